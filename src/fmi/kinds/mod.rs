//! What each kind of model is as an instance: its rows of the variable table, and its physics.
//!
//! [`describe`] and [`behaviour`] choose by the model. A contact alone is `contact`, in two directions `slip_slap`; beams and
//! oscillators put their rows around a `driven` system; `pin_rig` is a beam whose pin slips and slaps. `slip` tells all of
//! them how much of a contact slips.

mod beam;
mod contact;
mod driven;
mod oscillator;
mod pin_rig;
mod slip;
mod slip_slap;

use super::Behaviour;
use super::description::{Description, Variable};
use crate::contact::JointChanges;
use crate::model::{Model, Structure};
use crate::time::Ramp;

/// Most steps, attempts among them, within a communication step: more take a second, in which nothing can be told to the master.
const MOST_STEPS: usize = 50_000;

/// How many steps of at most `longest` (s) make a communication step of `step` (s).
///
/// # Errors
/// More than [`MOST_STEPS`].
fn count_steps(step: f64, longest: f64) -> Result<usize, String> {
    let count = (step / longest).ceil().max(1.0);
    if count > MOST_STEPS as f64 {
        // A little less, which rounding does not carry beyond it.
        let most = 0.99 * longest * MOST_STEPS as f64;
        return Err(format!(
            "a communication step of {step:?} s is too long for a motion this fast: ask for {most:.2e} s at most"
        ));
    }
    Ok(count as usize)
}

/// The normal load that acts, from the one that comes in.
#[derive(Debug, Clone, Copy)]
struct LoadRule {
    /// The fraction (1) of the change that reaches the contact; `None`: all.
    fraction: Option<f64>,
    constant: f64,
}

impl LoadRule {
    fn new(model: &Model) -> Self {
        Self {
            fraction: model.changes().joint.load_gain,
            constant: model.contact.map_or(0.0, |contact| contact.normal_load),
        }
    }

    /// Change of N per change of the input (1).
    fn gain(&self) -> f64 {
        self.fraction.unwrap_or(1.0)
    }

    /// N over a step, of an input over it.
    fn along(&self, input: &Ramp) -> Ramp {
        let (gain, Ramp { start, end, bow, skew }) = (self.gain(), *input);
        Ramp { start: self.acting(start), end: self.acting(end), bow: gain * bow, skew: gain * skew }
    }

    /// N, of the `input` (N): all of it, or the fraction of its change that reaches the contact.
    #[inline]
    fn acting(&self, input: f64) -> f64 {
        let changes = JointChanges { load_gain: self.fraction, ..JointChanges::default() };
        if self.fraction.is_none() { input } else { changes.normal_load(self.constant, Some(input)) }
    }
}

/// The variable table of a model whose parameters have the rows `parameters`.
pub(super) fn describe(model: &Model, parameters: Vec<Variable>) -> Result<Description, String> {
    match (&model.structure, &model.contact) {
        (Structure::Prescribed, Some(contact)) if contact.normal.is_some() => {
            Ok(slip_slap::describe(model, contact, parameters))
        }
        (Structure::Prescribed, Some(contact)) => Ok(contact::describe(model, contact, parameters)),
        (Structure::Prescribed, None) => Err("a contact model needs a contact".to_owned()),
        (Structure::PinRig(rig), _) => Ok(pin_rig::describe(model, rig, parameters)),
        (Structure::Beam(beam), contact) => Ok(beam::describe(model, beam, contact.as_ref(), parameters)),
        (Structure::Oscillator(oscillator), contact) => {
            Ok(oscillator::describe(model, oscillator, contact.as_ref(), parameters))
        }
    }
}

/// The physics of a model.
pub(super) fn behaviour(model: &Model) -> Result<Box<dyn Behaviour>, String> {
    match (&model.structure, &model.contact) {
        (Structure::Prescribed, Some(contact)) if contact.normal.is_some() => {
            Ok(Box::new(slip_slap::SlipSlapBehaviour::new(model)?))
        }
        (Structure::Prescribed, _) => Ok(Box::new(contact::ContactBehaviour::new(model)?)),
        (Structure::PinRig(rig), _) => Ok(Box::new(pin_rig::PinRigBehaviour::new(model, rig)?)),
        (Structure::Beam(beam), _) => beam::behaviour(beam, model),
        (Structure::Oscillator(oscillator), _) => oscillator::behaviour(model, oscillator),
    }
}
