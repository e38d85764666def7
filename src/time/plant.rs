//! A system in modal coordinates, where every coordinate moves by itself but for the forces at ports.

use std::ops::Range;
use std::sync::Arc;

use nalgebra::{Cholesky, DMatrix, DVector, SymmetricEigen};

use super::SystemError;
use crate::contact::{ContactLaw, Inputs, StateTangents};
use crate::system::{Core, Element, Entries, Port, Row, System};

/// Largest damping ratio of a mode that is solved exactly; what is beyond acts as a force.
const MOST_DAMPED: f64 = 2.0;
/// Relative to the largest of a matrix: rounding.
const ROUNDING: f64 = 1e-13;

/// A system whose core is diagonal, up to forces of damping.
#[derive(Debug, Clone)]
pub(crate) struct Plant {
    /// ω (rad/s) and ζ (1) of every mode.
    pub angular_frequency: Vec<f64>,
    pub damping_ratio: Vec<f64>,
    /// Damping (1/s) that the ratios leave out, row-major; empty where they leave out none.
    pub damping: Vec<f64>,
    /// G, row-major; empty where no port shortens.
    pub shortening: Vec<f64>,
    pub ports: Vec<ModalPort>,
    pub driven: Vec<usize>,
    pub sensors: Vec<usize>,
    pub contacts: Vec<Contact>,
    pub springs: Vec<Springs>,
    /// Length of what all laws remember.
    pub memory_len: usize,
    /// Whether a law's force acts on that of another, or on springs.
    pub interacts: bool,
    /// Coordinates by modes and modes by coordinates, where the core was not modal.
    shapes: Option<Shapes>,
}

/// [`Port`] in modal coordinates.
#[derive(Debug, Clone)]
pub(crate) struct ModalPort {
    pub row: Vec<f64>,
    pub shortening: f64,
    pub flexibility: f64,
}

/// A law at a port, or a force from outside.
#[derive(Debug, Clone)]
pub(crate) struct Contact {
    pub port: usize,
    /// `None` for a force from outside.
    pub law: Option<Arc<dyn ContactLaw>>,
    /// Its input: the normal load (N) or the force (N) itself.
    pub input: usize,
    /// Normal load (N) of a law, where none is given.
    pub normal_load: f64,
    /// Whether the force depends on what was before, so that a reversal matters.
    pub remembers: bool,
    /// The part a (m/N) of its port's flexibility by which its velocity yields: none where its limit follows the velocity.
    pub series: f64,
    /// Its part of what all laws remember.
    pub memory: Range<usize>,
}

/// [`Element::Springs`].
#[derive(Debug, Clone, Copy)]
pub(crate) struct Springs {
    pub ports: [usize; 2],
    pub stiffness: [[f64; 2]; 2],
}

impl ModalPort {
    /// Displacement and velocity at modal displacements `q` and velocities `v`; `pull` is G q.
    #[inline]
    pub fn motion(&self, q: &[f64], v: &[f64], pull: &[f64]) -> (f64, f64) {
        let (mut displacement, mut velocity) = (0.0, 0.0);
        if self.shortening == 0.0 {
            for ((b, q), v) in self.row.iter().zip(q).zip(v) {
                displacement += b * q;
                velocity += b * v;
            }
        } else {
            for (((b, g), q), v) in self.row.iter().zip(pull).zip(q).zip(v) {
                let g = self.shortening * g;
                displacement += (b - 0.5 * g) * q;
                velocity += (b - g) * v;
            }
        }
        (displacement, velocity)
    }

    /// `J x`, the change along which the port moves; `pull` is G q.
    pub fn along(&self, x: &[f64], pull: &[f64]) -> f64 {
        if self.shortening == 0.0 {
            return dot(&self.row, x);
        }
        self.row.iter().zip(pull).zip(x).map(|((b, g), x)| (b - self.shortening * g) * x).sum()
    }
}

impl Springs {
    /// Forces at the two ports at their displacements.
    pub fn forces(&self, u: [f64; 2]) -> [f64; 2] {
        self.stiffness.map(|row| row[0] * u[0] + row[1] * u[1])
    }
}

