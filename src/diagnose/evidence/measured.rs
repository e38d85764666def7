//! The measurements that hypotheses are fitted to, and what is known of their noise.

use super::autoregression::Autoregression;
use super::joint::{dot, minus};
use super::noise_prior::NoisePrior;
use crate::diagnose::assumptions::Assumptions;
use crate::diagnose::diagnosis::Noise;
use crate::diagnose::measurements::weighted_dataset::{RecordResiduals, WeightedDataset};

/// Some records of a dataset.
pub(in crate::diagnose) struct Measured<'a, 'd> {
    pub bench: &'a WeightedDataset<'d>,
    /// Indices of the records.
    pub records: Vec<usize>,
    /// Number of different compared channels; one noise process each.
    pub processes: usize,
    /// Per record of these and channel: its process, its samples, its standard deviation, its noise.
    pub channels: Vec<Vec<MeasuredChannel>>,
}

/// A compared channel of a record.
#[derive(Debug, Clone)]
pub(in crate::diagnose) struct MeasuredChannel {
    pub process: usize,
    pub range: std::ops::Range<usize>,
    pub size: f64,
    pub prior: NoisePrior,
}

impl<'a, 'd> Measured<'a, 'd> {
    /// Of `records`, with noise as `found` (in the order of all records and channels) and what the noise of the inputs
    /// makes of the predictions.
    pub fn new(
        bench: &'a WeightedDataset<'d>,
        records: &[usize],
        found: &[Noise],
        through: &[Vec<f64>],
    ) -> Self {
        let mut names: Vec<&str> =
            bench.lanes.iter().flat_map(|lane| lane.channels.iter().map(|(name, _)| *name)).collect();
        names.sort_unstable();
        names.dedup();
        let channels = records
            .iter()
            .map(|&record| {
                let lane = &bench.lanes[record];
                let channel = |(k, (name, range)): (usize, &(&str, std::ops::Range<usize>))| {
                    let size = 1.0 / lane.scales[range.start];
                    let own = found.iter().find(|noise| noise.record == record && noise.channel == *name);
                    let more = through.get(record).and_then(|of| of.get(k)).copied().unwrap_or(0.0);
                    let process = names.iter().position(|known| known == name).unwrap_or(0);
                    MeasuredChannel {
                        process,
                        range: range.clone(),
                        size,
                        prior: prior(own, size, more, &bench.assumptions),
                    }
                };
                lane.channels.iter().enumerate().map(channel).collect()
            })
            .collect();
        Self { bench, records: records.to_vec(), processes: names.len(), channels }
    }

    /// What is taken for granted.
    pub fn assumptions(&self) -> &Assumptions {
        &self.bench.assumptions
    }

