//! A linear structure as matrices, with the points where contacts, excitation and observers are.

use std::collections::BTreeMap;
use std::sync::Arc;

use nalgebra::{DMatrix, SymmetricEigen};

use super::StructureError;
use super::ports::{Core, Element, Entries, Port, Row, System};
use crate::contact::ContactLaw;

/// Most degrees of freedom for which all natural modes are computed: the effort grows with the cube.
pub const MOST_DENSE_MODES: usize = 1000;

/// A named point whose displacement is observed.
#[derive(Debug, Clone, PartialEq)]
pub struct Output {
    /// Its name, e.g. of a mass.
    pub name: String,
    /// Its displacement (m) in terms of the degrees of freedom.
    pub row: Row,
}

/// `M q̈ + C q̇ + K q + Σ Bᵢᵀ Tᵢ = f(t) e`, contact `i` displaced by `uᵢ = Bᵢ q`.
///
/// ```
/// use std::sync::Arc;
/// use stickslip::contact::{ContactLaw, Jenkins};
/// use stickslip::system::{LinearStructure, Output};
/// let row = vec![(0, 1.0)];
/// let structure = LinearStructure {
///     size: 1,
///     mass: vec![(0, 0, 2.0)],
///     damping: vec![(0, 0, 0.1)],
///     stiffness: vec![(0, 0, 18.0)],
///     contacts: vec![row.clone()],
///     excitation: row.clone(),
///     outputs: vec![Output { name: "m1".into(), row }],
/// };
/// assert!((structure.natural_modes()?.angular_frequency[0] - 3.0).abs() < 1e-14);
/// let law: Arc<dyn ContactLaw> = Arc::new(Jenkins::new(7.0, 0.5)?);
/// let system = structure.system(vec![(law, 2.0)]);
/// let ports: Vec<&str> = system.ports.iter().map(|port| port.name.as_str()).collect();
/// assert_eq!(ports, ["m1", "excitation", "contact"]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct LinearStructure {
    /// Number of degrees of freedom.
    pub size: usize,
    /// M (kg).
    pub mass: Entries,
    /// C (N s/m).
    pub damping: Entries,
    /// K (N/m).
    pub stiffness: Entries,
    /// Bᵢ of every contact.
    pub contacts: Vec<Row>,
    /// e.
    pub excitation: Row,
    /// Where the displacement is observed.
    pub outputs: Vec<Output>,
}

/// Undamped natural frequencies and modes of a [`LinearStructure`] without its contacts.
#[derive(Debug, Clone, PartialEq)]
pub struct NaturalModes {
    /// ωᵣ (rad/s), ascending; 0 for a body that is free to move.
    pub angular_frequency: Vec<f64>,
    /// Φ with `Φᵀ M Φ = 1`, one column per mode (kg^-1/2); the largest entry of a column is positive.
    pub shapes: DMatrix<f64>,
}

impl System {
    /// The linear part as matrices: the core with the springs between its ports, resonators
    /// [`expanded`](System::expanded). A contact per law, in the order of the
    /// elements; the outputs are the sensors.
    ///
    /// Left out are the shortening `½ qᵀ G q`, flexibilities in series, and forces from outside.
    pub fn linear_part(&self) -> LinearStructure {
        self.expanded().linear_part_of_expanded()
    }

    fn linear_part_of_expanded(&self) -> LinearStructure {
        let (size, mass, damping, mut stiffness) = match &self.core {
            Core::Modal { angular_frequency, damping_ratio } => {
                let frequencies = angular_frequency.iter();
                let rates =
                    damping_ratio.iter().zip(frequencies.clone()).map(|(zeta, omega)| 2.0 * zeta * omega);
                let mass = diagonal(frequencies.clone().map(|_| 1.0));
                (frequencies.len(), mass, diagonal(rates), diagonal(frequencies.map(|omega| omega * omega)))
            }
            Core::Matrices { size, mass, damping, stiffness } => {
                (*size, mass.clone(), damping.clone(), stiffness.clone())
            }
        };
        for element in &self.elements {
            if let Element::Springs { ports, stiffness: springs } = element {
                let rows = ports.map(|port| &self.ports[port].row);
                let pairs = [(0, 0), (0, 1), (1, 0), (1, 1)].into_iter();
                stiffness.extend(pairs.flat_map(|(a, b)| between(rows[a], springs[a][b], rows[b])));
            }
        }
        let driven = self.driven.iter().flat_map(|port| self.ports[*port].row.iter().copied());
        let output = |port: &usize| Output {
            name: self.ports[*port].name.clone(),
            row: self.ports[*port].row.clone(),
        };
        LinearStructure {
            size,
            mass,
            damping,
            stiffness,
            contacts: self.laws().map(|(port, ..)| self.ports[port].row.clone()).collect(),
            excitation: driven.collect(),
            outputs: self.sensors.iter().map(output).collect(),
        }
    }

