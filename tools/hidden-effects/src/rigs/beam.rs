//! Kind `beam`: a beam whose end rubs on a support, in steady states around its first two resonances.
//!
//! Modes by finite elements, integrated by the leapfrog scheme until a period repeats the one before.

use std::f64::consts::TAU;
use std::fmt::Write;

use crate::physics::finite_elements::{Geometry, Modes};
use crate::physics::friction::{Contact, Joint};
use crate::records::random::Random;
use crate::records::record::{Column, Fault, Fine, Record, Regime, Role};
use crate::rigs::effect::Hidden;
use crate::rigs::joint_effects::{self, Measures};
use crate::rigs::prescribed::contact_table;
use crate::rigs::rig::Rig;

const MODES: usize = 6;
/// Samples of a period, periods of a record, steps of the simulation between samples.
const SAMPLES: usize = 128;
const PERIODS: usize = 4;
const STEPS: usize = 32;
/// The steady state is reached when a period repeats the one before within this fraction of its size ...
const STEADY: f64 = 3e-6;
/// ... or given up after so many periods.
const MOST_PERIODS: usize = 1500;
/// A level at which the motion never repeats itself is replaced by one of these multiples.
const OTHER_LEVELS: [f64; 7] = [1.0, 0.8, 1.25, 0.6, 1.6, 0.4, 0.2];
const SENSORS: [f64; 3] = [0.55, 0.3, 0.1];
const EXCITATION: f64 = 0.55;
const OFFSET: f64 = 0.006;
/// Excitation over the limit, and frequency: mode, and place between its resonance in stick (0) and in slip (1).
const PLAN: [(f64, usize, f64); 8] = [
    (0.00055, 0, 0.0),
    (0.15, 0, 0.3),
    (0.205, 0, 0.85),
    (0.21, 0, 0.6),
    (0.33, 0, 1.0),
    (0.50, 0, 1.45),
    (0.004, 1, 0.0),
    (0.175, 1, 0.8),
];

/// The beam with its support.
#[derive(Clone)]
pub struct Beam {
    geometry: Geometry,
    damping_ratio: f64,
    joint: Joint,
    normal_load: f64,
    /// Swing of the normal load: share, and harmonic of the excitation.
    swing: Option<(f64, f64)>,
    cubic_stiffness: f64,
    quadratic_damping: f64,
    /// Mass (kg) and frequency (Hz) of a resonator hung at the contact.
    hanging: Option<(f64, f64)>,
    fault: Option<Fault>,
    /// Fraction of the excitation that comes as its third harmonic and is not measured.
    disturbance: f64,
    records: Vec<Excitation>,
    hidden: Vec<Hidden>,
}

#[derive(Clone)]
struct Excitation {
    size: f64,
    frequency: f64,
    phase: f64,
    phases: [f64; 2],
}

/// The resonator's damping ratio, that its own free motion may end.
const HANGING_DAMPING: f64 = 0.003;

