//! A simulated system for people and programs: page, terminal table, JSON.

mod json;
mod page;
mod terminal;

pub use json::simulation_json;
pub use page::simulation_html;
pub use terminal::simulation_table;

use stickslip::cosim::{Report, Unwatched};

use crate::format;

/// What a simulation came to.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Simulation {
    /// Name of the system.
    pub title: String,
    /// The algorithm in a few words.
    pub algorithm: String,
    /// Start and stop (s).
    pub span: (f64, f64),
    /// Communication step (s), the first one where it is adapted.
    pub step: f64,
    /// Communication points (s).
    pub time: Vec<f64>,
    /// What was recorded, a value for each point.
    pub columns: Vec<Column>,
    /// Sum of the energy residuals of each power connection (J) for each point, in the order of the report's.
    pub energy: Vec<Vec<f64>>,
    /// The master's report.
    pub report: Report,
    /// Notes on the system besides the master's.
    pub notes: Vec<String>,
    /// Why it ended early, if it did.
    pub failure: Option<String>,
    /// Time it took (s).
    pub seconds: f64,
}

/// A variable over time.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Column {
    /// `component.variable`.
    pub name: String,
    /// Its unit, as its component writes it.
    pub unit: Option<String>,
    /// Its values.
    pub values: Vec<f64>,
}

impl Column {
    /// As in the header of a table: `beam.displacement [m]`.
    pub fn heading(&self) -> String {
        match self.unit.as_deref() {
            None | Some("") => format!("{} [1]", self.name),
            Some(unit) => format!("{} [{unit}]", self.name),
        }
    }
}

impl Simulation {
    /// The result in one sentence.
    fn lead(&self) -> String {
        let steps = format::count(usize::try_from(self.report.steps).unwrap_or(usize::MAX), "step");
        let reached = format::engineering(self.report.time, "s");
        let how = if self.failure.is_some() {
            "ended early at"
        } else if self.report.interrupted {
            "interrupted at"
        } else {
            "simulated to"
        };
        format!("{how} {reached} in {steps}")
    }

    /// What a reader must know.
    fn warnings(&self) -> Vec<String> {
        let mut warnings: Vec<String> = self.failure.iter().cloned().collect();
        if self.report.interrupted {
            warnings.push("Interrupted: these are the results so far.".to_owned());
        }
        if self.report.unconverged > 0 {
            let first = self.report.examples.first().map_or_else(String::new, |one| {
                format!("; the first at {} ({})", format::engineering(one.time, "s"), one.slave)
            });
            warnings.push(format!(
                "{} of {} steps did not converge{first}.",
                self.report.unconverged, self.report.steps
            ));
        }
        warnings.extend(self.report.unwatched.iter().filter(|one| one.is_unresolved()).map(unresolved));
        if self.report.forced > 0 {
            warnings.push(format!(
                "{} steps were accepted beyond their tolerance: they could not be shorter.",
                self.report.forced
            ));
        }
        warnings
    }

    /// The algorithm and its step.
    fn scope(&self) -> String {
        let step = format::engineering(self.step, "s");
        let (start, stop) = (format::engineering(self.span.0, "s"), format::engineering(self.span.1, "s"));
        format!("{}, communication step {step}, from {start} to {stop}", self.algorithm)
    }

    /// Repetitions per step.
    fn evaluations(&self) -> f64 {
        self.report.evaluations as f64 / (self.report.steps + self.report.rejected).max(1) as f64
    }

    /// All notes, the system's first.
    fn all_notes(&self) -> impl Iterator<Item = String> {
        let told = self.notes.iter().chain(&self.report.notes).cloned();
        told.chain(self.report.unwatched.iter().map(not_watched))
    }
}

/// That nobody would see a coupling explode by its energy, and what to do about it.
fn not_watched(coupling: &Unwatched) -> String {
    let [one, other] = coupling.slaves.each_ref().map(|name| format::printable(name));
    let reason = if coupling.units {
        "their units do not tell which force and motion belong together"
    } else {
        "not all of their variables have units"
    };
    format!(
        "the energy of the coupling of {one} and {other} is not watched: {reason}; if they exchange power, give --power FORCE=MOTION, \
         the inputs that take them"
    )
}

/// That a coupling cannot be right, seen without its energy.
fn unresolved(coupling: &Unwatched) -> String {
    let [one, other] = coupling.slaves.each_ref().map(|name| format::printable(name));
    format!(
        "The steps are too long for the coupling of {one} and {other}, or it explodes: at their ends, {} was given values that \
         are off by {:.0} % of its standard deviation. Try a shorter step, or repeat each step until the values agree \
         (strong coupling).",
        format::printable(&coupling.input),
        100.0 * coupling.mismatch
    )
}

