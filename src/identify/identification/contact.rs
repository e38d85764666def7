//! The contact in all steady records: receptances inverted, and the published way beside it.

use super::published::{Published, published};
use super::{Identification, IdentifyOptions, Setup, check_interrupt};
use crate::identify::inversion::invert_until;
use crate::identify::steady::Steady;
use crate::identify::{ContactPeriod, Doubts, IdentificationError, Inversion, SteadyMotion, WIDE};
use crate::system::{Beam, ModalBeam};

/// Accelerations left unexplained, over what noise lets expect and as a part of the measured ones, that call for a warning.
const MISFIT: f64 = 2.0;
const UNEXPLAINED: f64 = 2e-3;
/// What remains with a beam that explains the records clearly better than another, over what remains with that.
const CLEARLY: f64 = 0.97;

/// The contact in one steady record; its period is that of the inversion at the same place.
#[derive(Debug, Clone, PartialEq)]
pub struct ContactRecord {
    /// Name of the record.
    pub name: String,
    /// Frequency of the excitation (Hz).
    pub frequency: f64,
    /// Amplitude of the acceleration at the excitation (m/s²), first harmonic.
    pub amplitude: f64,
    /// Amplitude of the excitation (N), first harmonic.
    pub force: f64,
    /// Harmonics that stand out of the noise in some channel.
    pub harmonics: usize,
    /// Half-widths of the 95 % intervals of force (N), displacement (m) and velocity (m/s), root mean square over the period,
    /// means left out.
    pub intervals: [f64; 3],
    /// The published way, where the beam can have this frequency.
    pub published: Option<Published>,
    /// What to know beside it.
    pub warnings: Vec<String>,
}

/// Inverts `steady` and fills in what it tells.
pub(super) fn identify_contact(
    setup: &Setup,
    steady: &[Steady],
    options: &IdentifyOptions,
    found: &mut Identification,
) -> Result<(), IdentificationError> {
    let doubts = Doubts {
        excitation_gain: options.excitation_gain,
        sensor_gain: options.sensor_gain,
        sensor_mass: options.sensor_mass,
        // A mean force is bounded by friction.
        force: setup.normal_load,
    };
    let (inversion, steady) = inverted(setup, steady, &doubts, options, found)?;
    let Some(inversion) = inversion else { return Ok(()) };
    for (record, period) in steady.iter().zip(&inversion.periods) {
        found.records.push(ContactRecord {
            name: record.name.clone(),
            frequency: record.frequency,
            amplitude: record.amplitude,
            force: record.force(),
            harmonics: record.shown,
            intervals: period.deviations().map(|deviation| WIDE * deviation),
            published: published(setup, record, period),
            warnings: gives(period).into_iter().collect(),
        });
    }
    found.warnings.extend(unexplained(&inversion));
    if steady.len() == 1 {
        found.warnings.push(
            "One level alone: nothing tells gains of the measuring chain from the force, and no prediction can be checked."
                .to_owned(),
        );
    }
    found.inversion = Some(inversion);
    Ok(())
}

/// That the model of the beam does not fit the accelerations.
pub(in crate::identify) fn unexplained(inversion: &Inversion) -> Option<String> {
    let most = inversion.periods.iter().map(|period| period.unexplained).fold(0.0, f64::max);
    (inversion.misfit > MISFIT && most > UNEXPLAINED).then(|| {
        format!(
            "No force at the contact explains {:.2} % of the accelerations, {:.1} times what noise does: the beam’s model \
             does not fit, and what is found has errors that no interval shows.",
            100.0 * most,
            inversion.misfit
        )
    })
}

/// The inversion of as many of `steady` as can be inverted together, and which they are; the others are told in `found`.
fn inverted<'s>(
    setup: &Setup,
    steady: &'s [Steady],
    doubts: &Doubts,
    options: &IdentifyOptions,
    found: &mut Identification,
) -> Result<(Option<Inversion>, Vec<&'s Steady>), IdentificationError> {
    let mut kept: Vec<&Steady> = steady.iter().collect();
    while !kept.is_empty() {
        let reason = match together(setup, &kept, doubts, options, found) {
            Ok(inversion) => return Ok((Some(inversion), kept)),
            Err(reason) => reason,
        };
        check_interrupt(options)?;
        // Those that cannot be inverted alone go, with their reasons; if all can, the one that moves most.
        let mut alone = |record: &&Steady| together(setup, &[*record], doubts, options, found).err();
        let mut failed: Vec<Option<IdentificationError>> = kept.iter().map(&mut alone).collect();
        check_interrupt(options)?;
        if failed.iter().all(Option::is_none) {
            let amplitude = |k: &usize| kept[*k].amplitude;
            let most = (0..kept.len()).max_by(|a, b| amplitude(a).total_cmp(&amplitude(b)));
            most.into_iter().for_each(|most| failed[most] = Some(reason.clone()));
        }
        for (record, reason) in kept.iter().zip(&failed) {
            let Some(IdentificationError::Failed(reason)) = reason else { continue };
            found.warnings.push(format!("{} could not be inverted: {reason}.", record.name));
            found.skipped.push((record.name.clone(), reason.clone()));
        }
        let mut place = failed.iter();
        kept.retain(|_| place.next().is_some_and(Option::is_none));
    }
    Ok((None, kept))
}

/// The inversion of all `records` on the likeliest of the beams.
fn together(
    setup: &Setup,
    records: &[&Steady],
    doubts: &Doubts,
    options: &IdentifyOptions,
    found: &mut Identification,
) -> Result<Inversion, IdentificationError> {
    let motions: Vec<SteadyMotion> = records.iter().map(|record| record.motion.clone()).collect();
    let harmonics = motions[0].excitation.len() / 2;
    let interrupted = || options.interrupt.is_some_and(|asked| asked());
    let mut tried = Vec::new();
    for (words, beam) in &setup.beams {
        let beam = Beam { sensors: records[0].positions.clone(), ..beam.clone() };
        let modal = ModalBeam::with_changes(&beam, &setup.changes)
            .map_err(|error| IdentificationError::Failed(error.to_string()))?;
        let inversion = invert_until(&(&modal).into(), &motions, harmonics, doubts, &interrupted);
        tried.push((words.as_str(), inversion));
        check_interrupt(options)?;
    }
    let (best, words, inversion) = likeliest(tried);
    (found.beam, found.static_correction) = (words, setup.beams[best].1.static_correction);
    inversion
}

/// The inversion that leaves least, the first one if none is clearly better: its place, and words on the beam.
pub(in crate::identify) fn likeliest(
    mut tried: Vec<(&str, Result<Inversion, IdentificationError>)>,
) -> (usize, String, Result<Inversion, IdentificationError>) {
    let misfit = |result: &Result<Inversion, _>| result.as_ref().map_or(f64::INFINITY, |one| one.misfit);
    let told: Vec<String> =
        tried.iter().map(|(words, result)| format!("{:.3} with {words}", misfit(result))).collect();
    let best = (1..tried.len())
        .fold(0, |best, k| if misfit(&tried[k].1) < CLEARLY * misfit(&tried[best].1) { k } else { best });
    let words = format!(
        "The beam has {}. What remains of the accelerations, over what their errors let expect: {}.",
        tried[best].0,
        told.join(", ")
    );
    (best, words, tried.swap_remove(best).1)
}

/// That a contact which can only take energy gives it.
pub(in crate::identify) fn gives(period: &ContactPeriod) -> Option<String> {
    let given = period.given()?;
    Some(format!(
        "the contact gives {given:.2e} J a period: phases of the channels do not fit, or the sign of one is reversed"
    ))
}
