//! Contact laws whose force grows gradually to its limit, marched in small steps by the midpoint rule.

/// A force T in the place of the sliders, with stiffness k in stick and limit F. s is the direction of the motion.
#[derive(Debug, Clone, PartialEq)]
pub enum Gradual {
    /// dT/du = k (1 − s T/F) (Dahl, with exponent one).
    Dahl,
    /// dT/du = k (1 − |T/F|ⁿ (γ + β sgn(s T))), β = ratio/2, γ = 1 − β.
    BoucWen {
        /// n.
        sharpness: f64,
        /// Slope on a reversal from the limit, over k.
        unloading_ratio: f64,
    },
    /// dT/du = k (1 − s T/F) / (1 − κ s T/F): Valanis without a slope left in slip.
    Valanis {
        /// κ: zero is Dahl's law, one a slider.
        smoothness: f64,
    },
    /// T = σ0 z + σ1 ż, ż = v − σ0 |v| z/g, σ0 = k, g = F (1 + rise · exp(−(v/speed)²)): bristles of which more break
    /// the faster it slips.
    LuGre {
        /// Limit in rest over that in fast slip, less one.
        rise: f64,
        /// Stribeck's speed (m/s).
        speed: f64,
        /// σ1 (N s/m).
        damping: f64,
    },
}

/// What a step of a law starts from and meets.
#[derive(Debug, Clone, Copy)]
pub struct Reach {
    /// Force of the bristles so far (N): T, or σ0 z.
    pub held: f64,
    /// Stiffness in stick (N/m).
    pub stiffness: f64,
    /// Limits against positive and negative force (N), both positive.
    pub limits: [f64; 2],
    /// s.
    pub duration: f64,
}

/// What a step of a law gives.
#[derive(Debug, Clone, Copy)]
pub struct Grown {
    /// Force of the bristles (N).
    pub held: f64,
    /// Force of the contact (N).
    pub force: f64,
    /// Its slope (N/m).
    pub slope: f64,
}

impl Gradual {
    /// Moves by `change` (m).
    pub fn advance(&self, from: Reach, change: f64) -> Grown {
        let Reach { held, stiffness, limits: [upper, lower], duration } = from;
        let rise = match self {
            Gradual::LuGre { rise, speed, .. } => 1.0 + rise * (-(change / duration / speed).powi(2)).exp(),
            _ => 1.0,
        };
        let direction = if change == 0.0 { 0.0 } else { change.signum() };
        let slope = |force: f64| {
            let limit = rise * if force >= 0.0 { upper } else { lower };
            stiffness * if limit > 0.0 { self.growth(direction * force / limit) } else { 0.0 }
        };
        let slope = slope(held + 0.5 * slope(held) * change);
        let (most, damping) = match self {
            Gradual::LuGre { rise, damping, .. } => (1.0 + rise, damping / (stiffness * duration)),
            _ => (1.0, 0.0),
        };
        let grown = (held + slope * change).clamp(-most * lower, most * upper);
        Grown { held: grown, force: grown + damping * (grown - held), slope: slope * (1.0 + damping) }
    }

