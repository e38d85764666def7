//! The same system by time integration: exact between events, which are located.

use std::f64::consts::TAU;

use stickslip::time::{Excitation, LoadedContact, OscillatorFlow, ShootingSettings, shoot};

use crate::Failure;
use crate::system::System;

/// What a period of a motion does.
#[derive(Debug, Clone)]
pub struct Motion {
    /// Largest displacement of each mass (m).
    pub amplitude: Vec<f64>,
    /// Energy that friction takes (J).
    pub dissipated: f64,
    /// Work of the force (J).
    pub work: f64,
    /// Displacement (m) and force (N) of the contact over the period, where asked for.
    pub contact: Option<(Vec<f64>, Vec<f64>)>,
}

/// Samples of a loop.
const SAMPLES: usize = 360;

/// The periodic motion, found by shooting.
pub fn periodic(
    system: &System,
    force: f64,
    angular_frequency: f64,
    with_loop: bool,
) -> Result<Motion, Failure> {
    with_flow(system, |flow| {
        let excitation = Excitation::cosine(angular_frequency, force);
        let found =
            shoot(flow, &excitation, None, &ShootingSettings::default()).map_err(|error| failed(&error))?;
        let mut motion = motion(&found.passage);
        if with_loop {
            let mut at = found.start.clone();
            let (mut displacement, mut restoring) = (Vec::new(), Vec::new());
            let row = system.structure().contacts.first().cloned().unwrap_or_default();
            for k in 0..=SAMPLES {
                if k > 0 {
                    let step = TAU / angular_frequency / SAMPLES as f64;
                    flow.advance(&mut at, step, &excitation).map_err(|error| failed(&error))?;
                }
                let q = flow.displacement(&at);
                displacement.push(row.iter().map(|(i, factor)| factor * q[*i]).sum());
                restoring.push(flow.contact_forces(&at)[0]);
            }
            motion.contact = Some((displacement, restoring));
        }
        Ok(motion)
    })
}

/// Every one of the first `periods` periods after the force begins to act on the system at rest.
pub fn from_rest(
    system: &System,
    force: f64,
    angular_frequency: f64,
    periods: usize,
) -> Result<Vec<Motion>, Failure> {
    with_flow(system, |flow| {
        let excitation = Excitation::cosine(angular_frequency, force);
        let mut at = flow.rest();
        let one = |_| {
            let passage = flow.advance(&mut at, TAU / angular_frequency, &excitation);
            passage.map(|passage| motion(&passage)).map_err(|error| failed(&error))
        };
        (0..periods).map(one).collect()
    })
}

fn motion(passage: &stickslip::time::Passage) -> Motion {
    Motion {
        amplitude: (0..passage.output_range.len()).map(|k| passage.amplitude(k)).collect(),
        dissipated: passage.total_dissipated_energy(),
        work: passage.work,
        contact: None,
    }
}

fn with_flow<T>(
    system: &System,
    of: impl FnOnce(&mut OscillatorFlow) -> Result<T, Failure>,
) -> Result<T, Failure> {
    let law = system.law()?;
    let contacts = [LoadedContact { law: &law, normal_load: system.normal_load }];
    let mut flow = OscillatorFlow::new(system.structure(), &contacts).map_err(|error| failed(&error))?;
    of(&mut flow)
}

fn failed(error: &dyn std::fmt::Display) -> Failure {
    Failure::from(format!("time integration: {error}"))
}
