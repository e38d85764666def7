//! Solutions of the beam's balance from a start, from equivalent linearisation, or followed from small
//! amplitudes.

use crate::harmonic::balance::modal::Balance;
use crate::harmonic::newton::problem::{Effort, Newton, Stopping};
use crate::harmonic::newton::system::{Operating, PeriodicSystem};
use crate::harmonic::{HarmonicError, Settings};

/// Unknowns, scalars, and how they were found.
#[derive(Debug, Clone)]
pub(crate) struct State {
    pub x: Vec<f64>,
    pub at: Operating,
}

/// A family of periodic responses with an amount (a level, a held amplitude) that can be made small.
pub(crate) trait Family {
    /// Solves at `amount` from what `state` holds.
    fn solve(
        &mut self,
        balance: &mut Balance,
        newton: &mut Newton,
        amount: f64,
        state: &mut State,
        stopping: &Stopping,
    ) -> Result<Effort, HarmonicError>;

    /// A start at `amount`.
    fn guess(&mut self, balance: &mut Balance, amount: f64) -> Result<State, HarmonicError>;
}

/// Smallest fraction of `amount` from which it is followed, and the smallest step (factor).
const WEAK: f64 = 1e-3;
const SMALLEST_STEP: f64 = 1.001;

/// Solves at `amount` from `start` if it is given and close enough, else from the family's guess, else by
/// following from a small amount.
pub(crate) fn find(
    family: &mut dyn Family,
    balance: &mut Balance,
    amount: f64,
    start: Option<State>,
    settings: &Settings,
) -> Result<(State, Effort), HarmonicError> {
    let stopping = Stopping {
        tolerance: settings.tolerance,
        max_iterations: settings.max_iterations,
        reach: f64::INFINITY,
    };
    let mut newton = Newton::default();
    let mut attempt = |family: &mut dyn Family, balance: &mut Balance, amount: f64, state: &mut State| {
        balance.forget();
        family.solve(balance, &mut newton, amount, state, &stopping)
    };
    if let Some(mut state) = start
        && let Ok(effort) = attempt(family, balance, amount, &mut state)
    {
        return Ok((state, effort));
    }
    balance.forget();
    let mut state = family.guess(balance, amount)?;
    if let Ok(effort) = attempt(family, balance, amount, &mut state) {
        return Ok((state, effort));
    }
    let mut reached = WEAK * amount;
    balance.forget();
    state = family.guess(balance, reached)?;
    let mut effort = attempt(family, balance, reached, &mut state)?;
    let mut step: f64 = 1.5;
    while reached < amount {
        let next = (reached * step).min(amount);
        let mut trial = state.clone();
        trial.x.iter_mut().for_each(|x| *x *= next / reached);
        trial.at.level *= next / reached;
        match attempt(family, balance, next, &mut trial) {
            Ok(done) => {
                (state, reached, effort) = (trial, next, done);
                step = step.powf(1.5).min(2.0);
            }
            Err(error) if step < SMALLEST_STEP => return Err(error),
            Err(_) => step = step.sqrt(),
        }
    }
    Ok((state, effort))
}
