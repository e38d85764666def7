//! What acts at the ports, by coefficients.

use std::ops::Range;
use std::sync::Arc;

use nalgebra::DMatrix;

use super::ports::{CondensedPort, Ports};
use super::resonator::Resonator;
use crate::contact::SlipSlap;
use crate::harmonic::balance::assembly::Assembly;
use crate::harmonic::balance::attached::Attached;
use crate::harmonic::newton::system::{Operating, Scalar};
use crate::harmonic::period::Cycle;
use crate::harmonic::period::map::ContactMap;
use crate::harmonic::period::pair::PairCycle;
use crate::harmonic::{HarmonicError, Method};
use crate::numeric::HarmonicSet;
use crate::system::Element;

/// What carries contacts over a period, with the unknowns that each is for.
#[derive(Debug, Default)]
pub(super) struct Maps {
    laws: Vec<(Range<usize>, ContactMap)>,
    pairs: Vec<([Range<usize>; 2], Box<PairCycle>)>,
}

impl Maps {
    /// Those of all that acted.
    pub fn of(acting: Vec<Acting>) -> Self {
        let mut maps = Self::default();
        for acting in acting {
            match acting {
                Acting::Law { rows, attached } => maps.laws.push((rows, attached.cycle)),
                Acting::SlipSlap { rows, cycle, .. } => maps.pairs.push((rows, cycle)),
                _ => {}
            }
        }
        maps
    }

    fn law(&mut self, rows: &Range<usize>, method: Method) -> ContactMap {
        match self.laws.iter().position(|(of, _)| of == rows) {
            Some(place) => self.laws.swap_remove(place).1,
            None => ContactMap::new(HarmonicSet::full(rows.len() / 2), method, 0.0),
        }
    }

    fn pair(&mut self, rows: &[Range<usize>; 2], method: Method) -> Box<PairCycle> {
        match self.pairs.iter().position(|(of, _)| of == rows) {
            Some(place) => self.pairs.swap_remove(place).1,
            None => {
                let harmonics = [rows[0].len() / 2, rows[1].len() / 2];
                Box::new(PairCycle::new(harmonics, method.samples_in_motion()))
            }
        }
    }
}

/// An element at the unknowns of its ports.
#[derive(Debug)]
pub(super) enum Acting {
    /// A law over a period.
    Law { rows: Range<usize>, attached: Box<Attached> },
    /// Springs between two ports.
    Springs { rows: [Range<usize>; 2], stiffness: [[f64; 2]; 2] },
    /// Masses that move with two ports.
    Inertia { rows: [Range<usize>; 2], mass: [[f64; 2]; 2] },
    /// A contact in two directions over a period.
    SlipSlap { rows: [Range<usize>; 2], contact: Arc<SlipSlap>, cycle: Box<PairCycle> },
    /// A mass on a spring that follows the port.
    Resonator(Resonator),
    /// A damper (N s/m).
    Damper { rows: Range<usize>, damping: f64 },
}

/// The elements of `assembly` at `ports`, but those given from outside, that at the contact behind a spring of the
/// compliance `series` (m/N). Maps that others have left are used again.
pub(super) fn acting(
    assembly: &Assembly,
    names: &Ports,
    ports: &[CondensedPort],
    series: f64,
    method: Method,
    mut left: Maps,
) -> Vec<Acting> {
    let system = &assembly.system;
    let rows = |place: usize| Some(ports.get(names.place(&system.ports[place].name)?)?.rows.clone());
    let one = |(place, element): (usize, &Element)| match element {
        Element::Law { port, law, normal_load } => {
            let rows = rows(*port)?;
            let mut attached = Attached::new(assembly, place, (law, *normal_load), left.law(&rows, method));
            attached.compliance = if rows.start == 0 { series } else { 0.0 };
            Some(Acting::Law { rows, attached: Box::new(attached) })
        }
        Element::Springs { ports: [a, b], stiffness } => {
            Some(Acting::Springs { rows: [rows(*a)?, rows(*b)?], stiffness: *stiffness })
        }
        Element::Inertia { ports: [a, b], mass } => {
            Some(Acting::Inertia { rows: [rows(*a)?, rows(*b)?], mass: *mass })
        }
        Element::SlipSlap { ports: [a, b], contact } => {
            let rows = [rows(*a)?, rows(*b)?];
            let cycle = left.pair(&rows, method);
            Some(Acting::SlipSlap { rows, contact: contact.clone(), cycle })
        }
        Element::Resonator { port, mass, angular_frequency, damping_ratio } => {
            let hung = Resonator::new(rows(*port)?, *mass, *angular_frequency, *damping_ratio);
            Some(Acting::Resonator(hung))
        }
        Element::Outside { .. } => None,
    };
    system.elements.iter().enumerate().filter_map(one).collect()
}

