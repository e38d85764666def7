//! The periodic response of one beam after another to the same excitation, each near the last, and to first order
//! its change from one to another.
//!
//! The unknowns are displacements at the contact (and the excitation), not modal coordinates: they mean the same
//! whatever the modes, so that beams with other masses or another clamp are neighbours too. At a solution
//! `r(x; p) = 0` the change with a parameter is `dx = −J⁻¹ ∂r/∂p dp`: one residual of the neighbour at the same x
//! and the factors there are, no search ([`linearised`]).

pub(crate) mod linearised;
mod measured;
mod reached;

use super::{Assembly, CurveSettings, HarmonicError, Method};
use crate::harmonic::balance::modal::{Balance, Extent, Ports, Workspace};
use crate::harmonic::newton::problem::{Stopping, largest, length, solve};
use crate::harmonic::newton::system::{Operating, PeriodicSystem};
use crate::harmonic::response::start::{directly, indirectly};
use crate::numeric::fourier::coefficient_count;
use crate::numeric::lu::Factors;
use measured::explained;

/// Steps with factors found elsewhere, before the search starts anew.
const MOST_STEPS: usize = 40;
/// Fraction to which a step must bring the residual for the factors to be used again.
const GOOD_FACTORS: f64 = 0.2;
/// Fraction to which a step with new factors must bring the residual; else a search with shorter steps is better.
const GOOD_STEP: f64 = 0.9;

/// Step, as multiple of the motion itself, that leads nowhere near: those that led to a response were 8 times as long at
/// most, the others up to 5000 times, and under the forces there a single evaluation takes as long as ten solutions.
const REACH: f64 = 20.0;
/// Damped steps from a start that is not near enough for the factors, and from nothing.
const NEAR_ITERATIONS: usize = 40;
const FAR_ITERATIONS: usize = 25;
/// Halvings of a step from such a start: those that led to a response were hardly ever shortened more, and what is creeps on,
/// step by step, for seconds.
const NEAR_HALVINGS: usize = 8;
/// Points of a path from a weak excitation or a neighbouring frequency, and the longest step on it as a fraction of the way.
const MOST_POINTS: usize = 60;
const LONGEST_STEP: f64 = 0.2;

/// The excitation, and the discretisation of the response to it.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct SteadyProblem {
    /// Fundamental (rad/s).
    pub angular_frequency: f64,
    /// Coefficients `[a0, c1, s1, …]` (N), of the response's harmonics at most.
    pub coefficients: Vec<f64>,
    /// Highest harmonic of the modes.
    pub harmonics: usize,
    /// Highest harmonic of the contact, from that of the modes to twice that.
    pub contact_harmonics: usize,
    /// Highest harmonic of the sensors' motion, at least that of the modes: above that the modes follow the contact's
    /// force without acting on it.
    pub sensed_harmonics: usize,
    /// Largest residual accepted, as a fraction of the largest displacement among the unknowns.
    pub tolerance: f64,
}

/// A solution to start from, for beams condensed to the same ports and to others.
#[derive(Debug, Clone)]
pub(crate) struct Start {
    /// Displacement at the contact, behind its flexibility and in front of it: the unknown is either.
    contact: [Vec<f64>; 2],
    /// Displacements at the other ports, by name.
    ports: Vec<(String, Vec<f64>)>,
    /// Factors at a solution, and the ports they belong to.
    factors: Option<Box<(Ports, Factors)>>,
}

/// A periodic response.
#[derive(Debug)]
pub(crate) struct Steady {
    balance: Balance,
    unknowns: Vec<f64>,
    at: Operating,
}

impl Ports {
    /// What any of them needs.
    pub fn of_all(assembly: &Assembly, neighbours: &[Assembly]) -> Self {
        neighbours.iter().fold(Self::of(&assembly.system), |all, next| all.or(&Self::of(&next.system)))
    }
}

impl SteadyProblem {
    pub(super) fn operating(&self) -> Operating {
        Operating::forced(self.angular_frequency, 1.0)
    }

    fn extent(&self, ports: &Ports) -> Extent {
        Extent { harmonics: self.harmonics, contact: self.contact_harmonics, ports: ports.clone() }
    }

