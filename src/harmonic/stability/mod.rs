//! Stability of periodic responses: Floquet multipliers of the variational equation along them.
//!
//! A small disturbance δq of a periodic motion obeys `M δq̈ + C δq̇ + K δq + Σ Bᵢᵀ δTᵢ = 0`, where δTᵢ is
//! what the contact answers to `δuᵢ = Bᵢ δq` and to what its memory was disturbed by. The eigenvalues of
//! the map over one period are the multipliers; the motion is stable where all are smaller than one.
//!
//! - Sliders without play on a structure that gains energy nowhere, and no contact at all (`monotone`): always stable, no
//!   check is needed. Motions along which no slider changes its branch: the poles of the linear structure decide.
//! - Other piecewise-linear laws (`regimes`): the displacement determines when each slider sticks; each regime is
//!   a linear system, solved to rounding by the exponential of its matrix. Sliders remember the displacement of their last reversal, so that a
//!   disturbance of memory has one component per turning point, whatever the number of sliders.
//! - Any other law (`tangents`): the tangents of its steps on a grid that meets all turning points,
//!   the structure exactly between two, extrapolated (Romberg) until the map settles. So is a system in modal coordinates,
//!   whose ports turn with the motion, whatever the laws.
//!
//! What a disturbance sees (`disturbed`) is a constant structure and what its contacts answer (`feedback`).
//!
//! A slider that never slips keeps any position; that neutral direction is not counted.

mod budget;
mod disturbed;
mod feedback;
mod history;
mod impulse;
mod monotone;
mod regimes;
mod signal;
mod step;
mod tangents;

use nalgebra::{Complex, DMatrix};

use super::HarmonicError;
use super::modal_system::ModalSystem;
use crate::contact::Slider;
use crate::system::{Element, LinearStructure, System};
use crate::time::exact::multipliers;
use crate::time::exact::system::System as Exact;
use crate::time::{LoadedContact, OscillatorError};
use budget::Budget;
use disturbed::Disturbed;

/// Most degrees of freedom for which multipliers are computed.
const LARGEST: usize = 60;

/// How far beyond the unit circle a multiplier may lie by rounding, that of the map and the root of it that is left
/// of two multipliers that fall together. Where nothing damps, all lie on the circle, and disturbances neither grow
/// nor die out: without this, rounding would decide.
const ON_THE_CIRCLE: f64 = 1e-8;

/// Floquet multipliers of a periodic motion.
#[derive(Debug, Clone, PartialEq)]
pub struct Multipliers {
    /// The multipliers, by falling magnitude. Zeros of directions that are forgotten at once are among them.
    pub values: Vec<Complex<f64>>,
}

impl Multipliers {
    /// Whether no disturbance grows: by more than 1e-8 of itself in a period, which can be distinguished from
    /// rounding.
    pub fn stable(&self) -> bool {
        self.values.iter().all(|multiplier| multiplier.norm() <= 1.0 + ON_THE_CIRCLE)
    }
}

/// Multipliers of the periodic motion of `structure` at `angular_frequency` (rad/s) whose contacts move by
/// the Fourier coefficients `displacement` (m), `[a0, c1, s1, …]` per contact in the structure's order.
///
/// # Errors
/// Lists that do not fit the structure, numbers that are not finite, a map that does not settle.
///
/// ```
/// use stickslip::harmonic::stability::floquet;
/// use stickslip::system::{LinearStructure, Output};
/// let structure = LinearStructure {
///     size: 1,
///     mass: vec![(0, 0, 1.0)],
///     damping: vec![(0, 0, 0.1)],
///     stiffness: vec![(0, 0, 9.0)],
///     contacts: vec![],
///     excitation: vec![(0, 1.0)],
///     outputs: vec![Output { name: "m1".into(), row: vec![(0, 1.0)] }],
/// };
/// let found = floquet(&structure, &[], &[], 2.0)?;
/// // A disturbance decays as exp(−0.1 t / 2).
/// let period = std::f64::consts::TAU / 2.0;
/// assert!(found.stable() && (found.values[0].norm() - (-0.05 * period).exp()).abs() < 1e-9);
/// # Ok::<(), stickslip::time::OscillatorError>(())
/// ```
pub fn floquet(
    structure: &LinearStructure,
    contacts: &[LoadedContact],
    displacement: &[&[f64]],
    angular_frequency: f64,
) -> Result<Multipliers, OscillatorError> {
    let motion = Motion { structure, contacts, displacement, angular_frequency };
    Ok(Multipliers { values: motion.multipliers(&motion.system()?, &mut |_| false, Budget::unlimited())? })
}

