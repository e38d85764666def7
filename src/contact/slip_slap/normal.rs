//! The normal direction of a contact: how hard two bodies press on each other.

use crate::contact::error::{Bounds, LawError, checked};
use crate::contact::quadrature::GAUSS_LEGENDRE_16;
use crate::vocabulary::{
    IMPACT_DAMPING, NORMAL_CUBIC_STIFFNESS, NORMAL_EXPONENT, NORMAL_LOAD, NORMAL_STIFFNESS, Quantity,
};

/// How the elastic normal force grows as two bodies approach each other.
///
/// ```text
///   N_c ▲            ╱  Hertz: K δ^p
///       │          ╱    slope k at N0
///   N0 ─┼ ─ ─ ─ ╱
///       │   _.-‾
///   ────┴─‾─────┼──► δ = δ0 − η
///       0       δ0
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum NormalLaw {
    /// `N0 − k η`.
    Linear,
    /// `N0 − k η − k3 η³`: hardening about the position at rest.
    Cubic {
        /// k3 (N/m³), at least zero.
        cubic_stiffness: f64,
    },
    /// `K δ^p`, with K and the static approach δ0 such that force and slope at rest are N0 and k.
    Hertz {
        /// p (1), from 1 to 2: 1.5 for two spheres.
        exponent: f64,
    },
}

/// The normal direction of a contact: an elastic law under a preload, with Hunt and Crossley's damping.
///
/// # Law
/// `N_c = N_el(δ) (1 + λ δ̇)₊`, δ the approach (m), `δ = δ0 − η`: the normal displacement η is zero at rest, where the
/// preload N0 is carried, and opens the contact where it is positive. N_el is a [`NormalLaw`] for δ > 0 and zero for
/// δ ≤ 0: the bodies are apart, and their next touch remembers nothing. They never pull: `N_c ≥ 0`.
///
/// # Parameters
/// `normal_load` N0 (N), at least zero, with Hertz' law above zero; `normal_stiffness` k (N/m), above zero: slope of N_el
/// at rest; `impact_damping` λ (s/m), at least zero.
///
/// # Limits of validity
/// No adhesion, no plasticity: an impact loses energy by λ alone.
///
/// # Reference
/// Hunt & Crossley (1975), *Coefficient of restitution interpreted as damping in vibroimpact*, J. Appl. Mech. 42, 440–445.
///
/// ```
/// use stickslip::contact::{NormalDirection, NormalLaw};
/// let hertz = NormalDirection::new(NormalLaw::Hertz { exponent: 1.5 }, 60.0, 2e7, 0.0)?;
/// // δ0 = p N0/k.
/// assert!((hertz.static_approach() - 4.5e-6).abs() < 1e-18);
/// assert!((hertz.force(0.0, 0.0) - 60.0).abs() < 1e-12);
/// assert_eq!(hertz.force(4.6e-6, 0.0), 0.0);
/// # Ok::<(), stickslip::contact::LawError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NormalDirection {
    law: NormalLaw,
    preload: f64,
    stiffness: f64,
    impact_damping: f64,
    /// δ0 (m).
    static_approach: f64,
}

impl NormalDirection {
    /// `law` under `preload` N0 (N), of the slope `stiffness` k (N/m) there, with `impact_damping` λ (s/m).
    ///
    /// # Errors
    /// [`LawError::OutOfBounds`] for a number outside the bounds.
    pub fn new(law: NormalLaw, preload: f64, stiffness: f64, impact_damping: f64) -> Result<Self, LawError> {
        let legal = |quantity: &Quantity, value, bounds| checked(quantity.name, quantity.unit, value, bounds);
        legal(&NORMAL_STIFFNESS, stiffness, Bounds::POSITIVE)?;
        legal(&IMPACT_DAMPING, impact_damping, Bounds::NOT_NEGATIVE)?;
        let loads = match law {
            NormalLaw::Hertz { .. } => Bounds::POSITIVE,
            _ => Bounds::NOT_NEGATIVE,
        };
        legal(&NORMAL_LOAD, preload, loads)?;
        let static_approach = match law {
            NormalLaw::Linear => preload / stiffness,
            NormalLaw::Cubic { cubic_stiffness } => {
                legal(&NORMAL_CUBIC_STIFFNESS, cubic_stiffness, Bounds::NOT_NEGATIVE)?;
                cubic_root(stiffness, cubic_stiffness, preload)
            }
            NormalLaw::Hertz { exponent } => {
                let bounds =
                    Bounds { lower: std::ops::Bound::Included(1.0), upper: std::ops::Bound::Included(2.0) };
                legal(&NORMAL_EXPONENT, exponent, bounds)? * preload / stiffness
            }
        };
        Ok(Self { law, preload, stiffness, impact_damping, static_approach })
    }

