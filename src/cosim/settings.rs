//! How a system is simulated.

use super::system::SystemError;

/// The frame and the algorithm of a simulation.
///
/// ```
/// use stickslip::cosim::{Algorithm, Settings};
/// let jacobi = Algorithm::Jacobi { extrapolation: 1 };
/// let settings = Settings { tolerance: Some(1e-8), ..Settings::new(jacobi, 1e-4, 0.5) };
/// assert_eq!((settings.start, settings.stop, settings.step), (0.0, 0.5, 1e-4));
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// Start (s).
    pub start: f64,
    /// Stop (s).
    pub stop: f64,
    /// Communication step (s); under [`Settings::adaptive`] the first one.
    pub step: f64,
    /// Relative tolerance inside the slaves; their own where absent.
    pub tolerance: Option<f64>,
    /// How slaves exchange their values.
    pub algorithm: Algorithm,
    /// Steps of varying length, rejected where they are too long; equal ones where absent.
    pub adaptive: Option<Adaptive>,
    /// Whether slaves that do not wait for each other are stepped at the same time.
    pub parallel: Parallel,
    /// Algebraic loops are an error, as some standards for models ask, and not solved.
    pub refuse_algebraic_loops: bool,
}

impl Settings {
    /// From 0 to `stop` (s) in equal steps of `step` (s).
    pub fn new(algorithm: Algorithm, step: f64, stop: f64) -> Self {
        Self {
            start: 0.0,
            stop,
            step,
            tolerance: None,
            algorithm,
            adaptive: None,
            parallel: Parallel::Auto,
            refuse_algebraic_loops: false,
        }
    }

    pub(super) fn check(&self) -> Result<(), SystemError> {
        let mut numbers = vec![
            ("start", self.start, self.start.is_finite(), "a finite number"),
            (
                "stop",
                self.stop,
                self.stop.is_finite() && self.stop >= self.start,
                "finite, not before the start",
            ),
            ("step", self.step, positive(self.step), "finite, above 0"),
        ];
        if let Some(tolerance) = self.tolerance {
            numbers.push(("tolerance", tolerance, positive(tolerance), "finite, above 0"));
        }
        if let Some(adaptive) = self.adaptive {
            let Adaptive { tolerance, smallest, largest, .. } = adaptive;
            // Below, rounding errors reject every step.
            let fits = (1e-10..=1.0).contains(&tolerance);
            numbers.push(("adaptive tolerance", tolerance, fits, "from 1e-10 to 1 (1e-4 is usual)"));
            numbers.push(("smallest step", smallest, positive(smallest), "finite, above 0"));
            let fits = largest.is_finite() && largest >= smallest;
            numbers.push(("largest step", largest, fits, "finite, not below the smallest"));
        }
        if let Algorithm::Strong(strong) = &self.algorithm {
            // Below, rounding errors keep the repetition from its end.
            let fits = strong.tolerance >= 1e-14 && strong.tolerance < 1.0;
            let allowed = "from 1e-14 to below 1 (1e-8 is usual)";
            numbers.push(("iteration tolerance", strong.tolerance, fits, allowed));
            let limit = f64::from(strong.iterations);
            numbers.push(("iterations", limit, strong.iterations > 0, "at least 1"));
        }
        match numbers.into_iter().find(|(.., fits, _)| !fits) {
            Some((name, value, _, allowed)) => Err(SystemError::Setting { name, value, allowed }),
            None => Ok(()),
        }
    }
}

fn positive(value: f64) -> bool {
    value > 0.0 && value.is_finite()
}

/// How slaves exchange their values over a communication step.
///
/// Orders are those of the coupling error as the step goes to zero, for smooth motions; the slaves' own errors come on top.
#[derive(Debug, Clone, PartialEq)]
pub enum Algorithm {
    /// All slaves step at once with inputs extrapolated over the step. Order `extrapolation + 1`, at most 2.
    Jacobi {
        /// 0: inputs hold the values of the step's beginning. 1, 2: they are continued as a polynomial of this order
        /// through output derivatives, or past values where there are none.
        extrapolation: u32,
    },
    /// Slaves step one after the other: inputs from slaves that have stepped run to their new values, others are
    /// extrapolated. Order as [`Algorithm::Jacobi`], with a smaller error.
    GaussSeidel {
        /// As for [`Algorithm::Jacobi`].
        extrapolation: u32,
        /// The slaves' names in the order in which they step; where absent, along the connections, loops opened where
        /// the least depends on an input at once.
        order: Option<Vec<String>>,
    },
    /// The slaves of each loop repeat their step until the inputs they assumed are the outputs they gave. Order 2, and more
    /// while the values are smooth and their slopes known.
    Strong(Strong),
}

/// How the repetition of a step is driven.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Strong {
    /// The method.
    pub method: Method,
    /// Largest difference between assumed and given values that ends the repetition, relative to the largest
    /// magnitude of each in the simulation so far.
    pub tolerance: f64,
    /// Most repetitions of a step.
    pub iterations: u32,
}

impl Default for Strong {
    fn default() -> Self {
        Self { method: Method::Anderson { depth: 5 }, tolerance: 1e-8, iterations: 50 }
    }
}

/// From the difference between assumed and given values to the next assumption.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Method {
    /// Assume what was given: converges where the loop's gain is below one.
    FixedPoint,
    /// The same, relaxed by Aitken's factor (U. Küttler, W. A. Wall, Computational Mechanics 43 (2008) 61–72).
    Aitken,
    /// Least squares over the last differences (D. G. Anderson, Journal of the ACM 12 (1965) 547–560; H. F. Walker, P. Ni,
    /// SIAM Journal on Numerical Analysis 49 (2011) 1715–1735). For one unknown this is the secant method.
    Anderson {
        /// How many differences, at least 1.
        depth: usize,
    },
    /// Newton's method on the connections (S. Sicklinger, V. Belsky, B. Engelmann et al.: Interface Jacobian-based
    /// co-simulation, International Journal for Numerical Methods in Engineering 98 (2014) 418–444), its linear equations
    /// solved by GMRES. Products with the Jacobian are the slaves' directional derivatives, or differences of repeated
    /// steps where a slave has none or where what the derivatives leave out, the motion within the step, keeps the
    /// method from converging.
    Newton,
}

/// Control of the communication step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Adaptive {
    /// Of the measure in [`Adaptive::control`], relative to the largest value or power so far.
    pub tolerance: f64,
    /// Smallest step (s); what goes wrong at this step is accepted and counted.
    pub smallest: f64,
    /// Largest step (s).
    pub largest: f64,
    /// By what.
    pub control: Control,
}

/// What decides about the length of a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Control {
    /// What extrapolation over the step missed of each connected output.
    Error,
    /// The energy residual of each power connection, over step and largest power so far.
    Energy,
    /// The worse of the two.
    Both,
    /// Nothing but slaves that give up on the way.
    Discards,
}

/// Whether slaves are stepped at the same time. The results are the same.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Parallel {
    /// Never.
    Never,
    /// Wherever there are two to step.
    Always,
    /// Where stepping them one by one takes so long that starting threads pays; it is timed.
    #[default]
    Auto,
}
