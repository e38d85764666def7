//! The periodic response of one beam after another to the same excitation, each near the last, and to first order
//! its change from one to another.
//!
//! The unknowns are displacements at the contact (and the excitation), not modal coordinates: they mean the same
//! whatever the modes, so that beams with other masses or another clamp are neighbours too. At a solution
//! `r(x; p) = 0` the change with a parameter is `dx = −J⁻¹ ∂r/∂p dp`: one residual of the neighbour at the same x
//! and the factors there are, no search.

use super::balance::{Balance, Extent, Signals};
use super::cycle::map::ContactMap;
use super::factors::Factors;
use super::follow::{Family, State, find};
use super::forced::Forced;
use super::fourier::coefficient_count;
use super::measured::explained;
use super::problem::{Newton, Stopping};
use super::system::{Operating, PeriodicSystem};
use super::{ContactOnBeam, HarmonicError, Method, Settings};
use crate::structure::ModalBeam;

/// Steps with factors found elsewhere, before the search starts anew.
const MOST_STEPS: usize = 40;
/// Share to which a step must bring the residual for the factors to be used again.
const GOOD_FACTORS: f64 = 0.2;
/// Share to which a step with new factors must bring the residual; else a search with shorter steps is better.
const GOOD_STEP: f64 = 0.9;

/// Share of a step by which the change along it is told.
const PROBE: f64 = 1e-4;

/// Damped steps from a start that is not near enough for the factors, and from nothing.
const NEAR_ITERATIONS: usize = 12;
const FAR_ITERATIONS: usize = 25;

/// A beam with its contact.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Driven<'a> {
    pub beam: &'a ModalBeam,
    pub contact: Option<ContactOnBeam<'a>>,
    /// Coefficients `[c1, s1, …]` (N) of the normal load's swing over the period; empty where it is constant.
    pub load_swing: &'a [f64],
    /// Displacement (m) at which the contact that never moved has no force.
    pub seat: f64,
}

/// The excitation, and the discretisation of the response to it.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Forcing {
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
    /// Largest residual accepted, as share of the largest displacement among the unknowns.
    pub tolerance: f64,
}

/// A solution to start from, for beams with the same signals and with others.
#[derive(Debug, Clone)]
pub(crate) struct Start {
    /// Displacement at the contact, shortening, displacement at the excitation, stretch of the string.
    contact: Vec<f64>,
    shortening: Vec<f64>,
    excitation: Vec<f64>,
    string: Vec<f64>,
    /// Factors at a solution, and the signals they belong to.
    factors: Option<(Signals, Factors)>,
}

/// A periodic response with its equations as they stand there.
#[derive(Debug)]
pub(crate) struct Steady<'a> {
    balance: Balance<'a>,
    unknowns: Vec<f64>,
    at: Operating,
    factors: Factors,
    /// Whether derivatives and factors are those at the solution.
    current: bool,
    /// Coefficients of the sensors there.
    sensors: Vec<f64>,
    /// The contact of the last neighbour: its workspace serves the next one.
    spare: Option<ContactMap>,
}

impl Signals {
    fn of_all(driven: Driven, neighbours: &[Driven]) -> Self {
        neighbours.iter().fold(Self::of(driven.beam), |all, next| all.or(Self::of(next.beam)))
    }
}

impl Forcing {
    fn operating(&self) -> Operating {
        Operating::forced(self.angular_frequency, 1.0)
    }

    fn extent(&self, signals: Signals) -> Extent {
        Extent { harmonics: self.harmonics, contact: self.contact_harmonics, signals }
    }