impl Acting {
    /// A law and its unknowns.
    pub fn law(&self) -> Option<(&Range<usize>, &Attached)> {
        match self {
            Self::Law { rows, attached } => Some((rows, attached)),
            _ => None,
        }
    }

    /// The law of the contact, at whose port the unknowns begin.
    pub fn at_contact(&self) -> Option<&Attached> {
        self.law().filter(|(rows, _)| rows.start == 0).map(|(_, attached)| attached)
    }

    /// What hangs at the port of the contact.
    pub fn hung(&self) -> Option<&Resonator> {
        match self {
            Self::Resonator(hung) if hung.rows.start == 0 => Some(hung),
            _ => None,
        }
    }

    /// A law.
    pub fn law_mut(&mut self) -> Option<&mut Attached> {
        match self {
            Self::Law { attached, .. } => Some(attached),
            _ => None,
        }
    }

    /// Makes the next evaluation depend on its arguments alone.
    pub fn forget(&mut self) {
        match self {
            Self::Law { attached, .. } => attached.cycle.forget(),
            Self::SlipSlap { cycle, .. } => cycle.forget(),
            _ => {}
        }
    }

    /// Makes a law's derivatives at the unknowns `x` that it was last evaluated for.
    pub fn complete(&mut self, angular_frequency: f64, x: &[f64]) {
        match self {
            Self::Law { rows, attached } => attached.complete(angular_frequency, &x[rows.clone()]),
            Self::SlipSlap { rows: [a, b], contact, cycle } => {
                // As of a law: where it fails the derivatives there are stay.
                let _ = cycle.evaluate(contact, angular_frequency, [&x[a.clone()], &x[b.clone()]], true);
            }
            _ => {}
        }
    }

    /// Adds the forces (N) for the unknowns `x`; no derivatives can follow where they are wanted `alone`.
    pub fn act(
        &mut self,
        at: &Operating,
        x: &[f64],
        alone: bool,
        forces: &mut [f64],
    ) -> Result<(), HarmonicError> {
        let angular_frequency = at.angular_frequency;
        match self {
            Self::Law { rows, attached } => {
                let (u, forces) = (&x[rows.clone()], &mut forces[rows.clone()]);
                attached.evaluate_force(angular_frequency, u, alone)?;
                add(forces, attached.force(), 1.0);
            }
            Self::Springs { rows, stiffness } => {
                for (to, row) in rows.iter().zip(stiffness) {
                    for (from, stiffness) in rows.iter().zip(row) {
                        add(&mut forces[to.clone()], &x[from.clone()], *stiffness);
                    }
                }
            }
            Self::Inertia { rows, mass } => {
                for (to, row) in rows.iter().zip(mass) {
                    for (from, mass) in rows.iter().zip(row) {
                        let factor = *mass * angular_frequency * angular_frequency;
                        add_accelerations(&mut forces[to.clone()], &x[from.clone()], factor);
                    }
                }
            }
            Self::SlipSlap { rows: [a, b], contact, cycle } => {
                let u = [&x[a.clone()], &x[b.clone()]];
                cycle.evaluate(contact, angular_frequency, u, false)?;
                add(&mut forces[a.clone()], cycle.force(0), 1.0);
                add(&mut forces[b.clone()], cycle.force(1), 1.0);
            }
            Self::Resonator(hung) => hung.act(at, x, forces),
            Self::Damper { rows, damping } => {
                add_rates(&mut forces[rows.clone()], &x[rows.clone()], *damping * angular_frequency);
            }
        }
        Ok(())
    }

