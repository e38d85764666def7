//! The beam in motion: modes marched by the leapfrog scheme until a period repeats the one before.

use std::f64::consts::TAU;

use nalgebra::Complex;

use super::excitation::Excitation;
use super::{Beam, EXCITATION, MODES, OFFSET, PERIODS, SAMPLES, SENSORS};
use crate::physics::contact::Contact;
use crate::physics::finite_elements::Modes;
use crate::records::record::Fine;

/// Steps of the simulation between samples.
const STEPS: usize = 32;
/// The steady state is reached when a period repeats the one before within this fraction of its size: with thirty times as
/// much, a motion passed that does not settle in ten thousand periods ...
const STEADY: f64 = 1e-7;
/// ... or given up after so many periods.
const MOST_PERIODS: usize = 4000;
/// A level counts as held within this fraction of it.
const HELD: f64 = 1e-5;
/// Exponents by which the force follows the level that is missing: at once, and from period to period.
const CONTROL: (f64, f64) = (1.5, 0.1);

/// The beam in motion.
pub struct Motion<'a> {
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
    /// Force of the excitation (N).
    size: f64,
    /// Modal coordinates now and a step before, the resonator's last.
    now: [f64; MODES + 1],
    before: [f64; MODES + 1],
    /// Modal accelerations in the last step.
    acceleration: [f64; MODES],
    /// Force through the contact's point, contact and resonator, in the last two steps.
    forces: [f64; 2],
}

impl<'a> Motion<'a> {
    /// At rest.
    pub fn new(beam: &'a Beam, modes: &'a Modes, excitation: &'a Excitation) -> Self {
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
            size: excitation.size,
            now: [0.0; MODES + 1],
            before: [0.0; MODES + 1],
            acceleration: [0.0; MODES],
            forces: [0.0; 2],
        }
    }

    /// Marches until a period repeats the one before, and takes a record from there on: what the sensors show, and the
    /// force; `None` when it never does.
    pub fn steady(mut self) -> Option<([Fine; 3], f64)> {
        let cycle = SAMPLES * STEPS;
        let mut last = vec![0.0; SAMPLES];
        let mut index = 0;
        let mut steady = false;
        let mut settled = self.size;
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
            let held = self.excitation.held.is_none_or(|level| self.hold(level, &last, &mut settled));
            if held && change < STEADY * STEADY * size {
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
        Some((shown.map(|values| Fine { values, step: self.step, start }), self.size))
    }

    /// Moves the force towards the one that holds `level`, given the last period; whether it is held. `settled` is the
    /// force without what follows the missing level at once.
    fn hold(&mut self, level: f64, period: &[f64], settled: &mut f64) -> bool {
        let missing = (level / first_harmonic(period).norm()).ln().clamp(-0.3, 0.3);
        *settled *= (CONTROL.1 * missing).exp();
        self.size = *settled * (CONTROL.0 * missing).exp();
        missing.abs() < HELD
    }

    /// One step of the leapfrog scheme; the modal accelerations at its start.
    fn advance(&mut self, index: usize) -> [f64; MODES] {
        let beam = self.beam;
        let cycle = SAMPLES * STEPS;
        let angle = TAU * (index % cycle) as f64 / cycle as f64;
        let time = index as f64 * self.step;
        let q = self.now;
        // The difference is the velocity half a step before.
        let velocity: [f64; MODES] = std::array::from_fn(|i| {
            (q[i] - self.before[i]) / self.step + 0.5 * self.step * self.acceleration[i]
        });
        let mut turned = [0.0; MODES]; // Σ_j q_j ∫φ_i'φ_j'
        for (value, row) in turned.iter_mut().zip(&self.modes.shortening) {
            *value = dot(row, &q[..MODES]);
        }
        let shortened = dot(&turned, &q[..MODES]);
        let moved = dot(&self.slopes, &q[..MODES]) - 0.5 * shortened;
        let pull = self.hanging(moved);
        let hung = beam.hanging.map_or(0.0, |(mass, _)| mass * pull);
        let given = moved - hung / beam.geometry.axial_stiffness();
        let force = hung + self.contact.advance(given, beam.load(self.excitation, angle), self.step, time);
        self.forces = [force, self.forces[0]];
        let speed = dot(&self.driven, &velocity);
        let excitation = self.size
            * ((angle + self.excitation.phase).cos()
                + beam.disturbance * (3.0 * angle + self.excitation.phases[1]).cos());
        let at_excitation = excitation - beam.quadratic_damping * speed.abs() * speed;
        let stretching = beam.cubic_stiffness * shortened / self.stretching.powi(2);
        let mut next = [0.0; MODES + 1];
        for i in 0..MODES {
            let w = self.modes.angular_frequencies[i];
            let outer = at_excitation * self.driven[i]
                - self.stiffnesses[i] * q[i]
                - force * (self.slopes[i] - turned[i])
                - stretching * turned[i];
            next[i] = self.stepped(i, w, outer);
            self.acceleration[i] = (next[i] - 2.0 * q[i] + self.before[i]) / (self.step * self.step);
        }
        let w = TAU * beam.hanging.map_or(0.0, |(_, frequency)| frequency);
        next[MODES] = self.stepped(MODES, w, pull);
        self.before = q;
        self.now = next;
        self.acceleration
    }

    /// Coordinate `i` a step on, under the acceleration `outer` and damping of the frequency `w` (rad/s) by the central
    /// difference, solved for the next value.
    fn stepped(&self, i: usize, w: f64, outer: f64) -> f64 {
        let damping = self.beam.damping_ratio * w * self.step;
        let on = 2.0 * self.now[i] - self.before[i] * (1.0 - damping);
        (on + self.step * self.step * outer) / (1.0 + damping)
    }

    /// Acceleration of the resonator by its spring from the contact's point; damped as the beam's modes are. The point itself
    /// is `moved` plus the stretch of the beam under the force, which goes on as in the last two steps.
    fn hanging(&self, moved: f64) -> f64 {
        let Some((_, frequency)) = self.beam.hanging else { return 0.0 };
        let w = TAU * frequency;
        let force = 2.0 * self.forces[0] - self.forces[1];
        w * w * (moved - force / self.beam.geometry.axial_stiffness() - self.now[MODES])
    }
}

