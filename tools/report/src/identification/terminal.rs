//! An identification as text for a terminal.

use super::IdentificationReport;
use crate::document::{Block, Document, Section, Table};
use crate::format::printable;
use crate::table::{BOLD, RED, Text};

/// The result, the page's tables and what could not be identified, in lines of at most `width` columns (at least 40 are
/// used). With `color`, ANSI sequences are added.
pub fn identification_table(report: &IdentificationReport, width: usize, color: bool) -> String {
    document_table(&report.document(), width, color)
}

/// As [`identification_table`], of any such document.
pub(crate) fn document_table(document: &Document, width: usize, color: bool) -> String {
    let mut out = Text::new(width, color);
    out.paragraph(&document.title, BOLD);
    out.paragraph(&document.lead, "");
    for warning in &document.warnings {
        out.paragraph(warning, RED);
    }
    let has_text = |section: &&Section| {
        !section.blocks.iter().all(|block| matches!(block, Block::Plots(_) | Block::Note(_)))
    };
    for section in document.sections.iter().filter(has_text) {
        out.line("");
        out.paragraph(&section.title, BOLD);
        for block in &section.blocks {
            match block {
                Block::Table(table) => grid(&mut out, table),
                Block::Text(text) => out.paragraph(&format!("- {text}"), ""),
                Block::Warning(text) => out.paragraph(text, RED),
                Block::Note(_) | Block::Plots(_) => {}
            }
        }
    }
    out.finish()
}

fn grid(out: &mut Text, table: &Table) {
    let shown =
        table.rows.iter().map(|row| row.iter().map(|cell| printable(&cell.shown())).collect::<Vec<_>>());
    let rows = std::iter::once(table.heading.clone()).chain(shown);
    let (left, cells): (Vec<String>, Vec<Vec<String>>) = rows
        .filter(|row| !row.is_empty())
        .map(|mut row| {
            let cells = row.split_off(1);
            (row.remove(0), cells)
        })
        .unzip();
    out.grid(&left, &cells, 0);
}
