//! The continuous-time form of a model, for importers that integrate themselves (FMI's model exchange).
//!
//! A law's memory is discrete: it is what the contact remembers of the last accepted instant. Anything between is a
//! look from there ([`ContactLaw::step`](crate::contact::ContactLaw::step)), which is smooth while the contact moves one
//! way, and leaves the memory alone. Reversals, stick, slip and lift-off are events, where the memory goes on.

use super::description::{Causality, Description, Variable};
use super::error::Error;
use super::instance::Instance;
use super::stage::Stage;
use crate::contact::SlipState;
use crate::vocabulary as v;
use std::borrow::Cow;
use std::ops::Range;

/// Indicators of a contact: of the direction of its motion, of slip, and of its normal load.
pub(super) const OF_CONTACT: usize = 3;

/// The physics behind the continuous-time form; `state` is the behaviour's, and holds the last accepted instant.
pub(crate) trait ContinuousTime {
    /// Number of modes: each has a displacement and a velocity as continuous states. A contact alone has none.
    fn modes(&self) -> usize {
        0
    }

    /// Number of event indicators.
    fn indicators(&self) -> usize;

    /// Writes the displacements and velocities of all modes at the last accepted instant.
    fn read(&mut self, _state: &[f64], _continuous: &mut [f64]) -> Result<(), String> {
        Ok(())
    }

    /// Writes the outputs to `values` for the inputs in it and these continuous states. `accepted` are all values at the
    /// last accepted instant.
    fn look(
        &mut self,
        state: &[f64],
        accepted: &[f64],
        values: &mut [f64],
        at: Instant<'_>,
    ) -> Result<(), String>;

    /// Accepts the instant with these inputs and continuous states: the memory goes on.
    fn accept(&mut self, state: &mut [f64], values: &[f64], continuous: &[f64]) -> Result<(), String>;
}

/// Continuous states, and what is to be found there.
pub(crate) struct Instant<'a> {
    /// Displacements and velocities of all modes.
    pub continuous: &'a [f64],
    /// Accelerations of the modes.
    pub accelerations: &'a mut [f64],
    /// Event indicators.
    pub indicators: &'a mut [f64],
}

/// The indicators of a contact: velocity (m/s), slip, and how much is `pressed`, above zero as long as the bodies meet;
/// `slip_state` as in the table. That of slip is 1 or -1: where the importer brackets its change, the force is continuous.
pub(super) fn indicators(velocity: f64, slip_state: f64, pressed: f64, out: &mut [f64]) {
    let sticks = if slip_state == f64::from(SlipState::Stick as i32) { 1.0 } else { -1.0 };
    out.copy_from_slice(&[velocity, sticks, pressed]);
}

/// Slip state and slip fraction, from row `slip_state`, of a contact that has not `moved` since the accepted instant stay:
/// a slider at its limit would be said to stick.
pub(super) fn keep_slip(moved: bool, slip_state: usize, values: &mut [f64], accepted: &[f64]) {
    if !moved {
        values[slip_state..slip_state + 2].copy_from_slice(&accepted[slip_state..slip_state + 2]);
    }
}

/// Above zero the normal force (N), below zero the distance (m) of bodies that are apart.
pub(super) fn pressed(normal_force: f64, separation: f64) -> f64 {
    if separation > 0.0 { -separation } else { normal_force }
}

/// What a description has for importers that integrate.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct ContinuousForm {
    /// Modes, whose displacements, velocities and accelerations are the last rows of the table.
    pub modes: usize,
    /// Event indicators.
    pub indicators: usize,
}

impl Description {
    /// Adds the rows of `form`.
    pub(super) fn with_continuous_form(mut self, form: ContinuousForm) -> Self {
        self.continuous = form;
        let states: Vec<usize> = (0..2 * form.modes).map(|row| self.variables.len() + row).collect();
        for row in self.variables.iter_mut().filter(|row| row.causality == Causality::Output) {
            row.depend_on_states(&states);
        }
        let quantities = [&v::DISPLACEMENT, &v::VELOCITY, &v::ACCELERATION];
        for (quantity, noun) in quantities.into_iter().zip(["Displacement", "Velocity", "Acceleration"]) {
            self.variables.extend((1..=form.modes).map(|mode| Variable {
                name: Cow::Owned(format!("modal_{}:mode={mode}", quantity.name)),
                description: Cow::Owned(format!("{noun} of mode {mode}, scaled to a modal mass of 1 kg")),
                ..Variable::local(quantity)
            }));
        }
        self
    }