    /// `assembly` in the workspace that another has left.
    pub(super) fn balance(
        &self,
        assembly: &Assembly,
        ports: &Ports,
        left: Option<Workspace>,
    ) -> Result<Balance, HarmonicError> {
        Balance::with(assembly, &self.coefficients, &self.extent(ports), Method::Exact, left)
    }

    /// The response of `assembly`, with unknowns that its `neighbours` have too: that near `start`, or without a start
    /// one sought from nothing.
    ///
    /// # Errors
    /// [`HarmonicError`] where no solution was found.
    pub fn solve(
        &self,
        assembly: &Assembly,
        neighbours: &[Assembly],
        start: Option<&Start>,
    ) -> Result<Steady, HarmonicError> {
        let ports = Ports::of_all(assembly, neighbours);
        let mut balance = self.balance(assembly, &ports, None)?;
        let at = self.operating();
        if let Some(start) = start {
            let mut unknowns = start.unknowns(&ports);
            let factors =
                start.factors.as_ref().filter(|known| known.0 == ports).map(|known| known.1.clone());
            if self.correct(&mut balance, &mut unknowns, &at, factors) {
                return Ok(Steady { balance, unknowns, at });
            }
            let (mut unknowns, mut at) = (start.unknowns(&ports), at);
            let stopping = Stopping {
                tolerance: self.tolerance,
                max_iterations: NEAR_ITERATIONS,
                reach: REACH,
                halvings: NEAR_HALVINGS,
                interrupt: None,
            };
            balance.forget();
            solve(&mut balance, &mut unknowns, &mut at, &[], &mut [], &stopping)?;
            return Ok(Steady { balance, unknowns, at });
        }
        let settings = self.settings();
        if let Some(unknowns) = directly(&mut balance, at, &settings)? {
            return Ok(Steady { balance, unknowns, at });
        }
        if let Ok((start, settled)) = self.reached(assembly) {
            let found = self.solve(assembly, neighbours, Some(&start));
            // Where a settled motion leads to none, paths from other levels and frequencies do hardly either, and take 1 to 6 s: of
            // 17 beams among candidates for what is missing one, to a response far from what was measured.
            if settled || found.is_ok() {
                return found;
            }
        }
        let (unknowns, _) = indirectly(&mut balance, at, &settings)?;
        Ok(Steady { balance, unknowns, at })
    }

    /// Of a search from nothing.
    fn settings(&self) -> CurveSettings {
        CurveSettings {
            harmonics: self.harmonics,
            tolerance: self.tolerance,
            max_iterations: FAR_ITERATIONS,
            max_step: LONGEST_STEP,
            max_points: MOST_POINTS,
            ..CurveSettings::default()
        }
    }

    /// Where to look for the response that was measured: the displacement coefficients (m) of every sensor of the beam
    /// are `motion`, zero where nothing was seen. In the workspace that another has left, left for another.
    ///
    /// # Errors
    /// [`HarmonicError`] for a beam or contact that cannot be balanced.
    pub fn start_at(
        &self,
        assembly: &Assembly,
        motion: &[Vec<f64>],
        left: &mut Option<Workspace>,
    ) -> Result<Start, HarmonicError> {
        let mut balance = self.balance(assembly, &Ports::of(&assembly.system), left.take())?;
        let (coefficients, force) = explained(&balance, self.angular_frequency, &self.coefficients, motion);
        let unknowns = balance.unknowns_of(&coefficients, &force, self.angular_frequency);
        let start = Start::of(&balance, &unknowns, &force, None);
        *left = Some(balance.into_workspace());
        Ok(start)
    }

    /// Newton's method with the factors at hand as long as they are good enough; false where it does not converge.
    fn correct(
        &self,
        balance: &mut Balance,
        unknowns: &mut [f64],
        at: &Operating,
        factors: Option<Factors>,
    ) -> bool {
        balance.forget();
        // Without factors the first step must find its own.
        let (mut before, mut fresh) = (if factors.is_some() { f64::INFINITY } else { 0.0 }, false);
        let mut factors = factors.unwrap_or_default();
        let mut step = vec![0.0; unknowns.len()];
        for _ in 0..MOST_STEPS {
            let Ok(scale) = balance.evaluate(unknowns, at, &[]) else { return false };
            let largest = largest(balance.residual());
            let residual = if scale > 0.0 { largest / scale } else { largest };
            if residual <= self.tolerance {
                return true;
            }
            if !residual.is_finite() || (fresh && residual > GOOD_STEP * before) {
                return false;
            }
            fresh = residual > GOOD_FACTORS * before;
            if fresh {
                factors.reset(unknowns.len()).copy_from_slice(balance.jacobian().as_slice());
                if !factors.factor() {
                    return false;
                }
            }
            before = residual;
            step.iter_mut().zip(balance.residual()).for_each(|(s, r)| *s = -r);
            factors.solve(&mut step);
            if length(&step) > REACH * length(unknowns) {
                return false;
            }
            unknowns.iter_mut().zip(&step).for_each(|(x, s)| *x += s);
        }
        false
    }
}

