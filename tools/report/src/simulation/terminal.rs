//! A simulation as text for a terminal.

use super::{Simulation, fraction};
use crate::format;
use crate::table::{BOLD, RED, Text};

/// What happened, the steps, the energy residual of each power connection, and notes, in lines of at most `width`
/// columns (at least 40 are used). With `color`, ANSI sequences are added.
pub fn simulation_table(simulation: &Simulation, width: usize, color: bool) -> String {
    let mut out = Text::new(width, color);
    out.paragraph(&simulation.title, BOLD);
    let seconds = format::significant(simulation.seconds, 2);
    out.paragraph(&format!("{}, {seconds} s of computing", simulation.lead()), "");
    for warning in simulation.warnings() {
        out.paragraph(&warning, RED);
    }
    out.paragraph(&simulation.scope(), "");
    steps(&mut out, simulation);
    energy(&mut out, simulation);
    for note in simulation.all_notes() {
        out.paragraph(&format!("note: {note}"), "");
    }
    out.finish()
}

fn steps(out: &mut Text, simulation: &Simulation) {
    let report = &simulation.report;
    out.line("");
    let mut row = vec![("steps", report.steps.to_string()), ("rejected", report.rejected.to_string())];
    if report.evaluations > 0 {
        row.push(("evaluations", report.evaluations.to_string()));
        row.push(("per step", format::significant(simulation.evaluations(), 3)));
    }
    row.push(("seconds", format::significant(simulation.seconds, 3)));
    let (heading, row): (Vec<_>, Vec<_>) =
        row.into_iter().map(|(name, cell)| (name.to_owned(), cell)).unzip();
    let cells = [heading, row];
    out.grid(&[String::new(), "run".to_owned()], &cells, 0);
}

fn energy(out: &mut Text, simulation: &Simulation) {
    let connections = &simulation.report.energy;
    if connections.is_empty() {
        return;
    }
    out.line("");
    out.paragraph("Energy residual of each power connection", BOLD);
    let mut left = vec!["force on".to_owned()];
    let mut cells = vec![["sum", "magnitude", "exchanged", "fraction"].map(str::to_owned).to_vec()];
    for one in connections {
        left.push(format::printable(&one.force));
        cells.push(vec![
            format::engineering(one.sum, "J"),
            format::engineering(one.magnitude, "J"),
            format::engineering(one.exchanged, "J"),
            percent(fraction(one.sum, one.exchanged)),
        ]);
    }
    out.grid(&left, &cells, 0);
    out.paragraph("a positive sum is energy that the coupling added, a negative one energy that it removed. It does not show \
         whether the step is short enough for the FMUs themselves: halve the step and compare", "");
}

/// Two significant digits.
pub(super) fn percent(fraction: f64) -> String {
    if fraction.is_finite() {
        format!("{} %", format::fixed(100.0 * fraction, 2))
    } else {
        format::ABSENT.to_owned()
    }
}
