//! Nonlinear modes: free vibrations whose losses an artificial negative damping makes good.
//!
//! The extended periodic motion concept (M. Krack, *Nonlinear modal analysis of nonconservative systems*,
//! Computers and Structures 154 (2015) 59–71): `M q̈ + (C − 2 ζ Ω M) q̇ + K q + Σ Bᵀ T = 0` has a periodic
//! solution for every amplitude, with the mode's frequency Ω, damping ratio ζ and shape, harmonics included.
//! Where ζ is small and modes are apart, the resonances of the forced structure lie on it.

use super::{CurveSettings, HarmonicError};
use crate::harmonic::balance::assembly::Assembly;
use crate::harmonic::balance::condensed::Condensed;
use crate::harmonic::balance::modal::{Balance, Extent, Ports};
use crate::harmonic::newton::Point;
use crate::harmonic::newton::condition::{HeldAmplitude, Phase};
use crate::harmonic::newton::problem::{Condition, Newton};
use crate::harmonic::newton::system::{Operating, PeriodicSystem, Scalar};
use crate::harmonic::response::linear_resonances::at_rest;
use crate::harmonic::response::stepwise::{LastSolutions, StepwiseContinuation};
use crate::harmonic::response::tracker::{Solution, describe_by};
use crate::numeric::fourier::coefficient_count;
use crate::system::{Element, LinearStructure, Output, Row};

const FREE: [Scalar; 2] = [Scalar::AngularFrequency, Scalar::SelfExcitation];

/// Which mode, over which amplitudes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ModeRange {
    /// The mode, counted from 0 by the frequencies of the structure with its contacts as they are at rest
    /// (a friction contact sticks).
    pub mode: usize,
    /// The node whose first harmonic is the mode's amplitude. It must move in the mode.
    pub node: usize,
    /// Smallest and largest amplitude (m), both above zero, in either order: the first is where it starts.
    pub amplitudes: [f64; 2],
    /// Number of amplitudes, evenly spaced by ratio, ends included.
    pub points: usize,
}

/// A mode at one amplitude.
#[derive(Debug, Clone, PartialEq)]
pub struct ModePoint {
    /// Amplitude of the node's first harmonic (m).
    pub amplitude: f64,
    /// Ω (rad/s).
    pub angular_frequency: f64,
    /// ζ (1): of all losses, those of the structure and of the contacts.
    pub damping_ratio: f64,
    /// Energy that the contacts take per cycle (J).
    pub dissipated_energy: f64,
    /// The vibration, whose coefficients at the nodes are the mode's shape; the excitation's level is zero.
    pub point: Point,
}

/// A mode over its amplitudes: backbone, damping, shapes.
#[derive(Debug, Clone, PartialEq)]
pub struct NonlinearMode {
    /// Ω of the undamped structure with its contacts as they are at rest (rad/s).
    pub angular_frequency: f64,
    /// The points in the order of [`ModeRange::amplitudes`], as far as they were reached.
    pub points: Vec<ModePoint>,
    /// Why the rest is missing, if it is: no vibration was found, however small the step from the last one.
    pub lost: Option<HarmonicError>,
}

