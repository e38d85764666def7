//! What effects change of the beam: masses and the clamp change its modes; stretching, drag and what hangs at the contact
//! are elements.

use super::checks::check_hung;
use crate::system::{Beam, ModalBeam, Place, PointMass, StructureChanges, StructureError};

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
    /// and is damped like the first mode. Sensors are where the unchanged beam has them.
    ///
    /// # Errors
    /// As [`ModalBeam::new`]; [`StructureError::NotOnTheBeam`] for a mass that is not at a position,
    /// [`StructureError::OutOfBounds`] for a hanging mass or its frequency that is not positive.
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
        check_hung(&changes.hanging_masses)?;
        modal.hung.clone_from(&changes.hanging_masses);
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
}
