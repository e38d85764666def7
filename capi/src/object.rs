//! What a handle points to.

use crate::guard::{Failure, Status};
use std::ffi::CString;
use std::sync::{Arc, Mutex, MutexGuard};
use stickslip::fmi::{self, Causality, Instance, Setup, Snapshot, Template, VariableType};

/// Which variables of a model.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Given to every step.
    Input = 0,
    /// Computed by every step.
    Output = 1,
    /// Set before the start.
    Parameter = 2,
}

/// A model that is being simulated.
pub struct Object {
    pub(crate) names: Arc<Names>,
    running: Mutex<Running>,
}

/// A saved state of a model.
pub struct State(pub(crate) Snapshot);

/// The variables of a model, of each kind in the order of the table; shared by copies.
#[derive(Debug)]
pub struct Names([Vec<Row>; 3]);

/// A variable.
#[derive(Debug)]
pub struct Row {
    pub reference: u32,
    pub name: CString,
    pub unit: CString,
    whole: bool,
}

impl Names {
    fn new(template: &Template) -> Self {
        let description = template.description();
        let row = |reference: u32| {
            let variable = &description.variables[reference as usize];
            Row {
                reference,
                name: CString::new(&*variable.name).unwrap_or_default(),
                unit: CString::new(variable.quantity.unit).unwrap_or_default(),
                whole: variable.variable_type == VariableType::Integer,
            }
        };
        let kinds = [Causality::Input, Causality::Output, Causality::Parameter];
        Self(kinds.map(|kind| description.references(kind).map(row).collect()))
    }

    pub fn of(&self, kind: Kind) -> &[Row] {
        &self.0[kind as usize]
    }
}

/// References of inputs and of Real outputs, with the places of these among all, and room for their values.
struct Room {
    inputs: Vec<u32>,
    reals: Vec<u32>,
    places: Vec<usize>,
    values: Vec<f64>,
}

impl Room {
    fn new(names: &Names) -> Self {
        let real = || names.of(Kind::Output).iter().enumerate().filter(|(_, row)| !row.whole);
        let reals: Vec<u32> = real().map(|(_, row)| row.reference).collect();
        Self {
            inputs: names.of(Kind::Input).iter().map(|row| row.reference).collect(),
            places: real().map(|(place, _)| place).collect(),
            values: vec![0.0; reals.len()],
            reals,
        }
    }
}

/// What changes from call to call.
pub struct Running {
    template: Template,
    names: Arc<Names>,
    instance: Instance,
    room: Room,
    /// Of every parameter, for the next start.
    parameters: Vec<f64>,
    /// As it was before the step under way.
    before: Snapshot,
}

impl Object {
    pub(crate) fn new(model_toml: &str) -> Result<Self, Failure> {
        let template = Template::parse(model_toml)?;
        let instance = template.instance()?;
        let names = Arc::new(Names::new(&template));
        let variables = &template.description().variables;
        let rows = names.of(Kind::Parameter).iter();
        let parameters = rows.map(|row| variables[row.reference as usize].start).collect();
        let before = instance.snapshot();
        let room = Room::new(&names);
        let running = Running { template, names: Arc::clone(&names), instance, room, parameters, before };
        Ok(Self { names, running: Mutex::new(running) })
    }

    /// The model, for this thread alone.
    pub(crate) fn lock(&self) -> Result<MutexGuard<'_, Running>, Failure> {
        let broken = "an internal error has left this model in an unknown state; free it";
        self.running.lock().map_err(|_| Failure(Status::Broken, broken.to_owned()))
    }

    pub(crate) fn copy(&self) -> Result<Self, Failure> {
        let running = self.lock()?;
        let mut instance = running.template.instance()?;
        let before = running.instance.snapshot();
        instance.restore(&before)?;
        let Running { template, names, parameters, .. } = &*running;
        let (template, names, parameters) = (template.clone(), Arc::clone(names), parameters.clone());
        let room = Room::new(&names);
        let running = Running { template, names: Arc::clone(&names), instance, room, parameters, before };
        Ok(Self { names, running: Mutex::new(running) })
    }
}

impl Running {
    pub fn parameter(&self, index: usize) -> f64 {
        self.parameters[index]
    }

