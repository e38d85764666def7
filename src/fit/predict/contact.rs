//! A contact driven along a measured displacement.

use super::motion::{Motion, Outside, earlier};
use super::prehistory::Prehistory;
use super::sensors;
use super::simulation::Simulation;
use crate::contact::{ContactLaw, Inputs, Period, PeriodicSolver};
use crate::data::{Channel, Record, Regime};
use crate::fit;
use crate::model::Model;

/// Predictions of a record of a bare contact: the force, and the normal load where the model has a normal
/// stiffness.
pub(crate) struct ContactRecord<'r> {
    channels: Vec<&'r Channel>,
    regime: Regime,
    displacement: Motion,
    /// The measured normal load (N), smoothed.
    measured_load: Option<Motion>,
    normal_displacement: Option<Motion>,
    prehistory: Prehistory,
    solver: PeriodicSolver,
    /// Seconds between samples, where they are even.
    step: Option<f64>,
    /// Normal load (N) at every sample, under the model predicted last.
    load: Vec<f64>,
    /// Motion and load by as much earlier as that model's force sensor is late.
    earlier: Option<(Motion, Vec<f64>)>,
    states: [Vec<f64>; 2],
}

/// Share of the range, and multiple of the largest step between samples, above which the end of a record does not lead
/// to its beginning.
const OPEN: [f64; 2] = [0.2, 3.0];

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

impl<'r> ContactRecord<'r> {
    /// Of `record`, predicting `channels`.
    pub fn new(record: &'r Record, channels: Vec<&'r Channel>) -> Result<Self, String> {
        if record.regime == Regime::Backbone {
            return Err("a backbone table belongs to a beam or an oscillator, not to a bare contact".into());
        }
        let column = |name: &str| record.channel(name).map(|channel| channel.values.as_slice());
        let values = column("displacement").ok_or("there is no `displacement` column")?;
        let motion = |values: &[f64]| match (record.sample_step(), record.time()) {
            (Some(step), _) => Ok(Motion::even(values, step)),
            (None, Some(time)) => Ok(Motion::uneven(values, time)),
            (None, None) => Err("there is no `time` column"),
        };
        let displacement = match column("velocity") {
            Some(rates) => Motion { values: values.to_vec(), rates: rates.to_vec() },
            None => motion(values)?,
        };
        if record.regime == Regime::Steady {
            closes(&displacement.values)?;
        }
        let measured_load = column("normal_load").map(motion).transpose()?;
        let normal_displacement = column("normal_displacement").map(motion).transpose()?;
        let prehistory = Prehistory::new(&displacement.values);
        Ok(Self {
            channels,
            regime: record.regime,
            displacement,
            measured_load,
            normal_displacement,
            prehistory,
            solver: PeriodicSolver::new(),
            step: record.sample_step(),
            load: Vec::new(),
            earlier: None,
            states: Default::default(),
        })
    }

    /// What the contact is driven by under `model`.
    fn drive(&mut self, model: &Model) -> Result<(), String> {
        self.update_load(model)?;
        let force = self.channels.iter().copied().find(|channel| self.shows_delay(channel));
        let delay = force.and_then(|force| sensors::fault(model, force)).map_or(0.0, |fault| fault.delay);
        self.earlier = self.step.filter(|_| delay != 0.0).map(|step| {
            let outside = match self.regime {
                Regime::FromRest => Outside::Still,
                _ => self.prehistory.period().map_or(Outside::Straight, Outside::Periodic),
            };
            (self.displacement.earlier(delay / step, step, outside), earlier(&self.load, delay / step))
        });
        Ok(())
    }

    /// The normal load at every sample.
    fn update_load(&mut self, model: &Model) -> Result<(), String> {
        let contact = model.contact.as_ref().ok_or("the model has no [contact]")?;
        let joint = model.changes().joint;
        let count = self.displacement.values.len();
        self.load.clear();
        if let (true, Some(normal)) = (contact.normal_stiffness > 0.0, &self.normal_displacement) {
            let reaction = |(approach, rate): (&f64, &f64)| {
                joint.normal_reaction(contact.normal_load, contact.normal_stiffness, *approach, *rate)
            };
            self.load.extend(normal.values.iter().zip(&normal.rates).map(reaction));
        } else if let Some(measured) = &self.measured_load {
            self.load.extend(
                measured.values.iter().map(|load| joint.normal_load(contact.normal_load, Some(*load))),
            );
        } else {
            self.load.resize(count, contact.normal_load);
        }
        Ok(())
    }

    fn inputs(&self, index: usize) -> Inputs {
        let (motion, load) = match &self.earlier {
            Some((motion, load)) => (motion, load),
            None => (&self.displacement, &self.load),
        };
        Inputs { displacement: motion.values[index], velocity: motion.rates[index], normal_load: load[index] }
    }

