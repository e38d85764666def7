//! What dual-mode records do not tell of a contact, and why.

use super::{STIFFNESS, SlipSlapIdentification};
use crate::identify::{Inversion, Unidentified, WIDE};

/// An interval wider than this part of the value tells no more than an order of magnitude.
const VAGUE: f64 = 0.5;
/// Relative change over that of the assumed normal stiffness that makes an echo of it.
const ECHO: f64 = 0.5;
/// Young's modulus is known to a tenth of a per cent at best: what that changes by more than this part is not told.
const HANGS: f64 = 0.2;

/// What may not be told, in the order of the changes, and what else goes with it.
const NAMES: [&str; 4] =
    ["tangential_force", "normal_force", "tangential_displacement", "normal_displacement"];

pub(super) fn unidentified(found: &SlipSlapIdentification) -> Vec<Unidentified> {
    let gives = gives(found);
    let vague = |(place, name): (usize, &&'static str)| {
        let reason = gives.clone().or_else(|| vague(found, place))?;
        Some(Unidentified { name, reason })
    };
    let mut out: Vec<Unidentified> = NAMES.iter().enumerate().filter_map(vague).collect();
    if out.iter().any(|one| one.name.starts_with("normal")) {
        out.push(Unidentified {
            name: "normal_stiffness",
            reason: "the slope of the normal force over the normal displacement is as uncertain as these are"
                .to_owned(),
        });
    }
    out.extend(hardening(found));
    out.extend(echo(found));
    out.extend(mean_force(found));
    out
}

/// Why nothing is told where the contact gives energy.
fn gives(found: &SlipSlapIdentification) -> Option<String> {
    let Inversion { periods, normal, .. } = &found.inversion;
    let giving =
        periods.iter().zip(normal).filter(|(along, across)| along.given().or(across.given()).is_some());
    let count = giving.count();
    (count > 0).then(|| {
        format!("the contact gives energy in {count} of {} records, which no contact does", periods.len())
    })
}

/// Why a force or displacement is not told, if it is not.
fn vague(found: &SlipSlapIdentification, place: usize) -> Option<String> {
    let periods = if place.is_multiple_of(2) { &found.inversion.periods } else { &found.inversion.normal };
    let size = |values: &[f64]| (0.5 * values[1..].iter().map(|x| x * x).sum::<f64>()).sqrt();
    let wide = periods.iter().map(|period| {
        let value = if place < 2 { &period.force } else { &period.displacement };
        WIDE * period.deviations()[place / 2] / size(value)
    });
    let wide = wide.fold(0.0, f64::max);
    let (modulus, stiffness) = (found.by_modulus[place], found.by_normal_stiffness[place]);
    (wide > VAGUE || modulus > HANGS || stiffness > ECHO * STIFFNESS).then(|| {
        format!(
            "its 95 % interval is ± {:.0} % of it; Young’s modulus 0.1 % larger changes it by {:.1} %, an assumed normal stiffness 1 % \
             larger by {:.2} %",
            100.0 * wide,
            100.0 * modulus,
            100.0 * stiffness
        )
    })
}

/// How the normal force hardens, where that hangs on what is assumed of the beam.
fn hardening(found: &SlipSlapIdentification) -> Option<Unidentified> {
    let all: Vec<[f64; 2]> = found.records.iter().map(super::SlipSlapRecord::hardening).collect();
    // Written so that what is no number is no answer.
    let told = |[here, there]: &[f64; 2]| (there - here).abs() <= HANGS * here.abs();
    if all.iter().all(told) {
        return None;
    }
    let ends = |place: usize| {
        let (low, high) = range(all.iter().map(|hardening| 100.0 * hardening[place]));
        format!("{low:.1} … {high:.1} %")
    };
    Some(Unidentified {
        name: "hardening",
        reason: format!(
            "the slope of the normal force is larger by {} where more presses than in the mean, and by {} if Young’s modulus were \
             0.1 % larger",
            ends(0),
            ends(1)
        ),
    })
}

fn range(values: impl Iterator<Item = f64>) -> (f64, f64) {
    values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)))
}

/// The published way's normal displacement, where it gives back the normal stiffness that was assumed.
fn echo(found: &SlipSlapIdentification) -> Option<Unidentified> {
    let published = found.records.iter().filter_map(|record| record.published.as_ref());
    let most = published.map(|published| published.echo).max_by(|a, b| a.abs().total_cmp(&b.abs()))?;
    (most.abs() > ECHO).then(|| Unidentified {
        name: "published_normal_displacement",
        reason: format!(
            "it changes by {most:.2} % where the assumed normal stiffness is 1 % larger: it gives that assumption back, and so does the \
             slope of the normal force over it"
        ),
    })
}

/// The mean of the tangential force, where its interval holds zero.
fn mean_force(found: &SlipSlapIdentification) -> Option<Unidentified> {
    let periods = &found.inversion.periods;
    let wide: Vec<f64> = periods.iter().map(|period| WIDE * period.covariance[(0, 0)].sqrt()).collect();
    let means = periods.iter().zip(&wide).filter(|(period, wide)| period.force[0].abs() < **wide).count();
    let widest = wide.iter().copied().fold(0.0, f64::max);
    (means > 0).then(|| Unidentified {
        name: "mean_force",
        reason: format!(
            "accelerometers show no mean, and what it does to the bending leaves zero in its interval in {means} of {} records \
             (± {widest:.1} N at most)",
            periods.len()
        ),
    })
}