/// Multipliers of the periodic motion of `system`, in modal coordinates, at `angular_frequency` (rad/s). Its modes move by
/// the Fourier coefficients `modes` (m √kg), `[a0, c1, s1, …]` mode after mode, and its laws, in the order of the elements,
/// by `displacement` (m): what a flexibility in series leaves of that of the port. Coordinates of resonators, in the
/// system's [`expanded`](System::expanded) form, come behind its own.
///
/// ```
/// use stickslip::harmonic::stability::floquet_in_modes;
/// use stickslip::system::{Core, System};
/// let system = System {
///     core: Core::Modal { angular_frequency: vec![330.0], damping_ratio: vec![0.003] },
///     shortening: vec![],
///     ports: vec![],
///     elements: vec![],
///     driven: vec![],
///     sensors: vec![],
/// };
/// let multipliers = floquet_in_modes(&system, &[0.0, 1e-3, 0.0], &[], 300.0)?;
/// let decay = (-0.003 * 330.0 * std::f64::consts::TAU / 300.0_f64).exp();
/// assert!((multipliers.values[0].norm() - decay).abs() < 1e-9);
/// # Ok::<(), stickslip::harmonic::HarmonicError>(())
/// ```
///
/// # Errors
/// A system without modal coordinates, lists that do not fit it, numbers that are not finite, a map that does not settle.
pub fn floquet_in_modes(
    system: &System,
    modes: &[f64],
    displacement: &[&[f64]],
    angular_frequency: f64,
) -> Result<Multipliers, HarmonicError> {
    let modal = ModalSystem::new(&system.expanded())?;
    let bent = bent(&modal, modes, displacement, angular_frequency)?;
    Ok(Multipliers { values: tangents::multipliers_of(&bent, &mut |_| false, Budget::unlimited())? })
}

/// Why the stability of a motion cannot be determined.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Undecided {
    /// The structure has more than 60 degrees of freedom, and contacts of other than sliders without play.
    TooLarge,
    /// The fastest motion of the structure goes round too often in a period: the multipliers would take a second or
    /// more.
    TooLong,
    /// The multipliers do not settle, or are not finite.
    NotSettled,
    /// The motion is no response: a free vibration that artificial damping sustains.
    NoResponse,
    /// A contact in two directions, or masses that move with ports: what disturbances of them do is not followed.
    TwoDirections,
}

impl From<OscillatorError> for Undecided {
    fn from(error: OscillatorError) -> Self {
        match error {
            OscillatorError::TooManySteps { .. } => Undecided::TooLong,
            _ => Undecided::NotSettled,
        }
    }
}

/// Whether the motion that [`floquet`] describes is stable. Sliders without play, as no contact at all, make every
/// motion stable, whatever the structure's size, unless it gains energy by itself.
///
/// # Errors
/// Why it cannot be determined.
pub fn decide(
    structure: &LinearStructure,
    contacts: &[LoadedContact],
    displacement: &[&[f64]],
    angular_frequency: f64,
) -> Result<bool, Undecided> {
    let motion = Motion { structure, contacts, displacement, angular_frequency };
    motion.check()?;
    if monotone::only_loses(structure, contacts) {
        return Ok(true);
    }
    if structure.size > LARGEST {
        return Err(Undecided::TooLarge);
    }
    let system = motion.system()?;
    if motion.has_sliders()
        && let Some(stiffness) = regimes::constant_stiffness(contacts, displacement)?
    {
        return poles_are_stable(structure, &system, &stiffness);
    }
    verdict(system.floats(), |enough| motion.multipliers(&system, enough, Budget::of_a_point()))
}

/// Whether no pole lies to the right of the imaginary axis, where the contacts are springs.
fn poles_are_stable(
    structure: &LinearStructure,
    system: &Exact,
    contacts: &[f64],
) -> Result<bool, Undecided> {
    /// Real part of a pole that is rounding, as a fraction of the fastest motion: two that fall together are off by the
    /// root of it.
    const ON_THE_AXIS: f64 = 1e-7;
    let mut stiffness = structure.stiffness.clone();
    stiffness.extend(structure.along_contacts(contacts.iter().copied()));
    if monotone::is_passive(structure, &stiffness) {
        return Ok(true);
    }
    let (n, rate) = (system.size, system.fastest());
    let (springs, dampers) = system.matrices();
    let mut map = DMatrix::zeros(2 * n, 2 * n);
    for i in 0..n {
        map[(i, n + i)] = rate;
        for j in 0..n {
            let held = system.contacts.iter().zip(contacts).map(|(b, k)| b[i] * k * b[j]).sum::<f64>();
            map[(n + i, j)] = -(springs[i * n + j] + held) / rate;
            map[(n + i, n + j)] = -dampers[i * n + j];
        }
    }
    let limit = ON_THE_AXIS * map.amax();
    let poles = multipliers(map).ok_or(Undecided::NotSettled)?;
    Ok(poles.iter().all(|pole| pole.re <= limit))
}

