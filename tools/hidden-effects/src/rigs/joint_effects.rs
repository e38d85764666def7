//! Drawing effects of the contact in the measures of a motion.

use std::f64::consts::TAU;

use crate::physics::gradual::Gradual;
use crate::physics::joint::Joint;
use crate::physics::unknown::Unknown;
use crate::records::random::Random;
use crate::rigs::effect::{Hidden, Law, MICRO_SLIP_OF, UNKNOWN};

/// The measures of a motion, by which the sizes of effects are drawn.
#[derive(Debug, Clone, Copy)]
pub struct Measures {
    /// Displacement at the end of stick (m).
    pub yield_displacement: f64,
    /// Friction limit (N).
    pub limit: f64,
    /// Amplitude of the strong records over the yield displacement.
    pub reach: f64,
    /// Speed of a motion of the yield displacement's amplitude at the usual frequency (m/s).
    pub slow_speed: f64,
    /// Highest speed (m/s).
    pub high_speed: f64,
    /// Slip of a strong record (m).
    pub travel: f64,
    /// Duration of a usual record (s).
    pub duration: f64,
    /// Largest residual stiffness over that in stick.
    pub residual: f64,
}

/// Hides `id` in the joint, `strength` of its full size; `None` when it is not an effect of the contact.
pub fn hide(
    id: &str,
    strength: f64,
    measures: &Measures,
    joint: &mut Joint,
    random: &mut Random,
) -> Option<Hidden> {
    if let Some(law) = id.strip_prefix(MICRO_SLIP_OF) {
        return replace_sliders(gradual(law, strength, measures, random)?, joint);
    }
    if let Some(own) = id.strip_prefix(UNKNOWN) {
        match gradual(own, strength, measures, random) {
            Some(law) => joint.gradual = Some(law),
            None => joint.unknown = Some(unknown(own, strength, measures, joint, random)?),
        }
        return Some(Hidden::new(id, &[]));
    }
    let parameters = in_catalogue(id, strength, measures, joint, random)?;
    Some(Hidden::new(id, &parameters))
}

/// Hides an effect of the catalogue; its parameters.
fn in_catalogue(
    id: &str,
    strength: f64,
    measures: &Measures,
    joint: &mut Joint,
    random: &mut Random,
) -> Option<Vec<(&'static str, f64)>> {
    let at_reach = measures.reach * measures.yield_displacement;
    Some(match id {
        "micro_slip" => {
            joint.spread = strength * random.between(0.7, 0.98);
            vec![("spread", joint.spread)]
        }
        "residual_stiffness" => {
            let share = random.between(0.5, 1.0) * measures.residual;
            joint.residual_stiffness = strength * share * joint.stiffness;
            vec![("residual_stiffness", joint.residual_stiffness)]
        }
        "contact_damping" => {
            joint.damping = strength * random.between(0.3, 0.6) * measures.limit / measures.high_speed;
            vec![("damping", joint.damping)]
        }
        "velocity_weakening" => {
            let share = strength * random.between(0.4, 0.7);
            let speed = random.between(3.0, 6.0) * measures.slow_speed;
            joint.weakening = Some((share, speed));
            vec![("weakening", share), ("weakening_velocity", speed)]
        }
        "wear" => {
            joint.wear = strength * random.sign() * random.between(0.3, 0.5) / measures.travel;
            vec![("rate", joint.wear)]
        }
        "backlash" => {
            joint.half_gap = strength * random.between(0.25, 0.45) * measures.yield_displacement;
            vec![("half_gap", joint.half_gap)]
        }
        "stiffening" => {
            // A softening spring behind a gap has no single answer where it outweighs the sliders.
            let sign = if random.unit() < 0.25 && joint.half_gap == 0.0 { -0.5 } else { 1.0 };
            let force = strength * sign * random.between(0.4, 0.8) * measures.limit;
            joint.cubic_stiffness = force / at_reach.powi(3);
            vec![("cubic_stiffness", joint.cubic_stiffness)]
        }
        "asymmetry" => {
            joint.asymmetry = strength * random.sign() * random.between(0.15, 0.3);
            vec![("asymmetry", joint.asymmetry)]
        }
        _ => return None,
    })
}

