//! Locates resonances of a balance: by phase, or where a node's amplitude is largest over frequency.

use crate::harmonic::newton::Point;
use crate::harmonic::newton::condition::{ArcLength, Phase, Value};
use crate::harmonic::newton::problem::{Condition, Newton, Stopping, length};
use crate::harmonic::newton::system::{Operating, PeriodicSystem, Scalar};
use crate::harmonic::{CurveSettings, HarmonicError, UNRESOLVED};
use crate::numeric::extremum::{Extremum, value_at};
use crate::numeric::fourier::dot;
use crate::numeric::lu::Factors;

const FREQUENCY: [Scalar; 1] = [Scalar::AngularFrequency];
/// Steps uphill before a peak is given up.
const MOST_STEPS: usize = 2000;
/// Longest and shortest step uphill, in units of the unknowns' norm and of the frequency.
const LONGEST_STEP: f64 = 0.2;
const FIRST_STEP: f64 = 0.02;
const SHORTEST_STEP: f64 = 1e-9;
/// Least cosine between the directions at the ends of a step: a longer step may pass a peak unseen.
const LEAST_COSINE: f64 = 0.8;
/// Distance from the peak that counts as none: the amplitude is off by its square.
const AT_PEAK: f64 = 1e-9;

/// A solution: unknowns, and the numbers they belong to.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Solution {
    pub x: Vec<f64>,
    pub at: Operating,
}

/// What is sought at given level and parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Sought {
    /// Largest amplitude of a node over frequency.
    Peak(usize),
    /// First harmonic of a node a quarter period from that of the excitation, `[cosine, sine]`.
    Phase(usize, [f64; 2]),
}

/// A response on the frequency response curve, and the way on from there.
#[derive(Debug, Clone)]
struct Place {
    solution: Solution,
    /// Unit vector along the curve, in the walk's measure: unknowns, then the frequency.
    direction: Vec<f64>,
    /// Derivative of the amplitude along it, relative to the amplitude.
    rise: f64,
}

/// The steps of a search, warm from one to the next.
#[derive(Debug)]
pub(crate) struct Tracker {
    newton: Newton,
    stopping: Stopping,
    extremum: Extremum,
    along: Vec<Vec<f64>>,
    /// Direction of the curve at the last peak, and how fast the rise falls there.
    last: Option<(Vec<f64>, f64)>,
    /// Size of the unknowns and of the frequency, by which steps are measured.
    sizes: (f64, f64),
    /// Newton steps since the count began.
    iterations: usize,
}

impl Tracker {
    pub fn new(stopping: Stopping) -> Self {
        Self {
            newton: Newton::default(),
            stopping,
            extremum: Extremum::default(),
            along: Vec::new(),
            last: None,
            sizes: (1.0, 1.0),
            iterations: 0,
        }
    }

    /// Begins to count Newton steps anew.
    pub fn count_anew(&mut self) {
        self.iterations = 0;
    }

    /// Newton steps made since then.
    pub fn iterations(&self) -> usize {
        self.iterations
    }

    fn solve(
        &mut self,
        system: &mut dyn PeriodicSystem,
        solution: &mut Solution,
        free: &[Scalar],
        conditions: &mut [&mut dyn Condition],
    ) -> Result<(), HarmonicError> {
        let Solution { x, at } = solution;
        let effort = self.newton.solve(system, x, at, free, conditions, &self.stopping)?;
        self.iterations += effort.iterations;
        Ok(())
    }

    /// What is sought near `start`, at whose level and parameter the system stands.
    pub fn locate(
        &mut self,
        system: &mut dyn PeriodicSystem,
        sought: Sought,
        start: Solution,
    ) -> Result<Solution, HarmonicError> {
        match sought {
            Sought::Peak(node) => self.peak(system, node, start),
            Sought::Phase(node, excitation) => {
                let mut solution = start;
                let mut phase = Phase::quarter(node, 1, excitation);
                self.solve(system, &mut solution, &FREQUENCY, &mut [&mut phase])?;
                Ok(solution)
            }
        }
    }

