//! Harmonic balance of a system that keeps its modal coordinates, condensed to the displacements of its ports.
//!
//! The port of the first element is the contact. With `w_i(t) = b_i − γ Σ G_ij q_j(t)` its displacement,
//! `u = b·q − γ ½ qᵀG q`, has `∂u/∂q_i = w_i`, and its force T acts on mode `i` by `T w_i`. Displacements with harmonics
//! `0..=H` give `u` harmonics `0..=2H`, and Galerkin projection of `T w_i` on `0..=H` sees `T`'s harmonics
//! `0..=2H` only: the contact is therefore one map between signals of `4H + 1` coefficients, and
//! everything else here is exact algebra on coefficients. Other ports have `2H + 1`.
//!
//! Under given forces the modal equations are linear, `A(T) q = level · f − P[T b]`, and are solved
//! ([`ModalEquations`]): forces at ports that shorten go into A by `Σ γ_p T_p`, all of them to the right side by
//! `Σ b_p T_p`. The flexibility `a` in series with an element yields by `a T`, and the unknown is the
//! displacement v that is left for the element itself, so that a step of a law needs no iteration. What
//! remains are equations whose number does not depend on that of the modes,
//!
//! `r(v) = v + a T(v) − (b·q − γ ½ qᵀG q) = 0`, `∂r/∂v = 1 + (a + W A⁻¹ B) ∂T/∂v`,
//!
//! W being multiplication by `w_i` and B its adjoint, the projection of `T w_i`, of all ports stacked. A resonator is a dynamic
//! stiffness at its port, harmonic by harmonic, and adds no unknowns.
//!
//! A limit that follows the velocity follows that in front of the flexibility. The contact's unknown is then `x = v + a T` of its
//! law alone, which is carried over the period behind a spring of the compliance a, with the derivative `T'` by x; F being all
//! that pulls there, `∂r/∂x = 1 − a T' + (a + W A⁻¹ B) F'`.

mod beyond;
mod blocks;
mod derivatives;
mod dynamic;
mod elements;
mod equations;
pub(crate) mod guess;
mod periodic;
mod ports;
mod resonator;
#[cfg(test)]
mod tests;
mod truncation;
mod unknowns;
mod weights;

use nalgebra::{Complex, DMatrix};

use super::assembly::Assembly;
use super::attached::Attached;
use crate::harmonic::modal_system::{ModalPort, ModalSystem};
use crate::harmonic::newton::system::{Observation, Operating, PeriodicSystem, Scalar};
use crate::harmonic::period::Cycle;
use crate::harmonic::{HarmonicError, Method, Point};
use crate::numeric::extremum::Extremum;
use crate::numeric::fourier::{coefficient_count, work_per_cycle};
use crate::numeric::multiplication::Multiplication;
use crate::system::{Port, System};
use elements::{Acting, Maps, acting};
use equations::ModalEquations;
use ports::{CondensedPort, can_be_in_front, completed, named};
use resonator::Resonator;

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
    maps: Maps,
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

impl Workspace {
    /// What another has left if that fits, else a new one.
    fn renewed(left: Option<Self>, extent: &Extent, system: &ModalSystem) -> Self {
        match left.filter(|left| left.extent == *extent && left.equations.modes() == system.modes()) {
            Some(left) => Self { equations: left.equations.renewed(system), ..left },
            None => Self {
                extent: extent.clone(),
                maps: Maps::default(),
                equations: ModalEquations::new(system, extent.harmonics),
                matrices: Matrices::default(),
            },
        }
    }
}