/// A nonlinear mode of a structure with contacts, without excitation.
///
/// ```
/// use std::sync::Arc;
/// use stickslip::contact::CubicSpring;
/// use stickslip::harmonic::{Assembly, CurveSettings, ModeRange, nonlinear_mode};
/// use stickslip::model::{Anchor, Mass, Oscillator, Spring};
/// let structure = Oscillator {
///     masses: vec![Mass { name: "m1".into(), mass: 1.0 }],
///     springs: vec![Spring { between: [Anchor::Ground, Anchor::Mass(0)], stiffness: 1.0, damping: 0.02 }],
///     contact: Some(0),
///     excitation: 0,
/// }
/// .structure()?;
/// let assembly = Assembly::new(structure.system(vec![(Arc::new(CubicSpring::new(0.0, 1.0)?), 0.0)]));
/// let range = ModeRange { mode: 0, node: 0, amplitudes: [0.01, 1.0], points: 20 };
/// let mode = nonlinear_mode(&assembly, &range, &CurveSettings::default(), &mut |_| true)?;
/// assert!((mode.points[0].angular_frequency - 1.0).abs() < 1e-4);
/// assert!(mode.points[19].angular_frequency > 1.3);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`HarmonicError::InvalidInput`] for arguments that do not fit, or a node that does not move in the mode;
/// [`HarmonicError::Structure`] for a structure whose modes cannot be computed; the other kinds where
/// there is no vibration of the first amplitude.
///
/// `on_point` sees every point, and ends the mode there by `false`.
pub fn nonlinear_mode(
    assembly: &Assembly,
    range: &ModeRange,
    settings: &CurveSettings,
    on_point: &mut dyn FnMut(&ModePoint) -> bool,
) -> Result<NonlinearMode, HarmonicError> {
    let amplitudes = range.checked()?;
    assembly.check()?;
    settings.check()?;
    let acts = |element: &Element| !matches!(element, Element::Outside { .. });
    if !assembly.system.elements.iter().any(acts) {
        return Err(HarmonicError::InvalidInput("a structure without contacts has linear modes only"));
    }
    let mut structure = assembly.system.linear_part();
    if !assembly.is_condensed() {
        let driven = Output { name: "excitation".into(), row: structure.excitation.clone() };
        structure.outputs.push(driven);
        if structure.contacts.is_empty() {
            structure.contacts.push(Ports::of(&assembly.system).contact().row.clone());
        }
        return mode_in_modes(assembly, &structure, range, &amplitudes, (settings, on_point));
    }
    let start = LinearStart::new(&structure, at_rest(&assembly.system), range)?;
    // Free vibrations are poles of the structure's compliance where the contacts carry little; a damper moved
    // from the contacts to the structure, more than any friction damps, keeps the poles away.
    let mut system = Condensed::new(assembly, settings, start.angular_frequency / start.contact_fraction)?;
    let mut x = vec![0.0; system.unknowns()];
    let set = system.set();
    for (u, row) in x.chunks_exact_mut(set.len()).zip(&structure.contacts) {
        if let Some(place) = set.place(1) {
            u[place] = start.displacement(row) * amplitudes[0];
        }
    }
    follow(&mut system, &start, x, range.node, &amplitudes, (settings, on_point))
}

/// Settings, and who sees the points and may end the mode.
type Watched<'w> = (&'w CurveSettings, &'w mut dyn FnMut(&ModePoint) -> bool);

/// A nonlinear mode of a system that keeps its modal coordinates.
fn mode_in_modes(
    assembly: &Assembly,
    structure: &LinearStructure,
    range: &ModeRange,
    amplitudes: &[f64],
    (settings, on_point): Watched<'_>,
) -> Result<NonlinearMode, HarmonicError> {
    let start = LinearStart::new(structure, at_rest(&assembly.system), range)?;
    // As for a condensed system, but for the damper: it sits in the mode that takes most part.
    let strongest = start.shape.iter().enumerate().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()));
    let mode = strongest.map_or(0, |(mode, _)| mode);
    let ports = Ports::of(&assembly.system);
    let arm = ports.contact().row.iter().filter(|(i, _)| *i == mode).map(|(_, value)| value).sum();
    let harmonics = settings.harmonics;
    let extent = Extent { harmonics, contact: 2 * harmonics, ports: ports.with(Balance::shifted(mode, arm)) };
    let mut system = Balance::with(assembly, &[], &extent, settings.method, None)?;
    system.shift_damping(mode, start.angular_frequency);
    let count = coefficient_count(harmonics);
    let mut modal = vec![0.0; count * start.shape.len()];
    for (mode, fraction) in modal.chunks_exact_mut(count).zip(&start.shape) {
        mode[1] = fraction * amplitudes[0];
    }
    let mut force = vec![0.0; coefficient_count(2 * harmonics)];
    if let (true, Some(stiffness)) = (system.has_contact(), at_rest(&assembly.system).next()) {
        force[1] = stiffness * start.displacement(&structure.contacts[0]) * amplitudes[0];
    }
    let x = system.unknowns_of(&modal, &force);
    follow(&mut system, &start, x, range.node, amplitudes, (settings, on_point))
}

