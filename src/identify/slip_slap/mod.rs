//! Both forces of a contact that slips and slaps, from dual-mode records: no law of the contact is assumed.
//!
//! In come a [`PinRig`] and steady records of the force that drives it and of the accelerations. Out goes, per record, the
//! contact over a period along and across the beam, with what the records do not tell (unidentified.rs), and how far the limit
//! of friction follows the normal force (coupling.rs), and what the loops show (loops.rs). Receptances are inverted as on the beam with one direction; the
//! published way stands beside it (published.rs), with a warning where it cannot be trusted.
//!
//! Source: "Identifying slip-slap forces in the contact interface using dual-mode excitation".

mod coupling;
mod loops;
mod published;
mod unidentified;

use super::identification::{
    IdentifyOptions, ModeCount, Unidentified, check_interrupt, gives, likeliest, nothing_usable, unexplained,
};
use super::inversion::invert_until;
use super::steady::{Steady, amplitude, steady};
use super::{ContactPeriod, Doubts, IdentificationError, Inversion, SteadyMotion, WIDE};
use crate::data::{Dataset, Record, Regime};
use crate::numeric::fourier::value;
use crate::system::{Damping, ModalPinRig, PinRig};
pub use coupling::Coupling;
pub use loops::LoopSlopes;
pub use published::{NonlinearMode, PublishedSlipSlap};

/// Phases of a period at which extremes are looked for.
const PHASES: usize = 1024;

/// Changes of Young's modulus and of the assumed normal stiffness by which it is told what hangs on them.
const MODULUS: f64 = 1e-3;
const STIFFNESS: f64 = 1e-2;

/// Places of the beam whose motions tell both forces and both displacements.
const PLACES: usize = 3;

/// The contact in one dual-mode record; its periods are those of the inversion at the same place.
#[derive(Debug, Clone, PartialEq)]
pub struct SlipSlapRecord {
    /// Name of the record.
    pub name: String,
    /// Frequency of the first harmonic (Hz).
    pub frequency: f64,
    /// Amplitudes of the first and third harmonic of the acceleration at the excitation (m/s²).
    pub accelerations: [f64; 2],
    /// And of the excitation (N).
    pub forces: [f64; 2],
    /// Lowest and highest force N_c (N) that presses the pin on its support; below zero the pin would part from it.
    pub normal_force: [f64; 2],
    /// Half-widths of the 95 % intervals of the tangential and the normal force (N), root mean square over the period, means left
    /// out.
    pub force_intervals: [f64; 2],
    /// Of the tangential and the normal displacement (m).
    pub displacement_intervals: [f64; 2],
    /// Reversals of the tangential and the normal displacement in a period: two of a simple loop, and two more for each loop inside
    /// it. Two tones ω and 3ω alone turn six times at most: three loops.
    pub reversals: [usize; 2],
    /// How S answers to ξ along the loop.
    pub slopes: LoopSlopes,
    /// Slopes of N over η (N/m) where less presses than in the mean and where more does: to be read only where the normal
    /// displacement is identified.
    pub normal_slopes: [f64; 2],
    /// The same, if Young's modulus were 0.1 % larger.
    pub normal_slopes_by_modulus: [f64; 2],
    /// The published way, where the rig has the modes for it.
    pub published: Option<PublishedSlipSlap>,
}

/// All that dual-mode records tell of a contact in two directions.
#[derive(Debug, Clone, PartialEq)]
pub struct SlipSlapIdentification {
    /// The contact in every record, in the order of the dataset.
    pub records: Vec<SlipSlapRecord>,
    /// The measuring chain, and the contact along the beam (`periods`: S and ξ) and across it (`normal`: N and η). N is what the
    /// normal force lacks of the preload.
    pub inversion: Inversion,
    /// What presses the pin on its support at rest (N).
    pub preload: f64,
    /// Which modes it was inverted on, and why.
    pub rig: String,
    /// Changes of S, N, ξ and η, root mean square over their own, if Young's modulus were 0.1 % larger: the largest of the records.
    pub by_modulus: [f64; 4],
    /// The same, if the normal stiffness in place of the contact were 1 % larger: nothing but the shape of the modes changes.
    pub by_normal_stiffness: [f64; 4],
    /// How far the limit of friction follows the normal force; `None` where the tangential force shows no limit.
    pub coupling: Option<Coupling>,
    /// What the records do not tell, however exact the numbers look.
    pub unidentified: Vec<Unidentified>,
    /// Records that were not used, with the reason.
    pub skipped: Vec<(String, String)>,
    /// What a reader must know beside the results.
    pub warnings: Vec<String>,
}

