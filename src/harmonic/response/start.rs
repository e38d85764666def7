//! The first solution of a curve, from nothing.

use crate::harmonic::balance::assembly::Control;
use crate::harmonic::continuation::{Advance, Path, Route, Verdict};
use crate::harmonic::newton::condition::HeldAmplitude;
use crate::harmonic::newton::problem::{Condition, Stopping, solve};
use crate::harmonic::newton::system::{Operating, PeriodicSystem, Scalar};
use crate::harmonic::{CurveSettings, HarmonicError};

/// Level from which a response is followed up where Newton's method fails at once, as a fraction of the wanted.
const WEAK: f64 = 1e-3;

/// Points of such a curve after which it is given up: the response may be out of reach, and is to say so soon.
const MOST_POINTS: usize = 400;
/// Springs in front of contacts, in compliances of the structure there: the first leaves almost nothing of
/// the contacts, beyond the last there is nothing left to be gained.
const LARGEST_COMPLIANCE: f64 = 100.0;
const LEAST_COMPLIANCE: f64 = 1e-13;
/// Newton steps for such a spring, and springs tried.
const HOMOTOPY_ITERATIONS: usize = 10;
const HOMOTOPY_STEPS: usize = 60;
/// Harmonics to begin with where all of them lead nowhere, and neighbouring frequencies, as ratios.
const FEW: [usize; 4] = [11, 7, 3, 1];
const NEIGHBOURS: [f64; 8] = [0.9, 1.1, 0.8, 1.3, 0.6, 1.6, 2.5, 0.4];

/// The condition that `control` puts beside the balance; the level is free then.
pub(crate) fn condition(control: &Control) -> Option<HeldAmplitude> {
    match *control {
        Control::Level(_) => None,
        Control::Held { node, order, derivative, amplitude } => {
            Some(HeldAmplitude::new(node, order, derivative, amplitude))
        }
    }
}

pub(crate) fn check_control(control: &Control, nodes: usize, harmonics: usize) -> Result<(), HarmonicError> {
    let refuse = |message| Err(HarmonicError::InvalidInput(message));
    match *control {
        Control::Level(level) if !level.is_finite() => refuse("the level is not finite"),
        Control::Held { node, .. } if node >= nodes => refuse("there is no such node to hold"),
        Control::Held { order, derivative, .. } if order == 0 || order > harmonics || derivative > 2 => {
            refuse("only displacement, velocity or acceleration of a harmonic of the set can be held")
        }
        Control::Held { amplitude, .. } if !(amplitude > 0.0 && amplitude.is_finite()) => {
            refuse("the amplitude held must be positive")
        }
        _ => Ok(()),
    }
}

/// Solves at the frequency and parameter of `start` under `control`: by Newton's method from equivalent linearisation, and where
/// that fails along the level from a weak excitation up.
pub(crate) fn first(
    system: &mut dyn PeriodicSystem,
    start: &Operating,
    control: &Control,
    settings: &CurveSettings,
) -> Result<(Vec<f64>, Operating), HarmonicError> {
    check_control(control, system.nodes(), system.harmonics())?;
    let found = match control {
        Control::Level(level) => at_level(system, Operating { level: *level, ..*start }, settings),
        Control::Held { .. } => held(system, start.angular_frequency, control, settings),
    };
    // Attempts that were ended have found nothing: that is not what is to be said.
    if found.is_err() && settings.interrupted() { Err(HarmonicError::Interrupted) } else { found }
}

/// Solves at `at` as [`first`] does.
pub(crate) fn at_level(
    system: &mut dyn PeriodicSystem,
    at: Operating,
    settings: &CurveSettings,
) -> Result<(Vec<f64>, Operating), HarmonicError> {
    match directly(system, at, settings)? {
        Some(x) => Ok((x, at)),
        None => indirectly(system, at, settings),
    }
}

/// Solves at `at` along the level from a weak excitation up, from fewer harmonics, or along the frequency from a
/// neighbouring one.
pub(crate) fn indirectly(
    system: &mut dyn PeriodicSystem,
    at: Operating,
    settings: &CurveSettings,
) -> Result<(Vec<f64>, Operating), HarmonicError> {
    let from_weak = up(system, at, WEAK * at.level, at.level, settings);
    if let Some(found) = end_of(from_weak, settings)? {
        return Ok(found);
    }
    if let Some(x) = from_fewer(system, at, settings)? {
        return Ok((x, at));
    }
    for ratio in NEIGHBOURS {
        let there = Operating { angular_frequency: ratio * at.angular_frequency, ..at };
        let path = along_frequency(system, there, at.angular_frequency, settings);
        if let Some(found) = end_of(path, settings)? {
            return Ok(found);
        }
    }
    Err(HarmonicError::NotConverged { residual: f64::INFINITY, iterations: settings.max_points })
}