    /// Steps through the samples `0..end` from `states[0]`, which is left behind.
    fn walk(&mut self, law: &dyn ContactLaw, end: usize, mut visit: impl FnMut(usize, f64)) {
        let [mut state, mut next] = std::mem::take(&mut self.states);
        for index in 0..end {
            visit(index, law.step(&state, self.inputs(index), &mut next).force);
            std::mem::swap(&mut state, &mut next);
        }
        self.states = [state, next];
    }

    /// Puts the state before the first sample into `states[0]`.
    fn start(&mut self, law: &dyn ContactLaw, nuisances: &[f64]) -> Result<(), String> {
        let [mut state, mut next] = std::mem::take(&mut self.states);
        state.clear();
        state.resize(law.state_len(), 0.0);
        next.clone_from(&state);
        let first = self.inputs(0);
        match (self.regime, nuisances) {
            (Regime::Steady, _) => {
                law.set_state(first.displacement, first.normal_load, 0.0, &mut state);
                let period = Period {
                    displacement: &self.displacement.values,
                    velocity: &self.displacement.rates,
                    normal_load: &self.load,
                };
                self.solver.solve(law, &period, &mut state).map_err(|error| error.to_string())?;
            }
            (Regime::UnknownInitialState, [value]) => {
                let inputs = |index| self.inputs(index);
                self.prehistory.start(law, &inputs, *value, &mut state, &mut next);
            }
            _ => law.set_state(0.0, first.normal_load, 0.0, &mut state),
        }
        self.states = [state, next];
        Ok(())
    }

    /// Mean square error of the force over the samples that tell the start, as a function of the nuisance.
    fn misfit(&mut self, law: &dyn ContactLaw, measured: &Measured, value: f64) -> f64 {
        if self.start(law, &[value]).is_err() {
            return f64::INFINITY;
        }
        let mut sum = 0.0;
        self.walk(law, measured.samples, |index, force| {
            sum += (measured.gain * force + measured.bias - measured.values[index]).powi(2);
        });
        if sum.is_finite() { sum } else { f64::INFINITY }
    }
}

/// The contact's law with all the model's effects.
fn law_of(model: &Model) -> Result<Box<dyn ContactLaw>, String> {
    model.law().map_err(|error| error.to_string())?.ok_or_else(|| "the model has no [contact]".to_owned())
}

/// The beginning of the measured force, and how its sensor shows it.
struct Measured<'r> {
    values: &'r [f64],
    samples: usize,
    gain: f64,
    bias: f64,
}

impl Simulation for ContactRecord<'_> {
    fn channels(&self) -> &[&Channel] {
        &self.channels
    }

    /// A late force is the force of the earlier motion, which has a past before the record's first sample.
    fn shows_delay(&self, channel: &Channel) -> bool {
        channel.quantity() == "force" && self.step.is_some() && self.regime != Regime::Steady
    }

    fn nuisances(&mut self, model: &Model) -> Result<Vec<fit::Parameter>, String> {
        if self.regime != Regime::UnknownInitialState {
            return Ok(Vec::new());
        }
        let law = law_of(model)?;
        self.drive(model)?;
        let force = self.channels.iter().copied().find(|channel| channel.quantity() == "force");
        let Some(force) = force else { return Ok(vec![self.prehistory.parameter(0.0)]) };
        let fault = sensors::fault(model, force);
        let measured = Measured {
            values: &force.values,
            samples: self.prehistory.telling(force.values.len()),
            gain: fault.as_ref().map_or(1.0, |fault| fault.gain),
            bias: fault.as_ref().map_or(0.0, |fault| fault.bias),
        };
        // The search belongs to the prehistory, which has to be changed while the record is walked.
        let mut best = (f64::INFINITY, self.prehistory.clone(), 0.0);
        for kind in Prehistory::KINDS {
            self.prehistory.choose(kind, law.as_ref(), self.load[0]);
            let value =
                self.prehistory.clone().search(&mut |value| self.misfit(law.as_ref(), &measured, value));
            let cost = self.misfit(law.as_ref(), &measured, value);
            if cost < best.0 {
                best = (cost, self.prehistory.clone(), value);
            }
        }
        let (_, prehistory, value) = best;
        self.prehistory = prehistory;
        Ok(vec![self.prehistory.parameter(value)])
    }

    fn predict(&mut self, model: &Model, nuisances: &[f64], out: &mut Vec<f64>) -> Result<(), String> {
        let law = law_of(model)?;
        self.drive(model)?;
        self.start(law.as_ref(), nuisances)?;
        let count = self.displacement.values.len();
        out.clear();
        out.reserve(count * self.channels.len());
        for channel in 0..self.channels.len() {
            match self.channels[channel].quantity() {
                "normal_load" => out.extend_from_slice(&self.load),
                _ => self.walk(law.as_ref(), count, |_, force| out.push(force)),
            }
        }
        Ok(())
    }
}
