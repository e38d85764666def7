//! Queries of records and channels.

use super::{Channel, ChannelName, Record};
#[cfg(feature = "analysis")]
use crate::vocabulary as v;

/// Samples may stand this fraction of a step off an even grid: time stamps are printed with few digits.
const EVENNESS: f64 = 0.05;
/// Standard deviations of a normal number in half of a 95 % interval.
#[cfg(feature = "analysis")]
const NORMAL_95: f64 = 1.96;

impl Record {
    /// The channel called `name`; `x=0.550` and `x=0.55` are the same place.
    ///
    /// ```
    /// use stickslip::data::{Channel, Record, Regime};
    /// let force = Channel { name: "acceleration:x=0.55".into(), unit: "m/s^2", values: vec![], noise: None };
    /// let record = Record { name: "r".into(), regime: Regime::Steady, use_for: None, channels: vec![force] };
    /// assert!(record.channel("acceleration:x=0.550").is_some() && record.channel("acceleration").is_none());
    /// ```
    pub fn channel(&self, name: &str) -> Option<&Channel> {
        let name = ChannelName::parse(name).ok()?.to_string();
        self.channels.iter().find(|channel| channel.name == name)
    }

    /// The channels of the quantity called `quantity`, wherever they were measured.
    ///
    /// ```
    /// use stickslip::data::{Channel, Record, Regime};
    /// let channel = |name: &str| Channel { name: name.into(), unit: "m/s^2", values: vec![0.0], noise: None };
    /// let channels = vec![channel("acceleration:m1"), channel("acceleration:m2")];
    /// let record = Record { name: "r".into(), regime: Regime::FromRest, use_for: None, channels };
    /// assert_eq!(record.channels_of("acceleration").count(), 2);
    /// ```
    pub fn channels_of<'r>(&'r self, quantity: &'r str) -> impl Iterator<Item = &'r Channel> {
        self.channels.iter().filter(move |channel| channel.quantity() == quantity)
    }

    /// Standard deviation of each value of `channel`, where the record has its 95 % intervals beside it.
    #[cfg(feature = "analysis")]
    pub(crate) fn deviations(&self, channel: &Channel) -> Option<Vec<f64>> {
        let intervals = match channel.quantity() {
            "frequency" => &v::FREQUENCY_INTERVAL,
            "damping_ratio" => &v::DAMPING_INTERVAL,
            _ => return None,
        };
        let intervals = &self.channel(intervals.name)?.values;
        intervals
            .iter()
            .all(|half| *half > 0.0)
            .then(|| intervals.iter().map(|half| half / NORMAL_95).collect())
    }

    /// Standard deviation of the noise of `channel` in all, as stated or by its intervals.
    #[cfg(feature = "analysis")]
    pub(crate) fn stated_noise(&self, channel: &Channel) -> Option<f64> {
        let of_rows = || {
            let deviations = self.deviations(channel)?;
            let square = deviations.iter().map(|x| x * x).sum::<f64>() / deviations.len() as f64;
            Some(square.sqrt())
        };
        channel.noise.or_else(of_rows)
    }

    /// How much more or less each value of `channel` weighs than its noise in all says: that over its own; all the same
    /// where nothing tells them apart.
    #[cfg(feature = "analysis")]
    pub(crate) fn weights(&self, channel: &Channel) -> Vec<f64> {
        match (self.deviations(channel), self.stated_noise(channel)) {
            (Some(own), Some(all)) => own.iter().map(|own| all / own).collect(),
            _ => vec![1.0; channel.values.len()],
        }
    }

    /// Number of samples, the same in every channel.
    pub fn len(&self) -> usize {
        self.channels.first().map_or(0, |channel| channel.values.len())
    }

    /// Whether the record has no samples.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The time stamps (s), strictly increasing; a backbone table has none.
    ///
    /// ```
    /// use stickslip::data::{Channel, Record, Regime};
    /// let time = Channel { name: "time".into(), unit: "s", values: vec![0.0, 0.1], noise: None };
    /// let record = Record { name: "r".into(), regime: Regime::FromRest, use_for: None, channels: vec![time] };
    /// assert_eq!(record.time(), Some(&[0.0, 0.1][..]));
    /// ```
    pub fn time(&self) -> Option<&[f64]> {
        self.channel("time").map(|channel| channel.values.as_slice())
    }

