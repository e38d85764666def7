//! Kind `oscillator`: two masses between ground and ground's friction, excited from rest around both resonances.
//!
//! Integrated by the leapfrog scheme with many short steps: no modes, no events. draw.rs: its numbers and what is hidden.

mod draw;

use std::f64::consts::TAU;
use std::fmt::Write;

use crate::physics::contact::Contact;
use crate::physics::joint::Joint;
use crate::records::record::{Column, Fault, Fine, Record, Regime, Role};
use crate::rigs::effect::Hidden;
use crate::rigs::prescribed::contact_table;
use crate::rigs::rig::Rig;

const SAMPLES: usize = 2400;
/// Time between samples (s).
const PERIOD: f64 = 0.0005;
/// Steps of the simulation between samples, at the usual pace.
const STEPS: usize = 100;
/// The excitation grows to its level within this time (s).
const RAMP: f64 = 0.05;

/// Two masses on springs with a contact at the second.
#[derive(Clone)]
pub struct Oscillator {
    /// kg.
    pub masses: [f64; 2],
    /// N/m: ground to the first mass, first to the second.
    pub stiffness: [f64; 2],
    /// N s/m.
    pub damping: [f64; 2],
    /// The contact between the second mass and the ground.
    pub joint: Joint,
    normal_load: f64,
    /// Share and frequency (Hz) by which the normal load swings.
    swing: Option<(f64, f64)>,
    /// Whether a load cell is there although the load is constant.
    load_cell: bool,
    added: [f64; 2],
    cubic_stiffness: f64,
    quadratic_damping: f64,
    /// Mass (kg) and frequency (Hz) of a resonator hung at the second mass.
    hanging: Option<(f64, f64)>,
    fault: Option<Fault>,
    /// Size (N) and frequency (Hz) of a force on the first mass that nobody measures.
    disturbance: Option<(f64, f64)>,
    records: Vec<Excitation>,
    /// Steps of the simulation between samples.
    steps: usize,
    /// Whether the dataset tells the noise.
    tells_noise: bool,
    hidden: Vec<Hidden>,
}

/// An excitation of the first mass, and the phases of what else swings.
#[derive(Clone)]
pub struct Excitation {
    /// Amplitude (N), frequency (Hz) and phase (rad) of each line.
    pub lines: Vec<[f64; 3]>,
    /// Of the normal load and of a disturbance.
    pub phases: [f64; 2],
}

impl Excitation {
    fn at(&self, time: f64) -> f64 {
        let ramp = (time / RAMP).clamp(0.0, 1.0);
        let sum: f64 = self.lines.iter().map(|[size, f, phase]| size * (TAU * f * time + phase).sin()).sum();
        ramp * sum
    }
}

impl Oscillator {
    /// A system with nothing hidden and no excitation yet.
    pub fn new(
        masses: [f64; 2],
        stiffness: [f64; 2],
        damping: [f64; 2],
        joint: Joint,
        normal_load: f64,
    ) -> Self {
        Self {
            masses,
            stiffness,
            damping,
            joint,
            normal_load,
            swing: None,
            load_cell: false,
            added: [0.0; 2],
            cubic_stiffness: 0.0,
            quadratic_damping: 0.0,
            hanging: None,
            fault: None,
            disturbance: None,
            records: Vec::new(),
            steps: STEPS,
            tells_noise: true,
            hidden: Vec::new(),
        }
    }

    /// The two natural frequencies (Hz), the lower first, with a spring at the second mass.
    pub fn frequencies(&self, contact_stiffness: f64) -> [f64; 2] {
        let [first, second] = self.masses;
        let a = (self.stiffness[0] + self.stiffness[1]) / first;
        let b = (self.stiffness[1] + contact_stiffness) / second;
        let coupling = self.stiffness[1].powi(2) / (first * second);
        let (mean, half) = (0.5 * (a + b), (0.25 * (a - b).powi(2) + coupling).sqrt());
        [(mean - half).sqrt() / TAU, (mean + half).sqrt() / TAU]
    }

    fn load(&self, excitation: &Excitation, time: f64) -> f64 {
        let swing = self
            .swing
            .map_or(0.0, |(share, frequency)| share * (TAU * frequency * time + excitation.phases[0]).sin());
        self.normal_load * (1.0 + swing)
    }

