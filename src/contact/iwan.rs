//! The four-parameter Iwan element.

use std::ops::Bound;

use super::error::{Bounds, LawError, checked, checked_pair};
use super::kind::{BaseLaw, JointBase, LawKind, LawParameter, LawRule, LawValues};
use super::parallel::Sliders;
use super::{ContactLaw, ParallelSliders};
use crate::vocabulary::{self as v, Scale};

/// The four-parameter Iwan element: sliders of every strength side by side, as a joint slips from its
/// edge inwards.
///
/// ```text
///   ρ(φ) ▲                 ↑ S
///        │╲                │
///        │ ╲_     R φ^χ    │
///        │   ╲────_________│
///   ─────┼─────────────────┴──► φ
///                        φ_max
/// ```
///
/// # Law
/// `T = ∫ ρ(φ) [u − z(φ)] dφ`, in which the slider of strength φ yields at the stretch φ, with
/// `ρ(φ) = R φ^χ` up to `φ_max` and `S δ(φ − φ_max)` there. Segalman's four parameters are kept in the form
/// that can be measured: the stiffness `K_T` of small motion, the force `F_S` of macro-slip, the exponent
/// χ of the dissipation, `D ∝ X^(χ+3)`, and `β = S/[R φ_max^(χ+1)/(χ+1)]`, the terminal slider's
/// stiffness to that of all others. From
/// `K_T = (1 + β) R φ_max^(χ+1)/(χ+1)` and `F_S = R φ_max^(χ+2)/(χ+2) + S φ_max` follow
///
/// ```text
///   φ_max = F_S (1 + β) / {K_T [β + (χ+1)/(χ+2)]},   R = K_T (χ+1) / [(1 + β) φ_max^(χ+1)].
/// ```
///
/// Here `F_S = μN`. All strengths follow the normal load in proportion, `φ_max = travel_per_load · N`, while
/// the stiffnesses stay: a change of `N` in stick creates no force.
/// Below macro-slip a symmetric closed loop of amplitude `X < φ_max` dissipates
/// `4 R X^(χ+3)/[(χ+2)(χ+3)]`; Masing's rules hold.
///
/// # Discretisation
/// `[0, φ_max]` is cut into intervals ([`IwanSpacing`]). One Jenkins element stands for each, with its
/// stiffness `∫ρ dφ` and its strength `∫ρφ dφ`, and one for the terminal slider if β > 0. So
/// `K_T` and `F_S` are exact for any number, and so is the loading curve wherever it meets the end of an
/// interval; in between it lies above the smooth one by the second order in the interval's length. The dissipation at the end
/// of an interval is too large by `4 Σ ∫ρ (φ − φ̄)² dφ` over the intervals passed, second order as well. Loops
/// smaller than the first interval are all stick: geometric spacing puts the intervals where they
/// are needed and keeps the relative error of the dissipation even over decades of amplitude.
///
/// # State
/// As [`ParallelSliders`].
///
/// # Parameters
/// `tangential_stiffness` K_T (N/m) and `friction_coefficient` μ (1), both above zero; `exponent` χ (1), above −1 and
/// at most 0; `ratio` β (1), at least zero; number of intervals and their spacing.
///
/// # Limits of validity
/// That of its sliders: a step must not contain a reversal. The power law of the dissipation is
/// met from a few times the length of the first interval upwards.
///
/// # Reference
/// Segalman (2005), *A four-parameter Iwan model for lap-type joints*, J. Appl. Mech. 72, 752–760.
///
/// ```
/// use stickslip::contact::{ContactLaw, Iwan, IwanSpacing};
/// let law = Iwan::new(5e6, 0.5, -0.4, 2.0, 30, IwanSpacing::Geometric { growth: 1.2 })?;
/// let sliders = law.sliders_alone();
/// assert_eq!(sliders.elements().len(), 31);
/// assert!((sliders.tangential_stiffness() / 5e6 - 1.0).abs() < 1e-13);
/// assert!((law.limit(100.0) / 50.0 - 1.0).abs() < 1e-13);
/// # Ok::<(), stickslip::contact::LawError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Iwan {
    sliders: ParallelSliders,
    tangential_stiffness: f64,
    friction_coefficient: f64,
    exponent: f64,
    ratio: f64,
}

