//! The contact of the generator in motion: many sliders in parallel, or a force that grows gradually, marched in small
//! steps with whatever is hidden in it.
//!
//! Nothing here locates an event or uses a closed form: each step clamps every slider to its limit. A force is
//! restoring: positive when it resists positive displacement.

use crate::physics::gradual::Reach;
use crate::physics::joint::Joint;
use crate::physics::unknown::{Memory, Moved, Unknown};

/// Sliders of a distribution.
const SLIDERS: usize = 40;

/// A contact in motion.
pub struct Contact<'a> {
    joint: &'a Joint,
    /// Stiffness, fraction of the limit and position of each slider.
    sliders: Vec<Slider>,
    /// Compliance in series (m/N): of the beam against stretching.
    compliance: f64,
    /// Displacement behind the play.
    displacement: f64,
    velocity: f64,
    /// Displacement in front of play and compliance.
    given: f64,
    /// Mean velocities in the last step, in front and behind.
    paces: [Option<f64>; 2],
    slip: f64,
    /// Force of what grows gradually, of its bristles alone (N).
    held: f64,
    memory: Memory,
}

#[derive(Clone)]
struct Slider {
    stiffness: f64,
    share: f64,
    position: f64,
}

/// The two limits of a step, against positive and negative force (N), the factor of the stiffness, and the duration (s).
#[derive(Clone, Copy)]
struct Step {
    upper: f64,
    lower: f64,
    stiffening: f64,
    duration: f64,
}

/// The velocity at the end of a step of mean velocity `mean`, after one of `before` if there was any (m/s).
fn at_end(mean: f64, before: Option<f64>) -> f64 {
    before.map_or(mean, |before| 1.5 * mean - 0.5 * before)
}

impl<'a> Contact<'a> {
    /// At rest at zero, nothing remembered. `compliance` (m/N) is a spring in series, 0 for none.
    pub fn at_rest(joint: &'a Joint, compliance: f64) -> Self {
        let count = match joint.gradual {
            Some(_) => 0,
            None if joint.spread > 0.0 => SLIDERS,
            None => 1,
        };
        let sliders = (0..count)
            .map(|index| {
                let place = (2 * index + 1) as f64 / count as f64 - 1.0;
                Slider {
                    stiffness: joint.stiffness / count as f64,
                    share: (1.0 + joint.spread * place) / count as f64,
                    position: 0.0,
                }
            })
            .collect();
        Self {
            joint,
            sliders,
            compliance,
            displacement: 0.0,
            velocity: 0.0,
            given: 0.0,
            paces: [None; 2],
            slip: 0.0,
            held: 0.0,
            memory: joint.unknown.as_ref().map(Unknown::memory).unwrap_or_default(),
        }
    }

    /// At `displacement` with every slider's spring stretched by `elongation` (m), as an unknown past leaves it.
    pub fn stretched(joint: &'a Joint, displacement: f64, elongation: f64) -> Self {
        let mut contact = Self::at_rest(joint, 0.0);
        let behind = displacement - elongation.signum() * joint.half_gap;
        contact.given = displacement;
        contact.displacement = behind;
        contact.memory.reversal = behind;
        contact.held = joint.stiffness * elongation;
        for slider in &mut contact.sliders {
            slider.position = behind - elongation;
        }
        contact
    }

    /// Forgets the distance slipped so far: a record begins.
    pub fn begin_record(&mut self) {
        self.slip = 0.0;
    }

    /// Moves to `given` (m) within `duration` (s) under `normal_load` (N), `time` (s) after the record's start;
    /// returns the force (N).
    pub fn advance(&mut self, given: f64, normal_load: f64, duration: f64, time: f64) -> f64 {
        let pace = (given - self.given) / duration;
        let given_velocity = at_end(pace, self.paces[0].replace(pace));
        // In front of the compliance: behind it a limit that falls with the speed would make the speed run away.
        let factor = self.factor(given_velocity, time);
        let limit = self.joint.friction_coefficient * normal_load.max(0.0) * factor;
        let step = Step {
            upper: limit * (1.0 + self.joint.asymmetry),
            lower: limit * (1.0 - self.joint.asymmetry),
            stiffening: self.joint.unknown.as_ref().map_or(1.0, |unknown| unknown.on_stiffness(time)),
            duration,
        };
        let displacement = self.behind_the_play(given, &step);
        self.commit(given, displacement, &step)
    }