/// The mode over its amplitudes, from the unknowns `x` of the linear one of the first amplitude.
fn follow(
    system: &mut dyn PeriodicSystem,
    start: &LinearStart,
    x: Vec<f64>,
    node: usize,
    amplitudes: &[f64],
    (settings, on_point): Watched<'_>,
) -> Result<NonlinearMode, HarmonicError> {
    let at = Operating {
        angular_frequency: start.angular_frequency,
        level: 0.0,
        self_excitation: start.damping_ratio,
        parameter: 0.0,
    };
    let first = Solution { x, at };
    let mut vibration = FreeVibration { system, settings: *settings, newton: Newton::default(), node, first };
    let mut reached = LastSolutions::new();
    let mut mode =
        NonlinearMode { angular_frequency: start.angular_frequency, points: Vec::new(), lost: None };
    for amplitude in amplitudes {
        match vibration.reach(*amplitude, &mut reached) {
            Ok(point) => {
                let point = ModePoint {
                    amplitude: *amplitude,
                    angular_frequency: point.angular_frequency,
                    damping_ratio: reached[0].1.at.self_excitation,
                    dissipated_energy: point.dissipated_energy(),
                    point,
                };
                let goes_on = on_point(&point);
                mode.points.push(point);
                if !goes_on {
                    break;
                }
            }
            Err(error) if !mode.points.is_empty() && error.is_of_the_step() => {
                mode.lost = Some(error);
                break;
            }
            Err(error) => return Err(error),
        }
    }
    Ok(mode)
}

impl ModeRange {
    /// The amplitudes.
    fn checked(&self) -> Result<Vec<f64>, HarmonicError> {
        if !self.amplitudes.iter().all(|a| *a > 0.0 && a.is_finite()) {
            return Err(HarmonicError::InvalidInput("a mode's amplitudes must be positive"));
        }
        if self.points == 0 {
            return Err(HarmonicError::InvalidInput("a mode needs at least one amplitude"));
        }
        let [first, last] = self.amplitudes;
        let spaces = (self.points - 1).max(1) as f64;
        let amplitude = |k: usize| match k {
            0 => first,
            k if k + 1 == self.points => last,
            k => first * (last / first).powf(k as f64 / spaces),
        };
        Ok((0..self.points).map(amplitude).collect())
    }
}

/// The mode of the structure with its contacts linearised at rest.
struct LinearStart {
    angular_frequency: f64,
    damping_ratio: f64,
    /// Degrees of freedom where the node's displacement is 1.
    shape: Vec<f64>,
    /// Sum of the squares of the contacts' displacements in the mode of unit modal mass (1/kg).
    contact_fraction: f64,
}

impl LinearStart {
    fn new(
        structure: &LinearStructure,
        stiffness: impl Iterator<Item = f64>,
        range: &ModeRange,
    ) -> Result<Self, HarmonicError> {
        const STILL: f64 = 1e-9;
        let Some(output) = structure.outputs.get(range.node) else {
            return Err(HarmonicError::InvalidInput("the structure has no such node"));
        };
        let mut stuck = structure.clone();
        stuck.stiffness.extend(structure.along_contacts(stiffness));
        let modes = stuck.natural_modes()?;
        let Some(angular_frequency) = modes.angular_frequency.get(range.mode).copied() else {
            return Err(HarmonicError::InvalidInput("the structure has no such mode"));
        };
        if angular_frequency == 0.0 {
            return Err(HarmonicError::InvalidInput(
                "a body that is free to move has no vibration in this mode",
            ));
        }
        let shape = modes.shapes.column(range.mode);
        let of = |row: &Row| row.iter().map(|(i, factor)| factor * shape[*i]).sum::<f64>();
        let node = of(&output.row);
        if node.abs() <= STILL * shape.amax() {
            return Err(HarmonicError::InvalidInput("the node does not move in this mode"));
        }
        let contact_fraction: f64 = structure.contacts.iter().map(|row| of(row).powi(2)).sum();
        if contact_fraction.sqrt() <= STILL * shape.amax() {
            return Err(HarmonicError::InvalidInput("no contact moves in this mode: it is linear"));
        }
        let rate: f64 = structure.damping.iter().map(|(i, j, c)| shape[*i] * c * shape[*j]).sum();
        Ok(Self {
            angular_frequency,
            damping_ratio: 0.5 * rate / angular_frequency,
            shape: shape.iter().map(|x| x / node).collect(),
            contact_fraction,
        })
    }