    /// Rows of the continuous states: displacements of all modes, then their velocities.
    pub fn states(&self) -> Range<u32> {
        let modes = self.continuous.modes as u32;
        let end = self.variables.len() as u32 - modes;
        end - 2 * modes..end
    }

    /// Rows of the derivatives of [`Description::states`], in their order: velocities and accelerations.
    pub fn state_derivatives(&self) -> Range<u32> {
        let states = self.states();
        let modes = (states.end - states.start) / 2;
        states.start + modes..states.end + modes
    }
}

/// What an instance for importers that integrate has besides.
#[derive(Debug, Clone)]
pub(super) struct Continuous {
    /// All values at the last accepted instant.
    pub accepted: Vec<f64>,
    indicators: Vec<f64>,
}

impl Continuous {
    pub fn new(description: &Description) -> Self {
        Self {
            accepted: vec![0.0; description.variables.len()],
            indicators: vec![0.0; description.continuous.indicators],
        }
    }
}

impl Instance {
    /// Whether it is integrated by its importer.
    pub fn is_continuous(&self) -> bool {
        self.continuous.is_some()
    }

    fn require_continuous(&self) -> Result<(), Error> {
        if self.is_continuous() { Ok(()) } else { Err(Error::Interface) }
    }

    /// Ends the initialization, or leaves continuous time.
    pub(super) fn begin_event(&mut self) -> Result<(), Error> {
        self.accept()?;
        self.stage = Stage::Event;
        Ok(())
    }

    /// Enters event mode.
    ///
    /// # Errors
    /// Only from continuous time.
    pub fn enter_event(&mut self) -> Result<(), Error> {
        self.require(Stage::ContinuousTime)?;
        self.begin_event()
    }

    /// Answers an event: what the contacts remember goes on to this instant. Nothing further is needed, and no state jumps.
    ///
    /// # Errors
    /// Only in event mode.
    pub fn new_discrete_states(&mut self) -> Result<(), Error> {
        self.require(Stage::Event)?;
        self.accept()
    }

    /// Enters continuous time.
    ///
    /// # Errors
    /// Only from event mode.
    pub fn enter_continuous_time(&mut self) -> Result<(), Error> {
        self.require(Stage::Event)?;
        self.accept()?;
        self.stage = Stage::ContinuousTime;
        Ok(())
    }

    /// Sets the time (s), on which nothing depends but messages.
    ///
    /// # Errors
    /// A time that is not finite, and other stages than event mode and continuous time.
    pub fn set_time(&mut self, time: f64) -> Result<(), Error> {
        if !matches!(self.stage, Stage::Event | Stage::ContinuousTime) {
            return Err(Error::Stage(self.stage));
        }
        if !time.is_finite() {
            return Err(Error::Argument {
                argument: "time",
                value: time,
                allowed: "a finite number".to_owned(),
            });
        }
        self.time = Some(time);
        Ok(())
    }

    /// Reads the continuous states, in the order of [`Description::states`].
    ///
    /// # Errors
    /// Another number of them, an instance for co-simulation.
    pub fn continuous_states(&mut self, out: &mut [f64]) -> Result<(), Error> {
        self.show(self.shared.description.states(), out)
    }

    /// Sets them.
    ///
    /// # Errors
    /// As [`Instance::continuous_states`]; values that are not finite.
    pub fn set_continuous_states(&mut self, values: &[f64]) -> Result<(), Error> {
        self.require_continuous()?;
        self.require(Stage::ContinuousTime)?;
        let rows = self.shared.description.states();
        super::values::same_length(rows.len(), values.len())?;
        for (row, value) in rows.clone().zip(values) {
            super::values::check_value(&self.shared.description.variables[row as usize], *value)?;
        }
        self.values[rows.start as usize..rows.end as usize].copy_from_slice(values);
        self.stale = true;
        Ok(())
    }

    /// Reads the derivatives of the continuous states with respect to time.
    ///
    /// # Errors
    /// As [`Instance::continuous_states`]; [`Error::Step`] where the contact's force cannot be found.
    pub fn state_derivatives(&mut self, out: &mut [f64]) -> Result<(), Error> {
        self.show(self.shared.description.state_derivatives(), out)
    }

    fn show(&mut self, rows: Range<u32>, out: &mut [f64]) -> Result<(), Error> {
        self.require_continuous()?;
        super::values::same_length(rows.len(), out.len())?;
        self.refresh()?;
        out.copy_from_slice(&self.values[rows.start as usize..rows.end as usize]);
        Ok(())
    }