/// Puts a law of gradual slip in the place of the slider; `None` for one that the catalogue does not describe.
pub fn replace_sliders(law: Gradual, joint: &mut Joint) -> Option<Hidden> {
    let (name, described_by, parameters): (_, &'static [&'static str], _) = match law {
        Gradual::Dahl => {
            ("dahl", &["bouc_wen", "valanis"], vec![("sharpness", 1.0), ("unloading_ratio", 2.0)])
        }
        Gradual::BoucWen { sharpness, unloading_ratio } => {
            ("bouc_wen", &["bouc_wen"], vec![("sharpness", sharpness), ("unloading_ratio", unloading_ratio)])
        }
        Gradual::Valanis { smoothness } => ("valanis", &["valanis"], vec![("smoothness", smoothness)]),
        Gradual::LuGre { .. } => return None,
    };
    joint.gradual = Some(law);
    Some(Hidden::of_law("micro_slip", Law { name, described_by }, &parameters))
}

/// A contact law whose slip is gradual.
fn gradual(law: &str, strength: f64, measures: &Measures, random: &mut Random) -> Option<Gradual> {
    Some(match law {
        "dahl" => Gradual::Dahl,
        "bouc_wen" => Gradual::BoucWen {
            sharpness: random.between(1.0, 2.5),
            unloading_ratio: random.between(1.0, 1.6),
        },
        "valanis" => Gradual::Valanis { smoothness: random.between(0.2, 0.6) },
        "lugre" => Gradual::LuGre {
            rise: strength * random.between(0.4, 0.7),
            speed: random.between(3.0, 6.0) * measures.slow_speed,
            damping: random.between(0.1, 0.2) * measures.limit / measures.high_speed,
        },
        _ => return None,
    })
}

fn unknown(
    id: &str,
    strength: f64,
    measures: &Measures,
    joint: &Joint,
    random: &mut Random,
) -> Option<Unknown> {
    let length = measures.yield_displacement;
    Some(match id {
        "position_dependent_friction" => Unknown::PositionDependentFriction {
            share: strength * random.between(0.2, 0.3),
            length: random.between(0.7, 1.1) * length,
        },
        "dwell_strengthening" => {
            let length = random.between(0.5, 1.5) * length;
            Unknown::DwellStrengthening {
                share: strength * random.between(0.15, 0.3),
                dwell: 0.1 * length / measures.slow_speed,
                length,
            }
        }
        "second_limit" => Unknown::SecondLimit {
            share: strength * random.between(0.3, 0.5),
            distance: random.between(0.4, 0.6) * 2.0 * measures.reach * length,
        },
        "memory_damping" => {
            let slowest = measures.duration / 3.0;
            Unknown::MemoryDamping {
                stiffness: strength * random.between(0.05, 0.1) * joint.stiffness,
                times: (0..4).map(|decade| slowest * 10_f64.powi(-decade)).collect(),
            }
        }
        "stick_ageing" => Unknown::StickAgeing {
            share: strength * random.between(0.3, 0.5),
            time: random.between(0.7, 1.5) * 0.1 * TAU * length / measures.slow_speed,
        },
        "power_law_damping" => {
            let exponent = 0.3;
            let force = strength * random.between(0.15, 0.3) * measures.limit;
            Unknown::PowerLawDamping { coefficient: force / measures.high_speed.powf(exponent), exponent }
        }
        "stiffness_drift" => Unknown::StiffnessDrift {
            share: strength * random.sign() * random.between(0.25, 0.4),
            time: random.between(0.2, 0.4) * measures.duration,
        },
        "time_drift" => Unknown::TimeDrift {
            share: strength * random.sign() * random.between(0.25, 0.4),
            time: random.between(0.2, 0.4) * measures.duration,
        },
        _ => return None,
    })
}
