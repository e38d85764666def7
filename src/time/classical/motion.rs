//! Where a system in equal steps is, its energies, and what its contacts do.

use crate::contact::SlipState;

/// Where a system is, and what its contacts remember.
#[derive(Debug, Clone, PartialEq)]
pub struct SteppedMotion {
    /// Modal displacements (kg^1/2 m) and velocities.
    pub displacement: Vec<f64>,
    /// See `displacement`.
    pub velocity: Vec<f64>,
    /// Memory of the laws, element after element.
    pub(super) memory: Vec<f64>,
    /// Energies (J) since the beginning.
    pub energies: Energies,
    /// What the contacts in two directions do, in their order.
    pub contacts: Vec<ContactInTwo>,
}

/// Energies (J).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Energies {
    /// Work of the exciters, and of forces from outside.
    pub work: f64,
    /// Dissipated by the modes' damping.
    pub viscous: f64,
    /// Dissipated by friction.
    pub friction: f64,
    /// Dissipated by impacts.
    pub impact: f64,
}

/// A contact in two directions at the end of a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactInTwo {
    /// ξ and η (m).
    pub displacement: [f64; 2],
    /// S and N (N).
    pub force: [f64; 2],
    /// N_c (N).
    pub normal_force: f64,
    /// Distance of the bodies (m).
    pub separation: f64,
    /// What it does.
    pub slip_state: SlipState,
    /// ∂S/∂ξ (N/m) there.
    pub tangent: f64,
}

impl SteppedMotion {
    /// Numbers that [`SteppedMotion::write_state`] writes.
    pub(crate) fn state_len(&self) -> usize {
        2 * self.displacement.len() + self.memory.len()
    }

    /// Writes what the motion goes on from: modes and memories.
    pub(crate) fn write_state(&self, state: &mut [f64]) {
        let numbers = self.displacement.iter().chain(&self.velocity).chain(&self.memory);
        state.iter_mut().zip(numbers).for_each(|(to, from)| *to = *from);
    }

    /// Takes over what a state has; energies begin anew, and contacts are known after the next step.
    pub(crate) fn read_state(&mut self, state: &[f64]) {
        let numbers = self.displacement.iter_mut().chain(&mut self.velocity).chain(&mut self.memory);
        numbers.zip(state).for_each(|(to, from)| *to = *from);
        self.energies = Energies::default();
    }
}
