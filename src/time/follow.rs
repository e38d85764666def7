//! A step again, with a change of its inputs.

use super::integrator::Integrator;
use super::plant::dot;
use super::step::Span;
use super::tangent::Tangent;
use super::{IntegrationError, Motion, Ramp, Settings};

/// How a communication step is gone through.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Steps {
    /// As [`Integrator::advance`] does.
    Controlled(Settings),
    /// As [`Integrator::march`] does, in so many.
    Equal(usize),
}

impl Integrator {
    /// [`Integrator::advance`] or [`Integrator::march`].
    pub(crate) fn go(
        &mut self,
        motion: &mut Motion,
        duration: f64,
        inputs: &[Ramp],
        steps: Steps,
    ) -> Result<(), IntegrationError> {
        match steps {
            Steps::Controlled(settings) => self.advance(motion, duration, inputs, &settings).map(drop),
            Steps::Equal(count) => self.march(motion, duration, inputs, count),
        }
    }

    /// [`Integrator::go`] from `motion`, which stays, with the change `by` of the inputs; `tangent` becomes that of the
    /// end. Without a duration it is that of `motion` itself, at rest with laws that remember nothing.
    pub(crate) fn follow(
        &mut self,
        motion: &Motion,
        duration: Option<f64>,
        inputs: &[Ramp],
        steps: Steps,
        (tangent, by): (&mut Tangent, &[Ramp]),
    ) -> Result<(), IntegrationError> {
        let settings = if let Steps::Controlled(settings) = steps { settings } else { Settings::default() };
        self.begin(motion, duration.unwrap_or(1.0), inputs, &settings)?;
        tangent.begin(&self.solver);
        let Some(duration) = duration else {
            tangent.rest(&self.solver, by);
            if !self.solver.prepare(&Span::START) {
                return Err(IntegrationError::StepTooSmall { time: 0.0, step: 0.0 });
            }
            tangent.arrive(&self.solver, 0.0, by);
            tangent.finish(&self.solver, &Span::START, inputs, by);
            return Ok(());
        };
        match steps {
            Steps::Controlled(settings) => {
                let mut suggested = self.first_step(motion);
                self.run(duration, &settings, &mut suggested, Some((tangent, by)))?;
            }
            Steps::Equal(count) => {
                tangent.before_jump(&self.solver);
                self.take_up(motion, inputs)?;
                tangent.jump(&self.solver, by);
                self.stride(duration, count, |solver, span| tangent.through_equal(solver, span, by))?;
                tangent.now(&self.solver, 1.0, by);
            }
        }
        tangent.finish(&self.solver, &Span { duration, ..Span::START }, inputs, by);
        Ok(())
    }

    /// The end of a step that was followed, where its inputs go on as `inputs` and change by `by` over `duration` (s).
    pub(crate) fn show(&self, tangent: &mut Tangent, duration: f64, inputs: &[Ramp], by: &[Ramp]) {
        tangent.finish(&self.solver, &Span { duration, ..Span::START }, inputs, by);
    }

    /// Change of what sensor `sensor` reads: displacement, velocity, acceleration.
    pub(crate) fn sensor_change(&self, tangent: &Tangent, sensor: usize) -> [f64; 3] {
        let plant = &self.solver.plant;
        let row = &plant.ports[plant.sensors[sensor]].row;
        tangent.present().map(|list| dot(row, list))
    }
}
