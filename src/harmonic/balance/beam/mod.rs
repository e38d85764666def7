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
//!
//! A beam that stretches adds the shortening `h = ½ qᵀG q` to the unknowns, and the force `2 κ h` that acts along
//! `G q = c − w`: in A it goes with −T. Drag adds the displacement y at the excitation, the string of a hanging mass
//! its stretch, which couples to h. The equations keep their form with W, the weights of `G q`, `φ(S)` and the stretch
//! stacked, and their forces stacked.

mod beyond;
mod check;
mod damping_shift;
mod derivatives;
mod drag;
pub(crate) mod guess;
mod periodic;
#[cfg(test)]
mod tests;
mod truncation;
mod varied;

use nalgebra::DMatrix;

use super::modal::ModalEquations;
use crate::harmonic::newton::Contacting;
use crate::harmonic::newton::system::{Observation, Operating, PeriodicSystem, Scalar};
use crate::harmonic::period::map::ContactMap;
use crate::harmonic::period::{Cycle, PeriodicContact};
use crate::harmonic::{HarmonicError, LoadedContact, Method, Point};
use crate::numeric::HarmonicSet;
use crate::numeric::extremum::Extremum;
use crate::numeric::fourier::{coefficient_count, multiplication, work_per_cycle};
use crate::system::ModalBeam;
use check::check_beam;
use damping_shift::Relief;
use drag::Drag;
use varied::{Varied, attached};

/// What the balance is condensed to besides the contact's displacement.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct Signals {
    /// The shortening, for stretching and for a string.
    pub shortening: bool,
    /// The displacement at the excitation, for drag.
    pub excitation: bool,
    /// The stretch of a hanging mass's string, which the shortening adds to.
    pub string: bool,
    /// That of a mode from whose equation a damper is moved.
    pub mode: Option<usize>,
}

impl Signals {
    /// What `beam` needs.
    pub fn of(beam: &ModalBeam) -> Self {
        Self {
            shortening: beam.pulls_along(),
            excitation: beam.quadratic_damping != 0.0,
            string: beam.string_stiffness != 0.0,
            mode: None,
        }
    }

    /// What either needs.
    pub fn or(self, other: Self) -> Self {
        Self {
            shortening: self.shortening || other.shortening,
            excitation: self.excitation || other.excitation,
            string: self.string || other.string,
            mode: self.mode.or(other.mode),
        }
    }
}

/// Which coefficients a balance carries.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Extent {
    /// Highest harmonic H of the modes.
    pub harmonics: usize,
    /// Highest harmonic of the contact, from H to 2 H: beyond that nothing of it is seen.
    pub contact: usize,
    /// Signals besides.
    pub signals: Signals,
}

/// What a balance works in, for another of the same extent, number of modes and method to go on with.
#[derive(Debug)]
pub(crate) struct Workspace {
    extent: Extent,
    cycle: ContactMap,
    equations: ModalEquations,
    matrices: Matrices,
}

/// The large matrices. They take their sizes where they are first needed: for residuals alone most are not.
#[derive(Debug, Default)]
struct Matrices {
    /// W and what is stacked on it, `unknowns × unknowns of the modes`.
    weights: DMatrix<f64>,
    /// B, and A⁻¹ B.
    adjoint: DMatrix<f64>,
    moved: DMatrix<f64>,
    /// ∂forces/∂unknowns, block by block, where there is more than the contact.
    law: DMatrix<f64>,
    /// a + W A⁻¹ B.
    compliance: DMatrix<f64>,
    jacobian: DMatrix<f64>,
}

