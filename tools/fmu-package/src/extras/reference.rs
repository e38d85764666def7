//! Reference results: a run of the model by the library, without FMI, in the layout of the layered standard FMI-LS-REF.
//!
//! Every input follows a smooth signal. As most importers do, the inputs of a time are set before the step that begins there;
//! outputs in a row belong to the row's time.

use std::f64::consts::TAU;
use std::fmt::Write as _;

use stickslip::fmi::{Causality, Description, Error, Instance, Setup, VariableType};

use crate::xml::{Xml, number};

/// Where the layered standard has its files.
const FOLDER: &str = "extra/org.fmi-standard.fmi-ls-ref";
const STEPS: u32 = 200;

/// Inputs and outputs of a model over time.
pub struct Run {
    step: f64,
    tolerance: f64,
    /// Rows of the table that are inputs, and those that are outputs.
    inputs: Vec<u32>,
    outputs: Vec<u32>,
    /// Of each instant the time, the inputs and the outputs.
    rows: Vec<Vec<f64>>,
}

impl Run {
    /// Runs the model of the text over 200 steps of its default experiment.
    ///
    /// # Errors
    /// A text that is no model, or a step that fails.
    pub fn new(model_toml: &str) -> Result<Self, Error> {
        let mut instance = Instance::new(model_toml)?;
        let experiment = instance.description().experiment;
        let of = |causality| instance.description().references(causality).collect::<Vec<u32>>();
        let (inputs, outputs) = (of(Causality::Input), of(Causality::Output));
        let mut run = Self {
            step: experiment.step,
            tolerance: experiment.tolerance,
            inputs,
            outputs,
            rows: Vec::new(),
        };
        let stop = Some(f64::from(STEPS) * run.step);
        instance.set_up(Setup { tolerance: Some(run.tolerance), stop, ..Setup::default() })?;
        instance.enter_initialization()?;
        let first = run.signals(instance.description(), 0.0);
        instance.set_real(&run.inputs, &first)?;
        instance.exit_initialization()?;
        run.record(&mut instance, 0.0, first)?;
        for index in 0..STEPS {
            let [begin, end] = [index, index + 1].map(|index| f64::from(index) * run.step);
            let held = run.signals(instance.description(), begin);
            instance.set_real(&run.inputs, &held)?;
            instance.do_step(begin, end - begin)?;
            let next = run.signals(instance.description(), end);
            run.record(&mut instance, end, next)?;
        }
        Ok(run)
    }

    /// The inputs at a time.
    fn signals(&self, description: &Description, time: f64) -> Vec<f64> {
        let length = f64::from(STEPS) * self.step;
        let rate = TAU * 3.0 / length;
        // A motion that grows from one cycle to the next.
        let (sine, cosine) = (rate * time).sin_cos();
        let growth = (1.0 + 3.0 * time / length) / 4.0;
        let position = growth * sine;
        let velocity = 0.75 / length * sine + growth * rate * cosine;
        let of_row = |row: &u32| {
            let variable = &description.variables[*row as usize];
            let slower = (TAU * 1.7 * time / length).sin();
            match &*variable.name {
                "displacement" => 40e-6 * position,
                "velocity" => 40e-6 * velocity,
                "opening" => 40e-6 * position,
                "opening_velocity" => 40e-6 * velocity,
                "excitation" => 200.0 * position,
                "normal_load" => variable.start * (1.0 + 0.5 * slower),
                _ => variable.start + 0.2 * variable.quantity.nominal * slower,
            }
        };
        self.inputs.iter().map(of_row).collect()
    }

    fn record(&mut self, instance: &mut Instance, time: f64, inputs: Vec<f64>) -> Result<(), Error> {
        let mut row = vec![time];
        row.extend(inputs);
        for output in &self.outputs {
            let whole =
                instance.description().variables[*output as usize].variable_type == VariableType::Integer;
            let (mut real, mut integer) = ([0.0], [0]);
            if whole {
                instance.get_integer(&[*output], &mut integer)?;
            } else {
                instance.get_real(&[*output], &mut real)?;
            }
            row.push(if whole { f64::from(integer[0]) } else { real[0] });
        }
        self.rows.push(row);
        Ok(())
    }

    /// Values of a variable over the run; `None` for one that is neither input nor output.
    pub fn course(&self, description: &Description, name: &str) -> Option<Vec<f64>> {
        let row = description.reference(name)?;
        let column = 1 + self.inputs.iter().chain(&self.outputs).position(|known| *known == row)?;
        Some(self.rows.iter().map(|row| row[column]).collect())
    }