    fn balance<'a>(&self, driven: Driven<'a>, signals: Signals) -> Result<Balance<'a>, HarmonicError> {
        let extent = self.extent(signals);
        let mut balance =
            Balance::with(driven.beam, driven.contact, &self.coefficients, &extent, Method::Exact)?;
        balance.swing_load(driven.load_swing);
        balance.seat(driven.seat);
        Ok(balance)
    }

    /// The response of `driven`, with unknowns that its `neighbours` have too: that near `start`, or without a start
    /// one sought from nothing.
    ///
    /// # Errors
    /// [`HarmonicError`] where no solution was found.
    pub fn solve<'a>(
        &self,
        driven: Driven<'a>,
        neighbours: &[Driven],
        start: Option<&Start>,
    ) -> Result<Steady<'a>, HarmonicError> {
        let signals = Signals::of_all(driven, neighbours);
        let mut balance = self.balance(driven, signals)?;
        let at = self.operating();
        let steady = |balance, unknowns| Steady::new(balance, unknowns, self);
        let mut family = Forced { angular_frequency: self.angular_frequency };
        if let Some(start) = start {
            let mut unknowns = start.unknowns(signals);
            let factors =
                start.factors.as_ref().filter(|(of, _)| *of == signals).map(|(_, factors)| factors.clone());
            if self.correct(&mut balance, &mut unknowns, &at, factors) {
                return Ok(steady(balance, unknowns));
            }
            let mut state = State { x: start.unknowns(signals), at };
            let stopping = Stopping { tolerance: self.tolerance, max_iterations: NEAR_ITERATIONS };
            balance.forget();
            family.solve(&mut balance, &mut Newton::default(), 1.0, &mut state, &stopping)?;
            return Ok(steady(balance, state.x));
        }
        let settings = Settings {
            harmonics: self.harmonics,
            method: Method::Exact,
            tolerance: self.tolerance,
            max_iterations: FAR_ITERATIONS,
        };
        let (state, _) = find(&mut family, &mut balance, 1.0, None, &settings)?;
        Ok(steady(balance, state.x))
    }

    /// `driven` as it stands at `start`, whether that is a response or not; with unknowns that its `neighbours` have
    /// too.
    ///
    /// # Errors
    /// [`HarmonicError`] for a beam or contact that cannot be balanced.
    pub fn about<'a>(
        &self,
        driven: Driven<'a>,
        neighbours: &[Driven],
        start: &Start,
    ) -> Result<Steady<'a>, HarmonicError> {
        let signals = Signals::of_all(driven, neighbours);
        Ok(Steady::new(self.balance(driven, signals)?, start.unknowns(signals), self))
    }

    /// Where to look for the response that was measured: the displacement coefficients (m) of every sensor of the beam
    /// are `motion`, zero where nothing was seen.
    ///
    /// # Errors
    /// [`HarmonicError`] for a beam or contact that cannot be balanced.
    pub fn start_at(&self, driven: Driven, motion: &[Vec<f64>]) -> Result<Start, HarmonicError> {
        let mut balance = self.balance(driven, Signals::of(driven.beam))?;
        let (coefficients, force) = explained(&balance, self, motion);
        let unknowns = balance.unknowns_of(&coefficients, &force);
        Ok(Start::of(&balance, &unknowns, None))
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
            let Ok(scale) = balance.balance(unknowns, at) else { return false };
            let largest = balance.residual().iter().fold(0.0_f64, |most, r| most.max(r.abs()));
            let residual = if scale > 0.0 { largest / scale } else { largest };
            if residual <= self.tolerance {
                return true;
            }
            if !residual.is_finite() || (fresh && residual > GOOD_STEP * before) {
                return false;
            }
            fresh = residual > GOOD_FACTORS * before;
            if fresh {
                balance.differentiate(at.angular_frequency);
                factors.reset(unknowns.len()).copy_from_slice(balance.jacobian().as_slice());
                if !factors.factor() {
                    return false;
                }
            }
            before = residual;
            step.iter_mut().zip(balance.residual()).for_each(|(s, r)| *s = -r);
            factors.solve(&mut step);
            unknowns.iter_mut().zip(&step).for_each(|(x, s)| *x += s);
        }
        false
    }
}

impl Start {
    fn of(balance: &Balance, unknowns: &[f64], factors: Option<(Signals, Factors)>) -> Self {
        let contact = unknowns[..balance.displacement.len()].to_vec();
        let straight = balance.output(&balance.beam.contact_shape);
        let shortening = straight.iter().zip(&balance.displacement).map(|(c, u)| c - u).collect();
        let excitation = balance.output(&balance.beam.excitation_shape);
        let string = balance.output(&balance.beam.string_stretch);
        Self { contact, shortening, excitation, string, factors }
    }

    /// Whether it has the harmonics of `forcing`.
    pub fn fits(&self, forcing: &Forcing) -> bool {
        self.contact.len() == coefficient_count(forcing.contact_harmonics)
            && self.excitation.len() == coefficient_count(forcing.harmonics)
    }

    /// What a balance with `signals` calls its unknowns.
    fn unknowns(&self, signals: Signals) -> Vec<f64> {
        let mut unknowns = self.contact.clone();
        if signals.shortening {
            unknowns.extend_from_slice(&self.shortening);
        }
        if signals.excitation {
            unknowns.extend_from_slice(&self.excitation);
        }
        if signals.string {
            unknowns.extend_from_slice(&self.string);
        }
        unknowns
    }
}

