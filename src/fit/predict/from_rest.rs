//! Records that begin at rest: nothing moves and nothing is remembered at the first sample.

use super::simulation::Simulation;
use super::stepper::contact::MovedContact;
use super::stepper::system::ExcitedSystem;
use super::stepper::{Stepper, march};
use crate::data::{Channel, Record};
use crate::model::{Model, Structure};

/// The simulation of one record from rest.
pub(super) struct FromRest<'r> {
    channels: Vec<&'r Channel>,
    samples: usize,
    excited: Excited<'r>,
}

/// What the record drives, by the kind of model.
enum Excited<'r> {
    Contact(MovedContact<'r>),
    System(ExcitedSystem),
}

impl<'r> FromRest<'r> {
    /// Of `channels` of `record`, for models of the kind of `model`.
    pub fn new(model: &Model, record: &'r Record, channels: Vec<&'r Channel>) -> Result<Self, String> {
        let excited = match &model.structure {
            Structure::Prescribed => Excited::Contact(MovedContact::new(record, channels.clone())?),
            _ => Excited::System(ExcitedSystem::new(model, record, &channels)?),
        };
        Ok(Self { channels, samples: record.len(), excited })
    }
}

impl Simulation for FromRest<'_> {
    fn channels(&self) -> &[&Channel] {
        &self.channels
    }

    fn is_timed(&self, channel: &Channel) -> bool {
        matches!(&self.excited, Excited::Contact(contact) if contact.is_timed(channel))
    }

    fn refine(&mut self, finer: usize) {
        if let Excited::System(system) = &mut self.excited {
            system.finer = finer;
        }
    }

    fn predict(&mut self, model: &Model, _: &[f64], out: &mut Vec<f64>) -> Result<(), String> {
        match &mut self.excited {
            Excited::Contact(contact) => {
                let law = contact.drive(model)?;
                contact.stepper(law.as_ref()).march(out);
                Ok(())
            }
            Excited::System(system) => {
                let mut stepper = system.stepper(model)?;
                stepper.rest();
                march(&mut stepper, self.channels.len(), self.samples, out)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::Regime;

    const SAMPLE_STEP: f64 = 5e-4;
    const SAMPLES: usize = 400;
    /// The mass of the contact (kg).
    const MASS: f64 = 1.27;

    /// Two masses, a contact of a stiffness (N/m) at the second, and what `effects` add.
    fn oscillator(stiffness: f64, effects: &str) -> Model {
        let text = format!(
            "schema = \"stickslip.model/1\"\nkind = \"oscillator\"\n\
             [[mass]]\nname = \"m1\"\nmass = 1.06\n[[mass]]\nname = \"m2\"\nmass = {MASS}\n\
             [[spring]]\nbetween = [\"ground\", \"m1\"]\nstiffness = 36082.0\ndamping = 3.4\n\
             [[spring]]\nbetween = [\"m1\", \"m2\"]\nstiffness = 16900.0\ndamping = 3.5\n\
             [contact]\nat = \"m2\"\nlaw = \"jenkins\"\ntangential_stiffness = {stiffness}\n\
             friction_coefficient = 0.51\nnormal_load = 30.0\n{effects}"
        );
        Model::parse(&text).unwrap()
    }

    /// A record from rest under a force (N) over time (s) on the first mass.
    fn record(force: impl Fn(f64) -> f64) -> Record {
        let time: Vec<f64> = (0..SAMPLES).map(|i| i as f64 * SAMPLE_STEP).collect();
        let channel = |name: &str, unit, values| Channel { name: name.into(), unit, values, noise: None };
        let channels = vec![
            channel("displacement:m1", "m", vec![0.0; SAMPLES]),
            channel("displacement:m2", "m", vec![0.0; SAMPLES]),
            channel("acceleration:m2", "m/s\u{b2}", vec![0.0; SAMPLES]),
            channel("excitation:m1", "N", time.iter().map(|t| force(*t)).collect()),
            channel("time", "s", time),
        ];
        Record { name: "r".into(), regime: Regime::FromRest, use_for: None, channels }
    }

    /// Errors of the three channels over their size.
    fn errors(model: &Model, record: &Record) -> [f64; 3] {
        let run = |finer: usize| {
            let mut out = Vec::new();
            let mut simulation = FromRest::new(model, record, record.channels[..3].iter().collect()).unwrap();
            simulation.refine(finer);
            simulation.predict(model, &[], &mut out).unwrap();
            out
        };
        let (plain, fine) = (run(1), run(16));
        let size = |values: &[f64]| values.iter().map(|x| x * x).sum::<f64>().sqrt();
        let mut channels =
            plain.chunks_exact(SAMPLES).zip(fine.chunks_exact(SAMPLES)).map(|(plain, fine)| {
                let error: Vec<f64> = plain.iter().zip(fine).map(|(plain, fine)| plain - fine).collect();
                size(&error) / size(fine)
            });
        std::array::from_fn(|_| channels.next().unwrap())
    }

    #[test]
    fn what_hangs_at_a_contact_far_above_the_sampling_leaves_the_error_as_small() {
        let tones = |t: f64| (190.0 * t).sin() + 0.7 * (131.0 * t).sin() + 0.5 * (57.0 * t).cos();
        let smooth = record(|t| 40.0 * (t / 0.02).min(1.0) * tones(t));
        let jumps = record(|t| 40.0 * (90.0 * t).sin().signum());
        let laws = [
            "",
            "[[effect]]\nid = \"micro_slip\"\nspread = 0.8\n",
            "[[effect]]\nid = \"velocity_weakening\"\nweakening = 0.3\nweakening_velocity = 0.02\n",
            "[[effect]]\nid = \"contact_damping\"\ndamping = 20.0\n",
        ];
        for (law, stiffness, record) in
            laws.into_iter().flat_map(|law| [(law, 6e3, &smooth), (law, 6e4, &smooth), (law, 6e3, &jumps)])
        {
            let alone = errors(&oscillator(stiffness, law), record);
            for (mass, angle) in [(0.02, 1.1), (0.5, 2.0), (0.5, 4.1), (3.0, 9.0), (3.0, 40.0)] {
                // Together with the second mass so many times half the sampling rate.
                let frequency = angle / (2.0 * SAMPLE_STEP) / f64::sqrt(1.0 + mass / MASS);
                let hung = format!(
                    "[[effect]]\nid = \"hanging_mass\"\nmass = {mass}\nhanging_frequency = {frequency}\n"
                );
                let found = errors(&oscillator(stiffness, &format!("{law}{hung}")), record);
                // Accelerations of a heavy mass are small beside those that a corner of the force makes at once.
                for (channel, most) in [2.5 * alone[0], 2.5 * alone[1], 0.02].into_iter().enumerate() {
                    let error = found[channel];
                    assert!(
                        error < most,
                        "{law}{stiffness} N/m, {hung}channel {channel}: {error:e}, {alone:?}"
                    );
                }
            }
        }
    }
}
