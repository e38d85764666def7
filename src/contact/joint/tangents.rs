//! Derivatives of a joint's step: those of the base law carried through wear, weakening and play.

use super::look::Look;
use super::{BASE, DAMPER, End, Joint, SIDE, SLIP};
use crate::contact::{Inputs, StateTangents, Tangents};

/// How the end of a step hangs on what it starts from, to first order.
struct Chain<'a> {
    end: &'a End,
    look: &'a Look,
    /// Slope (N/m) of all springs and the base law behind the play.
    slope: f64,
    /// ∂load/∂slip (N/m).
    load_by_slip: f64,
    /// Whether the distance slipped is counted in this step.
    counts: bool,
}

/// Changes of one cause: of what the step starts from at fixed w, load and slip.
#[derive(Clone, Copy, Default)]
struct Cause {
    /// Of the displacement in front of the play.
    displacement: f64,
    /// Of the displacement behind the play before the step.
    before: f64,
    load: f64,
    slip: f64,
    /// Of the base law's force.
    force: f64,
    /// Of the path in this step.
    path: f64,
}

/// Changes of the end.
#[derive(Clone, Copy)]
struct Effect {
    displacement: f64,
    load: f64,
    slip: f64,
    /// Of springs and base law together; zero where the play is open.
    force: f64,
}

impl Chain<'_> {
    #[inline]
    fn effect(&self, cause: Cause) -> Effect {
        let (look, path) = (self.look, &self.look.path);
        // The usual case: nothing in between, and no slip that wears.
        if self.end.follows && !self.counts && self.load_by_slip == 0.0 {
            let Cause { displacement, load, slip, .. } = cause;
            let force = self.slope * displacement + look.by_load * load + cause.force;
            return Effect { displacement, load, slip, force };
        }
        // In the gap the base law's end rests, or moves so that the force stays zero.
        let (by_force, given) = match self.end {
            End { follows: true, .. } => (0.0, cause.displacement),
            End { rests: true, .. } => (0.0, cause.before),
            _ => (-1.0 / self.slope, 0.0),
        };
        let by_force = if by_force.is_finite() { by_force } else { 0.0 };
        // w = given + by_force (force + by_load load), slip = slip₀ + path₀ + path_w w + path_L load.
        let moved = given + by_force * cause.force;
        let by_load = path.by_load + path.by_displacement * by_force * look.by_load;
        let own = cause.path + path.by_displacement * moved + by_load * cause.load;
        let slip =
            if self.counts { (cause.slip + own) / (1.0 - by_load * self.load_by_slip) } else { cause.slip };
        let load = cause.load + self.load_by_slip * slip;
        let displacement = moved + by_force * look.by_load * load;
        let force = if self.end.follows {
            self.slope * displacement + look.by_load * load + cause.force
        } else {
            0.0
        };
        Effect { displacement, load, slip, force }
    }
}

impl Joint {
    fn chain<'a>(&self, inputs: Inputs, end: &'a End, look: &'a Look) -> Chain<'a> {
        let slope = look.by_displacement + self.spring(end.displacement).1;
        let by_slip = self.wear_factor(end.slip).1;
        let load_by_slip = inputs.normal_load * end.speed.0 * by_slip;
        Chain { end, look, slope, load_by_slip, counts: self.changes.wear != 0.0 && inputs.normal_load > 0.0 }
    }

    /// Changes by displacement, velocity and normal load.
    fn causes(&self, inputs: Inputs, end: &End) -> [Cause; 3] {
        let (factor, by_velocity) = end.speed;
        let worn = self.wear_factor(end.slip).0;
        [
            Cause { displacement: 1.0, ..Cause::default() },
            Cause { load: inputs.normal_load * by_velocity * worn, ..Cause::default() },
            Cause { load: factor * worn, ..Cause::default() },
        ]
    }

    /// Derivatives of the whole force, from those of springs and base law: the damper may stand against them.
    fn whole(&self, inputs: Inputs, end: &End, look: &Look) -> (f64, f64) {
        let force = look.force + self.spring(end.displacement).0;
        match self.damper(end, force, inputs.velocity) {
            (_, true) => (1.0, self.changes.damping),
            (damper, false) if damper != 0.0 => (0.0, 0.0),
            _ => (1.0, 0.0),
        }
    }

