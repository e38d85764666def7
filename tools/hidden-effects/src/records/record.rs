//! Records as columns: clean from the simulation, then noisy as an instrument would write them.

use crate::records::random::Random;

/// What a column's noise is relative to the case's.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// Exact: the time.
    Exact,
    /// What the experimenter sets, measured well: a tenth of the noise.
    Driven,
    /// Displacement of a prescribed motion: three hundredths of the noise.
    Prescribed,
    /// What the model has to explain.
    Response,
}

impl Role {
    fn share(self) -> f64 {
        match self {
            Role::Exact => 0.0,
            Role::Driven => 0.1,
            Role::Prescribed => 0.03,
            Role::Response => 1.0,
        }
    }
}

/// A column of a record.
#[derive(Debug, Clone, PartialEq)]
pub struct Column {
    /// `force`, `displacement:m1`, ...
    pub name: String,
    /// Its unit, as the header says it.
    pub unit: &'static str,
    /// How well it is measured.
    pub role: Role,
    /// One value per sample, SI.
    pub values: Vec<f64>,
}

impl Column {
    /// A column.
    pub fn new(name: impl Into<String>, unit: &'static str, role: Role, values: Vec<f64>) -> Self {
        Self { name: name.into(), unit, role, values }
    }
}

/// How a record begins, in the words of a dataset file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Regime {
    /// Nothing moves and nothing is remembered.
    FromRest,
    /// Whole periods of a steady state.
    Steady,
    /// The contact remembers something.
    UnknownInitialState,
}

impl Regime {
    /// The word in `dataset.toml`.
    pub fn word(self) -> &'static str {
        match self {
            Regime::FromRest => "from-rest",
            Regime::Steady => "steady",
            Regime::UnknownInitialState => "unknown-initial-state",
        }
    }
}

/// A record.
#[derive(Debug, Clone, PartialEq)]
pub struct Record {
    /// How it begins.
    pub regime: Regime,
    /// Its columns, the time first.
    pub columns: Vec<Column>,
    /// Standard deviations of the noise that the dataset file tells, by column.
    pub told: Vec<(String, f64)>,
}

impl Record {
    /// Adds noise: `share` of each column's root mean square, times what its role says.
    pub fn measure(&mut self, share: f64, correlation: f64, tell: bool, random: &mut Random) {
        for column in &mut self.columns {
            let size = share * column.role.share() * root_mean_square(&column.values);
            random.add_noise(&mut column.values, size, correlation);
            if tell && column.role == Role::Response {
                self.told.push((column.name.clone(), size));
            }
        }
    }

    /// Whether it has an excitation, and that is none.
    pub fn is_silent(&self) -> bool {
        let excitations = || self.columns.iter().filter(|column| column.name.starts_with("excitation"));
        let none = |column: &Column| column.values.iter().all(|value| *value == 0.0);
        excitations().count() > 0 && excitations().all(none)
    }

    /// The columns that a model has to explain.
    pub fn responses(&self) -> impl Iterator<Item = &Column> {
        self.columns.iter().filter(|column| column.role == Role::Response)
    }
}

/// Root mean square, the mean included.
pub fn root_mean_square(values: &[f64]) -> f64 {
    (values.iter().map(|value| value * value).sum::<f64>() / values.len() as f64).sqrt()
}

/// A fault of a sensor: it shows gain · y(t (1 + clock_error) − delay) + bias.
#[derive(Debug, Clone, PartialEq)]
pub struct Fault {
    /// The column.
    pub channel: String,
    /// Lateness (s), not negative.
    pub delay: f64,
    /// Relative error of the clock.
    pub clock_error: f64,
    /// Reading over true value.
    pub gain: f64,
    /// In the column's unit.
    pub bias: f64,
}

impl Fault {
    /// None of the sensor of `channel`.
    pub fn none(channel: impl Into<String>) -> Self {
        Self { channel: channel.into(), delay: 0.0, clock_error: 0.0, gain: 1.0, bias: 0.0 }
    }

    /// How many true samples `count` readings reach over.
    pub fn reach(fault: Option<&Self>, count: usize) -> usize {
        count + (count as f64 * fault.map_or(0.0, |fault| fault.clock_error.max(0.0))).ceil() as usize
    }
}

/// A response on a fine grid that begins before the record, from which a sensor's samples are taken.
pub struct Fine {
    /// Values every `step` seconds.
    pub values: Vec<f64>,
    /// Time between them (s).
    pub step: f64,
    /// Time of the first (s), not after the record's start.
    pub start: f64,
}

impl Fine {
    /// What a sensor shows at `count` times `period` apart from 0 on.
    pub fn sample(&self, name: &str, count: usize, period: f64, fault: Option<&Fault>) -> Vec<f64> {
        let fault = fault.filter(|fault| fault.channel == name);
        let fault = fault.cloned().unwrap_or_else(|| Fault::none(name));
        let Fault { delay, clock_error, gain, bias, .. } = fault;
        (0..count)
            .map(|index| {
                let time = index as f64 * period * (1.0 + clock_error) - delay;
                let place = ((time - self.start) / self.step).max(0.0);
                let left = (place.floor() as usize).min(self.values.len() - 1);
                let right = (left + 1).min(self.values.len() - 1);
                let part = place - left as f64;
                gain * (self.values[left] * (1.0 - part) + self.values[right] * part) + bias
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_record_without_a_drive_is_silent_whatever_its_sensors_show() {
        let record = |drive: f64, shown: f64| Record {
            regime: Regime::Steady,
            columns: vec![
                Column::new("excitation", "N", Role::Driven, vec![drive, -drive]),
                Column::new("acceleration:x=0.1", "m/s^2", Role::Response, vec![shown; 2]),
            ],
            told: Vec::new(),
        };
        assert!(record(0.0, 0.0).is_silent());
        assert!(record(0.0, 0.3).is_silent());
        assert!(!record(1.0, 0.0).is_silent());
        let moved = Record { columns: record(0.0, 0.0).columns.split_off(1), ..record(0.0, 0.0) };
        assert!(!moved.is_silent());
    }
}
