//! A running model: values, state, and the stages of a simulation.

use super::description::{Causality, Description, Variable, VariableType};
use super::error::Error;
use super::parameter::{parameters, with_values};
use super::snapshot::{Snapshot, SnapshotError};
use super::{Behaviour, behaviour, describe};
use crate::model::Model;
use crate::time::Ramp;
use uuid::Uuid;

/// Relative tolerance of the integration inside, where the simulation sets none.
const DEFAULT_TOLERANCE: f64 = 1e-6;
/// No physical input in SI units is larger; products of a few stay finite.
pub(super) const LARGEST_INPUT: f64 = 1e30;
/// Numbers in a snapshot besides values and state: time, tolerance, stop, and whether time is known.
const CLOCK: usize = 4;

/// Where an instance is in a simulation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u32)]
pub enum Stage {
    /// New or reset: parameters and inputs may be set.
    Instantiated = 0,
    /// Between [`Instance::enter_initialization`] and [`Instance::exit_initialization`].
    Initialization = 1,
    /// Ready for the next step.
    StepComplete = 2,
    /// The last step failed; the state is that before it.
    StepFailed = 3,
    /// The simulation is over.
    Terminated = 4,
}

impl Stage {
    /// Every stage.
    pub const ALL: [Self; 5] =
        [Self::Instantiated, Self::Initialization, Self::StepComplete, Self::StepFailed, Self::Terminated];

    pub(super) fn from_number(number: u32) -> Option<Self> {
        Self::ALL.into_iter().find(|stage| *stage as u32 == number)
    }
}

/// The frame of a simulation.
///
/// ```
/// use stickslip::fmi::Setup;
/// let setup = Setup { stop: Some(0.2), ..Setup::default() };
/// assert_eq!((setup.start, setup.tolerance), (0.0, None));
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Setup {
    /// Relative tolerance of the integration inside; 1e-6 where absent.
    pub tolerance: Option<f64>,
    /// Start (s).
    pub start: f64,
    /// Stop (s); no step may go beyond.
    pub stop: Option<f64>,
}

/// A model that is being simulated.
///
/// ```
/// use stickslip::fmi::{Instance, Setup};
/// let mut contact = Instance::new(
///     r#"
///     schema = "stickslip.model/1"
///     kind = "contact"
///     [contact]
///     law = "jenkins"
///     tangential_stiffness = 2e6
///     friction_coefficient = 0.5
///     normal_load = 100.0
///     "#,
/// )?;
/// let displacement = contact.description().reference("displacement").unwrap();
/// let force = contact.description().reference("force").unwrap();
/// contact.set_up(Setup::default())?;
/// contact.enter_initialization()?;
/// contact.exit_initialization()?;
/// contact.set_real(&[displacement], &[40e-6])?;
/// contact.do_step(0.0, 1e-3)?;
/// let mut value = [0.0];
/// contact.get_real(&[force], &mut value)?;
/// assert_eq!(value, [50.0]);
/// # Ok::<(), stickslip::fmi::Error>(())
/// ```
#[derive(Debug)]
pub struct Instance {
    model: Model,
    pub(super) description: Description,
    guid: Uuid,
    paths: Vec<String>,
    pub(super) behaviour: Box<dyn Behaviour>,
    /// Parameter values the behaviour was built from.
    built: Vec<f64>,
    pub(super) stage: Stage,
    pub(super) values: Vec<f64>,
    pub(super) state: Vec<f64>,
    /// Derivatives of the inputs with respect to time for the next step, where the master has set one.
    pub(super) slopes: Vec<Option<f64>>,
    /// Some slope is set.
    pub(super) sloped: bool,
    /// Room for derivatives of all outputs, and for a direction of all inputs.
    pub(super) rates: Vec<f64>,
    pub(super) direction: Vec<Ramp>,
    /// Outputs are older than inputs or parameters (only before the first step).
    stale: bool,
    time: Option<f64>,
    pub(super) tolerance: f64,
    stop: f64,
}

impl Instance {
    /// An instance of the model in `model_toml`, the text of a model file.
    ///
    /// # Errors
    /// A text that is no model, with the line, or parameters that make none.
    pub fn new(model_toml: &str) -> Result<Self, Error> {
        let model = Model::parse(model_toml).map_err(|error| {
            let line = error.span.as_ref().and_then(|span| model_toml.get(..span.start));
            let line = line.map(|before| format!("line {}: ", before.matches('\n').count() + 1));
            Error::Model(format!("{}{}", line.unwrap_or_default(), error.message))
        })?;
        Self::from_model(&model)
    }

