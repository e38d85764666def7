//! Response curves over frequency, level or a parameter, and single responses.

use super::curve::Curve;
use super::linear_resonances::linear_resonances;
use super::recorder::Recorder;
use super::start::{check_control, condition, first};
use crate::harmonic::balance::assembly::{Assembly, Control};
use crate::harmonic::balance::balance_of;
use crate::harmonic::balance::varied::{AssemblyAt, Varied};
use crate::harmonic::continuation::{Advance, Ending, LinearResonance, Location, Path, Route, Verdict};
use crate::harmonic::newton::Point;
use crate::harmonic::newton::problem::{Condition, Newton, solve};
use crate::harmonic::newton::system::{Operating, PeriodicSystem, Scalar};
use crate::harmonic::{CurveSettings, HarmonicError};

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
    sweep.run(system.as_mut(), Operating::forced(from, 1.0), assembly.nodes(), settings, watch)
}

/// Responses at `angular_frequency` (rad/s) under levels `from` … `to`, followed by arc length as
/// [`frequency_response`] does.
///
/// # Errors
/// As [`frequency_response`].
///
/// ```
/// use stickslip::harmonic::level_response;
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
/// let curve = level_response(&system, 2.0, 0.0, 4.0, &CurveSettings::default(), &mut |_| true)?;
/// let slips = curve.points.iter().find(|point| point.dissipated_energy() > 0.0).expect("it slips");
/// // Stuck, the mass moves by the force over |16 − 2² + 0.1·2 i| N/m; it slips beyond 1/7 m.
/// assert!(slips.level >= 12.0_f64.hypot(0.2) / 7.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
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
    let start = Operating::forced(angular_frequency, from);
    sweep.run(system.as_mut(), start, assembly.nodes(), settings, watch)
}

/// Responses at `angular_frequency` (rad/s) and `level` where a parameter runs through `range`, followed by arc length:
/// turning points are passed. `at` makes the system at a value; it must change smoothly with the parameter, within the
/// range and a hundred-thousandth beyond, and keep its ports. `watch` sees every point and says whether to go on.
///
/// A curve that cannot be followed to its end is returned as far as it came, with [`Ending`] saying so.
///
/// ```
/// use stickslip::harmonic::{CurveSettings, Ending, Point, parameter_response};
/// use stickslip::model::Model;
/// let model = Model::parse(
///     r#"
///     schema = "stickslip.model/1"
///     kind = "oscillator"
///     mass = [{ name = "m1", mass = 1.0 }]
///     spring = [{ between = ["ground", "m1"], stiffness = 1.0, damping = 0.1 }]
///     contact = { at = "m1", law = "jenkins", tangential_stiffness = 0.44, friction_coefficient = 0.1, normal_load = 1.0 }
///     "#,
/// )?;
/// let over_friction = model.assembly_over("contact.friction_coefficient")?;
/// let curve = parameter_response(&over_friction, 1.0, 0.5, [0.01, 0.2], &CurveSettings::default(), &mut |_| true)?;
/// assert_eq!(curve.ending, Ending::Complete);
/// let lost: Vec<f64> = curve.points.iter().map(Point::dissipated_energy).collect();
/// // As long as the contact slips freely, more friction takes more energy.
/// assert!(lost.last() > lost.first());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`HarmonicError::InvalidInput`] for arguments that do not fit, what `at` fails with at the start; the other kinds when
/// there is no first response.
pub fn parameter_response(
    at: &AssemblyAt,
    angular_frequency: f64,
    level: f64,
    range: [f64; 2],
    settings: &CurveSettings,
    watch: &mut dyn FnMut(&Point) -> bool,
) -> Result<Curve, HarmonicError> {
    let [from, to] = range;
    let positive = angular_frequency > 0.0 && angular_frequency.is_finite();
    if !(positive && level.is_finite() && from.is_finite() && to.is_finite() && from != to) {
        return Err(HarmonicError::InvalidInput(
            "the angular frequency must be positive, level and parameter finite, the range not empty",
        ));
    }
    // Across zero the parameter's own size is no measure of what a small change of it is.
    let least = if from * to > 0.0 { 0.0 } else { 1e-3 * from.abs().max(to.abs()) };
    let mut system = Varied::new(at, from, least, settings)?;
    let nodes = system.assembly().nodes();
    let control = Control::Level(level);
    let sweep = Sweep { along: Scalar::Parameter, from, to, control, linear_resonances: Vec::new() };
    let start = Operating { parameter: from, ..Operating::forced(angular_frequency, level) };
    sweep.run(&mut system, start, nodes, settings, watch)
}

/// One response at `angular_frequency` (rad/s) under `control`. `start`, a response nearby, saves the search.
///
/// # Errors
/// As [`frequency_response`].
///
/// ```
/// use stickslip::harmonic::periodic_response;
/// use stickslip::prelude::*;
/// let model = Model::parse(
///     r#"
///     schema = "stickslip.model/1"
///     kind = "oscillator"
///     mass = [{ name = "m1", mass = 1.0 }]
///     spring = [{ between = ["ground", "m1"], stiffness = 9.0, damping = 0.1 }]
///     "#,
/// )?;
/// let system = Assembly::new(model.system()?);
/// let point = periodic_response(&system, 2.0, &Control::Level(3.0), &CurveSettings::default(), None)?;
/// // 3 N over |9 − 2² + 0.1·2 i| N/m.
/// assert!((point.amplitude[0] - 3.0 / 5.0_f64.hypot(0.2)).abs() < 1e-9);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
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
        None => first(system, &Operating::forced(angular_frequency, 1.0), control, settings)?,
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
        start: Operating,
        nodes: Vec<String>,
        settings: &CurveSettings,
        watch: &mut dyn FnMut(&Point) -> bool,
    ) -> Result<Curve, HarmonicError> {
        let (x, at) = first(&mut *system, &start, &self.control, settings)?;
        let mut recorder = Recorder::new(settings);
        let mut curve = Curve::empty(nodes);
        // The first point fixes the harmonics to start with.
        let mut path = self.path(&mut *system, x, at, settings)?;
        while let Verdict::Harmonics(harmonics) =
            path.judge(&mut |system, newton, location, free| recorder.judge(system, newton, location, free))?
        {
            if path.restart(harmonics).is_err() {
                // What was found with fewer harmonics does not lead there: so many from the beginning.
                drop(path);
                let (x, at) = first(&mut *system, &start, &self.control, settings)?;
                path = self.path(&mut *system, x, at, settings)?;
            }
        }
        if !recorder.keep(&mut curve, watch) {
            curve.ending = Ending::Interrupted;
            return Ok(curve);
        }
        curve.ending = match follow(&mut path, &mut recorder, &mut curve, settings, watch) {
            Err(HarmonicError::Interrupted) => Ending::Interrupted,
            ending => ending?,
        };
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

/// Follows `path` to its end, point after point of `curve`.
fn follow(
    path: &mut Path,
    recorder: &mut Recorder,
    curve: &mut Curve,
    settings: &CurveSettings,
    watch: &mut dyn FnMut(&Point) -> bool,
) -> Result<Ending, HarmonicError> {
    loop {
        if curve.points.len() >= settings.max_points {
            return Ok(Ending::Stuck);
        }
        let advance = path
            .advance(&mut |system, newton, location, free| recorder.judge(system, newton, location, free))?;
        if advance == Advance::Stuck {
            return Ok(Ending::Stuck);
        }
        if !recorder.locate(path, curve, watch) || !recorder.keep(curve, watch) {
            return Ok(Ending::Interrupted);
        }
        if let Advance::Arrived(ending) = advance {
            return Ok(ending);
        }
    }
}
