//! A loading curve as it was measured, between reversals and after them.

use super::ParallelSliders;
use super::error::{Bounds, LawError, checked, checked_pair};
use super::kind::{BaseLaw, JointBase, LawKind, LawParameter, LawValues, MOST_PARAMETERS};
use super::parallel::Sliders;
use crate::vocabulary::{self as v, Quantity, Scale};

/// A tabulated loading curve that every branch after a reversal repeats at twice its size, for contacts whose loops no other
/// law describes.
///
/// ```text
///         T ▲            __──── μN: the end of the table
///           │       _─·──
///           │   _·─         the slope falls at every knot
///           │  ·            by the factor `slope_kept`
///           │ ╱ k
///   ────────┼╱─────────────────► u
///                          range
/// ```
///
/// # Law
/// Straight lines between twelve knots at `1.5^(j − 12)` of the range, j = 1 … 12. The slope is k before the first knot, times
/// `slope_kept_j` after each, and zero after the last. As such a curve is concave it is that of sliders side by side
/// ([`ParallelSliders`]), which makes it a law for any history: Masing's rules between reversals, minor loops that close, a step
/// that is exact, energy that is only lost.
///
/// # State
/// `[u, N, z₁ … z₁₂]`: as [`ParallelSliders`].
///
/// # Parameters
/// `tangential_stiffness` k (N/m) and `friction_coefficient` μ (1), both above zero; eleven numbers `slope_kept_j` (1), from 0
/// to 1: 1 where nothing yields, 0 where everything does.
///
/// # Limits of validity
/// The table ends at the [`range`](Self::range): a motion that goes farther keeps the force of the table's end, which nobody has
/// measured. One load was measured; under another, forces and range change in proportion. Nothing depends on the velocity.
///
/// # Reference
/// Masri and Caughey (1979), *A nonparametric identification technique for nonlinear dynamic problems*, J. Appl. Mech. 46,
/// 433–447, for the force-state map; Masing (1926) for its branches.
///
/// ```
/// use stickslip::contact::{ContactLaw, Inputs, Measured};
/// // A single knot at which everything yields: Jenkins' element.
/// let mut kept = [1.0; 11];
/// kept[4] = 0.0;
/// let law = Measured::new(2e6, 0.5, &kept)?;
/// let mut state = [0.0; 14];
/// law.set_state(0.0, 100.0, 0.0, &mut state);
/// let inputs = |displacement| Inputs { displacement, velocity: 0.0, normal_load: 100.0 };
/// assert!((law.advance(&mut state, inputs(20e-6)) - 40.0).abs() < 1e-6);
/// assert!((law.advance(&mut state, inputs(40e-6)) - 50.0).abs() < 1e-6);
/// assert!((law.range(100.0) - 25e-6 * 1.5_f64.powi(7)).abs() < 1e-9);
/// # Ok::<(), stickslip::contact::LawError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Measured {
    sliders: ParallelSliders,
    /// The range by load (m/N).
    range: f64,
}

/// Knots of the table; the last needs no parameter.
const KNOTS: usize = MOST_PARAMETERS + 1;
const SPACING: f64 = 1.5;
/// Part of the stiffness that a slider has where nothing yields, so that there are always as many.
const LEAST: f64 = 1e-12;

pub(super) static KIND: LawKind = LawKind {
    name: "measured",
    fmu_name: "MeasuredContact",
    summary: "Friction contact: a loading curve tabulated from measured loops",
    equations: &[
        "first loading: straight lines between twelve knots at 1.5^(j − 12) of the range, j = 1 … 12",
        "slope: k before the first knot, times slope_kept_j after knot j, 0 after the last, where T = μ N",
        "after a reversal: the same curve at twice its size (Masing)",
        "k: tangential_stiffness, μ: friction_coefficient, N: normal_load",
    ],
    parameters: &[
        kept(&v::SLOPE_KEPT_1),
        kept(&v::SLOPE_KEPT_2),
        kept(&v::SLOPE_KEPT_3),
        kept(&v::SLOPE_KEPT_4),
        kept(&v::SLOPE_KEPT_5),
        kept(&v::SLOPE_KEPT_6),
        kept(&v::SLOPE_KEPT_7),
        kept(&v::SLOPE_KEPT_8),
        kept(&v::SLOPE_KEPT_9),
        kept(&v::SLOPE_KEPT_10),
        kept(&v::SLOPE_KEPT_11),
    ],
    one_slider: false,
    refuses: |_| None,
    build: |&LawValues { tangential_stiffness, friction_coefficient, own }| {
        let kept = std::array::from_fn(|k| own[k]);
        Ok(Measured::new(tangential_stiffness, friction_coefficient, &kept)?.into())
    },
};