impl Beam {
    /// Draws an experiment in which `effects` are hidden at `strength`.
    pub fn draw(effects: &[&str], strength: f64, random: &mut Random) -> Result<Self, String> {
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
        let records = excitations(&geometry, &joint, joint.friction_coefficient * normal_load, &mut plan);
        let limit = joint.friction_coefficient * normal_load;
        let yield_displacement = limit / joint.stiffness;
        let speed = TAU * records[0].frequency * yield_displacement;
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
        let mut rig = Self {
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

    fn load(&self, excitation: &Excitation, angle: f64) -> f64 {
        let swing = self
            .swing
            .map_or(0.0, |(share, harmonic)| share * (harmonic * angle + excitation.phases[0]).sin());
        self.normal_load * (1.0 + swing)
    }

    fn record(&self, modes: &Modes, planned: &Excitation) -> Record {
        let mut levels =
            OTHER_LEVELS.iter().map(|level| Excitation { size: level * planned.size, ..planned.clone() });
        let found =
            levels.find_map(|excitation| Some((Motion::new(self, modes, &excitation).steady()?, excitation)));
        let (fine, excitation) = found.unwrap_or_else(|| self.silence(planned));
        let excitation = &excitation;
        let period = 1.0 / excitation.frequency / SAMPLES as f64;
        let count = SAMPLES * PERIODS;
        let times: Vec<f64> = (0..count).map(|index| index as f64 * period).collect();
        let angle = |time: &f64| TAU * excitation.frequency * time;
        let force =
            times.iter().map(|time| excitation.size * (angle(time) + excitation.phase).cos()).collect();
        let loads = times.iter().map(|time| self.load(excitation, angle(time))).collect();
        let mut columns = vec![
            Column::new("time", "s", Role::Exact, times),
            Column::new("excitation", "N", Role::Driven, force),
        ];
        for (position, fine) in SENSORS.iter().zip(&fine) {
            let name = format!("acceleration:x={position}");
            let shown = fine.sample(&name, count, period, self.fault.as_ref());
            columns.push(Column::new(name, "m/s^2", Role::Response, shown));
        }
        if self.swing.is_some() {
            columns.push(Column::new("normal_load", "N", Role::Driven, loads));
        }
        Record { regime: Regime::Steady, columns, told: Vec::new() }
    }
}

impl Beam {
    /// A record of nothing, should no level give a steady state.
    fn silence(&self, planned: &Excitation) -> ([Fine; 3], Excitation) {
        let fine = SENSORS.map(|_| Fine { values: vec![0.0; 2], step: 1.0, start: 0.0 });
        (fine, Excitation { size: 0.0, ..planned.clone() })
    }
}

/// The beam in motion.
struct Motion<'a> {
    beam: &'a Beam,
    modes: &'a Modes,
    excitation: &'a Excitation,
    contact: Contact<'a>,
    slopes: Vec<f64>,
    driven: Vec<f64>,
    sensors: [Vec<f64>; 3],
    /// Modal stiffnesses with which the scheme's steps, not only their limit, oscillate at the natural frequencies: a
    /// high harmonic of the excitation at a resonance shows a frequency that is off by its damping ratio's hundredth.
    stiffnesses: Vec<f64>,
    /// ∫ φ1'² of the first mode with unit deflection at the excitation.
    stretching: f64,
    step: f64,
    /// Modal coordinates now and a step before, the resonator's last.
    now: [f64; MODES + 1],
    before: [f64; MODES + 1],
    /// Force through the contact's point, contact and resonator.
    force: f64,
}

impl<'a> Motion<'a> {
    fn new(beam: &'a Beam, modes: &'a Modes, excitation: &'a Excitation) -> Self {
        let driven = modes.deflections(EXCITATION);
        let step = 1.0 / excitation.frequency / (SAMPLES * STEPS) as f64;
        let stepped = |w: &f64| (2.0 / step * (0.5 * w * step).sin()).powi(2);
        Self {
            beam,
            modes,
            excitation,
            contact: Contact::at_rest(&beam.joint, 1.0 / beam.geometry.axial_stiffness()),
            slopes: modes.slopes_at_pin().iter().map(|slope| OFFSET * slope).collect(),
            stretching: modes.shortening[0][0] / driven[0].powi(2),
            driven,
            sensors: SENSORS.map(|position| modes.deflections(position)),
            stiffnesses: modes.angular_frequencies.iter().map(stepped).collect(),
            step,
            now: [0.0; MODES + 1],
            before: [0.0; MODES + 1],
            force: 0.0,
        }
    }

    /// Marches until a period repeats the one before, and takes a record from there on; `None` when it never does.
    fn steady(mut self) -> Option<[Fine; 3]> {
        let cycle = SAMPLES * STEPS;
        let mut last = vec![0.0; SAMPLES];
        let mut index = 0;
        let mut steady = false;
        for _ in 0..MOST_PERIODS {
            let (mut change, mut size) = (0.0, 0.0);
            for place in 0..cycle {
                let acceleration = self.advance(index);
                index += 1;
                if place % STEPS == 0 {
                    let shown = dot(&self.sensors[0], &acceleration);
                    change += (shown - last[place / STEPS]).powi(2);
                    size += shown * shown;
                    last[place / STEPS] = shown;
                }
            }
            if change < STEADY * STEADY * size {
                steady = true;
                break;
            }
        }
        if !steady {
            return None;
        }
        // A period more before the record's start, for sensors that are late.
        let count = (PERIODS + 1) * cycle + 1;
        let mut shown = SENSORS.map(|_| Vec::with_capacity(count));
        for _ in 0..count {
            let acceleration = self.advance(index);
            index += 1;
            for (values, shape) in shown.iter_mut().zip(&self.sensors) {
                values.push(dot(shape, &acceleration));
            }
        }
        let start = -(cycle as f64) * self.step;
        Some(shown.map(|values| Fine { values, step: self.step, start }))
    }

