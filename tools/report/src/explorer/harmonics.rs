//! The residual of a periodic record, harmonic by harmonic.

use serde_json::{Value, json};
use stickslip::diagnose::Comparison;
use stickslip::fit::residual::drive;
use stickslip::harmonic::{fourier, whole_periods};

use super::residual;
use super::views::{deviation, short};
use crate::comparison::summary;

/// Harmonics in the table.
const HARMONICS: usize = 9;
/// Largest fraction of the drive's mean square that the harmonics of a periodic record leave out.
const UNREPRESENTED: f64 = 0.02;

/// The residual of a channel of a periodic record at the harmonics of its fundamental.
#[derive(Debug, Clone, PartialEq)]
pub struct Harmonics {
    /// Index of the record.
    pub record: usize,
    /// Name of the channel.
    pub channel: String,
    /// Frequency of the fundamental (Hz).
    pub fundamental: f64,
    /// By stage, from the mean (harmonic 0) on: root mean square of that part of the residual over the
    /// channel's standard deviation. `None` where the stage has no prediction.
    pub residuals: Vec<Option<Vec<f64>>>,
}

/// The residual of channel `name` of record `index` by harmonic; `None` where the record does not repeat.
pub fn by_harmonic(comparison: &Comparison, index: usize, name: &str) -> Option<Harmonics> {
    let record = &comparison.records[index];
    let measured = summary::channel(record, name)?;
    let step = record.sample_step()?;
    let drive = drive(record, measured)?.values.as_slice();
    let periods = whole_periods(drive).filter(|periods| *periods >= 2)?;
    if unrepresented(drive, periods) > UNREPRESENTED {
        return None;
    }
    let spread = deviation(&measured.values);
    let parts = |values: Vec<f64>| -> Vec<f64> {
        let coefficients = fourier::from_samples(&values, periods, HARMONICS);
        let mean = coefficients[0].abs() / spread;
        let sizes = coefficients[1..].chunks(2).map(|pair| pair[0].hypot(pair[1]) / (2f64.sqrt() * spread));
        std::iter::once(mean).chain(sizes).collect()
    };
    let whole = |values: &Vec<f64>| values.len() == measured.values.len();
    let residuals = comparison
        .stages
        .iter()
        .map(|stage| residual(comparison, index, stage, name).filter(whole).map(parts));
    Some(Harmonics {
        record: index,
        channel: name.to_owned(),
        fundamental: periods as f64 / (step * measured.values.len() as f64),
        residuals: residuals.collect(),
    })
}

/// Fraction of the mean square, the mean removed, beyond the harmonics.
fn unrepresented(values: &[f64], periods: usize) -> f64 {
    let coefficients = fourier::from_samples(values, periods, HARMONICS);
    let represented = 0.5 * coefficients[1..].iter().map(|c| c * c).sum::<f64>();
    let whole = deviation(values).powi(2);
    if whole > 0.0 { 1.0 - represented / whole } else { 1.0 }
}

impl Harmonics {
    /// For the page's script.
    pub(super) fn to_plot(&self) -> Value {
        let short = |values: &Vec<f64>| values.iter().map(|value| short(*value)).collect::<Vec<_>>();
        json!({
            "fundamental": self.fundamental,
            "residuals": self.residuals.iter().map(|one| one.as_ref().map(short)).collect::<Vec<_>>(),
        })
    }
}
