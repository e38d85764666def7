//! Drawing two masses, what drives them, and what is hidden.

use std::f64::consts::TAU;

use super::{Excitation, Oscillator};
use crate::physics::joint::Joint;
use crate::records::random::Random;
use crate::records::record::Fault;
use crate::rigs::effect::Hidden;
use crate::rigs::joint_effects::{self, Measures};
use crate::rigs::setting::Setting;

/// A multisine has these multiples of its lowest frequency (Hz).
const LINES: std::ops::RangeInclusive<usize> = 3..=35;
const LINE_SPACING: f64 = 1.0 / 0.6;

impl Oscillator {
    /// Draws an experiment in which `effects` are hidden at `strength`.
    ///
    /// # Errors
    /// An effect that cannot be hidden in an oscillator.
    pub fn draw(
        setting: Setting,
        effects: &[&str],
        strength: f64,
        random: &mut Random,
    ) -> Result<Self, String> {
        // How fast the physics is; once leaves all numbers as they are.
        let pace = if setting == Setting::Coarse { 4.0 } else { 1.0 };
        let mut numbers = random.fork();
        let mut pair = |ranges: [(f64, f64); 2]| ranges.map(|(low, high)| numbers.between(low, high));
        let masses = pair([(1.0, 1.5), (1.0, 1.5)]);
        let stiffness = pair([(3.0e4, 4.0e4), (1.3e4, 2.0e4)]).map(|value| pace * pace * value);
        let damping = pair([(2.5, 5.5), (2.0, 4.0)]).map(|value| pace * value);
        let [contact_stiffness, friction] = pair([(5e3, 9e3), (0.3, 0.6)]);
        let contact_stiffness = pace * pace * contact_stiffness;
        let normal_load = numbers.between(20.0, 40.0);
        let joint = Joint::jenkins(contact_stiffness, friction);
        let mut rig = Self::new(masses, stiffness, damping, joint, normal_load);
        rig.load_cell = numbers.unit() < 0.5;
        let limit = friction * normal_load;
        let [free, second] = rig.frequencies(0.0);
        let [stuck, _] = rig.frequencies(contact_stiffness);
        let mut plan = random.fork();
        rig.records = (0..setting.rounds())
            .flat_map(|_| excitations(limit, [free, stuck, second], pace * LINE_SPACING, &mut plan))
            .collect();
        if setting == Setting::Coarse {
            // Lines between the forces that are tabulated would be too small by (ωh)²/12, 4e-4 at four times the pace.
            rig.steps *= 10;
        }
        rig.tells_noise = setting != Setting::NoiseUntold;
        let yield_displacement = limit / contact_stiffness;
        let measures = Measures {
            yield_displacement,
            limit,
            reach: 4.0,
            slow_speed: 0.3 * TAU * free * yield_displacement,
            high_speed: 3.0 * TAU * free * yield_displacement,
            travel: 200.0 * yield_displacement,
            duration: 1.2,
            residual: 0.25,
        };
        for id in effects {
            let mut random = random.fork();
            match setting {
                Setting::MassOff if *id == "added_mass" => rig.mistake_a_mass(strength, &mut random),
                _ => rig.hide(id, strength, &measures, &mut random)?,
            }
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
        let hidden = match joint_effects::hide(id, strength, measures, &mut self.joint, random) {
            Some(hidden) => hidden,
            None => self
                .hide_in_structure(id, strength, measures, random)
                .ok_or_else(|| format!("`{id}` cannot be hidden in an oscillator"))?,
        };
        self.hidden.push(hidden);
        Ok(())
    }

    /// The given model's mass is wrong by 5 %, to either side: what it lacks, or has too much, is an added mass.
    fn mistake_a_mass(&mut self, strength: f64, random: &mut Random) {
        let mass = random.pick(&[0, 1]);
        self.added[mass] = strength * random.sign() * 0.05 * self.masses[mass];
        self.hidden.push(Hidden::at("added_mass", format!("m{}", mass + 1), &[("mass", self.added[mass])]));
    }

    fn hide_in_structure(
        &mut self,
        id: &str,
        strength: f64,
        measures: &Measures,
        random: &mut Random,
    ) -> Option<Hidden> {
        let mass = random.pick(&[0, 1]);
        Some(match id {
            "normal_load_variation" => {
                let share = if random.unit() < 0.2 { 1.25 } else { random.between(0.4, 0.8) };
                self.swing = Some((strength * share, random.between(2.0, 12.0)));
                Hidden::new(id, &[("load_gain", 1.0)])
            }
            "geometric_stiffening" => {
                let amplitude = 9e-3_f64;
                self.cubic_stiffness =
                    strength * random.between(0.07, 0.13) * self.stiffness[0] / amplitude.powi(2);
                Hidden::new(id, &[("cubic_stiffness", self.cubic_stiffness)])
            }
            "quadratic_damping" => {
                self.quadratic_damping = strength * random.between(3.0, 6.0);
                Hidden::new(id, &[("quadratic_damping", self.quadratic_damping)])
            }
            "added_mass" => {
                self.added[mass] = strength * random.between(0.06, 0.12) * self.masses[mass];
                Hidden::at(id, format!("m{}", mass + 1), &[("mass", self.added[mass])])
            }
            "hanging_mass" => {
                let hung = strength * random.between(0.05, 0.12) * self.masses[1];
                let frequency = random.between(8.0, 28.0);
                self.hanging = Some((hung, frequency));
                Hidden::new(id, &[("mass", hung), ("hanging_frequency", frequency)])
            }
            "unknown:periodic_disturbance" => {
                let size = strength * random.between(0.3, 0.6) * measures.limit;
                self.disturbance = Some((size, random.between(9.0, 30.0)));
                Hidden::new(id, &[])
            }
            _ => return self.hide_in_sensor(id, strength, measures, mass, random),
        })
    }

    fn hide_in_sensor(
        &mut self,
        id: &str,
        strength: f64,
        measures: &Measures,
        mass: usize,
        random: &mut Random,
    ) -> Option<Hidden> {
        let channel = format!("displacement:m{}", mass + 1);
        let fault = Fault::none(channel.clone());
        Some(match id {
            "sensor_delay" => {
                let delay = strength * random.between(6e-4, 1.2e-3);
                self.fault = Some(Fault { delay, ..fault });
                Hidden::at(id, channel, &[("delay", delay)])
            }
            "sensor_gain" => {
                let gain = 1.0 + strength * random.sign() * random.between(0.08, 0.2);
                self.fault = Some(Fault { gain, ..fault });
                Hidden::at(id, channel, &[("gain", gain)])
            }
            "sensor_offset" => {
                let bias = strength * random.sign() * random.between(0.3, 0.6) * measures.yield_displacement;
                self.fault = Some(Fault { bias, ..fault });
                Hidden::at(id, channel, &[("bias", bias)])
            }
            "sensor_clock_drift" => {
                let clock_error = strength * random.sign() * random.between(0.002, 0.004);
                self.fault = Some(Fault { clock_error, ..fault });
                Hidden::at(id, channel, &[("clock_error", clock_error)])
            }
            _ => return None,
        })
    }
}

/// Sines around both resonances at several levels, and two multisines.
fn excitations(
    limit: f64,
    [free, stuck, second]: [f64; 3],
    spacing: f64,
    random: &mut Random,
) -> Vec<Excitation> {
    let mut sine = |level: f64, place: f64| {
        let size = level * random.about_one(0.2) * limit;
        let frequency = free + (stuck - free) * (place + random.between(-0.12, 0.12));
        vec![[size, frequency, 0.0]]
    };
    let mut lines = vec![sine(0.5, 0.5), sine(1.85, 0.38), sine(2.7, 0.35), sine(7.0, 0.8)];
    let last = sine(3.6, 0.5);
    let mut multisine = |level: f64| {
        let size = level * random.about_one(0.15) * limit / (LINES.count() as f64 / 2.0).sqrt();
        LINES.map(|line| [size, line as f64 * spacing, random.phase()]).collect::<Vec<_>>()
    };
    lines.push(multisine(2.2));
    lines.push(multisine(5.6));
    lines.push(vec![[2.5 * random.about_one(0.2) * limit, second * random.about_one(0.02), 0.0]]);
    lines.push(last);
    lines.into_iter().map(|lines| Excitation { lines, phases: [random.phase(), random.phase()] }).collect()
}
