//! Beams to first order about a motion, a response of theirs or not: one step of Newton's method, which is no search and
//! finds no other response.

use super::{Assembly, Start, Steady, SteadyProblem, factored, sensed};
use crate::harmonic::HarmonicError;
use crate::harmonic::balance::modal::{Ports, Workspace};
use crate::harmonic::newton::system::{Operating, PeriodicSystem};
use crate::numeric::lu::Factors;

/// Fraction of a step over which the change along it is measured: where it may be long, and at a solution.
const PROBE: f64 = 1e-4;
const WHOLE: f64 = 1.0;

/// A beam's equations as they stand at a motion.
#[derive(Debug)]
pub(crate) struct Linearised {
    unknowns: Vec<f64>,
    at: Operating,
    factors: Factors,
    ports: Ports,
    /// Fraction of a step over which the change along it is measured.
    probe: f64,
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
        let factors = factored(&mut balance, &unknowns, &at)?;
        Ok(Self { unknowns, at, factors, ports, probe: PROBE, left: Some(balance.into_workspace()) })
    }

    /// `assembly`, which it is of, about the same motion, as neighbours take it whose contact's displacement is known in front
    /// of its flexibility alone; `None` where it is that already.
    ///
    /// # Errors
    /// As [`Linearised::new`].
    fn moved_in_front(
        &mut self,
        problem: &SteadyProblem,
        assembly: &Assembly,
    ) -> Result<Option<Self>, HarmonicError> {
        if self.ports.in_front() {
            return Ok(None);
        }
        let mut behind = problem.balance(assembly, &self.ports, self.left.take())?;
        behind.balance_alone(&self.unknowns, &self.at)?;
        let [_, front] = behind.either_side(&self.unknowns, behind.force());
        self.left = Some(behind.into_workspace());
        let (mut unknowns, ports) = (self.unknowns.clone(), self.ports.clone().moved_in_front());
        unknowns[..front.len()].copy_from_slice(&front);
        let mut balance = problem.balance(assembly, &ports, None)?;
        let factors = factored(&mut balance, &unknowns, &self.at)?;
        let left = Some(balance.into_workspace());
        Ok(Some(Self { unknowns, at: self.at, factors, ports, probe: self.probe, left }))
    }

    /// To first order, the displacement coefficients (m) of every sensor of `neighbours` less those of `assembly`, which it is
    /// of.
    ///
    /// # Errors
    /// As [`Linearised::new`].
    pub fn changes(
        &mut self,
        problem: &SteadyProblem,
        assembly: &Assembly,
        neighbours: &[Assembly],
    ) -> Result<Vec<Vec<f64>>, HarmonicError> {
        let in_front = |neighbour: &Assembly| Ports::of(&neighbour.system).in_front();
        let front =
            if neighbours.iter().any(in_front) { self.moved_in_front(problem, assembly)? } else { None };
        let here = self.first_order(problem, assembly)?;
        let mut front = match front {
            Some(mut front) => Some((front.first_order(problem, assembly)?, front)),
            None => None,
        };
        let mut changes = Vec::with_capacity(neighbours.len());
        for neighbour in neighbours {
            let (here, about) = match &mut front {
                Some((here, front)) if in_front(neighbour) => (&*here, front),
                _ => (&here, &mut *self),
            };
            let mut change = about.first_order(problem, neighbour)?;
            change.iter_mut().zip(here).for_each(|(there, here)| *there -= here);
            changes.push(change);
        }
        Ok(changes)
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
        let probe = self.probe;
        let mut moved: Vec<f64> = there.residual().iter().map(|r| -probe * r).collect();
        self.factors.solve(&mut moved);
        moved.iter_mut().zip(&self.unknowns).for_each(|(step, x)| *step += x);
        let mut found = if probe < WHOLE { sensed(&mut there, &self.at, problem) } else { Vec::new() };
        there.balance_alone(&moved, &self.at)?;
        let probed = sensed(&mut there, &self.at, problem);
        self.left = Some(there.into_workspace());
        if found.is_empty() {
            return Ok(probed);
        }
        found.iter_mut().zip(probed).for_each(|(here, probed)| *here += (probed - *here) / probe);
        Ok(found)
    }
}

impl Steady {
    /// The equations as they stand there, and the solution as a start for others.
    ///
    /// # Errors
    /// [`HarmonicError`] where the equations are singular.
    pub fn linearised(self) -> Result<(Linearised, Start), HarmonicError> {
        let Self { mut balance, unknowns, at } = self;
        let factors = factored(&mut balance, &unknowns, &at)?;
        let ports = balance.ports().clone();
        let start =
            Start::of(&balance, &unknowns, balance.force(), Some(Box::new((ports.clone(), factors.clone()))));
        let left = Some(balance.into_workspace());
        Ok((Linearised { unknowns, at, factors, ports, probe: WHOLE, left }, start))
    }
}