/// The equations of one system and set of harmonics.
///
/// Outputs are the sensors and, last, the point of excitation.
#[derive(Debug)]
pub(crate) struct Balance {
    pub system: ModalSystem,
    /// As it was given, but for ports without elements.
    completed: System,
    /// Coefficients per mode, `2H + 1`.
    pub count: usize,
    /// Modal coefficients of the last evaluation, coefficient after coefficient.
    pub q: Vec<f64>,
    waveform: Vec<f64>,
    /// Excitation per unit of the parameter.
    second: Vec<f64>,
    extremum: Extremum,
    equations: ModalEquations,
    harmonics: usize,
    /// Coefficients of the contact.
    wide: usize,
    names: Ports,
    /// All ports there are, for balances condensed to others.
    all_ports: Vec<(String, ModalPort)>,
    /// That of the contact first.
    ports: Vec<CondensedPort>,
    /// Mean square of each row's basis function.
    mean_squares: Vec<f64>,
    acting: Vec<Acting>,
    /// Coefficients of the forces (N) at all ports, and the unknowns they belong to.
    forces: Vec<f64>,
    unknown: Vec<f64>,
    /// Compliance (m/N) of the spring between the contact's unknown and its law, and the unknowns that the law has.
    series: f64,
    behind: Vec<f64>,
    /// Coefficients of the force (N) of the contact, without what hangs there.
    contact_force: Vec<f64>,
    /// `Σ γ_p T_p`: what pulls along the shortening.
    tension: Vec<f64>,
    /// Coefficients of the displacements (m) of all ports by the modes.
    moved: Vec<f64>,
    /// ∂forces/∂Ω, all of them.
    rates: Vec<f64>,
    right: Vec<f64>,
    /// Coefficients of what multiplies a mode's motion at a port, of that motion, and the multiplication.
    shape: Vec<f64>,
    mode: Vec<f64>,
    product: Multiplication,
    /// Coefficients of the shortening `½ qᵀG q` of the last evaluation.
    shorter: Vec<f64>,
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

impl Balance {
    /// The balance of `assembly`; what its waveform has beyond `harmonics` is left out.
    pub fn new(assembly: &Assembly, harmonics: usize, method: Method) -> Result<Self, HarmonicError> {
        let ports = Ports::of(&assembly.system);
        let extent = Extent { harmonics, contact: 2 * harmonics, ports };
        Self::with(assembly, &assembly.waveform, &extent, method, None)
    }

    /// As [`Balance::new`] under another `waveform`, with the coefficients of `extent`, in the workspace that another has
    /// left if that fits.
    pub fn with(
        assembly: &Assembly,
        waveform: &[f64],
        extent: &Extent,
        method: Method,
        left: Option<Workspace>,
    ) -> Result<Self, HarmonicError> {
        let Extent { harmonics, contact: highest, ref ports } = *extent;
        assembly.check()?;
        if !can_be_in_front(&assembly.system, ports) {
            let alone = "a limit that follows the velocity behind a flexibility needs a port of its own";
            return Err(HarmonicError::InvalidInput(alone));
        }
        debug_assert!((harmonics..=2 * harmonics).contains(&highest));
        let completed = completed(&assembly.system);
        let system = ModalSystem::new(&completed)?;
        let modes = system.modes();
        let (count, wide) = (coefficient_count(harmonics), coefficient_count(highest));
        let size = count * modes;
        let condensed = ports.condensed(&completed, modes, wide, count);
        let unknowns = condensed.last().map_or(wide, |port| port.rows.end);
        let Workspace { maps, equations, matrices, .. } = Workspace::renewed(left, extent, &system);
        let all_ports = named(&completed, &system);
        let series = if ports.in_front() { condensed[0].flexibility } else { 0.0 };
        let acting = acting(assembly, ports, &condensed, series, method, maps);
        let mut mean_squares = vec![mean_square(1); unknowns];
        condensed.iter().for_each(|port| mean_squares[port.rows.start] = mean_square(0));
        let mut kept = waveform.to_vec();
        kept.resize(count, 0.0);
        let mut second = assembly.second_waveform.clone();
        second.resize(count, 0.0);
        let mut balance = Self {
            system,
            completed,
            count,
            q: vec![0.0; size],
            waveform: kept,
            second,
            extremum: Extremum::default(),
            equations,
            harmonics,
            wide,
            names: ports.clone(),
            all_ports,
            ports: condensed,
            mean_squares,
            acting,
            forces: vec![0.0; unknowns],
            unknown: vec![0.0; unknowns],
            series,
            behind: vec![0.0; unknowns],
            contact_force: vec![0.0; wide],
            tension: vec![0.0; wide],
            moved: vec![0.0; unknowns],
            rates: vec![0.0; unknowns],
            right: vec![0.0; size],
            shape: vec![0.0; count],
            mode: vec![0.0; count],
            product: Multiplication::default(),
            shorter: vec![0.0; wide],
            matrices,
            residual: vec![0.0; unknowns],
            complete: false,
            undifferentiated: None,
            asked: Vec::new(),
            differentiated: false,
            by: std::array::from_fn(|_| vec![0.0; unknowns]),
            modal_by: std::array::from_fn(|_| vec![0.0; size]),
        };
        balance.acting.iter_mut().for_each(Acting::forget);
        Ok(balance)
    }

