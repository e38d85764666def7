//! The motions of which a step of Valanis' law is made, each in closed form under one load.

use super::endochronic::{Stretch, advance, dissipation, within};
use crate::contact::gradual::Gradual;
use crate::contact::{Inputs, cut_to};

/// The law as it is integrated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Curve {
    /// Of it p = e0 − e_t (N/m), slope of the hysteretic force on initial loading.
    pub gradual: Gradual,
    /// p r/[e0 (1 − κ)] (N/m): reach δ = this × distance/limit.
    pub reach_stiffness: f64,
    /// b = κ p/[e0 (1 − κ)] of the endochronic equation (1).
    pub curvature: f64,
}

/// The motion of a step, after re-contact: from the hysteretic force and the load at its start.
pub(super) struct Start {
    /// Within the limit (N).
    pub hysteretic_force: f64,
    pub normal_load: f64,
    /// Distance moved in contact (m), signed.
    pub travel: f64,
    pub origin: f64,
    /// Present when the contact closed within the step.
    pub closing: Option<Closing>,
}

/// Derivatives of the distance moved in contact, when the contact closed within the step.
#[derive(Clone, Copy)]
pub(super) struct Closing {
    pub by_displacement: f64,
    pub by_start_load: f64,
    pub by_end_load: f64,
}

/// Where a motion under one load ends.
struct Moved {
    /// Hysteretic force (N) where it begins, after it was cut.
    start: f64,
    /// Relative to the limit: gap there, and reach.
    gap: f64,
    delta: f64,
    stretch: Stretch,
    /// Hysteretic force (N) at the end.
    end: f64,
}

/// A motion under one load.
struct Motion {
    hysteretic_force: f64,
    dissipated_energy: f64,
    by_travel: f64,
    by_start: f64,
    by_limit: f64,
    /// In a motion that a limit ahead did not cut, relative to the limit: gap at the start, reach,
    /// and the end.
    gap: f64,
    delta: f64,
    stretch: Stretch,
}

/// The hysteretic force at the end of a step, with derivatives with respect to the distance moved, the
/// hysteretic force at the start, and the limits at both ends.
pub(super) struct End {
    pub hysteretic_force: f64,
    pub dissipated_energy: f64,
    pub by_travel: f64,
    pub by_start: f64,
    pub by_start_limit: f64,
    pub by_end_limit: f64,
}

/// Radau's quadrature with two points on `[0, 1]`: the first weight and node; the last node is 1.
const FIRST_FRACTION: f64 = 0.75;
const FIRST_LOAD: f64 = 1.0 / 3.0;

/// A limit behind the motion that falls to less than a half of the force is no small change within a
/// step: it cuts the force to this many limits before the motion, which keeps the gap below 3.
pub(super) const BEHIND: f64 = 2.0;

impl Curve {
    /// Whether a step that ends under this load and limit ends apart; a limit that underflows is none.
    pub fn separated(normal_load: f64, limit: f64) -> bool {
        normal_load <= 0.0 || limit == 0.0
    }

    pub fn start(state: &[f64], inputs: Inputs) -> Start {
        let (hysteretic_force, displacement, normal_load, origin) = (state[0], state[1], state[2], state[3]);
        let travel = inputs.displacement - displacement;
        if normal_load > 0.0 {
            return Start { hysteretic_force, normal_load, travel, origin, closing: None };
        }
        let load_change = inputs.normal_load - normal_load;
        let closed = inputs.normal_load / load_change;
        Start {
            hysteretic_force: 0.0,
            normal_load: 0.0,
            travel: closed * travel,
            origin: displacement + (1.0 - closed) * travel,
            closing: Some(Closing {
                by_displacement: closed,
                by_start_load: travel * (closed / load_change),
                by_end_load: -travel * (normal_load / load_change) / load_change,
            }),
        }
    }

    /// Moves from `force` (N) over `distance` (m, not negative) in the direction `sign` under one `limit`
    /// (N), which may lie below the force: ahead it cuts, behind it is mostly left to the end of the step.
    fn moved(&self, force: f64, sign: f64, distance: f64, limit: f64) -> Moved {
        let along = sign * force;
        let behind = BEHIND * (self.gradual.side(-sign) / self.gradual.side(sign));
        let start = if along > limit {
            sign * limit
        } else if along < -behind * limit {
            -sign * behind * limit
        } else {
            force
        };
        let gap = 1.0 - sign * (start / limit);
        let delta = self.reach_stiffness * (distance / limit);
        let stretch = advance(gap, delta, self.curvature);
        let end = start + sign * limit * stretch.drop;
        // Rounding may pass the limit ahead.
        let end = if sign * end > limit { sign * limit } else { end };
        Moved { start, gap, delta, stretch, end }
    }