    /// Hertz' law by its constant K (N/m^p) in place of its slope under the preload.
    ///
    /// # Errors
    /// As [`NormalDirection::new`].
    ///
    /// ```
    /// use stickslip::contact::NormalDirection;
    /// let (constant, exponent, preload) = (2e9, 1.5, 60.0);
    /// let hertz = NormalDirection::hertz(constant, exponent, preload, 0.0)?;
    /// assert!((constant * hertz.static_approach().powf(exponent) / preload - 1.0).abs() < 1e-12);
    /// # Ok::<(), stickslip::contact::LawError>(())
    /// ```
    pub fn hertz(constant: f64, exponent: f64, preload: f64, impact_damping: f64) -> Result<Self, LawError> {
        let stiffness = exponent * preload * (constant / preload).powf(1.0 / exponent);
        Self::new(NormalLaw::Hertz { exponent }, preload, stiffness, impact_damping)
    }

    /// The elastic law.
    pub fn law(&self) -> NormalLaw {
        self.law
    }

    /// N0 (N).
    pub fn preload(&self) -> f64 {
        self.preload
    }

    /// k (N/m): slope of the elastic force at rest.
    pub fn stiffness(&self) -> f64 {
        self.stiffness
    }

    /// λ (s/m).
    pub fn impact_damping(&self) -> f64 {
        self.impact_damping
    }

    /// δ0 (m): the normal displacement at which the bodies part.
    pub fn static_approach(&self) -> f64 {
        self.static_approach
    }

    /// N_c (N), never below zero, at the normal displacement η (m) and its rate (m/s).
    pub fn force(&self, displacement: f64, velocity: f64) -> f64 {
        self.force_and_slopes(displacement, velocity)[0]
    }

    /// N_c (N) with its derivatives by η (N/m) and η̇ (N s/m).
    pub fn force_and_slopes(&self, displacement: f64, velocity: f64) -> [f64; 3] {
        self.damped(self.elastic(displacement), velocity)
    }

    /// The elastic force and its slope with what the damping makes of them at η̇ (m/s).
    #[inline]
    fn damped(&self, (elastic, slope): (f64, f64), velocity: f64) -> [f64; 3] {
        let factor = 1.0 - self.impact_damping * velocity;
        // Written so that a NaN stays a NaN and a diverged caller sees it.
        if elastic <= 0.0 || factor <= 0.0 {
            return [0.0; 3];
        }
        [elastic * factor, -slope * factor, -self.impact_damping * elastic]
    }

    /// N_el (N), zero where the bodies are apart, and its slope by the approach (N/m).
    fn elastic(&self, displacement: f64) -> (f64, f64) {
        if displacement >= self.static_approach {
            return (0.0, 0.0);
        }
        match self.law {
            NormalLaw::Linear => {
                (polynomial(self.preload, self.stiffness, 0.0, -displacement), self.stiffness)
            }
            NormalLaw::Cubic { cubic_stiffness } => (
                polynomial(self.preload, self.stiffness, cubic_stiffness, -displacement),
                self.stiffness + 3.0 * cubic_stiffness * displacement * displacement,
            ),
            NormalLaw::Hertz { exponent } => {
                let stretch = 1.0 - displacement / self.static_approach;
                let part = stretch.powf(exponent - 1.0);
                (self.preload * part * stretch, self.stiffness * part)
            }
        }
    }

