//! Harmonic balance of the modal beam, condensed to the displacement of its contact.
//!
//! With `w_i(t) = c_i − Σ G_ij q_j(t)` the displacement of the contact, `u = c·q − ½ qᵀG q`, has
//! `∂u/∂q_i = w_i`, and the contact acts on mode `i` by `T w_i`. Displacements with harmonics `0..=H`
//! give `u` harmonics `0..=2H`, and Galerkin projection of `T w_i` on `0..=H` sees `T`'s harmonics
//! `0..=2H` only: the contact is therefore one map between signals of `4H + 1` coefficients, and
//! everything else here is exact algebra on coefficients.
//!
//! Under a given `T(t)` the modal equations are linear, `A(T) q = level · f − P[T c]`, and are solved
//! ([`ModalEquations`]). The flexibility `a` in series with the contact yields by `a T`, and the unknown is the
//! displacement v that is left for the contact itself, so that a step of the law needs no iteration. What
//! remains are `4H + 1` equations whatever the number of modes,
//!
//! `r(v) = v + a T(v) − (c·q − ½ qᵀG q) = 0`, `∂r/∂v = 1 + (a + W A⁻¹ B) ∂T/∂v`,
//!
//! W being multiplication by `w_i` and B its adjoint, the projection of `T w_i`.

#[cfg(test)]
mod tests;
mod truncation;

use nalgebra::DMatrix;

use crate::harmonic::curve::Contacting;
use crate::harmonic::cycle::map::ContactMap;
use crate::harmonic::cycle::{Cycle, PeriodicContact};
use crate::harmonic::extremum::Extremum;
use crate::harmonic::fourier::{coefficient_count, multiplication, work_per_cycle};
use crate::harmonic::modal::ModalEquations;
use crate::harmonic::set::HarmonicSet;
use crate::harmonic::system::{Observation, Operating, PeriodicSystem, Scalar};
use crate::harmonic::{ContactOnBeam, HarmonicError, Method, Point, guess};
use crate::structure::ModalBeam;

/// Workspace for one beam, contact and set of harmonics.
///
/// Outputs are the beam's sensors and, last, the point of excitation.
#[derive(Debug)]
pub(crate) struct Balance<'a> {
    pub beam: &'a ModalBeam,
    pub contact: Option<ContactOnBeam<'a>>,
    /// Coefficients per mode, `2H + 1`.
    pub count: usize,
    /// Modal coefficients of the last evaluation, coefficient after coefficient.
    pub q: Vec<f64>,
    /// Coefficients of `c·q − ½ qᵀG q` (m), harmonics `0..=2H`, of the last evaluation.
    pub displacement: Vec<f64>,
    waveform: Vec<f64>,
    extremum: Extremum,
    cycle: ContactMap,
    equations: ModalEquations,
    harmonics: usize,
    wide: usize,
    /// Coefficients of the contact force (N), and of its change with Ω.
    force: Vec<f64>,
    right: Vec<f64>,
    /// Coefficients of w_i, and multiplication by it.
    shape: Vec<f64>,
    block: Vec<f64>,
    /// W, `wide × unknowns of the modes`.
    weights: DMatrix<f64>,
    /// B, and A⁻¹ B.
    adjoint: DMatrix<f64>,
    moved: DMatrix<f64>,
    /// a + W A⁻¹ B.
    compliance: DMatrix<f64>,
    residual: Vec<f64>,
    jacobian: DMatrix<f64>,
    /// Whether the Jacobian is that of the last evaluation: it costs two large products, and a solution needs none.
    complete: bool,
    by: [Vec<f64>; 4],
    /// ∂q/∂scalar at fixed u.
    modal_by: [Vec<f64>; 4],
}

