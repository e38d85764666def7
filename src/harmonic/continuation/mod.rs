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

mod correction;
mod locate;
mod location;
mod prediction;
mod route;
mod unit;

pub(crate) use locate::NotFound;
pub use location::Ending;
pub(crate) use location::{LinearResonance, Location};
pub(crate) use route::{Advance, Judge, Route, See, Verdict};

use super::HarmonicError;
use crate::harmonic::newton::condition::ArcLength;
use crate::harmonic::newton::problem::{Condition, Newton, length};
use crate::harmonic::newton::system::{Operating, PeriodicSystem, Scalar};
use crate::system::StructureError;
use unit::Unit;

/// Steps below this are given up (the range has length 1).
const SMALLEST_STEP: f64 = 1e-8;
/// Steps this small may turn by up to a right angle: a corner of the curve.
const CORNER_STEP: f64 = 1e-4;
/// Steps this small are taken however much what is watched turns; smaller ones at resonances sharper than that,
/// this fraction of half their bandwidth, down to a least.
const SHARPEST_BEND: f64 = 1e-6;
const BEND_OF_RESONANCE: f64 = 0.02;
const LEAST_BEND: f64 = 3e-8;
/// A resonance this near counts as reached: in half bandwidths, and as a fraction of the range.
const REACHED: f64 = 0.3;
const REACHED_IN_RANGE: f64 = 1e-9;
/// What is free besides counts in units so many times its largest value: the force that holds a response falls and
/// rises again within a bandwidth, which would be a cusp if it counted in full. The unknowns tell where the curve is.
const FREE_SIZE: f64 = 10.0;
/// Steps this small may carry the level of a held response through zero, which it has at undamped resonances alone.
const ZERO_LEVEL_STEP: f64 = 3e-8;
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
    /// Largest magnitude of each scalar so far.
    largest: [f64; 4],
    linear_resonances: Vec<LinearResonance>,
    /// Steps this small are taken however much what is watched turns.
    sharpest: f64,
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
            largest: [0.0; 4],
            linear_resonances: Vec::new(),
            sharpest: SHARPEST_BEND,
            previous: location.clone(),
            next: location.clone(),
            present: location,
            right: Vec::new(),
        };
        path.start()?;
        Ok(path)
    }

    /// Has a path along the frequency pause at `linear_resonances`, so that none is passed unseen.
    pub fn pause_at(&mut self, linear_resonances: &[LinearResonance]) {
        let Route { along, from, to, .. } = self.route;
        if along != Scalar::AngularFrequency {
            return;
        }
        let within = |one: &&LinearResonance| {
            (one.angular_frequency - from) * (one.angular_frequency - to) < 0.0 && one.half_width > 0.0
        };
        self.linear_resonances = linear_resonances.iter().filter(within).copied().collect();
        let narrowest =
            self.linear_resonances.iter().fold(f64::INFINITY, |least, one| least.min(one.half_width));
        let resolved = BEND_OF_RESONANCE * narrowest / (to - from).abs();
        self.sharpest = SHARPEST_BEND.min(resolved.max(LEAST_BEND));
    }

    /// The step to the next resonance.
    fn step_to_resonance(&self) -> f64 {
        let along = self.route.along.index();
        let (rate, here) = (self.present.scalars[along], self.present.at.get(self.route.along));
        let range = (self.route.to - self.route.from).abs();
        let ahead = self.linear_resonances.iter().filter_map(|one| {
            let distance = (one.angular_frequency - here) * rate.signum();
            (distance > REACHED * one.half_width + REACHED_IN_RANGE * range).then_some(distance)
        });
        ahead.fold(f64::INFINITY, f64::min) / rate.abs()
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
            let largest = &mut self.largest[scalar.index()];
            *largest = largest.max(value);
            let size = if *scalar == self.route.along { range } else { FREE_SIZE * *largest };
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
        let wished = self.step;
        self.step = self.step.min(self.step_to_resonance());
        let mut shortened = self.step < wished;
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
                Ok(Some(advance)) => {
                    // A resonance where nothing is to be seen does not hold the next steps up.
                    self.step = if shortened { self.step.max(0.5 * wished) } else { self.step };
                    return Ok(advance);
                }
                // A failure of the model is not one of the step; a frequency at which there is no compliance is
                // stepped over.
                Err(HarmonicError::Structure(StructureError::UndampedResonance { .. })) => {
                    (self.step, shortened) = (0.5 * self.step, false);
                    self.system.forget();
                }
                Err(
                    error @ (HarmonicError::InvalidInput(_)
                    | HarmonicError::Structure(_)
                    | HarmonicError::Interrupted),
                ) => return Err(error),
                Ok(None) | Err(_) => {
                    (self.step, shortened) = (0.5 * self.step, false);
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
        // Of a held response with a level of the other sign is the branch half a period later, which comes close where
        // little force holds it.
        let turned =
            self.free[1..].contains(&Scalar::Level) && self.present.at.level * self.next.at.level < 0.0;
        if turned && self.step > ZERO_LEVEL_STEP {
            return Ok(None);
        }
        let corner = self.step < CORNER_STEP && cosine > 0.0 && orientation == self.orientation;
        if angle.is_nan() || (angle > LARGEST_ANGLE && !corner) {
            return Ok(None);
        }
        let bend = loop {
            match judge(self.system, &mut self.newton, &self.next, &self.free)? {
                Verdict::Keep(bend) if bend > 1.0 && self.step > self.sharpest => return Ok(None),
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

    /// Has the first point judged.
    pub fn judge(&mut self, judge: &mut Judge) -> Result<Verdict, HarmonicError> {
        judge(self.system, &mut self.newton, &self.present, &self.free)
    }

    /// Evaluates at `location`, found between points, and has `see` look at it; `None` where that fails.
    pub fn visit<T>(&mut self, location: &Location, see: &mut See<T>) -> Option<T> {
        self.next.clone_from(location);
        self.set_plane();
        let found = self.find_direction(true);
        self.next.iterations = location.iterations;
        let seen = found.ok().and_then(|()| see(self.system, &mut self.newton, &self.next, &self.free));
        self.next.clone_from(&self.present);
        seen
    }

    /// Way from the previous point to `location`.
    pub fn way(&self, location: &Location) -> f64 {
        self.unit.distance(location, &self.previous.x, &self.previous.at)
    }

    /// The scalar continued.
    pub fn along(&self) -> Scalar {
        self.route.along
    }
}