    /// One step of the leapfrog scheme; the modal accelerations at its start.
    fn advance(&mut self, index: usize) -> [f64; MODES] {
        let beam = self.beam;
        let cycle = SAMPLES * STEPS;
        let angle = TAU * (index % cycle) as f64 / cycle as f64;
        let time = index as f64 * self.step;
        let q = self.now;
        let velocity: [f64; MODES] = std::array::from_fn(|i| (q[i] - self.before[i]) / self.step);
        let mut turned = [0.0; MODES]; // Σ_j q_j ∫φ_i'φ_j'
        for (value, row) in turned.iter_mut().zip(&self.modes.shortening) {
            *value = dot(row, &q[..MODES]);
        }
        let shortened = dot(&turned, &q[..MODES]);
        let moved = dot(&self.slopes, &q[..MODES]) - 0.5 * shortened;
        let hung = self.hanging(moved);
        let given = moved - hung.0 / beam.geometry.axial_stiffness();
        self.force = hung.0 + self.contact.advance(given, beam.load(self.excitation, angle), self.step, time);
        let speed = dot(&self.driven, &velocity);
        let excitation = self.excitation.size
            * ((angle + self.excitation.phase).cos()
                + beam.disturbance * (3.0 * angle + self.excitation.phases[1]).cos());
        let at_excitation = excitation - beam.quadratic_damping * speed.abs() * speed;
        let stretching = beam.cubic_stiffness * shortened / self.stretching.powi(2);
        let mut acceleration = [0.0; MODES];
        let mut next = [0.0; MODES + 1];
        for i in 0..MODES {
            let w = self.modes.angular_frequencies[i];
            let outer = at_excitation * self.driven[i]
                - self.stiffnesses[i] * q[i]
                - self.force * (self.slopes[i] - turned[i])
                - stretching * turned[i];
            // Damping by the central difference, solved for the next value.
            let damping = beam.damping_ratio * w * self.step;
            next[i] = (2.0 * q[i] - self.before[i] * (1.0 - damping) + self.step * self.step * outer)
                / (1.0 + damping);
            acceleration[i] = (next[i] - 2.0 * q[i] + self.before[i]) / (self.step * self.step);
        }
        next[MODES] = 2.0 * q[MODES] - self.before[MODES] + self.step * self.step * hung.1;
        self.before = q;
        self.now = next;
        acceleration
    }

    /// Force of the resonator on the contact's point, and its acceleration. The point itself is `moved` plus the
    /// stretch of the beam under the force of the step before.
    fn hanging(&self, moved: f64) -> (f64, f64) {
        let Some((mass, frequency)) = self.beam.hanging else { return (0.0, 0.0) };
        let w = TAU * frequency;
        let point = moved - self.force / self.beam.geometry.axial_stiffness();
        let speed = (self.now[MODES] - self.before[MODES]) / self.step;
        let pull = w * w * (point - self.now[MODES]);
        (mass * pull, pull - 2.0 * HANGING_DAMPING * w * speed)
    }
}

fn dot(left: &[f64], right: &[f64]) -> f64 {
    left.iter().zip(right).map(|(a, b)| a * b).sum()
}

/// Levels around the resonances in stick and in slip.
fn excitations(geometry: &Geometry, joint: &Joint, limit: f64, random: &mut Random) -> Vec<Excitation> {
    let slipping = Modes::of(geometry, MODES);
    let axial = geometry.axial_stiffness();
    let stiffness = joint.stiffness * axial / (joint.stiffness + axial);
    let sticking = resonances_in_stick(&slipping, stiffness);
    PLAN.map(|(level, mode, place)| {
        let stuck = sticking[mode] / TAU;
        let slip = slipping.angular_frequencies[mode] / TAU;
        Excitation {
            size: level * random.about_one(0.12) * limit,
            frequency: stuck + (slip - stuck) * (place + random.between(-0.1, 0.1)),
            phase: random.phase(),
            phases: [random.phase(), random.phase()],
        }
    })
    .to_vec()
}

/// The lowest angular frequencies with a spring at the contact, in the space of the modes in slip.
fn resonances_in_stick(modes: &Modes, stiffness: f64) -> Vec<f64> {
    let slopes = modes.slopes_at_pin();
    let matrix = nalgebra::DMatrix::from_fn(MODES, MODES, |i, j| {
        let own = if i == j { modes.angular_frequencies[i].powi(2) } else { 0.0 };
        own + stiffness * OFFSET * OFFSET * slopes[i] * slopes[j]
    });
    let mut values: Vec<f64> =
        nalgebra::SymmetricEigen::new(matrix).eigenvalues.iter().map(|value| value.sqrt()).collect();
    values.sort_by(f64::total_cmp);
    values
}

impl Rig for Beam {
    fn respond(&self) -> Vec<Record> {
        let modes = Modes::of(&self.geometry, MODES);
        self.records.iter().map(|excitation| self.record(&modes, excitation)).collect()
    }

    fn base(&self) -> Vec<f64> {
        let joint = &self.joint;
        vec![self.geometry.youngs_modulus, self.damping_ratio, joint.stiffness, joint.friction_coefficient]
    }

    fn with_base(&self, values: &[f64]) -> Box<dyn Rig> {
        let mut rig = self.clone();
        (rig.geometry.youngs_modulus, rig.damping_ratio) = (values[0], values[1]);
        (rig.joint.stiffness, rig.joint.friction_coefficient) = (values[2], values[3]);
        Box::new(rig)
    }

