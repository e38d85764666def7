//! A contact moved as measured through whole periods of a steady state.

use crate::contact::{Period, PeriodicSolver};
use crate::data::{Channel, Record};
use crate::fit::predict::simulation::Simulation;
use crate::fit::predict::stepper::contact::MovedContact;
use crate::model::Model;

/// Fraction of the range, and multiple of the largest step between samples, above which the end of a record does not
/// lead to its beginning.
const OPEN: [f64; 2] = [0.2, 3.0];

/// The simulation of one steady record of a contact.
pub(in crate::fit::predict) struct SteadyContact<'r> {
    contact: MovedContact<'r>,
    solver: PeriodicSolver,
}

impl<'r> SteadyContact<'r> {
    /// Of `channels` of `record`.
    pub fn new(record: &'r Record, channels: Vec<&'r Channel>) -> Result<Self, String> {
        let contact = MovedContact::new(record, channels)?;
        closes(&contact.displacement.values)?;
        Ok(Self { contact, solver: PeriodicSolver::new() })
    }
}

impl Simulation for SteadyContact<'_> {
    fn channels(&self) -> &[&Channel] {
        &self.contact.channels
    }

    fn predict(&mut self, model: &Model, _: &[f64], out: &mut Vec<f64>) -> Result<(), String> {
        let law = self.contact.drive(model)?;
        let mut stepper = self.contact.stepper(law.as_ref());
        let first = self.contact.inputs(0);
        law.set_state(first.displacement, first.normal_load, 0.0, &mut stepper.state);
        let period = Period {
            displacement: &self.contact.displacement.values,
            velocity: &self.contact.displacement.rates,
            normal_load: &self.contact.load,
        };
        self.solver.solve(law.as_ref(), &period, &mut stepper.state).map_err(|error| error.to_string())?;
        stepper.march(out);
        Ok(())
    }
}

/// Refuses a motion that cannot be periodic.
fn closes(values: &[f64]) -> Result<(), String> {
    let (Some(first), Some(last)) = (values.first(), values.last()) else { return Ok(()) };
    let [low, high] =
        values.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| [low.min(*x), high.max(*x)]);
    let step = values.windows(2).map(|pair| (pair[1] - pair[0]).abs()).fold(0.0, f64::max);
    let jump = (last - first).abs();
    if jump > OPEN[0] * (high - low) && jump > OPEN[1] * step {
        return Err(format!(
            "it is marked steady, but its `displacement` ends {:.0} % of its range away from where it begins: a steady \
             record holds whole periods; otherwise mark it `unknown-initial-state`",
            100.0 * jump / (high - low)
        ));
    }
    Ok(())
}
