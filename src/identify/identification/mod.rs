//! From a beam's model and its records to all that they tell of the contact: the stages in their order.
//!
//! - `levels`: resonance, damping and rotational stiffness at each amplitude (table 2 of the paper);
//! - `linear`: frequency responses and modes from records under random excitation (table 1);
//! - `contact`: the contact's force and motion in all steady records together; `published`: the published way beside it;
//! - `catalogue`: every law of the catalogue fitted at some levels and predicted at the others;
//! - `unidentified`: what the records do not tell, and why.

mod catalogue;
mod contact;
mod levels;
mod linear;
mod published;
#[cfg(test)]
mod resonance_tests;
#[cfg(test)]
mod tests;
mod unidentified;

use super::steady::steady;
use super::{IdentificationError, IdentifiedLaw, Inversion};
use crate::data::{Dataset, Record, Regime};
use crate::fit::InterruptHook;
use crate::fit::checks::check;
use crate::fit::tabulated;
use crate::model::{Beam, Contact, Model, Structure};
use crate::system::{Damping, StructureChanges};

pub use contact::ContactRecord;
pub(super) use contact::{gives, likeliest, unexplained};
pub use levels::{Level, LevelResponse, LevelSource};
pub use linear::LinearRecord;
pub use published::{AmplitudeMode, Published};
pub use unidentified::Unidentified;

/// What is taken for granted, and what is asked for.
#[derive(Clone)]
pub struct IdentifyOptions<'a> {
    /// Standard deviation of the load cell's gain beforehand (1).
    pub excitation_gain: f64,
    /// Of each sensor's gain (1).
    pub sensor_gain: f64,
    /// Of the mass at each sensor (kg).
    pub sensor_mass: f64,
    /// Modes of the beam.
    pub modes: ModeCount,
    /// Harmonics at most.
    pub harmonics: usize,
    /// Names of the records that laws are fitted to; the one with the largest motion of the contact if empty.
    pub fitted: Vec<String>,
    /// Normal load (N) where the model has no contact; of a pin rig in place of the weight of the hanging mass.
    pub normal_load: Option<f64>,
    /// Asked often; `true` ends the work.
    pub interrupt: Option<InterruptHook<'a>>,
}

impl Default for IdentifyOptions<'_> {
    fn default() -> Self {
        Self {
            excitation_gain: 0.01,
            sensor_gain: 0.01,
            sensor_mass: 0.0,
            modes: ModeCount::Likelier(30),
            harmonics: 15,
            fitted: Vec::new(),
            normal_load: None,
            interrupt: None,
        }
    }
}

/// How many modes of the beam move.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ModeCount {
    /// So many, the rest following statically.
    Fixed(usize),
    /// As many as the model says, and the rest as it says.
    Model,
    /// Whichever of the two leaves less of the accelerations.
    Likelier(usize),
}

