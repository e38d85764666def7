//! A running model: values, state, and the way through the stages of a simulation.

use super::continuous::Continuous;
use super::description::Description;
use super::error::Error;
use super::kinds::behaviour;
use super::parameter::with_values;
use super::stage::{Setup, Stage};
use super::template::{Shared, Template};
use super::{Asked, Behaviour};
use crate::model::Model;
use crate::time::Ramp;
use crate::vocabulary as v;
use std::sync::Arc;
use uuid::Uuid;

/// Relative tolerance of the integration inside, where the simulation sets none.
const DEFAULT_TOLERANCE: f64 = 1e-6;

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
    pub(super) shared: Arc<Shared>,
    pub(super) behaviour: Box<dyn Behaviour>,
    /// Parameter values the behaviour was built from.
    built: Box<[f64]>,
    pub(super) stage: Stage,
    pub(super) values: Box<[f64]>,
    pub(super) state: Box<[f64]>,
    /// For the next step.
    pub(super) asked: Asked,
    /// Room for derivatives of all outputs, and for a direction of all inputs; none before it is needed.
    pub(super) rates: Vec<f64>,
    pub(super) direction: Vec<Ramp>,
    /// Outputs are older than inputs or parameters (before the first step, and where the importer integrates).
    pub(super) stale: bool,
    /// Of an instance that its importer integrates.
    pub(super) continuous: Option<Continuous>,
    pub(super) time: Option<f64>,
    pub(super) stop: f64,
}

impl Instance {
    /// An instance of the model in `model_toml`, the text of a model file. Several cost least by a [`Template`].
    ///
    /// # Errors
    /// A text that is no model, with the line, or parameters that make none.
    pub fn new(model_toml: &str) -> Result<Self, Error> {
        Template::parse(model_toml)?.instance()
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
        Template::new(model.clone())?.instance()
    }

    /// At the beginning of a simulation.
    pub(super) fn begin(shared: Arc<Shared>, behaviour: Box<dyn Behaviour>) -> Self {
        let values: Box<[f64]> = shared.starts().collect();
        let state = vec![0.0; behaviour.state_len()].into();
        Self {
            built: values[shared.parameters()].into(),
            stage: Stage::Instantiated,
            stale: true,
            continuous: None,
            time: None,
            stop: f64::INFINITY,
            asked: Asked { slopes: Vec::new(), tolerance: DEFAULT_TOLERANCE },
            rates: Vec::new(),
            direction: Vec::new(),
            behaviour,
            values,
            state,
            shared,
        }
    }

    /// The variable table.
    pub fn description(&self) -> &Description {
        &self.shared.description
    }

    /// Identity of the model ([`Description::guid`]).
    pub fn guid(&self) -> Uuid {
        self.shared.guid
    }

    /// Where the instance is in the simulation.
    pub fn stage(&self) -> Stage {
        self.stage
    }

    /// End of the last successful step (s); the start time before the first.
    pub fn time(&self) -> f64 {
        self.time.unwrap_or(0.0)
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
        self.asked.tolerance = setup.tolerance.unwrap_or(DEFAULT_TOLERANCE);
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
        if self.is_continuous() {
            return self.begin_event();
        }
        self.stage = Stage::StepComplete;
        Ok(())
    }

    /// One communication step from `time` to `time + step` (s). Derivatives set for the inputs
    /// ([`Instance::set_input_derivatives`]) hold for this step alone: the inputs are then at the values they have
    /// reached at its end.
    ///
    /// # Errors
    /// `step` not positive, times not finite, `time` not the end of the last step, an end beyond the
    /// stop time, an input that its derivative takes beyond its bounds: the instance is unchanged. [`Error::Step`] if the
    /// integration fails: values and state are those at `time` and the stage is [`Stage::StepFailed`].
    #[inline(always)]
    pub fn do_step(&mut self, time: f64, step: f64) -> Result<(), Error> {
        self.check_step(time, step)?;
        let sloped = !self.asked.slopes.is_empty();
        if sloped {
            self.check_reached(step)?;
        }
        if let Err(reason) = self.behaviour.step(&mut self.state, &mut self.values, &self.asked, step) {
            self.stage = Stage::StepFailed;
            return Err(Error::Step { time, reason: reason.into() });
        }
        if sloped {
            self.asked.slopes.clear();
        }
        self.time = Some(time + step);
        Ok(())
    }

    /// What is not as it should be at the end of the last step, although the simulation can go on: a contact beyond the
    /// table of its measured law ([`Measured`](crate::contact::Measured)), where all of it slips.
    ///
    /// ```
    /// use stickslip::fmi::{Instance, Setup};
    /// let kept: String = (1..12).map(|k| format!("slope_kept_{k} = 0.8\n")).collect();
    /// let mut contact = Instance::new(&format!(
    ///     "schema = \"stickslip.model/1\"\nkind = \"contact\"\n[contact]\nlaw = \"measured\"\n\
    ///      tangential_stiffness = 2e6\nfriction_coefficient = 0.5\nnormal_load = 100.0\n{kept}"
    /// ))?;
    /// contact.set_up(Setup::default())?;
    /// contact.enter_initialization()?;
    /// contact.exit_initialization()?;
    /// assert_eq!(contact.warning(), None);
    /// let displacement = contact.description().reference("displacement").unwrap();
    /// contact.set_real(&[displacement], &[1.0])?;
    /// contact.do_step(0.0, 1e-3)?;
    /// assert!(contact.warning().unwrap().contains("beyond the table"));
    /// # Ok::<(), stickslip::fmi::Error>(())
    /// ```
    #[inline]
    pub fn warning(&self) -> Option<String> {
        if self.shared.may_warn { self.beyond_table() } else { None }
    }

