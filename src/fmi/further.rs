//! What FMI 3.0 wants to be variables besides the rows of the table: time, event indicators, and arrays.
//!
//! Their value references follow those of the table, so that a row has the same one in every version of FMI.

use super::description::{Causality, Dependency, DependencyKind, Description};
use super::error::Error;
use super::instance::Instance;
use super::values::same_length;
use crate::vocabulary::{self as v, Quantity};

/// Names and meanings of a contact's event indicators, with the unit of those that have one.
const INDICATORS: [(&str, &str, &Quantity); 3] = [
    ("event_indicator:reversal", "Changes its sign where the contact turns round", &v::VELOCITY),
    ("event_indicator:slip", "1 in stick, -1 in slip", &v::SLIP_FRACTION),
    ("event_indicator:lift_off", "Changes its sign where the bodies part and meet", &v::SLIP_FRACTION),
];

/// A variable that is no row of the table.
#[derive(Debug, Clone, PartialEq)]
pub struct Further {
    /// Unique name.
    pub name: String,
    /// One line for an engineer.
    pub description: String,
    /// Unit and nominal value.
    pub quantity: &'static Quantity,
    /// What it shows.
    pub shows: Shows,
}

/// What a variable beyond the table shows.
#[derive(Debug, Clone, PartialEq)]
pub enum Shows {
    /// Time (s).
    Time,
    /// An event indicator, by its place among them.
    Indicator(usize),
    /// The outputs in these rows, as one array.
    Rows(Vec<u32>),
}

impl Further {
    /// Number of values.
    pub fn len(&self) -> usize {
        match &self.shows {
            Shows::Time | Shows::Indicator(_) => 1,
            Shows::Rows(rows) => rows.len(),
        }
    }

    /// No variable is empty.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The rows that it shows as an array; none of time and indicators.
    pub fn rows(&self) -> &[u32] {
        match &self.shows {
            Shows::Rows(rows) => rows,
            Shows::Time | Shows::Indicator(_) => &[],
        }
    }

    fn causality(&self) -> Causality {
        match &self.shows {
            Shows::Rows(_) => Causality::Output,
            Shows::Time | Shows::Indicator(_) => Causality::Local,
        }
    }
}

impl Description {
    /// The variables beyond the table, whose value references follow its last.
    ///
    /// Outputs of one quantity at several places are an array besides, in the order of the table.
    ///
    /// ```
    /// use stickslip::fmi::Instance;
    /// # let text = "schema = \"stickslip.model/1\"\nkind = \"contact\"\n[contact]\nlaw = \"jenkins\"\n\
    /// #     tangential_stiffness = 2e3\nfriction_coefficient = 0.1\nnormal_load = 10.0";
    /// let contact = Instance::new(text)?;
    /// let names: Vec<String> = contact.description().further().into_iter().map(|other| other.name).collect();
    /// assert_eq!(names[0], "time");
    /// assert_eq!(names.len(), 4);
    /// # Ok::<(), stickslip::fmi::Error>(())
    /// ```
    pub fn further(&self) -> Vec<Further> {
        let time = Further {
            name: "time".to_owned(),
            description: "Time".to_owned(),
            quantity: &v::TIME,
            shows: Shows::Time,
        };
        let indicators = INDICATORS.iter().take(self.continuous.indicators).enumerate();
        let indicators = indicators.map(|(index, (name, description, quantity))| Further {
            name: (*name).to_owned(),
            description: (*description).to_owned(),
            quantity,
            shows: Shows::Indicator(index),
        });
        let arrays = [
            (&v::DISPLACEMENT, "displacements"),
            (&v::VELOCITY, "velocities"),
            (&v::ACCELERATION, "accelerations"),
        ];
        let arrays = arrays.into_iter().filter_map(|(quantity, name)| {
            let outputs = self.references(Causality::Output).filter(|row| {
                let variable = &self.variables[*row as usize];
                variable.quantity.name == quantity.name && variable.name.contains(':')
            });
            let rows: Vec<u32> = outputs.collect();
            let names: Vec<&str> = rows.iter().map(|row| &*self.variables[*row as usize].name).collect();
            let description = format!("As one array: {}", names.join(", "));
            (!rows.is_empty()).then(|| Further {
                name: name.to_owned(),
                description,
                quantity,
                shows: Shows::Rows(rows),
            })
        });
        std::iter::once(time).chain(indicators).chain(arrays).collect()
    }

    /// What an array depends on: all that its rows do, by the lists that `of` gives of them.
    pub fn dependencies_of_rows(
        &self,
        rows: &[u32],
        of: impl Fn(&super::Variable) -> &Vec<Dependency>,
    ) -> Vec<Dependency> {
        let mut all: Vec<Dependency> = Vec::new();
        for dependency in rows.iter().flat_map(|row| of(&self.variables[*row as usize])) {
            match all.iter_mut().find(|known| known.on == dependency.on) {
                Some(known) if known.kind != dependency.kind => known.kind = DependencyKind::Dependent,
                Some(_) => {}
                None => all.push(*dependency),
            }
        }
        all.sort_by_key(|dependency| dependency.on);
        all
    }
}

impl Instance {
    /// The variable beyond the table with this reference.
    fn further(&self, reference: u32) -> Option<&Further> {
        self.shared.further.get((reference as usize).checked_sub(self.values.len())?)
    }