/// All that records tell of a beam's contact.
#[derive(Debug, Clone, PartialEq)]
pub struct Identification {
    /// The contact in every steady record that was inverted, in the order of the dataset.
    pub records: Vec<ContactRecord>,
    /// The measuring chain and the contact's motion in these records; `None` without a steady record.
    pub inversion: Option<Inversion>,
    /// Which beam it was inverted on, and why; empty without one.
    pub beam: String,
    /// Whether modes that this beam lacks follow statically; so do those of the new model.
    pub static_correction: bool,
    /// Laws of the catalogue, in its order.
    pub laws: Vec<IdentifiedLaw>,
    /// Places in `records` of those that laws were fitted to.
    pub fitted: Vec<usize>,
    /// Laws that could not be fitted, with the reason.
    pub failed_laws: Vec<(&'static str, String)>,
    /// Place in `laws` of the one with the least error on records that it was not fitted to.
    pub best: Option<usize>,
    /// Where the best is the measured map: the largest motion about its middle (m) that it holds for.
    pub range: Option<f64>,
    /// The model with the best law.
    pub model: Option<Model>,
    /// Records under random excitation.
    pub linear: Vec<LinearRecord>,
    /// Resonances over the amplitude, the smallest first.
    pub levels: Vec<Level>,
    /// What the records do not tell.
    pub unidentified: Vec<Unidentified>,
    /// Records that were not used, with the reason.
    pub skipped: Vec<(String, String)>,
    /// What a reader must know beside the results.
    pub warnings: Vec<String>,
}

/// The beam without its contact, and what presses on it.
struct Setup {
    beam: Beam,
    /// What to choose the beam of the inversion from, with the words for it.
    beams: Vec<(String, Beam)>,
    changes: StructureChanges,
    normal_load: f64,
    warnings: Vec<String>,
}

/// Identifies the contact of `model`, a beam, from `dataset`.
///
/// A contact that the model has already gives the normal load alone; nothing of its law is assumed. Without a contact a
/// rotational spring of the support stands for it and is left out.
///
/// # Errors
/// A model that is no beam or has no normal load, records of which none can be used, names of records that are not there, an
/// interrupt.
pub fn identify(
    model: &Model,
    dataset: &Dataset,
    options: &IdentifyOptions,
) -> Result<Identification, IdentificationError> {
    let setup = Setup::new(model, options)?;
    let mut skipped = Vec::new();
    // A free decay tells resonances over the amplitude, as a table does.
    let (dataset, _) = tabulated(model, dataset);
    let of = |regime: fn(Regime) -> bool| dataset.records.iter().filter(move |r| regime(r.regime));
    let records: Vec<&Record> = of(|regime| regime == Regime::Steady).collect();
    let free = of(|regime| matches!(regime, Regime::FromRest | Regime::UnknownInitialState));
    let mut linear = Vec::new();
    for record in free {
        match linear::linear(&setup, record) {
            Ok(found) => linear.push(found),
            Err(reason) => skipped.push((record.name.clone(), reason)),
        }
        check_interrupt(options)?;
    }
    let (exciter, faults) = (setup.beam.excitation_position, model.changes().sensors);
    let all = steady(exciter, &faults, &records, options.harmonics, &mut skipped);
    let (mut levels, chosen) = levels::of_records(&setup, all, &mut skipped);
    levels.extend(linear.iter().filter_map(|record| levels::of_modes(&setup, record)));
    for record in of(|regime| regime == Regime::Backbone) {
        match levels::of_backbone(&setup, record) {
            Ok(found) => levels.extend(found),
            Err(reason) => skipped.push((record.name.clone(), reason)),
        }
    }
    levels.sort_by(|a, b| a.amplitude.total_cmp(&b.amplitude));
    if chosen.is_empty() && levels.is_empty() && linear.is_empty() {
        return Err(nothing_usable(&skipped));
    }
    let mut found = Identification {
        records: Vec::new(),
        inversion: None,
        beam: String::new(),
        static_correction: false,
        laws: Vec::new(),
        fitted: Vec::new(),
        failed_laws: Vec::new(),
        best: None,
        range: None,
        model: None,
        linear,
        levels,
        unidentified: Vec::new(),
        skipped,
        warnings: said_first(model, &dataset, &setup),
    };
    check_interrupt(options)?;
    if !chosen.is_empty() {
        contact::identify_contact(&setup, &chosen, options, &mut found)?;
        check_interrupt(options)?;
        catalogue::fit_laws(&setup, model, options, &mut found)?;
        found.unidentified = unidentified::unidentified(&found);
    } else {
        found.warnings.push(
            "There is no steady record of the contact: its force was not identified, only resonances."
                .to_owned(),
        );
    }
    Ok(found)
}

/// What is wrong with the measurements or the model before anything is identified, and what the model leaves out.
fn said_first(model: &Model, dataset: &Dataset, setup: &Setup) -> Vec<String> {
    let found = check(model, dataset).into_iter().map(|finding| finding.to_string());
    found.chain(setup.warnings.iter().cloned()).collect()
}

pub(super) fn check_interrupt(options: &IdentifyOptions) -> Result<(), IdentificationError> {
    match options.interrupt.is_some_and(|asked| asked()) {
        true => Err(IdentificationError::Failed("interrupted".to_owned())),
        false => Ok(()),
    }
}

pub(super) fn nothing_usable(skipped: &[(String, String)]) -> IdentificationError {
    let reasons: Vec<String> =
        skipped.iter().map(|(record, reason)| format!("\n  {record}: {reason}")).collect();
    let missing = match reasons.is_empty() {
        true => "the dataset has no record of the beam".to_owned(),
        false => format!("no record can be used{}", reasons.concat()),
    };
    IdentificationError::Failed(format!(
        "{missing}\nneeded are records of regime \"steady\" with `excitation [N]` and motions such as `acceleration:x=0.55 \
         [m/s^2]`, best at several levels; records under random excitation give the linear modes"
    ))
}

impl Setup {
    fn new(model: &Model, options: &IdentifyOptions) -> Result<Self, IdentificationError> {
        let fail = |message: &str| Err(IdentificationError::Failed(message.to_owned()));
        let Structure::Beam(beam) = &model.structure else {
            return fail("a contact is identified behind a beam: the model's kind must be \"beam\"");
        };
        let own = model.contact.map(|contact: Contact| contact.normal_load);
        let Some(normal_load) = options.normal_load.or(own).filter(|load| *load > 0.0) else {
            return fail(
                "the normal load is not known: write `[contact] normal_load`, or say it by --normal-load (N)",
            );
        };
        let mut warnings = Vec::new();
        let mut beam = beam.clone();
        if model.contact.is_none() && beam.rotational_stiffness > 0.0 {
            warnings.push(
                "The model's rotational spring at the support stands for the contact; it was left out."
                    .to_owned(),
            );
            beam.rotational_stiffness = 0.0;
        }
        let mut changes = model.changes().structure;
        if changes.cubic_stiffness != 0.0
            || changes.quadratic_damping != 0.0
            || !changes.hanging_masses.is_empty()
        {
            warnings.push(
                "Nonlinear effects of the model on its structure were left out: the identified force holds them.".to_owned(),
            );
            (changes.cubic_stiffness, changes.quadratic_damping) = (0.0, 0.0);
            changes.hanging_masses.clear();
        }
        let own = (format!("the {} modes of the model", beam.modes), beam.clone());
        let many = |modes: usize| {
            let mut beam = Beam { modes, static_correction: true, ..beam.clone() };
            if let Damping::PerMode(ratios) = &mut beam.damping {
                let last = ratios.last().copied().unwrap_or(0.0);
                ratios.resize(modes, last);
            }
            (format!("{modes} modes, the rest following statically"), beam)
        };
        let beams = match options.modes {
            ModeCount::Fixed(modes) => vec![many(modes)],
            ModeCount::Model => vec![own],
            ModeCount::Likelier(modes) => vec![many(modes), own],
        };
        Ok(Self { beam: beams[0].1.clone(), beams, changes, normal_load, warnings })
    }
}
