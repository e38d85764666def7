//! The scalar equation `T = law(u_geometric − flexibility · T)` at the contact.

use crate::contact::{ContactLaw, Inputs, Response};

/// What the law sees of the beam at one instant.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ContactPoint {
    /// Displacement without the part due to the force itself (m).
    pub displacement: f64,
    /// Velocity without that part (m/s).
    pub velocity: f64,
    /// How far the contact yields per force (m/N), not negative.
    pub flexibility: f64,
    /// Normal load (N).
    pub normal_load: f64,
    /// First guess of the force (N).
    pub guess: f64,
}

impl ContactPoint {
    /// Solves for the force; returns the law's response and the displacement it was evaluated at (m),
    /// and writes the next contact state. `None` if the law returns no finite force.
    ///
    /// `F(T) = T − law(u − flexibility · T)` rises with slope `1 + flexibility · tangent ≥ 1`, so its
    /// root lies between any `T` and `T − F(T)`: every evaluation brackets it, and Newton's step
    /// stays inside. Bisection takes over where the law's rounding or its kinks stop Newton.
    pub fn solve(&self, law: &dyn ContactLaw, state: &[f64], next: &mut [f64]) -> Option<(Response, f64)> {
        let mut force = if self.flexibility == 0.0 { 0.0 } else { self.guess };
        let (mut low, mut high) = (f64::NEG_INFINITY, f64::INFINITY);
        let mut velocity = self.velocity;
        for _ in 0..80 {
            let displacement = self.displacement - self.flexibility * force;
            let inputs = Inputs { displacement, velocity, normal_load: self.normal_load };
            let response = law.step(state, inputs, next);
            if !response.force.is_finite() {
                return None;
            }
            let tangent = response.tangents.displacement.max(0.0);
            let slope = 1.0 + self.flexibility * tangent;
            let residual = force - response.force;
            let rounding = 4.0 * f64::EPSILON * (response.force.abs() + tangent * displacement.abs());
            if self.flexibility == 0.0 || residual.abs() <= rounding {
                return Some((response, displacement));
            }
            if residual > 0.0 {
                high = high.min(force);
                low = low.max(force - residual);
            } else {
                low = low.max(force);
                high = high.min(force - residual);
            }
            let newton = force - residual / slope;
            let following = if newton >= low && newton <= high { newton } else { 0.5 * (low + high) };
            if following == force || high <= low {
                return Some((response, displacement));
            }
            force = following;
            velocity = self.velocity / slope;
        }
        None
    }
}