    /// The linear part with springs in the place of the contacts: of the `tangential` stiffness (N/m) along them and, of those
    /// in two directions, of their own at rest across.
    #[cfg(feature = "analysis")]
    pub(crate) fn stuck_part(&self, tangential: f64) -> LinearStructure {
        let mut stuck = self.linear_part();
        let mut springs = vec![tangential; stuck.contacts.len()];
        for element in &self.elements {
            if let Element::SlipSlap { ports, contact } = element {
                stuck.contacts.extend(ports.map(|port| self.ports[port].row.clone()));
                springs.extend([tangential, contact.normal().stiffness()]);
            }
        }
        stuck.stiffness.extend(stuck.along_contacts(springs));
        stuck
    }
}

/// What a spring of `stiffness` (N/m) between the displacements of two rows adds to K.
fn between(left: &Row, stiffness: f64, right: &Row) -> impl Iterator<Item = (usize, usize, f64)> {
    left.iter().flat_map(move |(i, a)| right.iter().map(move |(j, b)| (*i, *j, a * stiffness * b)))
}

impl LinearStructure {
    /// The structure as a system. Ports: the outputs by their names, `excitation`, then a port per contact in their order,
    /// `contact` the first. `contacts` are their laws, each with its normal load (N).
    pub fn system(&self, contacts: Vec<(Arc<dyn ContactLaw>, f64)>) -> System {
        let mut ports: Vec<Port> =
            self.outputs.iter().map(|output| Port::linear(&output.name, output.row.clone())).collect();
        let excitation = ports.len();
        ports.push(Port::linear("excitation", self.excitation.clone()));
        let first = ports.len();
        for (place, row) in self.contacts.iter().enumerate() {
            let name = if place == 0 { "contact".to_owned() } else { format!("contact.{}", place + 1) };
            ports.push(Port::linear(&name, row.clone()));
        }
        let elements = contacts.into_iter().enumerate();
        let elements = elements
            .map(|(place, (law, normal_load))| Element::Law { port: first + place, law, normal_load })
            .collect();
        System {
            core: Core::Matrices {
                size: self.size,
                mass: self.mass.clone(),
                damping: self.damping.clone(),
                stiffness: self.stiffness.clone(),
            },
            shortening: Vec::new(),
            ports,
            elements,
            driven: vec![excitation],
            sensors: (0..excitation).collect(),
        }
    }

    /// All natural frequencies and modes, of the undamped structure without its contacts.
    ///
    /// Frequencies are exact to about 1e-15 of the square of the highest.
    ///
    /// # Errors
    /// [`StructureError::TooManyModes`] beyond [`MOST_DENSE_MODES`] degrees of freedom,
    /// [`StructureError::NotSymmetric`] for a matrix that lacks its other triangle,
    /// [`StructureError::NoInertia`] for a mass matrix that is not positive definite,
    /// [`StructureError::NotComputable`] for entries that are not finite.
    pub fn natural_modes(&self) -> Result<NaturalModes, StructureError> {
        if self.size > MOST_DENSE_MODES {
            return Err(StructureError::TooManyModes { size: self.size, most: MOST_DENSE_MODES });
        }
        if self.size == 0 {
            return Err(StructureError::NoInertia);
        }
        if let Some((_, _, value)) =
            self.stiffness.iter().chain(&self.mass).find(|entry| !entry.2.is_finite())
        {
            return Err(StructureError::NotComputable { quantity: "natural frequency", value: *value });
        }
        self.check_symmetry()?;
        // M = L Lᵀ turns K x = ω² M x into L⁻¹ K L⁻ᵀ y = ω² y with x = L⁻ᵀ y.
        let factor = dense(self.size, &self.mass).cholesky().ok_or(StructureError::NoInertia)?.unpack();
        let mut reduced = dense(self.size, &self.stiffness);
        let solved = factor.solve_lower_triangular_mut(&mut reduced);
        let mut reduced = reduced.transpose();
        if !(solved && factor.solve_lower_triangular_mut(&mut reduced)) {
            return Err(StructureError::NoInertia);
        }
        let symmetric = (&reduced + reduced.transpose()) * 0.5;
        let eigen = SymmetricEigen::try_new(symmetric, f64::EPSILON, 0)
            .ok_or(StructureError::NotComputable { quantity: "natural frequency", value: f64::NAN })?;
        let rounding = f64::EPSILON * self.size as f64 * eigen.eigenvalues.amax();
        let mut order: Vec<usize> = (0..self.size).collect();
        order.sort_by(|left, right| eigen.eigenvalues[*left].total_cmp(&eigen.eigenvalues[*right]));
        let mut shapes = eigen.eigenvectors.select_columns(&order);
        if !factor.tr_solve_lower_triangular_mut(&mut shapes) {
            return Err(StructureError::NoInertia);
        }
        for mut shape in shapes.column_iter_mut() {
            if shape[shape.iamax()] < 0.0 {
                shape.neg_mut();
            }
        }
        let angular_frequency = order
            .iter()
            .map(|mode| eigen.eigenvalues[*mode])
            .map(|square| if square.abs() <= rounding { 0.0 } else { square.max(0.0).sqrt() })
            .collect();
        Ok(NaturalModes { angular_frequency, shapes })
    }

