//! Nonlinear modes: free vibrations whose losses an artificial negative damping makes good.
//!
//! The extended periodic motion concept (M. Krack, *Nonlinear modal analysis of nonconservative systems*,
//! Computers and Structures 154 (2015) 59–71): `M q̈ + (C − 2 ζ Ω M) q̇ + K q + Σ Bᵀ T = 0` has a periodic
//! solution for every amplitude, with the mode's frequency Ω, damping ratio ζ and shape, harmonics included.
//! Where ζ is small and modes are apart, the resonances of the forced structure lie on it.

mod held;
mod linear_start;
mod vibration;

use std::borrow::Cow;

use super::{CurveSettings, HarmonicError};
use crate::harmonic::balance::assembly::Assembly;
use crate::harmonic::balance::condensed::Condensed;
use crate::harmonic::balance::modal::{Balance, Extent, Ports};
use crate::harmonic::newton::Point;
use crate::harmonic::newton::problem::Newton;
use crate::harmonic::newton::system::{Operating, PeriodicSystem};
use crate::harmonic::response::linear_resonances::{at_rest, with_contacts};
use crate::harmonic::response::stepwise::{LastSolutions, StepwiseContinuation};
use crate::harmonic::response::tracker::Solution;
use crate::numeric::fourier::coefficient_count;
use crate::system::{Element, LinearStructure, Output};
use held::Held;
use linear_start::LinearStart;
use vibration::FreeVibration;

/// Fractions of the least amplitude from which a mode is followed.
const FROM_WEAK: [f64; 3] = [1e-3, 1e-2, 1e-1];
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
    let held = Held { mode: range.mode, node: range.node, derivative: 0, amplitudes: &amplitudes };
    mode_of(assembly, &held, settings, on_point)
}

/// The frequency (rad/s) and damping ratio of mode `mode` where the acceleration of `node` has each of the amplitudes
/// (m/s²): a mode as a table has it. Without a contact that moves they are those of the linear mode.
///
/// # Errors
/// As [`nonlinear_mode`]; what it says where an amplitude is not reached.
pub(crate) fn mode_at(
    assembly: &Assembly,
    mode: usize,
    node: usize,
    accelerations: &[f64],
    settings: &CurveSettings,
) -> Result<Vec<[f64; 2]>, HarmonicError> {
    let structure = with_contacts(assembly);
    let stuck = LinearStart::new(&structure, at_rest(&assembly.system), mode, node)?;
    if stuck.is_linear() {
        return Ok(vec![[stuck.angular_frequency, stuck.damping_ratio]; accelerations.len()]);
    }
    let mut ascending: Vec<f64> = accelerations.to_vec();
    ascending.sort_by(f64::total_cmp);
    let Some(least) = ascending.first().copied().filter(|least| *least > 0.0) else {
        return Err(HarmonicError::InvalidInput("a mode's amplitudes must be positive"));
    };
    // From where contacts stick.
    ascending.splice(0..0, FROM_WEAK.map(|fraction| fraction * least));
    let held = Held { mode, node, derivative: 2, amplitudes: &ascending };
    let found = mode_of(assembly, &held, settings, &mut |_| true)?;
    if let Some(error) = found.lost {
        return Err(error);
    }
    let at = |acceleration: &f64| {
        let point = found.points.iter().find(|point| point.amplitude == *acceleration);
        point.map_or([f64::NAN; 2], |point| [point.angular_frequency, point.damping_ratio])
    };
    Ok(accelerations.iter().map(at).collect())
}

/// Angular frequency (rad/s) of mode `mode` with the contacts as they are at rest, and the displacements of the system's
/// coordinates where that of `node` is 1.
///
/// # Errors
/// A structure whose modes cannot be computed, or a node that does not move in the mode.
pub(crate) fn mode_at_rest(
    assembly: &Assembly,
    mode: usize,
    node: usize,
) -> Result<(f64, Vec<f64>), HarmonicError> {
    let start = LinearStart::new(&with_contacts(assembly), at_rest(&assembly.system), mode, node)?;
    Ok((start.angular_frequency, start.shape))
}

