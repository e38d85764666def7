//! The choice of regime: which simulation predicts a record.

use super::backbone::{BackboneOfBeam, BackboneOfOscillator};
use super::channels;
use super::from_rest::FromRest;
use super::simulation::{Seed, Simulation};
use super::steady::{SteadyBeam, SteadyContact, SteadyOscillator};
use super::unknown_start::{ContactOfUnknownStart, OscillatorOfUnknownStart};
use crate::data::{Record, Regime};
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
        (Regime::FromRest, _) => Box::new(FromRest::new(model, record, channels)?),
        (Regime::Steady, Structure::Prescribed) => Box::new(SteadyContact::new(record, channels)?),
        (Regime::Steady, Structure::Oscillator(_)) => {
            Box::new(SteadyOscillator::new(model, record, channels)?)
        }
        (Regime::Steady, Structure::Beam(_)) => Box::new(SteadyBeam::new(model, record, channels, seed)?),
        (Regime::UnknownInitialState, Structure::Prescribed) => {
            Box::new(ContactOfUnknownStart::new(record, channels)?)
        }
        (Regime::UnknownInitialState, Structure::Oscillator(oscillator)) => {
            Box::new(OscillatorOfUnknownStart::new(model, oscillator, record, channels)?)
        }
        (Regime::UnknownInitialState, Structure::Beam(_)) => return Err(BEAM_OF_UNKNOWN_START.into()),
        (Regime::Backbone, Structure::Beam(_)) => Box::new(BackboneOfBeam::new(record, channels)?),
        (Regime::Backbone, Structure::Oscillator(oscillator)) => {
            Box::new(BackboneOfOscillator::new(model, oscillator, record, channels)?)
        }
        (Regime::Backbone, Structure::Prescribed) => return Err(BACKBONE_OF_CONTACT.into()),
    })
}

const BEAM_OF_UNKNOWN_START: &str = "a beam's record needs the regime `from-rest`, `steady` or `backbone`: the motion \
                                     at its start is not measured everywhere";
const BACKBONE_OF_CONTACT: &str =
    "a backbone table belongs to a beam or an oscillator, not to a contact alone";