    /// Entries of the matrix that one factor for each contact, such as the stiffness (N/m) of a spring along its
    /// displacement, makes of the contacts' rows.
    #[cfg(feature = "analysis")]
    pub(crate) fn along_contacts(&self, factors: impl IntoIterator<Item = f64>) -> Entries {
        let contacts = self.contacts.iter().zip(factors);
        contacts.flat_map(|(row, factor)| between(row, factor, row)).collect()
    }

    /// Refuses matrices whose entries differ from their mirror images by more than rounding in sums.
    pub(crate) fn check_symmetry(&self) -> Result<(), StructureError> {
        let matrices = [("mass", &self.mass), ("damping", &self.damping), ("stiffness", &self.stiffness)];
        matrices.into_iter().try_for_each(|(name, entries)| symmetric(name, entries))
    }
}

fn symmetric(matrix: &'static str, entries: &Entries) -> Result<(), StructureError> {
    /// Fraction of the largest entry that sums of the same terms in another order may differ by.
    const ROUNDING: f64 = 1e-12;
    let largest = entries.iter().fold(0.0_f64, |largest, entry| largest.max(entry.2.abs()));
    // Difference of each pair: the upper triangle less the lower.
    let sides = entries.iter().filter(|(i, j, _)| i != j);
    let mut differences: Vec<(usize, usize, f64)> =
        sides.map(|(i, j, value)| if i < j { (*i, *j, *value) } else { (*j, *i, -value) }).collect();
    differences.sort_by_key(|(i, j, _)| (*i, *j));
    for pair in differences.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
        let difference: f64 = pair.iter().map(|entry| entry.2).sum();
        if difference.abs() > ROUNDING * largest {
            return Err(StructureError::NotSymmetric { matrix, row: pair[0].0, column: pair[0].1 });
        }
    }
    Ok(())
}

/// A matrix with these values on its diagonal.
fn diagonal(values: impl Iterator<Item = f64>) -> Entries {
    values.enumerate().map(|(i, value)| (i, i, value)).collect()
}

/// The matrix as a dense one.
pub(super) fn dense(size: usize, entries: &Entries) -> DMatrix<f64> {
    let mut matrix = DMatrix::zeros(size, size);
    entries.iter().for_each(|(i, j, value)| matrix[(*i, *j)] += *value);
    matrix
}

/// Sums contributions to a matrix, place by place.
#[derive(Debug, Default)]
pub(super) struct Sum(BTreeMap<(usize, usize), f64>);

impl Sum {
    /// Adds `value` at one place.
    pub(super) fn add(&mut self, i: usize, j: usize, value: f64) {
        *self.0.entry((i, j)).or_default() += value;
    }

