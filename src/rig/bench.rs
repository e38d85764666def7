//! The beam on the rig, with its sensors.

use std::f64::consts::TAU;

use super::error::RigError;
use super::plan::{Accelerometer, no_beam};
use crate::effects::{Location, Needs};
use crate::harmonic::{
    Assembly, Control, CurveSettings, Point, Resonance, periodic_response, phase_resonance,
};
use crate::model::Model;
use crate::system::{Core, System};

/// Harmonics up to so many times the highest mode are balanced: the contact excites every mode, and accelerations show it.
const BEYOND_HIGHEST_MODE: f64 = 1.4;
/// Fewest and most harmonics where the plan does not say how many.
const HARMONICS: (usize, usize) = (21, 60);

/// A beam as a system, its first sensors the accelerometers.
pub(super) struct Bench {
    pub assembly: Assembly,
    /// The lowest and the highest mode (rad/s).
    modes: [f64; 2],
    /// An effect that has no steady state.
    transient: Option<&'static str>,
}

impl Bench {
    pub fn new(model: &Model, sensors: &[Accelerometer]) -> Result<Self, RigError> {
        if let Some(fault) = model.effects.iter().find(|of| matches!(of.location, Some(Location::Channel(_))))
        {
            let message = format!(
                "the effect \"{}\" is of the measurement: say it in the plan's chain of sensors, not in the model",
                fault.effect.id
            );
            return Err(RigError::Input(message));
        }
        let mut observed = model.clone();
        let beam = observed.structure.beam_mut().ok_or_else(no_beam)?;
        beam.sensors = sensors.iter().map(|sensor| sensor.position).collect();
        beam.contact_points.clear();
        let system = observed.system()?;
        let modes = match &system.core {
            Core::Modal { angular_frequency: all, .. } => [all[0], all[all.len() - 1]],
            Core::Matrices { .. } => return Err(RigError::Input("the beam has no modes of its own".into())),
        };
        let transient = model.effects.iter().find(|applied| applied.effect.needs == Needs::Transient);
        let transient = transient.map(|applied| applied.effect.id);
        Ok(Self { assembly: Assembly::new(system), modes, transient })
    }

    pub fn system(&self) -> &System {
        &self.assembly.system
    }

    pub fn sensors(&self) -> usize {
        self.system().sensors.len()
    }

    /// The lowest mode (rad/s).
    pub fn lowest(&self) -> f64 {
        self.modes[0]
    }

    /// Harmonics for a motion of `angular_frequency` (rad/s).
    fn settings(&self, harmonics: Option<usize>, angular_frequency: f64) -> CurveSettings {
        let needed = (BEYOND_HIGHEST_MODE * self.modes[1] / angular_frequency).ceil() as usize + 1;
        let harmonics = harmonics.unwrap_or_else(|| needed.clamp(HARMONICS.0, HARMONICS.1));
        CurveSettings { harmonics, ..CurveSettings::default() }
    }

    /// Refuses effects that have no steady state.
    pub fn steady(&self) -> Result<(), RigError> {
        match self.transient {
            None => Ok(()),
            Some(id) => Err(RigError::Input(format!(
                "the effect \"{id}\" has no steady state, and so no held level: what it adds grows from period to period"
            ))),
        }
    }

    /// The phase resonance of the first mode with the acceleration held (m/s²).
    pub fn resonance(&self, harmonics: Option<usize>, acceleration: f64) -> Result<Resonance, RigError> {
        self.steady()?;
        let settings = self.settings(harmonics, self.lowest());
        Ok(phase_resonance(self.system(), acceleration, &settings, None)?)
    }

    /// The steady state at a frequency (Hz) with the acceleration held (m/s²).
    pub fn held(
        &self,
        harmonics: Option<usize>,
        frequency: f64,
        acceleration: f64,
    ) -> Result<Point, RigError> {
        self.steady()?;
        // After the sensors comes the port driven.
        let node = self.sensors();
        let control = Control::Held { node, order: 1, derivative: 2, amplitude: acceleration };
        let settings = self.settings(harmonics, TAU * frequency);
        Ok(periodic_response(&self.assembly, TAU * frequency, &control, &settings, None)?)
    }
}
