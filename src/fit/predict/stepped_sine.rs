//! Tables of a stepped sine: the first harmonic of the steady response at measured frequencies and forces, by harmonic balance.

use std::f64::consts::{PI, TAU};

use super::channels::{derivative_order, position};
use super::observed_system::observed_system;
use super::simulation::WRONG_BRANCH;
use super::stepper::excitation::mass_of;
use super::table::Table;
use crate::data::{Channel, Record};
use crate::harmonic::{Assembly, Control, CurveSettings, HarmonicError, Point, periodic_response};
use crate::model::{Model, Structure};

/// Harmonics of the response: its first needs few.
const HARMONICS: usize = 11;
const TOLERANCE: f64 = 1e-9;

/// Predictions of a table's amplitudes, one column per sensor, and phases.
pub(super) struct SteppedSine<'r> {
    channels: Vec<&'r Channel>,
    frequency: &'r [f64],
    force: &'r [f64],
    /// Place of the mass that is excited; `None` of a beam.
    excited: Option<usize>,
    /// Where the sensors of a beam are (m).
    positions: Vec<f64>,
    /// What every channel shows.
    shown: Vec<Shown>,
    /// The last responses, row by row.
    starts: Vec<Point>,
}

/// What a channel shows of the motion.
struct Shown {
    /// Place of the sensor among what is read.
    node: usize,
    /// Times the displacement is differentiated.
    order: usize,
    /// Its phase, not its amplitude.
    is_phase: bool,
}

impl<'r> SteppedSine<'r> {
    /// Of `channels` of `record`, for models of the kind of `model`. A phase is that of the motion measured at its place.
    pub fn new(model: &Model, record: &'r Record, channels: Vec<&'r Channel>) -> Result<Self, String> {
        let frequency = record.channel("frequency").ok_or("there is no `frequency` column")?;
        let force = record.channels_of("excitation").next().ok_or("there is no `excitation` column")?;
        let names: Option<Vec<&str>> = match &model.structure {
            Structure::Oscillator(oscillator) => {
                Some(oscillator.masses.iter().map(|mass| mass.name.as_str()).collect())
            }
            _ => None,
        };
        let moved = |channel: &Channel| channel.quantity() != "phase";
        let place = |channel: &Channel| channel.name.split_once(':').map(|(_, place)| place.to_owned());
        let motion = |channel: &&'r Channel| -> Result<&'r Channel, String> {
            let same = |other: &&&'r Channel| moved(other) && place(other) == place(channel);
            let found = if moved(channel) { Some(*channel) } else { channels.iter().find(same).copied() };
            found.ok_or_else(|| {
                format!("`{}` is the phase of a motion that was not measured there", channel.name)
            })
        };
        let motions: Vec<&Channel> = channels.iter().map(motion).collect::<Result<_, _>>()?;
        let mut positions = Vec::new();
        let mut node = |channel: &Channel| match &names {
            Some(names) => mass_of(&channel.name, names),
            None => {
                positions.push(position(channel)?);
                Ok(positions.len() - 1)
            }
        };
        let shown = |(channel, motion): (&&Channel, &&Channel)| {
            Ok(Shown { node: node(motion)?, order: derivative_order(motion), is_phase: !moved(channel) })
        };
        let shown = channels.iter().zip(&motions).map(shown).collect::<Result<_, String>>()?;
        let excited = names.as_ref().map(|names| mass_of(&force.name, names)).transpose()?;
        let (frequency, force) = (&frequency.values, &force.values);
        Ok(Self { channels, frequency, force, excited, positions, shown, starts: Vec::new() })
    }

    /// The response of a row: near its last one, or else of those found that which is nearest to the measured, which is
    /// sought with its amplitude held, under which there is but one.
    fn response(&self, assembly: &Assembly, row: usize) -> Result<Point, HarmonicError> {
        let settings =
            CurveSettings { harmonics: HARMONICS, tolerance: TOLERANCE, ..CurveSettings::default() };
        let speed = TAU * self.frequency[row];
        let level = Control::Level(self.force[row]);
        let solve = |control: &Control, start: Option<&Point>| {
            periodic_response(assembly, speed, control, &settings, start)
        };
        let last = self.starts.get(row).map(|start| solve(&level, Some(start)));
        let near = |found: &Result<Point, HarmonicError>| {
            found.as_ref().is_ok_and(|point| self.distance(point, row) <= WRONG_BRANCH)
        };
        if let Some(found) = last.filter(|found| near(found) || found.is_ok()) {
            return found;
        }
        let cold = solve(&level, None);
        if near(&cold) {
            return cold;
        }
        let held = self.held(row).and_then(|held| solve(&held, None).ok());
        match (held.map(|held| solve(&level, Some(&held))), cold) {
            (Some(Ok(held)), Ok(cold)) if self.distance(&cold, row) <= self.distance(&held, row) => Ok(cold),
            (Some(Ok(held)), _) => Ok(held),
            (_, cold) => cold,
        }
    }

    /// The first amplitude measured, held.
    fn held(&self, row: usize) -> Option<Control> {
        let (channel, shown) = self.channels.iter().zip(&self.shown).find(|(_, shown)| !shown.is_phase)?;
        let amplitude = channel.values[row];
        Some(Control::Held { node: shown.node, order: 1, derivative: shown.order, amplitude })
            .filter(|_| amplitude > 0.0)
    }

    /// Largest difference of an amplitude from the measured one, as a fraction of it.
    fn distance(&self, point: &Point, row: usize) -> f64 {
        let amplitudes = self.channels.iter().zip(&self.shown).filter(|(_, shown)| !shown.is_phase);
        let apart = amplitudes.map(|(channel, shown)| {
            let measured = channel.values[row].abs();
            (show(point, shown, measured) - measured).abs() / measured.max(f64::MIN_POSITIVE)
        });
        apart.fold(0.0, f64::max)
    }
}

/// What a channel shows of a response; a phase (rad) is that within half a turn of the `measured`.
fn show(point: &Point, shown: &Shown, measured: f64) -> f64 {
    let coefficients = &point.nodes[shown.node];
    let [cosine, sine] = [1, 2].map(|place| coefficients.get(place).copied().unwrap_or(0.0));
    if shown.is_phase {
        // Displacement, and a quarter turn more by every derivative.
        let phase = (-sine).atan2(cosine) + shown.order as f64 * 0.5 * PI;
        phase + TAU * ((measured - phase) / TAU).round()
    } else {
        cosine.hypot(sine) * point.angular_frequency.powi(shown.order as i32)
    }
}

impl Table for SteppedSine<'_> {
    type Rows = Vec<Point>;

    fn channels(&self) -> &[&Channel] {
        &self.channels
    }

    fn solve(&self, model: &Model) -> Result<Vec<Point>, String> {
        let mut assembly = Assembly::new(observed_system(model, &self.positions)?);
        if let Some(mass) = self.excited {
            assembly.system.driven = vec![assembly.system.sensors[mass]];
        }
        let row = |row: usize| {
            self.response(&assembly, row)
                .map_err(|error| format!("at {} Hz and {} N: {error}", self.frequency[row], self.force[row]))
        };
        (0..self.frequency.len()).map(row).collect()
    }

    fn show(&self, rows: &Vec<Point>, out: &mut Vec<f64>) {
        for (channel, shown) in self.channels.iter().zip(&self.shown) {
            out.extend(rows.iter().zip(&channel.values).map(|(row, measured)| show(row, shown, *measured)));
        }
    }

    fn keep(&mut self, rows: Vec<Point>) {
        self.starts = rows;
    }
}
