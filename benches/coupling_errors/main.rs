//! Beam and contact coupled, against the same in one piece: errors over the communication step, written as tables
//! and a drawing to `benches/cosimulation.md` and `.svg` (or to the folder named on the command line).
//!
//! `main.rs`: the displacement of a beam over a wide range of steps; `shipped.rs`: every signal of the systems that ship,
//! coupled and in one piece; `drawing.rs`: errors over steps.

#[path = "../../tests/common/mod.rs"]
mod common;
mod drawing;
mod shipped;

use common::cosim::*;
use drawing::{Curve, Panel};
use std::fmt::Write as _;
use std::path::PathBuf;
use stickslip::cosim::{Algorithm, Method, Settings};

/// Slips within a few periods.
const SHAKER: Shaker = Shaker { amplitude: 60.0, omega: 324.0, growth: 0.02 };
/// Friction settles the motion within the second.
const STEADY: Shaker = Shaker { amplitude: 6.0, omega: 324.0, growth: 0.1 };
const STEPS: [f64; 10] = [1e-3, 5e-4, 2e-4, 1e-4, 5e-5, 2e-5, 1e-5, 5e-6, 2e-6, 1e-6];
const CONTACTS: [(&str, &str); 2] = [("ValanisContact", VALANIS), ("JenkinsContact", JENKINS)];

