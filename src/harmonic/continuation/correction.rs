//! The point predicted, brought onto the curve.

use super::*;
use crate::harmonic::newton::problem::Stopping;

impl Path<'_> {
    /// Solves `next` with the scalar continued held.
    pub(super) fn solve_fixed(&mut self) -> Result<(), HarmonicError> {
        let Location { x, at, iterations, .. } = &mut self.next;
        let mut all: Vec<&mut dyn Condition> = Vec::new();
        all.extend(self.conditions.iter_mut().map(|condition| &mut **condition as &mut dyn Condition));
        let effort =
            self.newton.solve(self.system, x, at, &self.free[1..], &mut all, &self.route.stopping)?;
        *iterations = effort.iterations;
        Ok(())
    }

    /// Solves `next` on the plane set in `arc`.
    pub(super) fn solve_on_plane(&mut self, stopping: &Stopping) -> Result<(), HarmonicError> {
        let Location { x, at, iterations, .. } = &mut self.next;
        let mut all: Vec<&mut dyn Condition> = Vec::new();
        all.extend(self.conditions.iter_mut().map(|condition| &mut **condition as &mut dyn Condition));
        all.push(&mut self.arc);
        // The scalar continued comes first among the free ones, its condition last: order does not matter.
        let effort = self.newton.solve(self.system, x, at, &self.free, &mut all, stopping)?;
        *iterations = effort.iterations;
        Ok(())
    }

    /// Direction of the curve at `next`, along which `arc` grows by 1. With `fresh` the derivatives are
    /// evaluated there; else those of the last Newton step do.
    pub(super) fn find_direction(&mut self, fresh: bool) -> Result<(), HarmonicError> {
        if fresh {
            self.arc.target = self.arc.at(&self.next.x, &self.next.at);
            let Location { x, at, .. } = &mut self.next;
            let mut all: Vec<&mut dyn Condition> = Vec::new();
            all.extend(self.conditions.iter_mut().map(|condition| &mut **condition as &mut dyn Condition));
            all.push(&mut self.arc);
            // Nothing to be solved: an infinite tolerance leaves the evaluation.
            let stopping = Stopping { tolerance: f64::INFINITY, max_iterations: 0, ..self.route.stopping };
            self.newton.solve(self.system, x, at, &self.free, &mut all, &stopping)?;
        }
        let n = self.next.x.len();
        self.right.clear();
        self.right.resize(n + self.free.len(), 0.0);
        if let Some(last) = self.right.last_mut() {
            *last = 1.0;
        }
        if !self.newton.prepare(self.system, &self.free) || !self.newton.solve_linear(&mut self.right) {
            return Err(HarmonicError::NotConverged { residual: f64::INFINITY, iterations: 0 });
        }
        self.next.unknowns.clear();
        self.next.unknowns.extend_from_slice(&self.right[..n]);
        self.next.scalars = [0.0; 4];
        for (scalar, value) in self.free.iter().zip(&self.right[n..]) {
            self.next.scalars[scalar.index()] = *value;
        }
        Ok(())
    }

    /// The end of the range that `next` has passed.
    pub(super) fn edge_ahead(&self) -> Option<Ending> {
        let Route { along, from, to, .. } = self.route;
        let fraction = (self.next.at.get(along) - from) / (to - from);
        let forward = self.present.scalars[along.index()] * (to - from) > 0.0;
        if fraction.is_nan() || (fraction >= 1.0 && forward) {
            Some(Ending::Complete)
        } else if fraction <= 0.0 && !forward {
            Some(Ending::Returned)
        } else {
            None
        }
    }

    pub(super) fn correct(&mut self) -> Result<Option<Ending>, HarmonicError> {
        let predicted = (std::mem::take(&mut self.right), self.next.at);
        let mut predicted_x = predicted.0;
        predicted_x.clear();
        predicted_x.extend_from_slice(&self.next.x);
        let stopping = Stopping {
            max_iterations: self.route.stopping.max_iterations.min(MOST_ITERATIONS),
            ..self.route.stopping
        };
        let solved = self.solve_on_plane(&stopping);
        let correction = self.unit.distance(&self.next, &predicted_x, &predicted.1);
        self.right = predicted_x;
        solved?;
        // Beyond a corner the curve may run almost within the plane, a long way from the prediction.
        let corner = if self.step < CORNER_STEP { CORNER_STEP } else { 0.0 };
        if correction > corner.max(LARGEST_CORRECTION * self.step) {
            return Err(HarmonicError::NotConverged {
                residual: correction,
                iterations: self.next.iterations,
            });
        }
        if let Some(edge) = self.edge_ahead() {
            return self.land(edge);
        }
        self.find_direction(false)?;
        Ok(None)
    }

    /// Solves at the end of the range, which `next` has passed.
    pub(super) fn land(&mut self, edge: Ending) -> Result<Option<Ending>, HarmonicError> {
        let along = self.route.along;
        let end = if edge == Ending::Complete { self.route.to } else { self.route.from };
        let (here, there) = (self.present.at.get(along), self.next.at.get(along));
        let fraction = if there == here { 1.0 } else { ((end - here) / (there - here)).clamp(0.0, 1.0) };
        let here = &self.present;
        self.next.x.iter_mut().zip(&here.x).for_each(|(n, x)| *n = x + fraction * (*n - x));
        for scalar in &self.free {
            let start = here.at.get(*scalar);
            self.next.at.set(*scalar, start + fraction * (self.next.at.get(*scalar) - start));
        }
        self.next.at.set(along, end);
        let (guess, guess_at) = (self.next.x.clone(), self.next.at);
        self.solve_fixed()?;
        if self.unit.distance(&self.next, &guess, &guess_at) > self.step {
            return Err(HarmonicError::NotConverged { residual: 1.0, iterations: self.next.iterations });
        }
        let iterations = self.next.iterations;
        self.find_direction(true)?;
        self.next.iterations = iterations;
        Ok(Some(edge))
    }
}
