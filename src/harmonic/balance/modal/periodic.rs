//! The balance as a [`PeriodicSystem`]: what continuation, tracking and conditions ask of it.

use std::borrow::Cow;
use std::ops::Range;

use super::*;
use crate::harmonic::CycleSummary;
use crate::harmonic::newton::Contacting;
use crate::harmonic::stability::{Undecided, decide_modal};
use crate::system::System;

impl PeriodicSystem for Balance {
    fn unknowns(&self) -> usize {
        self.residual.len()
    }

    fn evaluate(&mut self, x: &[f64], at: &Operating, scalars: &[Scalar]) -> Result<f64, HarmonicError> {
        let scale = self.balance(x, at)?;
        self.undifferentiated = Some(*at);
        self.asked.clear();
        self.asked.extend_from_slice(scalars);
        Ok(scale)
    }

    fn residual(&self) -> &[f64] {
        &self.residual
    }

    fn jacobian(&mut self) -> &DMatrix<f64> {
        self.catch_up();
        if self.is_linear() {
            let unknowns = self.residual.len();
            sized(&mut self.matrices.jacobian, unknowns, unknowns);
            self.matrices.jacobian.fill_with_identity();
        } else if !self.complete {
            self.complete_jacobian();
        }
        &self.matrices.jacobian
    }

    fn by(&self, scalar: Scalar) -> &[f64] {
        &self.by[scalar.index()]
    }

    fn output(&mut self, node: usize, order: usize) -> [f64; 2] {
        let (modes, shape) = (self.modes(), &self.system.observed[node]);
        let seen = |place: usize| -> f64 {
            let q = &self.q[place * modes..(place + 1) * modes];
            q.iter().zip(shape).map(|(q, phi)| q * phi).sum()
        };
        match order {
            0 => [seen(0), 0.0],
            _ if order <= self.harmonics => [seen(2 * order - 1), seen(2 * order)],
            _ => [0.0; 2],
        }
    }

    fn observe(&mut self, node: usize, order: usize, out: &mut Observation) {
        self.catch_up();
        let (modes, unknowns) = (self.modes(), self.unknowns());
        let shape = &self.system.observed[node];
        out.value = [0.0; 2];
        out.by_scalars = [[0.0; 4]; 2];
        for row in &mut out.by_unknowns {
            row.clear();
            row.resize(unknowns, 0.0);
        }
        let places = match order {
            0 => 0..1,
            _ if order <= self.harmonics => 2 * order - 1..2 * order + 1,
            _ => return,
        };
        for (part, place) in places.enumerate() {
            let span = place * modes..(place + 1) * modes;
            let seen = |q: &[f64]| -> f64 { q.iter().zip(shape).map(|(q, phi)| q * phi).sum() };
            out.value[part] = seen(&self.q[span.clone()]);
            for (by, q) in out.by_scalars[part].iter_mut().zip(&self.modal_by) {
                *by = seen(&q[span.clone()]);
            }
            if self.is_linear() {
                continue;
            }
            // −φ A⁻¹ B ∂T/∂u.
            let columns = self.matrices.moved.as_slice().chunks_exact(self.q.len());
            let by_force: Vec<f64> = columns.map(|column| seen(&column[span.clone()])).collect();
            let columns = self.law().as_slice().chunks_exact(unknowns);
            for (by, column) in out.by_unknowns[part].iter_mut().zip(columns) {
                *by = -column.iter().zip(&by_force).map(|(k, s)| k * s).sum::<f64>();
            }
        }
    }

    fn forget(&mut self) {
        self.acting.iter_mut().for_each(Acting::forget);
        self.equations.forget();
        self.differentiated = false;
    }

    fn nodes(&self) -> usize {
        self.system.observed.len()
    }

    fn harmonics(&self) -> usize {
        self.harmonics
    }

    fn guess(&mut self, at: &Operating, x: &mut [f64]) -> Result<(), HarmonicError> {
        let both = self.waveform.iter().zip(&self.second);
        let excitation: Vec<f64> = both.map(|(f, second)| at.level * f + at.parameter * second).collect();
        guess::forced(self, at.angular_frequency, &excitation)?;
        self.displace();
        x.copy_from_slice(&self.start(at.angular_frequency));
        Ok(())
    }