    /// The same with what it dissipates, and derivatives.
    fn motion(&self, force: f64, sign: f64, distance: f64, limit: f64) -> Motion {
        let Moved { start, gap, delta, stretch, end } = self.moved(force, sign, distance, limit);
        // NaN differs from itself, but was not cut.
        let cut = start != force && !force.is_nan();
        // Where the reach overflows, all of the path is macro-slip.
        let slipped = if delta.is_finite() {
            limit / self.reach_stiffness * dissipation(gap, &stretch)
        } else {
            distance + self.lost_by_cut(start, sign * limit) / limit
        };
        let by_start = stretch.ratio * (1.0 + self.curvature * gap) / (1.0 + self.curvature * stretch.gap);
        let by_limit = self.by_limit(sign, gap, stretch.gap, by_start, delta);
        Motion {
            hysteretic_force: end,
            dissipated_energy: limit * slipped + self.lost_by_cut(force, start),
            by_travel: self.reach_stiffness * self.slope(stretch.gap),
            by_start: if cut { 0.0 } else { by_start },
            by_limit: if cut { by_limit + by_start * (start / limit) } else { by_limit },
            gap,
            delta,
            stretch,
        }
    }

    /// Slope of the hysteretic force over the distance, relative to the reach stiffness.
    pub fn slope(&self, gap: f64) -> f64 {
        gap / (1.0 + self.curvature * gap)
    }

    /// Derivative of the force after a motion with respect to its limit, at a given start.
    fn by_limit(&self, sign: f64, gap: f64, end_gap: f64, by_start: f64, delta: f64) -> f64 {
        let slope = self.slope(end_gap);
        let reach_term = if slope == 0.0 { 0.0 } else { delta * slope };
        sign * ((1.0 - end_gap) - by_start * (1.0 - gap) - reach_term)
    }

    /// Energy (J) lost where the hysteretic force is cut to `cut`.
    fn lost_by_cut(&self, force: f64, cut: f64) -> f64 {
        if force == cut {
            return 0.0;
        }
        0.5 * (force.abs() - cut.abs()) * (force.abs() + cut.abs()) / self.gradual.hysteretic_stiffness
    }

    fn direction(start: &Start) -> f64 {
        if start.travel == 0.0 { -start.hysteretic_force.signum() } else { start.travel.signum() }
    }

    pub fn end(&self, start: &Start, end_load: f64, limit: f64) -> End {
        let (sign, distance) = (Self::direction(start), start.travel.abs());
        let (ahead, behind) = (self.gradual.side(sign), self.gradual.side(-sign));
        let (limit, limit_behind) = (ahead * limit, behind * limit);
        let mut end = if start.closing.is_some() {
            self.growth(sign, distance, limit)
        } else if start.normal_load == end_load {
            self.one_motion(start.hysteretic_force, sign, distance, limit)
        } else {
            let first = ahead * self.first_limit(start, end_load);
            self.two_motions(start.hysteretic_force, sign, distance, [first, limit])
        };
        let cut = Self::cut(end.hysteretic_force, sign, limit, limit_behind);
        end.by_start_limit *= ahead;
        end.by_end_limit *= ahead;
        if cut != end.hysteretic_force {
            let (first, last) = (start.hysteretic_force.abs(), cut.abs());
            let lost = (first - last) / self.gradual.hysteretic_stiffness - distance;
            // NaN stays, which `max` would not keep.
            let lost = if lost < 0.0 { 0.0 } else { lost };
            end = End {
                hysteretic_force: cut,
                dissipated_energy: 0.5 * (first + last) * lost,
                by_travel: 0.0,
                by_start: 0.0,
                by_start_limit: 0.0,
                by_end_limit: -sign * behind,
            };
        }
        end
    }

    /// The mean of both limits (N) of the first motion of a step.
    fn first_limit(&self, start: &Start, end_load: f64) -> f64 {
        self.gradual.limit(start.normal_load + FIRST_LOAD * (end_load - start.normal_load))
    }

    /// A force at the end of a step within the limits there. A limit behind the motion that falls faster than the force takes it
    /// along: the mean counts.
    fn cut(force: f64, sign: f64, limit: f64, behind: f64) -> f64 {
        if sign * force < -behind { -sign * behind } else { cut_to(force, limit.max(behind)) }
    }

    /// Hysteretic force (N) at the end of a step in contact that began in contact, without derivatives.
    pub fn end_force(&self, start: &Start, end_load: f64, limit: f64) -> f64 {
        let (sign, distance) = (Self::direction(start), start.travel.abs());
        let (ahead, behind) = (self.gradual.side(sign), self.gradual.side(-sign));
        let force = if start.normal_load == end_load {
            self.moved(start.hysteretic_force, sign, distance, ahead * limit).end
        } else {
            let first = ahead * self.first_limit(start, end_load);
            let first = self.moved(start.hysteretic_force, sign, FIRST_FRACTION * distance, first).end;
            self.moved(first, sign, (1.0 - FIRST_FRACTION) * distance, ahead * limit).end
        };
        Self::cut(force, sign, ahead * limit, behind * limit)
    }

