//! What effects change of the beam: masses and the clamp change its modes, a hanging mass adds one, stretching and
//! drag are forces that the solvers add.

use nalgebra::{DMatrix, SymmetricEigen};

use super::check;
use crate::system::{Beam, HangingMass, ModalBeam, Place, PointMass, StructureChanges, StructureError};
use crate::vocabulary;

impl Beam {
    /// The beam with the masses and the clamp of `changes`; its sensors stay where they are.
    pub(crate) fn changed(&self, changes: &StructureChanges) -> Result<Self, StructureError> {
        let mut changed = self.clone();
        if changed.sensors.is_empty() {
            changed.sensors = self.point_masses.iter().map(|point| point.position).collect();
        }
        for (place, mass) in &changes.added_masses {
            let Place::Position(position) = *place else {
                return Err(StructureError::NotOnTheBeam { place: place.to_string() });
            };
            changed.add_mass(PointMass { position, mass: *mass });
        }
        if let Some(spring) = changes.clamp_stiffness {
            changed.clamp_stiffness =
                Some(self.clamp_stiffness.map_or(spring, |own| spring * own / (spring + own)));
        }
        Ok(changed)
    }

    /// Puts a mass on the beam, to the one that stands there if one does.
    pub(crate) fn add_mass(&mut self, added: PointMass) {
        match self.point_masses.iter_mut().find(|point| point.position == added.position) {
            Some(point) => point.mass += added.mass,
            None if added.mass == 0.0 => {}
            None => self.point_masses.push(added),
        }
    }
}

impl ModalBeam {
    /// Reduces a beam with `changes` to its modes; without changes this is [`ModalBeam::new`].
    ///
    /// A clamp that has a spring already gets the other in series. A hanging mass follows the contact's displacement
    /// and is damped like the first mode; each adds a mode, and damping that
    /// couples the new modes is left out. Sensors are where the unchanged beam has them.
    ///
    /// # Errors
    /// As [`ModalBeam::new`]; [`StructureError::NotOnTheBeam`] for a mass that is not at a position.
    ///
    /// ```
    /// use stickslip::system::{Beam, Damping, ModalBeam, Place, PointMass, StructureChanges};
    /// let bare = Beam {
    ///     length: 0.6, width: 0.04, thickness: 0.005, density: 7850.0, youngs_modulus: 2e11,
    ///     modes: 4, static_correction: false, damping: Damping::Uniform(0.003), point_masses: vec![],
    ///     offset: 0.006, rotational_stiffness: 0.0, clamp_stiffness: None,
    ///     excitation_position: 0.55, sensors: vec![0.3], contact_points: vec![],
    /// };
    /// let added = StructureChanges {
    ///     added_masses: vec![(Place::Position(0.3), 0.02)],
    ///     ..StructureChanges::default()
    /// };
    /// let built_in = Beam { point_masses: vec![PointMass { position: 0.3, mass: 0.02 }], ..bare.clone() };
    /// assert_eq!(ModalBeam::with_changes(&bare, &added)?, ModalBeam::new(&built_in)?);
    /// # Ok::<(), stickslip::system::StructureError>(())
    /// ```
    pub fn with_changes(beam: &Beam, changes: &StructureChanges) -> Result<Self, StructureError> {
        let mut modal = Self::linear(&beam.changed(changes)?)?;
        modal.stretching_stiffness = modal.stretching(beam, changes.cubic_stiffness)?;
        modal.quadratic_damping = changes.quadratic_damping;
        for hanging in &changes.hanging_masses {
            modal.hang(hanging)?;
        }
        Ok(modal)
    }

    /// `k3/G₁²` (N/m) for a cubic stiffness `k3` (N/m³) of the first mode at the excitation, where
    /// `G₁ = ∫ w'² dx` of that mode with unit displacement there.
    fn stretching(&self, beam: &Beam, cubic_stiffness: f64) -> Result<f64, StructureError> {
        if cubic_stiffness == 0.0 {
            return Ok(0.0);
        }
        let refused = |value| StructureError::NotComputable { quantity: "stretching stiffness", value };
        // The first mode and its shortening; the lever at the excitation may vanish at the ends alone.
        let (lever, shortening) = match (self.excitation_shape.first(), self.shortening.first()) {
            (Some(lever), Some(shortening)) if beam.excitation_position > 0.0 => (*lever, *shortening),
            _ => return Err(refused(f64::INFINITY)),
        };
        let per_displacement = shortening / (lever * lever);
        let stiffness = cubic_stiffness / (per_displacement * per_displacement);
        if stiffness.is_finite() { Ok(stiffness) } else { Err(refused(stiffness)) }
    }

