//! Where the force of a contact jumps: a damper that takes hold, or lets go, with a velocity.
//!
//! The jump is `c u̇` where the rest of the force, G, passes zero. Its phase moves with the motion,
//! `dφ = −(b + (∂G/∂state dstate) / (∂G/∂u)) / u′`, and the coefficients of the force with it by
//! `e(φ) |c| Ω (b + (∂G/∂state dstate) / (∂G/∂u))`: the slope u′ cancels.
//!
//! Behind a spring of the compliance a there is no jump. The contact itself rests while the spring takes up the force of
//! the damper, with the slope 1/a.

use crate::contact::{Inputs, StateTangents};
use crate::harmonic::period::PeriodicContact;
use crate::harmonic::period::motion::{Motion, Turning};

/// How far beside a jump the law is looked at, as a fraction of the leg.
const BESIDE: f64 = 1e-9;
/// Halvings that leave nothing of an interval.
const BISECTIONS: usize = 60;

/// A jump between two turning points.
#[derive(Debug)]
pub(super) struct Jump {
    pub phase: f64,
    /// m.
    displacement: f64,
    /// The damper (N s/m); one that feeds energy in lets go.
    pub damping: f64,
    /// −∂displacement/∂state at the turning point behind.
    pub by_state: Vec<f64>,
}

impl Jump {
    /// The jump on the leg between two turning points, `state` being that at the first; the last argument is for use.
    pub fn find(
        contact: &PeriodicContact,
        state: &[f64],
        motion: &Motion,
        (from, to): (&Turning, &Turning),
        (next, tangents): (&mut [f64], &mut StateTangents),
    ) -> Option<Self> {
        let way = to.value - from.value;
        let at = |displacement| Inputs { displacement, velocity: way, normal_load: contact.normal_load };
        let crate::contact::Jump { displacement, damping } = contact.law.jump(state, at(to.value))?;
        // On the side on which the damper holds, where the force tells what the place depends on.
        let closed = at(displacement + BESIDE * way * damping.signum());
        let stiffness = contact.law.force_and_tangents(state, closed, next, tangents).tangents.displacement;
        let by_state = tangents.force_by_state.iter().map(|by_state| by_state / stiffness).collect();
        let phase = motion.phase_of(displacement, from, to);
        (stiffness > 0.0).then_some(Self { phase, displacement, damping, by_state })
    }

    /// Force (N) where the contact rests while a spring of `compliance` (m/N) takes up the damper's force.
    pub fn taken_up(&self, compliance: f64, displacement: f64, velocity: f64) -> Option<f64> {
        let (force, damper) = ((displacement - self.displacement) / compliance, self.damping * velocity);
        (force * damper > 0.0 && force.abs() < damper.abs()).then_some(force)
    }

    /// Where that ends, or begins if the damper lets go, between the turning points at `from` and `to` (rad).
    pub fn other_end(
        &self,
        contact: &PeriodicContact,
        angular_frequency: f64,
        motion: &Motion,
        leg: (f64, f64),
    ) -> f64 {
        let (mut near, mut far) = (self.phase, if self.damping > 0.0 { leg.1 } else { leg.0 });
        for _ in 0..BISECTIONS {
            let middle = 0.5 * (near + far);
            let (displacement, slope) = motion.value_and_slope(middle);
            match self.taken_up(contact.compliance, displacement, angular_frequency * slope) {
                Some(_) => near = middle,
                None => far = middle,
            }
        }
        0.5 * (near + far)
    }
}