    /// Under constant load both motions of a step are one; its derivatives still distinguish their limits.
    fn one_motion(&self, force: f64, sign: f64, distance: f64, limit: f64) -> End {
        let whole = self.motion(force, sign, distance, limit);
        let (delta, end_gap) = (whole.delta, whole.stretch.gap);
        let (gap, left) = within(whole.gap, delta, self.curvature, &whole.stretch, FIRST_FRACTION);
        let last_delta = (1.0 - FIRST_FRACTION) * delta;
        let by_start = left * (1.0 + self.curvature * gap) / (1.0 + self.curvature * end_gap);
        let last = self.by_limit(sign, gap, end_gap, by_start, last_delta);
        let first = whole.by_limit - last;
        End {
            hysteretic_force: whole.hysteretic_force,
            dissipated_energy: whole.dissipated_energy,
            by_travel: whole.by_travel,
            by_start: whole.by_start,
            by_start_limit: (1.0 - FIRST_LOAD) * first,
            by_end_limit: last + FIRST_LOAD * first,
        }
    }

    /// Motion since the contact closed. The limit grows from zero in proportion to the distance, and so
    /// does the force: their ratio `d` is the root of `d (1 + b (1 − d)) = ρ (1 − d)`.
    fn growth(&self, sign: f64, distance: f64, limit: f64) -> End {
        let (b, rho) = (self.curvature, self.reach_stiffness * (distance / limit));
        let root = (1.0 + 2.0 * (b + rho)).sqrt().hypot(b - rho);
        // Where ρ overflows the contact is saturated.
        let saturated = rho == f64::INFINITY;
        let ratio = if saturated { 1.0 } else { 2.0 * rho / (1.0 + b + rho + root) };
        let by_rho = if saturated { 0.0 } else { (1.0 - ratio) / root };
        let reach_term = if saturated { 0.0 } else { rho * by_rho };
        End {
            hysteretic_force: sign * limit * ratio,
            dissipated_energy: 0.5 * limit * ratio * distance * (ratio / (1.0 + b * (1.0 - ratio))),
            by_travel: self.reach_stiffness * by_rho,
            by_start: 0.0,
            by_start_limit: 0.0,
            by_end_limit: sign * (ratio - reach_term),
        }
    }

    fn two_motions(&self, force: f64, sign: f64, distance: f64, limits: [f64; 2]) -> End {
        let first = self.motion(force, sign, FIRST_FRACTION * distance, limits[0]);
        let last = self.motion(first.hysteretic_force, sign, (1.0 - FIRST_FRACTION) * distance, limits[1]);
        let by_first_limit = last.by_start * first.by_limit;
        End {
            hysteretic_force: last.hysteretic_force,
            dissipated_energy: first.dissipated_energy + last.dissipated_energy,
            by_travel: FIRST_FRACTION * last.by_start * first.by_travel
                + (1.0 - FIRST_FRACTION) * last.by_travel,
            by_start: last.by_start * first.by_start,
            by_start_limit: (1.0 - FIRST_LOAD) * by_first_limit,
            by_end_limit: last.by_limit + FIRST_LOAD * by_first_limit,
        }
    }

    /// Energy (J) dissipated in a step that ends apart: that of the motion up to the instant `N = 0`, the
    /// last part of which is without force, and all that is kept there.
    pub fn lift_off(&self, state: &[f64], inputs: Inputs) -> f64 {
        let [force, displacement, normal_load, origin] = [state[0], state[1], state[2], state[3]];
        let first = self.gradual.limit((1.0 - FIRST_LOAD) * normal_load);
        if first == 0.0 {
            return self.gradual.stored_energy(state);
        }
        let in_contact = normal_load / (normal_load - inputs.normal_load.min(0.0));
        let travel = in_contact * (inputs.displacement - displacement);
        let start = Start { hysteretic_force: force, normal_load, travel, origin, closing: None };
        let sign = Self::direction(&start);
        let moved = self.motion(force, sign, FIRST_FRACTION * travel.abs(), self.gradual.side(sign) * first);
        let stretch = displacement + travel - origin;
        let hysteretic = moved.hysteretic_force * moved.hysteretic_force / self.gradual.hysteretic_stiffness;
        moved.dissipated_energy + 0.5 * (hysteretic + self.gradual.residual_stiffness * stretch * stretch)
    }
}
