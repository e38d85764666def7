//! Response curves over frequency and level, and single responses.

use super::curve::Curve;
use super::linear_resonances::linear_resonances;
use super::recorder::Recorder;
use super::start::{check_control, condition, first};
use crate::harmonic::balance::assembly::{Assembly, Control};
use crate::harmonic::balance::balance_of;
use crate::harmonic::continuation::Ending;
use crate::harmonic::continuation::LinearResonance;
use crate::harmonic::continuation::{Advance, Location, Path, Route, Verdict};
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
