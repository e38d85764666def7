//! Two harmonics of the motion held at once by a force of two tones.

use std::f64::consts::TAU;

use crate::harmonic::balance::assembly::Assembly;
use crate::harmonic::balance::modal::Balance;
use crate::harmonic::continuation::{Advance, Location, Path, Route, Verdict};
use crate::harmonic::newton::Point;
use crate::harmonic::newton::condition::{HeldAmplitude, HeldRatio};
use crate::harmonic::newton::problem::{Condition, Stopping, solve};
use crate::harmonic::newton::system::{Operating, PeriodicSystem, Scalar};
use crate::harmonic::{CurveSettings, HarmonicError};

/// Force (N) of a tone under which the system is as good as linear, and the response tells how large the held one is about.
const WEAK: f64 = 1e-4;
/// Where the way to the amplitudes wanted begins, as a fraction of them, and its shortest step.
const FIRST: f64 = 0.05;
const SHORTEST: f64 = 1e-3;
/// Newton steps for one place on the way.
const MOST_ITERATIONS: usize = 12;
/// Harmonics on the way; the end is then solved with as many as are wanted.
const HARMONICS_ON_THE_WAY: usize = 15;
/// Points of a way around folds, and how many times the tones may grow on it.
const MOST_POINTS: usize = 2000;
const FARTHEST: f64 = 100.0;

/// A harmonic of the acceleration that is held, by a tone of the force of the same order.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HeldTone {
    /// Which harmonic, at least 1.
    pub order: usize,
    /// Amplitude of the acceleration (m/s²).
    pub amplitude: f64,
    /// Phase (rad) of the tone of the force: `sin(order ωt + phase)`.
    pub phase: f64,
}

/// A response of which two harmonics are held.
#[derive(Debug, Clone, PartialEq)]
pub struct DualTone {
    /// The response; its level is the force of the first tone, its parameter that of the second.
    pub point: Point,
    /// Amplitudes of both tones of the force (N).
    pub force: [f64; 2],
}

/// The response at `angular_frequency` (rad/s) of which two harmonics of the acceleration of node `node` (as
/// [`Assembly::nodes`] counts) are held, as a dual-mode test does. The waveform of `assembly` plays no part.
///
/// From weak tones, where the system is linear, the amplitudes are raised together, with few harmonics.
///
/// # Errors
/// [`HarmonicError::InvalidInput`] for arguments that do not fit, a system without modal coordinates;
/// [`HarmonicError::NotConverged`] where the amplitudes are out of reach.
pub fn dual_tone_response(
    assembly: &Assembly,
    angular_frequency: f64,
    node: usize,
    tones: [HeldTone; 2],
    settings: &CurveSettings,
) -> Result<DualTone, HarmonicError> {
    check(assembly, angular_frequency, node, &tones, settings)?;
    let mut driven = assembly.clone();
    driven.waveform = tones[0].waveform();
    driven.second_waveform = tones[1].waveform();
    driven.check()?;
    settings.check()?;
    driven.check_excitation(settings)?;
    let held = Held { node, tones };
    let enough = tones.iter().map(|tone| tone.order).fold(HARMONICS_ON_THE_WAY, usize::max);
    let few = CurveSettings { harmonics: settings.harmonics.min(enough), ..*settings };
    let mut coarse = Balance::new(&driven, few.harmonics, few.method)?;
    let mut fine = Balance::new(&driven, settings.harmonics, settings.method)?;
    let end = held.reached(&mut coarse, angular_frequency, &few).and_then(|(x, mut at, effort)| {
        let mut refined = coarse.refined(&x, &fine);
        let more = held.hold(&mut fine, &mut refined, &mut at, settings)?;
        Ok((refined, at, effort + more))
    });
    let (x, at, effort) = match end {
        // With few it ends elsewhere: all the way with many.
        Err(error) if error.is_of_the_step() && few.harmonics < settings.harmonics => {
            held.reached(&mut fine, angular_frequency, settings)?
        }
        end => end?,
    };
    let mut point = fine.describe(&x, &at)?;
    point.iterations = effort;
    Ok(DualTone { point, force: [at.level, at.parameter] })
}

