//! An oscillator in a steady state under a measured periodic force on one mass, by harmonic balance.

use super::harmonics::RecordHarmonics;
use crate::data::{Channel, Record};
use crate::fit::predict::observed_system::observed_assembly;
use crate::fit::predict::simulation::WRONG_BRANCH;
use crate::fit::predict::stepper::excitation::mass_of;
use crate::harmonic::{Assembly, Control, CurveSettings, HarmonicError, Point, periodic_response};
use crate::model::{Model, Structure};
use crate::numeric::fourier::coefficient_count;

/// Fewest and most harmonics.
const HARMONICS: (usize, usize) = (41, 101);
/// Truncation error of the displacements wanted, as a fraction of the amplitude: friction turns the force round within
/// a short time, which accelerations show.
const TRUNCATION: f64 = 1e-6;
/// Truncation error from which on the record is better shot at.
const UNRESOLVED: f64 = 1e-4;

/// What does not change from one prediction of the record to the next, and the last solution.
pub(super) struct BalancedOscillator {
    measured: RecordHarmonics,
    /// Place of the mass that is excited, and of those that the channels are at.
    excited: usize,
    sensors: Vec<usize>,
    /// Highest harmonic balanced.
    harmonics: usize,
    start: Option<Point>,
}

impl BalancedOscillator {
    /// Of `channels` of `record`, where the balance resolves the response of `model`.
    ///
    /// # Errors
    /// Why it does not.
    pub fn new(model: &Model, record: &Record, channels: &[&Channel]) -> Result<Self, String> {
        let Structure::Oscillator(oscillator) = &model.structure else {
            return Err("it is no oscillator".into());
        };
        let names: Vec<&str> = oscillator.masses.iter().map(|mass| mass.name.as_str()).collect();
        let mut excitations = record.channels_of("excitation");
        let (Some(excitation), None) = (excitations.next(), excitations.next()) else {
            return Err("not one mass is excited".into());
        };
        let sensors = channels.iter().map(|channel| mass_of(&channel.name, &names));
        let mut balance = Self {
            measured: RecordHarmonics::new(record, channels, excitation, |_| HARMONICS.1)?,
            excited: mass_of(&excitation.name, &names)?,
            sensors: sensors.collect::<Result<_, _>>()?,
            harmonics: HARMONICS.0,
            start: None,
        };
        let point = balance.settle(model, &mut Vec::new()).map_err(|error| error.to_string())?;
        // An unknown error is not resolved.
        if point.error_estimate <= UNRESOLVED {
            Ok(balance)
        } else {
            Err("the harmonics left out are too large".into())
        }
    }

    /// Predictions of all channels, one after the other: of the response near the last one settled.
    pub fn predict(&self, model: &Model, out: &mut Vec<f64>) -> Result<(), HarmonicError> {
        let assembly = self.assembly(model)?;
        let point = self.solve(&assembly, self.start.as_ref(), None)?;
        self.show(&point, out);
        Ok(())
    }

    /// The same, of the response near the last one and, where that is not the motion measured, of the one nearest to it,
    /// with as many harmonics as it takes: the start of what follows.
    pub fn settle(&mut self, model: &Model, out: &mut Vec<f64>) -> Result<&Point, HarmonicError> {
        let assembly = self.assembly(model)?;
        let measured = self.measured_motion(&assembly);
        let starts = [self.start.as_ref(), measured.as_ref(), None];
        let given = starts.iter().enumerate().filter(|(place, start)| start.is_some() || *place == 2);
        let mut best: Option<(f64, Point)> = None;
        let mut failure = None;
        let mut near = Vec::new();
        for (_, start) in given {
            match self.solve(&assembly, *start, Some(TRUNCATION)) {
                Ok(point) => {
                    self.show(&point, &mut near);
                    let distance = self.measured.distance(&near);
                    if best.as_ref().is_none_or(|(least, _)| distance < *least) {
                        out.clone_from(&near);
                        best = Some((distance, point));
                    }
                    if distance <= WRONG_BRANCH {
                        break;
                    }
                }
                Err(error) => failure = failure.or(Some(error)),
            }
        }
        let nothing = HarmonicError::InvalidInput("nothing was measured");
        let (_, point) = best.ok_or(failure.unwrap_or(nothing))?;
        self.harmonics = point.harmonics;
        Ok(self.start.insert(point))
    }

    /// The system of `model` under the record's excitation.
    fn assembly(&self, model: &Model) -> Result<Assembly, HarmonicError> {
        let load = self.measured.load.as_deref();
        let system = model.system().map_err(|error| HarmonicError::Model(error.to_string()))?;
        let mut assembly = observed_assembly(system, model, load, 0.0);
        assembly.system.driven = vec![assembly.system.sensors[self.excited]];
        assembly.waveform = self.measured.excitation.clone();
        let highest = assembly.waveform.iter().rposition(|f| *f != 0.0).unwrap_or(0);
        assembly.waveform.truncate(highest + 1);
        Ok(assembly)
    }

    fn solve(
        &self,
        assembly: &Assembly,
        start: Option<&Point>,
        truncation: Option<f64>,
    ) -> Result<Point, HarmonicError> {
        let excited = assembly.waveform.len() / 2;
        let settings = CurveSettings {
            harmonics: self.harmonics.max(excited),
            max_harmonics: HARMONICS.1,
            truncation,
            ..CurveSettings::default()
        };
        let level = Control::Level(1.0);
        periodic_response(assembly, self.measured.angular_frequency, &level, &settings, start)
    }

    /// The laws as they were moved, where every mass beside one was measured.
    fn measured_motion(&self, assembly: &Assembly) -> Option<Point> {
        let system = &assembly.system;
        let count = coefficient_count(self.measured.harmonics);
        let coordinate = |at: usize| -> Option<&Vec<f64>> {
            let own = |sensor: &usize| system.ports[system.sensors[*sensor]].row == [(at, 1.0)];
            let channel = self.sensors.iter().position(own)?;
            self.measured.motion.get(channel).filter(|motion| motion.iter().any(|x| *x != 0.0))
        };
        let moved = |port: usize| -> Option<Vec<f64>> {
            let mut sum = vec![0.0; count];
            for (at, factor) in &system.ports[port].row {
                sum.iter_mut().zip(coordinate(*at)?).for_each(|(sum, x)| *sum += factor * x);
            }
            Some(sum)
        };
        let displacements: Option<Vec<Vec<f64>>> = system.laws().map(|(port, ..)| moved(port)).collect();
        displacements
            .filter(|laws| !laws.is_empty())
            .map(|laws| Point::moved(self.measured.angular_frequency, laws))
    }

    fn show(&self, point: &Point, out: &mut Vec<f64>) {
        let sensors: Vec<f64> =
            self.sensors.iter().flat_map(|sensor| &point.nodes[*sensor]).copied().collect();
        self.measured.observe(&sensors, out);
    }
}
