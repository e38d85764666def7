//! A beam excited as measured, or held at measured response levels.

mod linearised;
mod steady;
#[cfg(test)]
mod tests;

use std::f64::consts::TAU;

use crate::contact::ContactLaw;
use crate::contact::JointChanges;
use crate::data::{Channel, Record, Regime};
use crate::fit;
use crate::fit::predict::simulation::{Direction, Seed, Simulation};
use crate::harmonic::steady::{ForcedBeam, Start};
use crate::harmonic::{self, LoadedContact, Method, Resonance, Settings};
use crate::model::{Beam, Model, Structure};
use crate::system::ModalBeam;
use crate::time::{self, BeamInputs, BeamIntegrator, Ramp, SensorReading};
use linearised::LinearisedAtMeasurement;
use steady::SteadyRecord;

/// Harmonics at phase resonance: the frequencies of the frictional support are then within 0.1 mHz of those
/// with 15.
const HELD: Settings = Settings { harmonics: 5, method: Method::Exact, tolerance: 1e-9, max_iterations: 40 };

/// Tolerance of the integration from rest, far below the noise of any sensor.
const FROM_REST: time::Settings = time::Settings { tolerance: 1e-6, step_limit: 1_000_000 };

/// Farthest seat of a contact, in elastic displacements at the limit (m): from there on it slips wherever it was.
const MOST_SEATED: f64 = 2.0;
/// The same displacement where a model has no contact to say it.
const NO_REACH: f64 = 1e-9;

/// A model's beam, reduced to its modes, with its contact.
#[derive(Debug)]
pub(super) struct Attached {
    beam: ModalBeam,
    law: Option<Box<dyn ContactLaw>>,
    /// The load (N) where none is measured, else the mean of what the contact follows of the measured one.
    normal_load: f64,
    /// Coefficients `[c1, s1, …]` (N) of what it follows of a measured load's swing.
    load_swing: Vec<f64>,
    /// Displacement (m) at which the contact that never moved has no force.
    seat: f64,
    /// What is changed in the contact: how much of a measured normal load it follows.
    joint: JointChanges,
}

impl Attached {
    /// The model with all its effects, and sensors at `sensors` (m), whatever sensors it lists.
    ///
    /// `load` are the coefficients of the normal load (N) that was measured in a steady state.
    fn new(model: &Model, sensors: &[f64], load: Option<&[f64]>) -> Result<Self, String> {
        let Structure::Beam(beam) = &model.structure else {
            return Err("the model is not a beam".into());
        };
        // Nothing is known of forces at contact points, and models of measurements have none.
        let beam = Beam { sensors: sensors.to_vec(), contact_points: Vec::new(), ..beam.clone() };
        let beam =
            ModalBeam::with_changes(&beam, &model.changes().structure).map_err(|error| error.to_string())?;
        let law = model.law().map_err(|error| error.to_string())?;
        let constant = model.contact.map_or(0.0, |contact| contact.normal_load);
        let joint = model.changes().joint;
        let normal_load = joint.normal_load(constant, load.map(|load| load[0]));
        let gain = joint.load_gain.filter(|gain| *gain != 0.0);
        let load_swing = match (gain, load) {
            (Some(gain), Some([_, swing @ ..])) if swing.iter().any(|x| *x != 0.0) => {
                swing.iter().map(|x| gain * x).collect()
            }
            _ => Vec::new(),
        };
        Ok(Self { beam, law, normal_load, load_swing, seat: 0.0, joint })
    }

    fn contact(&self) -> Option<LoadedContact<'_>> {
        let law = self.law.as_deref()?;
        Some(LoadedContact { law, normal_load: self.normal_load })
    }

    pub fn driven(&self) -> ForcedBeam<'_> {
        ForcedBeam {
            beam: &self.beam,
            contact: self.contact(),
            load_swing: &self.load_swing,
            static_offset: self.seat,
        }
    }
}

/// A model with its nuisances, and what it is attached to.
pub(super) struct At<'a> {
    pub model: &'a Model,
    pub nuisances: &'a [f64],
    pub attached: &'a Attached,
}

/// What a prediction was made of, to know it again.
pub(super) struct Known {
    model: Model,
    nuisances: Vec<f64>,
}

impl At<'_> {
    pub fn known(&self) -> Known {
        Known { model: self.model.clone(), nuisances: self.nuisances.to_vec() }
    }
}

impl Known {
    pub fn is(&self, at: &At) -> bool {
        self.nuisances == at.nuisances && self.model == *at.model
    }
}

/// Predictions of one record of a beam: of the columns `frequency` (Hz) and `damping_ratio` of a backbone, or of
/// every motion measured at a position (`acceleration:x=…`, `velocity:x=…`, `displacement:x=…`) in time.
pub(super) struct BeamSimulation<'r> {
    record: &'r Record,
    channels: Vec<&'r Channel>,
    positions: Vec<f64>,
    task: Task,
}

