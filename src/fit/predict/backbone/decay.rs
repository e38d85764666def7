//! A model's own free decay at measured acceleration amplitudes of a mass or a sensor.

use std::f64::consts::TAU;

use super::mode::SensedMode;
use crate::data::{Channel, Record};
use crate::fit::predict::observed_system::observed_system;
use crate::fit::predict::table::Table;
use crate::fit::ring_down::{Asked, OwnDecay, Start};
use crate::harmonic::{Assembly, mode_at_rest};
use crate::model::Model;
use crate::time::{IntegrationError, Integrator, Ramp, Settings};

/// Far below what frequencies and damping ratios are known by.
const SETTINGS: Settings = Settings { tolerance: 1e-6, step_limit: 1_000_000 };
/// Starts, and as many again, that tell how much depends on the start.
const STARTS: usize = 4;

/// Predictions of a table's columns `frequency` (Hz) and `damping_ratio` at each `amplitude` of a free decay that was cut into
/// windows: those of the model's own decay, cut about the same amplitudes, and of its mode where that does not come to them.
pub(in crate::fit::predict) struct BackboneOfDecay<'r> {
    channels: Vec<&'r Channel>,
    rows: usize,
    decaying: Decaying,
}

/// A model that decays, seen as in a table.
struct Decaying {
    own: OwnDecay,
    /// Of the acceleration (m/s²), row by row.
    amplitudes: Vec<f64>,
    sensed: SensedMode,
}

/// Standard deviations of frequency (Hz) and damping ratio in each row of a table of a free decay, that come of how the decay of `model` is
/// begun: where fewer than two starts come to its amplitude the largest of the others, zero where there are none.
///
/// # Errors
/// What the record or the model lacks.
pub(crate) fn scatter_of_starts(model: &Model, record: &Record) -> Result<Vec<[f64; 2]>, String> {
    let decaying = Decaying::of(model, record)?;
    let starts = (0..STARTS).map(|k| k as f64 / STARTS as f64);
    let starts = starts.flat_map(|cycles| [Start::Running { cycles }, Start::Released { cycles }]);
    let all: Vec<Vec<Option<[f64; 2]>>> =
        starts.map(|start| decaying.shown(model, start)).collect::<Result<_, _>>()?;
    let deviation = |row: usize, column: usize| {
        let values = || all.iter().filter_map(|shown| shown[row]).map(|shown| shown[column]);
        let count = values().count() as f64;
        let mean = values().sum::<f64>() / count;
        let squares: f64 = values().map(|value| (value - mean).powi(2)).sum();
        (count > 1.0).then(|| (squares / (count - 1.0)).sqrt())
    };
    let columns =
        [0, 1].map(|column| filled(&(0..record.len()).map(|row| deviation(row, column)).collect::<Vec<_>>()));
    Ok((0..record.len()).map(|row| columns.each_ref().map(|column| column[row])).collect())
}

/// What is not known, the largest of what is.
fn filled(values: &[Option<f64>]) -> Vec<f64> {
    let largest = values.iter().flatten().copied().fold(0.0, f64::max);
    values.iter().map(|value| value.unwrap_or(largest)).collect()
}

impl<'r> BackboneOfDecay<'r> {
    /// Whether the amplitudes of `record` were taken from a free decay.
    pub fn is_one(record: &Record) -> bool {
        record.channel("window").is_some()
    }

    /// Of `channels` of `record`, for models like `model`.
    pub fn new(model: &Model, record: &'r Record, channels: Vec<&'r Channel>) -> Result<Self, String> {
        Ok(Self { channels, rows: record.len(), decaying: Decaying::of(model, record)? })
    }
}

impl Table for BackboneOfDecay<'_> {
    type Rows = Vec<Option<[f64; 2]>>;

    fn channels(&self) -> &[&Channel] {
        &self.channels
    }

    fn solve(&self, model: &Model) -> Result<Vec<Option<[f64; 2]>>, String> {
        // A model that is far from the measurement may not decay as the table asks.
        let shown = self.decaying.shown(model, Start::Running { cycles: 0.0 }).unwrap_or_default();
        let mut rows: Vec<Option<[f64; 2]>> = (0..self.rows).map(|row| *shown.get(row)?).collect();
        self.decaying.complete(model, &mut rows)?;
        Ok(rows)
    }

    fn show(&self, rows: &Vec<Option<[f64; 2]>>, out: &mut Vec<f64>) {
        for channel in &self.channels {
            let column = usize::from(channel.quantity() == "damping_ratio");
            out.extend(rows.iter().flatten().map(|row| row[column]));
        }
    }
}

