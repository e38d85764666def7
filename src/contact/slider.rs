//! The element of piecewise-linear hysteresis.

/// A spring with play, in series with a Coulomb slider, under a constant normal load:
/// `T = k · d(u − z)`, held within `−lower_limit ≤ T ≤ upper_limit` by the slider `z`, which follows in slip.
///
/// `d(x)` is zero within the play, `x − play_above` above and `x − play_below` below it. Without play it is
/// Jenkins' element; with `play_below = −∞` and infinite limits a one-sided spring; with neither play
/// nor limits a linear spring.
///
/// ```
/// use stickslip::contact::Slider;
/// let slider = Slider::jenkins(2e6, 50.0);
/// let (force, position) = slider.step(0.0, 40e-6);
/// assert_eq!(force, 50.0);
/// assert!((position - 15e-6).abs() < 1e-18);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Slider {
    /// k (N/m), above zero.
    pub stiffness: f64,
    /// Lower end of the play (m), at most zero; −∞ for a spring that never pulls.
    pub play_below: f64,
    /// Upper end of the play (m), at least `play_below`; +∞ for a spring that never pushes.
    pub play_above: f64,
    /// Largest −T (N); ∞ where nothing slips.
    pub lower_limit: f64,
    /// Largest T (N); ∞ where nothing slips.
    pub upper_limit: f64,
}

impl Slider {
    /// Jenkins' element with stiffness `stiffness` (N/m) and limit `limit` (N).
    pub const fn jenkins(stiffness: f64, limit: f64) -> Self {
        Self { stiffness, play_below: 0.0, play_above: 0.0, lower_limit: limit, upper_limit: limit }
    }

    /// A spring of stiffness `stiffness` (N/m) that neither has play nor slips.
    pub const fn linear(stiffness: f64) -> Self {
        Self::jenkins(stiffness, f64::INFINITY)
    }

    /// A spring of stiffness `stiffness` (N/m) that pushes back above the displacement `gap` (m) alone.
    pub const fn unilateral(stiffness: f64, gap: f64) -> Self {
        Self { play_below: f64::NEG_INFINITY, play_above: gap, ..Self::linear(stiffness) }
    }

    /// Whether the reversed displacement gives the reversed force.
    pub fn is_odd(&self) -> bool {
        self.play_below == -self.play_above && self.lower_limit == self.upper_limit
    }

    /// Force (N) and slider position (m) after the displacement has run one way to `displacement` (m), from
    /// the slider position `slider` (m).
    pub fn step(&self, slider: f64, displacement: f64) -> (f64, f64) {
        let stretch = displacement - slider;
        // Written so that a NaN stays a NaN and a diverged caller sees it.
        let force = self.stiffness * (stretch - stretch.max(self.play_below).min(self.play_above));
        if force > self.upper_limit {
            (self.upper_limit, displacement - self.play_above - self.upper_limit / self.stiffness)
        } else if force < -self.lower_limit {
            (-self.lower_limit, displacement - self.play_below + self.lower_limit / self.stiffness)
        } else {
            (force, slider)
        }
    }
}