/// The equations of one beam, contact and set of harmonics.
///
/// Outputs are the beam's sensors and, last, the point of excitation.
#[derive(Debug)]
pub(crate) struct Balance<'a> {
    pub beam: &'a ModalBeam,
    pub contact: Option<LoadedContact<'a>>,
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
    /// Coefficients of the contact.
    wide: usize,
    signals: Signals,
    drag: Option<Box<Drag>>,
    relief: Option<Relief>,
    varied: Option<Varied<'a>>,
    /// Swing of the normal load, as [`PeriodicContact::load_swing`].
    load_swing: Vec<f64>,
    /// Displacement (m) at which the contact that never moved has no force.
    static_offset: f64,
    /// Displacement (m) from the static_offset that the contact was last evaluated for.
    evaluated: Vec<f64>,
    /// Coefficients of the contact force (N).
    force: Vec<f64>,
    /// Contact force less the force of stretching.
    tension: Vec<f64>,
    /// Shortening h (m) of the last evaluation.
    shortening: Vec<f64>,
    /// ∂forces/∂Ω, all of them.
    rates: Vec<f64>,
    right: Vec<f64>,
    /// Coefficients of w_i, and multiplication by it.
    shape: Vec<f64>,
    block: Vec<f64>,
    matrices: Matrices,
    residual: Vec<f64>,
    /// Whether the Jacobian is that of the last evaluation: it costs two large products, and a solution needs none.
    complete: bool,
    /// Where the last evaluation was, while its derivatives are not made: a trial step that is refused needs none, nor
    /// does a solution. With the scalars by which they are asked for.
    undifferentiated: Option<Operating>,
    asked: Vec<Scalar>,
    /// Whether there are derivatives, of whichever evaluation.
    differentiated: bool,
    by: [Vec<f64>; 4],
    /// ∂q/∂scalar at fixed u.
    modal_by: [Vec<f64>; 4],
}

impl<'a> Balance<'a> {
    /// Excitation at level 1: `waveform`, coefficients `[a0, c1, s1, …]` (N); those beyond `harmonics` are
    /// left out.
    pub fn new(
        beam: &'a ModalBeam,
        contact: Option<LoadedContact<'a>>,
        waveform: &[f64],
        harmonics: usize,
        method: Method,
    ) -> Result<Self, HarmonicError> {
        let extent = Extent { harmonics, contact: 2 * harmonics, signals: Signals::of(beam) };
        Self::with(beam, contact, waveform, &extent, method, None)
    }

    /// As [`Balance::new`], with the coefficients of `extent`, in the workspace that another has left if that fits.
    pub fn with(
        beam: &'a ModalBeam,
        contact: Option<LoadedContact<'a>>,
        waveform: &[f64],
        extent: &Extent,
        method: Method,
        left: Option<Workspace>,
    ) -> Result<Self, HarmonicError> {
        let Extent { harmonics, contact: highest, signals } = *extent;
        check_beam(beam)?;
        if let Some(contact) = &contact
            && !contact.normal_load.is_finite()
        {
            return Err(HarmonicError::InvalidInput("the normal load is not finite"));
        }
        debug_assert!((harmonics..=2 * harmonics).contains(&highest));
        let (count, wide) = (coefficient_count(harmonics), coefficient_count(highest));
        let modes = beam.angular_frequency.len();
        let size = count * modes;
        let signal_count = [signals.shortening, signals.excitation, signals.string, signals.mode.is_some()];
        let more = signal_count.into_iter().filter(|there| *there).count();
        let unknowns = wide + more * count;
        let left = left.filter(|left| left.extent == *extent && left.equations.modes() == modes);
        let (cycle, equations, matrices) = match left {
            Some(left) => (left.cycle, left.equations.renewed(beam), left.matrices),
            None => (
                ContactMap::new(HarmonicSet::full(highest), method),
                ModalEquations::new(beam, harmonics),
                Matrices::default(),
            ),
        };
        let mut kept = waveform.to_vec();
        kept.resize(count, 0.0);
        let mut balance = Self {
            beam,
            contact,
            count,
            q: vec![0.0; size],
            displacement: vec![0.0; wide],
            waveform: kept,
            extremum: Extremum::default(),
            cycle,
            equations,
            harmonics,
            wide,
            signals,
            drag: signals.excitation.then(|| Box::new(Drag::new(harmonics))),
            relief: signals.mode.map(|mode| Relief::new(mode, count)),
            varied: None,
            load_swing: Vec::new(),
            static_offset: 0.0,
            evaluated: vec![0.0; wide],
            force: vec![0.0; wide],
            tension: vec![0.0; wide],
            shortening: vec![0.0; count],
            rates: vec![0.0; unknowns],
            right: vec![0.0; size],
            shape: vec![0.0; count],
            block: vec![0.0; wide * count],
            matrices,
            residual: vec![0.0; unknowns],
            complete: false,
            undifferentiated: None,
            asked: Vec::new(),
            differentiated: false,
            by: std::array::from_fn(|_| vec![0.0; unknowns]),
            modal_by: std::array::from_fn(|_| vec![0.0; size]),
        };
        sized(&mut balance.matrices.weights, unknowns, size);
        balance.cycle.forget();
        Ok(balance)
    }