/// Complex amplitude of the first harmonic of one period.
fn first_harmonic(period: &[f64]) -> Complex<f64> {
    let count = period.len() as f64;
    let turned =
        |(index, value): (usize, &f64)| Complex::from_polar(2.0 * value / count, -TAU * index as f64 / count);
    period.iter().enumerate().map(turned).sum()
}

fn dot(left: &[f64], right: &[f64]) -> f64 {
    left.iter().zip(right).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests {
    use nalgebra::{DMatrix, DVector};

    use super::*;
    use crate::records::random::Random;
    use crate::rigs::rig::Rig;
    use crate::rigs::setting::Setting;

    fn rig(level: f64) -> Beam {
        let mut rig = Beam::draw(Setting::Usual, &[], 1.0, &mut Random::new(3)).unwrap();
        rig.damping_ratio = 0.04; // the start dies away in few periods
        rig.records.truncate(1);
        rig.records[0].size = level;
        rig
    }

    /// First harmonic of the acceleration at the excitation.
    fn measured(rig: &Beam) -> Complex<f64> {
        first_harmonic(&rig.respond()[0].columns[2].values[..SAMPLES])
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

    fn stiffness_in_stick(rig: &Beam) -> f64 {
        let axial = rig.geometry.axial_stiffness();
        rig.joint.stiffness * axial / (rig.joint.stiffness + axial)
    }

    #[test]
    fn in_stick_the_steady_state_is_that_of_a_spring_in_series_with_the_beam() {
        let rig = rig(0.01);
        let (found, exact) = (measured(&rig), linear(&rig, stiffness_in_stick(&rig)));
        assert!((found - exact).norm() < 1e-4 * exact.norm(), "{found} {exact}");
    }

    #[test]
    fn without_friction_the_pin_turns_freely() {
        let mut rig = rig(0.01);
        rig.joint.friction_coefficient = 0.0;
        let (found, exact) = (measured(&rig), linear(&rig, 0.0));
        assert!((found - exact).norm() < 1e-4 * exact.norm(), "{found} {exact}");
    }

    #[test]
    fn a_held_level_is_held_by_the_force_that_the_receptance_asks_for() {
        let mut rig = rig(0.05);
        rig.records[0].held = Some(0.8);
        let stiffness = stiffness_in_stick(&rig);
        let record = &rig.respond()[0];
        let held = first_harmonic(&record.columns[2].values[..SAMPLES]).norm();
        let force = first_harmonic(&record.columns[1].values[..SAMPLES]).norm();
        assert!((held / 0.8 - 1.0).abs() < 2.0 * HELD, "{held}");
        let per_force = linear(&rig, stiffness).norm() / rig.records[0].size;
        assert!((held / force / per_force - 1.0).abs() < 1e-3, "{held} {force} {per_force}");
    }

    #[test]
    fn the_first_papers_contact_holds_its_levels_with_the_forces_of_the_reference() {
        let effects = ["micro_slip:valanis"];
        let rig = Beam::draw(Setting::HeldLevels, &effects, 1.0, &mut Random::new(3)).unwrap();
        // Acceleration over force at 20 and 60 m/s², by harmonic balance with five harmonics.
        for (place, level, expected) in [(2, 20.0, 2.9), (6, 60.0, 4.7)] {
            let one = Beam { records: vec![rig.records[place].clone()], ..rig.clone() };
            let record = &one.respond()[0];
            let [force, held] =
                [1, 2].map(|column| first_harmonic(&record.columns[column].values[..SAMPLES]).norm());
            assert!((held / level - 1.0).abs() < 1e-4, "{held}");
            assert!((held / force / expected - 1.0).abs() < 0.03, "{}", held / force);
        }
    }
}
