//! The elements behind the play of a joint: sliders or a law that slips gradually, under a load that scales the limit.

use super::look::{Look, Path};
use super::sliders::Sliders;
use crate::contact::gradual::{GradualLaw, STATE};
use crate::contact::{Inputs, SlipState, StateTangents};

/// The law proper.
#[derive(Debug, Clone)]
pub(super) enum Base {
    Sliders(Sliders),
    Gradual(Box<dyn GradualLaw>),
}

impl Base {
    pub fn state_len(&self) -> usize {
        match self {
            Self::Sliders(sliders) => sliders.state_len(),
            Self::Gradual(law) => law.state_len(),
        }
    }

    /// Where in the state the displacement at the end of the last step stands.
    pub fn displacement_index(&self) -> usize {
        match self {
            Self::Sliders(_) => 0,
            Self::Gradual(_) => 1,
        }
    }

    /// Displacement (m) and load (N) at the end of the last step.
    pub fn before(&self, state: &[f64]) -> (f64, f64) {
        match self {
            Self::Sliders(_) => (state[0], state[1]),
            Self::Gradual(_) => (state[1], state[2]),
        }
    }

    /// Multiplies the load (N) at the end of the last step.
    pub fn scale_load(&self, state: &mut [f64], factor: f64) {
        match self {
            Self::Sliders(_) => state[1] *= factor,
            Self::Gradual(_) => state[2] *= factor,
        }
    }

    /// Largest force (N) in either direction.
    pub fn limit(&self, load: f64) -> f64 {
        match self {
            Self::Sliders(sliders) => sliders.limit(load),
            Self::Gradual(law) => law.limit(load) * (1.0 + law.gradual().asymmetry.abs()),
        }
    }

    /// Writes the state that carries `force` (N), or as much of it as the limit allows; returns that.
    pub fn set_state(&self, displacement: f64, load: f64, force: f64, state: &mut [f64]) -> f64 {
        match self {
            Self::Sliders(sliders) => sliders.set_state(displacement, load, force, state),
            Self::Gradual(law) => {
                law.set_state(displacement, load, force, state);
                state[0]
            }
        }
    }

    /// One step in place; the force (N).
    #[inline]
    pub fn advance(&self, state: &mut [f64], displacement: f64, load: f64) -> f64 {
        match self {
            Self::Sliders(sliders) => sliders.advance(state, displacement, load),
            Self::Gradual(law) => law.advance(state, inputs(displacement, load)),
        }
    }

    /// Force (N) and its slope (N/m) after a step.
    pub fn force(&self, state: &[f64], displacement: f64, load: f64) -> (f64, f64) {
        match self {
            Self::Sliders(sliders) => sliders.force(state, displacement, load),
            Self::Gradual(law) => {
                let response = law.step(state, inputs(displacement, load), &mut [0.0; STATE]);
                (response.force, response.tangents.displacement)
            }
        }
    }

    /// Distance slipped in a step. Of a gradual law that is the displacement less the elastic part of the force.
    pub fn path(&self, state: &[f64], displacement: f64, load: f64) -> Path {
        match self {
            Self::Sliders(sliders) => sliders.path(state, displacement, load),
            Self::Gradual(_) => self.look(state, displacement, load).path,
        }
    }

    /// Everything about a step but the next state.
    pub fn look(&self, state: &[f64], displacement: f64, load: f64) -> Look {
        match self {
            Self::Sliders(sliders) => sliders.look(state, displacement, load),
            Self::Gradual(_) => self.step(state, displacement, load, &mut [0.0; STATE]),
        }
    }

    /// Everything about a step; writes the next state.
    pub fn step(&self, state: &[f64], displacement: f64, load: f64, next: &mut [f64]) -> Look {
        let law = match self {
            Self::Sliders(sliders) => {
                let look = sliders.look(state, displacement, load);
                next.copy_from_slice(state);
                sliders.advance(next, displacement, load);
                return look;
            }
            Self::Gradual(law) => law,
        };
        let response = law.step(state, inputs(displacement, load), next);
        let mut path = Path::default();
        // A step in which the contact opens or closes is left out: the path there is of no account.
        if load > 0.0 && state[2] > 0.0 {
            let elastic = 1.0 / law.gradual().hysteretic_stiffness;
            let plastic = (displacement - state[1]) - elastic * (next[0] - state[0]);
            let sign = plastic.signum();
            let slope = response.tangents.displacement - law.gradual().residual_stiffness;
            path = Path {
                length: plastic.abs(),
                by_displacement: sign * (1.0 - elastic * slope),
                by_load: -sign * elastic * response.tangents.normal_load,
            };
        }
        Look {
            force: response.force,
            by_displacement: response.tangents.displacement,
            by_load: response.tangents.normal_load,
            dissipated_energy: response.dissipated_energy,
            path,
            slips: response.slip_state == SlipState::Slip,
        }
    }

    /// Derivatives of a step with respect to the state, in the block that begins at `offset`, and those of the
    /// path in the row `path_row` before it. By displacement and load stand in the columns of both inputs.
    pub fn partials(
        &self,
        state: &[f64],
        displacement: f64,
        load: f64,
        out: &mut StateTangents,
        (offset, path_row): (usize, usize),
    ) {
        let law = match self {
            Self::Sliders(sliders) => {
                return sliders.partials(state, displacement, load, out, (offset, path_row));
            }
            Self::Gradual(law) => law,
        };
        let n = out.force_by_state.len();
        let path = self.look(state, displacement, load).path;
        law.state_tangents(state, inputs(displacement, load), out);
        let mut own = [[0.0; STATE]; STATE + 3];
        own[0].copy_from_slice(&out.force_by_state);
        own[1].copy_from_slice(&out.next_by_displacement);
        own[2].copy_from_slice(&out.next_by_normal_load);
        for row in 0..STATE {
            own[3 + row].copy_from_slice(&out.next_by_state[row * STATE..(row + 1) * STATE]);
        }
        out.reset(n);
        let block = offset..offset + STATE;
        out.force_by_state[block.clone()].copy_from_slice(&own[0]);
        out.next_by_displacement[block.clone()].copy_from_slice(&own[1]);
        out.next_by_normal_load[block.clone()].copy_from_slice(&own[2]);
        for row in 0..STATE {
            out.next_by_state[(offset + row) * n + offset..][..STATE].copy_from_slice(&own[3 + row]);
        }
        if path.length > 0.0 {
            let elastic = 1.0 / law.gradual().hysteretic_stiffness;
            let plastic = (displacement - state[1])
                - elastic * (own_end(law.as_ref(), state, displacement, load) - state[0]);
            let sign = plastic.signum();
            let row = &mut out.next_by_state[path_row * n + offset..][..STATE];
            for (column, entry) in row.iter_mut().enumerate() {
                let by_start = [elastic, -1.0, 0.0, 0.0][column];
                *entry = sign * (by_start - elastic * own[3][column]);
            }
        }
    }

    /// Energy (J) kept.
    pub fn stored_energy(&self, state: &[f64]) -> f64 {
        match self {
            Self::Sliders(sliders) => sliders.stored_energy(state),
            Self::Gradual(law) => law.stored_energy(state),
        }
    }
}

/// Hysteretic force (N) of a gradual law after a step.
fn own_end(law: &dyn GradualLaw, state: &[f64], displacement: f64, load: f64) -> f64 {
    let mut next = [0.0; STATE];
    law.step(state, inputs(displacement, load), &mut next);
    next[0]
}

fn inputs(displacement: f64, normal_load: f64) -> Inputs {
    Inputs { displacement, velocity: 0.0, normal_load }
}
