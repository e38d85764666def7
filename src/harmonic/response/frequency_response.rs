//! Response curves over frequency and level, and single responses.

use super::curve::{Curve, Fold, Peak};
use super::linear_resonances::linear_resonances;
use super::start::{check_control, condition, first};
use crate::harmonic::HarmonicError;
use crate::harmonic::balance::assembly::{Assembly, Control, CurveSettings, UNRESOLVED};
use crate::harmonic::balance::balance_of;
use crate::harmonic::continuation::Ending;
use crate::harmonic::continuation::LinearResonance;
use crate::harmonic::continuation::{Advance, Location, NotFound, Path, Route, Verdict};
use crate::harmonic::newton::Point;
use crate::harmonic::newton::problem::{Condition, Newton, solve};
use crate::harmonic::newton::system::{Operating, PeriodicSystem, Scalar};
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

/// Responses at angular frequencies `from` … `to` (rad/s) under `control`, followed by arc length: turning
/// points are passed, peaks and folds located. `watch` sees every point and says whether to go on.
///
/// A curve that cannot be followed to its end is returned as far as it came, with [`Ending`] saying so.
///
/// # Errors
/// [`HarmonicError::InvalidInput`] for arguments that do not fit; the other kinds when there is no first
/// point.
///
/// ```
/// use stickslip::prelude::*;
/// let model = Model::parse(
///     r#"
///     schema = "stickslip.model/1"
///     kind = "oscillator"
///     mass = [{ name = "m1", mass = 1.0 }]
///     spring = [{ between = ["ground", "m1"], stiffness = 9.0, damping = 0.1 }]
///     contact = { at = "m1", law = "jenkins", tangential_stiffness = 7.0, friction_coefficient = 0.5, normal_load = 2.0 }
///     "#,
/// )?;
/// let system = Assembly::new(model.system()?);
/// let settings = CurveSettings::default();
/// let curve = frequency_response(&system, 2.0, 5.0, &Control::Level(2.0), &settings, &mut |_| true)?;
/// // The resonance lies between that of the mass that slides freely, 3 rad/s, and that of the stuck one, 4 rad/s.
/// assert!((3.0..4.0).contains(&curve.peaks[0].angular_frequency));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn frequency_response(
    assembly: &Assembly,
    from: f64,
    to: f64,
    control: &Control,
    settings: &CurveSettings,
    watch: &mut dyn FnMut(&Point) -> bool,
) -> Result<Curve, HarmonicError> {
    if !(from > 0.0 && to > 0.0 && from.is_finite() && to.is_finite() && from != to) {
        return Err(HarmonicError::InvalidInput("the angular frequencies must be positive and different"));
    }
    let mut system = balance_of(assembly, settings)?;
    let linear_resonances = linear_resonances(assembly);
    let sweep = Sweep { along: Scalar::AngularFrequency, from, to, control: *control, linear_resonances };
    sweep.run(system.as_mut(), assembly.nodes(), settings, watch)
}

/// Responses at `angular_frequency` (rad/s) under levels `from` … `to`, followed by arc length as
/// [`frequency_response`] does.
///
/// # Errors
/// As [`frequency_response`].
pub fn level_response(
    assembly: &Assembly,
    angular_frequency: f64,
    from: f64,
    to: f64,
    settings: &CurveSettings,
    watch: &mut dyn FnMut(&Point) -> bool,
) -> Result<Curve, HarmonicError> {
    let positive = angular_frequency > 0.0 && angular_frequency.is_finite();
    if !(positive && from.is_finite() && to.is_finite() && from != to) {
        return Err(HarmonicError::InvalidInput(
            "the angular frequency must be positive, the levels finite and different",
        ));
    }
    let mut system = balance_of(assembly, settings)?;
    let control = Control::Level(from);
    let sweep = Sweep { along: Scalar::Level, from, to, control, linear_resonances: Vec::new() };
    sweep.run_at(system.as_mut(), angular_frequency, assembly.nodes(), settings, watch)
}