    /// The fastest that a body of the `mobility` (1/kg) answers at η (m): by the damping and by the slope of the law (1/s).
    pub(crate) fn rate(&self, displacement: f64, mobility: f64) -> f64 {
        if displacement >= self.static_approach {
            return 0.0;
        }
        let (force, slope) = self.elastic(displacement);
        self.impact_damping * force * mobility + (slope * mobility).sqrt()
    }

    /// Energy (J) that the elastic law keeps at η (m): what it gives back until the bodies part.
    pub fn stored_energy(&self, displacement: f64) -> f64 {
        let (open, x) = (-self.static_approach, -displacement);
        if x <= open {
            return 0.0;
        }
        let polynomial = |cubic: f64| {
            let of = |x: f64| x * (self.preload + x * (0.5 * self.stiffness + 0.25 * cubic * x * x));
            of(x) - of(open)
        };
        match self.law {
            NormalLaw::Linear => polynomial(0.0),
            NormalLaw::Cubic { cubic_stiffness } => polynomial(cubic_stiffness),
            NormalLaw::Hertz { exponent } => self.elastic(displacement).0 * (x - open) / (exponent + 1.0),
        }
    }

    /// Energy (J) that the damping takes along a straight way with displacement η (m) and rate (m/s) at both ends, the rate
    /// running linearly over the way: `∫ (N_c − N_el) dδ`. Rates that do not belong to the way make no energy.
    pub(super) fn impact_energy(&self, from: [f64; 2], to: [f64; 2]) -> f64 {
        if self.impact_damping == 0.0 {
            return 0.0;
        }
        // Between the corners of the integrand, where the bodies part and where the damping outweighs the spring.
        let turn = 1.0 / self.impact_damping;
        let mut corners =
            [0.0, crossing(from[0], to[0], self.static_approach), crossing(from[1], to[1], turn), 1.0];
        corners.sort_by(f64::total_cmp);
        let at = |place: f64| [0, 1].map(|i: usize| from[i] + place * (to[i] - from[i]));
        let loss = |place: f64| {
            let [displacement, velocity] = at(place);
            let elastic = self.elastic(displacement);
            self.damped(elastic, velocity)[0] - elastic.0
        };
        let mut sum = 0.0;
        for ends in corners.windows(2) {
            let (middle, half) = (0.5 * (ends[0] + ends[1]), 0.5 * (ends[1] - ends[0]));
            if half > 0.0 {
                let pair = |&(node, weight): &(f64, f64)| {
                    half * weight * (loss(middle - half * node) + loss(middle + half * node))
                };
                sum += GAUSS_LEGENDRE_16.iter().map(pair).sum::<f64>();
            }
        }
        (sum * (from[0] - to[0])).max(0.0)
    }
}

/// `N0 + k x + k3 x³` (N) at the approach x (m) beyond that at rest.
pub(in crate::contact) fn polynomial(preload: f64, stiffness: f64, cubic: f64, approach: f64) -> f64 {
    preload + stiffness * approach + cubic * approach * approach * approach
}

/// Where (0 … 1) a number that runs linearly from `from` to `to` passes `value`; 0 where it does not.
pub(super) fn crossing(from: f64, to: f64, value: f64) -> f64 {
    if (from < value) == (to < value) { 0.0 } else { (value - from) / (to - from) }
}

/// The root y ≥ 0 of `k y + k3 y³ = N0`, by Newton's method from above, where it cannot overshoot.
fn cubic_root(stiffness: f64, cubic: f64, preload: f64) -> f64 {
    let mut y = preload / stiffness;
    for _ in 0..200 {
        let step = (y * (stiffness + cubic * y * y) - preload) / (stiffness + 3.0 * cubic * y * y);
        if step <= f64::EPSILON * y {
            break;
        }
        y -= step;
    }
    y
}