enum Task {
    Steady(Box<SteadyRecord>),
    /// A steady state to first order about the measured one.
    LinearisedAtMeasurement(Box<LinearisedAtMeasurement>),
    /// The last solutions, one per amplitude.
    Backbone(Vec<Resonance>),
    FromRest,
}

impl<'r> BeamSimulation<'r> {
    /// Of `channels` of `record`, with a discretisation fine enough for models like `model`.
    /// `seed` is a solution of another simulation of the record.
    pub fn new(
        model: &Model,
        record: &'r Record,
        channels: Vec<&'r Channel>,
        seed: Option<&Seed>,
    ) -> Result<Self, String> {
        let positions = match record.regime {
            Regime::Backbone => Vec::new(),
            _ => channels.iter().map(|channel| position(channel)).collect::<Result<_, _>>()?,
        };
        let task = match record.regime {
            Regime::Backbone => Task::Backbone(Vec::new()),
            Regime::FromRest => Task::FromRest,
            Regime::Steady => {
                let highest = Attached::new(model, &positions, None)?.beam.angular_frequency.last().copied();
                let mut steady = SteadyRecord::new(record, &channels, highest.unwrap_or(0.0))?;
                match seed {
                    Some(Seed::LinearisedAtMeasurement) => {
                        Task::LinearisedAtMeasurement(Box::new(LinearisedAtMeasurement::new(steady)))
                    }
                    seed => {
                        if let Some(Seed::Near(start)) = seed {
                            steady.start_from(start);
                        }
                        let attached = Attached::new(model, &positions, steady.load())?;
                        // Without a start later predictions search on their own.
                        let at = At { model, nuisances: &[], attached: &attached };
                        let _ = steady.linearise(&at, &[], &mut Vec::new(), &mut []);
                        Task::Steady(Box::new(steady))
                    }
                }
            }
            Regime::UnknownInitialState => {
                return Err("a beam's record needs the regime `from-rest`, `steady` or `backbone`: the motion at its \
                            start is not measured everywhere"
                    .into());
            }
        };
        Ok(Self { record, channels, positions, task })
    }

    fn attached(&self, model: &Model, nuisances: &[f64]) -> Result<Attached, String> {
        let load = match &self.task {
            Task::Steady(steady) => steady.load(),
            Task::LinearisedAtMeasurement(about) => about.load(),
            Task::Backbone(_) | Task::FromRest => None,
        };
        let seat = nuisances.first().copied().unwrap_or(0.0);
        Ok(Attached { seat, ..Attached::new(model, &self.positions, load)? })
    }

    fn differences(
        &mut self,
        model: &Model,
        directions: &[Direction],
        predictions: &mut Vec<f64>,
        derivatives: &mut [Vec<f64>],
    ) -> Result<(), String> {
        self.predict(model, &[], predictions)?;
        for (direction, derivative) in directions.iter().zip(derivatives) {
            self.predict(&direction.model, &[], derivative)?;
            derivative.iter_mut().zip(&*predictions).for_each(|(moved, base)| *moved -= base);
        }
        Ok(())
    }
}

