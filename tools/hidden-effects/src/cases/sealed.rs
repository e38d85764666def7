//! All sealed cases.

use super::case::{Case, Kind, Noise, Strength};
use super::later::later;
use crate::motion::drive::Drive;
use crate::rigs::setting::Setting;

/// All sealed cases: the first ones, which stay as they are, and those that came later.
pub fn sealed() -> Vec<Case> {
    let mut cases = Vec::new();
    for kind in Kind::ALL {
        nulls(kind, &mut cases);
        singles(kind, &mut cases);
        pairs(kind, &mut cases);
        outside(kind, &mut cases);
        drifts(kind, &mut cases);
        if kind == Kind::Contact {
            moving(kind, &mut cases);
        }
    }
    cases.extend(later());
    cases
}

pub(super) fn case(
    kind: Kind,
    effects: &[&'static str],
    strength: Strength,
    (share, coloured): (f64, bool),
    replica: usize,
) -> Case {
    Case {
        kind,
        effects: effects.to_vec(),
        strength,
        noise: Noise { share, coloured },
        drive: Drive::Stationary,
        setting: Setting::Usual,
        replica,
    }
}

pub(super) const NOISES: [(f64, bool); 8] = [
    (0.003, false),
    (0.003, true),
    (0.01, false),
    (0.01, true),
    (0.03, false),
    (0.03, true),
    (0.1, false),
    (0.1, true),
];

fn nulls(kind: Kind, cases: &mut Vec<Case>) {
    let replicas = match kind {
        Kind::Contact => 6,
        Kind::Oscillator => 2,
        Kind::Beam => 1,
    };
    for replica in 1..=replicas {
        cases.extend(NOISES.map(|noise| case(kind, &[], Strength::Full, noise, replica)));
    }
}

fn singles(kind: Kind, cases: &mut Vec<Case>) {
    use Strength::{Full, Half, Quarter};
    for (index, id) in kind.effects().iter().enumerate() {
        let plan: &[(Strength, (f64, bool))] = match (kind, index % 3) {
            (Kind::Contact, _) => &[
                (Full, (0.01, false)),
                (Full, (0.03, false)),
                (Full, (0.003, true)),
                (Full, (0.1, true)),
                (Half, (0.01, true)),
                (Quarter, (0.01, false)),
            ],
            (Kind::Oscillator, 0) => &[(Full, (0.01, false)), (Full, (0.03, true)), (Half, (0.01, false))],
            (Kind::Oscillator, 1) => {
                &[(Full, (0.01, false)), (Full, (0.03, true)), (Quarter, (0.003, false))]
            }
            (Kind::Oscillator, _) => &[(Full, (0.01, false)), (Full, (0.03, true)), (Full, (0.1, false))],
            (Kind::Beam, 0) => &[(Full, (0.01, false)), (Full, (0.03, true))],
            (Kind::Beam, 1) => &[(Full, (0.01, false)), (Half, (0.01, true))],
            (Kind::Beam, _) => &[(Full, (0.01, false)), (Full, (0.003, false))],
        };
        cases.extend(plan.iter().map(|(strength, noise)| case(kind, &[id], *strength, *noise, 1)));
    }
}

/// The noises of pairs, in turn.
pub(super) const PLAN_OF_PAIRS: [(f64, bool); 3] = [(0.01, false), (0.003, true), (0.03, false)];

fn pairs(kind: Kind, cases: &mut Vec<Case>) {
    for (index, pair) in kind.pairs().iter().enumerate() {
        cases.push(case(kind, pair, Strength::Full, PLAN_OF_PAIRS[index % 3], 1));
    }
}

fn outside(kind: Kind, cases: &mut Vec<Case>) {
    let plan: &[(Strength, (f64, bool))] = match kind {
        Kind::Contact => &[
            (Strength::Full, (0.003, false)),
            (Strength::Full, (0.01, true)),
            (Strength::Full, (0.03, false)),
            (Strength::Half, (0.01, false)),
        ],
        Kind::Oscillator => &[(Strength::Full, (0.003, false)), (Strength::Full, (0.01, true))],
        Kind::Beam => &[(Strength::Full, (0.01, false))],
    };
    for id in kind.outside() {
        cases.extend(plan.iter().map(|(strength, noise)| case(kind, &[id], *strength, *noise, 1)));
    }
}

/// Clocks that drift, which came later than the other effects: where a record has more than a steady state.
fn drifts(kind: Kind, cases: &mut Vec<Case>) {
    let noises: &[(f64, bool)] = match kind {
        Kind::Contact => &[(0.003, false), (0.01, true), (0.03, false)],
        Kind::Oscillator => &[(0.003, false), (0.01, false)],
        Kind::Beam => &[],
    };
    cases.extend(noises.iter().map(|noise| case(kind, &["sensor_clock_drift"], Strength::Full, *noise, 1)));
}

/// One of each kind of question, asked of records that are not stationary; where the noise is not told, those that can
/// be answered without it.
fn moving(kind: Kind, cases: &mut Vec<Case>) {
    const NULLS: [(f64, bool); 4] = [(0.003, false), (0.01, false), (0.01, true), (0.03, true)];
    const PAIRS: [(f64, bool); 3] = [(0.01, false), (0.003, true), (0.03, false)];
    let mut push = |drive, effects: &[&'static str], noise| {
        let case = case(kind, effects, Strength::Full, noise, 1);
        cases.push(Case { drive, ..case });
    };
    NULLS.into_iter().for_each(|noise| push(Drive::Moving, &[], noise));
    for id in kind.effects() {
        push(Drive::Moving, &[id], (0.01, false));
        push(Drive::Moving, &[id], (0.03, true));
    }
    kind.pairs().iter().zip(PAIRS).for_each(|(pair, noise)| push(Drive::Moving, pair, noise));
    for drive in [Drive::Moving, Drive::MovingUntold] {
        kind.outside().iter().for_each(|id| push(drive, &[id], (0.01, false)));
    }
    kind.effects().iter().for_each(|id| push(Drive::MovingUntold, &[id], (0.01, false)));
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;
    use crate::cases::case::fingerprint;
    use crate::rigs::effect::Hidden;

    #[test]
    fn the_sealed_cases_are_enough_and_none_is_there_twice() {
        let cases = sealed();
        let names: BTreeSet<String> = cases.iter().map(Case::name).collect();
        assert_eq!(names.len(), cases.len());
        assert!(cases.len() >= 200);
        // False alarms are counted on three hundred, of noise that does not hide them.
        let quiet_null = |case: &&Case| case.effects.is_empty() && case.noise.share <= 0.03;
        assert!(cases.iter().filter(quiet_null).count() >= 300);
    }

    #[test]
    fn cases_that_were_there_before_keep_their_names() {
        let cases = sealed();
        let (first, later) = cases.split_at(364);
        assert!(first.iter().all(|case| case.question().is_none()));
        assert!(later.iter().all(|case| case.question().is_some()));
        let all: Vec<String> = first.iter().map(Case::name).collect();
        assert_eq!(format!("{:016x}", fingerprint(&all.join("\n"))), "bb923792b223849b");
        let old = |case: &Case| !case.drive.is_moving() && case.effects != ["sensor_clock_drift"];
        let old: Vec<String> = first.iter().filter(|case| old(case)).map(Case::name).collect();
        assert_eq!(old.len(), 301);
        assert_eq!(format!("{:016x}", fingerprint(&old.join("\n"))), "5d1cd47880136401");
        let moving: Vec<String> =
            first.iter().filter(|case| case.drive.is_moving()).map(Case::name).collect();
        assert!(moving.len() == 58 && moving.iter().all(|name| name.contains("-moving")));
        // Those of one kind stand together.
        assert!(first.is_sorted_by_key(|case| case.kind));
    }

    #[test]
    fn every_case_can_be_drawn_and_hides_what_it_says() {
        for case in sealed() {
            let drawn = case.draw().unwrap();
            let told = |hidden: &Hidden| match hidden.law {
                None => hidden.id.clone(),
                Some(law) => format!("{}:{}", hidden.id, law.name),
            };
            let hidden: Vec<String> = drawn.hidden().iter().map(told).collect();
            assert_eq!(hidden, case.effects, "{}", case.name());
        }
    }
}