    /// An instance of `model`.
    ///
    /// # Errors
    /// Parameters that make no model.
    ///
    /// ```
    /// use stickslip::fmi::Instance;
    /// use stickslip::model::Model;
    /// # let text = "schema = \"stickslip.model/1\"\nkind = \"contact\"\n[contact]\nlaw = \"jenkins\"\n\
    /// #     tangential_stiffness = 2e3\nfriction_coefficient = 0.1\nnormal_load = 10.0";
    /// let contact = Instance::from_model(&Model::parse(text)?)?;
    /// assert!(contact.description().reference("force").is_some());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn from_model(model: &Model) -> Result<Self, Error> {
        model.check().map_err(|error| Error::Model(error.to_string()))?;
        let (paths, rows) = parameters(model);
        let description = describe(model, rows).map_err(Error::Model)?;
        let behaviour = behaviour(model).map_err(Error::Parameters)?;
        let values: Vec<f64> = description.variables.iter().map(|variable| variable.start).collect();
        let state = vec![0.0; behaviour.state_len()];
        let guid = description.guid();
        let count = |causality| description.references(causality).count();
        let (inputs, outputs) = (count(Causality::Input), count(Causality::Output));
        Ok(Self {
            model: model.clone(),
            guid,
            built: values[values.len() - paths.len()..].to_vec(),
            paths,
            stage: Stage::Instantiated,
            stale: true,
            time: None,
            tolerance: DEFAULT_TOLERANCE,
            stop: f64::INFINITY,
            slopes: vec![None; inputs],
            sloped: false,
            rates: vec![0.0; outputs],
            direction: vec![Ramp::held(0.0); inputs],
            description,
            behaviour,
            values,
            state,
        })
    }

    /// The variable table.
    pub fn description(&self) -> &Description {
        &self.description
    }

    /// Identity of the model ([`Description::guid`]).
    pub fn guid(&self) -> Uuid {
        self.guid
    }

    /// Where the instance is in the simulation.
    pub fn stage(&self) -> Stage {
        self.stage
    }

    /// End of the last successful step (s); the start time before the first.
    pub fn time(&self) -> f64 {
        self.time.unwrap_or(0.0)
    }

    /// Reads Real variables into `values`.
    ///
    /// # Errors
    /// An unknown or Integer variable; before the first step also parameters that make no model.
    pub fn get_real(&mut self, references: &[u32], values: &mut [f64]) -> Result<(), Error> {
        same_length(references.len(), values.len())?;
        self.check_rows(references, VariableType::Real)?;
        self.refresh()?;
        for (reference, value) in references.iter().zip(values) {
            *value = self.values[*reference as usize];
        }
        Ok(())
    }

    /// Reads Integer variables into `values`.
    ///
    /// # Errors
    /// As [`Instance::get_real`].
    pub fn get_integer(&mut self, references: &[u32], values: &mut [i32]) -> Result<(), Error> {
        same_length(references.len(), values.len())?;
        self.check_rows(references, VariableType::Integer)?;
        self.refresh()?;
        for (reference, value) in references.iter().zip(values) {
            *value = self.values[*reference as usize] as i32;
        }
        Ok(())
    }

    /// Sets Real inputs and, until the initialization ends, parameters. Sets all or none.
    ///
    /// # Errors
    /// An unknown, Integer or not settable variable, or a value outside its bounds.
    pub fn set_real(&mut self, references: &[u32], values: &[f64]) -> Result<(), Error> {
        same_length(references.len(), values.len())?;
        self.check_rows(references, VariableType::Real)?;
        for (reference, value) in references.iter().zip(values) {
            self.check_setting(&self.description.variables[*reference as usize], *value)?;
        }
        for (reference, value) in references.iter().zip(values) {
            self.values[*reference as usize] = *value;
        }
        self.stale |= self.stage != Stage::StepComplete;
        Ok(())
    }

    /// Sets Integer variables; no model has one that may be set.
    ///
    /// # Errors
    /// Always, unless `references` is empty.
    pub fn set_integer(&mut self, references: &[u32], values: &[i32]) -> Result<(), Error> {
        same_length(references.len(), values.len())?;
        self.check_rows(references, VariableType::Integer)?;
        match references.iter().zip(values).next() {
            Some((reference, value)) => {
                self.check_setting(&self.description.variables[*reference as usize], f64::from(*value))
            }
            None => Ok(()),
        }
    }

    /// Sets the frame of the simulation.
    ///
    /// # Errors
    /// A tolerance that is not positive, times that are not finite, a stop before the start.
    pub fn set_up(&mut self, setup: Setup) -> Result<(), Error> {
        self.require(Stage::Instantiated)?;
        let argument = |argument, value, allowed: &str| {
            Err(Error::Argument { argument, value, allowed: allowed.to_owned() })
        };
        if !setup.start.is_finite() {
            return argument("startTime", setup.start, "a finite number");
        }
        if let Some(stop) = setup.stop
            && !(stop.is_finite() && stop >= setup.start)
        {
            return argument("stopTime", stop, "a finite number, not before startTime");
        }
        if let Some(tolerance) = setup.tolerance
            && !(tolerance.is_finite() && tolerance > 0.0)
        {
            return argument("tolerance", tolerance, "a finite number, above 0");
        }
        self.time = Some(setup.start);
        self.stop = setup.stop.unwrap_or(f64::INFINITY);
        self.tolerance = setup.tolerance.unwrap_or(DEFAULT_TOLERANCE);
        Ok(())
    }

    /// Begins the initialization.
    ///
    /// # Errors
    /// Only after instantiation or reset.
    pub fn enter_initialization(&mut self) -> Result<(), Error> {
        self.require(Stage::Instantiated)?;
        self.stage = Stage::Initialization;
        self.stale = true;
        Ok(())
    }

    /// Ends the initialization: builds the model from its parameters and starts it.
    ///
    /// # Errors
    /// Parameters that make no model; the initialization then goes on.
    pub fn exit_initialization(&mut self) -> Result<(), Error> {
        self.require(Stage::Initialization)?;
        self.refresh()?;
        self.stage = Stage::StepComplete;
        Ok(())
    }

    /// One communication step from `time` to `time + step` (s). Derivatives set for the inputs
    /// ([`Instance::set_input_derivatives`]) hold for this step alone: the inputs are then at the values they have
    /// reached at its end.
    ///
    /// # Errors
    /// `step` not positive, times not finite, `time` not the end of the last step, an end beyond the
    /// stop time, an input that its derivative takes beyond its bounds: the instance is unchanged. [`Error::Step`] if the integration fails: values and state
    /// are those at `time` and the stage is [`Stage::StepFailed`].
    pub fn do_step(&mut self, time: f64, step: f64) -> Result<(), Error> {
        self.require(Stage::StepComplete)?;
        self.check_times(time, step)?;
        if self.sloped {
            self.check_reached(step)?;
        }
        let slopes = if self.sloped { &self.slopes[..] } else { &[] };
        let outcome = self.behaviour.step(&mut self.state, &mut self.values, slopes, step, self.tolerance);
        if let Err(reason) = outcome {
            self.stage = Stage::StepFailed;
            return Err(Error::Step { time, reason });
        }
        if self.sloped {
            self.forget_slopes();
        }
        self.time = Some(time + step);
        Ok(())
    }

    /// Ends the simulation; values can still be read.
    ///
    /// # Errors
    /// Only after the initialization.
    pub fn terminate(&mut self) -> Result<(), Error> {
        if !matches!(self.stage, Stage::StepComplete | Stage::StepFailed) {
            return Err(Error::Stage(self.stage));
        }
        self.stage = Stage::Terminated;
        Ok(())
    }

    /// Back to where the instance was made: all values at their start.
    pub fn reset(&mut self) {
        for (value, variable) in self.values.iter_mut().zip(&self.description.variables) {
            *value = variable.start;
        }
        self.state.fill(0.0);
        self.forget_slopes();
        self.stage = Stage::Instantiated;
        self.stale = true;
        self.time = None;
        self.stop = f64::INFINITY;
        self.tolerance = DEFAULT_TOLERANCE;
    }

    /// Saves everything that [`Instance::restore`] needs.
    pub fn snapshot(&self) -> Snapshot {
        let mut snapshot = Snapshot { guid: self.guid, stage: self.stage, numbers: Vec::new() };
        self.save(&mut snapshot);
        snapshot
    }

    /// Saves into an existing snapshot, without allocating if it is of the same model.
    pub fn save(&self, snapshot: &mut Snapshot) {
        snapshot.guid = self.guid;
        snapshot.stage = self.stage;
        let numbers = &mut snapshot.numbers;
        numbers.clear();
        numbers.reserve_exact(self.numbers());
        numbers.extend_from_slice(&self.values);
        numbers.extend_from_slice(&self.state);
        let slopes = self.slopes.iter();
        numbers.extend(slopes.flat_map(|slope| [f64::from(u8::from(slope.is_some())), slope.unwrap_or(0.0)]));
        let known = f64::from(u8::from(self.time.is_some()));
        numbers.extend_from_slice(&[self.time.unwrap_or(0.0), known, self.tolerance, self.stop]);
    }

    /// Numbers in a snapshot.
    fn numbers(&self) -> usize {
        self.values.len() + self.state.len() + 2 * self.slopes.len() + CLOCK
    }

    /// Makes the instance continue where `snapshot` was saved, bit by bit.
    ///
    /// # Errors
    /// A snapshot of another model, or with numbers that no instance has; the instance is as before.
    pub fn restore(&mut self, snapshot: &Snapshot) -> Result<(), Error> {
        if snapshot.guid != self.guid {
            return Err(SnapshotError::OtherModel { found: snapshot.guid, expected: self.guid }.into());
        }
        let (values_len, state_len) = (self.values.len(), self.state.len());
        let expected = self.numbers();
        if snapshot.numbers.len() != expected {
            return Err(SnapshotError::Corrupt.into());
        }
        let (values, rest) = snapshot.numbers.split_at(values_len);
        let (state, rest) = rest.split_at(state_len);
        let (slopes, clock) = rest.split_at(2 * self.slopes.len());
        // Bytes may come from anywhere. Only the stop time may be infinite.
        let [_, _, tolerance, stop] = *clock else { return Err(SnapshotError::Corrupt.into()) };
        let finite = snapshot.numbers[..expected - 1].iter().all(|number| number.is_finite());
        if !finite || tolerance <= 0.0 || stop.is_nan() {
            return Err(SnapshotError::Corrupt.into());
        }
        // In the first two stages the parameters are still open and need not make a model.
        let stale = matches!(snapshot.stage, Stage::Instantiated | Stage::Initialization);
        if !stale {
            self.build(&values[values_len - self.paths.len()..])?;
        }
        self.values.copy_from_slice(values);
        self.state.copy_from_slice(state);
        for (slope, saved) in self.slopes.iter_mut().zip(slopes.chunks_exact(2)) {
            *slope = (saved[0] != 0.0).then_some(saved[1]);
        }
        self.sloped = self.slopes.iter().any(Option::is_some);
        self.stage = snapshot.stage;
        self.stale = stale;
        self.time = (clock[1] != 0.0).then_some(clock[0]);
        self.tolerance = tolerance;
        self.stop = stop;
        Ok(())
    }

    fn require(&self, stage: Stage) -> Result<(), Error> {
        if self.stage == stage { Ok(()) } else { Err(Error::Stage(self.stage)) }
    }

    pub(super) fn check_rows(&self, references: &[u32], asked: VariableType) -> Result<(), Error> {
        for reference in references {
            match self.description.variables.get(*reference as usize) {
                Some(variable) if variable.variable_type == asked => {}
                Some(variable) => {
                    return Err(Error::WrongType {
                        name: variable.name.to_string(),
                        is: type_name(variable.variable_type),
                        asked: type_name(asked),
                    });
                }
                None => return Err(self.unknown_reference(*reference)),
            }
        }
        Ok(())
    }

    /// The error for a value reference asked as a type that no variable of any model has.
    pub fn no_variable_of_type(&self, reference: u32, asked: &'static str) -> Error {
        match self.description.variables.get(reference as usize) {
            Some(variable) => Error::WrongType {
                name: variable.name.to_string(),
                is: type_name(variable.variable_type),
                asked,
            },
            None => self.unknown_reference(reference),
        }
    }

    fn unknown_reference(&self, reference: u32) -> Error {
        Error::UnknownReference { reference, largest: self.description.variables.len() - 1 }
    }

    pub(super) fn check_setting(&self, variable: &Variable, value: f64) -> Result<(), Error> {
        self.check_settable(variable)?;
        check_value(variable, value)
    }

    pub(super) fn check_settable(&self, variable: &Variable) -> Result<(), Error> {
        let open = matches!(self.stage, Stage::Instantiated | Stage::Initialization);
        let reason = match variable.causality {
            Causality::Input if open || self.stage == Stage::StepComplete => None,
            Causality::Input => Some("the simulation cannot go on from here"),
            Causality::Parameter if open => None,
            Causality::Parameter => Some("a fixed parameter is settled when the initialization ends"),
            Causality::Output => Some("it is an output"),
        };
        match reason {
            Some(reason) => Err(Error::NotSettable { name: variable.name.to_string(), reason }),
            None => Ok(()),
        }
    }

    #[inline]
    fn check_times(&self, time: f64, step: f64) -> Result<(), Error> {
        let slack = 1e-3 * step + 1e-9 * time.abs();
        let expected = self.time.unwrap_or(time);
        let fits = step > 0.0
            && step.is_finite()
            && time.is_finite()
            && (time - expected).abs() <= slack
            && time + step <= self.stop + slack;
        if fits { Ok(()) } else { Err(self.wrong_times(time, step)) }
    }

    #[cold]
    fn wrong_times(&self, time: f64, step: f64) -> Error {
        let argument = |argument, value, allowed| Error::Argument { argument, value, allowed };
        if !(step > 0.0 && step.is_finite()) {
            argument("communicationStepSize", step, "a finite number, above 0".to_owned())
        } else if !time.is_finite() {
            argument("currentCommunicationPoint", time, "a finite number".to_owned())
        } else if time + step > self.stop + 1e-3 * step + 1e-9 * time.abs() {
            let allowed = format!("so small that the step ends by the stop time, {:?}", self.stop);
            argument("communicationStepSize", step, allowed)
        } else {
            let allowed = format!("the end of the last step, {:?}", self.time());
            argument("currentCommunicationPoint", time, allowed)
        }
    }

    /// Before the first step: outputs from inputs and parameters.
    pub(super) fn refresh(&mut self) -> Result<(), Error> {
        if !self.stale {
            return Ok(());
        }
        let first_parameter = self.values.len() - self.paths.len();
        let parameters = self.values[first_parameter..].to_vec();
        self.build(&parameters)?;
        self.behaviour.start(&mut self.state, &mut self.values).map_err(Error::Parameters)?;
        self.stale = false;
        Ok(())
    }

    /// Builds the behaviour from `parameters`, unless it was built from the same.
    fn build(&mut self, parameters: &[f64]) -> Result<(), Error> {
        let same = self.built.iter().zip(parameters).all(|(old, new)| old.to_bits() == new.to_bits());
        if same {
            return Ok(());
        }
        let first_parameter = self.values.len() - self.paths.len();
        let rows = &self.description.variables[first_parameter..];
        let model = with_values(&self.model, &self.paths, rows, parameters).map_err(Error::Parameters)?;
        let behaviour = behaviour(&model).map_err(Error::Parameters)?;
        if behaviour.state_len() != self.state.len() {
            return Err(Error::Parameters("these parameters change the size of the model".to_owned()));
        }
        self.behaviour = behaviour;
        self.built.copy_from_slice(parameters);
        Ok(())
    }
}

/// Whether `variable` may be `value`.
pub(super) fn check_value(variable: &Variable, value: f64) -> Result<(), Error> {
    if variable.allows(value) && value.abs() <= LARGEST_INPUT {
        return Ok(());
    }
    let bounds = if value.abs() > LARGEST_INPUT && value.is_finite() {
        format!("at most {LARGEST_INPUT:e} in magnitude")
    } else {
        variable.bounds()
    };
    Err(Error::Value { name: variable.name.to_string(), value, bounds })
}

pub(super) fn same_length(references: usize, values: usize) -> Result<(), Error> {
    if references == values { Ok(()) } else { Err(Error::Lengths { references, values }) }
}

fn type_name(variable_type: VariableType) -> &'static str {
    match variable_type {
        VariableType::Real => "Real",
        VariableType::Integer => "Integer",
    }
}