impl<'a> Balance<'a> {
    /// Excitation at level 1: `waveform`, coefficients `[a0, c1, s1, …]` (N); those beyond `harmonics` are
    /// left out.
    pub fn new(
        beam: &'a ModalBeam,
        contact: Option<ContactOnBeam<'a>>,
        waveform: &[f64],
        harmonics: usize,
        method: Method,
    ) -> Result<Self, HarmonicError> {
        check_beam(beam)?;
        if let Some(contact) = &contact
            && !contact.normal_load.is_finite()
        {
            return Err(HarmonicError::InvalidInput("the normal load is not finite"));
        }
        let (count, wide) = (coefficient_count(harmonics), coefficient_count(2 * harmonics));
        let size = count * beam.angular_frequency.len();
        let mut kept = waveform.to_vec();
        kept.resize(count, 0.0);
        Ok(Self {
            beam,
            contact,
            count,
            q: vec![0.0; size],
            displacement: vec![0.0; wide],
            waveform: kept,
            extremum: Extremum::default(),
            cycle: ContactMap::new(HarmonicSet::full(2 * harmonics), method),
            equations: ModalEquations::new(beam, harmonics),
            harmonics,
            wide,
            force: vec![0.0; wide],
            right: vec![0.0; size],
            shape: vec![0.0; count],
            block: vec![0.0; wide * count],
            weights: DMatrix::zeros(wide, size),
            adjoint: DMatrix::zeros(size, wide),
            moved: DMatrix::zeros(size, wide),
            compliance: DMatrix::zeros(wide, wide),
            residual: vec![0.0; wide],
            jacobian: DMatrix::identity(wide, wide),
            complete: false,
            by: std::array::from_fn(|_| vec![0.0; wide]),
            modal_by: std::array::from_fn(|_| vec![0.0; size]),
        })
    }

    /// Number of modes.
    pub fn modes(&self) -> usize {
        self.beam.angular_frequency.len()
    }

    /// Coefficients of the contact force (N), harmonics `0..=2H`, of the last evaluation.
    pub fn force(&self) -> &[f64] {
        &self.force
    }

    /// Coefficients `[a0, c1, s1, …]` of every mode, mode after mode, of the last evaluation.
    pub fn modal_coefficients(&self) -> Vec<f64> {
        let modes = self.modes();
        (0..modes).flat_map(|i| self.q.iter().skip(i).step_by(modes).copied()).collect()
    }

    /// The unknowns that belong to such coefficients and a contact force.
    pub fn unknowns_of(&mut self, modal_coefficients: &[f64], force: &[f64]) -> Vec<f64> {
        let (modes, count) = (self.modes(), self.count);
        for (i, mode) in modal_coefficients.chunks_exact(count).enumerate() {
            mode.iter().enumerate().for_each(|(k, value)| self.q[k * modes + i] = *value);
        }
        self.weigh();
        self.relieved(force)
    }

    /// The displacement left for the contact under a force on it, once the series spring has yielded.
    fn relieved(&self, force: &[f64]) -> Vec<f64> {
        let series = self.beam.axial_flexibility;
        self.displacement.iter().zip(force).map(|(u, force)| u - series * force).collect()
    }

    /// The unknowns of the displacement and the contact force last evaluated.
    pub fn start(&self) -> Vec<f64> {
        self.relieved(&self.force)
    }

    /// Energy dissipated in the contact per cycle (J) at the last evaluation: the work of the force on
    /// the displacement before the series spring, which stores and returns its share.
    pub fn dissipated_energy(&self) -> f64 {
        work_per_cycle(&self.force, &self.displacement)
    }

    /// The contact alone, driven by `u` given by its coefficients (harmonics `0..=2H`), behind a spring of
    /// the compliance `series` (m/N).
    pub fn contact_force(
        &mut self,
        angular_frequency: f64,
        u: &[f64],
        series: f64,
    ) -> Result<&[f64], HarmonicError> {
        if let Some(ContactOnBeam { law, normal_load }) = self.contact {
            let contact = PeriodicContact { law, normal_load, compliance: series };
            self.cycle.evaluate(&contact, angular_frequency, u)?;
            self.force.copy_from_slice(self.cycle.force());
        }
        Ok(&self.force)
    }

    /// Writes the displacement and W for the modal coefficients.
    pub fn weigh(&mut self) {
        let (modes, wide) = (self.modes(), self.wide);
        // u = ½ Σ (w_i + c_i) q_i.
        self.displacement.fill(0.0);
        for i in 0..modes {
            self.shape.fill(0.0);
            self.shape[0] = self.beam.contact_shape[i];
            let row = &self.beam.shortening[i * modes..(i + 1) * modes];
            for (s, q) in self.shape.iter_mut().zip(self.q.chunks_exact(modes)) {
                *s -= row.iter().zip(q).map(|(g, q)| g * q).sum::<f64>();
            }
            multiplication(&self.shape, self.harmonics, wide, &mut self.block);
            for (k, column) in self.block.chunks_exact(wide).enumerate() {
                let place = k * modes + i;
                self.weights.as_mut_slice()[place * wide..(place + 1) * wide].copy_from_slice(column);
                let q = 0.5 * self.q[place];
                self.displacement.iter_mut().zip(column).for_each(|(u, w)| *u += w * q);
                self.displacement[k] += self.beam.contact_shape[i] * q;
            }
        }
    }

