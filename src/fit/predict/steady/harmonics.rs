//! A steady record as harmonics of its excitation: what drives a balance, where to look for the response, and the way back
//! to samples.

use std::f64::consts::TAU;
use std::sync::Arc;

use realfft::{ComplexToReal, RealFftPlanner};

use super::spectrum::{displacement, input};
use crate::data::{Channel, Record};
use crate::fit::predict::channels::derivative_order;
use crate::numeric::common_periods;
use crate::numeric::fourier::{self, time_derivative};

/// A steady record.
pub(super) struct RecordHarmonics {
    /// Fundamental (rad/s).
    pub angular_frequency: f64,
    /// Highest harmonic of the coefficients here.
    pub harmonics: usize,
    /// Coefficients `[a0, c1, s1, …]` of the excitation (N).
    pub excitation: Vec<f64>,
    /// Coefficients of the measured normal load (N).
    pub load: Option<Vec<f64>>,
    /// Displacement coefficients (m) of each channel, of the harmonics that stand out of its noise.
    pub motion: Vec<Vec<f64>>,
    /// Periods of the excitation in the record.
    periods: usize,
    /// From spectral lines to samples.
    inverse: Arc<dyn ComplexToReal<f64>>,
    /// Time derivative of the displacement that each channel measures.
    orders: Vec<usize>,
    /// What the channels measured, without their means.
    measured: Vec<f64>,
}

impl RecordHarmonics {
    /// Of `channels` of `record` under `excitation`, with as many harmonics as `enough` says of the fundamental (rad/s).
    ///
    /// # Errors
    /// What the record lacks, for a reader of the comparison.
    pub fn new(
        record: &Record,
        channels: &[&Channel],
        excitation: &Channel,
        enough: impl Fn(f64) -> usize,
    ) -> Result<Self, String> {
        let samples = record.time().ok_or("there is no `time` column")?.len();
        let step = record.even_step()?;
        let force = &excitation.values;
        let load = record.channel("normal_load").map(|channel| channel.values.as_slice());
        let periods = common_periods(std::iter::once(force.as_slice()).chain(load))
            .ok_or("the excitation shows no spectral line")?;
        let angular_frequency = TAU * periods as f64 / (step * force.len() as f64);
        let harmonics = enough(angular_frequency);
        let orders: Vec<usize> = channels.iter().map(|channel| derivative_order(channel)).collect();
        let values = || channels.iter().map(|channel| channel.values.as_slice());
        let displacements = values()
            .zip(&orders)
            .map(|(values, order)| displacement(values, *order, periods, harmonics, angular_frequency));
        let mut measured: Vec<f64> = values().flatten().copied().collect();
        measured.chunks_exact_mut(samples).for_each(remove_mean);
        Ok(Self {
            angular_frequency,
            harmonics,
            excitation: input("excitation", force, periods, harmonics)?,
            load: load.map(|load| input("normal_load", load, periods, harmonics)).transpose()?,
            motion: displacements.collect(),
            periods,
            inverse: RealFftPlanner::new().plan_fft_inverse(samples),
            orders,
            measured,
        })
    }

    /// Root-mean-square difference of `predictions` from the measured motion as a fraction of it, means apart.
    pub fn distance(&self, predictions: &[f64]) -> f64 {
        let samples = self.inverse.len();
        let (mut sum, mut channels) = (0.0, 0.0);
        let mut moved = vec![0.0; samples];
        for (predicted, measured) in
            predictions.chunks_exact(samples).zip(self.measured.chunks_exact(samples))
        {
            moved.copy_from_slice(predicted);
            remove_mean(&mut moved);
            let error: f64 = moved.iter().zip(measured).map(|(a, b)| (a - b).powi(2)).sum();
            let size: f64 = measured.iter().map(|b| b * b).sum();
            if size > 0.0 {
                sum += error / size;
                channels += 1.0;
            }
        }
        if channels > 0.0 { f64::sqrt(sum / channels) } else { 0.0 }
    }

    /// What the channels measure of displacements with the coefficients `sensors`. Their phase 0 is the first sample.
    pub fn observe(&self, sensors: &[f64], out: &mut Vec<f64>) {
        out.clear();
        let count = sensors.len() / self.orders.len();
        for (coefficients, order) in sensors.chunks_exact(count).zip(&self.orders) {
            let moved = time_derivative(coefficients, *order, self.angular_frequency);
            fourier::to_samples(&moved, self.periods, &*self.inverse, out);
        }
    }
}

fn remove_mean(values: &mut [f64]) {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    values.iter_mut().for_each(|value| *value -= mean);
}