/// What part `residual` is of what was exchanged.
fn fraction(residual: f64, exchanged: f64) -> f64 {
    if exchanged > 0.0 { residual.abs() / exchanged } else { f64::NAN }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Settings;
    use stickslip::cosim::EnergyResidual;

    fn simulation() -> Simulation {
        let energy = EnergyResidual {
            force: "beam.contact_force".to_owned(),
            motion: "contact.displacement".to_owned(),
            sum: 1e-6,
            magnitude: 2e-6,
            largest: 1e-7,
            exchanged: 1e-2,
            last: 0.0,
        };
        let unwatched = Unwatched {
            slaves: ["motor", "load"].map(str::to_owned),
            units: false,
            input: "load.speed".to_owned(),
            mismatch: 1.37,
        };
        let column = |name: &str, unit: Option<&str>| Column {
            name: name.to_owned(),
            unit: unit.map(str::to_owned),
            values: vec![0.0, 1.0, f64::NAN],
        };
        Simulation {
            title: "<Beam> & contact".to_owned(),
            algorithm: "strong coupling".to_owned(),
            span: (0.0, 0.2),
            step: 1e-3,
            time: vec![0.0, 0.001, 0.002],
            columns: vec![
                column("beam.displacement", Some("m")),
                column("contact.slip_state", None),
                column("x.y", Some("furlong")),
            ],
            energy: vec![vec![0.0, 1e-6, 1e-6]],
            report: Report {
                time: 0.002,
                steps: 2,
                evaluations: 7,
                energy: vec![energy],
                unwatched: vec![unwatched],
                ..Report::default()
            },
            notes: vec!["a note".to_owned()],
            failure: Some("at 0.002 s: contact: lost".to_owned()),
            seconds: 0.1,
        }
    }

    #[test]
    fn all_three_say_what_happened() {
        let one = simulation();
        let table = simulation_table(&one, 80, false);
        for text in ["contact: lost", "3.5", "beam.contact_force", "a note", "0.010 %"] {
            assert!(table.contains(text), "{text} in\n{table}");
        }
        let page = simulation_html(&one, &Settings::default());
        for text in ["&lt;Beam&gt; &amp; contact", "contact: lost", "furlong", "a note"] {
            assert!(page.contains(text), "{text}");
        }
        let json = simulation_json(&one);
        assert_eq!(json["columns"][1]["values"][1], 1.0);
        assert_eq!(json["columns"][1]["values"][2], serde_json::Value::Null);
        assert_eq!(json["energy"][0]["sum"], 1e-6);
        assert_eq!(json["failure"], "at 0.002 s: contact: lost");
    }

    #[test]
    fn all_three_say_which_couplings_are_not_watched() {
        let one = simulation();
        let joined = |text: String| text.split_whitespace().collect::<Vec<_>>().join(" ");
        let table = joined(simulation_table(&one, 80, false));
        let page = joined(simulation_html(&one, &Settings::default()));
        for text in [
            "coupling of motor and load is not watched: not all of their variables have units",
            "--power",
            "load.speed",
            "137 %",
        ] {
            assert!(table.contains(text) && page.contains(text), "{text} in\n{table}");
        }
        let json = simulation_json(&one);
        assert!(
            json["notes"][1].as_str().is_some_and(|note| note.contains("is not watched")),
            "{}",
            json["notes"]
        );
        assert_eq!(
            (&json["unwatched"][0]["slaves"][1], &json["unwatched"][0]["mismatch"]),
            (&"load".into(), &1.37.into())
        );
    }

    #[test]
    fn a_short_step_is_no_warning() {
        let mut one = simulation();
        one.report.unwatched[0].mismatch = 0.1;
        assert!(!simulation_table(&one, 80, false).contains("load.speed"));
    }

    #[test]
    fn the_page_does_not_hold_how_long_it_took() {
        let (one, longer) = (simulation(), Simulation { seconds: 12.0, ..simulation() });
        let page = |run: &Simulation| simulation_html(run, &Settings::default());
        assert_eq!(page(&one), page(&longer));
        assert!(simulation_table(&longer, 80, false).contains("12 s of computing"));
    }

    #[test]
    fn headings_have_units() {
        let headings: Vec<String> = simulation().columns.iter().map(Column::heading).collect();
        assert_eq!(headings, ["beam.displacement [m]", "contact.slip_state [1]", "x.y [furlong]"]);
    }
}