    /// The time between samples (s), if they are evenly spaced to within a twentieth of it.
    ///
    /// ```
    /// use stickslip::data::{Channel, Record, Regime};
    ///
    /// let time = Channel { name: "time".into(), unit: "s", values: vec![0.0, 0.1, 0.2], noise: None };
    /// let mut record =
    ///     Record { name: "r".into(), regime: Regime::FromRest, use_for: None, channels: vec![time] };
    /// assert_eq!(record.sample_step(), Some(0.1));
    /// record.channels[0].values.push(0.5);
    /// assert_eq!(record.sample_step(), None);
    /// ```
    pub fn sample_step(&self) -> Option<f64> {
        let time = self.time()?;
        let (first, last) = (*time.first()?, *time.last()?);
        let steps = (time.len() - 1) as f64;
        let step = (last - first) / steps;
        let even = |(index, stamp): (usize, &f64)| {
            let expected = first + index as f64 * step;
            (stamp - expected).abs() <= EVENNESS * step
        };
        (step > 0.0 && time.iter().enumerate().all(even)).then_some(step)
    }

    /// As [`Record::sample_step`], or what is wrong with the time stamps, and what to do.
    #[cfg(feature = "analysis")]
    pub(crate) fn even_step(&self) -> Result<f64, String> {
        if let Some(step) = self.sample_step() {
            return Ok(step);
        }
        let Some(time) = self.time().filter(|time| time.len() > 1) else {
            return Err("there is no column `time` with two samples or more".to_owned());
        };
        let step = (time[time.len() - 1] - time[0]) / (time.len() - 1) as f64;
        let even = |index: usize| time[0] + index as f64 * step;
        let off = |index: &usize| (time[*index] - even(*index)).abs();
        let worst = (0..time.len()).max_by(|a, b| off(a).total_cmp(&off(b))).unwrap_or(0);
        Err(format!(
            "its `time` is not evenly spaced: sample {} is at {:.6e} s, where the mean step of {step:.6e} s puts {:.6e} s; export \
             the time stamps with more digits, cut the record where samples are missing, or resample it",
            worst + 1,
            time[worst],
            even(worst)
        ))
    }
}

impl Channel {
    /// The name of the quantity, without the place: `acceleration` of `acceleration:x=0.55`.
    pub fn quantity(&self) -> &str {
        self.name.split_once(':').map_or(self.name.as_str(), |(quantity, _)| quantity)
    }

    /// Where on a beam the channel was measured (m from the clamp), if its name says.
    pub fn position(&self) -> Option<f64> {
        self.name.split_once(":x=").and_then(|(_, position)| position.parse().ok())
    }
}

#[cfg(test)]
mod tests {
    use super::super::Regime;
    use super::*;

    fn record(names: &[&str], values: &[f64]) -> Record {
        let channel = |name: &&str| Channel {
            name: (*name).to_owned(),
            unit: "1",
            values: values.to_vec(),
            noise: None,
        };
        Record {
            name: "r".to_owned(),
            regime: Regime::Steady,
            use_for: None,
            channels: names.iter().map(channel).collect(),
        }
    }

    #[test]
    fn channels_are_found_by_name_quantity_and_place() {
        let record = record(&["time", "acceleration:x=0.55", "acceleration:x=0.1"], &[0.0, 1.0]);
        assert_eq!(record.channel("acceleration:x=0.550").unwrap().position(), Some(0.55));
        assert!(record.channel("acceleration").is_none() && record.channel("nonsense").is_none());
        assert_eq!(record.channels_of("acceleration").count(), 2);
        assert_eq!((record.len(), record.is_empty()), (2, false));
    }

    #[test]
    fn rounded_time_stamps_count_as_even_and_a_gap_does_not() {
        // 256 Hz printed with six digits, as data loggers do.
        let mut stamps: Vec<f64> = (0..5000)
            .map(|index| format!("{:.4}", 0.00146484 + f64::from(index) / 256.0).parse().unwrap())
            .collect();
        let step = record(&["time"], &stamps).sample_step().unwrap();
        assert!((step * 256.0 - 1.0).abs() < 1e-5);
        stamps.remove(2500);
        assert_eq!(record(&["time"], &stamps).sample_step(), None);
    }

    #[test]
    fn a_step_needs_two_samples() {
        for stamps in [&[][..], &[1.0]] {
            assert_eq!(record(&["time"], stamps).sample_step(), None);
        }
        assert_eq!(record(&["force"], &[0.0, 1.0]).sample_step(), None);
    }
}