/// How the strengths `0 … φ_max` of an [`Iwan`] element are cut into intervals.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum IwanSpacing {
    /// All of one length.
    Equal,
    /// Each longer than the one before it by the factor `growth` (1), above 1 and at most 10; Segalman uses 1.2.
    Geometric {
        /// The factor.
        growth: f64,
    },
}

impl IwanSpacing {
    /// Ends of `count` intervals as fractions of the whole, without the zero at the start.
    fn ends(self, count: usize) -> impl Iterator<Item = f64> {
        let whole = count as f64;
        (1..=count).map(move |index| match self {
            Self::Equal => index as f64 / whole,
            // (gᵐ − 1)/(gⁿ − 1), which neither overflows nor cancels in this form.
            Self::Geometric { growth } => {
                let (m, log) = (index as f64, growth.ln());
                ((m - whole) * log).exp() * (-m * log).exp_m1() / (-whole * log).exp_m1()
            }
        })
    }
}

/// How finely a model's Iwan element is cut: the shortest interval is about 1/7000 of the longest stretch.
const INTERVALS: usize = 40;
const SPACING: IwanSpacing = IwanSpacing::Geometric { growth: 1.2 };

pub(super) static KIND: LawKind = LawKind {
    name: "iwan",
    fmu_name: "IwanContact",
    summary: "Friction contact: the four-parameter Iwan element",
    equations: &[
        "T = ∫ ρ(φ) [u − z(φ)] dφ, the slider of strength φ yielding at |u − z| = φ",
        "ρ(φ) = R φ^χ up to φmax, and S δ(φ − φmax) there; β = S (χ + 1) / (R φmax^(χ+1))",
        "φmax = μ N (1 + β) / {K [β + (χ+1)/(χ+2)]}, R = K (χ+1) / [(1 + β) φmax^(χ+1)]",
        "K: tangential_stiffness, χ: exponent, β: ratio, μ: friction_coefficient, N: normal_load",
    ],
    parameters: &[
        LawParameter {
            quantity: &v::EXPONENT,
            default: None,
            includes_min: false,
            one_slider_at: None,
            range: |_| (-0.95, 0.0, Scale::Linear),
        },
        LawParameter {
            quantity: &v::RATIO,
            default: None,
            includes_min: false,
            one_slider_at: Some(f64::INFINITY),
            range: |_| (0.0, 100.0, Scale::Linear),
        },
    ],
    one_slider: false,
    refuses: |values| {
        let exponent = values.own[0];
        (exponent > 0.0).then(|| LawRule {
            parameter: v::EXPONENT.name,
            message: format!("`exponent` must be above -1 and at most 0, not {exponent}"),
            help: "above 0 the weakest sliders would be the rarest",
        })
    },
    build: |&LawValues { tangential_stiffness, friction_coefficient, own }| {
        let (exponent, ratio) = (own[0], own[1]);
        let law = Iwan::new(tangential_stiffness, friction_coefficient, exponent, ratio, INTERVALS, SPACING)?;
        Ok(law.into())
    },
};

/// More sliders than this cost time without a gain in accuracy.
const MOST_INTERVALS: f64 = 10_000.0;