    /// `P[T w_i]` for the force `T` and the W of the last evaluation.
    fn project(&self, force: &[f64], out: &mut [f64]) {
        let modes = self.modes();
        for (place, column) in self.weights.as_slice().chunks_exact(self.wide).enumerate() {
            let sum: f64 = force.iter().zip(column).skip(1).map(|(t, w)| t * w).sum();
            out[place] = (force[0] * column[0] + 0.5 * sum) / mean_square(place / modes);
        }
    }

    /// q under the contact force of the last evaluation of the contact, and W.
    fn respond(&mut self, at: &Operating) -> Result<(), HarmonicError> {
        let (modes, beam) = (self.modes(), self.beam);
        let singular = HarmonicError::InvalidInput("the modal equations are singular at this frequency");
        if !self.equations.set(at, &self.force) {
            return Err(singular);
        }
        for (k, right) in self.right.chunks_exact_mut(modes).enumerate() {
            let (excitation, force) = (at.level * self.waveform[k], self.force[k]);
            let shapes = beam.excitation_shape.iter().zip(&beam.contact_shape);
            right.iter_mut().zip(shapes).for_each(|(r, (e, c))| *r = excitation * e - force * c);
        }
        if !self.equations.solve(&self.right, &mut self.q) {
            return Err(singular);
        }
        self.weigh();
        Ok(())
    }

    /// B and A⁻¹ B.
    fn differentiate(&mut self) {
        let (wide, modes) = (self.wide, self.modes());
        let size = self.q.len();
        let adjoint = self.adjoint.as_mut_slice();
        for (place, column) in self.weights.as_slice().chunks_exact(wide).enumerate() {
            let scale = 0.5 / mean_square(place / modes);
            let row = adjoint.iter_mut().skip(place).step_by(size);
            row.zip(column).for_each(|(to, weight)| *to = scale * weight);
            adjoint[place] *= 2.0;
        }
        self.equations.solve_many(&self.adjoint, &mut self.moved);
        self.complete = false;
    }

    /// a + W A⁻¹ B and ∂r/∂v.
    fn complete_jacobian(&mut self) {
        let wide = self.wide;
        self.compliance.gemm(1.0, &self.weights, &self.moved, 0.0);
        (0..wide).for_each(|m| self.compliance[(m, m)] += self.beam.axial_flexibility);
        self.jacobian.gemm(1.0, &self.compliance, self.cycle.jacobian(), 0.0);
        (0..wide).for_each(|m| self.jacobian[(m, m)] += 1.0);
        self.complete = true;
    }

    /// ∂q/∂scalar and ∂r/∂scalar at fixed u.
    fn differentiate_by(&mut self, scalar: Scalar) {
        let (modes, index) = (self.modes(), scalar.index());
        let mut right = std::mem::take(&mut self.right);
        match scalar {
            Scalar::AngularFrequency => {
                self.equations.by_frequency(&self.q, &mut right);
                if self.contact.is_some() && self.cycle.by_frequency().iter().any(|d| *d != 0.0) {
                    let mut contact = std::mem::take(&mut self.modal_by[index]);
                    self.project(self.cycle.by_frequency(), &mut contact);
                    right.iter_mut().zip(&contact).for_each(|(r, c)| *r += c);
                    self.modal_by[index] = contact;
                }
                right.iter_mut().for_each(|r| *r = -*r);
            }
            Scalar::Level => {
                for (k, right) in right.chunks_exact_mut(modes).enumerate() {
                    let shapes = right.iter_mut().zip(&self.beam.excitation_shape);
                    shapes.for_each(|(r, e)| *r = self.waveform[k] * e);
                }
            }
            Scalar::SelfExcitation => {
                self.equations.by_self_excitation(&self.q, &mut right);
                right.iter_mut().for_each(|r| *r = -*r);
            }
            Scalar::Parameter => right.fill(0.0),
        }
        let moved = &mut self.modal_by[index];
        if right.iter().all(|r| *r == 0.0) || !self.equations.solve(&right, moved) {
            moved.fill(0.0);
        }
        self.right = right;
        let by = &mut self.by[index];
        by.fill(0.0);
        for (column, q) in self.weights.as_slice().chunks_exact(self.wide).zip(&self.modal_by[index]) {
            by.iter_mut().zip(column).for_each(|(b, w)| *b -= w * q);
        }
        if scalar == Scalar::AngularFrequency && self.contact.is_some() {
            let series = self.beam.axial_flexibility;
            by.iter_mut().zip(self.cycle.by_frequency()).for_each(|(b, rate)| *b += series * rate);
        }
    }