    /// Lets the normal load swing by the coefficients `[c1, s1, …]` (N) about its mean.
    pub fn swing_load(&mut self, coefficients: &[f64]) {
        self.load_swing = coefficients.to_vec();
    }

    /// Lets the contact that never moved have no force at the displacement `static_offset` (m). One that slips forgets it; one
    /// that sticks all through a steady state keeps the force it was left with, and the shortening makes that a load
    /// along the beam.
    pub fn static_offset(&mut self, static_offset: f64) {
        self.static_offset = static_offset;
    }

    /// Number of modes.
    pub fn modes(&self) -> usize {
        self.beam.angular_frequency.len()
    }

    /// What it is condensed to besides the contact's displacement.
    pub fn signals(&self) -> Signals {
        self.signals
    }

    /// Coefficients of the contact force (N) of the last evaluation.
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

    /// The unknowns under a force on the contact: its displacement once the series spring has yielded, and what the
    /// modes give of the others.
    fn relieved(&self, force: &[f64]) -> Vec<f64> {
        let series = self.beam.axial_flexibility;
        let contact = self.displacement.iter().zip(force).map(|(u, force)| u - series * force);
        let mut unknowns: Vec<f64> = contact.collect();
        if self.signals.shortening {
            unknowns.extend_from_slice(&self.shortening);
        }
        if self.signals.excitation {
            unknowns.extend(self.displacement_along(&self.beam.excitation_shape));
        }
        if self.signals.string {
            unknowns.extend(self.displacement_along(&self.beam.string_stretch));
        }
        unknowns.extend(self.relieved_mode());
        unknowns
    }

    /// Whether the modes are all there is to solve for.
    fn is_linear(&self) -> bool {
        self.contact.is_none() && self.has_contact_alone()
    }

    /// Whether it is condensed to no more than the contact's displacement.
    fn has_contact_alone(&self) -> bool {
        self.signals == Signals::default()
    }

    /// First row of the signals of a kind, which follow the contact's.
    fn shortening_row(&self) -> usize {
        self.wide
    }

    fn excitation_row(&self) -> usize {
        self.wide + if self.signals.shortening { self.count } else { 0 }
    }

    fn string_row(&self) -> usize {
        self.excitation_row() + if self.signals.excitation { self.count } else { 0 }
    }

    /// Mean square of a row's basis function.
    fn row_mean_square(&self, row: usize) -> f64 {
        let bias = row == 0 || (row >= self.wide && (row - self.wide).is_multiple_of(self.count));
        if bias { 1.0 } else { 0.5 }
    }

    /// What it works in, for another to go on with.
    pub fn into_workspace(self) -> Workspace {
        let contact = self.wide / 2;
        let extent = Extent { harmonics: self.harmonics, contact, signals: self.signals };
        Workspace { extent, cycle: self.cycle, equations: self.equations, matrices: self.matrices }
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
        self.follow_contact(angular_frequency, u, series, false)?;
        Ok(&self.force)
    }

    /// Leaves the contact's force; with `alone` no derivatives can follow.
    fn follow_contact(
        &mut self,
        angular_frequency: f64,
        u: &[f64],
        series: f64,
        alone: bool,
    ) -> Result<(), HarmonicError> {
        let Some((law, normal_load)) = attached(&self.contact, &self.varied) else { return Ok(()) };
        let contact = PeriodicContact { law, normal_load, load_swing: &self.load_swing, compliance: series };
        self.evaluated.copy_from_slice(u);
        self.evaluated[0] -= self.static_offset;
        if alone {
            let set = HarmonicSet::full(self.wide / 2);
            return self.cycle.force_alone(
                &contact,
                angular_frequency,
                &self.evaluated,
                set,
                &mut self.force,
            );
        }
        self.cycle.evaluate_force(&contact, angular_frequency, &self.evaluated)?;
        self.force.copy_from_slice(self.cycle.force());
        Ok(())
    }

