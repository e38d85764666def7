//! Following a branch of solutions by its arc length, around turning points.
//!
//! The length is measured in unknowns over their present size and scalars over their range, so that steps are
//! relative. The next point is predicted from the last two tangents and corrected at a right angle to the
//! present one; the step follows the number of corrections and the angle between tangents. A point is refused
//! where the tangent turns too far or the correction is long compared with the step: a neighbouring branch
//! is not taken for the present one.
//!
//! Contacts give the curve corners, where stick or a minor loop begins or ends. The determinant of the equations
//! with the tangent below them keeps its sign along a piecewise smooth curve (Eaves 1976, Allgower &
//! Georg 2003): it tells which way the curve leaves a corner, even by more than a right angle.

use super::HarmonicError;
use super::bracket::Bracket;
use super::condition::ArcLength;
use super::curve::Ending;
use super::problem::{Condition, Newton, Stopping};
use super::system::{Operating, PeriodicSystem, Scalar};
use super::unit::Unit;
use crate::structure::StructureError;

/// Steps below this are given up (the range has length 1).
const SMALLEST_STEP: f64 = 1e-8;
/// Steps this small may turn by up to a right angle: a corner of the curve.
const CORNER_STEP: f64 = 1e-4;
/// Steps this small are taken however much what is watched turns.
const SHARPEST_BEND: f64 = 1e-6;
/// How far beyond a corner the equations are looked at, and the first step from there.
const BEYOND_CORNER: f64 = 1e-6;
const STEP_FROM_CORNER: f64 = 1e-5;
const LARGEST_STEP: f64 = 0.3;
const FIRST_STEP: f64 = 5e-3;
/// Angles between successive tangents: aimed at, and the largest accepted (rad).
const AIMED_ANGLE: f64 = 0.17;
const LARGEST_ANGLE: f64 = 0.6;
const MOST_ITERATIONS: usize = 8;
const AIMED_ITERATIONS: f64 = 2.0;
/// Correction over step beyond which a point is another branch's.
const LARGEST_CORRECTION: f64 = 0.5;

/// A solution and the direction of the curve there, per unit of arc length.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Location {
    /// The unknowns.
    pub x: Vec<f64>,
    /// The scalars.
    pub at: Operating,
    /// Direction: unknowns.
    pub unknowns: Vec<f64>,
    /// Direction: scalars, in the order of [`Scalar`].
    pub scalars: [f64; 4],
    /// Newton steps it took.
    pub iterations: usize,
}

/// What is followed, and how.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Route {
    /// The scalar continued.
    pub along: Scalar,
    /// Where it starts.
    pub from: f64,
    /// Where it is to arrive.
    pub to: f64,
    /// When a point is good enough.
    pub stopping: Stopping,
    /// Longest step, as share of the range.
    pub max_step: f64,
}

/// Judgement of a point that Newton's method found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Verdict {
    /// Good. What the caller watches turned by this share of what is tolerable, in second order of the step:
    /// above 1 the step was too long, unless it is as short as steps at corners.
    Keep(f64),
    /// To be solved again with so many harmonics.
    Harmonics(usize),
}

/// Judges a point that the system and the solver have just left; the last argument is what is free, the scalar
/// continued first.
pub(crate) type Judge<'j> = dyn FnMut(&mut dyn PeriodicSystem, &mut Newton, &Location, &[Scalar]) -> Result<Verdict, HarmonicError>
    + 'j;

/// Outcome of one step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Advance {
    /// A point was found.
    Going,
    /// A point was found, the last one.
    Arrived(Ending),
    /// No point was found.
    Stuck,
}

/// A branch being followed.
pub(crate) struct Path<'s> {
    /// The equations.
    pub system: &'s mut dyn PeriodicSystem,
    /// Conditions beside the balance, one for every free scalar after the first.
    conditions: Vec<Box<dyn Condition + 's>>,
    /// The scalar continued, then the other free ones.
    free: Vec<Scalar>,
    route: Route,
    newton: Newton,
    arc: ArcLength,
    unit: Unit,
    step: f64,
    last_step: f64,
    /// Sign of the determinant at the present point.
    orientation: f64,
    /// Set between crossing a corner and leaving it.
    at_corner: bool,
    /// The point before the present one.
    pub previous: Location,
    /// The present point.
    pub present: Location,
    next: Location,
    right: Vec<f64>,
}

