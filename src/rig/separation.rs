//! Whether a pin leaves its support while two harmonics are held, below which preload it begins to, and what follows in time.

use std::f64::consts::TAU;

use super::dual_mode::{DualMode, held, tones};
use super::error::RigError;
use crate::harmonic::Assembly;
use crate::model::Model;
use crate::numeric::fourier::value;
use crate::system::{Element, System};
use crate::time::ClassicalSteps;

/// Lowest preload that is tried, as a part of the rig's own; how near to the onset a search ends, and its steps at most.
const LOWEST: f64 = 0.02;
const NEAR: f64 = 1e-3;
const SEARCHED: usize = 20;
/// Phases of a period at which the least normal force is looked for.
const PHASES: usize = 1024;
/// Steps of a period in time: the highest of 20 modes needs them; and of how many one is kept.
const STEPS: usize = 4000;
const KEPT: usize = 10;

/// What holding two harmonics asks of the preload.
#[derive(Debug, Clone, PartialEq)]
pub struct Separation {
    /// Amplitudes of the acceleration held (m/s²).
    pub amplitudes: [f64; 2],
    /// Least force (N) that presses the pin on its support under the rig's own preload; not above zero where it parts.
    pub least_normal_force: f64,
    /// Preload (N) below which the pin leaves its support; `None` where it does not under any that was tried.
    pub onset: Option<f64>,
    /// Amplitudes of the two tones of the force (N) there; under the rig's own preload without one.
    pub forces: [f64; 2],
}

/// A motion in which the pin leaves its support and comes back, in time.
#[derive(Debug, Clone, PartialEq)]
pub struct Slap {
    /// Preload (N).
    pub preload: f64,
    /// Time (s) from rest on, at the steps that were kept.
    pub time: Vec<f64>,
    /// Force that presses the pin on its support (N), and its distance from there (m).
    pub normal_force: Vec<f64>,
    /// See `normal_force`.
    pub separation: Vec<f64>,
    /// How often it parted from its support.
    pub partings: usize,
    /// Energy that impacts took (J).
    pub impact_energy: f64,
}

/// At every pair of amplitudes of `test`, by harmonic balance: the least normal force, and the preload below which the pin leaves
/// its support. `build` makes the rig under a preload (N), of which `preload` is its own.
///
/// A preload under which no steady state is found counts as one under which the pin parts: let time tell, by [`slap_in_time`].
///
/// # Errors
/// What `build` says; amplitudes out of reach under the rig's own preload.
pub fn separation_on(
    build: &dyn Fn(f64) -> Result<System, RigError>,
    preload: f64,
    test: &DualMode,
) -> Result<Vec<Separation>, RigError> {
    let one = |amplitudes: &[f64; 2]| {
        let least = |preload: f64| least_normal_force(&build(preload)?, preload, test, *amplitudes);
        let (least_normal_force, forces) = least(preload)?;
        let mut found = Separation { amplitudes: *amplitudes, least_normal_force, onset: None, forces };
        // The normal force swings by about as much under any preload.
        let (mut open, mut closed, mut left) = (0.0_f64, preload, least_normal_force);
        for _ in 0..SEARCHED {
            if left <= NEAR * preload || closed - open <= NEAR * preload {
                found.onset = (left > 0.0).then_some(closed);
                break;
            }
            let next = (closed - left).max(0.5 * (open + closed));
            if next < LOWEST * preload {
                break;
            }
            match least(next) {
                Ok((least, forces)) if least > 0.0 => (closed, left, found.forces) = (next, least, forces),
                _ => open = next,
            }
        }
        Ok(found)
    };
    test.amplitudes.iter().map(one).collect()
}

/// The same of a pin rig that is a model, its contact included.
///
/// # Errors
/// As [`separation_on`]; a model without a contact.
pub fn separation_of(model: &Model, test: &DualMode) -> Result<Vec<Separation>, RigError> {
    let contact = model.contact.ok_or_else(|| RigError::Input("the model has no contact".into()))?;
    separation_on(&|preload| Ok(model.under_preload(preload).system()?), contact.normal_load, test)
}

/// The least force (N) that presses the pin on its support, and the tones of the force (N), while `amplitudes` are held.
fn least_normal_force(
    system: &System,
    preload: f64,
    test: &DualMode,
    amplitudes: [f64; 2],
) -> Result<(f64, [f64; 2]), RigError> {
    let held = held(&Assembly::new(system.clone()), test, amplitudes)?;
    let normal = held.point.contacts.get(1);
    let normal = normal.ok_or_else(|| RigError::Input("the rig has no contact in two directions".into()))?;
    let load = |k: usize| preload - value(&normal.force, TAU * k as f64 / PHASES as f64);
    Ok(((0..PHASES).map(load).fold(f64::INFINITY, f64::min), held.force))
}

/// The motion of `system` in time from rest, under two tones of these `forces` (N), over so many `periods` of `test`.
///
/// # Errors
/// A system without a contact in two directions, or one that the plainest scheme in time does not take.
pub fn slap_in_time(
    system: &System,
    forces: [f64; 2],
    test: &DualMode,
    periods: usize,
) -> Result<Slap, RigError> {
    let contact = system.elements.iter().find_map(|element| match element {
        Element::SlipSlap { contact, .. } => Some(contact),
        _ => None,
    });
    let contact =
        contact.ok_or_else(|| RigError::Input("the system has no contact in two directions".into()))?;
    let force = tones(forces);
    let mut steps = ClassicalSteps::new(system)?;
    let mut motion = steps.rest();
    let step = 1.0 / test.frequency / STEPS as f64;
    let mut slap = Slap {
        preload: contact.normal().preload(),
        time: Vec::new(),
        normal_force: Vec::new(),
        separation: Vec::new(),
        partings: 0,
        impact_energy: 0.0,
    };
    for k in 0..periods * STEPS {
        let apart = motion.contacts[0].separation > 0.0;
        let at = |part: f64| value(&force, TAU * (k as f64 + part) / STEPS as f64);
        steps.advance(&mut motion, step, [at(0.0), at(0.5), at(1.0)]);
        let now = &motion.contacts[0];
        slap.partings += usize::from(now.separation > 0.0 && !apart);
        if (k + 1).is_multiple_of(KEPT) {
            slap.time.push((k + 1) as f64 * step);
            slap.normal_force.push(now.normal_force);
            slap.separation.push(now.separation);
        }
    }
    slap.impact_energy = motion.energies.impact;
    Ok(slap)
}