    fn factor(&self, velocity: f64, time: f64) -> f64 {
        let joint = self.joint;
        let mut factor = 1.0 + joint.wear * self.slip;
        if let Some((share, speed)) = joint.weakening {
            factor *= 1.0 + share * (-velocity.abs() / speed).exp();
        }
        if let Some(unknown) = &joint.unknown {
            factor *= unknown.on_limit(&self.memory, self.displacement, time);
        }
        factor.max(0.0)
    }

    /// With play the contact is pressed from one side, from the other, or not at all.
    fn behind_the_play(&self, given: f64, step: &Step) -> f64 {
        let gap = self.joint.half_gap;
        if gap == 0.0 {
            return self.solve(given, self.compliance, step);
        }
        let pushed = self.solve(given - gap, self.compliance, step);
        if self.trial(pushed, step).0 >= 0.0 {
            return pushed;
        }
        let pulled = self.solve(given + gap, self.compliance, step);
        if self.trial(pulled, step).0 <= 0.0 {
            return pulled;
        }
        // Free: it stays where its force is zero, between the two.
        bisect(pulled.max(pushed), pulled.min(pushed), |w| self.trial(w, step).0)
    }

    /// Where w + compliance · T(w) = target: Newton's method, halved intervals when it leaves them.
    fn solve(&self, target: f64, compliance: f64, step: &Step) -> f64 {
        if compliance == 0.0 {
            return target;
        }
        let mut guess = self.displacement + (target - self.given) / (1.0 + compliance * self.joint.stiffness);
        for _ in 0..30 {
            let (force, slope) = self.trial(guess, step);
            let rest = guess + compliance * force - target;
            if rest.abs() <= 1e-13 * (1e-6 + target.abs()) {
                return guess;
            }
            guess -= rest / (1.0 + compliance * slope.max(0.0));
        }
        let reach = compliance * 10.0 * (step.upper + step.lower) + 2.0 * (target - self.displacement).abs();
        bisect(target + reach, target - reach, |w| w + compliance * self.trial(w, step).0 - target)
    }

    /// Force and its slope at `displacement` behind play and compliance, nothing committed.
    fn trial(&self, displacement: f64, step: &Step) -> (f64, f64) {
        let joint = self.joint;
        let change = displacement - self.displacement;
        // Where play is taken up the velocity jumps.
        let before = self.paces[1].filter(|_| joint.half_gap == 0.0);
        let by_mean = if before.is_some() { 1.5 } else { 1.0 };
        let mut force = joint.residual_stiffness * displacement
            + joint.cubic_stiffness * displacement.powi(3)
            + joint.damping * at_end(change / step.duration, before);
        let mut slope = joint.residual_stiffness
            + 3.0 * joint.cubic_stiffness * displacement * displacement
            + joint.damping * by_mean / step.duration;
        for slider in &self.sliders {
            let stiffness = slider.stiffness * step.stiffening;
            let free = stiffness * (displacement - slider.position);
            let held = free.min(slider.share * step.upper).max(-slider.share * step.lower);
            force += held;
            if free == held {
                slope += stiffness;
            }
        }
        if let Some(law) = &joint.gradual {
            let grown = law.advance(self.reach(step), change);
            force += grown.force;
            slope += grown.slope;
        }
        if let Some(unknown) = &joint.unknown {
            unknown.add_force(&self.memory, change, step.duration, (&mut force, &mut slope));
        }
        (force, slope)
    }

    /// What a gradual law starts from.
    fn reach(&self, step: &Step) -> Reach {
        Reach {
            held: self.held,
            stiffness: self.joint.stiffness * step.stiffening,
            limits: [step.upper, step.lower],
            duration: step.duration,
        }
    }

    fn commit(&mut self, given: f64, displacement: f64, step: &Step) -> f64 {
        let force = self.trial(displacement, step).0;
        let change = displacement - self.displacement;
        let slipped = self.slip_to(displacement, change, step);
        self.slip += slipped;
        if let Some(unknown) = &self.joint.unknown {
            let moved = Moved { change, slipped, duration: step.duration };
            unknown.remember(&mut self.memory, moved);
        }
        if change * self.velocity < 0.0 {
            self.memory.reversal = self.displacement;
        }
        if change != 0.0 {
            self.velocity = change / step.duration;
        }
        self.paces[1] = Some(change / step.duration);
        self.displacement = displacement;
        self.given = given;
        force
    }