    /// The record in place `k`.
    pub fn lane(&self, k: usize) -> &RecordResiduals<'d> {
        &self.bench.lanes[self.records[k]]
    }

    /// Root mean square over all channels of the difference of two predictions, as a fraction of the channel.
    pub fn distance(&self, a: &[Vec<f64>], b: &[Vec<f64>]) -> f64 {
        self.size(&apart(a, b))
    }

    /// The same of a change of predictions.
    pub fn size(&self, change: &[Vec<f64>]) -> f64 {
        let (sum, count) = (0..change.len())
            .map(|k| (self.square(k, &change[k]), self.channels[k].len()))
            .fold((0.0, 0), |(sum, count), (square, channels)| (sum + square, count + channels));
        (sum / count.max(1) as f64).sqrt()
    }

    /// How much the difference of two predictions matters: its size in the record where it is largest. Records that show
    /// nothing of an effect make it no smaller where it is seen.
    pub fn relevance(&self, a: &[Vec<f64>], b: &[Vec<f64>]) -> f64 {
        self.largest(&apart(a, b))
    }

    /// The same of a change of predictions.
    pub fn largest(&self, change: &[Vec<f64>]) -> f64 {
        (0..change.len()).map(|k| self.size_of(k, &change[k])).fold(0.0, f64::max)
    }

    /// The size of a change of the predictions of record `k`.
    pub fn size_of(&self, k: usize, change: &[f64]) -> f64 {
        (self.square(k, change) / self.channels[k].len().max(1) as f64).sqrt()
    }

    /// Sum over the channels of record `k` of the mean square of `change`, as a fraction of the channel's.
    fn square(&self, k: usize, change: &[f64]) -> f64 {
        let of = |channel: &MeasuredChannel| {
            let square: f64 = change[channel.range.clone()].iter().map(|x| x * x).sum();
            square / (channel.range.len() as f64 * channel.size * channel.size)
        };
        self.channels[k].iter().map(of).sum()
    }

    /// `predictions` minus measurements.
    fn residuals(&self, predictions: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let of = |(k, predicted): (usize, &Vec<f64>)| minus(predicted, &self.lane(k).measured);
        predictions.iter().enumerate().map(of).collect()
    }

    /// The size of what `predictions` leave of the measurements.
    pub fn left(&self, predictions: &[Vec<f64>]) -> f64 {
        self.size(&self.residuals(predictions))
    }

    /// The size of that part of it that follows from its own past.
    pub fn foretold(&self, predictions: &[Vec<f64>]) -> f64 {
        let mut left = self.residuals(predictions);
        for process in 0..self.processes {
            let own = |channels: &[MeasuredChannel]| -> Vec<std::ops::Range<usize>> {
                channels.iter().filter(|c| c.process == process).map(|c| c.range.clone()).collect()
            };
            let series = self.channels.iter().zip(&left);
            let series =
                series.flat_map(|(channels, left)| own(channels).into_iter().map(|range| &left[range]));
            let part = (1.0 - Autoregression::fit(series).fraction).max(0.0).sqrt();
            for (channels, left) in self.channels.iter().zip(&mut left) {
                own(channels).into_iter().for_each(|range| left[range].iter_mut().for_each(|x| *x *= part));
            }
        }
        self.size(&left)
    }

    /// Whether something is known of the noise of every channel.
    pub fn noise_is_known(&self) -> bool {
        self.channels
            .iter()
            .flatten()
            .all(|channel| channel.prior.spreads[1] < self.assumptions().unknown_noise)
    }

    /// Mean square of `predictions` minus measurements over that of the noise expected, of each record.
    pub fn chi_squares(&self, predictions: &[Vec<f64>]) -> Vec<f64> {
        let of_record = |(k, predicted): (usize, &Vec<f64>)| {
            let measured = &self.lane(k).measured;
            let square = |channel: &MeasuredChannel| {
                let apart = |i: usize| self.lane(k).weights[i] * (predicted[i] - measured[i]);
                let of = |i: usize| (apart(i) / channel.prior.deviation).powi(2);
                channel.range.clone().map(of).sum::<f64>()
            };
            self.channels[k].iter().map(square).sum::<f64>() / measured.len().max(1) as f64
        };
        predictions.iter().enumerate().map(of_record).collect()
    }

    /// By how much the residual of `predictions` is larger than the noise that was told, as a fraction of the channels, in the
    /// record where that is most: as `relevance`.
    pub fn excess(&self, predictions: &[Vec<f64>]) -> f64 {
        let of = |(k, predicted): (usize, &Vec<f64>)| self.excess_of(k, predicted);
        predictions.iter().enumerate().map(of).fold(0.0, f64::max)
    }

    /// The same of record `k`.
    pub fn excess_of(&self, k: usize, predicted: &[f64]) -> f64 {
        let measured = &self.lane(k).measured;
        let of = |MeasuredChannel { range, size, prior, .. }: &MeasuredChannel| {
            let square: f64 = range.clone().map(|i| (predicted[i] - measured[i]).powi(2)).sum();
            let more = square / range.len() as f64 - prior.deviation * prior.deviation;
            more.max(0.0) / (size * size)
        };
        (self.channels[k].iter().map(of).sum::<f64>() / self.channels[k].len().max(1) as f64).sqrt()
    }

    /// How much of the residual of `predictions` is more than noise, root mean square over all records as a fraction of the
    /// channels: what is beyond a noise that is known; of an unknown one what follows from its own past, all of it where few values,
    /// or a size that noise hardly has, tell nothing of that.
    pub fn unexplained(&self, predictions: &[Vec<f64>]) -> f64 {
        if self.noise_is_known() {
            let square = |(k, predicted): (usize, &Vec<f64>)| self.excess_of(k, predicted).powi(2);
            let squares: f64 = predictions.iter().enumerate().map(square).sum();
            return (squares / predictions.len().max(1) as f64).sqrt();
        }
        let left = self.left(predictions);
        let mut values = vec![0; self.processes];
        self.channels.iter().flatten().for_each(|channel| values[channel.process] += channel.range.len());
        let told = values.iter().all(|count| *count >= Autoregression::FEWEST);
        if told && left < self.assumptions().largest_noise() { self.foretold(predictions) } else { left }
    }

    /// Part of the square of what `predictions` leave that is beyond a noise as large as what was told of it may mean.
    pub fn share_beyond_noise(&self, predictions: &[Vec<f64>]) -> f64 {
        let (mut beyond, mut all) = (0.0, 0.0);
        for (channels, left) in self.channels.iter().zip(self.residuals(predictions)) {
            for MeasuredChannel { range, size, prior, .. } in channels {
                let left = &left[range.clone()];
                let square = dot(left, left) / left.len() as f64;
                let noise = prior.deviation * prior.spreads[1].exp();
                beyond += (square - noise * noise).max(0.0) / (size * size);
                all += square / (size * size);
            }
        }
        if all > 0.0 { beyond / all } else { 0.0 }
    }

    /// Log likelihood of `predictions`, the noise fitted to what they leave.
    pub fn log_score(&self, predictions: &[Vec<f64>]) -> f64 {
        let priors: Vec<Vec<NoisePrior>> =
            self.channels.iter().map(|channels| channels.iter().map(|c| c.prior).collect()).collect();
        self.log_score_under(&priors, predictions)
    }

    /// The same where the noise is known otherwise.
    pub fn log_score_under(&self, priors: &[Vec<NoisePrior>], predictions: &[Vec<f64>]) -> f64 {
        let residuals = self.residuals(predictions);
        let mut noise = NoiseModel::white(self);
        noise.renew(self, priors, &residuals, true);
        let square = |(k, r): (usize, &Vec<f64>)| noise.whiten(self, k, r).iter().map(|x| x * x).sum::<f64>();
        let squares: f64 = residuals.iter().enumerate().map(square).sum();
        noise.log_constant(self) - 0.5 * squares
    }

    /// Expected noise as a fraction of the channels, root mean square; `None` where it is unknown.
    pub fn floor(&self) -> Option<f64> {
        let fractions = self.channels.iter().flatten().map(|channel| channel.prior.deviation / channel.size);
        let (sum, count) = fractions.fold((0.0, 0), |(sum, count), x| (sum + x * x, count + 1));
        (count > 0 && self.noise_is_known()).then(|| (sum / f64::from(count)).sqrt())
    }
}

