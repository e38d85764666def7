//! The limit follows the normal load, with lift-off and re-contact.

use super::{ALL_KINDS, Confusion, Effect, EffectParameter, InTables, Needs, Part, PlaceKind, Range};
use crate::vocabulary::{self as v, Scale};

pub(super) static EFFECT: Effect = Effect {
    id: "normal_load_variation",
    title: "Varying normal load",
    summary: "The friction limit follows the normal load N0 + gain (N(t) − N0), with lift-off at zero and below; N(t) is \
          the measured load or, on a pin rig, the model's own normal force",
    explanation: "Vibration, thermal growth or a second direction of motion changes the pressure on the contact while \
          it slides. The limit rises and falls with it. Where the load vanishes, the bodies separate: the force \
          is zero, and the contact starts without history when they touch again.",
    confirmation: "Hold the load by a soft spring or a dead weight, or plot the loop's height against the measured \
          load: with this effect it is a straight line through zero.",
    confused_with: &[Confusion {
        with: &super::asymmetry::EFFECT,
        why: "a load that varies in step with the motion raises one plateau and lowers the other",
        experiment: "change the phase between normal load and motion, or hold the load constant",
    }],
    next_experiment: "repeat the test under another normal load",
    parameters: &[EffectParameter {
        quantity: &v::LOAD_GAIN,
        neutral: Some(0.0),
        range: |_| Range { lower: -3.0, upper: 3.0, scale: Scale::Linear, starts: vec![1.0] },
    }],
    part: Part::Joint,
    place: PlaceKind::Nowhere,
    kinds: ALL_KINDS,
    needs: Needs::VaryingNormalLoad,
    in_tables: InTables::Shown,
    apply: |values, _, changes| changes.joint.load_gain = Some(values[0]),
    signature: |seen| {
        seen.height_by_load.filter(|correlation| correlation.abs() > 0.3).map(|correlation| {
            format!("the force in slip follows the measured normal load (correlation {correlation:.2})")
        })
    },
};
