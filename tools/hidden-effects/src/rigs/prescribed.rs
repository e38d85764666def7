//! Kind `contact`: a bare contact whose displacement is prescribed.

use std::f64::consts::TAU;
use std::fmt::Write;

use crate::motion::drive::{Drive, Motion};
use crate::physics::contact::Contact;
use crate::physics::joint::Joint;
use crate::records::random::Random;
use crate::records::record::{Column, Fault, Fine, Record, Regime, Role};
use crate::rigs::effect::Hidden;
use crate::rigs::joint_effects::{self, Measures};
use crate::rigs::rig::Rig;
use crate::rigs::setting::Setting;

/// Steps of the simulation between samples.
const STEPS: usize = 32;
/// A contact in a test machine.
#[derive(Clone)]
pub struct Prescribed {
    drive: Drive,
    joint: Joint,
    normal_load: f64,
    normal: Option<Normal>,
    motions: Vec<Motion>,
    fault: Option<Fault>,
    disturbance: Option<(f64, f64)>,
    /// Multiple of a sensor's usual delay.
    lateness: f64,
    hidden: Vec<Hidden>,
}

/// What the normal direction does.
#[derive(Clone)]
enum Normal {
    /// The load swings by a fraction of its mean, at a multiple of the motion's frequency.
    Swing { share: f64, multiple: f64 },
    /// The approach swings, and the load follows it: stiffness (N/m), cubic stiffness (N/m³), Hunt and
    /// Crossley's factor (s/m).
    Approach { amplitude: f64, multiple: f64, stiffness: f64, cubic: f64, impact: f64 },
}

impl Prescribed {
    /// Draws an experiment in which `effects` are hidden at `strength`.
    ///
    /// # Errors
    /// An effect that cannot be hidden in a bare contact.
    pub fn draw(
        drive: Drive,
        setting: Setting,
        effects: &[&str],
        strength: f64,
        random: &mut Random,
    ) -> Result<Self, String> {
        let mut numbers = random.fork();
        let stiffness = numbers.magnitude(3e6, 9e6);
        let joint = Joint::jenkins(stiffness, numbers.between(0.35, 0.7));
        let normal_load = numbers.between(50.0, 180.0);
        let limit = joint.friction_coefficient * normal_load;
        let yield_displacement = limit / stiffness;
        let motions = (0..setting.rounds()).flat_map(|_| drive.motions(yield_displacement, random)).collect();
        let mut rig = Self {
            drive,
            joint,
            normal_load,
            normal: None,
            motions,
            fault: None,
            disturbance: None,
            lateness: if setting == Setting::LongDelay { 2.7 } else { 1.0 },
            hidden: Vec::new(),
        };
        let measures = Measures {
            yield_displacement,
            limit,
            reach: 6.0,
            slow_speed: TAU * yield_displacement,
            high_speed: TAU * 5.0 * 6.0 * yield_displacement,
            travel: drive.travel() * yield_displacement,
            duration: 3.0,
            residual: 0.12,
        };
        for id in effects {
            rig.hide(id, strength, &measures, &mut random.fork())?;
        }
        Ok(rig)
    }

    fn hide(
        &mut self,
        id: &str,
        strength: f64,
        measures: &Measures,
        random: &mut Random,
    ) -> Result<(), String> {
        if let Some(hidden) = joint_effects::hide(id, strength, measures, &mut self.joint, random) {
            self.hidden.push(hidden);
            return Ok(());
        }
        let force = || "force".to_owned();
        let hidden = match id {
            "normal_load_variation" => {
                let lifts_off = random.unit() < 0.2;
                let share = if lifts_off { 1.25 } else { random.between(0.3, 0.7) };
                self.normal =
                    Some(Normal::Swing { share: strength * share, multiple: random.between(0.4, 2.3) });
                Hidden::new(id, &[("load_gain", 1.0)])
            }
            "normal_hardening" | "impact_damping" => self.press(id, strength, random),
            "sensor_delay" => {
                let delay = self.lateness * strength * random.between(0.004, 0.007);
                self.fault = Some(Fault { delay, ..Fault::none(force()) });
                Hidden::at(id, force(), &[("delay", delay)])
            }
            "sensor_offset" => {
                let bias = strength * random.sign() * random.between(0.1, 0.25) * measures.limit;
                self.fault = Some(Fault { bias, ..Fault::none(force()) });
                Hidden::at(id, force(), &[("bias", bias)])
            }
            "sensor_clock_drift" => {
                let clock_error = strength * random.sign() * random.between(0.01, 0.02);
                self.fault = Some(Fault { clock_error, ..Fault::none(force()) });
                Hidden::at(id, force(), &[("clock_error", clock_error)])
            }
            "unknown:periodic_disturbance" => {
                self.disturbance =
                    Some((strength * random.between(0.1, 0.2) * measures.limit, random.between(2.3, 4.7)));
                Hidden::new(id, &[])
            }
            _ => return Err(format!("`{id}` cannot be hidden in a bare contact")),
        };
        self.hidden.push(hidden);
        Ok(())
    }

