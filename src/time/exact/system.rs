//! A linear structure in coordinates of unit mass, and its exact motion as a Taylor series.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use super::OscillatorError;
use super::polynomial::{DEGREE, Series};
use crate::system::{Entries, LinearStructure, Row, StructureError};

/// Steps are this many radians of the fastest motion: the series then ends at rounding.
const STEP_ANGLE: f64 = 2.0;

/// `ẍ + C ẋ + K x + Σ bᵢ Tᵢ = e f(t)`, `x = Lᵀ q` with Cholesky's factor `M = L Lᵀ`.
#[derive(Debug, Clone)]
pub(crate) struct System {
    /// Number of degrees of freedom.
    pub size: usize,
    /// C, row-major (1/s).
    damping: Vec<f64>,
    /// K, row-major (1/s²).
    stiffness: Vec<f64>,
    /// bᵢ of every contact (kg^-1/2).
    pub contacts: Vec<Vec<f64>>,
    /// e (kg^-1/2).
    pub excitation: Vec<f64>,
    /// Outputs (kg^-1/2).
    pub outputs: Vec<Vec<f64>>,
    factor: Cholesky<f64, Dyn>,
    /// Largest magnitude of an eigenvalue of K (1/s²) and of C (1/s).
    largest: (f64, f64),
    /// Smallest eigenvalue of K (1/s²).
    #[cfg_attr(not(feature = "analysis"), allow(dead_code))]
    least: f64,
    /// |bᵢ|² (1/kg).
    contact_mobility: Vec<f64>,
}

pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn dense(entries: &Entries, size: usize, field: &'static str) -> Result<DMatrix<f64>, OscillatorError> {
    let mut matrix = DMatrix::zeros(size, size);
    for &(i, j, value) in entries {
        if i >= size || j >= size || !value.is_finite() {
            return Err(OscillatorError::Structure { field });
        }
        matrix[(i, j)] += value;
    }
    Ok(matrix)
}

impl System {
    pub fn new(structure: &LinearStructure) -> Result<Self, OscillatorError> {
        let n = structure.size;
        if n == 0 {
            return Err(OscillatorError::Structure { field: "size" });
        }
        if let Err(StructureError::NotSymmetric { matrix, .. }) = structure.check_symmetry() {
            return Err(OscillatorError::Structure { field: matrix });
        }
        let factor =
            Cholesky::new(dense(&structure.mass, n, "mass")?).ok_or(OscillatorError::MassNotPositive)?;
        let lower = factor.l();
        let normalise = |entries, field| {
            let half = lower.solve_lower_triangular(&dense(entries, n, field)?);
            let full = half.and_then(|half| lower.solve_lower_triangular(&half.transpose()));
            full.map(|full| full.transpose()).ok_or(OscillatorError::MassNotPositive)
        };
        let row = |row: &Row, field| {
            let mut dense = DVector::zeros(n);
            for &(i, value) in row {
                if i >= n || !value.is_finite() {
                    return Err(OscillatorError::Structure { field });
                }
                dense[i] += value;
            }
            let solved = lower.solve_lower_triangular(&dense).ok_or(OscillatorError::MassNotPositive)?;
            Ok(solved.as_slice().to_vec())
        };
        let (damping, stiffness) =
            (normalise(&structure.damping, "damping")?, normalise(&structure.stiffness, "stiffness")?);
        let eigenvalues = |matrix: &DMatrix<f64>| {
            let symmetric = 0.5 * (matrix + matrix.transpose());
            symmetric.symmetric_eigenvalues()
        };
        let springs = eigenvalues(&stiffness);
        let contacts: Vec<Vec<f64>> =
            structure.contacts.iter().map(|r| row(r, "contacts")).collect::<Result<_, _>>()?;
        let outputs = structure.outputs.iter().map(|o| row(&o.row, "outputs")).collect::<Result<_, _>>()?;
        Ok(Self {
            size: n,
            largest: (springs.amax(), eigenvalues(&damping).amax()),
            least: springs.min(),
            damping: damping.transpose().as_slice().to_vec(),
            stiffness: stiffness.transpose().as_slice().to_vec(),
            contact_mobility: contacts.iter().map(|b| dot(b, b)).collect(),
            contacts,
            excitation: row(&structure.excitation, "excitation")?,
            outputs,
            factor,
        })
    }

    /// Inner coordinates of a displacement or velocity `q`.
    pub fn inward(&self, q: &[f64]) -> Vec<f64> {
        (self.factor.l().transpose() * DVector::from_column_slice(q)).as_slice().to_vec()
    }

    /// Displacement or velocity of the degrees of freedom from inner coordinates.
    pub fn outward(&self, x: &[f64]) -> Vec<f64> {
        let mut q = DVector::from_column_slice(x);
        // The diagonal of Cholesky's factor has no zero.
        let _ = self.factor.l_dirty().tr_solve_lower_triangular_mut(&mut q);
        q.as_slice().to_vec()
    }

    /// Longest step whose series converges to rounding, with the tangent stiffness `contact_stiffness`
    /// (N/m) at the contacts and an excitation no faster than `fastest` (rad/s).
    pub fn longest_step(&self, contact_stiffness: &[f64], fastest: f64) -> f64 {
        let stiffness: f64 = contact_stiffness
            .iter()
            .zip(&self.contact_mobility)
            .map(|(k, mobility)| k.abs() * mobility)
            .sum();
        let rate = (self.largest.0 + stiffness).sqrt() + self.largest.1;
        STEP_ANGLE / rate.max(fastest)
    }

