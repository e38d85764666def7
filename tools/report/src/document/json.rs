//! A page as data: every series and every number of its tables.

use serde_json::{Value, json};

use super::{Block, Cell, Document, Panel, Plot, Section, Table};

/// The page's numbers under `schema`, in SI units and at full precision.
///
/// ```json
/// {"schema": "...", "title": "...", "result": "...", "warnings": [],
///  "sections": [{"id": "...", "title": "...", "text": ["..."],
///    "tables": [{"label": "...", "heading": ["..."], "rows": [["...", 1.0]]}],
///    "figures": [{"caption": "...", "x": {"name": "...", "unit": "rad/s"},
///      "panels": [{"y": {"name": "...", "unit": "m"}, "series": [{"name": "...", "x": [], "y": []}]}]}]}]}
/// ```
///
/// Numbers that are not finite are `null`.
pub fn document_json(document: &Document, schema: &str) -> Value {
    json!({
        "schema": schema,
        "title": document.title,
        "result": plain(&document.lead),
        "warnings": document.warnings.iter().map(|text| plain(text)).collect::<Vec<_>>(),
        "sections": document.sections.iter().map(section).collect::<Vec<_>>(),
    })
}

fn section(section: &Section) -> Value {
    let text = section.blocks.iter().filter_map(|block| match block {
        Block::Text(text) | Block::Note(text) | Block::Warning(text) => Some(plain(text)),
        _ => None,
    });
    let tables = section.blocks.iter().filter_map(|block| match block {
        Block::Table(one) => Some(table(one)),
        _ => None,
    });
    let figures = section.blocks.iter().filter_map(|block| match block {
        Block::Plots(plots) => Some(plots.iter().map(figure)),
        _ => None,
    });
    json!({
        "id": section.id, "title": section.title, "text": text.collect::<Vec<_>>(),
        "tables": tables.collect::<Vec<_>>(), "figures": figures.flatten().collect::<Vec<_>>(),
    })
}

fn table(table: &Table) -> Value {
    let cell = |cell: &Cell| match cell {
        Cell::Text(text) | Cell::Marked(text) => json!(plain(text)),
        Cell::Number(value, _) | Cell::Scientific(value) => json!(value),
        Cell::Count(count) => json!(count),
    };
    let rows: Vec<Vec<Value>> = table.rows.iter().map(|row| row.iter().map(cell).collect()).collect();
    json!({ "label": table.label, "heading": table.heading, "rows": rows })
}

fn figure(plot: &Plot) -> Value {
    let panel = |panel: &Panel| {
        let series: Vec<Value> = panel
            .lines
            .iter()
            .map(|line| json!({ "name": line.name, "x": line.x, "y": line.y, "note": line.stroke.note }))
            .collect();
        json!({ "y": { "name": panel.y.name, "unit": panel.y.unit }, "series": series })
    };
    json!({
        "caption": plain(&plot.caption), "x": { "name": plot.x.name, "unit": plot.x.unit },
        "panels": plot.panels.iter().map(panel).collect::<Vec<_>>(),
    })
}

/// Without the spaces that keep a number and its unit together.
fn plain(text: &str) -> String {
    text.replace('\u{a0}', " ")
}