    /// φ of an output.
    fn output_shape(&self, node: usize) -> &'a [f64] {
        let beam: &'a ModalBeam = self.beam;
        beam.sensors.get(node).map_or(&beam.excitation_shape, |sensor| &sensor.shape)
    }

    /// Coefficients of the displacement (m) where the modes have the values `shape`.
    fn output(&self, shape: &[f64]) -> Vec<f64> {
        let dot = |q: &[f64]| q.iter().zip(shape).map(|(q, phi)| q * phi).sum();
        self.q.chunks_exact(self.modes()).map(dot).collect()
    }

    /// Energy the modal damping takes per cycle (J).
    pub fn viscous_energy(&self, angular_frequency: f64) -> f64 {
        let modes = self.modes();
        let mut sum = 0.0;
        for i in 0..modes {
            let damping = 2.0 * self.beam.damping_ratio[i] * self.beam.angular_frequency[i];
            for h in 1..=self.harmonics {
                let (c, s) = (self.q[(2 * h - 1) * modes + i], self.q[2 * h * modes + i]);
                sum += damping * angular_frequency * (h * h) as f64 * (c * c + s * s);
            }
        }
        std::f64::consts::PI * sum
    }
}

/// Mean square of the basis function with coefficient `k`: 1 for the bias, ½ for the rest.
fn mean_square(k: usize) -> f64 {
    if k == 0 { 1.0 } else { 0.5 }
}