    /// Hangs a resonator at the contact, behind the flexibility a that is in series with it.
    ///
    /// Contact and resonator, a spring k to a mass at p, pull with `F = T + k (u − p)` at a point that yields,
    /// `u = c·q − h − a F` with the shortening `h = ½ qᵀ G q`. With `s = 1/(1 + a k)` that is a contact at
    /// `u = s (c·q + a k p − h) − s a T`, the same equations with another shape, shortening and flexibility, and the
    /// potential `½ s k (c·q − p − h)²`: a spring between the modes and p, stretching, and what couples h to the
    /// string's stretch.
    fn hang(&mut self, hanging: &HangingMass) -> Result<(), StructureError> {
        check("effect.mass".into(), hanging.mass, &vocabulary::MASS)?;
        check("effect.hanging_frequency".into(), hanging.frequency, &vocabulary::HANGING_FREQUENCY)?;
        let modes = self.angular_frequency.len();
        let natural = std::f64::consts::TAU * hanging.frequency;
        // The resonator's own coordinate has a mass of one, as the modes have.
        let root = natural * hanging.mass.sqrt();
        let yielding = self.axial_flexibility * root * root;
        let fraction = 1.0 / (1.0 + yielding);
        let soft = fraction.sqrt();
        let lever: Vec<f64> =
            self.contact_shape.iter().map(|c| soft * root * c).chain([-soft * natural]).collect();
        let own = |index: usize| self.angular_frequency.get(index).map_or(0.0, |omega| omega * omega);
        let stiffness = DMatrix::from_fn(modes + 1, modes + 1, |i, j| {
            lever[i] * lever[j] + if i == j { own(i) } else { 0.0 }
        });
        let ratio = self.damping_ratio.first().copied().unwrap_or(0.0);
        let rates: Vec<f64> = self
            .angular_frequency
            .iter()
            .zip(&self.damping_ratio)
            .map(|(omega, zeta)| 2.0 * zeta * omega)
            .chain([2.0 * ratio * natural])
            .collect();
        let failed = |value| StructureError::NotComputable { quantity: "mode with a hanging mass", value };
        let eigen = SymmetricEigen::try_new(stiffness, f64::EPSILON, 0).ok_or_else(|| failed(f64::NAN))?;
        let mut order: Vec<usize> = (0..=modes).collect();
        order.sort_by(|a, b| eigen.eigenvalues[*a].total_cmp(&eigen.eigenvalues[*b]));
        if let Some(square) =
            order.iter().map(|mode| eigen.eigenvalues[*mode]).find(|x| x.is_nan() || *x <= 0.0)
        {
            return Err(failed(square));
        }
        let mut shapes = eigen.eigenvectors.select_columns(&order);
        let contact: Vec<f64> = self.contact_shape.iter().copied().chain([0.0]).collect();
        // Every mode keeps the sign that the unhung beam's modes have at the contact.
        let sign = self.contact_shape.iter().sum::<f64>().signum();
        for mut shape in shapes.column_iter_mut() {
            if sign * shape.iter().zip(&contact).map(|(x, c)| x * c).sum::<f64>() < 0.0 {
                shape.neg_mut();
            }
        }
        // In terms of s h, which the shortening now means.
        let string = root * root;
        self.stretching_stiffness =
            self.stretching_stiffness / (fraction * fraction) + 0.5 * string / fraction;
        let before = self.string_stiffness / fraction;
        self.string_stiffness = before + string;
        self.string_stretch.resize(modes + 1, 0.0);
        let own = self.contact_shape.iter().copied().chain([-1.0 / hanging.mass.sqrt()]);
        for (stretch, own) in self.string_stretch.iter_mut().zip(own) {
            *stretch = (before * *stretch + string * own) / self.string_stiffness;
        }
        self.contact_shape.iter_mut().for_each(|c| *c *= fraction);
        self.contact_shape.push(fraction * self.axial_flexibility * natural * root);
        self.axial_flexibility *= fraction;
        self.shortening.iter_mut().for_each(|g| *g *= fraction);
        self.transform(&shapes, &rates, |mode| eigen.eigenvalues[order[mode]].sqrt());
        Ok(())
    }

    /// Goes over to the modes that are the columns of `shapes`, one more than there are now.
    fn transform(&mut self, shapes: &DMatrix<f64>, rates: &[f64], frequency: impl Fn(usize) -> f64) {
        let modes = self.angular_frequency.len();
        let turned = |shape: &[f64]| -> Vec<f64> {
            shapes.column_iter().map(|column| column.iter().zip(shape).map(|(x, s)| x * s).sum()).collect()
        };
        let kept = shapes.rows(0, modes);
        let shortening = kept.transpose() * DMatrix::from_row_slice(modes, modes, &self.shortening) * kept;
        self.contact_shape = turned(&self.contact_shape);
        self.excitation_shape = turned(&self.excitation_shape);
        self.string_stretch = turned(&self.string_stretch);
        for sensor in self.sensors.iter_mut().chain(&mut self.contact_points) {
            sensor.shape = turned(&sensor.shape);
        }
        self.angular_frequency = (0..=modes).map(&frequency).collect();
        self.damping_ratio = shapes
            .column_iter()
            .zip(&self.angular_frequency)
            .map(|(column, omega)| {
                column.iter().zip(rates).map(|(x, rate)| x * x * rate).sum::<f64>() / (2.0 * omega)
            })
            .collect();
        // Symmetric to the last bit, whatever the products' rounding.
        self.shortening = (&shortening + shortening.transpose()).scale(0.5).iter().copied().collect();
    }
}
