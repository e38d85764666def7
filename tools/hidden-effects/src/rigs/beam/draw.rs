//! Drawing a beam and what is hidden in it.

use std::f64::consts::TAU;

use super::excitation::{self, Excitation};
use super::{Beam, EXCITATION, SENSORS};
use crate::physics::finite_elements::{Geometry, Modes};
use crate::physics::gradual::Gradual;
use crate::physics::joint::Joint;
use crate::records::random::Random;
use crate::records::record::Fault;
use crate::rigs::effect::Hidden;
use crate::rigs::joint_effects::{self, Measures};
use crate::rigs::setting::Setting;

impl Beam {
    /// Draws an experiment in which `effects` are hidden at `strength`.
    ///
    /// # Errors
    /// An effect that cannot be hidden in a beam.
    pub fn draw(
        setting: Setting,
        effects: &[&str],
        strength: f64,
        random: &mut Random,
    ) -> Result<Self, String> {
        let mut rig = match setting {
            Setting::HeldLevels => Self::of_the_first_paper(random),
            _ => Self::usual(random),
        };
        let limit = rig.joint.friction_coefficient * rig.normal_load;
        let yield_displacement = limit / rig.joint.stiffness;
        let speed = TAU * rig.records[0].frequency * yield_displacement;
        let measures = Measures {
            yield_displacement,
            limit,
            reach: 3.0,
            slow_speed: 0.3 * speed,
            high_speed: 3.0 * speed,
            travel: 100.0 * yield_displacement,
            duration: 0.08,
            residual: 0.15,
        };
        for id in effects {
            match (setting, *id) {
                (Setting::HeldLevels, "micro_slip:valanis") => rig.hide_the_papers_law(),
                _ => rig.hide(id, strength, &measures, &mut random.fork())?,
            }
        }
        Ok(rig)
    }

    fn usual(random: &mut Random) -> Self {
        let mut numbers = random.fork();
        let geometry = Geometry {
            length: 0.6,
            width: 0.04,
            thickness: 0.005,
            density: 7850.0,
            youngs_modulus: numbers.between(1.9e11, 2.1e11),
            point_masses: vec![(0.55, 0.025), (0.3, 0.005), (0.1, 0.005)],
            clamp_stiffness: None,
        };
        let joint = Joint::jenkins(numbers.magnitude(4e6, 8e6), numbers.between(0.4, 0.7));
        let normal_load = numbers.between(130.0, 160.0);
        let damping_ratio = numbers.between(0.003, 0.004);
        let mut plan = random.fork();
        let limit = joint.friction_coefficient * normal_load;
        let records = excitation::forces(&geometry, &joint, limit, &mut plan);
        Self::new(geometry, damping_ratio, joint, normal_load, records)
    }

    /// The first paper's rig with its contact's stiffness and limit (table 3); damping, modulus and the excitation's mass as
    /// they give its linear frequencies.
    fn of_the_first_paper(random: &mut Random) -> Self {
        let geometry = Geometry {
            length: 0.6,
            width: 0.04,
            thickness: 0.005,
            density: 7850.0,
            youngs_modulus: 1.971e11,
            point_masses: vec![(0.55, 0.02515), (0.3, 0.005), (0.1, 0.005)],
            clamp_stiffness: None,
        };
        let normal_load = 147.15;
        let joint = Joint::jenkins(7.9e6, 7.9e6 / 8.7e4 / normal_load);
        Self::new(geometry, 0.003, joint, normal_load, excitation::held_levels(random))
    }

    fn hide_the_papers_law(&mut self) {
        let law = Gradual::Valanis { smoothness: 0.3 };
        self.hidden.extend(joint_effects::replace_sliders(law, &mut self.joint));
    }

    fn new(
        geometry: Geometry,
        damping_ratio: f64,
        joint: Joint,
        normal_load: f64,
        records: Vec<Excitation>,
    ) -> Self {
        Self {
            geometry,
            damping_ratio,
            joint,
            normal_load,
            swing: None,
            cubic_stiffness: 0.0,
            quadratic_damping: 0.0,
            hanging: None,
            fault: None,
            disturbance: 0.0,
            records,
            hidden: Vec::new(),
        }
    }

