//! Points of a curve as they are found: judged, their error estimated, peaks and folds located between them.

use super::curve::{Curve, Fold, Peak};
use crate::harmonic::continuation::{Location, NotFound, Path, Verdict};
use crate::harmonic::newton::Point;
use crate::harmonic::newton::problem::Newton;
use crate::harmonic::newton::system::{PeriodicSystem, Scalar};
use crate::harmonic::{CurveSettings, HarmonicError, UNRESOLVED};
use crate::numeric::extremum::{Extremum, value_at};
use crate::numeric::fourier::dot;

/// Change of a node's motion, beyond the straight line, that one step may bring (fraction of its size).
const BEND: f64 = 0.03;
/// Fraction of a step within which a peak is at one of its ends, or at another peak.
const SAME_PLACE: f64 = 1e-3;
/// The harmonics grow by this factor where the error is too large …
const GROWTH: f64 = 1.5;
/// … and shrink by this one where it is smaller than this fraction of the tolerance.
const SHRINKAGE: f64 = 1.25;
const AMPLE: f64 = 0.1;

/// What is watched along a curve.
#[derive(Debug, Clone, Default)]
struct Trace {
    /// Derivatives of the nodes' coefficients by arc length.
    along: Vec<Vec<f64>>,
    /// Derivatives of the amplitudes by arc length.
    slopes: Vec<f64>,
    /// Change of the scalar continued per arc length.
    rate: f64,
}

/// Makes points of locations and watches what happens between them.
pub(super) struct Recorder<'s> {
    settings: &'s CurveSettings,
    extremum: Extremum,
    /// Where each node was largest at the last point (rad).
    phases: Vec<f64>,
    pub pending: Option<Point>,
    last_nodes: Vec<Vec<f64>>,
    now: Trace,
    before: Trace,
    correction: Vec<f64>,
    /// Set after the harmonics grew at a point, so that it does not shrink them again.
    grown: bool,
}

impl<'s> Recorder<'s> {
    pub fn new(settings: &'s CurveSettings) -> Self {
        Self {
            settings,
            extremum: Extremum::default(),
            phases: Vec::new(),
            pending: None,
            last_nodes: Vec::new(),
            now: Trace::default(),
            before: Trace::default(),
            correction: Vec::new(),
            grown: false,
        }
    }

    /// Makes the point at `location`, which the system and the solver have just left, and judges it.
    pub fn judge(
        &mut self,
        system: &mut dyn PeriodicSystem,
        newton: &mut Newton,
        location: &Location,
        free: &[Scalar],
    ) -> Result<Verdict, HarmonicError> {
        let mut point = system.describe(&location.x, &location.at)?;
        let direction = location.scalars.iter().any(|d| *d != 0.0);
        let mut bend = 0.0;
        if direction {
            self.now.along.resize_with(point.nodes.len(), Vec::new);
            system.nodes_along(&location.unknowns, &location.scalars, &mut self.now.along);
            self.now.rate = free.first().map_or(0.0, |along| location.scalars[along.index()]);
            bend = self.bend(&point);
            self.now.slopes.clear();
            self.phases.resize(point.nodes.len(), 0.0);
            let nodes = point.nodes.iter().zip(&point.amplitude).zip(&self.now.along);
            for (((node, amplitude), along), phase) in nodes.zip(&mut self.phases) {
                *phase = self.extremum.phase_of(node, *amplitude, *phase);
                self.now.slopes.push(slope(node, along, *phase));
            }
        }
        self.estimate(system, newton, location, free, &mut point)?;
        if let Some(tolerance) = self.settings.truncation
            && let Some(harmonics) = self.harmonics(&point, tolerance)
        {
            return Ok(Verdict::Harmonics(harmonics));
        }
        self.grown = false;
        self.finish(system, location, &mut point);
        self.pending = Some(point);
        Ok(Verdict::Keep(bend))
    }

    fn estimate(
        &mut self,
        system: &mut dyn PeriodicSystem,
        newton: &mut Newton,
        location: &Location,
        free: &[Scalar],
        point: &mut Point,
    ) -> Result<(), HarmonicError> {
        point.error_estimate = self.truncation_error(system, newton, location, free, point)?;
        point.resolved = point.error_estimate <= self.settings.truncation.unwrap_or(UNRESOLVED);
        Ok(())
    }

    fn finish(&self, system: &mut dyn PeriodicSystem, location: &Location, point: &mut Point) {
        if self.settings.stability {
            point.settle(system.stable(point));
        }
        point.iterations = location.iterations;
    }