impl Decaying {
    /// For models like `model`, as `record` sees it.
    fn of(model: &Model, record: &Record) -> Result<Self, String> {
        let column = |name: &'static str| {
            let channel = record.channels_of(name).next();
            channel.map(|channel| &channel.values).ok_or_else(|| format!("there is no `{name}` column"))
        };
        let (amplitude, window, frequency) = (column("amplitude")?, column("window")?, column("frequency")?);
        let damping = column("damping_ratio").ok();
        let row = |place: usize| Asked {
            place,
            amplitude: amplitude[place],
            window: window[place],
            angular_frequency: TAU * frequency[place],
            damping_ratio: damping.map_or(0.0, |damping| damping[place]),
        };
        let own = OwnDecay::of((0..record.len()).map(row)).ok_or("the table is empty")?;
        Ok(Self { own, amplitudes: amplitude.clone(), sensed: SensedMode::of(model, record)? })
    }

    /// Frequency (Hz) and damping ratio of `model` in each row of which its decay shows the amplitude.
    fn shown(&self, model: &Model, start: Start) -> Result<Vec<Option<[f64; 2]>>, String> {
        let SensedMode { positions, node, mode } = &self.sensed;
        let assembly = Assembly::new(observed_system(model, positions)?);
        let (_, shape) = mode_at_rest(&assembly, *mode, *node).map_err(|error| error.to_string())?;
        let mut integrator = Integrator::new(&assembly.system).map_err(|error| error.to_string())?;
        let scaled = |factor: f64| shape.iter().map(|x| factor * x).collect::<Vec<f64>>();
        let mut own = self.own.clone();
        let [displacement, velocity] = own.begins(start).map(scaled);
        self.let_go(&mut own, &mut integrator, &displacement, &velocity)
            .map_err(|error| format!("its free decay cannot be simulated: {error}"))?;
        Ok(own.shown())
    }

    /// Fills the rows whose amplitude the decay of `model` does not show by what its mode has there.
    fn complete(&self, model: &Model, rows: &mut [Option<[f64; 2]>]) -> Result<(), String> {
        let missing: Vec<usize> = (0..rows.len()).filter(|row| rows[*row].is_none()).collect();
        if missing.is_empty() {
            return Ok(());
        }
        let amplitudes: Vec<f64> = missing.iter().map(|row| self.amplitudes[*row]).collect();
        for (row, found) in missing.into_iter().zip(self.sensed.at(model, &amplitudes)?) {
            rows[row] = Some(found);
        }
        Ok(())
    }

    /// Lets a system go with such displacements and velocities of its coordinates, and contacts that carry what a first loading gives
    /// them.
    fn let_go(
        &self,
        own: &mut OwnDecay,
        integrator: &mut Integrator,
        displacement: &[f64],
        velocity: &[f64],
    ) -> Result<(), IntegrationError> {
        let inputs: Vec<Ramp> = integrator.held_inputs();
        let mut motion = integrator.moving(&vec![0.0; displacement.len()], velocity, &inputs, &[])?;
        if displacement.iter().any(|x| *x != 0.0) {
            integrator.displace(&mut motion, displacement, &inputs)?;
        }
        integrator.take_up(&motion, &inputs)?;
        own.clear();
        while own.push(integrator.sensor(self.sensed.node, 2)) {
            integrator.advance(&mut motion, own.step, &inputs, &SETTINGS)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    #[test]
    fn an_amplitude_that_no_decay_comes_to_is_not_known_best() {
        assert_eq!(super::filled(&[Some(1.0), None, Some(3.0)]), [1.0, 3.0, 3.0]);
        assert_eq!(super::filled(&[None, None]), [0.0, 0.0]);
    }
}