/// Where a path arrives; `None` where it does not, or could not begin.
fn end_of(
    path: Result<Path, HarmonicError>,
    settings: &CurveSettings,
) -> Result<Option<(Vec<f64>, Operating)>, HarmonicError> {
    let mut path = match path {
        Ok(path) => path,
        Err(error) if error.is_of_the_step() => return Ok(None),
        Err(error) => return Err(error),
    };
    for _ in 0..settings.max_points.min(MOST_POINTS) {
        match path.advance(&mut |_, _, _, _| Ok(Verdict::Keep(0.0)))? {
            Advance::Going => {}
            Advance::Arrived(crate::harmonic::Ending::Complete) => {
                return Ok(Some((path.present.x, path.present.at)));
            }
            _ => break,
        }
    }
    Ok(None)
}

/// Solves at `at` with fewer harmonics, which are then added; `None` where that fails, or the system keeps its
/// harmonics.
fn from_fewer(
    system: &mut dyn PeriodicSystem,
    at: Operating,
    settings: &CurveSettings,
) -> Result<Option<Vec<f64>>, HarmonicError> {
    let wanted = system.harmonics();
    let mut x = vec![0.0; system.unknowns()];
    let mut found = false;
    for few in FEW.into_iter().filter(|few| *few < wanted) {
        if !system.set_harmonics(few, &mut [&mut x])? {
            return Ok(None);
        }
        if let Some(start) = directly(system, at, settings)? {
            (x, found) = (start, true);
            break;
        }
    }
    let mut stride = 2;
    while found && system.harmonics() < wanted {
        let (now, before) = (system.harmonics(), x.clone());
        system.set_harmonics((now + stride).min(wanted), &mut [&mut x])?;
        system.forget();
        if solve(system, &mut x, &mut at.clone(), &[], &mut [], &settings.stopping()).is_ok() {
            stride *= 2;
        } else if stride > 2 {
            system.set_harmonics(now, &mut [&mut x])?;
            (x, stride) = (before, 2);
        } else {
            found = false;
        }
    }
    if !found {
        system.set_harmonics(wanted, &mut [&mut x])?;
    }
    Ok(found.then_some(x))
}

/// A path along the frequency, from `at` to the angular frequency `to` (rad/s).
fn along_frequency<'s>(
    system: &'s mut dyn PeriodicSystem,
    at: Operating,
    to: f64,
    settings: &CurveSettings,
) -> Result<Path<'s>, HarmonicError> {
    let x = directly(system, at, settings)?.ok_or_else(|| not_found(settings))?;
    let route = Route {
        along: Scalar::AngularFrequency,
        from: at.angular_frequency,
        to,
        stopping: settings.stopping(),
        max_step: 1.0,
    };
    Path::new(system, route, &[], Vec::new(), x, at)
}

/// Solves at `at` by Newton's method from equivalent linearisation, or from the structure without its contacts, which
/// are then made as stiff as they are; `None` where both fail.
pub(crate) fn directly(
    system: &mut dyn PeriodicSystem,
    at: Operating,
    settings: &CurveSettings,
) -> Result<Option<Vec<f64>>, HarmonicError> {
    let mut x = vec![0.0; system.unknowns()];
    system.guess(&at, &mut x)?;
    let attempt = |system: &mut dyn PeriodicSystem, x: &mut Vec<f64>, most: usize| {
        system.forget();
        let stopping = settings.stopping();
        let stopping = Stopping { max_iterations: stopping.max_iterations.min(most), ..stopping };
        solve(system, x, &mut at.clone(), &[], &mut [], &stopping).is_ok()
    };
    if attempt(system, &mut x, settings.max_iterations) {
        return Ok(Some(x));
    }
    if !system.compliance_homotopy(LARGEST_COMPLIANCE) {
        return Ok(None);
    }
    x.fill(0.0);
    let mut here = attempt(system, &mut x, HOMOTOPY_ITERATIONS).then_some((LARGEST_COMPLIANCE, x));
    let mut before: Option<(f64, Vec<f64>)> = None;
    let mut factor: f64 = 0.3;
    let mut found = None;
    for _ in 0..HOMOTOPY_STEPS {
        let Some((compliance, x)) = &here else { break };
        let mut whole = x.clone();
        system.compliance_homotopy(0.0);
        if attempt(system, &mut whole, HOMOTOPY_ITERATIONS) {
            found = Some(whole);
            break;
        }
        let next = factor * compliance;
        if next < LEAST_COMPLIANCE || factor > 0.99 {
            break;
        }
        // Over the logarithm of the compliance a response runs evenly.
        let mut ahead = x.clone();
        if let Some((last, y)) = &before {
            let fraction = factor.ln() / (compliance / last).ln();
            ahead.iter_mut().zip(y).for_each(|(x, y)| *x += fraction * (*x - y));
        }
        system.compliance_homotopy(next);
        if attempt(system, &mut ahead, HOMOTOPY_ITERATIONS) {
            before = here.replace((next, ahead));
            factor = (factor * factor.sqrt()).max(0.1);
        } else {
            factor = factor.sqrt();
        }
    }
    system.compliance_homotopy(0.0);
    Ok(found)
}