    /// Other harmonics than those of `point`, if its error says so.
    fn harmonics(&mut self, point: &Point, tolerance: f64) -> Option<usize> {
        let (least, most) = (self.settings.harmonics, self.settings.max_harmonics);
        let (now, error) = (point.harmonics, point.error_estimate);
        if error > tolerance && now < most {
            self.grown = true;
            // One more at least; odd sets end on odd harmonics.
            let more = ((now as f64 * GROWTH) as usize).max(now + 2).min(most);
            // An odd set cannot take on an even number: its highest harmonic stays.
            (more > now + usize::from(now % 2 == 1 && more == now + 1)).then_some(more)
        } else if error < AMPLE * tolerance && now > least && !self.grown {
            self.grown = true;
            let fewer = ((now as f64 / SHRINKAGE) as usize).max(least);
            (fewer + 1 < now).then_some(fewer)
        } else {
            None
        }
    }

    fn truncation_error(
        &mut self,
        system: &mut dyn PeriodicSystem,
        newton: &mut Newton,
        location: &Location,
        free: &[Scalar],
        point: &Point,
    ) -> Result<f64, HarmonicError> {
        let n = location.x.len();
        let buffer = &mut self.correction;
        // With the scalars held: the solution on the plane, less what leads along the curve back to the
        // first scalar's value.
        let prepared = newton.prepare(system, free);
        let mut solve = |change: &mut [f64]| {
            buffer.clear();
            buffer.extend(change.iter().map(|r| r / newton.scale()));
            buffer.resize(n + free.len(), 0.0);
            if prepared && newton.solve_linear(buffer) {
                change.copy_from_slice(&buffer[..n]);
                if let Some(first) = free.first() {
                    let rate = location.scalars[first.index()];
                    if rate != 0.0 {
                        let back = buffer[n] / rate;
                        change.iter_mut().zip(&location.unknowns).for_each(|(c, d)| *c -= back * d);
                    }
                }
            }
        };
        system.truncation_error(&location.x, &location.at, point, &mut solve)
    }

    /// How far the nodes' motion deviates from a straight line back to the last point, as a fraction of what is
    /// tolerable.
    fn bend(&mut self, point: &Point) -> f64 {
        if self.last_nodes.len() != point.nodes.len() {
            return 0.0;
        }
        let mut worst = 0.0_f64;
        for (node, (now, last)) in point.nodes.iter().zip(&self.last_nodes).enumerate() {
            let along = &self.now.along[node];
            if along.len() != now.len() {
                continue;
            }
            // The step is the one that fits best: what remains is across.
            let parts = || now.iter().zip(last.iter().chain(std::iter::repeat(&0.0))).zip(along);
            let rate = dot(along, along);
            let step =
                if rate > 0.0 { parts().map(|((x, y), d)| (x - y) * d).sum::<f64>() / rate } else { 0.0 };
            let off: f64 = parts().map(|((x, y), d)| (x - y - step * d).powi(2)).sum();
            let size = dot(now, now).max(dot(last, last));
            if size > 0.0 {
                worst = worst.max((off / size).sqrt() / BEND);
            }
            // Around a circle and back the tangents lie along the chord again, but against it.
            let chord: f64 = parts().map(|((x, y), _)| (x - y) * (x - y)).sum();
            let against = |along: &[f64]| {
                let pairs = now.iter().zip(last.iter().chain(std::iter::repeat(&0.0))).zip(along);
                pairs.map(|((x, y), d)| (x - y) * d).sum::<f64>() < 0.0
            };
            let before = self.before.along.get(node).is_some_and(|before| against(before));
            if chord > BEND * BEND * size && (before || against(along)) {
                worst = worst.max((chord / size).sqrt() / BEND);
            }
        }
        worst
    }