fn algorithms() -> [(&'static str, Algorithm); 5] {
    [
        ("Jacobi", JACOBI),
        ("Gauss–Seidel", GAUSS_SEIDEL),
        ("Jacobi, extrapolated", Algorithm::Jacobi { extrapolation: 1 }),
        ("Gauss–Seidel, extrapolated", Algorithm::GaussSeidel { extrapolation: 1, order: None }),
        ("strong", strong(Method::Anderson { depth: 5 })),
    ]
}

/// Errors, energy residuals and repetitions per step of one algorithm, for each of the steps.
struct Series {
    name: &'static str,
    errors: Vec<f64>,
    residuals: Vec<f64>,
    repetitions: Vec<f64>,
}

fn series(contact: &str, exact: &[[f64; 3]]) -> Vec<Series> {
    let size = exact.iter().map(|row| row[2].abs()).fold(0.0, f64::max);
    let stop = exact.last().map_or(0.0, |row| row[0]);
    let run = |(name, algorithm): (&'static str, Algorithm)| {
        let mut series = Series { name, errors: vec![], residuals: vec![], repetitions: vec![] };
        for step in STEPS {
            let settings =
                Settings { tolerance: Some(1e-10), ..Settings::new(algorithm.clone(), step, stop) };
            let Ok((rows, report)) = record(beam_with(contact, SHAKER), settings) else {
                series.errors.push(f64::NAN);
                series.residuals.push(f64::NAN);
                series.repetitions.push(f64::NAN);
                continue;
            };
            let every = (1e-3 / step).round() as usize;
            let pairs = rows.iter().step_by(every).zip(exact);
            let worst = pairs.map(|((_, values), exact)| (values[3] - exact[2]).abs()).fold(0.0, f64::max);
            series.errors.push(worst / size);
            series.residuals.push(report.energy[0].magnitude / report.energy[0].exchanged);
            series.repetitions.push(report.evaluations as f64 / report.steps as f64);
        }
        series
    };
    algorithms().into_iter().map(run).collect()
}

/// Order between the last two steps at which the error is well above that of the solution in one piece.
fn order(errors: &[f64]) -> f64 {
    let resolved = errors.iter().take_while(|error| **error > 1e-7).count().max(2);
    let (coarse, fine) = (resolved - 2, resolved - 1);
    (errors[coarse] / errors[fine]).ln() / (STEPS[coarse] / STEPS[fine]).ln()
}

fn table(text: &mut String, title: &str, series: &[Series], values: impl Fn(&Series) -> &Vec<f64>) {
    let _ = writeln!(
        text,
        "\n{title}\n\n| H (s) | {} |",
        series.iter().map(|s| s.name).collect::<Vec<_>>().join(" | ")
    );
    let _ = writeln!(text, "|---|{}", "---|".repeat(series.len()));
    for (index, step) in STEPS.iter().enumerate() {
        let cells: Vec<String> = series.iter().map(|s| format!("{:.1e}", values(s)[index])).collect();
        let _ = writeln!(text, "| {step:.0e} | {} |", cells.join(" | "));
    }
    let orders: Vec<String> = series.iter().map(|s| format!("{:.2}", order(values(s)))).collect();
    let _ = writeln!(text, "| order | {} |", orders.join(" | "));
}

fn steady(text: &mut String) {
    let (step, stop, from) = (1e-4, 1.0, 0.9);
    let names: Vec<&str> = algorithms().iter().map(|(name, _)| *name).collect();
    let _ = writeln!(text, "\n| contact | {} |\n|---|{}", names.join(" | "), "---|".repeat(names.len()));
    for (name, contact) in CONTACTS {
        let exact = monolithic(contact, STEADY, 1e-5, stop, 10);
        let exact = amplitude(exact.iter().filter(|row| row[0] >= from).map(|row| row[2]));
        let cells = algorithms().map(|(_, algorithm)| {
            let (rows, _) =
                record(beam_with(contact, STEADY), Settings::new(algorithm, step, stop)).expect("a run");
            let late = rows.iter().filter(|(time, _)| *time >= from);
            format!("{:+.3} %", 100.0 * (amplitude(late.map(|(_, values)| values[3])) / exact - 1.0))
        });
        let _ = writeln!(text, "| {name} | {} |", cells.join(" | "));
    }
}

fn main() -> std::io::Result<()> {
    // Cargo adds an option of its own.
    let folder = std::env::args()
        .skip(1)
        .find(|word| !word.starts_with("--"))
        .map_or_else(|| PathBuf::from("benches"), PathBuf::from);
    let mut text = String::from(
        "# Co-simulation against the monolithic beam\n\n\
         Written by `cargo xtask cosimulation`. ModalBeam and a contact, each a slave, under the library's masters; the\n\
         reference is the beam with the contact inside, integrated at 1e-6 s with a tolerance of 1e-10. The shaker's\n\
         force grows smoothly to 60 N at 324 rad/s; the contact slips from the second period on. Errors are the largest\n\
         of the displacement at the shaker over 0.1 s, relative to its largest value. \"Extrapolated\" is of first order\n\
         in time, by output derivatives or past values. The order stands for the finest two steps\n\
         whose errors are above 1e-7.\n\n\
         Laws with corners keep the second order over many steps: a corner or a reversal between two communication points is met\n\
         at a wrong instant by O(H), which is an error of the force of O(H) over a time of O(H). From one step to the next the order scatters,\n\
         as the places of the corners between the points do.\n\n\
         ![errors over the communication step](cosimulation.svg)\n",
    );
    let mut panels = Vec::new();
    for (name, contact) in CONTACTS {
        let exact = monolithic(contact, SHAKER, 1e-6, 0.1, 1000);
        let series = series(contact, &exact);
        let _ = writeln!(text, "\n## ModalBeam + {name}");
        table(&mut text, "Error of the displacement:", &series, |series| &series.errors);
        table(&mut text, "Energy residual over energy exchanged:", &series, |series| &series.residuals);
        let strong = &series[series.len() - 1];
        let cells: Vec<String> = strong.repetitions.iter().map(|count| format!("{count:.1}")).collect();
        let _ = writeln!(text, "\nRepetitions of a step under strong coupling: {}.", cells.join(", "));
        let curves = series.iter().map(|s| Curve::new(s.name, &STEPS, &s.errors)).collect();
        panels.push(Panel { title: format!("ModalBeam + {name}, displacement"), curves });
    }
    text.push_str(
        "\n## Steady amplitude at H = 1e-4 s\n\nDifference from the monolithic beam, 6 N at 324 rad/s:\n",
    );
    steady(&mut text);
    shipped::every_signal(&mut text, &mut panels);
    std::fs::write(folder.join("cosimulation.md"), text)?;
    std::fs::write(folder.join("cosimulation.svg"), drawing::page(&panels))
}
