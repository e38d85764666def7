//! The state of a beam in motion.

/// The state of a beam and of its contact, one flat list of numbers.
///
/// Layout, `n` modes and a contact memory of `m` numbers:
/// `[q (n), q̇ (n), contact memory (m), T, ∂T/∂u, ∂T/∂N, u, N, slip state, dissipated energy,
/// suggested step]`. Copying the list and writing it back restores the state bit for bit.
#[derive(Debug, Clone, PartialEq)]
pub struct BeamMotion {
    modes: usize,
    values: Vec<f64>,
}

/// Offsets behind the contact memory.
const FORCE: usize = 0;
const TANGENT: usize = 1;
const LOAD_TANGENT: usize = 2;
const DISPLACEMENT: usize = 3;
const NORMAL_LOAD: usize = 4;
const SLIP_STATE: usize = 5;
const DISSIPATED: usize = 6;
const STEP: usize = 7;
const SCALARS: usize = 8;

macro_rules! scalars {
    ($($(#[doc = $text:literal])+ $get:ident, $set:ident, $offset:ident;)*) => {
        $(
            $(#[doc = $text])+
            pub fn $get(&self) -> f64 {
                self.values[self.values.len() - SCALARS + $offset]
            }

            pub(crate) fn $set(&mut self, value: f64) {
                let index = self.values.len() - SCALARS + $offset;
                self.values[index] = value;
            }
        )*
    };
}

impl BeamMotion {
    /// All zero: `modes` modes and a contact memory of `contact_len` numbers.
    pub(crate) fn zero(modes: usize, contact_len: usize) -> Self {
        Self { modes, values: vec![0.0; Self::len_for(modes, contact_len)] }
    }

    pub(crate) const fn len_for(modes: usize, contact_len: usize) -> usize {
        2 * modes + contact_len + SCALARS
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

    /// The contact law's memory.
    pub fn contact_state(&self) -> &[f64] {
        &self.values[2 * self.modes..self.values.len() - SCALARS]
    }

    pub(crate) fn modal_displacement_mut(&mut self) -> &mut [f64] {
        &mut self.values[..self.modes]
    }

    pub(crate) fn modal_velocity_mut(&mut self) -> &mut [f64] {
        &mut self.values[self.modes..2 * self.modes]
    }

    pub(crate) fn contact_state_mut(&mut self) -> &mut [f64] {
        let end = self.values.len() - SCALARS;
        &mut self.values[2 * self.modes..end]
    }

    scalars! {
        /// Restoring contact force T at the end of the last step (N).
        contact_force, set_contact_force, FORCE;
        /// ∂T/∂u of the law at the end of the last step (N/m).
        tangent, set_tangent, TANGENT;
        /// ∂T/∂N of the law at the end of the last step (1).
        load_tangent, set_load_tangent, LOAD_TANGENT;
        /// Relative tangential displacement u of the contact at the end of the last step (m).
        displacement, set_displacement, DISPLACEMENT;
        /// Normal load at the end of the last step (N).
        normal_load, set_normal_load, NORMAL_LOAD;
        /// [`SlipState`](crate::contact::SlipState) at the end of the last step, as a number.
        slip_state, set_slip_state, SLIP_STATE;
        /// Energy dissipated in the contact since the start (J).
        dissipated_energy, set_dissipated_energy, DISSIPATED;
        /// Step size that the error control suggests for the next step (s); 0 before the first.
        suggested_step, set_suggested_step, STEP;
    }
}