impl Plant {
    pub fn new(system: &System) -> Result<Self, SystemError> {
        let system = system.expanded();
        let size = system.core.size();
        if size == 0 {
            return Err(SystemError::Length { field: "angular_frequency", expected: 1, found: 0 });
        }
        let (modes, shapes) = match &system.core {
            Core::Modal { angular_frequency, damping_ratio } => {
                check_list("angular_frequency", angular_frequency, size, |x| x >= 0.0)?;
                check_list("damping_ratio", damping_ratio, size, |x| x >= 0.0)?;
                ((angular_frequency.clone(), damping_ratio.clone(), Vec::new()), None)
            }
            Core::Matrices { mass, damping, stiffness, .. } => {
                let (modes, shapes) = modes(size, mass, damping, stiffness)?;
                (modes, Some(shapes))
            }
        };
        check_shortening(&system, size, shapes.is_some())?;
        let mut ports = Vec::with_capacity(system.ports.len());
        for port in &system.ports {
            ports.push(modal_port(port, size, shapes.as_ref().map(|(shapes, _)| shapes))?);
        }
        let (contacts, springs, memory_len) = elements(&system)?;
        check_ports(&system)?;
        let (angular_frequency, damping_ratio, damping) = modes;
        let laws = contacts.iter().filter(|contact| contact.law.is_some()).count();
        let mut plant = Self {
            interacts: laws > 1,
            angular_frequency,
            damping_ratio,
            damping,
            shortening: system.shortening.clone(),
            ports,
            driven: system.driven.clone(),
            sensors: system.sensors.clone(),
            contacts,
            springs,
            memory_len,
            shapes,
        };
        plant.interacts |= plant.follows_displacement();
        Ok(plant)
    }

    pub fn size(&self) -> usize {
        self.angular_frequency.len()
    }

    /// Whether forces that are not those of laws follow displacements.
    pub fn follows_displacement(&self) -> bool {
        !(self.springs.is_empty() && self.shortening.is_empty())
    }

    /// Whether they follow displacements or velocities.
    pub fn follows_motion(&self) -> bool {
        self.follows_displacement() || !self.damping.is_empty()
    }

    /// Number of inputs: forces on the driven ports, then one of each law and outside force.
    pub fn inputs(&self) -> usize {
        self.driven.len() + self.contacts.len()
    }

    /// `out = G x`; zero where nothing shortens.
    pub fn shorten(&self, x: &[f64], out: &mut [f64]) {
        out.fill(0.0);
        add_product(&self.shortening, x, out);
    }

    /// Modal displacements or velocities of the system's coordinates.
    pub fn inward(&self, coordinates: &[f64]) -> Vec<f64> {
        self.shapes.as_ref().map_or_else(
            || coordinates.to_vec(),
            |(_, inverse)| (inverse * DVector::from_column_slice(coordinates)).as_slice().to_vec(),
        )
    }

    /// The system's coordinates at modal displacements or velocities.
    pub fn outward(&self, modal: &[f64]) -> Vec<f64> {
        self.shapes.as_ref().map_or_else(
            || modal.to_vec(),
            |(shapes, _)| (shapes * DVector::from_column_slice(modal)).as_slice().to_vec(),
        )
    }
}

/// `out += A x`, A symmetric: a column is a row, and the inner loop runs over neighbours. A may be empty.
pub(crate) fn add_product(matrix: &[f64], x: &[f64], out: &mut [f64]) {
    for (column, &by) in matrix.chunks_exact(x.len()).zip(x) {
        for (out, a) in out.iter_mut().zip(column) {
            *out += a * by;
        }
    }
}

pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Coordinates by modes, and modes by coordinates.
type Shapes = (DMatrix<f64>, DMatrix<f64>);

/// Frequencies, damping ratios and the damping beside them.
type Modes = (Vec<f64>, Vec<f64>, Vec<f64>);