    /// Displacements of the masses on the fine grid, from rest.
    pub fn displacements(&self, excitation: &Excitation, samples: usize) -> [Fine; 2] {
        let step = PERIOD / self.steps as f64;
        // The excitation is tabulated every ten steps; at a hundred steps a straight line between is right within 4e-5.
        let coarse = 10;
        let table: Vec<f64> = (0..=samples * self.steps / coarse)
            .map(|index| excitation.at(index as f64 * step * coarse as f64))
            .collect();
        let mut contact = Contact::at_rest(&self.joint, 0.0);
        let mut position = [0.0; 3];
        let (mut speed, mut acceleration) = ([0.0; 3], [0.0; 3]);
        let count = (samples - 1) * self.steps + 1;
        let mut shown = [0, 1].map(|_| Vec::with_capacity(count));
        for index in 0..count {
            let time = index as f64 * step;
            shown[0].push(position[0]);
            shown[1].push(position[1]);
            let (cell, part) = (index / coarse, (index % coarse) as f64 / coarse as f64);
            let mut force = table[cell] * (1.0 - part) + table[cell + 1] * part;
            if let Some((size, frequency)) = self.disturbance {
                force +=
                    size * (TAU * frequency * time + excitation.phases[1]).sin() * (time / RAMP).min(1.0);
            }
            let friction = contact.advance(position[1], self.load(excitation, time), step, time);
            // Speeds are known half a step before the positions.
            let now = std::array::from_fn(|place| speed[place] + 0.5 * step * acceleration[place]);
            acceleration = self.acceleration(position, now, force, friction);
            for place in 0..3 {
                speed[place] += acceleration[place] * step;
                position[place] += speed[place] * step;
            }
        }
        shown.map(|values| Fine { values, step, start: 0.0 })
    }

    fn acceleration(&self, x: [f64; 3], v: [f64; 3], force: f64, friction: f64) -> [f64; 3] {
        let between = self.stiffness[1] * (x[1] - x[0]) + self.damping[1] * (v[1] - v[0]);
        let ground = self.stiffness[0] * x[0]
            + self.damping[0] * v[0]
            + self.cubic_stiffness * x[0].powi(3)
            + self.quadratic_damping * v[0].abs() * v[0];
        let (pull, hanging) = match self.hanging {
            None => (0.0, 0.0),
            Some((mass, frequency)) => {
                let per_mass = (TAU * frequency).powi(2) * (x[1] - x[2]);
                (mass * per_mass, per_mass)
            }
        };
        [
            (force - ground + between) / (self.masses[0] + self.added[0]),
            (-between - friction - pull) / (self.masses[1] + self.added[1]),
            hanging,
        ]
    }

    fn record(&self, excitation: &Excitation) -> Record {
        let times: Vec<f64> = (0..SAMPLES).map(|index| index as f64 * PERIOD).collect();
        let fine = self.displacements(excitation, Fault::reach(self.fault.as_ref(), SAMPLES));
        let force = times.iter().map(|time| excitation.at(*time)).collect();
        let loads = times.iter().map(|time| self.load(excitation, *time)).collect();
        let mut columns = vec![
            Column::new("time", "s", Role::Exact, times),
            Column::new("excitation:m1", "N", Role::Driven, force),
        ];
        for (mass, fine) in fine.iter().enumerate() {
            let name = format!("displacement:m{}", mass + 1);
            let shown = fine.sample(&name, SAMPLES, PERIOD, self.fault.as_ref());
            columns.push(Column::new(name, "m", Role::Response, shown));
        }
        if self.load_cell || self.swing.is_some() {
            columns.push(Column::new("normal_load", "N", Role::Driven, loads));
        }
        Record { regime: Regime::FromRest, columns, told: Vec::new() }
    }
}

impl Rig for Oscillator {
    fn respond(&self) -> Vec<Record> {
        self.records.iter().map(|excitation| self.record(excitation)).collect()
    }

    fn base(&self) -> Vec<f64> {
        let [k1, k2] = self.stiffness;
        let [c1, c2] = self.damping;
        vec![k1, c1, k2, c2, self.joint.stiffness, self.joint.friction_coefficient]
    }

    fn with_base(&self, values: &[f64]) -> Box<dyn Rig> {
        let mut rig = self.clone();
        rig.stiffness = [values[0], values[2]];
        rig.damping = [values[1], values[3]];
        (rig.joint.stiffness, rig.joint.friction_coefficient) = (values[4], values[5]);
        Box::new(rig)
    }

    fn plain(&self) -> Box<dyn Rig> {
        let joint = Joint::jenkins(self.joint.stiffness, self.joint.friction_coefficient);
        let mut rig = Self::new(self.masses, self.stiffness, self.damping, joint, self.normal_load);
        rig.records = self.records.clone();
        rig.steps = self.steps;
        Box::new(rig)
    }

    fn ignorance(&self) -> Vec<f64> {
        vec![0.03, 0.15, 0.03, 0.15, 0.15, 0.15]
    }