/// Identifies both forces at the contact of `rig` from the steady records of `dataset`.
///
/// The springs in place of the contact, `stuck_stiffness`, are taken off: they shape the modes and say how these are damped, and
/// play no other part. The normal load of the options, or the weight of the hanging mass, presses the pin on its support at rest;
/// the records fitted to are not read.
///
/// # Errors
/// No record that can be used, a rig without modes, forces that do not settle, an interrupt.
pub fn identify_slip_slap(
    rig: &PinRig,
    dataset: &Dataset,
    options: &IdentifyOptions,
) -> Result<SlipSlapIdentification, IdentificationError> {
    let (records, others): (Vec<&Record>, Vec<&Record>) =
        dataset.records.iter().partition(|record| record.regime == Regime::Steady);
    let other = |record: &&Record| (record.name.clone(), "its regime is not `steady`".to_owned());
    let mut skipped: Vec<(String, String)> = others.iter().map(other).collect();
    let mut used = steady(rig.beam.excitation_position, &[], &records, options.harmonics, &mut skipped);
    used.retain(|record| {
        let places = record.positions.len();
        if places < PLACES {
            let reason = format!(
                "it has motions at {places} of the {PLACES} places that forces and displacements of a contact in two directions take"
            );
            skipped.push((record.name.clone(), reason));
        }
        places >= PLACES
    });
    if used.is_empty() {
        return Err(nothing_usable(&skipped));
    }
    let (words, inversion) = inverted(rig, &used, options)?;
    let by = |change: &dyn Fn(&mut PinRig)| -> Result<Inversion, IdentificationError> {
        let mut changed = rig.clone();
        change(&mut changed);
        Ok(inverted(&changed, &used, options)?.1)
    };
    let stiffer = by(&|rig| rig.beam.youngs_modulus *= 1.0 + MODULUS)?;
    let by_normal_stiffness = changes(&inversion, &by(&|rig| rig.stuck_stiffness[1] *= 1.0 + STIFFNESS)?);
    let preload = preload_of(rig, options);
    let periods = inversion.periods.iter().zip(&inversion.normal).zip(loops::slopes(&inversion.periods));
    let found = used.iter().zip(periods).zip(&stiffer.normal);
    let found = found.map(|((record, ((along, across), slopes)), stiffer)| SlipSlapRecord {
        normal_slopes_by_modulus: loops::normal_slopes(stiffer),
        ..told((rig, preload), record, [along, across], slopes)
    });
    let records: Vec<SlipSlapRecord> = found.collect();
    check_interrupt(options)?;
    let mut identification = SlipSlapIdentification {
        warnings: warnings(&records, &inversion),
        records,
        coupling: coupling::coupling(&inversion.periods, &inversion.normal, preload),
        preload,
        rig: words,
        by_modulus: changes(&inversion, &stiffer),
        by_normal_stiffness,
        unidentified: Vec::new(),
        skipped,
        inversion,
    };
    identification.unidentified = unidentified::unidentified(&identification);
    Ok(identification)
}

/// What presses the pin on its support at rest (N).
fn preload_of(rig: &PinRig, options: &IdentifyOptions) -> f64 {
    options.normal_load.unwrap_or_else(|| rig.preload())
}

/// The inversion on the likeliest modes, and words on them.
fn inverted(
    rig: &PinRig,
    records: &[Steady],
    options: &IdentifyOptions,
) -> Result<(String, Inversion), IdentificationError> {
    let doubts = Doubts {
        excitation_gain: options.excitation_gain,
        sensor_gain: options.sensor_gain,
        sensor_mass: options.sensor_mass,
        force: preload_of(rig, options),
    };
    let motions: Vec<SteadyMotion> = records.iter().map(|record| record.motion.clone()).collect();
    let harmonics = motions[0].excitation.len() / 2;
    let interrupted = || options.interrupt.is_some_and(|asked| asked());
    let own = rig.beam.modes;
    let counts = match options.modes {
        ModeCount::Fixed(modes) => vec![modes],
        ModeCount::Model => vec![own],
        ModeCount::Likelier(modes) => vec![modes, own],
    };
    let mut tried = Vec::new();
    let words: Vec<String> = counts.iter().map(|modes| format!("{modes} modes")).collect();
    for (modes, words) in counts.into_iter().zip(&words) {
        let modal = modal(rig, modes, &records[0].positions)?;
        let inversion = invert_until(&(&modal).into(), &motions, harmonics, &doubts, &interrupted);
        tried.push((words.as_str(), inversion));
        check_interrupt(options)?;
    }
    let (_, words, inversion) = likeliest(tried);
    Ok((words, inversion?))
}

/// The rig in so many modes, read at `positions` (m).
fn modal(rig: &PinRig, modes: usize, positions: &[f64]) -> Result<ModalPinRig, IdentificationError> {
    let mut rig = rig.clone();
    rig.beam.modes = modes;
    rig.beam.sensors = positions.to_vec();
    if let Damping::PerMode(ratios) = &mut rig.beam.damping {
        let last = ratios.last().copied().unwrap_or(0.0);
        ratios.resize(modes, last);
    }
    ModalPinRig::new(&rig).map_err(|error| IdentificationError::Failed(error.to_string()))
}