impl Simulation for BeamSimulation<'_> {
    fn channels(&self) -> &[&Channel] {
        &self.channels
    }

    fn solution(&self) -> Option<&Start> {
        match &self.task {
            Task::Steady(steady) => steady.start(),
            Task::LinearisedAtMeasurement(_) | Task::Backbone(_) | Task::FromRest => None,
        }
    }

    /// Of a steady state where the contact has been seated before.
    fn nuisances(&mut self, model: &Model) -> Result<Vec<fit::Parameter>, String> {
        if !matches!(self.task, Task::Steady(_) | Task::LinearisedAtMeasurement(_)) {
            return Ok(Vec::new());
        }
        let elastic = model
            .contact
            .map(|contact| contact.friction_coefficient * contact.normal_load / contact.tangential_stiffness);
        let reach = elastic.filter(|reach| reach.is_finite() && *reach > 0.0).unwrap_or(NO_REACH);
        let (lower, upper) = (-MOST_SEATED * reach, MOST_SEATED * reach);
        Ok(vec![fit::Parameter { start: 0.0, lower, upper, scale: fit::Scale::Linear }])
    }

    fn predict(&mut self, model: &Model, nuisances: &[f64], out: &mut Vec<f64>) -> Result<(), String> {
        let attached = self.attached(model, nuisances)?;
        let at = At { model, nuisances, attached: &attached };
        match &mut self.task {
            Task::Steady(steady) => steady.predict(&at, out),
            Task::LinearisedAtMeasurement(about) => about.predict(&at, out),
            Task::Backbone(starts) => {
                let points = backbone(&attached, self.record, starts)?;
                observe(&points, &self.channels, out);
                Ok(())
            }
            Task::FromRest => from_rest(&attached, self.record, &self.channels, out),
        }
    }

    fn linearise(
        &mut self,
        model: &Model,
        nuisances: &[f64],
        directions: &[Direction],
        predictions: &mut Vec<f64>,
        derivatives: &mut Vec<Vec<f64>>,
    ) -> Result<(), String> {
        let attached = self.attached(model, nuisances)?;
        let neighbours = || {
            let neighbours =
                directions.iter().map(|direction| self.attached(&direction.model, &direction.nuisances));
            neighbours.collect::<Result<Vec<_>, _>>()
        };
        let neighbours = match self.task {
            Task::Steady(_) | Task::LinearisedAtMeasurement(_) => neighbours()?,
            Task::Backbone(_) | Task::FromRest => Vec::new(),
        };
        let neighbours: Vec<ForcedBeam> = neighbours.iter().map(Attached::driven).collect();
        derivatives.resize_with(directions.len(), Vec::new);
        let at = At { model, nuisances, attached: &attached };
        match &mut self.task {
            Task::Steady(steady) => steady.linearise(&at, &neighbours, predictions, derivatives)?,
            Task::LinearisedAtMeasurement(about) => {
                about.linearise(&at, &neighbours, predictions, derivatives)?
            }
            Task::Backbone(starts) => {
                *starts = backbone(&attached, self.record, starts)?;
                self.differences(model, directions, predictions, derivatives)?;
            }
            Task::FromRest => self.differences(model, directions, predictions, derivatives)?,
        }
        for (direction, derivative) in directions.iter().zip(derivatives) {
            derivative.iter_mut().for_each(|change| *change /= direction.step);
        }
        Ok(())
    }
}

fn position(channel: &Channel) -> Result<f64, String> {
    channel
        .position()
        .ok_or_else(|| format!("`{}` does not say where on the beam it was measured", channel.name))
}

fn backbone(model: &Attached, record: &Record, starts: &[Resonance]) -> Result<Vec<Resonance>, String> {
    let amplitudes = &record.channel("amplitude").ok_or("there is no `amplitude` column")?.values;
    harmonic::backbone(&model.beam, model.contact(), amplitudes, &HELD, starts)
        .map_err(|error| error.to_string())
}

fn observe(points: &[Resonance], channels: &[&Channel], out: &mut Vec<f64>) {
    out.clear();
    for channel in channels {
        match channel.quantity() {
            "damping_ratio" => out.extend(points.iter().map(Resonance::damping_ratio)),
            _ => out.extend(points.iter().map(|point| point.angular_frequency / TAU)),
        }
    }
}

/// The excitation and a measured normal load run linearly from sample to sample.
fn from_rest(
    model: &Attached,
    record: &Record,
    channels: &[&Channel],
    out: &mut Vec<f64>,
) -> Result<(), String> {
    let time = record.time().ok_or("there is no `time` column")?;
    let force = &record.channel("excitation").ok_or("there is no `excitation` column")?.values;
    let measured = record.channel("normal_load");
    let load = |index: usize| {
        model.joint.normal_load(model.normal_load, measured.map(|channel| channel.values[index]))
    };
    let contact = model.contact();
    let mut integrator = BeamIntegrator::new(&model.beam).map_err(|error| error.to_string())?;
    let mut motion = integrator.rest(contact.map(|contact| (contact.law, load(0))));
    let mut outputs = integrator.new_outputs();
    let acting = |from: usize, to: usize| BeamInputs {
        excitation: Ramp { start: force[from], end: force[to] },
        contact: match contact {
            Some(LoadedContact { law, .. }) => {
                time::Contact::Friction { law, normal_load: Ramp { start: load(from), end: load(to) } }
            }
            None => time::Contact::Force(Ramp::held(0.0)),
        },
        at_points: &[],
    };
    out.clear();
    out.resize(channels.len() * time.len(), 0.0);
    for index in 0..time.len() {
        if index > 0 {
            integrator
                .advance(&mut motion, time[index] - time[index - 1], &acting(index - 1, index), &FROM_REST)
                .map_err(|error| error.to_string())?;
        }
        integrator
            .outputs(&motion, f64::INFINITY, &acting(index, index), &mut outputs)
            .map_err(|error| error.to_string())?;
        let predictions = out.iter_mut().skip(index).step_by(time.len());
        for ((channel, value), SensorReading { displacement, velocity, acceleration }) in
            channels.iter().zip(predictions).zip(&outputs.sensors)
        {
            *value = match channel.quantity() {
                "acceleration" => *acceleration,
                "velocity" => *velocity,
                _ => *displacement,
            };
        }
    }
    Ok(())
}