    fn nodes_along(&mut self, unknowns: &[f64], scalars: &[f64; 4], out: &mut [Vec<f64>]) {
        if !self.differentiated {
            self.catch_up();
        }
        let modes = self.modes();
        self.right.fill(0.0);
        if !self.is_linear() {
            let mut force = vec![0.0; self.unknowns()];
            for (column, change) in self.law().as_slice().chunks_exact(unknowns.len()).zip(unknowns) {
                force.iter_mut().zip(column).for_each(|(f, k)| *f += k * change);
            }
            for (column, change) in self.matrices.moved.as_slice().chunks_exact(self.right.len()).zip(&force)
            {
                self.right.iter_mut().zip(column).for_each(|(q, s)| *q -= s * change);
            }
        }
        for (by, change) in self.modal_by.iter().zip(scalars).filter(|(_, change)| **change != 0.0) {
            self.right.iter_mut().zip(by).for_each(|(q, d)| *q += d * change);
        }
        for (node, coefficients) in out.iter_mut().enumerate() {
            let shape = &self.system.observed[node];
            coefficients.clear();
            coefficients.extend(
                self.right
                    .chunks_exact(modes)
                    .map(|q| q.iter().zip(shape).map(|(q, phi)| q * phi).sum::<f64>()),
            );
        }
    }

    fn resume(&self, point: &Point, x: &mut [f64]) -> bool {
        let mut known = 0;
        for ((rows, _), contact) in self.acting.iter().filter_map(Acting::law).zip(&point.contacts) {
            if contact.displacement.len() != rows.len() {
                return false;
            }
            x[rows.clone()].copy_from_slice(&contact.displacement);
            if rows.start == 0 && self.series != 0.0 {
                x.iter_mut().zip(&contact.force).for_each(|(x, force)| *x += self.series * force);
            }
            known += rows.len();
        }
        known == x.len()
    }

    fn replace_laws(&mut self, system: &System) -> Result<(), HarmonicError> {
        for (acting, (_, law, normal_load)) in
            self.acting.iter_mut().filter_map(Acting::law_mut).zip(system.laws())
        {
            acting.replace(law, normal_load);
        }
        Ok(())
    }

    fn truncation_error(
        &mut self,
        _x: &[f64],
        at: &Operating,
        point: &Point,
        solve: &mut dyn FnMut(&mut [f64]),
    ) -> Result<f64, HarmonicError> {
        Ok(self.left_out(at, point, solve))
    }

    fn stable(&mut self, point: &Point) -> Result<bool, Undecided> {
        if self.has_two_directions() {
            return Err(Undecided::TwoDirections);
        }
        let displacement: Vec<&[f64]> =
            point.contacts.iter().map(|contact| contact.displacement.as_slice()).collect();
        let decide = |system: &ModalSystem, modes: &[f64]| {
            decide_modal(system, modes, &displacement, point.angular_frequency)
        };
        let Cow::Owned(expanded) = self.completed.expanded() else {
            return decide(&self.system, &self.modal_coefficients());
        };
        let at = Operating::forced(point.angular_frequency, point.level);
        let expanded = ModalSystem::new(&expanded).map_err(|_| Undecided::NotSettled)?;
        decide(&expanded, &self.expanded_coefficients(&at))
    }

    fn describe(&mut self, x: &[f64], operating: &Operating) -> Result<Point, HarmonicError> {
        let rows = &self.system.observed;
        let behind = if self.series == 0.0 { x } else { &self.behind };
        let nodes: Vec<Vec<f64>> = rows.iter().map(|row| self.displacement_along(row)).collect();
        let at = |rows: &Range<usize>, summary: CycleSummary, force: &[f64]| Contacting {
            dissipated_energy: summary.dissipated_energy,
            equivalent_stiffness: summary.equivalent_stiffness,
            stick_fraction: summary.stick_fraction,
            displacement: behind[rows.clone()].to_vec(),
            force: force.to_vec(),
        };
        let mut contacts = Vec::new();
        for acting in &mut self.acting {
            match acting {
                Acting::Law { rows, attached } => {
                    contacts.push(at(rows, attached.cycle.summary(), attached.force()));
                }
                Acting::SlipSlap { rows, cycle, .. } => {
                    // The springs that the modes have in its place act at the same port.
                    let both = rows.iter().zip(cycle.summaries()).enumerate();
                    contacts.extend(both.map(|(k, (rows, summary))| at(rows, summary, cycle.force(k))));
                }
                _ => {}
            }
        }
        let driven = self.displacement_along(&self.system.driven);
        Ok(Point {
            angular_frequency: operating.angular_frequency,
            level: operating.level,
            parameter: operating.parameter,
            amplitude: nodes.iter().map(|node| self.extremum.of(node).1).collect(),
            nodes,
            contacts,
            work: operating.level * work_per_cycle(&self.waveform, &driven)
                + operating.parameter * work_per_cycle(&self.second, &driven),
            stable: None,
            undecided: None,
            error_estimate: 0.0,
            resolved: true,
            harmonics: self.harmonics,
            iterations: 0,
        })
    }
}
