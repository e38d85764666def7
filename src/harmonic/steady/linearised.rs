//! Beams to first order about a motion that need not be a response of theirs: one step of Newton's method, which is no
//! search and finds no other response.

use super::{Assembly, Start, SteadyProblem, factored, sensed};
use crate::harmonic::HarmonicError;
use crate::harmonic::balance::modal::{Ports, Workspace};
use crate::harmonic::newton::system::{Operating, PeriodicSystem};
use crate::numeric::lu::Factors;

/// Fraction of a step over which the change along it is measured.
const PROBE: f64 = 1e-4;

/// A beam's equations as they stand at a motion.
#[derive(Debug)]
pub(crate) struct Linearised {
    unknowns: Vec<f64>,
    at: Operating,
    factors: Factors,
    ports: Ports,
    /// What the last beam worked in.
    left: Option<Workspace>,
}

impl Linearised {
    /// `assembly` as it stands at `start`, with unknowns that its `neighbours` have too; in the workspace that another
    /// has left.
    ///
    /// # Errors
    /// [`HarmonicError`] for a beam or contact that cannot be balanced, or whose equations are singular there.
    pub fn new(
        problem: &SteadyProblem,
        assembly: &Assembly,
        neighbours: &[Assembly],
        start: &Start,
        left: Option<Workspace>,
    ) -> Result<Self, HarmonicError> {
        let ports = Ports::of_all(assembly, neighbours);
        let (unknowns, at) = (start.unknowns(&ports), problem.operating());
        let mut balance = problem.balance(assembly, &ports, left)?;
        let mut factors = Factors::default();
        factored(&mut balance, &unknowns, &at, &mut factors)?;
        Ok(Self { unknowns, at, factors, ports, left: Some(balance.into_workspace()) })
    }

    /// Whether its unknowns are those that `assembly` and its `neighbours` have.
    pub fn covers(&self, assembly: &Assembly, neighbours: &[Assembly]) -> bool {
        self.ports == Ports::of_all(assembly, neighbours)
    }

    /// The workspace, for another.
    pub fn into_workspace(self) -> Option<Workspace> {
        self.left
    }

    /// Displacement coefficients (m) of every sensor that `assembly`, the beam itself or one very near to it, has to first
    /// order. The derivatives are those of the beam itself: between neighbours only the residual differs. Far from a
    /// solution that is not the whole change.
    pub fn first_order(
        &mut self,
        problem: &SteadyProblem,
        assembly: &Assembly,
    ) -> Result<Vec<f64>, HarmonicError> {
        let mut there = problem.balance(assembly, &self.ports, self.left.take())?;
        there.balance_alone(&self.unknowns, &self.at)?;
        let mut moved: Vec<f64> = there.residual().iter().map(|r| -PROBE * r).collect();
        self.factors.solve(&mut moved);
        moved.iter_mut().zip(&self.unknowns).for_each(|(step, x)| *step += x);
        let mut found = sensed(&mut there, &self.at, problem);
        there.balance_alone(&moved, &self.at)?;
        let probed = sensed(&mut there, &self.at, problem);
        self.left = Some(there.into_workspace());
        found.iter_mut().zip(probed).for_each(|(here, probed)| *here += (probed - *here) / PROBE);
        Ok(found)
    }
}
