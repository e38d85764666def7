//! The page in HTML.

use maud::{Markup, html};

use super::{Block, Cell, Document, Plot, Section, Table};
use crate::Settings;
use crate::comparison::stages::name;
use crate::figure::{Captioned, Figures};
use crate::page::{Shell, figure_element, settings_section};

/// One self-contained HTML page; see [`crate::html`] for what that means.
pub fn document_html(document: &Document, settings: &Settings) -> String {
    let mut figures = Figures::default();
    let sections = html! {
        @for one in &document.sections { (section(&mut figures, one)) }
        (settings_section(settings))
    };
    Shell {
        title: &document.title,
        badge: None,
        verdict: &document.lead,
        warnings: &document.warnings,
        scope: &document.scope,
        sections,
        figures: &figures,
    }
    .page(settings)
}

/// One section of a page.
pub(crate) fn section(figures: &mut Figures, section: &Section) -> Markup {
    html! {
        section id=(section.id) {
            h2 { (name(&section.title)) }
            @for one in &section.blocks { (block(figures, one)) }
        }
    }
}

fn block(figures: &mut Figures, block: &Block) -> Markup {
    match block {
        Block::Text(text) => html! { p.text { (name(text)) } },
        Block::Note(text) => html! { p.note { (name(text)) } },
        Block::Warning(text) => html! { p.warning { (name(text)) } },
        Block::Table(one) => table(one),
        Block::Plots(plots) => html! {
            div.figures { @for plot in plots { (drawn(figures, plot)) } }
        },
    }
}

fn drawn(figures: &mut Figures, plot: &Plot) -> Markup {
    let (figure, height) = plot.draw(figures);
    let one = Captioned { figure, caption: plot.caption.clone(), half: plot.half };
    figure_element(&one, &format!("height:{height}px"))
}

fn table(table: &Table) -> Markup {
    // A column is right-aligned where its cells are numbers.
    let number = |column: usize| table.rows.iter().filter_map(|row| row.get(column)).any(Cell::is_number);
    html! {
        div.scroll tabindex="0" role="region" aria-label=(name(&table.label)) {
            table.data {
                thead { tr { @for (column, heading) in table.heading.iter().enumerate() {
                    th.number[number(column)] { (name(heading)) }
                } } }
                tbody { @for row in &table.rows { tr {
                    @for (column, cell) in row.iter().enumerate() {
                        @if column == 0 && !cell.is_number() {
                            th scope="row" { (name(&cell.shown())) }
                        } @else {
                            td.number[number(column)].failed[matches!(cell, Cell::Marked(_))] {
                                (name(&cell.shown()))
                            }
                        }
                    }
                } } }
            }
        }
    }
}