    /// Locates peaks and folds between the last two points; peaks become points of the curve. False where the
    /// watcher has seen enough, or the work is to end.
    pub fn locate(
        &mut self,
        path: &mut Path,
        curve: &mut Curve,
        watch: &mut dyn FnMut(&Point) -> bool,
    ) -> bool {
        curve.folds.extend(self.fold(path));
        let first = curve.peaks.len();
        let mut between: Vec<(f64, Point)> = Vec::new();
        for node in 0..self.now.slopes.len() {
            let Some(before) = self.before.slopes.get(node).copied() else { continue };
            let now = self.now.slopes[node];
            if !(before > 0.0 && now < 0.0) {
                continue;
            }
            if self.settings.interrupted() {
                return false;
            }
            // A node that moves as another does has its peak there too.
            let same = |slopes: &[f64], other: usize| slopes[other] == slopes[node];
            let twin =
                (0..node).find(|other| same(&self.before.slopes, *other) && same(&self.now.slopes, *other));
            if let Some(twin) = twin {
                let known = curve.peaks[first..].iter().find(|peak| peak.node == twin).cloned();
                curve.peaks.extend(known.map(|peak| Peak { node, ..peak }));
                continue;
            }
            if let Some((way, point)) = self.peak(path, curve, node, (before, now)) {
                curve.peaks.push(Peak {
                    node,
                    angular_frequency: point.angular_frequency,
                    amplitude: point.amplitude[node],
                    level: point.level,
                    parameter: point.parameter,
                });
                between.push((way, point));
            }
        }
        between.sort_by(|a, b| a.0.total_cmp(&b.0));
        let reach = path.way(&path.present);
        let mut last = 0.0;
        for (way, point) in between {
            if way - last > SAME_PLACE * reach && reach - way > SAME_PLACE * reach {
                last = way;
                let more = watch(&point);
                curve.points.push(point);
                if !more {
                    return false;
                }
            }
        }
        true
    }

    /// Where the scalar continued turns back between the last two points, if it does.
    fn fold(&self, path: &mut Path) -> Option<Fold> {
        let ends = (self.before.rate, self.now.rate);
        (ends.0 * ends.1 < 0.0).then_some(())?;
        let along = path.along();
        let found = path.locate(ends, &mut |_, location| location.scalars[along.index()]).ok()?;
        let Point { angular_frequency, level, parameter, amplitude, .. } = describe(path, &found)?;
        Some(Fold { angular_frequency, level, parameter, amplitude })
    }

    /// The peak of a node between the last two points, where its amplitude rises and falls by `slopes`, and the way
    /// there.
    fn peak(
        &mut self,
        path: &mut Path,
        curve: &Curve,
        node: usize,
        slopes: (f64, f64),
    ) -> Option<(f64, Point)> {
        let mut extremum = Extremum::default();
        let mut along = Vec::new();
        let mut test = |system: &mut dyn PeriodicSystem, location: &Location| {
            let Ok(point) = system.describe(&location.x, &location.at) else { return f64::NAN };
            along.resize_with(point.nodes.len(), Vec::new);
            system.nodes_along(&location.unknowns, &location.scalars, &mut along);
            let (phase, _) = extremum.of(&point.nodes[node]);
            slope(&point.nodes[node], &along[node], phase)
        };
        let found = match path.locate(slopes, &mut test) {
            Ok(found) => found,
            // A summit if its neighbours are lower; the step before saw a rise all the way.
            Err(NotFound::AtPrevious(there)) => {
                let [.., before, top] = &curve.points[..] else { return None };
                let after = self.pending.as_ref()?;
                let higher = |than: &Point| top.amplitude[node] > than.amplitude[node];
                (higher(before) && higher(after)).then_some(there)?
            }
            // It still rises: the next step sees the summit, if there is one.
            Err(NotFound::AtPresent(slope)) => {
                self.now.slopes[node] = slope?;
                return None;
            }
            Err(NotFound::Lost) => return None,
        };
        let point = path.visit(&found, &mut |system, newton, location, free| {
            let mut point = system.describe(&location.x, &location.at).ok()?;
            self.estimate(system, newton, location, free, &mut point).ok()?;
            self.finish(system, location, &mut point);
            Some(point)
        })?;
        Some((path.way(&found), point))
    }

    /// Takes the pending point into the curve; false where the watcher has seen enough.
    pub fn keep(&mut self, curve: &mut Curve, watch: &mut dyn FnMut(&Point) -> bool) -> bool {
        let Some(point) = self.pending.take() else { return true };
        self.last_nodes.clone_from(&point.nodes);
        std::mem::swap(&mut self.before, &mut self.now);
        let more = watch(&point);
        curve.points.push(point);
        more
    }
}

/// The response at a location found between points.
fn describe(path: &mut Path, location: &Location) -> Option<Point> {
    path.system.evaluate(&location.x, &location.at, &[]).ok()?;
    path.system.describe(&location.x, &location.at).ok()
}

/// Derivative of the largest magnitude of a signal, which it has at `phase`, where its coefficients change by
/// `along`: the slope in time vanishes there, so that the phase need not be followed.
fn slope(node: &[f64], along: &[f64], phase: f64) -> f64 {
    value_at(node, phase).signum() * value_at(along, phase)
}