impl<'s> Path<'s> {
    /// Solves at the start of the route, from `x` and `at`, and finds the direction there. `others` are free
    /// besides the scalar continued, under as many `conditions`.
    pub fn new(
        system: &'s mut dyn PeriodicSystem,
        route: Route,
        others: &[Scalar],
        conditions: Vec<Box<dyn Condition + 's>>,
        x: Vec<f64>,
        at: Operating,
    ) -> Result<Self, HarmonicError> {
        let mut free = vec![route.along];
        free.extend_from_slice(others);
        let location = Location { unknowns: vec![0.0; x.len()], x, at, scalars: [0.0; 4], iterations: 0 };
        let mut path = Self {
            system,
            conditions,
            free,
            route,
            newton: Newton::default(),
            arc: ArcLength::default(),
            unit: Unit { unknowns: 1.0, scalars: [1.0; 4], largest: 0.0 },
            step: FIRST_STEP,
            last_step: 0.0,
            orientation: 0.0,
            at_corner: false,
            previous: location.clone(),
            next: location.clone(),
            present: location,
            right: Vec::new(),
        };
        path.start()?;
        Ok(path)
    }

    /// Starts again with other harmonics.
    pub fn restart(&mut self, harmonics: usize) -> Result<(), HarmonicError> {
        self.next.clone_from(&self.present);
        self.system.set_harmonics(harmonics, &mut [&mut self.next.x])?;
        self.start()
    }

    fn start(&mut self) -> Result<(), HarmonicError> {
        self.system.forget();
        self.next.at.set(self.route.along, self.route.from);
        self.solve_fixed()?;
        let range = self.route.to - self.route.from;
        self.arc.unknowns.clear();
        self.arc.unknowns.resize(self.next.x.len(), 0.0);
        self.arc.scalars = [0.0; 4];
        self.arc.scalars[self.route.along.index()] = if range == 0.0 { 1.0 } else { 1.0 / range };
        self.find_direction(true)?;
        self.orientation = self.newton.orientation();
        std::mem::swap(&mut self.present, &mut self.next);
        self.measure();
        let unit = self.unit;
        unit.normalise(&mut self.present);
        self.previous.clone_from(&self.present);
        Ok(())
    }

    /// Solves `next` with the scalar continued held.
    fn solve_fixed(&mut self) -> Result<(), HarmonicError> {
        let Location { x, at, iterations, .. } = &mut self.next;
        let mut all: Vec<&mut dyn Condition> = Vec::new();
        all.extend(self.conditions.iter_mut().map(|condition| &mut **condition as &mut dyn Condition));
        let effort =
            self.newton.solve(self.system, x, at, &self.free[1..], &mut all, &self.route.stopping)?;
        *iterations = effort.iterations;
        Ok(())
    }

