//! The smallest experiment that would decide between the explanations that remain.

use super::decision::TakenBack;
use super::explain::Explained;
use crate::diagnose::diagnosis::Verdict;
use crate::fit::residual::{Appearance, Hint};

const REPEAT: &str = "Repeat one record, or run it over several periods: ";

/// What to measure next, if anything.
pub(super) fn next(explained: &Explained) -> Option<String> {
    let Explained { context, decision, residual, .. } = explained;
    let known = context.data.noise_is_known();
    if context.table {
        return Some(
            "Measure the table again, so that its scatter is known, with levels between those where the frequency \
             changes most and with the damping ratio at each level; or record the acceleration in time at three levels \
             or more"
                .to_owned(),
        );
    }
    let fault = residual.hints.iter().find(|hint| hint.is_of_the_measurement()).map(of_hint);
    match decision.verdict {
        Verdict::NotDistinguishable => decision.groups.first().map(|group| group.experiment.clone()),
        Verdict::EffectFound if !known => {
            Some(format!("{REPEAT}only then is it known how much of the residual is noise"))
        }
        Verdict::EffectFound => None,
        Verdict::NothingMissing => fault,
        Verdict::InsufficientData if fault.is_some() => fault,
        Verdict::Unexplained => Some(of_residual(residual)),
        Verdict::InsufficientData if !known => Some(format!("{REPEAT}the difference of the repeats is the noise")),
        Verdict::InsufficientData if decision.taken_back == Some(TakenBack::Unseen) => Some(
            "Measure longer, or with less noise, and at a level and a frequency beyond those there are: what is not seen \
             now is then either found or smaller than matters"
                .to_owned(),
        ),
        Verdict::InsufficientData => Some(
            "Measure more records at levels and frequencies between those there are and a little beyond them".to_owned(),
        ),
    }
}

/// What the shape of the residual asks for.
fn of_residual(residual: &Appearance) -> String {
    if let Some(hint) = residual.hints.first() {
        return of_hint(hint);
    }
    let first = residual.shapes.iter().max_by(|a, b| a.fraction.total_cmp(&b.fraction));
    let words = match first.filter(|shape| shape.fraction > 0.0).map(|shape| shape.against) {
        Some("displacement") => {
            "Repeat one record about another middle position: a cause that is fixed in space keeps its place"
        }
        Some("velocity") => "Repeat one record with the same way at half and at twice its speed",
        Some("normal load") => "Repeat one record at half and at twice its normal load",
        Some("time in the record") => return of_drift(),
        _ => "Repeat the record in which the residual is largest at half and at twice its speed and level",
    };
    words.to_owned()
}

fn of_drift() -> String {
    "Repeat the first record at the end of the tests: where the two differ, something drifts or wears"
        .to_owned()
}

fn of_hint(hint: &Hint) -> String {
    match hint {
        Hint::Hum(line) => format!(
            "Look for a source of {:.1} Hz (the mains, a ground loop, a machine), remove it, and repeat one record",
            line.frequency
        ),
        Hint::Clipping { channel, .. } => {
            format!("Widen the range of `{}` and repeat the record with the largest values", channel.0)
        }
        Hint::DropOuts { channel, .. } => {
            format!("Check the cable and the connector of `{channel}` and repeat one record")
        }
        Hint::Drift { .. } | Hint::DriftOverRecords { .. } => of_drift(),
        Hint::Memory { .. } => {
            "Repeat a low level twice: right after a high one, and after a rest; where the two differ, the contact remembers"
                .to_owned()
        }
    }
}