    fn model(&self, off: &[f64]) -> String {
        let mut text = String::from("schema = \"stickslip.model/1\"\nkind = \"oscillator\"\n\n");
        for (index, mass) in self.masses.iter().enumerate() {
            let _ = write!(text, "[[mass]]\nname = \"m{}\"\nmass = {mass}\n\n", index + 1);
        }
        for (index, between) in ["\"ground\", \"m1\"", "\"m1\", \"m2\""].iter().enumerate() {
            let stiffness = self.stiffness[index] * off[2 * index];
            let damping = self.damping[index] * off[2 * index + 1];
            let _ = write!(
                text,
                "[[spring]]\nbetween = [{between}]\nstiffness = {stiffness}\ndamping = {damping}\n\n"
            );
        }
        let (stiffness, friction) = (self.joint.stiffness * off[4], self.joint.friction_coefficient * off[5]);
        contact_table(&mut text, "at = \"m2\"\n", stiffness, friction, self.normal_load);
        text
    }

    fn hidden(&self) -> &[Hidden] {
        &self.hidden
    }

    fn tells_noise(&self, _: Regime) -> bool {
        self.tells_noise
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A sine of 1 N at `frequency`, from which the transient of a well damped system has gone.
    fn amplitudes(rig: &Oscillator, frequency: f64) -> [f64; 2] {
        let excitation = Excitation { lines: vec![[1.0, frequency, 0.0]], phases: [0.0; 2] };
        rig.displacements(&excitation, 4000).map(|fine| {
            let last = &fine.values[fine.values.len() * 9 / 10..];
            last.iter().fold(0.0, |largest: f64, value| largest.max(value.abs()))
        })
    }

    fn bare(friction_coefficient: f64) -> Oscillator {
        let joint = Joint::jenkins(7000.0, friction_coefficient);
        Oscillator::new([1.2, 1.4], [35e3, 16e3], [150.0, 60.0], joint, 30.0)
    }

    #[test]
    fn without_a_limit_the_response_is_the_receptance() {
        let cases = [(bare(0.0), 0.0), (bare(10.0), 7000.0)];
        let at = |frequency: f64| cases.clone().map(|(rig, stiffness)| (frequency, rig, stiffness));
        for (frequency, rig, contact_stiffness) in [17.0, 34.0].into_iter().flat_map(at) {
            let w = TAU * frequency;
            // [a b; b d] x = [1; 0], complex numbers as pairs.
            let a = (35e3 + 16e3 - w * w * 1.2, w * 210.0);
            let b = (-16e3, -w * 60.0);
            let d = (16e3 + contact_stiffness - w * w * 1.4, w * 60.0);
            let times = |p: (f64, f64), q: (f64, f64)| (p.0 * q.0 - p.1 * q.1, p.0 * q.1 + p.1 * q.0);
            let (ad, bb) = (times(a, d), times(b, b));
            let determinant = (ad.0 - bb.0).hypot(ad.1 - bb.1);
            let exact = [d.0.hypot(d.1) / determinant, b.0.hypot(b.1) / determinant];
            for (found, exact) in amplitudes(&rig, frequency).into_iter().zip(exact) {
                // Damping that lags by half a step leaves 1e-4.
                assert!((found / exact - 1.0).abs() < 2e-5, "{found} {exact}");
            }
        }
    }

    #[test]
    fn a_hung_resonator_holds_its_mass_at_its_frequency() {
        // The absorber: where it is hung nothing moves at its own frequency once the start has died away.
        let mut rig = bare(0.0);
        rig.hanging = Some((0.5, 17.0));
        let held = amplitudes(&rig, 17.0)[1];
        assert!(held < 0.02 * amplitudes(&bare(0.0), 17.0)[1], "{held}");
    }

    #[test]
    fn an_added_mass_is_a_mass() {
        let mut added = bare(0.4);
        added.added = [0.1, 0.2];
        let mut heavy = bare(0.4);
        heavy.masses = [1.3, 1.6];
        for (a, b) in amplitudes(&added, 15.0).into_iter().zip(amplitudes(&heavy, 15.0)) {
            assert!((a / b - 1.0).abs() < 1e-12, "{a} {b}");
        }
    }

    #[test]
    fn the_steps_are_short_enough_at_four_times_the_pace() {
        use crate::records::random::Random;
        use crate::rigs::setting::Setting;

        let rig = Oscillator::draw(Setting::Coarse, &[], 1.0, &mut Random::new(3)).unwrap();
        let finer = Oscillator { steps: 2 * rig.steps, ..rig.clone() };
        let at_samples = |rig: &Oscillator| {
            let [_, fine] = rig.displacements(&rig.records[3], 600);
            fine.values.into_iter().step_by(rig.steps).collect::<Vec<f64>>()
        };
        let (values, finer) = (at_samples(&rig), at_samples(&finer));
        let change: f64 = values.iter().zip(&finer).map(|(a, b)| (a - b).powi(2)).sum();
        let size: f64 = finer.iter().map(|b| b * b).sum();
        // A tenth of the noise of 0.3 %.
        assert!((change / size).sqrt() < 1.5e-4, "{}", (change / size).sqrt());
    }
}