fn not_found(settings: &CurveSettings) -> HarmonicError {
    HarmonicError::NotConverged { residual: f64::INFINITY, iterations: settings.max_iterations }
}

/// A path along the level.
fn up<'s>(
    system: &'s mut dyn PeriodicSystem,
    at: Operating,
    from: f64,
    to: f64,
    settings: &CurveSettings,
) -> Result<Path<'s>, HarmonicError> {
    let weak = Operating { level: from, ..at };
    let x = directly(system, weak, settings)?.ok_or_else(|| not_found(settings))?;
    let route =
        Route { along: Scalar::Level, from, to, stopping: settings.stopping(), max_step: settings.max_step };
    Path::new(system, route, &[], Vec::new(), x, weak)
}

/// Solves at `angular_frequency` with the response that `control` holds: from equivalent linearisation, and where that
/// fails along the level from a weak excitation up to the amplitude held.
fn held(
    system: &mut dyn PeriodicSystem,
    angular_frequency: f64,
    control: &Control,
    settings: &CurveSettings,
) -> Result<(Vec<f64>, Operating), HarmonicError> {
    const EXPANSIONS: usize = 6;
    let nothing = HarmonicError::InvalidInput("nothing is held");
    let (Control::Held { node, order, derivative, amplitude }, Some(mut condition)) =
        (*control, condition(control))
    else {
        return Err(nothing);
    };
    let wanted = Wanted {
        node,
        order,
        amplitude: amplitude / (order as f64 * angular_frequency).powi(derivative as i32),
    };
    let (mut x, mut at) = wanted.guess(system, angular_frequency)?;
    let guessed = at.level;
    let mut solve_held = |system: &mut dyn PeriodicSystem, x: &mut [f64], at: &mut Operating| {
        let mut all: [&mut dyn Condition; 1] = [&mut condition];
        solve(system, x, at, &[Scalar::Level], &mut all, &settings.stopping())
    };
    system.forget();
    // A negative level is the excitation half a period later: a solution, but not the one meant.
    if solve_held(system, &mut x, &mut at).is_ok() && at.level > 0.0 {
        return Ok((x, at));
    }
    let mut top = 4.0 * guessed;
    for _ in 0..EXPANSIONS {
        let start = Operating::forced(angular_frequency, guessed);
        let path = up(system, start, WEAK * guessed, top, settings)?;
        if let Some((mut x, mut at)) = wanted.reached(path, settings)? {
            solve_held(system, &mut x, &mut at)?;
            return Ok((x, at));
        }
        top *= 4.0;
    }
    Err(HarmonicError::NotConverged { residual: f64::INFINITY, iterations: settings.max_points })
}

/// A response to be held: amplitude (m) of a node's harmonic.
struct Wanted {
    node: usize,
    order: usize,
    amplitude: f64,
}

impl Wanted {
    /// The amplitude at `x` and `at`.
    fn found(
        &self,
        system: &mut dyn PeriodicSystem,
        x: &[f64],
        at: &Operating,
    ) -> Result<f64, HarmonicError> {
        system.evaluate(x, at, &[Scalar::Level])?;
        let [cosine, sine] = system.output(self.node, self.order);
        Ok(cosine.hypot(sine))
    }

    /// Equivalent linearisation at about the level that it takes.
    fn guess(
        &self,
        system: &mut dyn PeriodicSystem,
        angular_frequency: f64,
    ) -> Result<(Vec<f64>, Operating), HarmonicError> {
        const ROUNDS: usize = 30;
        let mut x = vec![0.0; system.unknowns()];
        let mut at = Operating::forced(angular_frequency, 1.0);
        for _ in 0..ROUNDS {
            system.guess(&at, &mut x)?;
            let found = self.found(system, &x, &at)?;
            if !(found > 0.0 && found.is_finite()) {
                return Err(HarmonicError::InvalidInput("the excitation does not move what is held"));
            }
            // The level follows in proportion, tamed for responses that grow suddenly.
            let factor = (self.amplitude / found).clamp(1e-6, 1e6);
            at.level *= if (0.5..2.0).contains(&factor) { factor.sqrt() } else { factor };
            if (factor - 1.0).abs() < 0.02 {
                break;
            }
        }
        Ok((x, at))
    }

    /// The first response on a path along the level that has the amplitude.
    fn reached(
        &self,
        mut path: Path,
        settings: &CurveSettings,
    ) -> Result<Option<(Vec<f64>, Operating)>, HarmonicError> {
        for _ in 0..settings.max_points.min(MOST_POINTS) {
            let advance = path.advance(&mut |_, _, _, _| Ok(Verdict::Keep(0.0)))?;
            if advance == Advance::Stuck {
                break;
            }
            let (x, at) = (path.present.x.clone(), path.present.at);
            if self.found(path.system, &x, &at)? >= self.amplitude {
                return Ok(Some((x, at)));
            }
            if advance != Advance::Going {
                break;
            }
        }
        Ok(None)
    }
}