    fn peak(
        &mut self,
        system: &mut dyn PeriodicSystem,
        node: usize,
        start: Solution,
    ) -> Result<Solution, HarmonicError> {
        self.sizes = (length(&start.x).max(f64::MIN_POSITIVE), start.at.angular_frequency);
        let mut here = self.first_place(system, node, start)?;
        let mut step = match &self.last {
            Some((_, fall)) => (1.5 * here.rise.abs() / fall).clamp(100.0 * AT_PEAK, LONGEST_STEP),
            None => FIRST_STEP,
        };
        if here.rise < 0.0 {
            here.direction.iter_mut().for_each(|d| *d = -*d);
            here.rise = -here.rise;
        }
        for _ in 0..MOST_STEPS {
            let ahead = here.direction.clone();
            match self.place_along(system, node, &here.solution, &ahead, step) {
                Ok(next) if dot(&next.direction, &ahead) >= LEAST_COSINE => {
                    if next.rise <= 0.0 {
                        return self.refine(system, node, here, next);
                    }
                    here = self.grown(next);
                    step = (2.0 * step).min(LONGEST_STEP);
                }
                Err(error) if step < SHORTEST_STEP => return Err(error),
                // A corner of the curve, where a contact begins to slip: the peak is there or beyond.
                Ok(next) if step < SHORTEST_STEP => {
                    if next.rise <= 0.0 {
                        return self.refine(system, node, here, next);
                    }
                    here = self.grown(next);
                    step = FIRST_STEP;
                }
                _ => step *= 0.25,
            }
        }
        Err(HarmonicError::InvalidInput("the amplitude grows without limit: there is no peak near the start"))
    }

    /// The same place, measured by its own size once that is more than twice the one steps go by.
    fn grown(&mut self, mut place: Place) -> Place {
        let size = length(&place.solution.x);
        if size > 2.0 * self.sizes.0 {
            let n = place.solution.x.len();
            place.direction[..n].iter_mut().for_each(|d| *d *= self.sizes.0 / size);
            self.sizes.0 = size;
            let length = length(&place.direction);
            place.direction.iter_mut().for_each(|d| *d /= length);
            place.rise /= length;
        }
        place
    }

    /// The place at the start's frequency or, across a known direction of the curve, near it.
    fn first_place(
        &mut self,
        system: &mut dyn PeriodicSystem,
        node: usize,
        start: Solution,
    ) -> Result<Place, HarmonicError> {
        if let Some((direction, _)) = self.last.clone()
            && direction.len() == start.x.len() + 1
            && let Ok(place) = self.place_along(system, node, &start, &direction, 0.0)
        {
            return Ok(place);
        }
        let mut solution = start;
        let mut value = Value { scalar: Scalar::AngularFrequency, value: solution.at.angular_frequency };
        self.solve(system, &mut solution, &FREQUENCY, &mut [&mut value])?;
        self.place(system, node, solution)
    }

    /// The place a `step` from `from` along `direction`, in the plane across it.
    fn place_along(
        &mut self,
        system: &mut dyn PeriodicSystem,
        node: usize,
        from: &Solution,
        direction: &[f64],
        step: f64,
    ) -> Result<Place, HarmonicError> {
        let n = from.x.len();
        let mut ahead = from.clone();
        ahead.x.iter_mut().zip(direction).for_each(|(x, d)| *x += step * self.sizes.0 * d);
        ahead.at.angular_frequency += step * self.sizes.1 * direction[n];
        let mut plane = ArcLength {
            unknowns: direction[..n].iter().map(|d| d / self.sizes.0).collect(),
            scalars: [direction[n] / self.sizes.1, 0.0, 0.0, 0.0],
            target: 0.0,
        };
        plane.target = plane.at(&ahead.x, &ahead.at);
        self.solve(system, &mut ahead, &FREQUENCY, &mut [&mut plane])?;
        self.place(system, node, ahead)
    }

    /// Direction and rise at a solution just found, whose last condition gives the orientation.
    fn place(
        &mut self,
        system: &mut dyn PeriodicSystem,
        node: usize,
        solution: Solution,
    ) -> Result<Place, HarmonicError> {
        let n = solution.x.len();
        let mut direction = vec![0.0; n + 1];
        direction[n] = 1.0;
        let solved = self.newton.refactor(system, &FREQUENCY) && self.newton.solve_linear(&mut direction);
        if !solved {
            return Err(HarmonicError::NotConverged { residual: f64::NAN, iterations: 0 });
        }
        let rise = self.rise(system, node, &solution, &direction)?;
        direction[..n].iter_mut().for_each(|d| *d /= self.sizes.0);
        direction[n] /= self.sizes.1;
        let size = length(&direction);
        direction.iter_mut().for_each(|d| *d /= size);
        Ok(Place { solution, direction, rise: rise / size })
    }

    /// Derivative of the node's amplitude along a direction, relative to the amplitude.
    fn rise(
        &mut self,
        system: &mut dyn PeriodicSystem,
        node: usize,
        solution: &Solution,
        direction: &[f64],
    ) -> Result<f64, HarmonicError> {
        let coefficients = &system.describe(&solution.x, &solution.at)?.nodes[node];
        let (phase, amplitude) = self.extremum.of(coefficients);
        let (unknowns, frequency) = direction.split_at(direction.len() - 1);
        self.along.resize_with(system.nodes(), Vec::new);
        system.nodes_along(unknowns, &[frequency[0], 0.0, 0.0, 0.0], &mut self.along);
        if amplitude == 0.0 {
            return Err(HarmonicError::InvalidInput("the node does not move: it has no peak"));
        }
        let sign = value_at(coefficients, phase).signum();
        Ok(sign * value_at(&self.along[node], phase) / amplitude)
    }