    /// Series of the motion over a step of `h` (s) from `x`, `v`, under the contact forces
    /// `Tᵢ = stiffnessᵢ uᵢ + constantᵢ` and the excitation `force`: coefficient by coefficient, `size`
    /// numbers each.
    pub fn expand(
        &self,
        h: f64,
        x: &[f64],
        v: &[f64],
        (stiffness, constant): (&[f64], &[f64]),
        force: Option<&Series>,
        out: &mut [f64],
    ) {
        let n = self.size;
        out[..n].copy_from_slice(x);
        out[n..2 * n].iter_mut().zip(v).for_each(|(out, v)| *out = h * v);
        for j in 0..DEGREE - 1 {
            let (known, next) = out.split_at_mut((j + 2) * n);
            let (here, rate) = (&known[j * n..(j + 1) * n], &known[(j + 1) * n..]);
            let next = &mut next[..n];
            let f = force.map_or(0.0, |force| force[j]);
            let rate_factor = (j + 1) as f64 / h;
            for (i, next) in next.iter_mut().enumerate() {
                let row = i * n..(i + 1) * n;
                *next = self.excitation[i] * f
                    - rate_factor * dot(&self.damping[row.clone()], rate)
                    - dot(&self.stiffness[row], here);
            }
            for (c, b) in self.contacts.iter().enumerate() {
                let t = stiffness[c] * dot(b, here) + if j == 0 { constant[c] } else { 0.0 };
                next.iter_mut().zip(b).for_each(|(next, b)| *next -= b * t);
            }
            let factor = h * h / ((j + 1) * (j + 2)) as f64;
            next.iter_mut().for_each(|next| *next *= factor);
        }
    }

    /// Acceleration under the contact forces `contact` and the excitation `force` (N).
    pub fn accelerate(&self, x: &[f64], v: &[f64], contact: &[f64], force: f64, out: &mut [f64]) {
        let n = self.size;
        for (i, out) in out.iter_mut().enumerate() {
            let row = i * n..(i + 1) * n;
            *out = self.excitation[i] * force
                - dot(&self.damping[row.clone()], v)
                - dot(&self.stiffness[row], x)
                - self.contacts.iter().zip(contact).map(|(b, t)| b[i] * t).sum::<f64>();
        }
    }

    /// Room for [`System::expand`].
    pub fn series(&self) -> Vec<f64> {
        vec![0.0; (DEGREE + 1) * self.size]
    }

    /// Displacement and velocity at the fraction `x` of the step of `h` (s) that `series` expands.
    pub fn at(&self, series: &[f64], h: f64, fraction: f64, x: &mut [f64], v: &mut [f64]) {
        let n = self.size;
        x.fill(0.0);
        v.fill(0.0);
        for j in (0..=DEGREE).rev() {
            for (i, (x, v)) in x.iter_mut().zip(v.iter_mut()).enumerate() {
                *v = *v * fraction + *x;
                *x = *x * fraction + series[j * n + i];
            }
        }
        v.iter_mut().for_each(|v| *v /= h);
    }

    /// Series of the displacement along `row`.
    pub fn project(&self, series: &[f64], row: &[f64]) -> Series {
        let mut out = [0.0; DEGREE + 1];
        out.iter_mut().zip(series.chunks_exact(self.size)).for_each(|(out, x)| *out = dot(row, x));
        out
    }

    /// `vᵀ C v` (W): power lost to the dampers.
    pub fn viscous_power(&self, v: &[f64]) -> f64 {
        v.iter().zip(self.damping.chunks_exact(self.size)).map(|(v_i, row)| v_i * dot(row, v)).sum()
    }

    /// `½ vᵀ v + ½ xᵀ K x` (J).
    pub fn energy(&self, x: &[f64], v: &[f64]) -> f64 {
        let springs: f64 =
            x.iter().zip(self.stiffness.chunks_exact(self.size)).map(|(x_i, row)| x_i * dot(row, x)).sum();
        0.5 * (springs + dot(v, v))
    }
}

/// What harmonic balance and its stability ask of the system.
#[cfg(feature = "analysis")]
impl System {
    /// The same structure, driven along the displacement of contact `i` against a force's sense: its
    /// excitation is a contact force.
    pub fn driven_by_contact(&self, i: usize) -> Self {
        Self { excitation: self.contacts[i].iter().map(|b| -b).collect(), ..self.clone() }
    }

    /// K (1/s²) and C (1/s), row-major.
    pub fn matrices(&self) -> (&[f64], &[f64]) {
        (&self.stiffness, &self.damping)
    }

    /// Angular frequency (rad/s) of the structure's fastest motion; 1 without springs.
    pub fn fastest(&self) -> f64 {
        if self.largest.0 > 0.0 { self.largest.0.sqrt() } else { 1.0 }
    }

    /// Whether the structure can be displaced without a force: some part of it floats.
    pub fn floats(&self) -> bool {
        const ROUNDING: f64 = 1e-13;
        self.least.abs() <= ROUNDING * self.size as f64 * self.largest.0
    }
}
