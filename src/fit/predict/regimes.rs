//! The choice of regime: which simulation predicts a record.

use super::backbone::{BackboneOfBeam, BackboneOfDecay, BackboneOfMode};
use super::channels;
use super::from_rest::FromRest;
use super::simulation::{Seed, Simulation};
use super::steady::{SteadyBeam, SteadyContact, SteadyOscillator};
use super::stepped_sine::SteppedSine;
use super::unknown_start::{ContactOfUnknownStart, OscillatorOfUnknownStart};
use crate::data::{Record, Regime};
use crate::fit::ring_down::{is_ring_down, levels};
use crate::model::{Model, Structure};

/// The simulation of `record` for models of the kind of `model`, from `seed` if there is one.
///
/// # Errors
/// What the record lacks, for a reader of the comparison.
pub(super) fn simulation<'r>(
    model: &Model,
    record: &'r Record,
    seed: Option<&Seed>,
) -> Result<Box<dyn Simulation + 'r>, String> {
    let channels = channels::compared(model, record);
    if channels.is_empty() {
        return Err("it has no column that the model predicts".into());
    }
    Ok(match (record.regime, &model.structure) {
        (Regime::Steady, Structure::PinRig(_)) => Box::new(SteadyBeam::new(model, record, channels, seed)?),
        (Regime::SteppedSine, Structure::PinRig(_)) => Box::new(SteppedSine::new(model, record, channels)?),
        (Regime::Backbone, Structure::PinRig(_)) => Box::new(BackboneOfMode::new(model, record, channels)?),
        (_, Structure::PinRig(_)) => return Err(PIN_RIG.into()),
        (Regime::FromRest, _) => Box::new(FromRest::new(model, record, channels)?),
        (Regime::Steady, Structure::Prescribed) => Box::new(SteadyContact::new(record, channels)?),
        (Regime::Steady, Structure::Oscillator(_)) => {
            Box::new(SteadyOscillator::new(model, record, channels)?)
        }
        (Regime::Steady, Structure::Beam(_)) => Box::new(SteadyBeam::new(model, record, channels, seed)?),
        (Regime::UnknownInitialState, _) if is_ring_down(model, record) => return Err(uncut(record)),
        (Regime::UnknownInitialState, Structure::Prescribed) => {
            Box::new(ContactOfUnknownStart::new(record, channels)?)
        }
        (Regime::UnknownInitialState, Structure::Oscillator(oscillator)) => {
            Box::new(OscillatorOfUnknownStart::new(model, oscillator, record, channels)?)
        }
        (Regime::UnknownInitialState, Structure::Beam(_)) => return Err(BEAM_OF_UNKNOWN_START.into()),
        (Regime::Backbone, _) if BackboneOfDecay::is_one(record) => {
            Box::new(BackboneOfDecay::new(model, record, channels)?)
        }
        (Regime::Backbone, Structure::Beam(_)) if record.channel("amplitude").is_some() => {
            Box::new(BackboneOfBeam::new(record, channels)?)
        }
        (Regime::Backbone, Structure::Beam(_) | Structure::Oscillator(_)) => {
            Box::new(BackboneOfMode::new(model, record, channels)?)
        }
        (Regime::SteppedSine, Structure::Prescribed) => return Err(STEPPED_SINE_OF_CONTACT.into()),
        (Regime::SteppedSine, _) => Box::new(SteppedSine::new(model, record, channels)?),
        (Regime::Backbone, Structure::Prescribed) => return Err(BACKBONE_OF_CONTACT.into()),
    })
}

const PIN_RIG: &str = "a pin rig's record needs the regime `steady`, under a force that repeats, `stepped-sine`, or `backbone` with the place of its amplitude";
const BEAM_OF_UNKNOWN_START: &str = "a beam's record needs the regime `from-rest`, `steady` or `backbone`: the motion \
                                     at its start is not measured everywhere";
const BACKBONE_OF_CONTACT: &str =
    "a backbone table belongs to a beam or an oscillator, not to a contact alone";

const STEPPED_SINE_OF_CONTACT: &str =
    "a stepped-sine table belongs to a beam or an oscillator, not to a contact alone";

/// Why a free decay has no table.
fn uncut(record: &Record) -> String {
    let not_asked =
        "nothing excites it: it is a free decay, which is compared level by level, as `tabulated` cuts it";
    levels(record).err().unwrap_or_else(|| not_asked.to_owned())
}
