//! Derivatives of the balance, made when they are asked for.

use super::{Acting, Attached, Balance, Matrices, mean_square, sized};
use crate::harmonic::newton::system::{Operating, Scalar};
use crate::harmonic::period::Cycle;
use nalgebra::{Complex, DMatrix, DMatrixViewMut};

/// Entries of a column beyond which it counts as full.
const FEW: usize = 4;

/// `out = W x` for a port that moves along `shape` and does not shorten: harmonic by harmonic.
fn along(shape: &[f64], x: &DMatrix<f64>, modes: usize, out: &mut DMatrixViewMut<f64>) {
    for (mut out, x) in out.column_iter_mut().zip(x.column_iter()) {
        out.fill(0.0);
        for (out, x) in out.as_mut_slice().iter_mut().zip(x.as_slice().chunks_exact(modes)) {
            *out = shape.iter().zip(x).map(|(b, x)| b * x).sum();
        }
    }
}

/// `out = xᵀ`, a few columns of `x` at a time: one by one their entries lie too far from each other.
fn transpose(x: &DMatrix<f64>, out: &mut DMatrix<f64>) {
    const TOGETHER: usize = 8;
    let (rows, size) = x.shape();
    debug_assert_eq!(out.shape(), (size, rows));
    for (group, columns) in x.as_slice().chunks(TOGETHER * rows).enumerate() {
        for (row, target) in out.as_mut_slice().chunks_exact_mut(size).enumerate() {
            let entries = columns.iter().skip(row).step_by(rows);
            target[group * TOGETHER..].iter_mut().zip(entries).for_each(|(to, from)| *to = *from);
        }
    }
}

/// `out = compliance · law`. Laws over a period, which come first, fill the columns of their ports; what else acts has few
/// entries in each.
fn multiply(compliance: &DMatrix<f64>, law: &DMatrix<f64>, out: &mut DMatrix<f64>) {
    let entries = |column: usize| law.column(column).into_iter().enumerate().filter(|(_, x)| **x != 0.0);
    let full = (0..law.ncols()).rposition(|column| entries(column).count() > FEW).map_or(0, |last| last + 1);
    let reach = (0..full).filter_map(|column| entries(column).next_back()).map(|(row, _)| row + 1).max();
    if let Some(reach) = reach {
        let law = law.view((0, 0), (reach, full));
        out.columns_mut(0, full).gemm(1.0, &compliance.columns(0, reach), &law, 0.0);
    }
    for column in full..law.ncols() {
        let mut out = out.column_mut(column);
        out.fill(0.0);
        entries(column).for_each(|(row, x)| out.axpy(*x, &compliance.column(row), 1.0));
    }
}

impl Balance {
    /// The law that acts alone, at all unknowns: its derivatives need no copy.
    fn single(acting: &[Acting], unknowns: usize) -> Option<&Attached> {
        match acting {
            [Acting::Law { rows, attached }] if rows.len() == unknowns => Some(attached),
            _ => None,
        }
    }

    /// ∂forces/∂unknowns.
    pub(super) fn law(&self) -> &DMatrix<f64> {
        Self::single(&self.acting, self.residual.len()).map_or(&self.matrices.law, |law| law.cycle.jacobian())
    }

    /// B, A⁻¹ B and the derivatives of the forces, with the weights.
    fn differentiate(&mut self, at: &Operating) {
        for acting in &mut self.acting {
            acting.complete(at.angular_frequency, &self.unknown);
        }
        let modes = self.modes();
        let (size, rows) = (self.q.len(), self.residual.len());
        sized(&mut self.matrices.adjoint, size, rows);
        sized(&mut self.matrices.moved, size, rows);
        let Matrices { weights, adjoint, .. } = &mut self.matrices;
        transpose(weights, adjoint);
        for (column, scale) in adjoint.as_mut_slice().chunks_exact_mut(size).zip(&self.mean_squares) {
            // Both are ½ but for means.
            let (mean, others) = column.split_at_mut(modes);
            mean.iter_mut().for_each(|x| *x *= scale / mean_square(0));
            if *scale != mean_square(1) {
                others.iter_mut().for_each(|x| *x *= scale / mean_square(1));
            }
        }
        self.differentiate_laws(at);
        self.equations.solve_many(&self.matrices.adjoint, &mut self.matrices.moved);
        self.complete = false;
    }

    /// Makes the derivatives of the last evaluation if they are not made yet.
    pub(super) fn catch_up(&mut self) {
        let Some(at) = self.undifferentiated.take() else { return };
        self.weigh();
        if !self.is_linear() {
            self.differentiate(&at);
        }
        for k in 0..self.asked.len() {
            self.differentiate_by(self.asked[k]);
        }
        self.differentiated = true;
    }

    /// a + W A⁻¹ B and ∂r/∂unknowns.
    pub(super) fn complete_jacobian(&mut self) {
        let (rows, modes) = (self.residual.len(), self.modes());
        sized(&mut self.matrices.compliance, rows, rows);
        sized(&mut self.matrices.jacobian, rows, rows);
        let Matrices { weights, moved, compliance, jacobian, law, .. } = &mut self.matrices;
        for port in &self.ports {
            let mut target = compliance.rows_mut(port.rows.start, port.rows.len());
            if port.shortening == 0.0 {
                along(&port.shape, moved, modes, &mut target);
            } else {
                target.gemm(1.0, &weights.rows(port.rows.start, port.rows.len()), moved, 0.0);
            }
            port.rows.clone().for_each(|m| compliance[(m, m)] += port.flexibility);
        }
        // As `law`, of which the borrow would hold all of the balance.
        let law = Self::single(&self.acting, rows).map_or(&*law, |law| law.cycle.jacobian());
        multiply(compliance, law, jacobian);
        (0..rows).for_each(|m| jacobian[(m, m)] += 1.0);
        // The law's part of what the flexibility yields stands in its unknown.
        if let Some(contact) = self.acting.iter().find_map(Acting::at_contact).filter(|_| self.series != 0.0)
        {
            let own = contact.cycle.jacobian();
            let mut block = self.matrices.jacobian.view_mut((0, 0), own.shape());
            block.zip_apply(own, |entry, own| *entry -= self.series * own);
        }
        self.complete = true;
    }

