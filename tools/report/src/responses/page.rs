//! The page of response curves.

use super::{Responses, ending, figures, trust};
use crate::document::{Block, Cell, Document, Section, Table, document_html};
use crate::{Settings, format};

/// One self-contained HTML page of the curves: peaks, responses, contacts, errors.
pub fn responses_html(responses: &Responses, settings: &Settings) -> String {
    document_html(&document(responses), settings)
}

fn document(responses: &Responses) -> Document {
    let mut sections = vec![Section {
        id: "peaks".into(),
        title: if responses.held.is_some() { "Resonances".into() } else { "Peaks".into() },
        blocks: [
            Some(peak_table(responses)),
            responses.held_note().filter(|_| responses.point_count() > 0).map(Block::Note),
            fold_table(responses),
        ]
        .into_iter()
        .flatten()
        .collect(),
    }];
    let mut section = |id: &str, title: &str, blocks: Vec<Block>| {
        let some = blocks.iter().any(|block| !matches!(block, Block::Plots(plots) if plots.is_empty()));
        if some {
            sections.push(Section { id: id.into(), title: title.into(), blocks });
        }
    };
    if responses.point_count() > 0 {
        if responses.held.is_some() {
            section("force", "Force that holds the response", vec![Block::Plots(figures::force(responses))]);
        }
        section("response", "Response", vec![Block::Plots(figures::amplitudes(responses))]);
        section("contact", "Contact", vec![Block::Plots(figures::contact(responses))]);
        section(
            "structure",
            "The structure’s own nonlinearities",
            vec![Block::Plots(figures::structure(responses))],
        );
        section("loops", "Loops at the peaks", vec![Block::Plots(figures::loops(responses))]);
        section(
            "error",
            "Truncation error",
            vec![Block::Plots(figures::errors(responses)), error_note(responses)],
        );
    }
    section("curves", "Curves", vec![curve_table(responses)]);
    Document {
        title: responses.title.clone(),
        lead: responses.lead(),
        warnings: responses.warnings(),
        scope: responses.scope(),
        sections,
    }
}

/// Every peak of every node at every level.
fn peak_table(responses: &Responses) -> Block {
    let held = responses.held.as_ref();
    let peaks = responses.curves.iter().flat_map(|one| &one.curve.peaks);
    let amplitude = format::Scale::of(peaks.map(|peak| peak.amplitude), "m");
    let mut heading = vec![
        "Node".to_owned(),
        format!("Frequency ({})", responses.unit.name()),
        amplitude.label("Amplitude"),
        if held.is_some() { "Held".to_owned() } else { "Force".to_owned() },
    ];
    if let Some(held) = held {
        heading
            .extend(["Force".to_owned(), format!("Response over force ({}/N)", format::unit(held.unit()))]);
    }
    heading.push("Error estimate".to_owned());
    let mut rows = Vec::new();
    for one in &responses.curves {
        for peak in &one.curve.peaks {
            let mut row = vec![
                Cell::text(one.curve.nodes.get(peak.node).map_or("", String::as_str)),
                Cell::Number(responses.unit.of(peak.angular_frequency), 6),
                Cell::Number(amplitude.factor * peak.amplitude, 6),
                Cell::text(responses.level(one)),
            ];
            if held.is_some() {
                row.push(Cell::text(format::engineering(peak.level, "N")));
                row.push(Cell::Number(one.level / peak.level, 3));
            }
            let estimate = trust::at_peak(one, peak);
            row.push(match trust::is_unresolved(one, peak) {
                true => Cell::Marked(format!("{estimate}, unresolved")),
                false => Cell::text(estimate),
            });
            rows.push(row);
        }
    }
    if rows.is_empty() {
        return Block::Note(responses.no_peak());
    }
    Block::Table(Table { label: "Peaks".into(), heading, rows })
}

/// Where curves turn back; nothing where none does.
fn fold_table(responses: &Responses) -> Option<Block> {
    let rows = responses.curves.iter().flat_map(|one| {
        one.curve.folds.iter().map(|fold| {
            let moved = fold.amplitude.iter().map(|value| Cell::text(format::engineering(*value, "m")));
            [Cell::text(responses.level(one)), Cell::Number(responses.unit.of(fold.angular_frequency), 6)]
                .into_iter()
                .chain(moved)
                .collect::<Vec<_>>()
        })
    });
    let rows: Vec<_> = rows.collect();
    let heading = ["Turning point at".to_owned(), format!("Frequency ({})", responses.unit.name())];
    let nodes = responses.nodes().iter().map(|node| format!("Amplitude of {node}"));
    let heading = heading.into_iter().chain(nodes).collect();
    (!rows.is_empty()).then(|| Block::Table(Table { label: "Turning points".into(), heading, rows }))
}

/// How well each curve was found.
fn curve_table(responses: &Responses) -> Block {
    let heading =
        ["Level", "Points", "Harmonics", "Largest error estimate", "Unresolved", "Unstable", "Ended"];
    let rows = responses.curves.iter().map(|one| {
        let points = &one.curve.points;
        let harmonics = points.iter().map(|point| point.harmonics);
        let span = match (harmonics.clone().min(), harmonics.max()) {
            (Some(low), Some(high)) if low != high => format!("{low}–{high}"),
            (Some(low), _) => low.to_string(),
            _ => format::ABSENT.to_owned(),
        };
        let unstable = match (responses.stability, points.is_empty()) {
            (true, false) => Cell::text(trust::unstable(points)),
            (true, true) => Cell::text(format::ABSENT),
            (false, _) => Cell::text("not requested"),
        };
        let ended = match ending(one) {
            "complete" => Cell::text("complete"),
            other => Cell::Marked(other.to_owned()),
        };
        vec![
            Cell::text(responses.level(one)),
            Cell::Count(points.len()),
            Cell::text(span),
            Cell::text(match points.is_empty() {
                true => format::ABSENT.to_owned(),
                false => trust::shown(trust::worst(points.iter())),
            }),
            Cell::text(trust::unresolved(points)),
            unstable,
            ended,
        ]
    });
    Block::Table(Table {
        label: "Curves".into(),
        heading: heading.map(str::to_owned).to_vec(),
        rows: rows.collect(),
    })
}

fn error_note(responses: &Responses) -> Block {
    if trust::count(responses.points()).1 == responses.point_count() {
        return Block::Note("For this kind of structure the truncation error is unknown.".into());
    }
    let tolerance = responses.tolerance.map_or_else(
        || {
            format!(
                "Every point has {} harmonics. A point whose estimate is above {} counts as unresolved.",
                responses.harmonics,
                crate::document::scientific(responses.limit())
            )
        },
        |tolerance| {
            format!(
                "Harmonics are added until the estimate is below {}; a point where that does not come about \
                 counts as unresolved.",
                crate::document::scientific(tolerance)
            )
        },
    );
    Block::Note(format!(
        "The estimate is of what the harmonics left out would change in the displacements, as fraction of the amplitude. \
         {tolerance}"
    ))
}