    /// Moves sliders or bristles; the distance slipped (m).
    fn slip_to(&mut self, displacement: f64, change: f64, step: &Step) -> f64 {
        if let Some(law) = &self.joint.gradual {
            let from = self.reach(step);
            let grown = law.advance(from, change).held;
            let slipped = (change - (grown - self.held) / from.stiffness).abs();
            self.held = grown;
            return slipped;
        }
        let mut slipped = 0.0;
        for slider in &mut self.sliders {
            let stiffness = slider.stiffness * step.stiffening;
            let stretch = displacement - slider.position;
            let held = stretch
                .min(slider.share * step.upper / stiffness)
                .max(-slider.share * step.lower / stiffness);
            slipped += (stretch - held).abs();
            slider.position = displacement - held;
        }
        slipped / self.sliders.len() as f64
    }
}

/// Where a growing function is zero.
fn bisect(mut high: f64, mut low: f64, function: impl Fn(f64) -> f64) -> f64 {
    for _ in 0..80 {
        let middle = 0.5 * (low + high);
        if function(middle) > 0.0 {
            high = middle;
        } else {
            low = middle;
        }
    }
    0.5 * (low + high)
}

#[cfg(test)]
pub(super) mod tests {
    use std::f64::consts::TAU;

    use super::*;

    pub const LOAD: f64 = 100.0;

    /// ∮ T du over the third period of a sine, and the largest force in it.
    pub fn cycle(joint: &Joint, amplitude: f64) -> (f64, f64) {
        let mut contact = Contact::at_rest(joint, 0.0);
        let (mut area, mut largest, mut before) = (0.0, 0.0_f64, (0.0, 0.0));
        let count = 40_000;
        for index in 1..=3 * count {
            let displacement = amplitude * (TAU * index as f64 / count as f64).sin();
            let force = contact.advance(displacement, LOAD, 1.0 / count as f64, 0.0);
            if index > 2 * count {
                area += 0.5 * (force + before.1) * (displacement - before.0);
                largest = largest.max(force);
            }
            before = (displacement, force);
        }
        (area, largest)
    }

    /// μN = 50 N, yield at 10 µm.
    pub fn jenkins() -> Joint {
        Joint::jenkins(5e6, 0.5)
    }

    pub fn assert_close(found: f64, expected: f64, share: f64) {
        assert!((found / expected - 1.0).abs() < share, "{found} instead of {expected}");
    }

    #[test]
    fn jenkins_loop_area_equals_4_limit_times_slip() {
        let (area, largest) = cycle(&jenkins(), 4e-5);
        assert_close(area, 4.0 * 50.0 * (4e-5 - 1e-5), 1e-6);
        assert_close(largest, 50.0, 1e-12);
    }

    #[test]
    fn play_takes_its_width_from_the_slip() {
        let joint = Joint { half_gap: 4e-6, ..jenkins() };
        assert_close(cycle(&joint, 4e-5).0, 4.0 * 50.0 * (4e-5 - 1e-5 - 4e-6), 1e-6);
        let (area, largest) = cycle(&joint, 3.9e-6);
        assert!(area.abs() < 1e-15 && largest.abs() < 1e-9, "{area} {largest}");
    }

    #[test]
    fn spread_sliders_lose_the_iwan_integral_of_their_yields() {
        // Yields x uniform in x̄(1 ± s): D = ∫ 4 k x (U − x) over the sliders that slip.
        let joint = Joint { spread: 0.8, ..jenkins() };
        let (low, high, reach) = (2e-6, 18e-6, 1.2e-5_f64);
        let density = joint.stiffness / (high - low);
        let integral = |x: f64| 4.0 * density * (reach * x * x / 2.0 - x.powi(3) / 3.0);
        assert_close(cycle(&joint, reach).0, integral(reach) - integral(low), 5e-3);
        assert_close(cycle(&joint, 1e-4).1, 50.0, 1e-9);
    }