impl Iwan {
    /// An element of stiffness `tangential_stiffness` (N/m), whose macro-slip force is
    /// `friction_coefficient` (1) times the normal load, with Segalman's `exponent` χ (1) and `ratio` β (1),
    /// in `intervals` sliders and the terminal one if β > 0.
    ///
    /// # Errors
    /// [`LawError::OutOfBounds`] unless stiffness and friction are finite and above zero, −1 < χ ≤ 0, β is finite and at least
    /// zero, there are 1 to 10 000 intervals, and a geometric growth is above 1 and at most 10.
    ///
    /// ```
    /// use stickslip::contact::{ContactLaw, Iwan, IwanSpacing};
    /// // χ = −0.5, β = 2, 20 sliders.
    /// let law = Iwan::new(5e6, 0.5, -0.5, 2.0, 20, IwanSpacing::Geometric { growth: 1.5 })?;
    /// assert!((law.limit(100.0) - 50.0).abs() < 1e-12);
    /// # Ok::<(), stickslip::contact::LawError>(())
    /// ```
    pub fn new(
        tangential_stiffness: f64,
        friction_coefficient: f64,
        exponent: f64,
        ratio: f64,
        intervals: usize,
        spacing: IwanSpacing,
    ) -> Result<Self, LawError> {
        let (stiffness, friction) = checked_pair(tangential_stiffness, friction_coefficient)?;
        let above_minus_one = Bounds { lower: Bound::Excluded(-1.0), upper: Bound::Included(0.0) };
        checked("exponent", "1", exponent, above_minus_one)?;
        checked("ratio", "1", ratio, Bounds::NOT_NEGATIVE)?;
        let count = Bounds { lower: Bound::Included(1.0), upper: Bound::Included(MOST_INTERVALS) };
        checked("intervals", "1", intervals as f64, count)?;
        if let IwanSpacing::Geometric { growth } = spacing {
            let above_one = Bounds { lower: Bound::Excluded(1.0), upper: Bound::Included(10.0) };
            checked("growth", "1", growth, above_one)?;
        }
        // Of the distributed sliders together; their mean strength is (χ+1)/(χ+2) of the largest.
        let distributed = stiffness / (1.0 + ratio);
        let mean = (exponent + 1.0) / (exponent + 2.0);
        let travel_per_load = friction * (1.0 + ratio) / (stiffness * (ratio + mean));
        let mut elements = Vec::with_capacity(intervals + 1);
        let mut start = 0.0;
        for end in spacing.ends(intervals) {
            let fraction = power_difference(start, end, exponent + 1.0);
            let moment = power_difference(start, end, exponent + 2.0);
            let element = (distributed * fraction, distributed * mean * moment * travel_per_load);
            // Very many intervals of a fast growth vanish at the lower end, and with them what they carry.
            if element.0 > 0.0 && element.1 > 0.0 {
                elements.push(element);
            }
            start = end;
        }
        if ratio > 0.0 {
            let terminal = distributed * ratio;
            elements.push((terminal, terminal * travel_per_load));
        }
        Ok(Self {
            sliders: ParallelSliders::new(&elements)?,
            tangential_stiffness,
            friction_coefficient,
            exponent,
            ratio,
        })
    }

    /// Stiffness of small motion, K_T (N/m).
    pub fn tangential_stiffness(&self) -> f64 {
        self.tangential_stiffness
    }

    /// Coefficient of friction, μ (1).
    pub fn friction_coefficient(&self) -> f64 {
        self.friction_coefficient
    }

    /// Exponent of the distribution of strengths, χ (1).
    pub fn exponent(&self) -> f64 {
        self.exponent
    }

    /// Stiffness of the terminal slider to that of all others, β (1).
    pub fn ratio(&self) -> f64 {
        self.ratio
    }

    /// Displacement of macro-slip (m) under `normal_load` (N), φ_max: there the last slider yields.
    pub fn macro_slip_displacement(&self, normal_load: f64) -> f64 {
        let mean = (self.exponent + 1.0) / (self.exponent + 2.0);
        self.sliders.limit(normal_load) * (1.0 + self.ratio)
            / (self.tangential_stiffness * (self.ratio + mean))
    }

    /// R (N/m^(χ+2)) of the distribution `ρ = R φ^χ` under `normal_load` (N).
    pub fn distribution_scale(&self, normal_load: f64) -> f64 {
        let power = self.exponent + 1.0;
        let largest = self.macro_slip_displacement(normal_load);
        self.tangential_stiffness * power / ((1.0 + self.ratio) * largest.powf(power))
    }

    /// The sliders that stand for the element.
    pub fn sliders_alone(&self) -> &ParallelSliders {
        &self.sliders
    }
}

/// `end^power − start^power` for `0 ≤ start < end`, without cancellation.
fn power_difference(start: f64, end: f64, power: f64) -> f64 {
    if start == 0.0 {
        return end.powf(power);
    }
    -end.powf(power) * (power * (start / end).ln()).exp_m1()
}

impl From<Iwan> for JointBase {
    fn from(law: Iwan) -> Self {
        Self(BaseLaw::Sliders(law.sliders))
    }
}

impl Sliders for Iwan {
    fn parallel(&self) -> &ParallelSliders {
        &self.sliders
    }
}