    /// Writes the displacement, the shortening and the weights for the modal coefficients.
    pub fn weigh(&mut self) {
        let (modes, wide, count) = (self.modes(), self.wide, self.count);
        let (rows, shortening, excitation) =
            (self.matrices.weights.nrows(), self.shortening_row(), self.excitation_row());
        let (string, relief) = (self.string_row(), self.relief_row());
        // u = ½ Σ (w_i + c_i) q_i.
        self.displacement.fill(0.0);
        for i in 0..modes {
            let relieved = self.relief_weight(i);
            self.shape.fill(0.0);
            self.shape[0] = self.beam.contact_shape[i];
            let row = &self.beam.shortening[i * modes..(i + 1) * modes];
            for (s, q) in self.shape.iter_mut().zip(self.q.chunks_exact(modes)) {
                *s -= row.iter().zip(q).map(|(g, q)| g * q).sum::<f64>();
            }
            multiplication(&self.shape, self.harmonics, wide, &mut self.block);
            for (k, column) in self.block.chunks_exact(wide).enumerate() {
                let place = k * modes + i;
                let weights = &mut self.matrices.weights.as_mut_slice()[place * rows..(place + 1) * rows];
                weights[..wide].copy_from_slice(column);
                if self.signals.shortening {
                    let along = &mut weights[shortening..shortening + count];
                    along.iter_mut().zip(column).for_each(|(g, w)| *g = -w);
                    along[k] += self.beam.contact_shape[i];
                }
                if self.signals.excitation {
                    weights[excitation + k] = self.beam.excitation_shape[i];
                }
                if self.signals.string {
                    weights[string + k] = self.beam.string_stretch.get(i).copied().unwrap_or(0.0);
                }
                if let Some(weight) = relieved {
                    weights[relief + k] = weight;
                }
                let q = 0.5 * self.q[place];
                self.displacement.iter_mut().zip(column).for_each(|(u, w)| *u += w * q);
                self.displacement[k] += self.beam.contact_shape[i] * q;
            }
        }
        if self.signals.shortening {
            for ((h, u), q) in
                self.shortening.iter_mut().zip(&self.displacement).zip(self.q.chunks_exact(modes))
            {
                *h = q.iter().zip(&self.beam.contact_shape).map(|(q, c)| q * c).sum::<f64>() - u;
            }
        }
    }

    /// Projection of the stacked forces, `P[T w_i]` and the rest, with the weights of the last evaluation.
    fn project(&self, forces: &[f64], out: &mut [f64]) {
        let modes = self.modes();
        for (place, column) in self.matrices.weights.as_slice().chunks_exact(forces.len()).enumerate() {
            let terms = forces.iter().zip(column).enumerate();
            let sum: f64 = terms.map(|(row, (t, w))| self.row_mean_square(row) * t * w).sum();
            out[place] = sum / mean_square(place / modes);
        }
    }

    /// q under the forces of the contact's and the drag's last evaluation and the unknown shortening and stretch of the
    /// string, and the weights.
    fn respond(&mut self, at: &Operating, shortening: &[f64], string: &[f64]) -> Result<(), HarmonicError> {
        let (modes, beam) = (self.modes(), self.beam);
        self.tension.copy_from_slice(&self.force);
        let stretching = 2.0 * beam.stretching_stiffness;
        self.tension.iter_mut().zip(shortening).for_each(|(t, h)| *t -= stretching * h);
        self.tension.iter_mut().zip(string).for_each(|(t, y)| *t += beam.string_stiffness * y);
        let singular = HarmonicError::InvalidInput("the modal equations are singular at this frequency");
        if !self.equations.set(at, &self.tension) {
            return Err(singular);
        }
        for (k, right) in self.right.chunks_exact_mut(modes).enumerate() {
            let drag = self.drag.as_ref().map_or(0.0, |drag| drag.force[k]);
            let (excitation, force) = (at.level * self.waveform[k] - drag, self.force[k]);
            let shapes = beam.excitation_shape.iter().zip(&beam.contact_shape);
            right.iter_mut().zip(shapes).for_each(|(r, (e, c))| *r = excitation * e - force * c);
            let shortened = beam.string_stiffness * shortening.get(k).copied().unwrap_or(0.0);
            right.iter_mut().zip(&beam.string_stretch).for_each(|(r, s)| *r += shortened * s);
        }
        self.relieve_right();
        if !self.equations.solve(&self.right, &mut self.q) {
            return Err(singular);
        }
        self.weigh();
        Ok(())
    }

