//! The sealed cases that came later, after the first ones: other numbers of records, noise that nobody tells, wrong masses,
//! coarse samples, other laws, measurements out of order, and the first paper's rig.

use super::case::{Case, Kind, LATER_OUTSIDE, Noise, Strength};
use super::sealed::{NOISES, case};
use crate::motion::drive::Drive;
use crate::rigs::setting::Setting::{
    self, Coarse, Further, HeldLevels, LongDelay, MassOff, NoiseUntold, Records32, Records128,
};

const FINE: (f64, bool) = (0.003, false);
const USUAL: (f64, bool) = (0.01, false);
const COLOURED: (f64, bool) = (0.01, true);
const LOUD: (f64, bool) = (0.03, false);

/// What is hidden in a case, and its noise.
type Asked = (&'static [&'static str], (f64, bool));

/// What is asked of bare contacts in other settings.
const CONTACTS: &[(Setting, &[Asked])] = &[
    (
        Records32,
        &[
            (&[], USUAL),
            (&["backlash"], USUAL),
            (&["micro_slip"], COLOURED),
            (&["velocity_weakening", "asymmetry"], USUAL),
        ],
    ),
    (Records128, &[(&[], USUAL), (&["backlash"], USUAL), (&["micro_slip"], FINE), (&["wear"], LOUD)]),
    (
        LongDelay,
        &[
            (&["sensor_delay"], USUAL),
            (&["sensor_delay"], (0.03, true)),
            (&["sensor_delay", "backlash"], USUAL),
        ],
    ),
];

/// What is asked of bare contacts in ramped records.
const RAMPED: &[Asked] = &[
    (&[], FINE),
    (&[], (0.03, true)),
    (&["backlash"], USUAL),
    (&["micro_slip"], COLOURED),
    (&["contact_damping"], USUAL),
    (&["asymmetry"], LOUD),
    (&["stiffening"], USUAL),
    (&["unknown:position_dependent_friction"], USUAL),
];

/// What is asked of oscillators in other settings.
const OSCILLATORS: &[(Setting, &[Asked])] = &[
    (Records32, &[(&[], USUAL), (&["backlash"], USUAL)]),
    (
        NoiseUntold,
        &[
            (&[], USUAL),
            (&["backlash"], USUAL),
            (&["micro_slip"], COLOURED),
            (&["velocity_weakening"], LOUD),
            (&["unknown:second_limit"], USUAL),
        ],
    ),
    (
        MassOff,
        &[
            (&["added_mass"], FINE),
            (&["added_mass"], USUAL),
            (&["added_mass"], COLOURED),
            (&["added_mass", "backlash"], USUAL),
            (&["added_mass", "micro_slip"], USUAL),
            (&["added_mass", "residual_stiffness"], USUAL),
        ],
    ),
    (
        Coarse,
        &[
            (&[], FINE),
            (&[], USUAL),
            (&["velocity_weakening"], FINE),
            (&["velocity_weakening"], USUAL),
            (&["micro_slip"], FINE),
            (&["backlash"], USUAL),
        ],
    ),
];

/// What is asked of beams in other settings.
const BEAMS: &[(Setting, &[Asked])] = &[(HeldLevels, &[(&["micro_slip:valanis"], USUAL)])];

/// All of them.
pub fn later() -> Vec<Case> {
    let mut cases = Vec::new();
    add(&mut cases, Kind::Contact, CONTACTS);
    let ramped = RAMPED.iter().map(|(effects, noise)| full(Kind::Contact, effects, *noise));
    cases.extend(ramped.map(|case| Case { drive: Drive::Ramped, ..case }));
    add(&mut cases, Kind::Oscillator, OSCILLATORS);
    add(&mut cases, Kind::Beam, BEAMS);
    laws(&mut cases);
    outside(&mut cases);
    further_nulls(&mut cases);
    cases
}

fn add(cases: &mut Vec<Case>, kind: Kind, plan: &[(Setting, &[Asked])]) {
    for (setting, asked) in plan {
        let usual = asked.iter().map(|(effects, noise)| full(kind, effects, *noise));
        cases.extend(usual.map(|case| Case { setting: *setting, ..case }));
    }
}

fn full(kind: Kind, effects: &[&'static str], noise: (f64, bool)) -> Case {
    case(kind, effects, Strength::Full, noise, 1)
}

/// Micro-slip as contact laws show it that are not many sliders.
fn laws(cases: &mut Vec<Case>) {
    const LAWS: [&str; 3] = ["micro_slip:dahl", "micro_slip:bouc_wen", "micro_slip:valanis"];
    for law in LAWS {
        cases.extend([FINE, USUAL, (0.03, true)].map(|noise| full(Kind::Contact, &[law], noise)));
    }
    cases.extend(LAWS.map(|law| full(Kind::Oscillator, &[law], USUAL)));
}

fn outside(cases: &mut Vec<Case>) {
    for id in LATER_OUTSIDE {
        cases.extend([FINE, USUAL].map(|noise| full(Kind::Contact, &[id], noise)));
        cases.push(full(Kind::Oscillator, &[id], USUAL));
    }
    // Physics of which much is absorbed where the noise may be anything.
    cases.extend(
        LATER_OUTSIDE[..3]
            .iter()
            .map(|id| Case { drive: Drive::MovingUntold, ..full(Kind::Contact, &[id], USUAL) }),
    );
}

/// Replicas of the null cases with noise of at most 3 %, beyond those of the first cases.
const FURTHER: std::ops::RangeInclusive<usize> = 7..=46;

fn further_nulls(cases: &mut Vec<Case>) {
    for replica in FURTHER {
        for (share, coloured) in NOISES.into_iter().filter(|(share, _)| *share <= 0.03) {
            let noise = Noise { share, coloured };
            cases.push(Case { noise, replica, setting: Further, ..full(Kind::Contact, &[], USUAL) });
        }
    }
}