const fn kept(quantity: &'static Quantity) -> LawParameter {
    LawParameter {
        quantity,
        default: None,
        includes_min: false,
        one_slider_at: None,
        range: |_| (0.0, 1.0, Scale::Linear),
    }
}

impl Measured {
    /// Knots of a table.
    pub const KNOTS: usize = KNOTS;

    /// Each knot over the one before.
    pub const SPACING: f64 = SPACING;

    /// A table of stiffness `tangential_stiffness` (N/m) before its first knot, whose end carries `friction_coefficient` (1)
    /// times the load, with the part `slope_kept` of the slope that is left after each knot but the last.
    ///
    /// # Errors
    /// [`LawError::OutOfBounds`] unless stiffness and friction are finite and above zero, and every part lies between 0 and 1.
    pub fn new(
        tangential_stiffness: f64,
        friction_coefficient: f64,
        slope_kept: &[f64; KNOTS - 1],
    ) -> Result<Self, LawError> {
        let (stiffness, friction) = checked_pair(tangential_stiffness, friction_coefficient)?;
        let part = Bounds { upper: std::ops::Bound::Included(1.0), ..Bounds::NOT_NEGATIVE };
        for (kept, parameter) in slope_kept.iter().zip(KIND.parameters) {
            checked(parameter.quantity.name, parameter.quantity.unit, *kept, part)?;
        }
        let mut slope = stiffness;
        let falls: [f64; KNOTS] = std::array::from_fn(|k| {
            let before = slope;
            slope *= slope_kept.get(k).copied().unwrap_or(0.0);
            (before - slope).max(LEAST * stiffness)
        });
        let knots = Self::knots();
        let whole: f64 = falls.iter().zip(knots).map(|(fall, knot)| fall * knot).sum();
        let range = friction / whole;
        let elements: [(f64, f64); KNOTS] = std::array::from_fn(|k| (falls[k], falls[k] * knots[k] * range));
        Ok(Self { sliders: ParallelSliders::new(&elements)?, range })
    }

    /// Where the knots are, in parts of the range.
    pub fn knots() -> [f64; KNOTS] {
        std::array::from_fn(|k| SPACING.powi(k as i32 + 1 - KNOTS as i32))
    }

    /// The displacement (m) from the loading curve's start at which the table ends, under `normal_load` (N).
    pub fn range(&self, normal_load: f64) -> f64 {
        self.range * normal_load.max(0.0)
    }

    /// The values of the catalogue's parameters, tangential stiffness and coefficient of friction before them, for a table whose
    /// slope falls by `falls` (N/m) at the knots of `range` (m) under `normal_load` (N); `None` where it falls nowhere.
    pub fn values_of(falls: &[f64; KNOTS], range: f64, normal_load: f64) -> Option<[f64; KNOTS + 1]> {
        let mut slope: f64 = falls.iter().sum();
        let carried: f64 = falls.iter().zip(Self::knots()).map(|(fall, knot)| fall * knot * range).sum();
        let mut values = [slope, carried / normal_load].into_iter();
        let legal = slope > 0.0 && carried > 0.0 && normal_load > 0.0;
        let kept = |k: usize| {
            let before = slope;
            slope = (slope - falls[k]).max(0.0);
            // After all has yielded there is no slope to keep a part of.
            if before > 0.0 { slope / before } else { 0.0 }
        };
        let mut kept = (0..KNOTS - 1).map(kept).collect::<Vec<_>>().into_iter();
        legal.then(|| std::array::from_fn(|_| values.next().or_else(|| kept.next()).unwrap_or(0.0)))
    }
}

impl From<Measured> for JointBase {
    fn from(law: Measured) -> Self {
        Self(BaseLaw::Sliders(law.sliders))
    }
}

impl Sliders for Measured {
    fn parallel(&self) -> &ParallelSliders {
        &self.sliders
    }
}