/// One response at `angular_frequency` (rad/s) under `control`. `start`, a response nearby, saves the search.
///
/// # Errors
/// As [`frequency_response`].
pub fn periodic_response(
    assembly: &Assembly,
    angular_frequency: f64,
    control: &Control,
    settings: &CurveSettings,
    start: Option<&Point>,
) -> Result<Point, HarmonicError> {
    if !(angular_frequency > 0.0 && angular_frequency.is_finite()) {
        return Err(HarmonicError::InvalidInput("the angular frequency must be positive"));
    }
    let mut system = balance_of(assembly, settings)?;
    let system = system.as_mut();
    check_control(control, system.nodes(), system.harmonics())?;
    let warm = start.and_then(|point| resume(system, angular_frequency, control, settings, point));
    let (mut x, mut at) = match warm {
        Some(found) => found,
        None => first(system, angular_frequency, control, settings)?,
    };
    let mut recorder = Recorder::new(settings);
    loop {
        let mut newton = Newton::default();
        let effort = solve_at(&mut newton, system, &mut x, &mut at, control, settings)?;
        let location =
            Location { x: x.clone(), at, unknowns: Vec::new(), scalars: [0.0; 4], iterations: effort };
        let free: &[Scalar] = if let Control::Held { .. } = control { &[Scalar::Level] } else { &[] };
        match recorder.judge(system, &mut newton, &location, free)? {
            Verdict::Harmonics(harmonics) => {
                system.set_harmonics(harmonics, &mut [&mut x])?;
            }
            _ => return recorder.pending.ok_or(HarmonicError::InvalidInput("no response")),
        }
    }
}

fn solve_at(
    newton: &mut Newton,
    system: &mut dyn PeriodicSystem,
    x: &mut [f64],
    at: &mut Operating,
    control: &Control,
    settings: &CurveSettings,
) -> Result<usize, HarmonicError> {
    let effort = match condition(control) {
        None => newton.solve(system, x, at, &[], &mut [], &settings.stopping())?,
        Some(mut held) => {
            let mut all: [&mut dyn Condition; 1] = [&mut held];
            newton.solve(system, x, at, &[Scalar::Level], &mut all, &settings.stopping())?
        }
    };
    Ok(effort.iterations)
}

/// Newton's method from a known response; `None` where it fails.
fn resume(
    system: &mut dyn PeriodicSystem,
    angular_frequency: f64,
    control: &Control,
    settings: &CurveSettings,
    point: &Point,
) -> Option<(Vec<f64>, Operating)> {
    let mut x = vec![0.0; system.unknowns()];
    if !system.resume(point, &mut x) {
        return None;
    }
    let level = if let Control::Level(level) = control { *level } else { point.level };
    let mut at = Operating::forced(angular_frequency, level);
    let mut held = condition(control);
    let mut all: Vec<&mut dyn Condition> = Vec::new();
    all.extend(held.iter_mut().map(|held| held as &mut dyn Condition));
    let free = [Scalar::Level];
    let free = &free[..all.len()];
    solve(system, &mut x, &mut at, free, &mut all, &settings.stopping()).ok().map(|_| (x, at))
}

/// A scalar run through its range.
struct Sweep {
    along: Scalar,
    from: f64,
    to: f64,
    control: Control,
    linear_resonances: Vec<LinearResonance>,
}

impl Sweep {
    fn run(
        &self,
        system: &mut dyn PeriodicSystem,
        nodes: Vec<String>,
        settings: &CurveSettings,
        watch: &mut dyn FnMut(&Point) -> bool,
    ) -> Result<Curve, HarmonicError> {
        self.run_at(system, self.from, nodes, settings, watch)
    }