/// The difference of two predictions.
fn apart(a: &[Vec<f64>], b: &[Vec<f64>]) -> Vec<Vec<f64>> {
    a.iter().zip(b).map(|(a, b)| minus(a, b)).collect()
}

fn prior(own: Option<&Noise>, size: f64, more: f64, assumed: &Assumptions) -> NoisePrior {
    match own.and_then(|noise| Some((noise.deviation?, noise.log_error))) {
        Some((deviation, log_error)) => {
            let spread = assumed.stated_noise.hypot(log_error).min(assumed.magnitude);
            NoisePrior::new(deviation.hypot(more), spread, assumed)
        }
        None => NoisePrior::new(assumed.usual_noise * size, assumed.unknown_noise, assumed),
    }
}

/// `values` of record `k`, those of which more is known the larger.
fn weighted(data: &Measured, k: usize, values: &[f64]) -> Vec<f64> {
    values.iter().zip(&data.lane(k).weights).map(|(value, weight)| weight * value).collect()
}

/// The noise of all compared channels: a process per channel's name, a size per record.
#[derive(Debug, Clone)]
pub(super) struct NoiseModel {
    pub processes: Vec<Autoregression>,
    /// Innovation deviations, per record and channel.
    pub sizes: Vec<Vec<f64>>,
    /// Log evidence of each.
    evidence: Vec<Vec<f64>>,
}

impl NoiseModel {
    /// White, of the sizes expected.
    pub fn white(data: &Measured) -> Self {
        let sizes: Vec<Vec<f64>> =
            data.channels.iter().map(|of| of.iter().map(|c| c.prior.deviation).collect()).collect();
        let evidence = sizes.iter().map(|of| vec![0.0; of.len()]).collect();
        Self { processes: vec![Autoregression::white(); data.processes], sizes, evidence }
    }

    /// Fits sizes, and processes if `coloured`, to `residuals` per record.
    pub fn renew(
        &mut self,
        data: &Measured,
        priors: &[Vec<NoisePrior>],
        residuals: &[Vec<f64>],
        coloured: bool,
    ) {
        let mut residuals: Vec<Vec<f64>> =
            residuals.iter().enumerate().map(|(k, residuals)| weighted(data, k, residuals)).collect();
        for index in 0..if coloured { data.processes } else { 0 } {
            let series = data.channels.iter().zip(&residuals).flat_map(|(channels, residuals)| {
                let own = channels.iter().filter(move |channel| channel.process == index);
                own.map(|channel| &residuals[channel.range.clone()])
            });
            self.processes[index] = Autoregression::fit(series);
        }
        for (k, residuals) in residuals.iter_mut().enumerate() {
            for (c, channel) in data.channels[k].iter().enumerate() {
                let process = &self.processes[channel.process];
                let e = &mut residuals[channel.range.clone()];
                process.whiten(e);
                let square: f64 = e.iter().map(|x| x * x).sum();
                let (size, evidence) = priors[k][c].most_probable(square, e.len(), process.fraction);
                (self.sizes[k][c], self.evidence[k][c]) = (size, evidence);
            }
        }
    }