    fn press(&mut self, id: &str, strength: f64, random: &mut Random) -> Hidden {
        let stiffness = random.magnitude(1e7, 3e7);
        let amplitude = random.between(0.3, 0.5) * self.normal_load / stiffness;
        let multiple = random.between(0.4, 2.3);
        let (mut cubic, mut impact) = (0.0, 0.0);
        let parameter = if id == "normal_hardening" {
            cubic = strength * random.between(0.2, 0.4) * stiffness / amplitude.powi(2);
            ("normal_cubic_stiffness", cubic)
        } else {
            // At 5 Hz the factor swings by a third.
            impact = strength * random.between(0.25, 0.4) / (TAU * 5.0 * multiple * amplitude);
            ("impact_damping", impact)
        };
        self.normal = Some(Normal::Approach { amplitude, multiple, stiffness, cubic, impact });
        Hidden::new(id, &[parameter])
    }

    /// Normal load and approach at a time.
    fn normal(&self, motion: &Motion, time: f64) -> (f64, f64) {
        let angle = |multiple: f64| TAU * multiple * motion.pace * time + motion.phases[0];
        match &self.normal {
            None => (self.normal_load, 0.0),
            Some(Normal::Swing { share, multiple }) => {
                (self.normal_load * (1.0 + share * angle(*multiple).sin()), 0.0)
            }
            Some(Normal::Approach { amplitude, multiple, stiffness, cubic, impact }) => {
                let approach = amplitude * angle(*multiple).sin();
                let speed = TAU * multiple * motion.pace * amplitude * angle(*multiple).cos();
                let elastic = self.normal_load + stiffness * approach + cubic * approach.powi(3);
                ((elastic * (1.0 + impact * speed)).max(0.0), approach)
            }
        }
    }

    fn record(&self, motion: &Motion) -> Record {
        let step = motion.period / STEPS as f64;
        let times = motion.times();
        let force = self.force(motion, step);
        let normals = times.iter().map(|time| self.normal(motion, *time));
        let (loads, approaches): (Vec<f64>, Vec<f64>) = normals.unzip();
        let displacement = times.iter().map(|time| motion.displacement(*time)).collect();
        let shown = force.sample("force", motion.samples, motion.period, self.fault.as_ref());
        let mut columns = vec![
            Column::new("time", "s", Role::Exact, times),
            Column::new("displacement", "m", Role::Prescribed, displacement),
            Column::new("force", "N", Role::Response, shown),
            Column::new("normal_load", "N", Role::Driven, loads),
        ];
        if let Some(Normal::Approach { .. }) = self.normal {
            columns.push(Column::new("normal_displacement", "m", Role::Prescribed, approaches));
        }
        Record { regime: motion.regime, columns, told: Vec::new() }
    }

    /// The contact force on the fine grid, from before the record's start as far as a late sensor looks back,
    /// and beyond its end as far as one of a slow clock looks ahead.
    fn force(&self, motion: &Motion, step: f64) -> Fine {
        let late = self.fault.as_ref().map_or(0.0, |fault| fault.delay);
        // One sample at least: a contact that is put down at the first sample has no speed there yet.
        let before = ((late / motion.period).ceil() as usize).max(1) * STEPS;
        let history = match motion.stretch {
            None => 800 * STEPS,
            Some(_) => before,
        };
        let start = -(history as f64) * step;
        let mut contact = match motion.stretch {
            Some(stretch) if motion.regime == Regime::UnknownInitialState => {
                let elongation =
                    stretch * self.joint.friction_coefficient * self.normal_load / self.joint.stiffness;
                Contact::stretched(&self.joint, motion.displacement(start), elongation)
            }
            _ => Contact::at_rest(&self.joint, 0.0),
        };
        let count = history + (Fault::reach(self.fault.as_ref(), motion.samples) - 1) * STEPS + 1;
        let values = (0..count)
            .map(|index| {
                let time = (index as f64 - history as f64) * step;
                if index == history {
                    contact.begin_record();
                }
                let disturbance = self.disturbance.map_or(0.0, |(size, frequency)| {
                    size * (TAU * frequency * time + motion.phases[1]).sin()
                });
                let load = self.normal(motion, time).0;
                contact.advance(motion.displacement(time), load, step, time) + disturbance
            })
            .collect();
        Fine { values, step, start }
    }
}