    fn hide(
        &mut self,
        id: &str,
        strength: f64,
        measures: &Measures,
        random: &mut Random,
    ) -> Result<(), String> {
        let known = if matches!(id, "wear" | "unknown:time_drift") {
            None // no steady state
        } else {
            joint_effects::hide(id, strength, measures, &mut self.joint, random)
        };
        let hidden = known
            .or_else(|| self.hide_in_structure(id, strength, random))
            .or_else(|| self.hide_in_sensor(id, strength, random))
            .ok_or_else(|| format!("`{id}` cannot be hidden in a beam"))?;
        self.hidden.push(hidden);
        Ok(())
    }

    fn hide_in_structure(&mut self, id: &str, strength: f64, random: &mut Random) -> Option<Hidden> {
        let modes = Modes::of(&self.geometry, 1);
        let frequency = modes.angular_frequencies[0];
        // Deflection at the excitation that goes with 150 m/s², and the first mode's stiffness there.
        let deflection = 150.0 / frequency.powi(2);
        let stiffness = (frequency / modes.deflections(EXCITATION)[0]).powi(2);
        Some(match id {
            "normal_load_variation" => {
                self.swing = Some((strength * random.between(0.3, 0.6), random.pick(&[1.0, 2.0])));
                Hidden::new(id, &[("load_gain", 1.0)])
            }
            "geometric_stiffening" => {
                self.cubic_stiffness = strength * random.between(0.04, 0.08) * stiffness / deflection.powi(2);
                Hidden::new(id, &[("cubic_stiffness", self.cubic_stiffness)])
            }
            "quadratic_damping" => {
                self.quadratic_damping = strength * random.between(10.0, 25.0);
                Hidden::new(id, &[("quadratic_damping", self.quadratic_damping)])
            }
            "added_mass" => {
                let place = random.pick(&[0, 0, 1, 2]);
                let mass = strength * random.between(0.012, 0.03);
                self.geometry.point_masses.push((SENSORS[place], mass));
                Hidden::at(id, format!("x={}", SENSORS[place]), &[("mass", mass)])
            }
            "support_compliance" => {
                let bending = self.geometry.bending_stiffness() / self.geometry.length;
                let stiffness = random.between(20.0, 45.0) * bending / strength;
                self.geometry.clamp_stiffness = Some(stiffness);
                Hidden::new(id, &[("clamp_stiffness", stiffness)])
            }
            "hanging_mass" => {
                let mass = strength * random.between(3.0, 8.0);
                let frequency = random.between(56.0, 75.0);
                self.hanging = Some((mass, frequency));
                Hidden::new(id, &[("mass", mass), ("hanging_frequency", frequency)])
            }
            "unknown:periodic_disturbance" => {
                self.disturbance = strength * random.between(0.1, 0.2);
                Hidden::new(id, &[])
            }
            _ => return None,
        })
    }

    fn hide_in_sensor(&mut self, id: &str, strength: f64, random: &mut Random) -> Option<Hidden> {
        let channel = format!("acceleration:x={}", random.pick(&SENSORS));
        let mut fault = Fault::none(channel.clone());
        let parameter = match id {
            "sensor_delay" => {
                fault.delay = strength * random.between(1e-4, 2.5e-4);
                ("delay", fault.delay)
            }
            "sensor_gain" => {
                fault.gain = 1.0 + strength * random.sign() * random.between(0.08, 0.2);
                ("gain", fault.gain)
            }
            "sensor_offset" => {
                fault.bias = strength * random.sign() * random.between(4.0, 10.0);
                ("bias", fault.bias)
            }
            _ => return None,
        };
        self.fault = Some(fault);
        Some(Hidden::at(id, channel, &[parameter]))
    }
}
