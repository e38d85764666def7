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
//! Where other elements act, the displacement of each of their ports joins the unknowns: `r_p = v_p + a_p T_p − u_p(q)`
//! with `u_p = b_p·q − γ_p ½ qᵀG q`. Forces along the shortening go into A by `Σ γ_p T_p`, the others to the right side by
//! `Σ b_p T_p`. The equations keep their form with the weights of all ports stacked, and their forces stacked.

mod beyond;
mod by_parameter;
mod check;
mod derivatives;
mod elements;
pub(crate) mod guess;
mod periodic;
mod ports;
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
use crate::system::{ModalBeam, Port};
use check::check_beam;
use elements::{Acting, acting};
use ports::{CondensedPort, system_of};
use varied::{Varied, attached};

pub(crate) use ports::Ports;

/// The port, and its name, of a mode from whose equation a damper is moved.
const SHIFTED_MODE: &str = "mode";

/// Which coefficients a balance carries.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Extent {
    /// Highest harmonic H of the modes.
    pub harmonics: usize,
    /// Highest harmonic of the contact, from H to 2 H: beyond that nothing of it is seen.
    pub contact: usize,
    /// Ports besides that of the contact.
    pub ports: Ports,
}

/// What a balance works in, for another of the same extent, number of modes and method to go on with.
#[derive(Debug)]
pub(crate) struct Workspace {
    extent: Extent,
    cycle: ContactMap,
    /// Those of the other laws.
    maps: Vec<ContactMap>,
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
    names: Ports,
    /// That of the contact first.
    ports: Vec<CondensedPort>,
    /// Mean square of each row's basis function.
    mean_squares: Vec<f64>,
    acting: Vec<Acting>,
    varied: Option<Varied<'a>>,
    /// Swing of the normal load, as [`PeriodicContact::load_swing`].
    load_swing: Vec<f64>,
    /// Displacement (m) at which the contact that never moved has no force.
    static_offset: f64,
    /// Displacement (m) from the static_offset that the contact was last evaluated for.
    evaluated: Vec<f64>,
    /// Coefficients of the contact force (N).
    force: Vec<f64>,
    /// Coefficients of the forces (N) at all ports, and the unknowns they belong to.
    forces: Vec<f64>,
    unknown: Vec<f64>,
    /// `Σ γ_p T_p`: what pulls along the shortening.
    tension: Vec<f64>,
    /// Coefficients of the displacements (m) of all ports by the modes.
    moved: Vec<f64>,
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
        let extent = Extent { harmonics, contact: 2 * harmonics, ports: Ports::of(beam) };
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
        let Extent { harmonics, contact: highest, ref ports } = *extent;
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
        let system = system_of(beam)?;
        let condensed = ports.condensed(&system, modes, wide, count);
        let unknowns = condensed.last().map_or(wide, |port| port.rows.end);
        let left = left.filter(|left| left.extent == *extent && left.equations.modes() == modes);
        let (cycle, maps, equations, matrices) = match left {
            Some(left) => (left.cycle, left.maps, left.equations.renewed(beam), left.matrices),
            None => (
                ContactMap::new(HarmonicSet::full(highest), method),
                Vec::new(),
                ModalEquations::new(beam, harmonics),
                Matrices::default(),
            ),
        };
        let acting = acting(&system, ports, &condensed, method, maps);
        let mut mean_squares = vec![0.5; unknowns];
        condensed.iter().for_each(|port| mean_squares[port.rows.start] = 1.0);
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
            names: ports.clone(),
            ports: condensed,
            mean_squares,
            acting,
            varied: None,
            load_swing: Vec::new(),
            static_offset: 0.0,
            evaluated: vec![0.0; wide],
            force: vec![0.0; wide],
            forces: vec![0.0; unknowns],
            unknown: vec![0.0; unknowns],
            tension: vec![0.0; wide],
            moved: vec![0.0; unknowns],
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
    pub fn ports(&self) -> &Ports {
        &self.names
    }

