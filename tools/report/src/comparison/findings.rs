//! What is wrong with the measurements before anything is fitted, in sentences and as JSON.

use serde_json::{Value, json};
use stickslip::fit::checks::Finding;

/// One sentence for each kind of fault in each channel: what many records share is said once, with the first of them.
///
/// ```
/// use stickslip::fit::checks::{Fault, Finding};
/// let of = |record: &str| Finding {
///     record: Some(record.into()),
///     channel: Some("force".into()),
///     fault: Fault::Quantisation { fraction: 0.1 },
/// };
/// let said = stickslip_report::findings(&[of("a.csv"), of("b.csv"), of("c.csv")]);
/// assert!(said.len() == 1 && said[0].starts_with("a.csv: `force`: ") && said[0].ends_with("(and in 2 more records)."));
/// ```
pub fn findings(found: &[Finding]) -> Vec<String> {
    let like = |a: &Finding, b: &Finding| a.channel == b.channel && a.fault.id() == b.fault.id();
    let first = |(place, one): &(usize, &Finding)| !found[..*place].iter().any(|before| like(before, one));
    let said = found.iter().enumerate().filter(first).map(|(_, one)| {
        let more = found.iter().filter(|other| like(one, other)).count() - 1;
        match more {
            0 => format!("{one}."),
            1 => format!("{one} (and in 1 more record)."),
            _ => format!("{one} (and in {more} more records)."),
        }
    });
    said.collect()
}

/// What a verdict begins with where something was found: what follows is worth no more than the data and the model are.
pub(crate) fn before_all(found: &[Finding]) -> String {
    let kinds = findings(found).len();
    let Some(first) = found.first() else { return String::new() };
    let of = first.channel.as_ref().map(|channel| format!(" of `{channel}`")).unwrap_or_default();
    let what = format!("{}{of}", first.fault.id().replace('-', " "));
    match kinds {
        1 => format!("Look at this first: {what}, see below. "),
        2 => format!("Look at this first: {what} and one thing more, see below. "),
        _ => format!("Look at this first: {what} and {} things more, see below. ", kinds - 1),
    }
}

/// Every finding with its place.
pub(crate) fn to_json(found: &[Finding]) -> Vec<Value> {
    let one = |one: &Finding| json!({ "file": one.record, "channel": one.channel, "fault": one.fault.id(), "message": one.to_string() });
    found.iter().map(one).collect()
}