    /// Number of modes.
    pub fn modes(&self) -> usize {
        self.system.modes()
    }

    /// b of the contact's port.
    pub fn contact_shape(&self) -> &[f64] {
        &self.ports[0].shape
    }

    /// a of the contact's port (m/N).
    pub fn flexibility(&self) -> f64 {
        self.ports[0].flexibility
    }

    /// Rows of the sensors.
    pub fn sensors(&self) -> &[Vec<f64>] {
        let [sensors @ .., _] = self.system.observed.as_slice() else { return &[] };
        sensors
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

    /// The port at which the damper of `mode`, which moves the contact by `arm`, is taken away.
    pub fn shifted(mode: usize, arm: f64) -> Port {
        Port::linear(SHIFTED_MODE, vec![(mode, arm)])
    }

    /// Coefficients of the contact's displacement (m) by the modes of the last evaluation, before the flexibility in
    /// series yields.
    pub fn displacement(&self) -> &[f64] {
        &self.moved[..self.wide]
    }

    /// The law of the contact; `None` without one. It is the first there.
    fn contact(&self) -> Option<&Attached> {
        self.acting.iter().find_map(Acting::at_contact)
    }

    fn contact_mut(&mut self) -> Option<&mut Attached> {
        self.acting.iter_mut().find_map(|acting| match acting {
            Acting::Law { rows, attached } if rows.start == 0 => Some(&mut **attached),
            _ => None,
        })
    }

    /// Whether the contact has a law.
    pub fn has_contact(&self) -> bool {
        self.contact().is_some()
    }

    /// Coefficients of the contact force (N) of the last evaluation, without the pull of what hangs at the contact.
    pub fn force(&self) -> &[f64] {
        &self.contact_force
    }

    /// Coefficients `[a0, c1, s1, …]` of every mode, mode after mode, of the last evaluation.
    pub fn modal_coefficients(&self) -> Vec<f64> {
        let modes = self.modes();
        (0..modes).flat_map(|i| self.q.iter().skip(i).step_by(modes).copied()).collect()
    }

    /// Whether the modes are all there is to solve for.
    fn is_linear(&self) -> bool {
        self.acting.is_empty()
    }

    /// What it works in, for another to go on with.
    pub fn into_workspace(self) -> Workspace {
        let contact = self.wide / 2;
        let extent = Extent { harmonics: self.harmonics, contact, ports: self.names };
        Workspace { extent, maps: Maps::of(self.acting), equations: self.equations, matrices: self.matrices }
    }

    /// Energy dissipated in the contact per cycle (J) at the last evaluation.
    pub fn dissipated_energy(&self) -> f64 {
        work_per_cycle(self.force(), &self.behind[..self.wide])
    }

    /// The contact alone, driven by `u` given by its coefficients (harmonics `0..=2H`), behind a spring of
    /// the compliance `series` (m/N).
    pub fn contact_force(
        &mut self,
        angular_frequency: f64,
        u: &[f64],
        series: f64,
    ) -> Result<&[f64], HarmonicError> {
        let mut force = std::mem::take(&mut self.contact_force);
        let (own, mut done) = (self.series, Ok(()));
        if let Some(attached) = self.contact_mut() {
            attached.compliance = series;
            done = attached.evaluate_force(angular_frequency, u, false);
            attached.compliance = own;
            force.copy_from_slice(attached.force());
        }
        self.contact_force = force;
        done?;
        Ok(self.force())
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
        self.forces.fill(0.0);
        for acting in self.acting.iter_mut().filter(|acting| acting.hung().is_none()) {
            acting.act(at, x, alone, &mut self.forces)?;
        }
        self.contact_force.copy_from_slice(&self.forces[..self.wide]);
        self.take(x);
        let hung = self.acting.iter().filter_map(Acting::hung);
        hung.for_each(|hung| hung.act(at, &self.behind, &mut self.forces));
        self.respond(at)?;
        for port in &self.ports {
            for row in port.rows.clone() {
                self.residual[row] = self.behind[row] + port.flexibility * self.forces[row] - self.moved[row];
            }
        }
        let terms = x[..self.wide].iter().chain(self.displacement());
        Ok(terms.fold(0.0_f64, |scale, term| scale.max(term.abs())))
    }

    /// Takes the unknowns over, the contact's force being the last.
    fn take(&mut self, x: &[f64]) {
        self.unknown.copy_from_slice(x);
        self.behind.copy_from_slice(x);
        if self.series != 0.0 {
            self.behind.iter_mut().zip(&self.contact_force).for_each(|(v, force)| *v -= self.series * force);
        }
    }

    /// Coefficients of the displacement (m) where the modes have the values `shape`.
    pub fn displacement_along(&self, shape: &[f64]) -> Vec<f64> {
        let dot = |q: &[f64]| q.iter().zip(shape).map(|(q, phi)| q * phi).sum();
        self.q.chunks_exact(self.modes()).map(dot).collect()
    }

    /// Energy that modal damping, what hangs at the contact and drag take per cycle (J).
    pub fn viscous_energy(&self, angular_frequency: f64) -> f64 {
        let modes = self.modes();
        let mut sum = 0.0;
        for i in 0..modes {
            let damping = 2.0 * self.system.damping_ratio[i] * self.system.angular_frequency[i];
            for h in 1..=self.harmonics {
                let (c, s) = (self.q[(2 * h - 1) * modes + i], self.q[2 * h * modes + i]);
                sum += damping * angular_frequency * (h * h) as f64 * (c * c + s * s);
            }
        }
        let of_structure = self.acting.iter().filter_map(Acting::law).filter(|(rows, _)| rows.start > 0);
        let by_laws: f64 =
            of_structure.map(|(rows, law)| work_per_cycle(law.force(), &self.moved[rows.clone()])).sum();
        let at = Operating::forced(angular_frequency, 0.0);
        let lost = |acting: &Acting| match acting {
            Acting::Resonator(hung) => hung.lost(&at, &self.behind[hung.rows.clone()]),
            _ => 0.0,
        };
        let hung: f64 = self.acting.iter().map(lost).sum();
        std::f64::consts::PI * sum + by_laws + hung
    }

    /// What hangs at the contact.
    fn hung(&self) -> impl Iterator<Item = &Resonator> {
        self.acting.iter().filter_map(Acting::hung)
    }

    /// Force (N) over displacement (m) of the contact of what hangs there, in harmonic `order`, as `c − i s`.
    pub fn hung_stiffness(&self, at: &Operating, order: usize) -> Complex<f64> {
        self.hung().map(|hung| hung.dynamic_stiffness(at, order)).sum()
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