    /// For the next start.
    pub fn set_parameter(&mut self, index: usize, value: f64) -> Result<(), Failure> {
        let row = &self.names.of(Kind::Parameter)[index];
        let variable = &self.instance.description().variables[row.reference as usize];
        if !variable.allows(value) {
            let (name, bounds) = (&variable.name, variable.bounds());
            return Err(Failure::refused(format!("{name} is {value}; it must be {bounds}")));
        }
        self.parameters[index] = value;
        Ok(())
    }

    /// Begins at time 0.
    pub fn start(&mut self, inputs: Option<&[f64]>, tolerance: f64) -> Result<(), Failure> {
        self.all_or_nothing(|running| {
            running.instance.reset();
            let tolerance = (tolerance != 0.0).then_some(tolerance);
            running.instance.set_up(Setup { tolerance, ..Setup::default() })?;
            for (row, value) in running.names.of(Kind::Parameter).iter().zip(&running.parameters) {
                running.instance.set_real(&[row.reference], &[*value])?;
            }
            running.instance.enter_initialization()?;
            running.set_inputs(inputs)?;
            running.instance.exit_initialization()
        })
    }

    /// One step of `step` (s).
    pub fn step(&mut self, inputs: Option<&[f64]>, step: f64) -> Result<(), Failure> {
        self.require_started()?;
        self.all_or_nothing(|running| {
            running.set_inputs(inputs)?;
            running.instance.do_step(running.instance.time(), step)
        })
    }

    fn set_inputs(&mut self, inputs: Option<&[f64]>) -> Result<(), fmi::Error> {
        inputs.map_or(Ok(()), |inputs| self.instance.set_real(&self.room.inputs, inputs))
    }

    /// Runs `body`; where it fails, all is as before.
    fn all_or_nothing(
        &mut self,
        body: impl FnOnce(&mut Self) -> Result<(), fmi::Error>,
    ) -> Result<(), Failure> {
        self.instance.save(&mut self.before);
        let Err(error) = body(self) else { return Ok(()) };
        self.instance.restore(&self.before)?;
        Err(error.into())
    }

    /// The outputs, in order.
    pub fn outputs(&mut self, outputs: &mut [f64]) -> Result<(), Failure> {
        let Room { reals, places, values, .. } = &mut self.room;
        self.instance.get_real(reals, values)?;
        places.iter().zip(values).for_each(|(place, value)| outputs[*place] = *value);
        for (row, value) in self.names.of(Kind::Output).iter().zip(outputs).filter(|(row, _)| row.whole) {
            let mut whole = [0];
            self.instance.get_integer(&[row.reference], &mut whole)?;
            *value = f64::from(whole[0]);
        }
        Ok(())
    }

    /// Derivatives of the outputs by the inputs of the last step, a row for each output. A whole number has none.
    pub fn tangent(&mut self, tangent: &mut [f64]) -> Result<(), Failure> {
        self.require_started()?;
        let Room { inputs, reals, places, values } = &mut self.room;
        tangent.fill(0.0);
        for (column, input) in inputs.iter().enumerate() {
            self.instance.directional_derivative(reals, &[*input], &[1.0], values)?;
            for (place, value) in places.iter().zip(&*values) {
                tangent[place * inputs.len() + column] = *value;
            }
        }
        Ok(())
    }

    pub fn time(&self) -> f64 {
        self.instance.time()
    }

    /// Into a state of the same or another model, whose memory is used again.
    pub fn save(&self, state: &mut Snapshot) {
        self.instance.save(state);
    }

    pub fn saved(&self) -> Snapshot {
        self.instance.snapshot()
    }

    pub fn restore(&mut self, state: &Snapshot) -> Result<(), Failure> {
        Ok(self.instance.restore(state)?)
    }

    /// Whether a state is of this model.
    pub fn check_model(&self, state: &Snapshot) -> Result<(), Failure> {
        let (found, expected) = (state.guid(), self.instance.guid());
        if found == expected {
            return Ok(());
        }
        Err(fmi::Error::from(fmi::SnapshotError::OtherModel { found, expected }).into())
    }

    fn require_started(&self) -> Result<(), Failure> {
        if self.instance.stage() == fmi::Stage::StepComplete {
            return Ok(());
        }
        Err(Failure::refused("the model has not been started: call stickslip_start first"))
    }
}
