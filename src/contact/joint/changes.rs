//! The changes of a joint by effects: of its law, of the elements beside the law and in series, and of its load.

use crate::contact::slip_slap::polynomial;

/// Changes of the contact's law. Zero, or `None`, changes nothing.
///
/// With the relative displacement u behind the play, the velocity v and the slip distance s,
/// `T = T_law(u; limit · m) + e_t u + k3 u³ + c v`, where the limit's factor is
/// `m = (1 + δ exp(−|v|/v_s)) (1 + w s) (1 ± a)` and follows the normal load.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct JointChanges {
    /// Half-width of the distribution of the sliders' yield displacements over its mean (1), in [0, 1].
    pub spread: f64,
    /// e_t (N/m): spring beside the law.
    pub residual_stiffness: f64,
    /// c (N s/m): damper beside the law.
    pub damping: f64,
    /// k3 (N/m³): cubic spring beside the law.
    pub cubic_stiffness: f64,
    /// δ (1) and v_s (m/s).
    pub weakening: Option<(f64, f64)>,
    /// w (1/m): change of the limit with the distance slipped since the start of the record.
    pub wear: f64,
    /// a (1): the limit is `1 + a` times as large against positive slip, `1 − a` against negative.
    pub asymmetry: f64,
    /// g (m): half of the play in series with the law and all beside it.
    pub half_gap: f64,
    /// The fraction (1) of the measured change of the normal load that reaches the contact; `None`: the load is
    /// constant.
    pub load_gain: Option<f64>,
    /// N/m³: what the normal displacement adds to the load beyond the linear stiffness.
    pub normal_cubic_stiffness: f64,
    /// λ (s/m): Hunt–Crossley's factor `1 + λ δ̇` on the normal load.
    pub impact_damping: f64,
}

impl JointChanges {
    /// Normal load (N) on a contact of the constant load `constant` (N), under which `measured` (N) was measured
    /// where a normal load was: the fraction of the measured change that reaches the contact is
    /// [`JointChanges::load_gain`], none where that is `None`. At zero or below the contact is apart.
    #[inline]
    pub fn normal_load(&self, constant: f64, measured: Option<f64>) -> f64 {
        match (self.load_gain, measured) {
            (Some(gain), Some(measured)) => constant + gain * (measured - constant),
            _ => constant,
        }
    }

    /// Normal load (N), never below zero, of a contact that is pressed together by `displacement` (m) at the
    /// rate `velocity` (m/s): `(N₀ + k δ + k3 δ³)(1 + λ δ̇)`, with the load N₀ (N) at rest and the normal
    /// stiffness k (N/m).
    pub fn normal_reaction(&self, constant: f64, stiffness: f64, displacement: f64, velocity: f64) -> f64 {
        let elastic = polynomial(constant, stiffness, self.normal_cubic_stiffness, displacement);
        (elastic.max(0.0) * (1.0 + self.impact_damping * velocity)).max(0.0)
    }

    /// Whether the law stays as it is, whatever happens to the normal load.
    pub fn is_none(&self) -> bool {
        let law = Self { load_gain: None, normal_cubic_stiffness: 0.0, impact_damping: 0.0, ..*self };
        law == Self::default()
    }
}