/// The undamped modes: `K φ = ω² M φ` by Cholesky's factor of M.
fn modes(
    size: usize,
    mass: &Entries,
    damping: &Entries,
    stiffness: &Entries,
) -> Result<(Modes, Shapes), SystemError> {
    let factor = Cholesky::new(dense(mass, size, "mass")?).ok_or(SystemError::MassNotPositive)?;
    let lower = factor.l();
    let half =
        |matrix: &DMatrix<f64>| lower.solve_lower_triangular(matrix).ok_or(SystemError::MassNotPositive);
    let stiffness = half(&half(&dense(stiffness, size, "stiffness")?)?.transpose())?;
    let SymmetricEigen { eigenvalues, eigenvectors } =
        (0.5 * (&stiffness + stiffness.transpose())).symmetric_eigen();
    let floor = ROUNDING * size as f64 * eigenvalues.amax();
    if let Some(value) = eigenvalues.iter().find(|value| **value < -floor) {
        return Err(SystemError::Value { field: "stiffness".into(), value: *value });
    }
    let angular_frequency: Vec<f64> =
        eigenvalues.iter().map(|square| if *square <= floor { 0.0 } else { square.sqrt() }).collect();
    let shapes =
        lower.transpose().solve_upper_triangular(&eigenvectors).ok_or(SystemError::MassNotPositive)?;
    let inverse = eigenvectors.transpose() * lower.transpose();
    let mut left = shapes.transpose() * dense(damping, size, "damping")? * &shapes;
    let floor = ROUNDING * size as f64 * left.amax();
    let mut damping_ratio = vec![0.0; size];
    for (i, (zeta, omega)) in damping_ratio.iter_mut().zip(&angular_frequency).enumerate() {
        let rate = left[(i, i)];
        if *omega > 0.0 && rate > 0.0 {
            *zeta = (rate / (2.0 * omega)).min(MOST_DAMPED);
            left[(i, i)] -= 2.0 * *zeta * omega;
        }
    }
    let left = if left.amax() <= floor { Vec::new() } else { left.as_slice().to_vec() };
    Ok(((angular_frequency, damping_ratio, left), (shapes, inverse)))
}

fn dense(entries: &Entries, size: usize, field: &'static str) -> Result<DMatrix<f64>, SystemError> {
    let mut matrix = DMatrix::zeros(size, size);
    for &(i, j, value) in entries {
        if i >= size || j >= size {
            return Err(SystemError::Length { field, expected: size, found: i.max(j) + 1 });
        }
        if !value.is_finite() {
            return Err(SystemError::Value { field: field.into(), value });
        }
        matrix[(i, j)] += value;
    }
    symmetric(matrix.as_slice(), size, field)?;
    Ok(matrix)
}

fn symmetric(matrix: &[f64], size: usize, field: &'static str) -> Result<(), SystemError> {
    let largest = matrix.iter().fold(0.0_f64, |m, g| m.max(g.abs()));
    for row in 0..size {
        for column in 0..row {
            if (matrix[row * size + column] - matrix[column * size + row]).abs() > 1e-9 * largest {
                return Err(SystemError::Asymmetric { field, row, column });
            }
        }
    }
    Ok(())
}

fn check_list(
    field: &'static str,
    values: &[f64],
    expected: usize,
    legal: impl Fn(f64) -> bool,
) -> Result<(), SystemError> {
    if values.len() != expected {
        return Err(SystemError::Length { field, expected, found: values.len() });
    }
    match values.iter().find(|&&value| !(value.is_finite() && legal(value))) {
        Some(&value) => Err(SystemError::Value { field: field.into(), value }),
        None => Ok(()),
    }
}

/// G is of the modes themselves.
pub(super) fn check_shortening(system: &System, size: usize, reduced: bool) -> Result<(), SystemError> {
    let shortens = system.ports.iter().any(|port| !port.is_linear());
    if system.shortening.is_empty() && !shortens {
        return Ok(());
    }
    if reduced {
        return Err(SystemError::NotLinear);
    }
    check_list("shortening", &system.shortening, size * size, |_| true)?;
    symmetric(&system.shortening, size, "shortening")
}