    fn beyond_table(&self) -> Option<String> {
        let contact = self.shared.model.contact?;
        let slips = self.shared.description.reference(v::SLIP_FRACTION.name)?;
        let load = self.shared.description.reference(v::NORMAL_LOAD.name);
        let pressed = load.is_none_or(|row| self.values[row as usize] > 0.0);
        (pressed && self.values[slips as usize] >= 1.0).then(|| {
            format!(
                "at {} s the contact has moved beyond the table of its law `{}`, where nothing was measured: its force stays \
                 that of the table's end",
                self.time(),
                contact.law.kind.name
            )
        })
    }

    /// Ends the simulation; values can still be read.
    ///
    /// # Errors
    /// Only after the initialization.
    pub fn terminate(&mut self) -> Result<(), Error> {
        if matches!(self.stage, Stage::Instantiated | Stage::Initialization | Stage::Terminated) {
            return Err(Error::Stage(self.stage));
        }
        if matches!(self.stage, Stage::Event | Stage::ContinuousTime) {
            // What can still be read belongs to the last inputs and states.
            self.refresh()?;
        }
        self.stage = Stage::Terminated;
        Ok(())
    }

    /// Ends the simulation where it stands, since a call failed: FMI 3.0 does not go on from there. Values can still be
    /// read, and the instance reset or put into a saved state.
    ///
    /// ```
    /// # use stickslip::fmi::{Instance, Stage};
    /// # let model = "schema = \"stickslip.model/1\"\nkind = \"contact\"\n[contact]\nlaw = \"jenkins\"\n\
    /// #     tangential_stiffness = 2e6\nfriction_coefficient = 0.5\nnormal_load = 100.0\n";
    /// let mut contact = Instance::new(model)?;
    /// contact.fail();
    /// assert_eq!(contact.stage(), Stage::Terminated);
    /// # Ok::<(), stickslip::fmi::Error>(())
    /// ```
    pub fn fail(&mut self) {
        if matches!(self.stage, Stage::Event | Stage::ContinuousTime) {
            // A look that fails leaves what was seen before.
            let _ = self.refresh();
            self.stale = false;
        }
        self.stage = Stage::Terminated;
    }

    /// Back to where the instance was made: all values at their start.
    pub fn reset(&mut self) {
        self.values.iter_mut().zip(self.shared.starts()).for_each(|(value, start)| *value = start);
        self.state.fill(0.0);
        self.asked.slopes.clear();
        self.stage = Stage::Instantiated;
        self.stale = true;
        self.time = None;
        self.stop = f64::INFINITY;
        self.asked.tolerance = DEFAULT_TOLERANCE;
    }

    /// Whether [`Instance::do_step`] would begin a step from `time` of `step` (s).
    ///
    /// # Errors
    /// As [`Instance::do_step`], but for what comes of the inputs and of the integration.
    #[inline(always)]
    pub fn check_step(&self, time: f64, step: f64) -> Result<(), Error> {
        self.require(Stage::StepComplete)?;
        self.check_times(time, step)
    }

    #[inline]
    pub(super) fn require(&self, stage: Stage) -> Result<(), Error> {
        if self.stage == stage { Ok(()) } else { Err(Error::Stage(self.stage)) }
    }

    #[inline(always)]
    fn check_times(&self, time: f64, step: f64) -> Result<(), Error> {
        let slack = 1e-3 * step + 1e-9 * time.abs();
        let expected = self.time.unwrap_or(time);
        // A slack that is finite tells that both are.
        let fits = step > 0.0
            && slack <= f64::MAX
            && (time - expected).abs() <= slack
            && time + step <= f64::MAX
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
        } else if !(time + step).is_finite() {
            argument("communicationStepSize", step, "so small that the step ends at a finite time".to_owned())
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
        if matches!(self.stage, Stage::Event | Stage::ContinuousTime) {
            self.look()?;
            self.stale = false;
            return Ok(());
        }
        let parameters = self.values[self.shared.parameters()].to_vec();
        self.build(&parameters)?;
        self.behaviour.start(&mut self.state, &mut self.values).map_err(Error::Parameters)?;
        self.stale = false;
        if self.is_continuous() { self.begin_continuous() } else { Ok(()) }
    }

    /// Builds the behaviour from `parameters`, unless it was built from the same.
    pub(super) fn build(&mut self, parameters: &[f64]) -> Result<(), Error> {
        let same = self.built.iter().zip(parameters).all(|(old, new)| old.to_bits() == new.to_bits());
        if same {
            return Ok(());
        }
        let Shared { model, description, paths, .. } = &*self.shared;
        let rows = &description.variables[self.shared.parameters()];
        let model = with_values(model, paths, rows, parameters).map_err(Error::Parameters)?;
        let behaviour = behaviour(&model).map_err(Error::Parameters)?;
        if behaviour.modes() != description.continuous.modes || behaviour.state_len() != self.state.len() {
            return Err(Error::Parameters("these parameters change the size of the model".to_owned()));
        }
        self.behaviour = behaviour;
        self.built.copy_from_slice(parameters);
        Ok(())
    }
}