/// What is told of one record.
fn told(
    (rig, preload): (&PinRig, f64),
    record: &Steady,
    periods: [&ContactPeriod; 2],
    slopes: LoopSlopes,
) -> SlipSlapRecord {
    let both = |coefficients: &[f64]| [1, 3].map(|harmonic| amplitude(coefficients, harmonic));
    let [low, high] = range(&periods[1].force);
    let deviations = periods.map(ContactPeriod::deviations);
    let wide = |place: usize| deviations.map(|deviation| WIDE * deviation[place]);
    SlipSlapRecord {
        name: record.name.clone(),
        frequency: record.frequency,
        accelerations: both(&record.motion.accelerations[record.nearest]),
        forces: both(&record.motion.excitation),
        normal_force: [preload - high, preload - low],
        force_intervals: wide(0),
        displacement_intervals: wide(1),
        reversals: periods.map(|period| reversals(&period.velocity)),
        slopes,
        normal_slopes: loops::normal_slopes(periods[1]),
        normal_slopes_by_modulus: [f64::NAN; 2],
        published: published::published(rig, record, periods).ok(),
    }
}

impl SlipSlapRecord {
    /// Loops that the hysteresis along and across the beam consists of: a large one, and those within it.
    pub fn loops(&self) -> [usize; 2] {
        self.reversals.map(|reversals| reversals / 2)
    }

    /// By which part the normal force is stiffer where more presses than in the mean than where less does; and if Young's modulus
    /// were 0.1 % larger.
    pub fn hardening(&self) -> [f64; 2] {
        [self.normal_slopes, self.normal_slopes_by_modulus].map(|[less, more]| more / less - 1.0)
    }
}

/// What does not fit, what gives energy, and where the published way cannot be trusted.
fn warnings(records: &[SlipSlapRecord], inversion: &Inversion) -> Vec<String> {
    let gives = |directions: &[ContactPeriod], words: &str| {
        let one = |(record, period): (&SlipSlapRecord, &ContactPeriod)| {
            Some(format!("{}, {words} the beam: {}.", record.name, gives(period)?))
        };
        records.iter().zip(directions).filter_map(one).collect::<Vec<String>>()
    };
    let mut all: Vec<String> = unexplained(inversion).into_iter().collect();
    all.extend(gives(&inversion.periods, "along"));
    all.extend(gives(&inversion.normal, "across"));
    if records.len() == 1 {
        all.push("One level alone: nothing tells gains of the measuring chain from the forces.".to_owned());
    }
    all.extend(records.iter().filter_map(distrust));
    all
}

/// Why the published way cannot be trusted in a record.
fn distrust(record: &SlipSlapRecord) -> Option<String> {
    let published = record.published.as_ref().filter(|published| !published.trusted())?;
    let ratio = published.modes.iter().map(|mode| mode.normal_ratio.abs()).fold(f64::INFINITY, f64::min);
    Some(format!(
        "{}: do not trust the published way: its nonlinear modes move the contact across the beam by {:.2} % of their largest \
         deflection, too little to see a normal force by (its forces differ from the inverted ones by {:.0} % along and {:.0} % across \
         the beam).",
        record.name,
        100.0 * ratio,
        100.0 * published.difference[0],
        100.0 * published.difference[1]
    ))
}

/// Changes of S, N, ξ and η from one inversion to another, over their own: the largest of the records.
fn changes(from: &Inversion, to: &Inversion) -> [f64; 4] {
    let change = |a: &[f64], b: &[f64]| {
        let square = |values: &mut dyn Iterator<Item = f64>| values.skip(1).map(|x| x * x).sum::<f64>();
        (square(&mut a.iter().zip(b).map(|(a, b)| a - b)) / square(&mut a.iter().copied())).sqrt()
    };
    let mut most = [0.0_f64; 4];
    for (place, (from, to)) in
        [(&from.periods, &to.periods), (&from.normal, &to.normal)].into_iter().enumerate()
    {
        for (from, to) in from.iter().zip(to) {
            most[place] = most[place].max(change(&from.force, &to.force));
            most[place + 2] = most[place + 2].max(change(&from.displacement, &to.displacement));
        }
    }
    most
}

/// How often the motion turns in a period.
fn reversals(velocity: &[f64]) -> usize {
    let runs = |k: usize| value(velocity, std::f64::consts::TAU * k as f64 / PHASES as f64) > 0.0;
    (0..PHASES).filter(|k| runs(*k) != runs(k + 1)).count()
}

/// Lowest and highest value over a period.
fn range(coefficients: &[f64]) -> [f64; 2] {
    let at = |k: usize| value(coefficients, std::f64::consts::TAU * k as f64 / PHASES as f64);
    (0..PHASES).map(at).fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| [low.min(x), high.max(x)])
}