pub(super) fn modal_port(
    port: &Port,
    size: usize,
    shapes: Option<&DMatrix<f64>>,
) -> Result<ModalPort, SystemError> {
    let field = || format!("port {}", port.name);
    let row =
        dense_row(&port.row, size).ok_or_else(|| SystemError::Value { field: field(), value: f64::NAN })?;
    let row = match shapes {
        Some(shapes) => shapes.tr_mul(&DVector::from_vec(row)).as_slice().to_vec(),
        None => row,
    };
    if !port.shortening.is_finite() {
        return Err(SystemError::Value { field: field(), value: port.shortening });
    }
    if !(port.flexibility.is_finite() && port.flexibility >= 0.0) {
        let field = format!("flexibility of {}", field());
        return Err(SystemError::Value { field, value: port.flexibility });
    }
    Ok(ModalPort { row, shortening: port.shortening, flexibility: port.flexibility })
}

/// `None` where an entry is out of place or not finite.
fn dense_row(row: &Row, size: usize) -> Option<Vec<f64>> {
    let mut dense = vec![0.0; size];
    for &(i, value) in row {
        *dense.get_mut(i).filter(|_| value.is_finite())? += value;
    }
    Some(dense)
}

/// Laws and outside forces, springs, and the length of all memories.
fn elements(system: &System) -> Result<(Vec<Contact>, Vec<Springs>, usize), SystemError> {
    let (mut contacts, mut springs, mut memory_len) = (Vec::new(), Vec::new(), 0);
    for element in &system.elements {
        if let Some(port) = element.ports().iter().find(|port| **port >= system.ports.len()) {
            let (expected, found) = (system.ports.len(), port + 1);
            return Err(SystemError::Length { field: "ports", expected, found });
        }
        let (port, law, normal_load) = match element {
            Element::Law { port, law, normal_load } => (*port, Some(law.clone()), *normal_load),
            Element::Outside { port } => (*port, None, 0.0),
            Element::SlipSlap { .. } => return Err(SystemError::TwoDirections),
            Element::Inertia { .. } => return Err(SystemError::InertiaAtPorts),
            Element::Resonator { .. } => continue, // in the expanded form there are none
            Element::Springs { ports, stiffness } => {
                springs.push(Springs { ports: *ports, stiffness: *stiffness });
                continue;
            }
        };
        let length = law.as_ref().map_or(0, |law| law.state_len());
        contacts.push(Contact {
            port,
            remembers: law.as_deref().is_some_and(remembers),
            series: match law.as_deref() {
                Some(law) if law.limit_follows_velocity() => 0.0,
                _ => system.ports[port].flexibility,
            },
            law,
            input: system.driven.len() + contacts.len(),
            normal_load,
            memory: memory_len..memory_len + length,
        });
        memory_len += length;
    }
    Ok((contacts, springs, memory_len))
}

/// Whether the force from rest depends on what the law remembers.
fn remembers(law: &dyn ContactLaw) -> bool {
    let mut memory = vec![0.0; law.state_len()];
    law.set_state(0.0, 1.0, 0.0, &mut memory);
    let mut tangents = StateTangents::default();
    law.state_tangents(&memory, Inputs { displacement: 0.0, velocity: 0.0, normal_load: 1.0 }, &mut tangents);
    law.limit(1.0).is_finite() || tangents.force_by_state.iter().any(|by| *by != 0.0)
}

/// Drives, sensors and springs are at linear ports, the latter without flexibility in series.
fn check_ports(system: &System) -> Result<(), SystemError> {
    for port in system.driven.iter().chain(&system.sensors) {
        let (expected, found) = (system.ports.len(), port + 1);
        let port = system.ports.get(*port).ok_or(SystemError::Length { field: "ports", expected, found })?;
        if !port.is_linear() {
            return Err(SystemError::NotLinear);
        }
    }
    for element in &system.elements {
        if let Element::Springs { ports, .. } = element
            && let Some(port) =
                ports.iter().map(|port| &system.ports[*port]).find(|port| port.flexibility != 0.0)
        {
            let field = format!("flexibility of port {}", port.name);
            return Err(SystemError::Value { field, value: port.flexibility });
        }
    }
    Ok(())
}