/// What is held, and where.
struct Held {
    node: usize,
    tones: [HeldTone; 2],
}

impl Held {
    /// The response with the whole amplitudes, from weak tones on, and the Newton steps it took.
    fn reached(
        &self,
        system: &mut Balance,
        angular_frequency: f64,
        settings: &CurveSettings,
    ) -> Result<(Vec<f64>, Operating, usize), HarmonicError> {
        let Self { node, tones } = self;
        let mut x = vec![0.0; system.unknowns()];
        let mut at = Operating { parameter: WEAK, ..Operating::forced(angular_frequency, WEAK) };
        system.guess(&at, &mut x)?;
        solve(system, &mut x, &mut at, &[], &mut [], &settings.stopping())?;
        let acceleration = |tone: &HeldTone, system: &mut dyn PeriodicSystem| {
            let [c, s] = system.output(*node, tone.order);
            (tone.order as f64 * angular_frequency).powi(2) * c.hypot(s)
        };
        let [first, second] = [0, 1].map(|k| WEAK * tones[k].amplitude / acceleration(&tones[k], system));
        // The linear response grows with its tones: to the beginning of the way in proportion.
        (at.level, at.parameter) = (FIRST * first, FIRST * second);
        system.guess(&at, &mut x)?;
        let (effort, reached) = self.raise(system, &mut x, &mut at, settings)?;
        let effort =
            if reached { effort } else { effort + self.follow(system, &mut x, &mut at, settings)? };
        Ok((x, at, effort))
    }

    /// The response with the whole amplitudes near `x` and `at`; the Newton steps it took.
    fn hold(
        &self,
        system: &mut dyn PeriodicSystem,
        x: &mut [f64],
        at: &mut Operating,
        settings: &CurveSettings,
    ) -> Result<usize, HarmonicError> {
        let [mut first, mut second] = self.conditions(1.0);
        let mut held: [&mut dyn Condition; 2] = [&mut first, &mut second];
        let free = [Scalar::Level, Scalar::Parameter];
        Ok(solve(system, x, at, &free, &mut held, &settings.stopping())?.iterations)
    }

    /// Conditions for `fraction` of both amplitudes.
    fn conditions(&self, fraction: f64) -> [HeldAmplitude; 2] {
        self.tones.map(|tone| HeldAmplitude::new(self.node, tone.order, 2, fraction * tone.amplitude))
    }

    /// Raises both amplitudes from [`FIRST`] to the whole, as long as the tones grow smoothly with them; returns the Newton steps it
    /// took and whether the end was reached.
    fn raise(
        &self,
        system: &mut dyn PeriodicSystem,
        x: &mut Vec<f64>,
        at: &mut Operating,
        settings: &CurveSettings,
    ) -> Result<(usize, bool), HarmonicError> {
        let stopping = Stopping { max_iterations: MOST_ITERATIONS, ..settings.stopping() };
        let (mut done, mut step, mut iterations) = (0.0, FIRST, 0);
        // The last two places give the direction to the next.
        let mut before: Option<(f64, Vec<f64>, Operating)> = None;
        while done < 1.0 {
            let next = f64::min(done + step, 1.0);
            let (mut trial, mut there) = (x.clone(), *at);
            if let Some((earlier, x_before, at_before)) = &before {
                let ahead = (next - done) / (done - earlier);
                trial.iter_mut().zip(x_before).for_each(|(x, before)| *x += ahead * (*x - before));
                there.level += ahead * (at.level - at_before.level);
                there.parameter += ahead * (at.parameter - at_before.parameter);
            }
            let [mut first, mut second] = self.conditions(next);
            let mut held: [&mut dyn Condition; 2] = [&mut first, &mut second];
            let free = [Scalar::Level, Scalar::Parameter];
            match solve(system, &mut trial, &mut there, &free, &mut held, &stopping) {
                Ok(effort) => {
                    iterations += effort.iterations;
                    let place = (done > 0.0).then(|| (done, std::mem::take(x), *at));
                    (before, *x, *at, done) = (place, trial, there, next);
                    step *= if effort.iterations <= 5 { 2.0 } else { 1.0 };
                }
                Err(error) if !error.is_of_the_step() || done == 0.0 && step < SHORTEST => return Err(error),
                Err(_) if step < SHORTEST => return Ok((iterations, false)),
                Err(_) => step *= 0.5,
            }
        }
        Ok((iterations, true))
    }