    /// Moves a damper (1/s) from the equation of `mode` to its other side, where it is an element at [`Self::shifted`].
    ///
    /// A free vibration is a pole of the modes' compliance where the contact carries little; with a damper in the mode
    /// that resonates the compliance has none, and the force of the damper is taken away again.
    pub fn shift_damping(&mut self, mode: usize, rate: f64) {
        let place = self.names.place(SHIFTED_MODE);
        if let Some(port) = place.and_then(|place| self.ports.get(place)) {
            let arm = port.shape[mode];
            self.equations.add_damping(mode, rate);
            self.acting.push(Acting::Damper { rows: port.rows.clone(), damping: -rate / (arm * arm) });
        }
    }

    /// The port at which the damper of `mode` is taken away.
    pub fn shifted(beam: &ModalBeam, mode: usize) -> Port {
        Port::linear(SHIFTED_MODE, vec![(mode, beam.contact_shape[mode])])
    }

    /// Names and displacements (m), by the modes of the last evaluation, of all ports to which this balance or one of
    /// another beam may be condensed besides the contact's.
    pub fn at_ports(&self) -> Result<Vec<(String, Vec<f64>)>, HarmonicError> {
        let straight = self.displacement_along(&self.beam.contact_shape);
        let shortening: Vec<f64> = straight.iter().zip(&self.displacement).map(|(c, u)| c - u).collect();
        let system = system_of(self.beam)?;
        let others = system.ports.iter().enumerate().filter(|(place, _)| !system.sensors.contains(place));
        let displaced = |port: &Port| {
            let port = CondensedPort::new(port, self.modes(), 0..0);
            let linear = self.displacement_along(&port.shape);
            linear.iter().zip(&shortening).map(|(u, h)| u - port.shortening * h).collect()
        };
        Ok(others.map(|(_, port)| (port.name.clone(), displaced(port))).collect())
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
        self.unknowns_under(force)
    }

    /// The unknowns under a force on the contact: its displacement once the series spring has yielded, and what the
    /// modes give of the others.
    fn unknowns_under(&self, force: &[f64]) -> Vec<f64> {
        let series = self.beam.axial_flexibility;
        let contact = self.displacement.iter().zip(force).map(|(u, force)| u - series * force);
        contact.chain(self.moved[self.wide..].iter().copied()).collect()
    }

    /// Whether the modes are all there is to solve for.
    fn is_linear(&self) -> bool {
        self.contact.is_none() && self.has_contact_alone()
    }

    /// Whether it is condensed to no more than the contact's displacement.
    fn has_contact_alone(&self) -> bool {
        self.ports.len() == 1 && self.acting.is_empty()
    }

    /// What it works in, for another to go on with.
    pub fn into_workspace(self) -> Workspace {
        let contact = self.wide / 2;
        let extent = Extent { harmonics: self.harmonics, contact, ports: self.names };
        let map = |acting| if let Acting::Law { map, .. } = acting { Some(*map) } else { None };
        let maps = self.acting.into_iter().filter_map(map).collect();
        Workspace { extent, cycle: self.cycle, maps, equations: self.equations, matrices: self.matrices }
    }

