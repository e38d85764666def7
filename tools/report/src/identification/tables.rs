//! The tables of an identification.

use stickslip::identify::{ContactPeriod, Inversion, LinearRecord};

use super::{IdentificationReport, name_of, samples, words};
use crate::document::{Block, Cell, Table};
use crate::format;

/// Steps of a period in which its largest values are looked for.
const STEPS: usize = 256;

impl IdentificationReport<'_> {
    /// Every law with its parameters.
    pub(super) fn parameter_table(&self) -> Table {
        let rows = self.found.laws.iter().enumerate().flat_map(|(k, law)| {
            let best = if self.found.best == Some(k) { " (best)" } else { "" };
            let name = format!("{}{best}", words::prose(name_of(law)));
            law.parameters.iter().map(move |one| {
                let [low, high] = one.interval.map(|end| match end.is_finite() {
                    true => format::engineering(end, one.unit),
                    false => format::ABSENT.to_owned(),
                });
                let value = format::engineering(one.value, one.unit);
                vec![
                    Cell::text(name.clone()),
                    Cell::text(words::prose(one.name)),
                    Cell::text(value),
                    Cell::text(low),
                    Cell::text(high),
                ]
            })
        });
        table("Parameters", &["Law", "Parameter", "Value", "From", "To"], rows.collect())
    }

    /// The error of every law on every record, in per cent.
    pub(super) fn error_table(&self) -> Table {
        let laws = self.found.laws.iter().map(|law| format!("{} (%)", words::prose(name_of(law))));
        let heading: Vec<String> = ["Record".to_owned(), String::new()].into_iter().chain(laws).collect();
        let rows = self.found.records.iter().enumerate().map(|(k, record)| {
            let how = if self.is_fitted(k) { "fitted" } else { "predicted" };
            let errors = self.found.laws.iter().map(|law| match law.errors[k] {
                Some(error) => Cell::Number(100.0 * error, 2),
                None => Cell::Marked("failed".to_owned()),
            });
            [Cell::text(record.name.clone()), Cell::text(how)].into_iter().chain(errors).collect()
        });
        Table { label: "Errors of the laws".into(), heading, rows: rows.collect() }
    }

    /// What was identified in each record.
    pub(super) fn record_table(&self) -> Table {
        let heading = [
            "Record",
            "a (m/s²)",
            "f (Hz)",
            "F (N)",
            "harmonics",
            "T (N)",
            "± (N)",
            "u (µm)",
            "± (µm)",
            "u̇ (mm/s)",
            "± (mm/s)",
        ];
        let rows = self.periods().map(|(record, period)| {
            let [u, v, force] = largest(period);
            vec![
                Cell::text(record.name.clone()),
                Cell::Number(record.amplitude, 2),
                Cell::Number(record.frequency, 4),
                Cell::Number(record.force, 3),
                Cell::Count(record.harmonics),
                Cell::Number(force, 2),
                Cell::Number(record.intervals[0], 2),
                Cell::Number(1e6 * u, 2),
                Cell::Number(1e6 * record.intervals[1], 2),
                Cell::Number(1e3 * v, 2),
                Cell::Number(1e3 * record.intervals[2], 2),
            ]
        });
        table("Contact in every record", &heading, rows.collect())
    }

    /// Gains and masses of the measuring chain.
    pub(super) fn chain(&self) -> Vec<Block> {
        self.found
            .inversion
            .as_ref()
            .map_or_else(Vec::new, |inversion| chain_blocks(inversion, &self.found.beam))
    }

    /// Table 2: frequency, damping and rotational stiffness over the amplitude.
    pub(super) fn level_table(&self) -> Table {
        let heading = ["a (m/s²)", "f1 (Hz)", "± (Hz)", "damping (%)", "a/F (1/kg)", "k_θ (N·m/rad)", "from"];
        let rows = self.found.levels.iter().map(|level| {
            let wide =
                level.frequency_interval.map_or(f64::NAN, |interval| 0.5 * (interval.high - interval.low));
            vec![
                Cell::Number(level.amplitude, 2),
                Cell::Number(level.frequency, 4),
                Cell::Number(wide, 4),
                Cell::Number(level.damping_ratio.map_or(f64::NAN, |ratio| 100.0 * ratio), 3),
                Cell::Number(level.peak.unwrap_or(f64::NAN), 3),
                match &level.rotational_stiffness {
                    Ok(stiffness) => Cell::Number(*stiffness, 2),
                    Err(_) => Cell::Marked("out of reach".to_owned()),
                },
                Cell::text(words::source(&level.source)),
            ]
        });
        table("Resonance over the amplitude", &heading, rows.collect())
    }

    /// Table 1: modes of a random record.
    pub(super) fn mode_table(&self, record: &LinearRecord) -> Table {
        let shapes = record.responses.iter().map(|(at, _)| format!("shape at {at} m"));
        let heading = ["Mode", "f (Hz)", "model (Hz)", "damping (%)"].map(str::to_owned).into_iter();
        let rows = record.poles.iter().enumerate().map(|(k, pole)| {
            let largest = pole.residues.iter().max_by(|a, b| a.norm().total_cmp(&b.norm()));
            let numbers = [
                Cell::text(format!("{}", k + 1)),
                Cell::Number(pole.frequency, 3),
                Cell::Number(record.model.get(k).copied().unwrap_or(f64::NAN), 3),
                Cell::Number(100.0 * pole.damping_ratio, 3),
            ];
            let shape = pole
                .residues
                .iter()
                .map(|residue| Cell::Number(largest.map_or(f64::NAN, |largest| (residue / largest).re), 3));
            numbers.into_iter().chain(shape).collect()
        });
        Table {
            label: format!("Modes of {}", record.name),
            heading: heading.chain(shapes).collect(),
            rows: rows.collect(),
        }
    }
}

/// Gains and masses of the measuring chain of `inversion`, with words on the `beam`.
pub(crate) fn chain_blocks(inversion: &Inversion, beam: &str) -> Vec<Block> {
    let row = |name: String, [value, deviation]: [f64; 2], factor: f64| {
        vec![Cell::text(name), Cell::Number(factor * value, 3), Cell::Number(1.96 * factor * deviation, 3)]
    };
    let mut rows = vec![row("gain of the load cell, off by (%)".into(), inversion.excitation_gain, 100.0)];
    for (k, gain) in inversion.sensor_gains.iter().enumerate() {
        rows.push(row(format!("gain of sensor {}, off by (%)", k + 1), *gain, 100.0));
    }
    for (k, mass) in inversion.sensor_masses.iter().enumerate().filter(|(_, mass)| mass[1] > 0.0) {
        rows.push(row(format!("mass at sensor {}, more by (g)", k + 1), *mass, 1e3));
    }
    let note = format!("Sensors are counted from the clamp. {beam}");
    vec![Block::Table(table("Measuring chain", &["", "Value", "±"], rows)), Block::Note(note)]
}

pub(crate) fn table(label: &str, heading: &[&str], rows: Vec<Vec<Cell>>) -> Table {
    Table { label: label.into(), heading: heading.iter().map(|&text| text.to_owned()).collect(), rows }
}

/// Largest displacement, velocity and force of a period, means left out.
fn largest(period: &ContactPeriod) -> [f64; 3] {
    let means = [period.displacement[0], period.velocity[0], period.force[0]];
    let mut most = [0.0_f64; 3];
    for at in samples(period, STEPS) {
        for (k, most) in most.iter_mut().enumerate() {
            *most = most.max((at[k] - means[k]).abs());
        }
    }
    most
}