impl PeriodicSystem for Balance<'_> {
    fn unknowns(&self) -> usize {
        self.wide
    }

    fn evaluate(&mut self, x: &[f64], at: &Operating, scalars: &[Scalar]) -> Result<f64, HarmonicError> {
        self.contact_force(at.angular_frequency, x, 0.0)?;
        self.respond(at)?;
        let series = self.beam.axial_flexibility;
        let mut scale = 0.0_f64;
        for (((r, x), u), force) in self.residual.iter_mut().zip(x).zip(&self.displacement).zip(&self.force) {
            *r = x + series * force - u;
            scale = scale.max(x.abs()).max(u.abs());
        }
        if self.contact.is_some() {
            self.differentiate();
        }
        scalars.iter().for_each(|scalar| self.differentiate_by(*scalar));
        Ok(scale)
    }

    fn residual(&self) -> &[f64] {
        &self.residual
    }

    fn jacobian(&mut self) -> &DMatrix<f64> {
        if self.contact.is_some() && !self.complete {
            self.complete_jacobian();
        }
        &self.jacobian
    }

    fn by(&self, scalar: Scalar) -> &[f64] {
        &self.by[scalar.index()]
    }

    fn observe(&mut self, node: usize, order: usize, out: &mut Observation) {
        let (modes, wide) = (self.modes(), self.wide);
        let shape = self.output_shape(node);
        out.value = [0.0; 2];
        out.by_scalars = [[0.0; 4]; 2];
        for row in &mut out.by_unknowns {
            row.clear();
            row.resize(wide, 0.0);
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
            if self.contact.is_none() {
                continue;
            }
            // −φ A⁻¹ B ∂T/∂u.
            let columns = self.moved.as_slice().chunks_exact(self.q.len());
            let by_force: Vec<f64> = columns.map(|column| seen(&column[span.clone()])).collect();
            let columns = self.cycle.jacobian().as_slice().chunks_exact(wide);
            for (by, column) in out.by_unknowns[part].iter_mut().zip(columns) {
                *by = -column.iter().zip(&by_force).map(|(k, s)| k * s).sum::<f64>();
            }
        }
    }

    fn forget(&mut self) {
        self.cycle.forget();
        self.equations.forget();
    }

    fn nodes(&self) -> usize {
        self.beam.sensors.len() + 1
    }

    fn harmonics(&self) -> usize {
        self.harmonics
    }

    fn guess(&mut self, at: &Operating, x: &mut [f64]) -> Result<(), HarmonicError> {
        let excitation: Vec<f64> = self.waveform.iter().map(|f| at.level * f).collect();
        guess::forced(self, at.angular_frequency, &excitation)?;
        self.weigh();
        x.copy_from_slice(&self.start());
        Ok(())
    }

    fn nodes_along(&mut self, unknowns: &[f64], scalars: &[f64; 4], out: &mut [Vec<f64>]) {
        let modes = self.modes();
        self.right.fill(0.0);
        if self.contact.is_some() {
            let mut force = vec![0.0; self.wide];
            for (column, change) in self.cycle.jacobian().as_slice().chunks_exact(self.wide).zip(unknowns) {
                force.iter_mut().zip(column).for_each(|(f, k)| *f += k * change);
            }
            for (column, change) in self.moved.as_slice().chunks_exact(self.right.len()).zip(&force) {
                self.right.iter_mut().zip(column).for_each(|(q, s)| *q -= s * change);
            }
        }
        for (by, change) in self.modal_by.iter().zip(scalars).filter(|(_, change)| **change != 0.0) {
            self.right.iter_mut().zip(by).for_each(|(q, d)| *q += d * change);
        }
        for (node, coefficients) in out.iter_mut().enumerate() {
            let shape = self.output_shape(node);
            coefficients.clear();
            coefficients.extend(
                self.right
                    .chunks_exact(modes)
                    .map(|q| q.iter().zip(shape).map(|(q, phi)| q * phi).sum::<f64>()),
            );
        }
    }

    fn resume(&self, point: &Point, x: &mut [f64]) -> bool {
        let known = point.contacts.first().filter(|contact| contact.displacement.len() == x.len());
        known.is_some_and(|contact| {
            x.copy_from_slice(&contact.displacement);
            true
        })
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

    fn describe(&mut self, x: &[f64], at: &Operating) -> Result<Point, HarmonicError> {
        let nodes: Vec<Vec<f64>> =
            (0..self.nodes()).map(|node| self.output(self.output_shape(node))).collect();
        let contacts = match &self.contact {
            None => Vec::new(),
            Some(_) => {
                let summary = self.cycle.summary();
                vec![Contacting {
                    dissipated_energy: summary.dissipated_energy,
                    equivalent_stiffness: summary.equivalent_stiffness,
                    stick_fraction: summary.stick_fraction,
                    displacement: x.to_vec(),
                    force: self.force.clone(),
                }]
            }
        };
        let driven = self.output(&self.beam.excitation_shape);
        Ok(Point {
            angular_frequency: at.angular_frequency,
            level: at.level,
            amplitude: nodes.iter().map(|node| self.extremum.of(node).1).collect(),
            nodes,
            contacts,
            work: at.level * work_per_cycle(&self.waveform, &driven),
            stable: None,
            error_estimate: 0.0,
            resolved: true,
            harmonics: self.harmonics,
            iterations: 0,
        })
    }
}

fn check_beam(beam: &ModalBeam) -> Result<(), HarmonicError> {
    let modes = beam.angular_frequency.len();
    if modes == 0 {
        return Err(HarmonicError::InvalidInput("the beam has no modes"));
    }
    let same_length = [&beam.damping_ratio, &beam.contact_shape, &beam.excitation_shape];
    if same_length.iter().any(|v| v.len() != modes) || beam.shortening.len() != modes * modes {
        return Err(HarmonicError::InvalidInput("the beam's arrays do not have one entry per mode"));
    }
    let all =
        same_length.iter().flat_map(|v| v.iter()).chain(&beam.angular_frequency).chain(&beam.shortening);
    if all.chain([&beam.axial_flexibility]).any(|x| !x.is_finite()) {
        return Err(HarmonicError::InvalidInput("the beam has a value that is not finite"));
    }
    if beam.angular_frequency.iter().any(|w| *w <= 0.0) || beam.axial_flexibility < 0.0 {
        return Err(HarmonicError::InvalidInput(
            "a natural frequency or the axial flexibility is not positive",
        ));
    }
    Ok(())
}
