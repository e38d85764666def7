//! Whether a dataset has what a model needs to be compared with it.

use std::path::PathBuf;

use stickslip::data::{Channel, Dataset, Record, Regime};
use stickslip::model::{Beam, Model, Oscillator, PinnedBeam, Structure};

use crate::error::{Excerpt, InputError, Problem};

/// Checks that every record has the columns that a comparison with `model` needs.
///
/// A contact needs `displacement` and `force`; a beam needs `excitation` and at least one measured motion
/// at a position on the beam (`acceleration:x=0.55`), or a backbone table; an oscillator needs `excitation` at
/// one or several masses (`excitation:m1`) and the motion of at least one mass (`displacement:m2`), or a backbone table.
/// A record of unknown start may lack the excitation: it is a free decay.
///
/// # Errors
/// The first record that lacks a column, has one that does not fit the model or is compared but never changes, or has a
/// regime the model cannot have. The path is the record's name as the dataset writes it.
pub fn check_columns(dataset: &Dataset, model: &Model) -> Result<(), InputError> {
    for record in &dataset.records {
        let problem = match &model.structure {
            Structure::Prescribed => contact_problem(record),
            Structure::Beam(beam) | Structure::PinRig(PinnedBeam { beam, .. }) => beam_problem(record, beam),
            Structure::Oscillator(oscillator) => oscillator_problem(record, oscillator),
        };
        let problem = problem.or_else(|| constant_problem(record, model));
        if let Some(problem) = problem {
            // The header is not at hand any more, but it is the first line.
            let header = Excerpt { line: 1, column: 1, text: String::new(), span: 0..0 };
            return Err(InputError {
                path: PathBuf::from(&record.name),
                excerpt: Some(header),
                problem: Box::new(problem),
            });
        }
    }
    Ok(())
}

fn missing(column: &str, reason: &str) -> Option<Problem> {
    Some(Problem::MissingColumn { column: column.to_owned(), reason: reason.to_owned() })
}

fn contact_problem(record: &Record) -> Option<Problem> {
    if record.regime.is_table() {
        let message = "a backbone or stepped-sine table is measured on a structure, but the model's kind is \"contact\"";
        return Some(Problem::UnsuitableRegime(message.to_owned()));
    }
    if record.channel("displacement").is_none() {
        return missing("displacement [m]", "it drives a model of kind \"contact\"");
    }
    if record.channel("force").is_none() {
        return missing(
            "force [N]",
            "a model of kind \"contact\" is compared with the measured contact force",
        );
    }
    None
}

fn beam_problem(record: &Record, beam: &Beam) -> Option<Problem> {
    if record.regime == Regime::Backbone {
        // Its two columns were checked when it was read.
        let placed = record.channels_of("amplitude").find(|channel| channel.name != "amplitude")?;
        return unsuitable_motion(placed, beam);
    }
    if record.channel("excitation").is_none() && !decays(record) {
        return missing("excitation [N]", "it drives a model of kind \"beam\"");
    }
    let motions = motions(record);
    if motions.is_empty() {
        let reason = "a model of kind \"beam\" is compared with the motion measured at a position";
        return missing("acceleration:x=... [m/s^2]", reason);
    }
    motions.into_iter().find_map(|channel| unsuitable_motion(channel, beam))
}

/// Whether a record of a structure may be a free decay.
fn decays(record: &Record) -> bool {
    record.regime == Regime::UnknownInitialState && record.channels_of("excitation").next().is_none()
}

/// The measured motions of a structure.
fn motions(record: &Record) -> Vec<&Channel> {
    let quantities = ["acceleration", "velocity", "displacement", "phase"];
    quantities.iter().flat_map(|quantity| record.channels_of(quantity)).collect()
}

fn oscillator_problem(record: &Record, oscillator: &Oscillator) -> Option<Problem> {
    if record.regime == Regime::Backbone {
        let amplitudes = record.channels_of("amplitude").filter(|channel| channel.name != "amplitude");
        return stray_mass(amplitudes, oscillator);
    }
    let excitations: Vec<&Channel> = record.channels_of("excitation").collect();
    if excitations.is_empty() && !decays(record) {
        let excited = oscillator.masses.get(oscillator.excitation).map_or("", |mass| mass.name.as_str());
        return missing(&format!("excitation:{excited} [N]"), "it drives the model");
    }
    let motions = motions(record);
    if motions.is_empty() {
        let reason = "a model of kind \"oscillator\" is compared with the motion of a mass";
        return missing("displacement:... [m]", reason);
    }
    stray_mass(excitations.into_iter().chain(motions), oscillator)
}

/// The first of `channels` that is at no mass of the model.
fn stray_mass<'r>(
    channels: impl IntoIterator<Item = &'r Channel>,
    oscillator: &Oscillator,
) -> Option<Problem> {
    let mut names = oscillator.masses.iter().map(|mass| mass.name.as_str());
    let stray = channels.into_iter().find(|channel| {
        let place = channel.name.split_once(':').map_or("", |(_, place)| place);
        !names.clone().any(|name| name == place)
    })?;
    let reason = match names.by_ref().take(6).map(|name| format!("`:{name}`")).collect::<Vec<_>>() {
        listed if names.next().is_some() => format!("the model's masses are {}, …", listed.join(", ")),
        listed => format!("the model's masses are {}", listed.join(", ")),
    };
    Some(Problem::UnsuitableColumn { column: stray.name.clone(), reason })
}

/// Errors are measured by how much a channel varies.
fn constant_problem(record: &Record, model: &Model) -> Option<Problem> {
    let mut compared = match &model.structure {
        _ if record.regime == Regime::Backbone => record.channels_of("frequency").collect(),
        Structure::Prescribed => record.channels_of("force").collect(),
        _ => motions(record),
    }
    .into_iter();
    let constant = compared.find(|channel| channel.values.windows(2).all(|pair| pair[0] == pair[1]))?;
    let reason = match constant.values.len() {
        1 => "one row shows no change, by which errors are measured: give two or more",
        _ => "it is the same number throughout: there is nothing to compare",
    };
    Some(Problem::UnsuitableColumn { column: constant.name.clone(), reason: reason.to_owned() })
}

fn unsuitable_motion(channel: &Channel, beam: &Beam) -> Option<Problem> {
    let reason = match channel.position() {
        None => format!("say where on the beam it was measured: `{}:x=0.55 [...]`", channel.quantity()),
        Some(position) if !(0.0..=beam.length).contains(&position) => {
            format!("the beam runs from 0 to {} m", beam.length)
        }
        Some(_) => return None,
    };
    Some(Problem::UnsuitableColumn { column: channel.name.clone(), reason })
}