    /// Derivatives of the force with respect to the inputs.
    pub(super) fn tangents(&self, inputs: Inputs, end: &End, look: &Look) -> Tangents {
        let chain = self.chain(inputs, end, look);
        let (factor, by_velocity) = self.whole(inputs, end, look);
        let [displacement, velocity, normal_load] = self.causes(inputs, end);
        let by = |cause| factor * chain.effect(cause).force;
        Tangents {
            displacement: by(displacement),
            velocity: by(velocity) + by_velocity,
            normal_load: by(normal_load),
        }
    }

    pub(super) fn write_state_tangents(&self, state: &[f64], inputs: Inputs, out: &mut StateTangents) {
        let end = self.end(state, inputs);
        let base = &state[BASE..];
        let look = self.base.look(base, end.displacement, end.load);
        let n = state.len();
        out.reset(n);
        self.base.partials(base, end.displacement, end.load, out, (BASE, SLIP));
        let chain = self.chain(inputs, &end, &look);
        let (factor, by_velocity) = self.whole(inputs, &end, &look);
        for column in 0..n {
            let own = (out.force_by_state[column], out.next_by_state[SLIP * n + column]);
            let effect = chain.effect(self.cause(column, own));
            // What a slider remembers moves neither the end nor its load.
            if effect.displacement != 0.0 || effect.load != 0.0 {
                for row in BASE..n {
                    out.next_by_state[row * n + column] += out.next_by_displacement[row]
                        * effect.displacement
                        + out.next_by_normal_load[row] * effect.load;
                }
            }
            out.next_by_state[SIDE * n + column] = 0.0;
            out.next_by_state[SLIP * n + column] = effect.slip;
            out.next_by_state[DAMPER * n + column] = (factor - 1.0) * effect.force;
            out.force_by_state[column] = factor * effect.force;
        }
        self.write_input_tangents(inputs, &end, &chain, (factor, by_velocity), out);
    }

    /// Change of the state's number `column` alone, which changes base law's force and path by what is given.
    fn cause(&self, column: usize, (force, path): (f64, f64)) -> Cause {
        Cause {
            slip: if column == SLIP { 1.0 } else { 0.0 },
            before: if column == BASE + self.base.displacement_index() { 1.0 } else { 0.0 },
            force,
            path,
            ..Cause::default()
        }
    }

    /// ∂force/∂state, `count` entries, from what each does to the base law's force and path.
    pub(super) fn write_force_by_state(
        &self,
        count: usize,
        inputs: Inputs,
        (end, look): (&End, &Look),
        own: impl Fn(usize) -> (f64, f64),
        out: &mut Vec<f64>,
    ) {
        let chain = self.chain(inputs, end, look);
        let factor = self.whole(inputs, end, look).0;
        out.clear();
        out.extend((0..count).map(|column| factor * chain.effect(self.cause(column, own(column))).force));
    }

    /// Derivatives of the next state by the inputs; in the columns of displacement and load stand those of the base law.
    fn write_input_tangents(
        &self,
        inputs: Inputs,
        end: &End,
        chain: &Chain<'_>,
        (factor, by_velocity): (f64, f64),
        out: &mut StateTangents,
    ) {
        let effects = self.causes(inputs, end).map(|cause| chain.effect(cause));
        for row in BASE..out.force_by_state.len() {
            let (by_displacement, by_load) = (out.next_by_displacement[row], out.next_by_normal_load[row]);
            let [u, v, load] =
                effects.map(|effect| by_displacement * effect.displacement + by_load * effect.load);
            out.next_by_displacement[row] = u;
            out.next_by_velocity[row] = v;
            out.next_by_normal_load[row] = load;
        }
        let [u, v, load] = effects;
        out.next_by_displacement[SLIP] = u.slip;
        out.next_by_velocity[SLIP] = v.slip;
        out.next_by_normal_load[SLIP] = load.slip;
        out.next_by_displacement[DAMPER] = (factor - 1.0) * u.force;
        out.next_by_velocity[DAMPER] = (factor - 1.0) * v.force + by_velocity;
        out.next_by_normal_load[DAMPER] = (factor - 1.0) * load.force;
    }
}