    /// Number of values of the variable with this reference: 1, or the length of an array.
    ///
    /// # Errors
    /// An unknown reference.
    pub fn size(&self, reference: u32) -> Result<usize, Error> {
        if (reference as usize) < self.values.len() {
            return Ok(1);
        }
        self.further(reference).map(Further::len).ok_or_else(|| self.unknown(reference))
    }

    fn unknown(&self, reference: u32) -> Error {
        Error::UnknownReference { reference, largest: self.values.len() + self.shared.further.len() - 1 }
    }

    /// Reads Real variables into `values`, those beyond the table too; an array fills as many as it has.
    ///
    /// # Errors
    /// As [`Instance::get_real`]; another number of `values`.
    pub fn get_all(&mut self, references: &[u32], values: &mut [f64]) -> Result<(), Error> {
        if references.iter().all(|reference| (*reference as usize) < self.values.len()) {
            return self.get_real(references, values);
        }
        let sizes = references.iter().map(|reference| self.size(*reference));
        let sizes = sizes.collect::<Result<Vec<usize>, Error>>()?;
        same_length(sizes.iter().sum(), values.len())?;
        let mut rest = values;
        for (reference, size) in references.iter().zip(sizes) {
            let (here, after) = rest.split_at_mut(size);
            rest = after;
            match self.further(*reference).map(|further| further.shows.clone()) {
                None => self.get_real(&[*reference], here)?,
                Some(Shows::Rows(rows)) => self.get_real(&rows, here)?,
                Some(Shows::Time) => here.fill(self.time()),
                Some(Shows::Indicator(index)) => here.fill(self.indicator(index)?),
            }
        }
        Ok(())
    }

    /// The rows of the table that these references stand for.
    ///
    /// # Errors
    /// An unknown reference; time and indicators, of which nothing is set, and no derivative known.
    pub fn rows_of(&self, references: &[u32]) -> Result<Vec<u32>, Error> {
        let mut rows = Vec::with_capacity(references.len());
        for reference in references {
            if (*reference as usize) < self.values.len() {
                rows.push(*reference);
                continue;
            }
            let further = self.further(*reference).ok_or_else(|| self.unknown(*reference))?;
            if further.rows().is_empty() {
                let reason = "it is neither an input nor an output";
                return Err(Error::NoDerivative { name: further.name.clone(), reason });
            }
            rows.extend(further.rows());
        }
        Ok(rows)
    }

    /// Refuses what is beyond the table where a variable is to be set or read as another type than Real.
    ///
    /// # Errors
    /// A reference of the kind: none of them can be set, and all are Real.
    pub fn refuse_further(&self, references: &[u32], asked: Option<&'static str>) -> Result<(), Error> {
        for reference in references {
            let Some(further) = self.further(*reference) else { continue };
            let name = further.name.clone();
            return Err(match (asked, further.causality()) {
                (Some(asked), _) => Error::WrongType { name, is: "Real", asked },
                (None, Causality::Output) => Error::NotSettable { name, reason: "it is an output" },
                (None, _) => Error::NotSettable { name, reason: "it is time, or made by the model" },
            });
        }
        Ok(())
    }

    /// The products of the Jacobian, transposed, with `seed`, one number for each row of `unknowns`: for each row of
    /// `knowns` what [`Instance::directional_derivative`] would give of all unknowns, weighed by the seed and added.
    ///
    /// # Errors
    /// As [`Instance::directional_derivative`].
    ///
    /// ```
    /// # use stickslip::fmi::Instance;
    /// # let model = "schema = \"stickslip.model/1\"\nkind = \"contact\"\n[contact]\nlaw = \"jenkins\"\n\
    /// #     tangential_stiffness = 2e6\nfriction_coefficient = 0.5\nnormal_load = 100.0\n";
    /// let mut contact = Instance::new(model)?;
    /// contact.enter_initialization()?;
    /// contact.exit_initialization()?;
    /// let row = |name| contact.description().reference(name).unwrap();
    /// let (displacement, load, force) = (row("displacement"), row("normal_load"), row("force"));
    /// contact.set_real(&[displacement], &[1e-6])?;
    /// contact.do_step(0.0, 1e-3)?;
    /// let mut change = [0.0; 2];
    /// contact.adjoint_derivative(&[force], &[displacement, load], &[3.0], &mut change)?;
    /// assert_eq!(change, [6e6, 0.0]);
    /// # Ok::<(), stickslip::fmi::Error>(())
    /// ```
    pub fn adjoint_derivative(
        &mut self,
        unknowns: &[u32],
        knowns: &[u32],
        seed: &[f64],
        change: &mut [f64],
    ) -> Result<(), Error> {
        same_length(unknowns.len(), seed.len())?;
        same_length(knowns.len(), change.len())?;
        if let Some((row, value)) = unknowns.iter().zip(seed).find(|(_, value)| !value.is_finite()) {
            let name = self.shared.description.variables.get(*row as usize).map(|row| row.name.to_string());
            let most = super::values::LARGEST_INPUT;
            return Err(Error::DerivativeValue { name: name.unwrap_or_default(), value: *value, most });
        }
        let mut column = vec![0.0; unknowns.len()];
        let mut found = vec![0.0; knowns.len()];
        for (known, found) in knowns.iter().zip(&mut found) {
            self.directional_derivative(unknowns, &[*known], &[1.0], &mut column)?;
            *found = column.iter().zip(seed).map(|(column, seed)| column * seed).sum();
        }
        change.copy_from_slice(&found);
        Ok(())
    }
}