/// The mode whose frequency, with the contacts as they are at rest, is nearest to `angular_frequency` (rad/s).
///
/// # Errors
/// A structure whose modes cannot be computed, or that has none but those of a free body.
pub(crate) fn mode_near(assembly: &Assembly, angular_frequency: f64) -> Result<usize, HarmonicError> {
    let mut stuck = with_contacts(assembly);
    stuck.stiffness.extend(stuck.along_contacts(at_rest(&assembly.system)));
    let modes = stuck.natural_modes()?;
    let apart = |natural: f64| (natural / angular_frequency).ln().abs();
    let vibrating = modes.angular_frequency.iter().enumerate().filter(|(_, natural)| **natural > 0.0);
    let nearest = vibrating.min_by(|a, b| apart(*a.1).total_cmp(&apart(*b.1)));
    nearest.map(|(mode, _)| mode).ok_or(HarmonicError::InvalidInput("the structure has no vibration"))
}

fn mode_of(
    assembly: &Assembly,
    held: &Held,
    settings: &CurveSettings,
    on_point: &mut dyn FnMut(&ModePoint) -> bool,
) -> Result<NonlinearMode, HarmonicError> {
    assembly.check()?;
    settings.check()?;
    // Near the free vibrations of what hangs at the contact the port hardly moves: coordinates of its own tell more.
    let expanded = match assembly.system.expanded() {
        Cow::Owned(system) => Cow::Owned(Assembly { system, ..assembly.clone() }),
        Cow::Borrowed(_) => Cow::Borrowed(assembly),
    };
    let assembly = &*expanded;
    let acts = |element: &Element| !matches!(element, Element::Outside { .. });
    if !assembly.system.elements.iter().any(acts) {
        return Err(HarmonicError::InvalidInput("a structure without contacts has linear modes only"));
    }
    let mut structure = with_contacts(assembly);
    if !assembly.is_condensed() {
        let driven = Output { name: "excitation".into(), row: structure.excitation.clone() };
        structure.outputs.push(driven);
        return mode_in_modes(assembly, &structure, held, (settings, on_point));
    }
    let start = LinearStart::moving(&structure, at_rest(&assembly.system), held)?;
    // Free vibrations are poles of the structure's compliance where the contacts carry little; a damper moved
    // from the contacts to the structure, more than any friction damps, keeps the poles away.
    let mut system = Condensed::new(assembly, settings, start.angular_frequency / start.contact_fraction)?;
    let mut x = vec![0.0; system.unknowns()];
    let set = system.set();
    for (u, row) in x.chunks_exact_mut(set.len()).zip(&structure.contacts) {
        if let Some(place) = set.place(1) {
            u[place] = start.displacement(row) * held.first(start.angular_frequency);
        }
    }
    follow(&mut system, &start, x, held, (settings, on_point))
}

/// Settings, and who sees the points and may end the mode.
type Watched<'w> = (&'w CurveSettings, &'w mut dyn FnMut(&ModePoint) -> bool);

/// A nonlinear mode of a system that keeps its modal coordinates.
fn mode_in_modes(
    assembly: &Assembly,
    structure: &LinearStructure,
    held: &Held,
    (settings, on_point): Watched<'_>,
) -> Result<NonlinearMode, HarmonicError> {
    let start = LinearStart::moving(structure, at_rest(&assembly.system), held)?;
    let first = held.first(start.angular_frequency);
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
        mode[1] = fraction * first;
    }
    let mut force = vec![0.0; coefficient_count(2 * harmonics)];
    if let (true, Some(stiffness)) = (system.has_contact(), at_rest(&assembly.system).next()) {
        force[1] = stiffness * start.displacement(&structure.contacts[0]) * first;
    }
    let x = system.unknowns_of(&modal, &force, start.angular_frequency);
    follow(&mut system, &start, x, held, (settings, on_point))
}

/// The mode over its amplitudes, from the unknowns `x` of the linear one of the first amplitude.
fn follow(
    system: &mut dyn PeriodicSystem,
    start: &LinearStart,
    x: Vec<f64>,
    held: &Held,
    (settings, on_point): Watched<'_>,
) -> Result<NonlinearMode, HarmonicError> {
    let at = Operating {
        angular_frequency: start.angular_frequency,
        level: 0.0,
        self_excitation: start.damping_ratio,
        parameter: 0.0,
    };
    let first = Solution { x, at };
    let Held { node, derivative, amplitudes, .. } = *held;
    let newton = Newton::default();
    let mut vibration = FreeVibration { system, settings: *settings, newton, node, derivative, first };
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
            Err(HarmonicError::Interrupted) if !mode.points.is_empty() => break,
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