    /// The peak between a place on the way up and one on the way down.
    fn refine(
        &mut self,
        system: &mut dyn PeriodicSystem,
        node: usize,
        mut up: Place,
        mut down: Place,
    ) -> Result<Solution, HarmonicError> {
        const MOST_HALVINGS: usize = 60;
        // Rises by which the straight line is drawn: that of the end which stays is lowered (Anderson &
        // Björck 1973), so that both ends come near.
        let (mut above, mut below) = (up.rise, down.rise);
        let mut found = None;
        for _ in 0..MOST_HALVINGS {
            let (chord, distance) = self.chord(&up.solution, &down.solution);
            let fall = (up.rise - down.rise) / distance;
            let nearest = if up.rise < -down.rise { &up } else { &down };
            if distance < AT_PEAK || nearest.rise.abs() < AT_PEAK * fall {
                found = Some((nearest.clone(), fall));
                break;
            }
            let fraction = (above / (above - below)).clamp(0.001, 0.999);
            let middle = self.place_along(system, node, &up.solution, &chord, fraction * distance)?;
            let lowered = |here: f64, replaced: f64| {
                let weight = 1.0 - here / replaced;
                if weight > 0.0 { weight } else { 0.5 }
            };
            if middle.rise > 0.0 {
                below *= lowered(middle.rise, above);
                above = middle.rise;
                up = middle;
            } else {
                above *= lowered(middle.rise, below);
                below = middle.rise;
                down = middle;
            }
        }
        let (place, fall) =
            found.ok_or(HarmonicError::NotConverged { residual: f64::NAN, iterations: MOST_HALVINGS })?;
        let mut solution = place.solution;
        self.last = Some((place.direction, fall));
        // The system's last evaluation must be that of the result.
        self.solve(system, &mut solution, &[], &mut [])?;
        Ok(solution)
    }

    /// Unit vector and distance from one solution to another.
    fn chord(&self, from: &Solution, to: &Solution) -> (Vec<f64>, f64) {
        let mut chord: Vec<f64> = to.x.iter().zip(&from.x).map(|(b, a)| (b - a) / self.sizes.0).collect();
        chord.push((to.at.angular_frequency - from.at.angular_frequency) / self.sizes.1);
        let distance = length(&chord);
        chord.iter_mut().for_each(|c| *c /= distance);
        (chord, distance)
    }
}

/// The response at a solution, at which the system was last evaluated, with its truncation error and, where
/// asked for, its stability.
pub(crate) fn describe(
    system: &mut dyn PeriodicSystem,
    solution: &Solution,
    settings: &CurveSettings,
) -> Result<Point, HarmonicError> {
    let mut factors = Factors::default();
    factors.reset(solution.x.len()).copy_from_slice(system.jacobian().as_slice());
    // At a turning point the estimate is infinite, and rightly so.
    let factored = factors.factor();
    describe_by(system, solution, settings, &mut |right| {
        if factored {
            factors.solve(right);
        } else {
            right.fill(f64::INFINITY);
        }
    })
}

/// As [`describe`], where `solve` tells the change of the unknowns that a residual asks for.
pub(crate) fn describe_by(
    system: &mut dyn PeriodicSystem,
    solution: &Solution,
    settings: &CurveSettings,
    solve: &mut dyn FnMut(&mut [f64]),
) -> Result<Point, HarmonicError> {
    let Solution { x, at } = solution;
    let mut point = system.describe(x, at)?;
    point.error_estimate = system.truncation_error(x, at, &point, solve)?;
    point.resolved = point.error_estimate <= settings.truncation.unwrap_or(UNRESOLVED);
    if settings.stability {
        point.settle(system.stable(&point));
    }
    Ok(point)
}

/// More harmonics for a point that has too few: half as many again, up to the most. `None` where there are
/// the most already, or none are asked for.
pub(crate) fn more_harmonics(point: &Point, settings: &CurveSettings) -> Option<usize> {
    let now = point.harmonics;
    let more = (now + now / 2 + 2).min(settings.max_harmonics);
    // A set of odd harmonics cannot take on an even one: it would stay as it is.
    let least = now + if now % 2 == 1 { 2 } else { 1 };
    // An unknown error gives no reason for more.
    let asked = settings.truncation.is_some_and(|tolerance| point.error_estimate > tolerance);
    (asked && more >= least).then_some(more)
}