    /// Solves `next` on the plane set in `arc`.
    fn solve_on_plane(&mut self, stopping: &Stopping) -> Result<(), HarmonicError> {
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
    fn find_direction(&mut self, fresh: bool) -> Result<(), HarmonicError> {
        if fresh {
            self.arc.target = self.arc.at(&self.next.x, &self.next.at);
            let Location { x, at, .. } = &mut self.next;
            let mut all: Vec<&mut dyn Condition> = Vec::new();
            all.extend(self.conditions.iter_mut().map(|condition| &mut **condition as &mut dyn Condition));
            all.push(&mut self.arc);
            // Nothing to be solved: an infinite tolerance leaves the evaluation.
            let stopping = Stopping { tolerance: f64::INFINITY, max_iterations: 0 };
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

    /// Sizes of the unknowns and scalars at the present point.
    fn measure(&mut self) {
        let size = length(&self.present.x);
        let along = self.route.along.index();
        let range = (self.route.to - self.route.from).abs();
        // A response that vanishes at the start has the size it takes on within the range.
        let rate = self.present.scalars[along].abs();
        let foreseen = if rate > 0.0 { length(&self.present.unknowns) / rate * range } else { 0.0 };
        self.unit.largest = self.unit.largest.max(size);
        let size =
            if self.unit.largest == 0.0 { 0.01 * foreseen } else { size.max(1e-3 * self.unit.largest) };
        self.unit.unknowns = if size > 0.0 { 1.0 / size } else { 1.0 };
        for scalar in &self.free {
            let value = self.present.at.get(*scalar).abs();
            let size = if *scalar == self.route.along { range } else { value };
            self.unit.scalars[scalar.index()] = if size > 0.0 { 1.0 / size } else { 1.0 };
        }
    }

    /// One step: `present` moves on, `previous` is where it was.
    pub fn advance(&mut self, judge: &mut Judge) -> Result<Advance, HarmonicError> {
        self.measure();
        let unit = self.unit;
        unit.normalise(&mut self.present);
        unit.normalise(&mut self.previous);
        let along = self.route.along.index();
        let rate = (self.present.scalars[along] * self.unit.scalars[along]).abs();
        self.step = self.step.min(LARGEST_STEP).min(self.route.max_step / rate.max(1e-12));
        loop {
            if self.step < SMALLEST_STEP && (self.at_corner || !self.cross_corner()) {
                return Ok(Advance::Stuck);
            }
            self.set_plane();
            self.predict(self.step, self.last_step > 0.0);
            let outcome = match self.edge_ahead() {
                None => self.correct(),
                Some(edge) => self.land(edge),
            };
            match outcome.and_then(|arrived| self.settle(arrived, judge)) {
                Ok(Some(advance)) => return Ok(advance),
                // A failure of the model is not one of the step; a frequency at which there is no compliance is
                // stepped over.
                Err(HarmonicError::Structure(StructureError::UndampedResonance { .. })) => {
                    self.step *= 0.5;
                    self.system.forget();
                }
                Err(error @ (HarmonicError::InvalidInput(_) | HarmonicError::Structure(_))) => {
                    return Err(error);
                }
                Ok(None) | Err(_) => {
                    self.step *= 0.5;
                    self.system.forget();
                }
            }
        }
    }

    /// Turns the direction at the present point, which lies at a corner, into that of the curve beyond. False
    /// where the equations beyond say nothing.
    fn cross_corner(&mut self) -> bool {
        self.set_plane();
        self.predict(BEYOND_CORNER, false);
        self.system.forget();
        if self.find_direction(true).is_err() {
            return false;
        }
        let orientation = self.newton.orientation();
        let unit = self.unit;
        unit.normalise(&mut self.next);
        let sign = orientation * self.orientation;
        self.present.unknowns.clear();
        self.present.unknowns.extend(self.next.unknowns.iter().map(|d| sign * d));
        self.present.scalars = self.next.scalars.map(|d| sign * d);
        (self.last_step, self.step, self.at_corner) = (0.0, STEP_FROM_CORNER, true);
        true
    }

    /// The plane through the present point at a right angle to the curve.
    fn set_plane(&mut self) {
        let unit = self.unit;
        self.arc.unknowns.clear();
        self.arc.unknowns.extend(self.present.unknowns.iter().map(|d| d * unit.unknowns * unit.unknowns));
        self.arc.scalars =
            std::array::from_fn(|k| self.present.scalars[k] * unit.scalars[k] * unit.scalars[k]);
    }

    /// Puts `next` ahead by `step`: along the tangent; where the curve is `bent`, on the cubic through the last
    /// two points and tangents.
    fn predict(&mut self, step: f64, bent: bool) {
        let (here, before) = (&self.present, &self.previous);
        // With s the step over the last one: x + s h d + s² (…) + s³ (…), Hermite's cubic beyond its end.
        // The chord measured in the present unit, and the arc above it.
        let chord = self.unit.distance(here, &before.x, &before.at);
        let turned = 1.0 - self.unit.product(here, before).clamp(-1.0, 1.0);
        let last = chord * (1.0 + turned / 12.0);
        let s = if bent { step / last } else { 0.0 };
        let (square, cube) = (s * s * (2.0 * s + 3.0), s * s * (s + 1.0));
        let ahead = |x: f64, d: f64, y: f64, b: f64| {
            if bent {
                x + step * d + square * (y - x) + last * (cube * b + (cube + s * s) * d)
            } else {
                x + step * d
            }
        };
        self.next.x.clear();
        let ends = here.x.iter().zip(&here.unknowns).zip(before.x.iter().zip(&before.unknowns));
        self.next.x.extend(ends.map(|((x, d), (y, b))| ahead(*x, *d, *y, *b)));
        self.next.at = here.at;
        for scalar in &self.free {
            let k = scalar.index();
            let (x, y) = (here.at.get(*scalar), before.at.get(*scalar));
            self.next.at.set(*scalar, ahead(x, here.scalars[k], y, before.scalars[k]));
        }
        self.arc.target = self.arc.at(&here.x, &here.at) + step;
    }

    /// The end of the range that `next` has passed.
    fn edge_ahead(&self) -> Option<Ending> {
        let Route { along, from, to, .. } = self.route;
        let share = (self.next.at.get(along) - from) / (to - from);
        let forward = self.present.scalars[along.index()] * (to - from) > 0.0;
        if share.is_nan() || (share >= 1.0 && forward) {
            Some(Ending::Complete)
        } else if share <= 0.0 && !forward {
            Some(Ending::Returned)
        } else {
            None
        }
    }

    fn correct(&mut self) -> Result<Option<Ending>, HarmonicError> {
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
    fn land(&mut self, edge: Ending) -> Result<Option<Ending>, HarmonicError> {
        let along = self.route.along;
        let end = if edge == Ending::Complete { self.route.to } else { self.route.from };
        let (here, there) = (self.present.at.get(along), self.next.at.get(along));
        let share = if there == here { 1.0 } else { ((end - here) / (there - here)).clamp(0.0, 1.0) };
        let here = &self.present;
        self.next.x.iter_mut().zip(&here.x).for_each(|(n, x)| *n = x + share * (*n - x));
        for scalar in &self.free {
            let start = here.at.get(*scalar);
            self.next.at.set(*scalar, start + share * (self.next.at.get(*scalar) - start));
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

    /// Judges `next` and takes it, or says that the step was too long.
    fn settle(
        &mut self,
        arrived: Option<Ending>,
        judge: &mut Judge,
    ) -> Result<Option<Advance>, HarmonicError> {
        let unit = self.unit;
        unit.normalise(&mut self.next);
        let cosine = unit.product(&self.present, &self.next).clamp(-1.0, 1.0);
        let angle = cosine.acos();
        let orientation = self.newton.orientation();
        let corner = self.step < CORNER_STEP && cosine > 0.0 && orientation == self.orientation;
        if angle.is_nan() || (angle > LARGEST_ANGLE && !corner) {
            return Ok(None);
        }
        let bend = loop {
            match judge(self.system, &mut self.newton, &self.next, &self.free)? {
                Verdict::Keep(bend) if bend > 1.0 && self.step > SHARPEST_BEND => return Ok(None),
                Verdict::Keep(bend) => break bend.min(1.0),
                Verdict::Harmonics(harmonics) => self.change_harmonics(harmonics, arrived.is_some())?,
            }
        };
        // The way covered, which the predictor needs; the end of the range cuts it short.
        self.last_step = unit.distance(&self.next, &self.present.x, &self.present.at);
        self.at_corner &= self.last_step < BEYOND_CORNER;
        // Of the determinant in the end: with other harmonics it may have another sign.
        self.orientation = self.newton.orientation();
        std::mem::swap(&mut self.previous, &mut self.present);
        std::mem::swap(&mut self.present, &mut self.next);
        self.next.clone_from(&self.present);
        let by_iterations = AIMED_ITERATIONS / (self.present.iterations.max(1) as f64);
        let factor = by_iterations.sqrt().min(AIMED_ANGLE / angle.max(1e-9)).min(0.8 / bend.max(1e-9).sqrt());
        self.step *= factor.clamp(0.3, 2.0);
        Ok(Some(arrived.map_or(Advance::Going, Advance::Arrived)))
    }

    /// Solves `next` again with other harmonics.
    fn change_harmonics(&mut self, harmonics: usize, held: bool) -> Result<(), HarmonicError> {
        let (present, previous) = (&mut self.present, &mut self.previous);
        let mut vectors = [
            &mut present.x,
            &mut present.unknowns,
            &mut previous.x,
            &mut previous.unknowns,
            &mut self.next.x,
            &mut self.next.unknowns,
            &mut self.arc.unknowns,
        ];
        self.system.set_harmonics(harmonics, &mut vectors)?;
        if held {
            self.solve_fixed()?;
        } else {
            let stopping = self.route.stopping;
            self.arc.target = self.arc.at(&self.next.x, &self.next.at);
            self.solve_on_plane(&stopping)?;
        }
        let iterations = self.next.iterations;
        self.find_direction(true)?;
        self.next.iterations = iterations;
        let unit = self.unit;
        unit.normalise(&mut self.next);
        Ok(())
    }

    /// Finds the point between the previous and the present one where `test`, a function of the location,
    /// passes through zero (its values there are `low` and `high`, of opposite sign); the present point and
    /// the step are left alone. `None` where the solution is lost on the way.
    pub fn locate(
        &mut self,
        (low, high): (f64, f64),
        test: &mut dyn FnMut(&mut dyn PeriodicSystem, &Location) -> f64,
    ) -> Option<Location> {
        const ROUNDS: usize = 60;
        /// Share of the way at which the place is known well enough: what is largest there is known to the square.
        const SHARPEST: f64 = 1e-11;
        const NEAR_END: f64 = 1e-6;
        let stopping =
            Stopping { tolerance: self.route.stopping.tolerance.min(1e-12), ..self.route.stopping };
        std::mem::swap(&mut self.previous, &mut self.present);
        let kept = (self.step, self.last_step);
        self.unit.normalise(&mut self.present);
        self.unit.normalise(&mut self.previous);
        self.set_plane();
        let base = self.arc.at(&self.present.x, &self.present.at);
        let reach = self.arc.at(&self.previous.x, &self.previous.at) - base;
        let mut bracket = Bracket::new((0.0, low), (reach, high));
        let mut found = None;
        for _ in 0..ROUNDS {
            let place = bracket.next();
            if found.is_some() && (place - bracket.latest.0).abs() <= SHARPEST * reach.abs() {
                break;
            }
            let Some(value) = self.test_at(base, place, reach, &stopping, test) else { break };
            found = Some(self.next.clone());
            if value == 0.0 {
                break;
            }
            bracket.take((place, value));
        }
        // The directions along a curve are those of the last Newton step: close to an extremum the sign at an end
        // may have been wrong, and that end is what was found.
        for (end, expected) in [(0.0, low), (reach, high)] {
            if (bracket.latest.0 - end).abs() <= NEAR_END * reach.abs() && bracket.latest.1 * expected < 0.0 {
                let exact = self.test_at(base, end, reach, &stopping, test);
                found = found.filter(|_| exact.is_some_and(|exact| exact * expected >= 0.0));
            }
        }
        std::mem::swap(&mut self.previous, &mut self.present);
        self.next.clone_from(&self.present);
        (self.step, self.last_step) = kept;
        found
    }

    /// `test` at `place` on the way of length `reach` from `base`, where `next` is left; `None` where there is no
    /// solution.
    fn test_at(
        &mut self,
        base: f64,
        place: f64,
        reach: f64,
        stopping: &Stopping,
        test: &mut dyn FnMut(&mut dyn PeriodicSystem, &Location) -> f64,
    ) -> Option<f64> {
        self.set_plane();
        self.interpolate(place / reach, reach);
        self.arc.target = base + place;
        self.solve_loosely(stopping).ok()?;
        if !self.newton.refactor(self.system, &self.free) {
            return None;
        }
        self.find_direction(false).ok()?;
        let unit = self.unit;
        unit.normalise(&mut self.next);
        Some(test(self.system, &self.next)).filter(|value| value.is_finite())
    }

    /// The plane's solution, or the best there is at the accuracy of rounding.
    fn solve_loosely(&mut self, stopping: &Stopping) -> Result<(), HarmonicError> {
        let guess = (self.next.x.clone(), self.next.at);
        if self.solve_on_plane(stopping).is_ok() {
            return Ok(());
        }
        (self.next.x, self.next.at) = guess;
        let stopping = self.route.stopping;
        self.solve_on_plane(&stopping)
    }

    /// Puts `next` between the present and the previous point (swapped: the present one comes first) on
    /// Hermite's cubic.
    fn interpolate(&mut self, share: f64, reach: f64) {
        let (s2, s3) = (share * share, share * share * share);
        let (h0, h1) = (2.0 * s3 - 3.0 * s2 + 1.0, 3.0 * s2 - 2.0 * s3);
        let (g0, g1) = (reach * (s3 - 2.0 * s2 + share), reach * (s3 - s2));
        let (a, b) = (&self.present, &self.previous);
        self.next.x.clear();
        let ends = a.x.iter().zip(&a.unknowns).zip(b.x.iter().zip(&b.unknowns));
        self.next.x.extend(ends.map(|((xa, da), (xb, db))| h0 * xa + g0 * da + h1 * xb + g1 * db));
        self.next.at = a.at;
        for scalar in &self.free {
            let k = scalar.index();
            let ends = h0 * a.at.get(*scalar) + h1 * b.at.get(*scalar);
            self.next.at.set(*scalar, ends + g0 * a.scalars[k] + g1 * b.scalars[k]);
        }
    }

    /// Has the first point judged.
    pub fn judge(&mut self, judge: &mut Judge) -> Result<Verdict, HarmonicError> {
        judge(self.system, &mut self.newton, &self.present, &self.free)
    }

    /// The scalar continued.
    pub fn along(&self) -> Scalar {
        self.route.along
    }
}

fn length(v: &[f64]) -> f64 {
    v.iter().map(|x| x * x).sum::<f64>().sqrt()
}
