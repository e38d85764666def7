//! A simulation as data.

use serde_json::{Value, json};

use super::Simulation;

/// ```json
/// {"schema": "stickslip.simulation/1", "system": "...", "algorithm": "...", "step": 1e-4,
///  "steps": 2000, "rejected": 0, "evaluations": 8000, "unconverged": 0, "forced": 0, "seconds": 0.5,
///  "reached": 0.2, "interrupted": false, "failure": null, "notes": ["..."],
///  "energy": [{"force": "beam.contact_force", "motion": "contact.displacement", "sum": 0.0, "magnitude": 0.0,
///    "largest": 0.0, "exchanged": 0.0, "history": [0.0]}],
///  "unwatched": [{"slaves": ["beam", "contact"], "units": false, "input": "contact.displacement", "mismatch": 0.01}],
///  "time": [0.0], "columns": [{"name": "beam.displacement", "unit": "m", "values": [0.0]}]}
/// ```
///
/// SI units, except for columns whose unit says otherwise; numbers that are not finite are `null`.
pub fn simulation_json(simulation: &Simulation) -> Value {
    let report = &simulation.report;
    let energy = report.energy.iter().enumerate().map(|(index, energy)| {
        json!({
            "force": energy.force,
            "motion": energy.motion,
            "sum": energy.sum,
            "magnitude": energy.magnitude,
            "largest": energy.largest,
            "exchanged": energy.exchanged,
            "history": simulation.energy.get(index),
        })
    });
    let unwatched = report.unwatched.iter().map(|one| {
        json!({ "slaves": one.slaves, "units": one.units, "input": one.input, "mismatch": one.mismatch })
    });
    let columns = simulation
        .columns
        .iter()
        .map(|column| json!({ "name": column.name, "unit": column.unit, "values": column.values }));
    json!({
        "schema": "stickslip.simulation/1",
        "system": simulation.title,
        "algorithm": simulation.algorithm,
        "step": simulation.step,
        "steps": report.steps,
        "rejected": report.rejected,
        "evaluations": report.evaluations,
        "unconverged": report.unconverged,
        "forced": report.forced,
        "seconds": simulation.seconds,
        "reached": report.time,
        "interrupted": report.interrupted,
        "failure": simulation.failure,
        "notes": simulation.all_notes().collect::<Vec<_>>(),
        "energy": energy.collect::<Vec<_>>(),
        "unwatched": unwatched.collect::<Vec<_>>(),
        "time": simulation.time,
        "columns": columns.collect::<Vec<_>>(),
    })
}