impl Start {
    /// Where the law of the contact has the force (N) by these coefficients.
    fn of(
        balance: &Balance,
        unknowns: &[f64],
        force: &[f64],
        factors: Option<Box<(Ports, Factors)>>,
    ) -> Self {
        Self { contact: balance.either_side(unknowns, force), ports: balance.at_ports(), factors }
    }

    /// The unknowns as they are: found anew without a step.
    fn exactly(balance: &Balance, unknowns: &[f64]) -> Self {
        let mut start = Self::of(balance, unknowns, balance.force(), None);
        let own = unknowns[balance.displacement().len()..].chunks_exact(balance.count);
        for (name, own) in balance.ports().names().zip(own) {
            if let Some((_, known)) = start.ports.iter_mut().find(|(known, _)| known == name) {
                known.copy_from_slice(own);
            }
        }
        start
    }

    /// Coefficients of the displacement at the contact (m).
    pub fn contact(&self) -> &[f64] {
        &self.contact[0]
    }

    /// Whether it has the harmonics of `problem`.
    pub fn fits(&self, problem: &SteadyProblem) -> bool {
        let count = coefficient_count(problem.harmonics);
        self.contact().len() == coefficient_count(problem.contact_harmonics)
            && self.ports.iter().all(|(_, coefficients)| coefficients.len() == count)
    }

    /// The same motion in the harmonics of `problem`, which has no fewer.
    pub fn padded(&self, problem: &SteadyProblem) -> Self {
        let mut start = Self { factors: None, ..self.clone() };
        let wide = coefficient_count(problem.contact_harmonics);
        start.contact.iter_mut().for_each(|side| side.resize(wide, 0.0));
        let count = coefficient_count(problem.harmonics);
        start.ports.iter_mut().for_each(|(_, coefficients)| coefficients.resize(count, 0.0));
        start
    }

    /// What a balance condensed to `ports` calls its unknowns.
    pub(super) fn unknowns(&self, ports: &Ports) -> Vec<f64> {
        let at = |name: &str| self.ports.iter().find(|(known, _)| known == name);
        let others = ports.names().filter_map(at).flat_map(|(_, coefficients)| coefficients);
        self.contact[usize::from(ports.in_front())].iter().chain(others).copied().collect()
    }
}

impl Steady {
    /// Displacement coefficients (m) of every sensor, one after the other.
    pub fn sensors(&mut self, problem: &SteadyProblem) -> Vec<f64> {
        sensed(&mut self.balance, &self.at, problem)
    }

    /// The solution, to be found again without a step.
    pub fn here(&self) -> Start {
        Start::exactly(&self.balance, &self.unknowns)
    }
}

/// Evaluates the balance; the factors of its derivatives.
pub(super) fn factored(
    balance: &mut Balance,
    unknowns: &[f64],
    at: &Operating,
) -> Result<Factors, HarmonicError> {
    balance.evaluate(unknowns, at, &[])?;
    let mut factors = Factors::default();
    factors.reset(unknowns.len()).copy_from_slice(balance.jacobian().as_slice());
    let singular = HarmonicError::InvalidInput("the balance is singular at the solution");
    if factors.factor() { Ok(factors) } else { Err(singular) }
}

/// Displacement coefficients (m) of every sensor at the last evaluation.
pub(super) fn sensed(balance: &mut Balance, at: &Operating, problem: &SteadyProblem) -> Vec<f64> {
    let beyond = balance.beyond(at, problem.sensed_harmonics);
    balance.sensors().iter().flat_map(|sensor| balance.output_with(sensor, &beyond)).collect()
}