    fn plain(&self) -> Box<dyn Rig> {
        let mut rig = self.clone();
        rig.joint = Joint::jenkins(self.joint.stiffness, self.joint.friction_coefficient);
        rig.geometry.point_masses.truncate(SENSORS.len());
        rig.geometry.clamp_stiffness = None;
        (rig.cubic_stiffness, rig.quadratic_damping, rig.disturbance) = (0.0, 0.0, 0.0);
        (rig.swing, rig.hanging, rig.fault) = (None, None, None);
        rig.hidden.clear();
        Box::new(rig)
    }

    fn ignorance(&self) -> Vec<f64> {
        vec![0.02, 0.15, 0.15, 0.15]
    }

    fn model(&self, off: &[f64]) -> String {
        let geometry = &self.geometry;
        let mut text = format!(
            "schema = \"stickslip.model/1\"\nkind = \"beam\"\n\n[beam]\nlength = {}\nwidth = {}\n\
             thickness = {}\ndensity = {:?}\nyoungs_modulus = {}\nmodes = {MODES}\ndamping_ratio = {}\n\n",
            geometry.length,
            geometry.width,
            geometry.thickness,
            geometry.density,
            geometry.youngs_modulus * off[0],
            self.damping_ratio * off[1]
        );
        for (position, mass) in &geometry.point_masses[..SENSORS.len()] {
            let _ = write!(text, "[[beam.point_mass]]\nposition = {position}\nmass = {mass}\n\n");
        }
        let _ = write!(text, "[support]\noffset = {OFFSET}\n\n[excitation]\nposition = {EXCITATION}\n\n");
        let (stiffness, friction) = (self.joint.stiffness * off[2], self.joint.friction_coefficient * off[3]);
        contact_table(&mut text, "", stiffness, friction, self.normal_load);
        text
    }

    fn hidden(&self) -> &[Hidden] {
        &self.hidden
    }

    fn tells_noise(&self, _: Regime) -> bool {
        false
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{Complex, DMatrix, DVector};

    use super::*;

    fn rig(level: f64) -> Beam {
        let mut rig = Beam::draw(&[], 1.0, &mut Random::new(3)).unwrap();
        rig.damping_ratio = 0.04; // the start dies away in few periods
        rig.records.truncate(1);
        rig.records[0].size = level;
        rig
    }

    /// First harmonic of the acceleration at the excitation.
    fn first_harmonic(rig: &Beam) -> Complex<f64> {
        let record = &rig.respond()[0];
        let values = &record.columns[2].values;
        let turn = |index: usize| {
            Complex::from_polar(2.0 / values.len() as f64, -TAU * index as f64 / SAMPLES as f64)
        };
        values.iter().enumerate().map(|(index, value)| turn(index) * *value).sum()
    }

    /// Receptance times the excitation, with a spring at the contact.
    fn linear(rig: &Beam, stiffness: f64) -> Complex<f64> {
        let modes = Modes::of(&rig.geometry, MODES);
        let w = TAU * rig.records[0].frequency;
        let slopes = modes.slopes_at_pin();
        let matrix = DMatrix::from_fn(MODES, MODES, |i, j| {
            let own = modes.angular_frequencies[i];
            let diagonal = Complex::new(own * own - w * w, 2.0 * rig.damping_ratio * own * w);
            let coupling = Complex::from(stiffness * OFFSET * OFFSET * slopes[i] * slopes[j]);
            if i == j { diagonal + coupling } else { coupling }
        });
        let shape = modes.deflections(EXCITATION);
        let force = Complex::from_polar(rig.records[0].size, rig.records[0].phase);
        let load = DVector::from_iterator(MODES, shape.iter().map(|value| force * *value));
        let answer = matrix.lu().solve(&load).unwrap();
        shape.iter().zip(answer.iter()).map(|(value, q)| q * (-w * w * value)).sum()
    }

    #[test]
    fn in_stick_the_steady_state_is_that_of_a_spring_in_series_with_the_beam() {
        let rig = rig(0.01);
        let axial = rig.geometry.axial_stiffness();
        let stiffness = rig.joint.stiffness * axial / (rig.joint.stiffness + axial);
        let (found, exact) = (first_harmonic(&rig), linear(&rig, stiffness));
        assert!((found - exact).norm() < 1e-4 * exact.norm(), "{found} {exact}");
    }

    #[test]
    fn without_friction_the_pin_turns_freely() {
        let mut rig = rig(0.01);
        rig.joint.friction_coefficient = 0.0;
        let (found, exact) = (first_harmonic(&rig), linear(&rig, 0.0));
        assert!((found - exact).norm() < 1e-4 * exact.norm(), "{found} {exact}");
    }
}