    /// ∂forces/∂unknowns where there is more than one law.
    fn differentiate_laws(&mut self, at: &Operating) {
        let unknowns = self.residual.len();
        if Self::single(&self.acting, unknowns).is_some() {
            return;
        }
        sized(&mut self.matrices.law, unknowns, unknowns);
        self.matrices.law.fill(0.0);
        for acting in &self.acting {
            acting.differentiate(at, &mut self.matrices.law);
        }
        if self.series != 0.0 {
            self.pull_less(at);
        }
    }

    /// What hangs at the contact, behind the spring of the law, pulls less where the law's force grows.
    fn pull_less(&mut self, at: &Operating) {
        let hung: Vec<Complex<f64>> =
            (1..=self.wide / 2).map(|order| self.series * self.hung_stiffness(at, order)).collect();
        let Some(contact) = self.acting.iter().find_map(Acting::at_contact) else { return };
        for (column, own) in contact.cycle.jacobian().column_iter().enumerate() {
            for (place, hung) in hung.iter().enumerate() {
                let c = 2 * place + 1;
                let pull = hung * Complex::new(own[c], -own[c + 1]);
                self.matrices.law[(c, column)] -= pull.re;
                self.matrices.law[(c + 1, column)] += pull.im;
            }
        }
    }

    /// ∂forces/∂`scalar` at fixed unknowns; false where it vanishes.
    fn force_rates(&mut self, scalar: Scalar) -> bool {
        self.rates.fill(0.0);
        for acting in &self.acting {
            let x = if acting.hung().is_some() { &self.behind } else { &self.unknown };
            acting.add_rates(&self.equations.at, scalar, x, &mut self.rates);
        }
        if self.series != 0.0 && scalar == Scalar::AngularFrequency {
            self.let_go();
        }
        self.rates.iter().any(|rate| *rate != 0.0)
    }

    /// What hangs at the contact pulls less at a higher frequency where the law's force is larger there.
    fn let_go(&mut self) {
        let at = self.equations.at;
        let Some(contact) = self.acting.iter().find_map(Acting::at_contact) else { return };
        let own = contact.cycle.by_frequency();
        for (place, pair) in own[1..].chunks_exact(2).enumerate() {
            let pull = self.series * self.hung_stiffness(&at, place + 1) * Complex::new(pair[0], -pair[1]);
            self.rates[2 * place + 1] -= pull.re;
            self.rates[2 * place + 2] += pull.im;
        }
    }

    /// ∂q/∂scalar and ∂r/∂scalar at fixed u.
    fn differentiate_by(&mut self, scalar: Scalar) {
        let (modes, index) = (self.modes(), scalar.index());
        let mut right = std::mem::take(&mut self.right);
        let forces_change = self.force_rates(scalar);
        match scalar {
            Scalar::AngularFrequency | Scalar::SelfExcitation => {
                if scalar == Scalar::AngularFrequency {
                    self.equations.by_frequency(&self.q, &mut right);
                } else {
                    self.equations.by_self_excitation(&self.q, &mut right);
                }
                if forces_change {
                    let mut forces = std::mem::take(&mut self.modal_by[index]);
                    self.project(&self.rates, &mut forces);
                    right.iter_mut().zip(&forces).for_each(|(r, c)| *r += c);
                    self.modal_by[index] = forces;
                }
                right.iter_mut().for_each(|r| *r = -*r);
            }
            Scalar::Level | Scalar::Parameter => {
                let waveform = if scalar == Scalar::Level { &self.waveform } else { &self.second };
                for (right, f) in right.chunks_exact_mut(modes).zip(waveform) {
                    right.iter_mut().zip(&self.system.driven).for_each(|(r, e)| *r = f * e);
                }
            }
        }
        let moved = &mut self.modal_by[index];
        if right.iter().all(|r| *r == 0.0) || !self.equations.solve(&right, moved) {
            moved.fill(0.0);
        }
        self.right = right;
        let by = &mut self.by[index];
        by.fill(0.0);
        for (column, q) in self.matrices.weights.as_slice().chunks_exact(by.len()).zip(&self.modal_by[index])
        {
            by.iter_mut().zip(column).for_each(|(b, w)| *b -= w * q);
        }
        if forces_change {
            for port in self.ports.iter().filter(|port| port.flexibility != 0.0) {
                let rates = by[port.rows.clone()].iter_mut().zip(&self.rates[port.rows.clone()]);
                rates.for_each(|(b, rate)| *b += port.flexibility * rate);
            }
            let in_front = self.series != 0.0 && scalar == Scalar::AngularFrequency;
            if let Some(contact) = self.acting.iter().find_map(Acting::at_contact).filter(|_| in_front) {
                let own = contact.cycle.by_frequency().iter();
                by.iter_mut().zip(own).for_each(|(b, rate)| *b -= self.series * rate);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_matrix_of_any_width_is_transposed() {
        for (rows, columns) in [(1, 1), (3, 7), (5, 8), (2, 9), (4, 17)] {
            let x = DMatrix::from_fn(rows, columns, |i, k| (10 * k + i) as f64);
            let mut out = DMatrix::zeros(columns, rows);
            transpose(&x, &mut out);
            assert_eq!(out, x.transpose(), "{rows} by {columns}");
        }
    }
}