    /// The residual; returns the size of its terms.
    pub fn balance(&mut self, x: &[f64], at: &Operating) -> Result<f64, HarmonicError> {
        self.balance_with(x, at, false)
    }

    /// The residual alone: no derivatives can follow.
    pub fn balance_alone(&mut self, x: &[f64], at: &Operating) -> Result<f64, HarmonicError> {
        self.balance_with(x, at, true)
    }

    fn balance_with(&mut self, x: &[f64], at: &Operating, alone: bool) -> Result<f64, HarmonicError> {
        let (shortening, excitation) = (self.shortening_row(), self.excitation_row());
        let (string, relief) = (self.string_row(), self.relief_row());
        self.build(at.parameter)?;
        self.follow_contact(at.angular_frequency, &x[..self.wide], 0.0, alone)?;
        if let Some(drag) = &mut self.drag {
            drag.evaluate(self.beam.quadratic_damping, at.angular_frequency, &x[excitation..string]);
        }
        self.relieve_force(x, at.angular_frequency);
        self.respond(at, &x[shortening..excitation], &x[string..relief])?;
        let series = self.beam.axial_flexibility;
        let mut scale = 0.0_f64;
        for (((r, x), u), force) in self.residual.iter_mut().zip(x).zip(&self.displacement).zip(&self.force) {
            *r = x + series * force - u;
            scale = scale.max(x.abs()).max(u.abs());
        }
        if self.signals.shortening {
            let rest = self.residual[shortening..].iter_mut().zip(&x[shortening..]);
            rest.zip(&self.shortening).for_each(|((r, x), h)| *r = x - h);
        }
        if self.signals.excitation {
            let found = self.displacement_along(&self.beam.excitation_shape);
            let rest = self.residual[excitation..].iter_mut().zip(&x[excitation..]);
            rest.zip(&found).for_each(|((r, x), y)| *r = x - y);
        }
        if self.signals.string {
            let found = self.displacement_along(&self.beam.string_stretch);
            let rest = self.residual[string..].iter_mut().zip(&x[string..]);
            rest.zip(&found).for_each(|((r, x), y)| *r = x - y);
        }
        let found = self.relieved_mode();
        let rest = self.residual[relief..].iter_mut().zip(&x[relief..]);
        rest.zip(&found).for_each(|((r, x), p)| *r = x - p);
        Ok(scale)
    }

    /// φ of an output.
    fn output_shape(&self, node: usize) -> &'a [f64] {
        let beam: &'a ModalBeam = self.beam;
        beam.sensors.get(node).map_or(&beam.excitation_shape, |sensor| &sensor.shape)
    }

    /// Coefficients of the displacement (m) where the modes have the values `shape`.
    pub fn displacement_along(&self, shape: &[f64]) -> Vec<f64> {
        let dot = |q: &[f64]| q.iter().zip(shape).map(|(q, phi)| q * phi).sum();
        self.q.chunks_exact(self.modes()).map(dot).collect()
    }

    /// Energy that modal damping and drag take per cycle (J).
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
        let drag = self.drag.as_ref();
        let drag = drag.map_or(0.0, |drag| {
            work_per_cycle(&drag.force, &self.displacement_along(&self.beam.excitation_shape))
        });
        std::f64::consts::PI * sum + drag
    }
}

/// Gives a matrix its size, zero where it had another.
fn sized(matrix: &mut DMatrix<f64>, rows: usize, columns: usize) {
    if matrix.shape() != (rows, columns) {
        *matrix = DMatrix::zeros(rows, columns);
    }
}

/// Mean square of the basis function with coefficient `k`: 1 for the bias, ½ for the rest.
fn mean_square(k: usize) -> f64 {
    if k == 0 { 1.0 } else { 0.5 }
}