    /// Follows the responses whose two harmonics keep their ratio by arc length from `x` and `at` on, around folds, to the first
    /// of the amplitudes wanted; returns the Newton steps it took.
    fn follow(
        &self,
        system: &mut dyn PeriodicSystem,
        x: &mut Vec<f64>,
        at: &mut Operating,
        settings: &CurveSettings,
    ) -> Result<usize, HarmonicError> {
        let Self { node, tones: [first, second] } = self;
        let of = |tone: &HeldTone| tone.amplitude / (tone.order as f64 * at.angular_frequency).powi(2);
        let wanted = of(first);
        let ratio =
            HeldRatio { node: *node, orders: [first.order, second.order], amplitudes: [wanted, of(second)] };
        let ahead = |system: &mut dyn PeriodicSystem| {
            let [c, s] = system.output(*node, first.order);
            c.hypot(s) / wanted - 1.0
        };
        let route = Route {
            along: Scalar::Level,
            from: at.level,
            to: FARTHEST * at.level,
            stopping: settings.stopping(),
            max_step: settings.max_step,
        };
        let mut path = Path::new(system, route, &[Scalar::Parameter], vec![Box::new(ratio)], x.clone(), *at)?;
        let mut iterations = 0;
        let mut passed = -1.0;
        for _ in 0..MOST_POINTS {
            let before = passed;
            let advance = path.advance(&mut |system, _, _, _| {
                passed = ahead(system);
                Ok(Verdict::Keep(0.0))
            })?;
            iterations += path.present.iterations;
            if passed >= 0.0 {
                let found = path.locate((before, passed), &mut |system, _| ahead(system));
                let Location { x: there, at: then, .. } = found.unwrap_or_else(|_| path.present.clone());
                drop(path);
                (*x, *at) = (there, then);
                return Ok(iterations + self.hold(system, x, at, settings)?);
            }
            if advance != Advance::Going {
                break;
            }
        }
        Err(HarmonicError::NotConverged { residual: -passed, iterations })
    }
}

impl HeldTone {
    /// Coefficients of the tone of unit amplitude.
    fn waveform(&self) -> Vec<f64> {
        let mut waveform = vec![0.0; 2 * self.order + 1];
        let (sine, cosine) = (self.phase % TAU).sin_cos();
        (waveform[2 * self.order - 1], waveform[2 * self.order]) = (sine, cosine);
        waveform
    }
}

fn check(
    assembly: &Assembly,
    angular_frequency: f64,
    node: usize,
    tones: &[HeldTone; 2],
    settings: &CurveSettings,
) -> Result<(), HarmonicError> {
    let refuse = |message| Err(HarmonicError::InvalidInput(message));
    let positive = |value: f64| value > 0.0 && value.is_finite();
    if !positive(angular_frequency) || tones.iter().any(|tone| !positive(tone.amplitude)) {
        return refuse("the angular frequency and the amplitudes held must be positive");
    }
    if tones.iter().any(|tone| !(1..=settings.harmonics).contains(&tone.order) || !tone.phase.is_finite())
        || tones[0].order == tones[1].order
    {
        return refuse("two different harmonics of the response can be held");
    }
    if assembly.is_condensed() {
        return refuse("two tones are held of a system in modal coordinates alone");
    }
    if node >= assembly.nodes().len() {
        return refuse("there is no such node to hold");
    }
    Ok(())
}
