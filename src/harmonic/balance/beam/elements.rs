//! What acts at the ports besides the contact, by coefficients.

use std::ops::Range;
use std::sync::Arc;

use nalgebra::DMatrix;

use super::ports::{CondensedPort, Ports};
use crate::contact::ContactLaw;
use crate::harmonic::period::map::ContactMap;
use crate::harmonic::period::{Cycle, PeriodicContact};
use crate::harmonic::{HarmonicError, Method};
use crate::numeric::HarmonicSet;
use crate::numeric::fourier::work_per_cycle;
use crate::system::{Element, System};

/// An element at the unknowns of its ports.
#[derive(Debug)]
pub(super) enum Acting {
    /// A law over a period.
    Law { rows: Range<usize>, law: Arc<dyn ContactLaw>, normal_load: f64, map: Box<ContactMap> },
    /// Springs between two ports.
    Springs { rows: [Range<usize>; 2], stiffness: [[f64; 2]; 2] },
    /// A damper (N s/m).
    Damper { rows: Range<usize>, damping: f64 },
}

/// The elements of `system` at `ports`, but those given from outside: the contact is one. Maps that others have left are
/// used again.
pub(super) fn acting(
    system: &System,
    names: &Ports,
    ports: &[CondensedPort],
    method: Method,
    left: Vec<ContactMap>,
) -> Vec<Acting> {
    let mut left = left.into_iter();
    let rows = |place: usize| Some(ports.get(names.place(&system.ports[place].name)?)?.rows.clone());
    let one = |element: &Element| match element {
        Element::Law { port, law, normal_load } => {
            let rows = rows(*port)?;
            let map =
                left.next().unwrap_or_else(|| ContactMap::new(HarmonicSet::full(rows.len() / 2), method));
            Some(Acting::Law { rows, law: law.clone(), normal_load: *normal_load, map: Box::new(map) })
        }
        Element::Springs { ports: [a, b], stiffness } => {
            Some(Acting::Springs { rows: [rows(*a)?, rows(*b)?], stiffness: *stiffness })
        }
        Element::Outside { .. } => None,
    };
    system.elements.iter().filter_map(one).collect()
}

impl Acting {
    /// Adds the forces (N) for the unknowns `x`, without their derivatives.
    pub fn act(
        &mut self,
        angular_frequency: f64,
        x: &[f64],
        forces: &mut [f64],
    ) -> Result<(), HarmonicError> {
        match self {
            Self::Law { rows, law, normal_load, map } => {
                let contact = periodic(law.as_ref(), *normal_load);
                map.evaluate_force(&contact, angular_frequency, &x[rows.clone()])?;
                add(&mut forces[rows.clone()], map.force(), 1.0);
            }
            Self::Springs { rows, stiffness } => {
                for (to, row) in rows.iter().zip(stiffness) {
                    for (from, stiffness) in rows.iter().zip(row) {
                        add(&mut forces[to.clone()], &x[from.clone()], *stiffness);
                    }
                }
            }
            Self::Damper { rows, damping } => {
                add_rates(&mut forces[rows.clone()], &x[rows.clone()], *damping * angular_frequency);
            }
        }
        Ok(())
    }

    /// Adds ∂forces/∂unknowns at the unknowns `x` that it was last evaluated for.
    pub fn differentiate(&mut self, angular_frequency: f64, x: &[f64], law_matrix: &mut DMatrix<f64>) {
        match self {
            Self::Law { rows, law, normal_load, map } => {
                // Where the derivatives are not found those there are stay, as for the contact.
                let contact = periodic(law.as_ref(), *normal_load);
                let _ = map.complete(&contact, angular_frequency, &x[rows.clone()]);
                let mut block = law_matrix.view_mut((rows.start, rows.start), (rows.len(), rows.len()));
                block += map.jacobian();
            }
            Self::Springs { rows, stiffness } => {
                for (to, row) in rows.iter().zip(stiffness) {
                    for (from, stiffness) in rows.iter().zip(row) {
                        for (i, j) in to.clone().zip(from.clone()) {
                            law_matrix[(i, j)] += *stiffness;
                        }
                    }
                }
            }
            Self::Damper { rows, damping } => {
                for (order, c) in rows.clone().skip(1).step_by(2).enumerate() {
                    let rate = *damping * angular_frequency * (order + 1) as f64;
                    law_matrix[(c, c + 1)] += rate;
                    law_matrix[(c + 1, c)] -= rate;
                }
            }
        }
    }

    /// Adds ∂forces/∂Ω at fixed unknowns `x`.
    pub fn add_rates(&self, x: &[f64], rates: &mut [f64]) {
        match self {
            Self::Law { rows, map, .. } => add(&mut rates[rows.clone()], map.by_frequency(), 1.0),
            Self::Springs { .. } => {}
            Self::Damper { rows, damping } => add_rates(&mut rates[rows.clone()], &x[rows.clone()], *damping),
        }
    }

    /// Energy (J) that a law takes per cycle of the displacements `u`.
    pub fn dissipated(&self, u: &[f64]) -> f64 {
        match self {
            Self::Law { rows, map, .. } => work_per_cycle(map.force(), &u[rows.clone()]),
            Self::Springs { .. } | Self::Damper { .. } => 0.0,
        }
    }
}

fn periodic(law: &dyn ContactLaw, normal_load: f64) -> PeriodicContact<'_> {
    PeriodicContact { law, normal_load, load_swing: &[], compliance: 0.0 }
}

fn add(to: &mut [f64], from: &[f64], factor: f64) {
    to.iter_mut().zip(from).for_each(|(to, from)| *to += factor * from);
}

/// Adds `factor` times the derivative by phase of a signal, by its coefficients.
fn add_rates(to: &mut [f64], signal: &[f64], factor: f64) {
    let pairs = to[1..].chunks_exact_mut(2).zip(signal[1..].chunks_exact(2));
    for (order, (to, signal)) in pairs.enumerate() {
        let rate = factor * (order + 1) as f64;
        to[0] += rate * signal[1];
        to[1] -= rate * signal[0];
    }
}