    fn run_at(
        &self,
        system: &mut dyn PeriodicSystem,
        angular_frequency: f64,
        nodes: Vec<String>,
        settings: &CurveSettings,
        watch: &mut dyn FnMut(&Point) -> bool,
    ) -> Result<Curve, HarmonicError> {
        let (x, at) = first(&mut *system, angular_frequency, &self.control, settings)?;
        let mut recorder = Recorder::new(settings);
        let mut curve = Curve {
            nodes,
            points: Vec::new(),
            peaks: Vec::new(),
            folds: Vec::new(),
            ending: Ending::Complete,
        };
        // The first point fixes the harmonics to start with.
        let mut path = self.path(&mut *system, x, at, settings)?;
        while let Verdict::Harmonics(harmonics) =
            path.judge(&mut |system, newton, location, free| recorder.judge(system, newton, location, free))?
        {
            if path.restart(harmonics).is_err() {
                // What was found with fewer harmonics does not lead there: so many from the beginning.
                drop(path);
                let (x, at) = first(&mut *system, angular_frequency, &self.control, settings)?;
                path = self.path(&mut *system, x, at, settings)?;
            }
        }
        if !recorder.keep(&mut curve, watch) {
            curve.ending = Ending::Interrupted;
            return Ok(curve);
        }
        loop {
            if curve.points.len() >= settings.max_points {
                curve.ending = Ending::Stuck;
                break;
            }
            let advance = path.advance(&mut |system, newton, location, free| {
                recorder.judge(system, newton, location, free)
            })?;
            if advance == Advance::Stuck {
                curve.ending = Ending::Stuck;
                break;
            }
            if !recorder.locate(&mut path, &mut curve, watch) || !recorder.keep(&mut curve, watch) {
                curve.ending = Ending::Interrupted;
                break;
            }
            if let Advance::Arrived(ending) = advance {
                curve.ending = ending;
                break;
            }
        }
        Ok(curve)
    }

    fn path<'s>(
        &self,
        system: &'s mut dyn PeriodicSystem,
        x: Vec<f64>,
        at: Operating,
        settings: &CurveSettings,
    ) -> Result<Path<'s>, HarmonicError> {
        let route = Route {
            along: self.along,
            from: self.from,
            to: self.to,
            stopping: settings.stopping(),
            max_step: settings.max_step,
        };
        let mut path = match condition(&self.control) {
            None => Path::new(system, route, &[], Vec::new(), x, at)?,
            Some(held) => Path::new(system, route, &[Scalar::Level], vec![Box::new(held)], x, at)?,
        };
        path.pause_at(&self.linear_resonances);
        Ok(path)
    }
}

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
struct Recorder<'s> {
    settings: &'s CurveSettings,
    extremum: Extremum,
    /// Where each node was largest at the last point (rad).
    phases: Vec<f64>,
    pending: Option<Point>,
    last_nodes: Vec<Vec<f64>>,
    now: Trace,
    before: Trace,
    correction: Vec<f64>,
    /// Set after the harmonics grew at a point, so that it does not shrink them again.
    grown: bool,
}

impl<'s> Recorder<'s> {
    fn new(settings: &'s CurveSettings) -> Self {
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
    fn judge(
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
    /// watcher has seen enough.
    fn locate(&mut self, path: &mut Path, curve: &mut Curve, watch: &mut dyn FnMut(&Point) -> bool) -> bool {
        if self.before.rate * self.now.rate < 0.0 {
            let ends = (self.before.rate, self.now.rate);
            let along = path.along();
            if let Ok(found) = path.locate(ends, &mut |_, location| location.scalars[along.index()])
                && let Some(point) = describe(path, &found)
            {
                curve.folds.push(Fold {
                    angular_frequency: point.angular_frequency,
                    level: point.level,
                    amplitude: point.amplitude,
                });
            }
        }
        let first = curve.peaks.len();
        let mut between: Vec<(f64, Point)> = Vec::new();
        for node in 0..self.now.slopes.len() {
            let Some(before) = self.before.slopes.get(node).copied() else { continue };
            let now = self.now.slopes[node];
            if !(before > 0.0 && now < 0.0) {
                continue;
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
    fn keep(&mut self, curve: &mut Curve, watch: &mut dyn FnMut(&Point) -> bool) -> bool {
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
