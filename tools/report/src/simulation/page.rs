//! The page of a simulation.

use super::terminal::percent;
use super::{Column, Simulation, fraction};
use crate::document::{
    Axis, Block, Cell, Document, Line, Panel, Plot, Section, Stroke, Table, document_html, palette,
};
use crate::{Settings, format};

/// One self-contained HTML page: what happened, energy residuals, every recorded variable over time.
pub fn simulation_html(simulation: &Simulation, settings: &Settings) -> String {
    document_html(&document(simulation), settings)
}

fn document(simulation: &Simulation) -> Document {
    let mut sections = vec![section("run", "Run", vec![run_table(simulation)])];
    if !simulation.report.energy.is_empty() {
        let blocks = vec![energy_table(simulation), Block::Plots(energy_plots(simulation))];
        sections.push(section("energy", "Energy residual of each power connection", blocks));
    }
    if !simulation.time.is_empty() {
        sections.push(section("outputs", "Time histories", vec![Block::Plots(histories(simulation))]));
    }
    let notes: Vec<Block> = simulation.all_notes().map(Block::Note).collect();
    if !notes.is_empty() {
        sections.push(section("notes", "Notes", notes));
    }
    Document {
        title: simulation.title.clone(),
        lead: simulation.lead(),
        warnings: simulation.warnings(),
        scope: simulation.scope(),
        sections,
    }
}

fn section(id: &str, title: &str, blocks: Vec<Block>) -> Section {
    Section { id: id.to_owned(), title: title.to_owned(), blocks }
}

fn count(number: u64) -> Cell {
    Cell::Count(usize::try_from(number).unwrap_or(usize::MAX))
}

fn run_table(simulation: &Simulation) -> Block {
    let report = &simulation.report;
    let mut row = vec![
        ("Algorithm", Cell::text(&simulation.algorithm)),
        ("Steps", count(report.steps)),
        ("Rejected", count(report.rejected)),
    ];
    // An explicit algorithm repeats nothing.
    if report.evaluations > 0 {
        row.push(("Evaluations", count(report.evaluations)));
        row.push(("Per step", Cell::Number(simulation.evaluations(), 2)));
    }
    let (heading, row) = row.into_iter().map(|(name, cell)| (name.to_owned(), cell)).unzip();
    Block::Table(Table { label: "Steps of the run".to_owned(), heading, rows: vec![row] })
}

fn energy_table(simulation: &Simulation) -> Block {
    let heading = ["Force on", "Motion of", "Sum (J)", "Magnitude (J)", "Exchanged (J)", "Fraction"];
    let rows = simulation.report.energy.iter().map(|one| {
        vec![
            Cell::text(format::printable(&one.force)),
            Cell::text(format::printable(&one.motion)),
            Cell::Scientific(one.sum),
            Cell::Scientific(one.magnitude),
            Cell::Scientific(one.exchanged),
            Cell::text(percent(fraction(one.sum, one.exchanged))),
        ]
    });
    Block::Table(Table {
        label: "Energy residuals".to_owned(),
        heading: heading.map(str::to_owned).to_vec(),
        rows: rows.collect(),
    })
}

fn energy_plots(simulation: &Simulation) -> Vec<Plot> {
    let count = simulation.energy.len();
    let lines = simulation.report.energy.iter().zip(&simulation.energy).enumerate();
    let lines: Vec<Line> = lines
        .map(|(index, (one, history))| Line {
            name: format::printable(&one.force),
            x: simulation.time.clone(),
            y: history.clone(),
            stroke: Stroke::solid(palette(index, count)),
        })
        .collect();
    vec![Plot {
        caption: "Energy that the coupling added (positive) or removed (negative) since the start."
            .to_owned(),
        half: false,
        x: Axis::new("time", "s"),
        panels: vec![Panel { y: Axis::new("energy residual", "J"), lines }],
    }]
}

/// Units that axes scale by prefixes.
const UNITS: [&str; 12] = ["m", "m/s", "m/s^2", "N", "N/m", "J", "W", "Pa", "s", "N.m", "rad", "rad/s"];

/// Lines in one plot at most.
const TOGETHER: usize = 6;

/// A plot for the variables of each unit.
fn histories(simulation: &Simulation) -> Vec<Plot> {
    let mut groups: Vec<(&str, Vec<&Column>)> = Vec::new();
    for column in &simulation.columns {
        let unit = column.unit.as_deref().unwrap_or("1");
        match groups.iter_mut().find(|(other, columns)| *other == unit && columns.len() < TOGETHER) {
            Some((_, columns)) => columns.push(column),
            None => groups.push((unit, vec![column])),
        }
    }
    groups.iter().map(|(unit, columns)| history(simulation, unit, columns)).collect()
}

fn history(simulation: &Simulation, unit: &str, columns: &[&Column]) -> Plot {
    // Axes know their units when the program is built; of others only the name is shown.
    let y = match UNITS.iter().find(|known| **known == unit) {
        Some(known) => Axis::new("value", known),
        None if unit == "1" => Axis::new("value", "1"),
        None => Axis::new(format!("value ({})", format::printable(unit)), "1"),
    };
    let line = |(index, column): (usize, &&Column)| Line {
        name: format::printable(&column.name),
        x: simulation.time.clone(),
        y: column.values.clone(),
        stroke: Stroke::solid(palette(index, columns.len())),
    };
    let names: Vec<&str> = columns.iter().map(|column| column.name.as_str()).collect();
    Plot {
        caption: names.join(", "),
        half: false,
        x: Axis::new("time", "s"),
        panels: vec![Panel { y, lines: columns.iter().enumerate().map(line).collect() }],
    }
}
