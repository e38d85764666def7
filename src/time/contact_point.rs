//! The scalar equation `T = law(u_geometric − flexibility · T)` at the contact.

use crate::contact::{ContactLaw, Inputs, Response};

/// Evaluations with Newton's step; it needs about five, and where rounding makes it go to and fro, none
/// of the further ones help.
const NEWTON: usize = 20;
/// Evaluations in all: bisection gets from any bracket to neighbouring numbers in the others.
const EVALUATIONS: usize = 100;

/// Shortest way since the step began, as a fraction of the displacement, from which rounding leaves a usable share.
const LEAST_WAY: f64 = 1e-12;

/// What the law sees of the beam at one instant.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ContactPoint {
    /// Displacement without the part due to the force itself (m).
    pub displacement: f64,
    /// Velocity without that part (m/s).
    pub velocity: f64,
    /// How far the contact yields per force (m/N), not negative.
    pub flexibility: f64,
    /// The part of it that lies in series with the contact and takes a part of the velocity.
    pub series: f64,
    /// Displacements (m) in front of what lies in series and behind it where the step began.
    pub began: [f64; 2],
    /// By how much it moves slower per force above `placed` (m/(s N)), not negative.
    pub slowing: f64,
    /// The law's tangent by displacement (N/m) to begin with.
    pub tangent: f64,
    /// Whether its force falls with the velocity, to begin with.
    pub falls: bool,
    /// Normal load (N).
    pub normal_load: f64,
    /// Force (N) under which it has that velocity.
    pub placed: f64,
    /// First guess of the force (N).
    pub guess: f64,
    /// Residual accepted, relative to the force and to what the displacement rounds it by.
    pub precision: f64,
}

/// What a law answered, and the displacement (m) and velocity (m/s) that it was asked with.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Answered {
    pub response: Response,
    pub displacement: f64,
    pub velocity: f64,
}

/// As good as rounding lets it.
pub(crate) const EXACT: f64 = 4.0 * f64::EPSILON;

impl ContactPoint {
    /// Solves for the force and writes the next contact state. `None` if the law returns no finite force.
    ///
    /// `F(T) = T − law(u − flexibility · T)` rises with slope `1 + flexibility · tangent ≥ 1`, so its
    /// root lies between any `T` and `T − F(T)`: every evaluation brackets it, and Newton's step
    /// stays inside. Bisection takes over where the law's rounding or its kinks stop Newton: the law
    /// rounds as its memory does, so that a force near zero is rounded more coarsely than its size says.
    pub fn solve(&self, law: &dyn ContactLaw, state: &[f64], next: &mut [f64]) -> Option<Answered> {
        let mut force = if self.flexibility == 0.0 { 0.0 } else { self.guess };
        let (mut low, mut high) = (f64::NEG_INFINITY, f64::INFINITY);
        let (mut velocity, mut yielding) = self.velocity_under(force, self.tangent, self.falls);
        // A force that falls with the velocity may answer by more than itself.
        let reach = if self.slowing == 0.0 { 1.0 } else { 2.0 };
        for evaluation in 0..EVALUATIONS {
            let displacement = self.displacement - self.flexibility * force;
            let inputs = Inputs { displacement, velocity, normal_load: self.normal_load };
            let response = law.step(state, inputs, next);
            if !response.force.is_finite() {
                return None;
            }
            let tangent = response.tangents.displacement.max(0.0);
            let by_velocity = yielding * response.tangents.velocity;
            let slope = (1.0 + self.flexibility * tangent + by_velocity).max(0.5);
            let residual = force - response.force;
            let rounding = self.precision * (response.force.abs() + tangent * displacement.abs());
            if self.flexibility == 0.0 || residual.abs() <= rounding {
                return Some(Answered { response, displacement, velocity });
            }
            if residual > 0.0 {
                high = high.min(force);
                low = low.max(force - reach * residual);
            } else {
                low = low.max(force);
                high = high.min(force - reach * residual);
            }
            let newton = force - residual / slope;
            let inside = newton >= low && newton <= high;
            let following = if inside && evaluation < NEWTON { newton } else { 0.5 * (low + high) };
            if following == force || high <= low {
                return Some(Answered { response, displacement, velocity });
            }
            force = following;
            (velocity, yielding) = self.velocity_under(force, tangent, response.tangents.velocity < 0.0);
        }
        None
    }

    /// The velocity (m/s) that the law sees under a force, and how much slower a larger force makes it (m/(s N)).
    ///
    /// What lies in series takes the part of the velocity that it took of the way since the step began. By the law's
    /// tangent alone the velocity would jump where a slider lets go, and the force of a damper with it, which would put the
    /// slider back: in truth that force relaxes while the spring takes it up, within this step or the next. Where the force
    /// `falls` with the velocity it would run away instead: there the law sees the velocity in front.
    fn velocity_under(&self, force: f64, tangent: f64, falls: bool) -> (f64, f64) {
        let velocity = self.velocity - self.slowing * (force - self.placed);
        if self.series == 0.0 || falls {
            return (velocity, self.slowing);
        }
        let own = self.displacement - self.flexibility * force;
        let [front, behind] = self.began;
        let moved = own + self.series * force - front;
        let known = moved.abs() > LEAST_WAY * (own.abs() + behind.abs());
        if !known || moved * velocity <= 0.0 {
            return (velocity / (1.0 + self.series * tangent), self.slowing);
        }
        let share = (own - behind) / moved;
        (velocity * share, self.slowing * share + velocity * self.series / moved)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::Valanis;

    /// Forces near zero on the way back from a larger one, where Newton's step went to and fro between
    /// two numbers next to each other.
    #[test]
    fn a_force_that_the_law_rounds_coarsely_is_found() {
        let law = Valanis::new(7.9e6, 0.6, 0.3, 0.0).unwrap();
        let point = |displacement, velocity, flexibility, normal_load, guess| ContactPoint {
            displacement,
            velocity,
            flexibility,
            series: flexibility,
            began: [0.0; 2],
            slowing: 0.0,
            tangent: 0.0,
            falls: false,
            normal_load,
            placed: guess,
            guess,
            precision: EXACT,
        };
        for (point, force, displacement, origin) in [
            (
                point(
                    -1.6887542010522152e-10,
                    -9.822542774585608e-4,
                    1.5228426405456837e-8,
                    62.56481246380056,
                    -1.2492228166403122e-3,
                ),
                0.027570691225917075,
                3.497343814665358e-9,
                0.0,
            ),
            (
                point(
                    -8.570894017970955e-7,
                    -5.0795596650554335e-3,
                    1.6430909426042125e-8,
                    131.85087202488123,
                    17.19895144022218,
                ),
                -39.84509572770177,
                -6.042049047763668e-6,
                4.844040201091358e-6,
            ),
        ] {
            let state = [force, displacement, point.normal_load, origin];
            let mut next = [0.0; 4];
            let Answered { response, displacement: at, .. } =
                point.solve(&law, &state, &mut next).expect("a finite force");
            let direct = point.displacement - point.flexibility * response.force;
            assert!((at - direct).abs() <= 1e-14 * displacement.abs());
        }
    }
}