/// Whether the motion that [`floquet_in_modes`] describes is stable.
///
/// # Errors
/// Why it cannot be determined.
pub(crate) fn decide_modal(
    system: &ModalSystem,
    modes: &[f64],
    displacement: &[&[f64]],
    angular_frequency: f64,
) -> Result<bool, Undecided> {
    let bent = bent(system, modes, displacement, angular_frequency)?;
    let linear = system.elements.iter().all(|element| matches!(element, Element::Outside { .. }));
    if linear && system.damping_ratio.iter().all(|ratio| *ratio >= 0.0) {
        return Ok(true);
    }
    verdict(false, |enough| tangents::multipliers_of(&bent, enough, Budget::of_a_point()))
}

/// Tells whether multipliers are good enough.
type Enough<'e> = dyn FnMut(&[Complex<f64>]) -> bool + 'e;

/// Whether all multipliers are stable, computed only as accurately as the decision needs.
fn verdict(
    floats: bool,
    found: impl FnOnce(&mut Enough) -> Result<Vec<Complex<f64>>, OscillatorError>,
) -> Result<bool, Undecided> {
    /// Change of the largest multiplier from one map to a better one, as a fraction of its distance from the unit circle.
    const CLEAR: f64 = 0.1;
    /// What floats has two multipliers at one, which rounding drives apart by its root.
    const OF_FLOATING: f64 = 1e-4;
    let mut last = f64::NAN;
    let mut clear = |found: &[Complex<f64>]| {
        let largest = found.first().map_or(0.0, |first| first.norm());
        let change = (largest - std::mem::replace(&mut last, largest)).abs();
        change <= CLEAR * (largest - 1.0).abs()
    };
    let mut values = found(&mut clear)?;
    if floats {
        values.retain(|multiplier| (multiplier - 1.0).norm() > OF_FLOATING);
    }
    Ok(Multipliers { values }.stable())
}

/// A periodic motion of a linear structure.
struct Motion<'a> {
    structure: &'a LinearStructure,
    contacts: &'a [LoadedContact<'a>],
    displacement: &'a [&'a [f64]],
    angular_frequency: f64,
}

impl Motion<'_> {
    fn check(&self) -> Result<(), OscillatorError> {
        let expected = self.structure.contacts.len();
        for (name, found) in [("contacts", self.contacts.len()), ("displacement", self.displacement.len())] {
            if found != expected {
                return Err(OscillatorError::Length { name, expected, found });
            }
        }
        self.displacement.iter().try_for_each(|coefficients| check("displacement", coefficients))?;
        check_frequency(self.angular_frequency)
    }

    fn system(&self) -> Result<Exact, OscillatorError> {
        Exact::new(self.structure)
    }

    fn has_sliders(&self) -> bool {
        let mut sliders: Vec<Slider> = Vec::new();
        self.contacts.iter().all(|contact| contact.law.sliders(contact.normal_load, &mut sliders))
    }

    fn multipliers(
        &self,
        system: &Exact,
        enough: &mut Enough,
        budget: Budget,
    ) -> Result<Vec<Complex<f64>>, OscillatorError> {
        self.check()?;
        let Self { contacts, displacement, angular_frequency, .. } = *self;
        if self.has_sliders() {
            let map = regimes::monodromy(system, contacts, displacement, angular_frequency, budget)?;
            let diverged = OscillatorError::Diverged { time: std::f64::consts::TAU / angular_frequency };
            return multipliers(map).ok_or(diverged);
        }
        let motion = Disturbed::linear(system, contacts, displacement, angular_frequency);
        tangents::multipliers_of(&motion, enough, budget)
    }
}

/// A periodic motion in modal coordinates.
fn bent<'a>(
    system: &'a ModalSystem,
    modes: &'a [f64],
    displacement: &[&'a [f64]],
    angular_frequency: f64,
) -> Result<Disturbed<'a>, OscillatorError> {
    check_frequency(angular_frequency)?;
    check("modes", modes)?;
    displacement.iter().try_for_each(|coefficients| check("displacement", coefficients))?;
    let found = modes.len() % system.modes();
    if found != 0 {
        return Err(OscillatorError::Length { name: "modes", expected: 0, found });
    }
    let width = (modes.len() / system.modes()).max(1);
    Disturbed::in_modes(system, modes.chunks_exact(width).collect(), displacement, angular_frequency)
}

fn check(name: &'static str, coefficients: &[f64]) -> Result<(), OscillatorError> {
    if coefficients.is_empty() {
        return Err(OscillatorError::Length { name, expected: 1, found: 0 });
    }
    match coefficients.iter().find(|value| !value.is_finite()) {
        Some(value) => Err(OscillatorError::Input { name, value: *value }),
        None => Ok(()),
    }
}

fn check_frequency(value: f64) -> Result<(), OscillatorError> {
    if value > 0.0 && value.is_finite() {
        return Ok(());
    }
    Err(OscillatorError::Input { name: "angular_frequency", value })
}