    /// The unknowns of the displacement and the contact force last evaluated.
    pub fn start(&self) -> Vec<f64> {
        self.unknowns_under(&self.force)
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

    /// Writes the displacements of all ports and the weights for the modal coefficients.
    pub fn weigh(&mut self) {
        let (modes, unknowns) = (self.modes(), self.residual.len());
        self.moved.fill(0.0);
        for port in &self.ports {
            let (rows, moved) = (port.rows.clone(), &mut self.moved[port.rows.clone()]);
            for i in 0..modes {
                let b = port.shape[i];
                if port.shortening == 0.0 {
                    for (k, moved) in moved.iter_mut().enumerate() {
                        let place = k * modes + i;
                        self.matrices.weights.as_mut_slice()[place * unknowns + rows.start + k] = b;
                        *moved += b * self.q[place];
                    }
                    continue;
                }
                // w_i = b_i − γ (G q)_i, and u = ½ Σ (w_i + b_i) q_i.
                self.shape.fill(0.0);
                self.shape[0] = b;
                let row = &self.beam.shortening[i * modes..(i + 1) * modes];
                for (s, q) in self.shape.iter_mut().zip(self.q.chunks_exact(modes)) {
                    *s -= port.shortening * row.iter().zip(q).map(|(g, q)| g * q).sum::<f64>();
                }
                let block = &mut self.block[..rows.len() * self.count];
                multiplication(&self.shape, self.harmonics, rows.len(), block);
                for (k, column) in block.chunks_exact(rows.len()).enumerate() {
                    let place = k * modes + i;
                    let weights = &mut self.matrices.weights.as_mut_slice()[place * unknowns..][rows.clone()];
                    weights.copy_from_slice(column);
                    let q = 0.5 * self.q[place];
                    moved.iter_mut().zip(column).for_each(|(u, w)| *u += w * q);
                    moved[k] += b * q;
                }
            }
        }
        self.displacement.copy_from_slice(&self.moved[..self.wide]);
    }

    /// Projection of the stacked forces, `P[T w_i]` and the rest, with the weights of the last evaluation.
    fn project(&self, forces: &[f64], out: &mut [f64]) {
        let modes = self.modes();
        for (place, column) in self.matrices.weights.as_slice().chunks_exact(forces.len()).enumerate() {
            let terms = forces.iter().zip(column).zip(&self.mean_squares);
            let sum: f64 = terms.map(|((t, w), mean_square)| mean_square * t * w).sum();
            out[place] = sum / mean_square(place / modes);
        }
    }

    /// q under the forces of the last evaluation, and the weights.
    fn respond(&mut self, at: &Operating) -> Result<(), HarmonicError> {
        let (modes, beam) = (self.modes(), self.beam);
        self.tension.fill(0.0);
        for port in self.ports.iter().filter(|port| port.shortening != 0.0) {
            let forces = &self.forces[port.rows.clone()];
            self.tension.iter_mut().zip(forces).for_each(|(t, force)| *t += port.shortening * force);
        }
        let singular = HarmonicError::InvalidInput("the modal equations are singular at this frequency");
        if !self.equations.set(at, &self.tension) {
            return Err(singular);
        }
        for (k, right) in self.right.chunks_exact_mut(modes).enumerate() {
            let excitation = at.level * self.waveform[k];
            right.iter_mut().zip(&beam.excitation_shape).for_each(|(r, e)| *r = excitation * e);
            for port in &self.ports {
                let force = self.forces[port.rows.start + k];
                right.iter_mut().zip(&port.shape).for_each(|(r, b)| *r -= force * b);
            }
        }
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
        self.build(at.parameter)?;
        self.follow_contact(at.angular_frequency, &x[..self.wide], 0.0, alone)?;
        self.unknown.copy_from_slice(x);
        self.forces.fill(0.0);
        self.forces[..self.wide].copy_from_slice(&self.force);
        for acting in &mut self.acting {
            acting.act(at.angular_frequency, x, &mut self.forces)?;
        }
        self.respond(at)?;
        for port in &self.ports {
            for row in port.rows.clone() {
                self.residual[row] = x[row] + port.flexibility * self.forces[row] - self.moved[row];
            }
        }
        let terms = x[..self.wide].iter().chain(&self.displacement);
        Ok(terms.fold(0.0_f64, |scale, term| scale.max(term.abs())))
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
        let by_laws: f64 = self.acting.iter().map(|acting| acting.dissipated(&self.moved)).sum();
        std::f64::consts::PI * sum + by_laws
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
