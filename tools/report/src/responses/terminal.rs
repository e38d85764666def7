//! Response curves as text for a terminal.

use super::{Responses, ending, trust};
use crate::format;
use crate::table::{BOLD, RED, Text};

/// Peaks shown at most; the files hold all.
const PEAKS: usize = 40;

/// Result, warnings, peaks and how well each curve was found, in lines of at most `width` columns (at
/// least 40 are used). With `color`, ANSI sequences are added.
pub fn responses_table(responses: &Responses, width: usize, color: bool) -> String {
    let mut out = Text::new(width, color);
    out.paragraph(&responses.title, BOLD);
    out.paragraph(&responses.lead(), "");
    for warning in responses.warnings() {
        out.paragraph(&warning, RED);
    }
    let took = format::engineering(responses.seconds, "s");
    out.paragraph(&format!("{} Computed in {took}.", responses.scope()), "");
    peaks(&mut out, responses);
    if let Some(note) = responses.held_note().filter(|_| responses.point_count() > 0) {
        out.paragraph(&note, "");
    }
    curves(&mut out, responses);
    out.finish()
}

fn peaks(out: &mut Text, responses: &Responses) {
    let all: Vec<_> =
        responses.curves.iter().flat_map(|one| one.curve.peaks.iter().map(move |peak| (one, peak))).collect();
    if all.is_empty() {
        return;
    }
    out.line("");
    let heading = match &responses.held {
        Some(held) => format!("Peaks of {} over force", held.name()),
        None => "Peaks".to_owned(),
    };
    out.paragraph(&heading, BOLD);
    let mut left = vec!["node".to_owned()];
    let level = if responses.held.is_some() { "held" } else { "force" };
    let mut first = vec![format!("frequency ({})", responses.unit.name()), "amplitude".into(), level.into()];
    if responses.held.is_some() {
        first.push("force".into());
    }
    first.push("error".into());
    let mut cells = vec![first];
    for (one, peak) in all.iter().take(PEAKS) {
        left.push(format::printable(one.curve.nodes.get(peak.node).map_or("", String::as_str)));
        let mut row = vec![
            format::fixed(responses.unit.of(peak.angular_frequency), 7),
            format::engineering(peak.amplitude, "m"),
            responses.level(one),
        ];
        if responses.held.is_some() {
            row.push(format::engineering(peak.level, "N"));
        }
        let mark = if trust::is_unresolved(one, peak) { " !" } else { "" };
        row.push(trust::at_peak(one, peak) + mark);
        cells.push(row);
    }
    out.grid(&left, &cells, 0);
    if all.len() > PEAKS {
        out.paragraph(&format!("and {} more", all.len() - PEAKS), "");
    }
    if all.iter().any(|(one, peak)| trust::is_unresolved(one, peak)) {
        out.paragraph("! unresolved: too few harmonics to rely on this peak", "");
    }
}

fn curves(out: &mut Text, responses: &Responses) {
    out.line("");
    out.paragraph("Curves", BOLD);
    let mut left = vec![if responses.held.is_some() { "held".to_owned() } else { "force".to_owned() }];
    let heading = ["points", "error estimate", "unresolved", "unstable", "ended"];
    let mut cells = vec![heading.map(str::to_owned).to_vec()];
    for one in &responses.curves {
        let points = &one.curve.points;
        left.push(responses.level(one));
        let unstable = if responses.stability && !points.is_empty() {
            trust::unstable(points)
        } else {
            format::ABSENT.into()
        };
        cells.push(vec![
            points.len().to_string(),
            if points.is_empty() { format::ABSENT.into() } else { trust::shown(trust::worst(points.iter())) },
            trust::unresolved(points),
            unstable,
            ending(one).to_owned(),
        ]);
    }
    out.grid(&left, &cells, 0);
}