impl Rig for Prescribed {
    fn respond(&self) -> Vec<Record> {
        self.motions.iter().map(|motion| self.record(motion)).collect()
    }

    fn base(&self) -> Vec<f64> {
        vec![self.joint.stiffness, self.joint.friction_coefficient]
    }

    fn with_base(&self, values: &[f64]) -> Box<dyn Rig> {
        let mut rig = self.clone();
        (rig.joint.stiffness, rig.joint.friction_coefficient) = (values[0], values[1]);
        Box::new(rig)
    }

    fn plain(&self) -> Box<dyn Rig> {
        let joint = Joint::jenkins(self.joint.stiffness, self.joint.friction_coefficient);
        let normal = match self.normal.clone() {
            Some(Normal::Approach { amplitude, multiple, stiffness, .. }) => {
                Some(Normal::Approach { amplitude, multiple, stiffness, cubic: 0.0, impact: 0.0 })
            }
            _ => None,
        };
        Box::new(Self { joint, normal, fault: None, disturbance: None, hidden: Vec::new(), ..self.clone() })
    }

    fn ignorance(&self) -> Vec<f64> {
        vec![0.15, 0.15]
    }

    fn model(&self, off: &[f64]) -> String {
        let mut text = String::from("schema = \"stickslip.model/1\"\nkind = \"contact\"\n\n");
        let (stiffness, friction) = (self.joint.stiffness * off[0], self.joint.friction_coefficient * off[1]);
        contact_table(&mut text, "", stiffness, friction, self.normal_load);
        if let Some(Normal::Approach { stiffness, .. }) = self.normal {
            let _ = writeln!(text, "normal_stiffness = {stiffness}");
        }
        text
    }

    fn hidden(&self) -> &[Hidden] {
        &self.hidden
    }

    /// Periods show the noise of stationary records. Where nothing repeats it is read off while the machine stands
    /// still, before a record from rest.
    fn tells_noise(&self, regime: Regime) -> bool {
        self.drive == Drive::Moving && regime == Regime::FromRest
    }
}

/// Writes `[contact]`.
pub fn contact_table(
    text: &mut String,
    at: &str,
    stiffness: f64,
    friction_coefficient: f64,
    normal_load: f64,
) {
    let _ = write!(
        text,
        "[contact]\n{at}law = \"jenkins\"\ntangential_stiffness = {stiffness}\n\
         friction_coefficient = {friction_coefficient}\nnormal_load = {normal_load}\n"
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn at_its_first_sample_a_record_is_in_motion_already() {
        for drive in [Drive::Stationary, Drive::Moving] {
            let damped =
                Prescribed::draw(drive, Setting::Usual, &["contact_damping"], 1.0, &mut Random::new(3))
                    .unwrap();
            let mut plain = damped.clone();
            plain.joint.damping = 0.0;
            for (motion, (with, without)) in
                damped.motions.iter().zip(damped.respond().iter().zip(plain.respond()))
            {
                let first = |record: &Record| record.responses().next().unwrap().values[0];
                let around = 1e-4 * motion.period;
                let speed = |time: f64| {
                    (motion.displacement(time + around) - motion.displacement(time - around)) / (2.0 * around)
                };
                let fastest =
                    motion.times().into_iter().map(speed).fold(0.0_f64, |most, v| most.max(v.abs()));
                let difference = first(with) - first(&without);
                assert!(
                    (difference / damped.joint.damping - speed(0.0)).abs() < 2e-3 * fastest,
                    "{difference} {fastest}"
                );
            }
        }
    }
}
