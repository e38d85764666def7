//! Free decays as tables that a model is compared to.

use crate::data::{Dataset, Record};
use crate::fit::predict::{predict, scatter_of_starts};
use crate::fit::ring_down::{NORMAL_95, RingDown, is_ring_down, levels};
use crate::model::{Model, Structure};

/// `dataset` with every free decay as the table of its levels; and those. A decay that cannot be cut stays as it is: a
/// prediction of it says why.
///
/// The levels of an oscillator are to be compared to those of a model's own decay. Of other structures they are those of its mode, as
/// long as that can be followed under `model`: it is quick and smooth in every parameter, and knows nothing of the release. Where it
/// cannot, as where a slider begins to slip and a higher mode lies near a multiple, the model's own decay is all there is.
///
/// ```
/// use stickslip::data::{Channel, Dataset, Record, Regime};
/// use stickslip::fit::tabulated;
/// use stickslip::model::Model;
/// let model = Model::parse(
///     "schema = \"stickslip.model/1\"\nkind = \"oscillator\"\nmass = [{ name = \"m1\", mass = 1.0 }]\n\
///      spring = [{ between = [\"ground\", \"m1\"], stiffness = 4e4, damping = 2.0 }]",
/// )?;
/// // 200 rad/s and a damping ratio of 0.005.
/// let time: Vec<f64> = (0..8000).map(|k| f64::from(k) * 1e-3).collect();
/// let decay = time.iter().map(|t| 3.0 * (-t).exp() * (200.0 * t).sin()).collect();
/// let channel = |name: &str, unit, values| Channel { name: name.into(), unit, values, noise: None };
/// let channels = vec![channel("time", "s", time.clone()), channel("acceleration:m1", "m/s^2", decay)];
/// let record = Record { name: "decay".into(), regime: Regime::UnknownInitialState, use_for: None, channels };
/// let (tables, found) = tabulated(&model, &Dataset { title: None, records: vec![record] });
/// assert_eq!(tables.records[0].regime, Regime::Backbone);
/// assert!((found[0].levels[0].damping_ratio - 0.005).abs() < 1e-6);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn tabulated(model: &Model, dataset: &Dataset) -> (Dataset, Vec<RingDown>) {
    let (mut tables, mut all) = (dataset.clone(), Vec::new());
    for record in tables.records.iter_mut().filter(|record| is_ring_down(model, record)) {
        if let Ok(found) = levels(record) {
            let found = compared(model, record, found);
            *record = found.table(record);
            all.push(found);
        }
    }
    (tables, all)
}

/// The levels as a model like `model` is compared to them. For its own decay intervals are wider by what that shows from one start or
/// another: nobody knows how the measured one was begun. What friction leaves in a contact, and the shock of a release, shift them.
fn compared(model: &Model, record: &Record, mut found: RingDown) -> RingDown {
    if !matches!(model.structure, Structure::Oscillator(_)) {
        let of_mode = found.clone().of_mode();
        let is_rig = matches!(model.structure, Structure::PinRig(_));
        if is_rig || predict(model, &of_mode.table(record)).is_ok() {
            return of_mode;
        }
    }
    let Ok(scatter) = scatter_of_starts(model, &found.table(record)) else { return found.of_mode() };
    for (level, [frequency, ratio]) in found.levels.iter_mut().zip(scatter) {
        level.frequency_interval = level.frequency_interval.hypot(NORMAL_95 * frequency);
        level.damping_interval = level.damping_interval.hypot(NORMAL_95 * ratio);
    }
    found
}
