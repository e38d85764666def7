//! Both forces for programs.

use serde_json::{Map, Value, json};
use stickslip::identify::{ContactPeriod, SlipSlapRecord};

use super::SlipSlapReport;

/// The identification under the schema `stickslip.identification/1`, without laws; numbers in SI units, those that are not told `null`.
///
/// Forces and displacements are Fourier coefficients `[mean, cos, sin, …]`; `normal_force` is what presses the pin on its support.
/// Intervals are half-widths of 95 % intervals, root mean square over the period, without the mean.
pub fn slip_slap_json(report: &SlipSlapReport) -> Value {
    let found = report.found;
    let reasons = found.unidentified.iter().map(|one| (one.name.to_owned(), json!(one.reason)));
    let skipped = found.skipped.iter().map(|(file, reason)| json!({ "file": file, "reason": reason }));
    let coupling = found.coupling.as_ref().map(|coupling| {
        json!({
            "following": coupling.following, "low": coupling.interval[0], "high": coupling.interval[1],
            "explained": coupling.explained, "left": coupling.left,
        })
    });
    let separation = report.separation.iter().map(|one| {
        json!({
            "amplitudes": one.amplitudes, "least_normal_force": one.least_normal_force, "onset": one.onset,
        })
    });
    json!({
        "schema": "stickslip.identification/1",
        "method": "receptance-inversion",
        "preload": found.preload,
        "records": report.periods().map(|(record, periods)| report.one_record(record, periods)).collect::<Vec<_>>(),
        "laws": [],
        "best": null,
        "coupling": coupling,
        "by_modulus": found.by_modulus,
        "by_normal_stiffness": found.by_normal_stiffness,
        "separates": report.separates(),
        "separation": separation.collect::<Vec<_>>(),
        "unidentified": found.unidentified.iter().map(|one| one.name).collect::<Vec<_>>(),
        "unidentified_reasons": reasons.collect::<Map<_, _>>(),
        "rig": found.rig,
        "skipped": skipped.collect::<Vec<_>>(),
        "warnings": found.warnings,
        "notes": report.notes,
    })
}

impl SlipSlapReport<'_> {
    fn one_record(&self, record: &SlipSlapRecord, [along, across]: [&ContactPeriod; 2]) -> Value {
        let own =
            |warning: &&String| warning.strip_prefix(&record.name).is_some_and(|rest| rest.starts_with(':'));
        let [sticks, partly, whole] = record.slopes.parts;
        let direction = |period: &ContactPeriod, place: usize| {
            json!({
                "force": period.force, "force_interval": record.force_intervals[place],
                "displacement": period.displacement, "displacement_interval": record.displacement_intervals[place],
                "work": period.work(),
            })
        };
        json!({
            "file": record.name, "frequency": record.frequency, "force_interval": record.force_intervals[0],
            "normal_force_interval": record.force_intervals[1], "conditioning": self.found.inversion.conditioning,
            "warnings": self.found.warnings.iter().filter(own).collect::<Vec<_>>(), "accelerations": record.accelerations,
            "excitation": record.forces, "unexplained": along.unexplained,
            "tangential": direction(along, 0), "normal": direction(across, 1),
            "normal_force": record.normal_force, "reversals": record.reversals[0], "normal_reversals": record.reversals[1],
            "loops": record.loops(), "hardening": record.hardening()[0], "hardening_by_modulus": record.hardening()[1],
            "stuck_stiffness": record.slopes.stuck,
            "sticks": sticks, "micro_slip": partly, "macro_slip": whole,
            "published": record.published.as_ref().map(|published| {
                json!({
                    "trusted": published.trusted(), "difference": published.difference,
                    "normal_ratio": published.modes.each_ref().map(|mode| mode.normal_ratio), "echo": published.echo,
                })
            }),
        })
    }
}