    #[test]
    fn what_depends_on_the_velocity_has_that_at_the_end_of_the_step() {
        let (damping, share, pace, count) = (7.0, 0.5, 3e-4, 2000);
        let damper = Joint { damping, ..Joint::jenkins(5e6, 0.0) };
        let weak = Joint { weakening: Some((share, pace)), ..jenkins() };
        // Damping behind the beam's compliance, too.
        let [mut damper, mut soft] = [0.0, 1.5e-8].map(|compliance| Contact::at_rest(&damper, compliance));
        // A limit follows the velocity in front of it.
        let mut weak = [0.0, 1.5e-8].map(|compliance| Contact::at_rest(&weak, compliance));
        let angle = |index: i32| TAU * f64::from(index) / f64::from(count);
        for index in 1..=3 * count {
            let displacement = 4e-5 * angle(index).sin();
            let velocity = 4e-5 * TAU * angle(index).cos();
            let duration = 1.0 / f64::from(count);
            for damper in [&mut damper, &mut soft] {
                let damped = damper.advance(displacement, LOAD, duration, 0.0);
                // The mean velocity of a step would leave 2e-3.
                assert!(index < 3 || (damped - damping * velocity).abs() < 2e-5 * damping * TAU * 4e-5);
            }
            let limit = 50.0 * (1.0 + share * (-velocity.abs() / pace).exp());
            let slips = index > count && displacement * velocity > 0.0 && velocity.abs() > 0.9 * TAU * 4e-5;
            for weak in &mut weak {
                let rubbed = weak.advance(displacement, LOAD, duration, 0.0);
                assert!(!slips || (rubbed.abs() / limit - 1.0).abs() < 1e-5, "{index}: {rubbed} {limit}");
            }
        }
    }

    #[test]
    fn springs_lose_nothing_and_a_damper_pi_c_omega_u_squared() {
        let beside = Joint {
            residual_stiffness: 1e5,
            cubic_stiffness: 1e14,
            damping: 7.0,
            ..Joint::jenkins(5e6, 0.0)
        };
        let expected = 7.0 * TAU / 2.0 * TAU * (4e-5_f64).powi(2);
        assert_close(cycle(&beside, 4e-5).0, expected, 1e-4);
    }

    #[test]
    fn a_compliance_in_series_is_a_spring_in_series() {
        let joint = jenkins();
        let mut contact = Contact::at_rest(&joint, 1e-7);
        assert_close(contact.advance(5e-6, LOAD, 1e-5, 0.0), 5e-6 / (1.0 / 5e6 + 1e-7), 1e-9);
        assert_close(contact.advance(1e-3, LOAD, 1e-5, 0.0), 50.0, 1e-9);
        // From slip back: the same spring in series.
        let change = 50.0 - contact.advance(1e-3 - 2e-6, LOAD, 1e-5, 0.0);
        assert_close(change, 2e-6 / (1.0 / 5e6 + 1e-7), 1e-6);
    }

    #[test]
    fn a_lifted_contact_remembers_no_force() {
        let joint = jenkins();
        let mut contact = Contact::at_rest(&joint, 0.0);
        contact.advance(3e-5, LOAD, 1e-3, 0.0);
        assert_eq!(contact.advance(4e-5, -1.0, 1e-3, 0.0), 0.0);
        assert_eq!(contact.advance(4e-5, LOAD, 1e-3, 0.0), 0.0);
    }

    #[test]
    fn the_limit_follows_direction_distance_and_speed() {
        let steady = |joint: Joint, direction: f64| {
            let mut contact = Contact::at_rest(&joint, 0.0);
            (1..=1000)
                .map(|i| contact.advance(direction * 1e-6 * f64::from(i), LOAD, 1e-3, 0.0))
                .last()
                .unwrap()
        };
        let asymmetric = Joint { asymmetry: 0.2, ..jenkins() };
        assert_close(steady(asymmetric.clone(), 1.0), 60.0, 1e-9);
        assert_close(steady(asymmetric, -1.0), -40.0, 1e-9);
        // 1 mm at 1 mm/s, of which all but the yield is slip.
        assert_close(steady(Joint { wear: 300.0, ..jenkins() }, 1.0), 50.0 * (1.0 + 300.0 * 0.99e-3), 1e-3);
        let weak = Joint { weakening: Some((0.5, 1e-3)), ..jenkins() };
        assert_close(steady(weak, 1.0), 50.0 * (1.0 + 0.5 * (-1.0_f64).exp()), 1e-9);
    }
}