    /// The sums in order; places where nothing is left are dropped.
    pub(super) fn entries(self) -> Entries {
        self.0.into_iter().filter(|(_, value)| *value != 0.0).map(|((i, j), value)| (i, j, value)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::system::{Anchor, Mass, Oscillator, Spring};

    fn two_masses() -> Oscillator {
        let mass = |name: &str| Mass { name: name.into(), mass: 1.0 };
        let spring = |between, stiffness, damping| Spring { between, stiffness, damping };
        use Anchor::{Ground, Mass as At};
        Oscillator {
            masses: vec![mass("m1"), mass("m2")],
            springs: vec![
                spring([Ground, At(0)], 1.0, 0.0),
                spring([At(0), At(1)], 0.5, 0.0),
                spring([Ground, At(0)], 0.0, 0.1),
                spring([Ground, At(1)], 0.0, 0.1),
            ],
            contact: Some(1),
            excitation: 0,
        }
    }

    #[test]
    fn springs_and_dampers_add_to_the_printed_matrices_of_the_two_mass_system() {
        let structure = two_masses().structure().unwrap();
        assert_eq!(structure.stiffness, [(0, 0, 1.5), (0, 1, -0.5), (1, 0, -0.5), (1, 1, 0.5)]);
        assert_eq!(structure.damping, [(0, 0, 0.1), (1, 1, 0.1)]);
        assert_eq!(structure.mass, [(0, 0, 1.0), (1, 1, 1.0)]);
        assert_eq!((&structure.contacts, &structure.excitation), (&vec![vec![(1, 1.0)]], &vec![(0, 1.0)]));
    }

    #[test]
    fn two_masses_have_the_natural_frequencies_of_their_characteristic_polynomial() {
        let free_sliding = two_masses().structure().unwrap().natural_modes().unwrap();
        let mut stuck = two_masses();
        stuck.springs.push(Spring {
            between: [Anchor::Ground, Anchor::Mass(1)],
            stiffness: 0.2,
            damping: 0.0,
        });
        let stuck = stuck.structure().unwrap().natural_modes().unwrap();
        // λ² − (a + b) λ + a b − c² = 0 with K = [[a, −c], [−c, b]].
        for (modes, b) in [(free_sliding, 0.5), (stuck, 0.7)] {
            let (a, c): (f64, f64) = (1.5, 0.5);
            let (mean, radius) = (0.5 * (a + b), (0.25 * (a - b).powi(2) + c * c).sqrt());
            for (omega, square) in modes.angular_frequency.iter().zip([mean - radius, mean + radius]) {
                assert!((omega / square.sqrt() - 1.0).abs() < 1e-14, "{omega}");
            }
        }
    }

    #[test]
    fn modes_are_mass_normalised_and_diagonalise_the_stiffness() {
        let mut oscillator = two_masses();
        oscillator.masses[1].mass = 7.0;
        let structure = oscillator.structure().unwrap();
        let modes = structure.natural_modes().unwrap();
        let shapes = &modes.shapes;
        let unit = shapes.transpose() * dense(2, &structure.mass) * shapes;
        assert!((unit - DMatrix::identity(2, 2)).amax() < 1e-14);
        let squares = shapes.transpose() * dense(2, &structure.stiffness) * shapes;
        for (i, omega) in modes.angular_frequency.iter().enumerate() {
            assert!((squares[(i, i)] - omega * omega).abs() < 1e-14);
        }
        assert!(squares[(0, 1)].abs() < 1e-14);
    }

    #[test]
    fn a_free_body_has_a_natural_frequency_of_zero() {
        let mut oscillator = two_masses();
        oscillator.springs.retain(|spring| spring.between != [Anchor::Ground, Anchor::Mass(0)]);
        let modes = oscillator.structure().unwrap().natural_modes().unwrap();
        assert_eq!(modes.angular_frequency[0], 0.0);
        assert!((modes.angular_frequency[1] - 1.0).abs() < 1e-15, "√(k (1/m1 + 1/m2))");
    }

    #[test]
    fn a_matrix_without_its_other_triangle_is_refused() {
        let mut structure = two_masses().structure().unwrap();
        structure.stiffness.retain(|entry| (entry.0, entry.1) != (1, 0));
        let expected = StructureError::NotSymmetric { matrix: "stiffness", row: 0, column: 1 };
        assert_eq!(structure.natural_modes(), Err(expected.clone()));
        assert_eq!(crate::system::Receptance::new(&structure).unwrap_err(), expected);
        // Contributions to one place may be listed one by one, and differ by rounding.
        structure.stiffness.extend([(1, 0, -0.2), (1, 0, -0.3 * (1.0 + 1e-15))]);
        assert!(structure.natural_modes().is_ok());
    }

    #[test]
    fn what_has_no_modes_is_refused() {
        let mut structure = two_masses().structure().unwrap();
        structure.mass.pop();
        assert_eq!(structure.natural_modes(), Err(StructureError::NoInertia));
        structure.size = 0;
        assert_eq!(structure.natural_modes(), Err(StructureError::NoInertia));
        let mut oscillator = two_masses();
        oscillator.contact = Some(2);
        assert!(matches!(oscillator.structure(), Err(StructureError::UnknownMass { mass: 2, .. })));
        let mut oscillator = two_masses();
        oscillator.springs[1].stiffness = f64::NAN;
        assert!(matches!(oscillator.structure(), Err(StructureError::OutOfBounds { .. })));
    }
}