    /// The files of the layered standard.
    pub fn files(&self, description: &Description) -> Vec<(String, Vec<u8>)> {
        let (first, second) =
            (1..1 + self.inputs.len(), 1 + self.inputs.len()..1 + self.inputs.len() + self.outputs.len());
        let files = [
            (format!("{FOLDER}/fmi-ls-manifest.xml"), manifest()),
            (format!("{FOLDER}/experiments.exp"), self.experiments()),
            (format!("{FOLDER}/stimuli.csv"), self.csv(description, &self.inputs, first)),
            (format!("{FOLDER}/reference.csv"), self.csv(description, &self.outputs, second)),
            ("documentation/fmi-ls-ref.html".to_owned(), self.documentation()),
        ];
        files.into_iter().map(|(name, text)| (name, text.into_bytes())).collect()
    }

    fn csv(&self, description: &Description, variables: &[u32], columns: std::ops::Range<usize>) -> String {
        let mut text = String::from("\"time\"");
        for variable in variables {
            let _ = write!(text, ",\"{}\"", description.variables[*variable as usize].name);
        }
        for row in &self.rows {
            let _ = write!(text, "\n{}", number(row[0]));
            for value in &row[columns.clone()] {
                let _ = write!(text, ",{}", number(*value));
            }
        }
        text.push('\n');
        text
    }

    fn experiments(&self) -> String {
        let mut xml = Xml::new();
        let name = |name: &str, description: &str| {
            vec![("name", name.to_owned()), ("description", description.to_owned())]
        };
        let mut experiment =
            name("smoke-test", "Smooth inputs; the outputs as the library finds them without FMI");
        experiment.extend([
            ("startTime", "0".to_owned()),
            ("stopTime", number(f64::from(STEPS) * self.step)),
            ("tolerance", number(self.tolerance)),
            ("stepSize", number(self.step)),
        ]);
        xml.inside(
            ("Experiments", name("Reference results", "A run to compare an importer's with")),
            |xml| {
                xml.inside(("Experiment", experiment), |xml| {
                    xml.empty(("Stimuli", vec![("source", "stimuli.csv".to_owned())]));
                    xml.empty(("References", vec![("source", "reference.csv".to_owned())]));
                });
            },
        );
        xml.text()
    }

    fn documentation(&self) -> String {
        format!(
            "<!DOCTYPE html>\n<html lang=\"en\">\n<head><meta charset=\"utf-8\"><title>Reference results</title></head>\n\
             <body>\n<h1>Reference results</h1>\n<p><code>{FOLDER}</code> holds a run of this model by the library that the \
             FMU contains, without FMI: {STEPS} steps of {} s in co-simulation, relative tolerance {}. The inputs of a \
             row in <code>stimuli.csv</code> are set before the step that begins at the row's time (during the initialization for \
             the first) and stay for the step; a row of <code>reference.csv</code> has the outputs at its time. No \
             derivatives of inputs are set.</p>\n<p>An importer that does the same finds every Real output within 1e-9 of its largest \
             value. One that sets the inputs of a step's end, or interpolates, finds another run.</p>\n</body>\n</html>\n",
            number(self.step),
            number(self.tolerance),
        )
    }
}

fn manifest() -> String {
    let mut xml = Xml::new();
    let root = vec![
        ("xmlns:fmi-ls", "http://fmi-standard.org/fmi-ls-manifest".to_owned()),
        ("fmi-ls:fmi-ls-name", "org.fmi-standard.fmi-ls-ref".to_owned()),
        ("fmi-ls:fmi-ls-version", "1.0.0-alpha.1".to_owned()),
        (
            "fmi-ls:fmi-ls-description",
            "Layered Standard providing information on related files included in an FMU.".to_owned(),
        ),
    ];
    let related = [
        (
            "application/x-ma-hs-experiments",
            "experiments.exp",
            "experiment/smoke-test",
            "A run of the model by the library, without FMI",
        ),
        ("text/csv", "reference.csv", "result", "Outputs of that run"),
        ("application/toml", "../../resources/model.toml", "model", "The model"),
        ("text/html", "../../documentation/index.html", "document", "Variables and equations of the model"),
    ];
    xml.inside(("fmiReferences", root), |xml| {
        for (kind, source, role, description) in related {
            xml.empty((
                "Related",
                vec![
                    ("type", kind.to_owned()),
                    ("source", source.to_owned()),
                    ("role", role.to_owned()),
                    ("description", description.to_owned()),
                ],
            ));
        }
    });
    xml.text()
}
