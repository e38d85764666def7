//! The tables of both forces.

use super::{SlipSlapReport, level};
use crate::document::{Cell, Table};
use crate::identification::table;

impl SlipSlapReport<'_> {
    /// Levels and forces of every record.
    pub(super) fn force_table(&self) -> Table {
        let heading = [
            "Record",
            "a1 (m/s²)",
            "a3 (m/s²)",
            "f (Hz)",
            "F1 (N)",
            "F3 (N)",
            "S (N)",
            "± (N)",
            "N_c (N)",
            "to (N)",
            "± (N)",
            "ξ (µm)",
            "± (µm)",
        ];
        let rows = self.periods().map(|(record, [along, _])| {
            let half_range = |coefficients: &[f64]| {
                let values = super::figures::over_period(coefficients);
                let most = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
                0.5 * (most - values.iter().copied().fold(f64::INFINITY, f64::min))
            };
            vec![
                Cell::text(record.name.clone()),
                Cell::Number(record.accelerations[0], 2),
                Cell::Number(record.accelerations[1], 2),
                Cell::Number(record.frequency, 3),
                Cell::Number(record.forces[0], 3),
                Cell::Number(record.forces[1], 3),
                Cell::Number(half_range(&along.force), 2),
                Cell::Number(record.force_intervals[0], 2),
                Cell::Number(record.normal_force[0], 2),
                Cell::Number(record.normal_force[1], 2),
                Cell::Number(record.force_intervals[1], 2),
                Cell::Number(1e6 * half_range(&along.displacement), 2),
                Cell::Number(1e6 * record.displacement_intervals[0], 2),
            ]
        });
        table("Forces in every record", &heading, rows.collect())
    }

    /// What the loops show.
    pub(super) fn slip_table(&self) -> Table {
        let heading = [
            "Level",
            "loops S–ξ",
            "loops N–η",
            "stuck (N/µm)",
            "sticks (%)",
            "micro-slip (%)",
            "macro-slip (%)",
            "loss (mJ)",
        ];
        let rows = self.periods().map(|(record, [along, _])| {
            let [sticks, partly, whole] = record.slopes.parts;
            vec![
                Cell::text(level(record)),
                Cell::Count(record.loops()[0]),
                Cell::Count(record.loops()[1]),
                Cell::Number(1e-6 * record.slopes.stuck, 3),
                Cell::Number(100.0 * sticks, 1),
                Cell::Number(100.0 * partly, 1),
                Cell::Number(100.0 * whole, 1),
                Cell::Number(1e3 * along.work(), 3),
            ]
        });
        table("Loops and slip", &heading, rows.collect())
    }

    /// How the normal force hardens, and what that hangs on.
    pub(super) fn hardening_table(&self) -> Table {
        let heading = [
            "Level",
            "N/η, unloaded half (N/µm)",
            "loaded half (N/µm)",
            "harder by (%)",
            "if E were 0.1 % larger (%)",
        ];
        let marked = |name: &str, value: f64, places: usize| match self.is_unidentified(name) {
            true => Cell::Marked(format!("{}, not identified", Cell::Number(value, places).shown())),
            false => Cell::Number(value, places),
        };
        let rows = self.found.records.iter().map(|record| {
            let [here, stiffer] = record.hardening();
            vec![
                Cell::text(level(record)),
                marked("normal_stiffness", 1e-6 * record.normal_slopes[0], 1),
                marked("normal_stiffness", 1e-6 * record.normal_slopes[1], 1),
                marked("hardening", 100.0 * here, 1),
                Cell::Number(100.0 * stiffer, 1),
            ]
        });
        table("Hardening of the normal force", &heading, rows.collect())
    }

    /// Below which preload the model's pin parts from its support.
    pub(super) fn separation_table(&self) -> Table {
        let heading =
            ["a1 (m/s²)", "a3 (m/s²)", "least N_c at this preload (N)", "parts below (N)", "that is (kg)"];
        let rows = self.separation.iter().map(|one| {
            let onset = one.onset.unwrap_or(f64::NAN);
            vec![
                Cell::text(crate::format::significant(one.amplitudes[0], 3)),
                Cell::Number(one.amplitudes[1], 1),
                Cell::Number(one.least_normal_force, 1),
                Cell::Number(onset, 1),
                Cell::Number(onset / 9.81, 2),
            ]
        });
        table("Separation in the model", &heading, rows.collect())
    }
}