    /// Slope over the stiffness in stick at a force over the limit, positive when the motion increases it.
    fn growth(&self, level: f64) -> f64 {
        match self {
            Gradual::Dahl | Gradual::LuGre { .. } => 1.0 - level,
            Gradual::BoucWen { sharpness, unloading_ratio } => {
                let beta = 0.5 * unloading_ratio;
                1.0 - level.abs().powf(*sharpness) * (1.0 - beta + beta * level.signum())
            }
            Gradual::Valanis { smoothness } => (1.0 - level) / (1.0 - smoothness * level),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::physics::contact::Contact;
    use crate::physics::contact::tests::{LOAD, assert_close, cycle, jenkins};
    use crate::physics::joint::Joint;
    use crate::records::random::Random;

    /// Stiffness, limit and yield displacement of [`jenkins`].
    const K: f64 = 5e6;
    const F: f64 = 50.0;
    const X: f64 = 1e-5;

    fn of(law: Gradual) -> Joint {
        Joint { gradual: Some(law), ..jenkins() }
    }

    fn lugre(damping: f64) -> Gradual {
        Gradual::LuGre { rise: 0.4, speed: 1e-3, damping }
    }

    fn every() -> [Gradual; 6] {
        [
            Gradual::Dahl,
            Gradual::BoucWen { sharpness: 1.0, unloading_ratio: 1.0 },
            Gradual::BoucWen { sharpness: 2.3, unloading_ratio: 1.6 },
            Gradual::Valanis { smoothness: 0.3 },
            Gradual::Valanis { smoothness: 0.7 },
            lugre(2e3),
        ]
    }

    /// Force at the end of a motion with one speed (m/s) over a distance (m), from rest.
    fn pushed(joint: &Joint, distance: f64, speed: f64) -> f64 {
        let mut contact = Contact::at_rest(joint, 0.0);
        let count = 20_000;
        let duration = distance.abs() / speed / f64::from(count);
        let place = |index: i32| distance * f64::from(index) / f64::from(count);
        (1..=count).map(|index| contact.advance(place(index), LOAD, duration, 0.0)).last().unwrap()
    }

    #[test]
    fn dahls_loop_has_its_closed_form() {
        // From tip to tip F − T falls by exp(−2U/X): T_tip = F tanh(U/X), D = 4 F (U − X tanh(U/X)).
        for reach in [1.5, 3.0] {
            let (area, largest) = cycle(&of(Gradual::Dahl), reach * X);
            assert_close(largest, F * reach.tanh(), 1e-5);
            assert_close(area, 4.0 * F * X * (reach - reach.tanh()), 1e-5);
        }
        // From rest: T = F (1 − exp(−u/X)).
        assert_close(pushed(&of(Gradual::Dahl), 0.7 * X, 1e-4), F * (1.0 - (-0.7_f64).exp()), 1e-8);
    }

    #[test]
    fn valanis_and_bouc_wen_meet_dahl_where_they_are_dahl() {
        for law in
            [Gradual::Valanis { smoothness: 0.0 }, Gradual::BoucWen { sharpness: 1.0, unloading_ratio: 2.0 }]
        {
            let ((area, largest), dahl) = (cycle(&of(law), 2.0 * X), cycle(&of(Gradual::Dahl), 2.0 * X));
            assert_close(area, dahl.0, 1e-12);
            assert_close(largest, dahl.1, 1e-12);
        }
    }

    #[test]
    fn valanis_from_rest_meets_its_implicit_solution() {
        // With ζ = 1 − T/F, λ = k/F: λ u = κ (1 − ζ) − (1 − κ) ln ζ.
        let law = of(Gradual::Valanis { smoothness: 0.3 });
        for distance in [0.2 * X, X, 3.0 * X] {
            let rest = 1.0 - pushed(&law, distance, 1e-4) / F;
            assert_close(0.3 * (1.0 - rest) - 0.7 * rest.ln(), K * distance / F, 1e-7);
        }
        // The first paper's contact: e0 = 7.9e6 N/m, κ = 0.3, limit 90.804598 N at 100 N.
        let paper = Joint { stiffness: 7.9e6, friction_coefficient: 0.908_045_98, ..law };
        for (distance, force) in [(1e-6, 7.660241), (1e-5, 56.581491), (2e-5, 79.786231), (5e-5, 90.526093)] {
            assert_close(pushed(&paper, distance, 1e-4), force, 1e-6);
        }
    }

    #[test]
    fn every_law_has_its_stiffness_in_stick_and_its_limit_in_slip() {
        for law in every() {
            let limit = if matches!(law, Gradual::LuGre { .. }) { F * 1.4 } else { F };
            let joint = of(law.clone());
            assert_close(pushed(&joint, 1e-4 * X, 1e-9), K * 1e-4 * X, 1e-3);
            // Slow, against Stribeck's speed.
            assert_close(pushed(&joint, 40.0 * X, 1e-6), limit, 1e-4);
            assert_close(pushed(&joint, -40.0 * X, 1e-6), -limit, 1e-4);
        }
    }

    #[test]
    fn bouc_wens_slope_on_reversal_is_the_unloading_ratio() {
        for ratio in [1.0, 1.6] {
            let law = Gradual::BoucWen { sharpness: 1.7, unloading_ratio: ratio };
            let from = Reach { held: F, stiffness: K, limits: [F, F], duration: 1.0 };
            assert_close(law.advance(from, -1e-6 * X).slope, ratio * K, 1e-5);
        }
    }

    #[test]
    fn lugre_slips_steadily_at_stribecks_curve() {
        for speed in [1e-4, 1e-3, 3e-3] {
            let expected = F * (1.0 + 0.4 * (-(speed / 1e-3_f64).powi(2)).exp());
            for damping in [0.0, 2e3] {
                assert_close(pushed(&of(lugre(damping)), 60.0 * X, speed), expected, 1e-6);
            }
        }
    }

    #[test]
    fn from_rest_no_law_ever_gives_back_more_than_was_put_in() {
        for (index, law) in every().into_iter().enumerate() {
            let joint = of(law);
            let mut contact = Contact::at_rest(&joint, 0.0);
            let mut random = Random::new(7 + index as u64);
            let waves: [[f64; 3]; 4] = std::array::from_fn(|_| {
                [random.between(0.3, 2.0) * X, random.between(0.5, 9.0), random.phase()]
            });
            let place = |time: f64| -> f64 {
                waves.iter().map(|[a, f, p]| a * ((f * time + p).sin() - p.sin())).sum()
            };
            let (mut work, mut before, step) = (0.0, (0.0, 0.0), 1e-4);
            for index in 1..100_000 {
                let time = f64::from(index) * step;
                let force = contact.advance(place(time), LOAD, step, time);
                work += 0.5 * (force + before.1) * (place(time) - before.0);
                before = (place(time), force);
                assert!(work > -1e-9 * F * X, "{joint:?}: {work} at {time}");
            }
            assert!(work > F * X);
        }
    }
}