    /// Adds ∂forces/∂unknowns, those of a law being made already.
    pub fn differentiate(&self, at: &Operating, law_matrix: &mut DMatrix<f64>) {
        let angular_frequency = at.angular_frequency;
        match self {
            Self::Law { rows, attached } => {
                let mut block = law_matrix.view_mut((rows.start, rows.start), (rows.len(), rows.len()));
                block += attached.cycle.jacobian();
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
            Self::Inertia { rows, mass } => {
                for (to, row) in rows.iter().zip(mass) {
                    for (from, mass) in rows.iter().zip(row) {
                        for (place, (i, j)) in to.clone().zip(from.clone()).enumerate() {
                            let speed = place.div_ceil(2) as f64 * angular_frequency;
                            law_matrix[(i, j)] -= *mass * speed * speed;
                        }
                    }
                }
            }
            Self::SlipSlap { rows: [a, b], cycle, .. } => {
                for (direction, rows) in [a, b].into_iter().enumerate() {
                    for (place, row) in rows.clone().enumerate() {
                        let by = cycle.derivatives(direction, place);
                        for (column, by) in a.clone().chain(b.clone()).zip(by) {
                            law_matrix[(row, column)] += by;
                        }
                    }
                }
            }
            Self::Resonator(hung) => hung.differentiate(at, law_matrix),
            Self::Damper { rows, damping } => {
                for (order, c) in rows.clone().skip(1).step_by(2).enumerate() {
                    let rate = *damping * angular_frequency * (order + 1) as f64;
                    law_matrix[(c, c + 1)] += rate;
                    law_matrix[(c + 1, c)] -= rate;
                }
            }
        }
    }

    /// Adds ∂forces/∂`scalar` at fixed unknowns `x`.
    pub fn add_rates(&self, at: &Operating, scalar: Scalar, x: &[f64], rates: &mut [f64]) {
        match self {
            Self::Resonator(hung) => hung.add_rates(at, scalar, x, rates),
            _ if scalar == Scalar::AngularFrequency => {
                self.add_rates_by_frequency(at.angular_frequency, x, rates)
            }
            _ => {}
        }
    }

    fn add_rates_by_frequency(&self, angular_frequency: f64, x: &[f64], rates: &mut [f64]) {
        match self {
            Self::Law { rows, attached } => {
                add(&mut rates[rows.clone()], attached.cycle.by_frequency(), 1.0);
            }
            Self::Springs { .. } | Self::Resonator(_) => {}
            Self::Inertia { rows, mass } => {
                for (to, row) in rows.iter().zip(mass) {
                    for (from, mass) in rows.iter().zip(row) {
                        let factor = 2.0 * *mass * angular_frequency;
                        add_accelerations(&mut rates[to.clone()], &x[from.clone()], factor);
                    }
                }
            }
            Self::SlipSlap { rows, cycle, .. } => {
                for (direction, rows) in rows.iter().enumerate() {
                    for (place, row) in rows.clone().enumerate() {
                        rates[row] += cycle.derivatives(direction, place).last().copied().unwrap_or(0.0);
                    }
                }
            }
            Self::Damper { rows, damping } => add_rates(&mut rates[rows.clone()], &x[rows.clone()], *damping),
        }
    }
}

fn add(to: &mut [f64], from: &[f64], factor: f64) {
    to.iter_mut().zip(from).for_each(|(to, from)| *to += factor * from);
}

/// Adds `factor` times the second derivative by phase of a signal, by its coefficients.
fn add_accelerations(to: &mut [f64], signal: &[f64], factor: f64) {
    for (place, (to, signal)) in to.iter_mut().zip(signal).enumerate() {
        let order = place.div_ceil(2) as f64;
        *to -= factor * order * order * signal;
    }
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