impl<'a> Steady<'a> {
    fn new(balance: Balance<'a>, unknowns: Vec<f64>, forcing: &Forcing) -> Self {
        let (at, factors) = (forcing.operating(), Factors::default());
        Self { balance, unknowns, at, factors, current: false, sensors: Vec::new(), spare: None }
    }

    /// Coefficients of every sensor (m) that `driven`, the beam itself or one very near to it, has to first order about
    /// where this stands: one step of Newton's method, which is no search and finds no other response. The derivatives
    /// are those of the beam itself: between neighbours only the residual differs. Far from a solution that is not the
    /// whole change.
    pub fn first_order(&mut self, forcing: &Forcing, driven: Driven) -> Result<Vec<f64>, HarmonicError> {
        self.linearise()?;
        let mut there = forcing.balance(driven, self.balance.signals())?;
        self.lend(&mut there);
        there.balance_alone(&self.unknowns, &self.at)?;
        let mut moved: Vec<f64> = there.residual().iter().map(|r| -PROBE * r).collect();
        self.factors.solve(&mut moved);
        moved.iter_mut().zip(&self.unknowns).for_each(|(step, x)| *step += x);
        let mut found = sensed(&mut there, &self.at, forcing);
        there.balance_alone(&moved, &self.at)?;
        let probed = sensed(&mut there, &self.at, forcing);
        self.spare = Some(there.into_cycle());
        found.iter_mut().zip(probed).for_each(|(here, probed)| *here += (probed - *here) / PROBE);
        Ok(found)
    }

    /// Displacement coefficients (m) of every sensor, one after the other.
    pub fn sensors(&mut self, forcing: &Forcing) -> Vec<f64> {
        sensed(&mut self.balance, &self.at, forcing)
    }

    /// The solution as a start for others.
    pub fn start(mut self) -> Result<Start, HarmonicError> {
        self.linearise()?;
        let factors = (self.balance.signals(), self.factors);
        Ok(Start::of(&self.balance, &self.unknowns, Some(factors)))
    }

    /// Change of [`Steady::sensors`] to first order when the beam and its contact become `neighbour`, one of those
    /// the response was solved for and very near to it.
    pub fn change(&mut self, forcing: &Forcing, neighbour: Driven) -> Result<Vec<f64>, HarmonicError> {
        self.linearise()?;
        if self.sensors.is_empty() {
            self.sensors = self.sensors(forcing);
        }
        let mut other = forcing.balance(neighbour, self.balance.signals())?;
        self.lend(&mut other);
        other.balance_alone(&self.unknowns, &self.at)?;
        let residuals = other.residual().iter().zip(self.balance.residual());
        let mut moved: Vec<f64> = residuals.map(|(there, here)| here - there).collect();
        self.factors.solve(&mut moved);
        moved.iter_mut().zip(&self.unknowns).for_each(|(step, x)| *step += x);
        other.balance_alone(&moved, &self.at)?;
        let after = sensed(&mut other, &self.at, forcing);
        self.spare = Some(other.into_cycle());
        Ok(after.iter().zip(&self.sensors).map(|(after, before)| after - before).collect())
    }

    /// Gives a neighbour the workspace there is, without what it remembers.
    fn lend(&mut self, neighbour: &mut Balance) {
        if let Some(spare) = self.spare.take() {
            neighbour.work_with(spare);
        }
        neighbour.forget();
    }

    /// Makes derivatives and factors those at the solution.
    fn linearise(&mut self) -> Result<(), HarmonicError> {
        if self.current {
            return Ok(());
        }
        self.balance.evaluate(&self.unknowns, &self.at, &[])?;
        self.factors.reset(self.unknowns.len()).copy_from_slice(self.balance.jacobian().as_slice());
        self.current = self.factors.factor();
        if self.current {
            Ok(())
        } else {
            Err(HarmonicError::InvalidInput("the balance is singular at the solution"))
        }
    }
}

/// Displacement coefficients (m) of every sensor at the last evaluation.
fn sensed(balance: &mut Balance, at: &Operating, forcing: &Forcing) -> Vec<f64> {
    let beyond = balance.beyond(at, forcing.sensed_harmonics);
    balance.beam.sensors.iter().flat_map(|sensor| balance.output_with(&sensor.shape, &beyond)).collect()
}