    /// Displacement of a row where that of the node is 1.
    fn displacement(&self, row: &Row) -> f64 {
        row.iter().map(|(i, factor)| factor * self.shape[*i]).sum()
    }
}

/// Carries a free vibration from amplitude to amplitude.
struct FreeVibration<'s> {
    system: &'s mut (dyn PeriodicSystem + 's),
    settings: CurveSettings,
    newton: Newton,
    node: usize,
    /// Where to look at the first amplitude.
    first: Solution,
}

impl FreeVibration<'_> {
    /// The vibration just found. A free vibration may begin at any phase, so that the balance alone does not tell
    /// how it answers to harmonics left out: frequency, damping, amplitude and phase take part.
    fn describe(&mut self, solution: &Solution) -> Result<Point, HarmonicError> {
        let prepared = self.newton.prepare(self.system, &FREE);
        let newton = &self.newton;
        let mut right = Vec::new();
        describe_by(self.system, solution, &self.settings, &mut |change| {
            let unknowns = change.len();
            right.clear();
            right.extend(change.iter().map(|r| r / newton.scale()));
            right.resize(unknowns + FREE.len(), 0.0);
            if prepared && newton.solve_linear(&mut right) {
                change.copy_from_slice(&right[..unknowns]);
            } else {
                change.fill(f64::INFINITY);
            }
        })
    }

    /// The vibration at an amplitude: shape, frequency and damping on straight lines over its logarithm.
    fn predicted(amplitude: f64, reached: &LastSolutions) -> Option<Solution> {
        let (last_amplitude, last) = reached.first()?;
        let ratio = amplitude / last_amplitude;
        let mut start = last.clone();
        start.x.iter_mut().for_each(|x| *x *= ratio);
        if let Some((before_amplitude, before)) = reached.get(1)
            && before_amplitude != last_amplitude
        {
            let ahead = ratio.ln() / (last_amplitude / before_amplitude).ln();
            let ahead = ahead.clamp(-1.0, 2.0);
            let scale = amplitude / before_amplitude;
            start.x.iter_mut().zip(&before.x).for_each(|(x, b)| *x += ahead * (*x - scale * b));
            let line = |last: f64, before: f64| last + ahead * (last - before);
            start.at.angular_frequency = line(last.at.angular_frequency, before.at.angular_frequency)
                .clamp(0.9 * last.at.angular_frequency, 1.1 * last.at.angular_frequency);
            start.at.self_excitation = line(last.at.self_excitation, before.at.self_excitation);
        }
        Some(start)
    }
}

impl StepwiseContinuation for FreeVibration<'_> {
    fn parts(&mut self) -> (&mut dyn PeriodicSystem, &CurveSettings) {
        (&mut *self.system, &self.settings)
    }

    fn start(&mut self, amplitude: f64, reached: &LastSolutions) -> Result<Solution, HarmonicError> {
        Ok(Self::predicted(amplitude, reached).unwrap_or_else(|| self.first.clone()))
    }

    fn solve(&mut self, amplitude: f64, solution: &mut Solution) -> Result<Point, HarmonicError> {
        let mut held = HeldAmplitude::new(self.node, 1, 0, amplitude);
        let mut phase = Phase::behind(self.node, 1, [1.0, 0.0], 0.0);
        let conditions: &mut [&mut dyn Condition] = &mut [&mut held, &mut phase];
        let Solution { x, at } = &mut *solution;
        let effort = self.newton.solve(self.system, x, at, &FREE, conditions, &self.settings.stopping())?;
        let mut point = self.describe(solution)?;
        point.iterations = effort.iterations;
        Ok(point)
    }
}