    /// Innovations of `values` of record `k`, in their standard deviations.
    pub fn whiten(&self, data: &Measured, k: usize, values: &[f64]) -> Vec<f64> {
        let mut out = weighted(data, k, values);
        for (c, channel) in data.channels[k].iter().enumerate() {
            let part = &mut out[channel.range.clone()];
            self.processes[channel.process].whiten(part);
            let factor = 1.0 / self.sizes[k][c];
            part.iter_mut().for_each(|x| *x *= factor);
        }
        out
    }

    /// Log evidence of the noise's own numbers, and the likelihood's constant; without the squares of the innovations.
    pub fn log_constant(&self, data: &Measured) -> f64 {
        let mut sum = 0.0;
        let mut counts = vec![0usize; data.processes];
        for (k, channels) in data.channels.iter().enumerate() {
            for (c, channel) in channels.iter().enumerate() {
                let process = &self.processes[channel.process];
                let n = channel.range.len() as f64;
                counts[channel.process] += channel.range.len();
                sum -= n * self.sizes[k][c].ln() + process.log_determinant();
                sum += self.evidence[k][c];
            }
        }
        for (process, count) in self.processes.iter().zip(counts) {
            sum -= 0.5 * process.order() as f64 * (count.max(1) as f64).ln();
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::{Channel, Dataset, Record, Regime};
    use crate::diagnose::diagnosis::NoiseSource;
    use crate::diagnose::evidence::samples::{moved, slider};

    const COUNT: usize = 1000;

    #[test]
    fn of_white_noise_nothing_is_foretold_and_of_a_wave_all() {
        let model = slider("");
        let values = |of: &mut dyn FnMut(f64) -> f64| (0..COUNT).map(|i| of(i as f64)).collect::<Vec<f64>>();
        let force = values(&mut |i| (0.1 * i).sin());
        let channel = |name: &str, unit, values| Channel { name: name.into(), unit, values, noise: None };
        let channels = vec![
            channel("time", "s", values(&mut |i| 1e-3 * i)),
            channel("displacement", "m", values(&mut |i| 1e-6 * (0.1 * i).sin())),
            channel("force", "N", force.clone()),
        ];
        let record = Record { name: "r".into(), regime: Regime::FromRest, use_for: None, channels };
        let dataset = Dataset { title: None, records: vec![record] };
        let bench = WeightedDataset::new(&model, &dataset, Assumptions::default(), None).unwrap();
        let data = Measured::new(&bench, &[0], &[], &[]);
        let mut numbers = fastrand::Rng::with_seed(7).fork();
        let foretold = |of: &mut dyn FnMut(f64) -> f64| {
            let off: Vec<f64> = values(of).iter().zip(&force).map(|(off, force)| force + off).collect();
            data.foretold(std::slice::from_ref(&off)) / data.left(&[off])
        };
        let white = foretold(&mut |_| 0.02 * (numbers.f64() - 0.5));
        assert!(white < 0.1, "{white}");
        let wave = foretold(&mut |i| 0.02 * (0.05 * i).sin());
        assert!(wave > 0.95, "{wave}");
    }

    #[test]
    fn more_than_noise_is_what_one_record_shows_and_others_do_not() {
        let model = slider("");
        let record = moved(&model, 200, 1e-3, |i| 1e-6 * (0.1 * f64::from(i)).sin());
        let dataset = Dataset { title: None, records: vec![record.clone(), record] };
        let force = &dataset.records[0].channels[2].values;
        let bench = WeightedDataset::new(&model, &dataset, Assumptions::default(), None).unwrap();
        let size = 1.0 / bench.lanes[0].scales[0];
        let told = [0, 1].map(|record| Noise {
            record,
            channel: "force".into(),
            deviation: Some(0.003 * size),
            log_error: 0.0,
            source: NoiseSource::Stated,
        });
        let data = Measured::new(&bench, &[0, 1], &told, &[]);
        let off = |fraction: f64| force.iter().map(|force| force + fraction * size).collect::<Vec<f64>>();
        let excess = |of: [f64; 2]| data.excess(&of.map(off));
        assert_eq!(excess([0.003, 0.002]), 0.0);
        assert_eq!(data.unexplained(&[0.003, 0.002].map(off)), 0.0);
        for other in [0.0, 0.003, 0.005] {
            assert!((excess([0.005, other]) - 0.004).abs() < 1e-9, "{other}");
        }
        assert!((data.unexplained(&[0.005, 0.0].map(off)) - 0.004 / 2.0_f64.sqrt()).abs() < 1e-9);
    }
}
