//! A contact in two directions: friction under the normal force that the normal motion makes.

mod derivatives;
mod energy;
mod normal;
mod tangential;

use std::f64::consts::TAU;
use std::sync::Arc;

use stickslip::contact::{
    BoucWen, ContactLaw, Iwan, IwanSpacing, Jenkins, Joint, JointChanges, NormalDirection, NormalLaw,
    SlipSlap, SlipSlapInputs, SlipSlapResponse, SlipSlapWork, Valanis,
};

/// Preload (N) and normal stiffness (N/m).
pub const PRELOAD: f64 = 68.67;
pub const STIFFNESS: f64 = 2.37e7;

pub fn normal(law: NormalLaw, impact_damping: f64) -> NormalDirection {
    NormalDirection::new(law, PRELOAD, STIFFNESS, impact_damping).unwrap()
}

/// Linear, hardening and Hertz' law, with and without damping.
pub fn normals() -> Vec<NormalDirection> {
    let laws = [
        NormalLaw::Linear,
        NormalLaw::Cubic { cubic_stiffness: 1e18 },
        NormalLaw::Hertz { exponent: 1.0 },
        NormalLaw::Hertz { exponent: 1.5 },
        NormalLaw::Hertz { exponent: 2.0 },
    ];
    laws.into_iter().flat_map(|law| [0.0, 30.0].map(|damping| normal(law, damping))).collect()
}

/// Every law of friction, and one with all that may stand beside it. A residual stiffness (N/m) of a gradual law lets go
/// at once where the bodies part: the force jumps there.
pub fn frictions(residual: f64) -> Vec<Arc<dyn ContactLaw>> {
    let jenkins = || Jenkins::new(3.95e6, 0.6).unwrap();
    let changes = JointChanges {
        residual_stiffness: 1e5,
        damping: 20.0,
        asymmetry: 0.1,
        weakening: Some((0.3, 5e-3)),
        ..JointChanges::default()
    };
    vec![
        Arc::new(jenkins()),
        Arc::new(Iwan::new(3.95e6, 0.6, -0.5, 1.0, 10, IwanSpacing::Equal).unwrap()),
        Arc::new(Valanis::new(3.95e6, 0.6, 0.3, residual).unwrap()),
        Arc::new(BoucWen::new(3.95e6, 0.6, 2.0, 1.0, residual).unwrap()),
        Arc::new(Joint::new(jenkins(), changes).unwrap()),
    ]
}

/// A contact carried along with its state.
pub struct History {
    pub contact: SlipSlap,
    pub state: Vec<f64>,
    work: SlipSlapWork,
}

impl History {
    /// At rest under the preload.
    pub fn new(law: Arc<dyn ContactLaw>, normal: NormalDirection) -> Self {
        let contact = SlipSlap::new(law, normal);
        let mut state = vec![0.0; contact.state_len()];
        contact.set_state([0.0; 2], 0.0, &mut state);
        Self { contact, state, work: SlipSlapWork::default() }
    }

    pub fn go(&mut self, inputs: SlipSlapInputs) -> SlipSlapResponse {
        let mut next = self.state.clone();
        let response = self.contact.step(&self.state, inputs, &mut next, &mut self.work);
        self.state = next;
        response
    }
}

/// `[ξ, η]` with amplitudes (m), orders and phases (rad) of a motion over a period of 1/50 s, at `time` (s).
pub fn motion(amplitudes: [f64; 2], orders: [f64; 2], phases: [f64; 2], time: f64) -> SlipSlapInputs {
    let omega = orders.map(|order| order * TAU * 50.0);
    let at = |i: usize| amplitudes[i] * (omega[i] * time + phases[i]).sin();
    let rate = |i: usize| amplitudes[i] * omega[i] * (omega[i] * time + phases[i]).cos();
    SlipSlapInputs { displacement: [at(0), at(1)], velocity: [rate(0), rate(1)] }
}