    /// Reads the event indicators; an event is where one changes its sign.
    ///
    /// # Errors
    /// As [`Instance::state_derivatives`].
    pub fn event_indicators(&mut self, out: &mut [f64]) -> Result<(), Error> {
        self.require_continuous()?;
        self.refresh()?;
        let found = self.continuous.as_ref().map_or(&[][..], |continuous| &continuous.indicators);
        super::values::same_length(found.len(), out.len())?;
        out.copy_from_slice(found);
        Ok(())
    }

    /// Typical sizes of the continuous states.
    ///
    /// # Errors
    /// As [`Instance::continuous_states`].
    pub fn nominals(&self, out: &mut [f64]) -> Result<(), Error> {
        self.require_continuous()?;
        let rows = self.shared.description.states();
        super::values::same_length(rows.len(), out.len())?;
        for (row, out) in rows.zip(out) {
            *out = self.shared.description.variables[row as usize].quantity.nominal;
        }
        Ok(())
    }

    /// The importer has completed an integration step; true where that should be followed by event mode, since a contact
    /// came to stick, slip or lift off and no indicator had been asked in time.
    ///
    /// # Errors
    /// As [`Instance::state_derivatives`]; only in continuous time.
    pub fn completed_step(&mut self) -> Result<bool, Error> {
        self.require(Stage::ContinuousTime)?;
        let state = self.shared.description.reference(v::SLIP_STATE.name);
        let before =
            state.zip(self.continuous.as_ref()).map(|(row, continuous)| continuous.accepted[row as usize]);
        self.accept()?;
        Ok(before != state.map(|row| self.values[row as usize]))
    }

    /// After a start: continuous states and derivatives there.
    pub(super) fn begin_continuous(&mut self) -> Result<(), Error> {
        let Self { continuous: Some(continuous), behaviour, state, values, shared, .. } = self else {
            return Ok(());
        };
        let states = shared.description.states();
        let rows = &mut values[states.start as usize..states.end as usize];
        behaviour.read(state, rows).map_err(Error::Parameters)?;
        continuous.accepted.copy_from_slice(values);
        self.look()
    }

    /// At the end of a step of a slave: what its modes and event indicators do, which a step does not write.
    pub(super) fn show_modes(&mut self, indicators: &mut [f64]) -> Result<(), Error> {
        let time = self.time();
        let Self { behaviour, state, values, shared, .. } = self;
        let states = shared.description.states();
        let rows = &mut values[states.start as usize..states.end as usize];
        behaviour.read(state, rows).map_err(|reason| Error::Step { time, reason })?;
        // The outputs are those of the step, and stay: the contact has not moved since.
        let (accepted, mut table) = (values.clone(), values[..states.start as usize].to_vec());
        let (states, accelerations) = values[states.start as usize..].split_at_mut(2 * behaviour.modes());
        let at = Instant { continuous: states, accelerations, indicators };
        behaviour.look(state, &accepted, &mut table, at).map_err(|reason| Error::Step { time, reason })
    }

    /// One of the event indicators, of a slave too.
    pub(super) fn indicator(&mut self, index: usize) -> Result<f64, Error> {
        self.refresh()?;
        if let Some(continuous) = &self.continuous {
            return Ok(continuous.indicators[index]);
        }
        let mut all = vec![0.0; self.shared.description.continuous.indicators];
        self.show_modes(&mut all)?;
        Ok(all[index])
    }

    /// Before the instant is accepted: outputs and derivatives from inputs and continuous states.
    pub(super) fn look(&mut self) -> Result<(), Error> {
        let time = self.time();
        let Self { continuous: Some(continuous), behaviour, state, values, shared, .. } = self else {
            return Ok(());
        };
        let first = shared.description.states().start as usize;
        let (table, rows) = values.split_at_mut(first);
        let (states, accelerations) = rows.split_at_mut(2 * behaviour.modes());
        let Continuous { accepted, indicators } = continuous;
        let at = Instant { continuous: states, accelerations, indicators };
        behaviour.look(state, accepted, table, at).map_err(|reason| Error::Step { time, reason })
    }

    fn accept(&mut self) -> Result<(), Error> {
        self.refresh()?;
        let time = self.time();
        let Self { continuous: Some(continuous), behaviour, state, values, shared, .. } = self else {
            return Err(Error::Interface);
        };
        let states = shared.description.states();
        let continuous_states = &values[states.start as usize..states.end as usize];
        behaviour.accept(state, values, continuous_states).map_err(|reason| Error::Step { time, reason })?;
        continuous.accepted.copy_from_slice(values);
        Ok(())
    }
}
