//! The state of a system in motion.

use crate::contact::SlipState;

/// The state of a system and of its contacts, one flat list of numbers.
///
/// Layout, `n` modes, laws that remember `m` numbers together: `[q (n), q̇ (n), memory (m)]`, then for every law and
/// outside force `[T, ∂T/∂u, ∂T/∂N, u, N, slip state, dissipated energy]`, then the suggested step. Copying the list
/// and writing it back restores the state bit for bit.
///
/// ```
/// use stickslip::system::{Core, Element, Port, System};
/// use stickslip::time::{Integrator, Ramp, Settings};
/// let system = System {
///     core: Core::Modal { angular_frequency: vec![5.0], damping_ratio: vec![0.01] },
///     shortening: vec![],
///     ports: vec![Port::linear("mass", vec![(0, 0.7)])],
///     elements: vec![],
///     driven: vec![0],
///     sensors: vec![0],
/// };
/// let (mut integrator, inputs) = (Integrator::new(&system)?, [Ramp::held(5.0)]);
/// let mut motion = integrator.rest(&inputs)?;
/// let start = motion.state().to_vec();
/// integrator.advance(&mut motion, 0.1, &inputs, &Settings::default())?;
/// let once = motion.clone();
/// // Back, and the same step again.
/// assert!(motion.read_state(&start));
/// integrator.advance(&mut motion, 0.1, &inputs, &Settings::default())?;
/// assert_eq!(motion, once);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Motion {
    modes: usize,
    contacts: usize,
    values: Vec<f64>,
}

/// Numbers of a contact besides its memory.
pub(crate) const PER_CONTACT: usize = 7;
const FORCE: usize = 0;
const TANGENT: usize = 1;
const LOAD_TANGENT: usize = 2;
const DISPLACEMENT: usize = 3;
const NORMAL_LOAD: usize = 4;
const SLIP_STATE: usize = 5;
const DISSIPATED: usize = 6;

/// A law, or a force from outside, at the end of the last step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactMotion {
    /// Restoring force T (N).
    pub force: f64,
    /// ∂T/∂u of the law (N/m).
    pub tangent: f64,
    /// ∂T/∂N of the law (1).
    pub load_tangent: f64,
    /// Displacement u of the port (m).
    pub displacement: f64,
    /// Normal load (N).
    pub normal_load: f64,
    /// Stick, slip or separated; always stick under a force from outside.
    pub slip_state: SlipState,
    /// Energy taken since the start (J).
    pub dissipated_energy: f64,
}

impl Motion {
    /// All zero.
    pub(crate) fn zero(modes: usize, memory: usize, contacts: usize) -> Self {
        Self { modes, contacts, values: vec![0.0; Self::len_for(modes, memory, contacts)] }
    }

    pub(crate) const fn len_for(modes: usize, memory: usize, contacts: usize) -> usize {
        2 * modes + memory + PER_CONTACT * contacts + 1
    }

    /// Length of the flat state.
    pub fn state_len(&self) -> usize {
        self.values.len()
    }

    /// The flat state.
    pub fn state(&self) -> &[f64] {
        &self.values
    }

    /// Copies the flat state to `out`. Returns false, without effect, where the length differs.
    #[must_use]
    pub fn write_state(&self, out: &mut [f64]) -> bool {
        let fits = out.len() == self.values.len();
        if fits {
            out.copy_from_slice(&self.values);
        }
        fits
    }

    /// Overwrites the flat state. Returns false, without effect, where the length differs.
    #[must_use]
    pub fn read_state(&mut self, state: &[f64]) -> bool {
        let fits = state.len() == self.values.len();
        if fits {
            self.values.copy_from_slice(state);
        }
        fits
    }

    /// Number of modes.
    pub fn modes(&self) -> usize {
        self.modes
    }

    /// Modal displacements q (m √kg).
    pub fn modal_displacement(&self) -> &[f64] {
        &self.values[..self.modes]
    }

    /// Modal velocities q̇ (m √kg / s).
    pub fn modal_velocity(&self) -> &[f64] {
        &self.values[self.modes..2 * self.modes]
    }

    /// What all laws remember.
    pub fn memory(&self) -> &[f64] {
        &self.values[2 * self.modes..self.first_contact()]
    }

    /// The law or outside force at `place`, counted over both in the order of the system's elements.
    ///
    /// # Panics
    /// Where the system has fewer.
    pub fn contact(&self, place: usize) -> ContactMotion {
        let from = self.first_contact() + PER_CONTACT * place;
        let values = &self.values[from..from + PER_CONTACT];
        let slip_state = [SlipState::Stick, SlipState::Slip, SlipState::Separated]
            .into_iter()
            .find(|state| f64::from(*state as i32) == values[SLIP_STATE]);
        ContactMotion {
            force: values[FORCE],
            tangent: values[TANGENT],
            load_tangent: values[LOAD_TANGENT],
            displacement: values[DISPLACEMENT],
            normal_load: values[NORMAL_LOAD],
            slip_state: slip_state.unwrap_or(SlipState::Stick),
            dissipated_energy: values[DISSIPATED],
        }
    }

    pub(crate) fn set_contact(&mut self, place: usize, to: &ContactMotion) {
        let from = self.first_contact() + PER_CONTACT * place;
        let slip_state = f64::from(to.slip_state as i32);
        self.values[from..from + PER_CONTACT].copy_from_slice(&[
            to.force,
            to.tangent,
            to.load_tangent,
            to.displacement,
            to.normal_load,
            slip_state,
            to.dissipated_energy,
        ]);
    }

    /// Number of laws and outside forces.
    pub fn contacts(&self) -> usize {
        self.contacts
    }

    /// Step size that the error control suggests for the next step (s); 0 before the first.
    pub fn suggested_step(&self) -> f64 {
        self.values[self.values.len() - 1]
    }

    pub(crate) fn set_suggested_step(&mut self, step: f64) {
        let last = self.values.len() - 1;
        self.values[last] = step;
    }

    pub(crate) fn modal_mut(&mut self) -> (&mut [f64], &mut [f64]) {
        self.values[..2 * self.modes].split_at_mut(self.modes)
    }

    /// Modal displacements, then velocities.
    pub(crate) fn modal_state(&self) -> &[f64] {
        &self.values[..2 * self.modes]
    }

    pub(crate) fn modal_state_mut(&mut self) -> &mut [f64] {
        &mut self.values[..2 * self.modes]
    }

    pub(crate) fn memory_mut(&mut self) -> &mut [f64] {
        let end = self.first_contact();
        &mut self.values[2 * self.modes..end]
    }

    fn first_contact(&self) -> usize {
        self.values.len() - 1 - PER_CONTACT * self.contacts
    }
}
