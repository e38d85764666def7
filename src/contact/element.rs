//! The step that Jenkins' element, its parallel arrangements and backlash share: a spring, with or without
//! play, in series with a Coulomb slider whose limit follows the normal load.

use super::{Inputs, SlipState, Tangents, cut_to};

/// `T = k d_g(u − z)` with `|T| ≤ μ N`, where `d_g` takes the play of half-width g off: zero within ±g,
/// `x − g` above and `x + g` below.
///
/// Displacement and normal load run linearly within a step. As long as the slider rests, the distance of
/// the stretch `u − z` from either end of its range `±(g + μN/k)` is linear too, so that it changes sign
/// once at most and slip, once begun, lasts: the step is exact, whatever its size.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Element {
    /// k (N/m), above zero.
    pub stiffness: f64,
    /// μ (1), above zero.
    pub friction: f64,
    /// g (m), at least zero.
    pub play: f64,
    /// μ/k (m/N): stretch of the spring at the limit, by normal load.
    stretch_per_load: f64,
}

/// What an element remembers of the end of the last step.
#[derive(Debug, Clone, Copy)]
pub(super) struct Start {
    /// Slider position z (m).
    pub slider: f64,
    /// Displacement (m).
    pub displacement: f64,
    /// Normal load (N).
    pub normal_load: f64,
}

/// One step, with all that the response and both kinds of derivative need.
pub(super) struct Step {
    pub force: f64,
    pub dissipated_energy: f64,
    branch: Branch,
}

/// Which formula gives the force at the end of the step.
enum Branch {
    /// The slider rested for the whole step; `stiffness` is k, or 0 within the play.
    Stick { stiffness: f64 },
    /// The slider rested since the contact closed within the step; `closed` is the fraction of the
    /// step in contact.
    StickSinceContact { closed: f64, load_change: f64, stiffness: f64 },
    /// At the limit, in the direction `sign`.
    Slip { sign: f64 },
    /// Apart.
    Separated,
}

/// Derivatives of the force and of the next slider position with respect to what a step starts from, and of
/// the latter with respect to the inputs.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Partials {
    pub force_by_slider: f64,
    pub force_by_start: f64,
    pub force_by_start_load: f64,
    pub slider_by_slider: f64,
    pub slider_by_start: f64,
    pub slider_by_start_load: f64,
    pub slider_by_displacement: f64,
    pub slider_by_normal_load: f64,
}

impl Element {
    /// An element of checked parameters.
    pub fn new(stiffness: f64, friction: f64, play: f64) -> Self {
        Self { stiffness, friction, play, stretch_per_load: friction / stiffness }
    }

    /// Largest force (N) under `normal_load` (N).
    pub fn limit(&self, normal_load: f64) -> f64 {
        if normal_load <= 0.0 { 0.0 } else { self.friction * normal_load }
    }

    /// Slider position (m) with which the element at rest at `displacement` (m) carries `force` (N), which
    /// is within the limit.
    pub fn slider_carrying(&self, displacement: f64, force: f64) -> f64 {
        // Without a force the play lies evenly on both sides.
        let play = if force == 0.0 { 0.0 } else { self.play.copysign(force) };
        displacement - play - force / self.stiffness
    }

    /// Energy (J) kept in the spring with the slider at `slider` (m) and the end at `displacement` (m).
    pub fn stored_energy(&self, slider: f64, displacement: f64) -> f64 {
        let (stretch, _) = self.spring(displacement - slider);
        0.5 * self.stiffness * stretch * stretch
    }

    /// The spring's part (m) of a stretch (m) of spring and play together, and the slope (N/m) there.
    #[inline(always)]
    fn spring(&self, stretch: f64) -> (f64, f64) {
        let taken_up = stretch - cut_to(stretch, self.play);
        (taken_up, if stretch.abs() < self.play { 0.0 } else { self.stiffness })
    }

    /// Largest stretch (m) of spring and play under `normal_load` (N), above zero.
    fn reach(&self, normal_load: f64) -> f64 {
        self.play + self.stretch_per_load * normal_load
    }

    /// The step from `start` to `inputs`.
    #[inline(always)]
    pub fn evaluate(&self, start: Start, inputs: Inputs) -> Step {
        if inputs.normal_load <= 0.0 || start.normal_load <= 0.0 {
            return self.open(start, inputs);
        }
        let stretch = inputs.displacement - start.slider;
        let slipped = stretch.abs() - self.reach(inputs.normal_load);
        if slipped <= 0.0 {
            let (force, stiffness) = self.stuck(stretch, inputs.normal_load);
            return Step { force, dissipated_energy: 0.0, branch: Branch::Stick { stiffness } };
        }
        let sign = stretch.signum();
        // Slip begins where the stuck force crosses the limit, a fraction `stuck` into the step, and
        // lasts; the slider's speed is constant and the limit linear, so their mean values multiply.
        let margin = self.margin(sign, start);
        let stuck = margin / (margin + slipped);
        let mean_load = inputs.normal_load + 0.5 * (1.0 - stuck) * (start.normal_load - inputs.normal_load);
        Step {
            force: sign * (self.friction * inputs.normal_load),
            dissipated_energy: self.friction * mean_load * slipped,
            branch: Branch::Slip { sign },
        }
    }

    /// A step at the end or the beginning of which the contact is open.
    #[cold]
    fn open(&self, start: Start, inputs: Inputs) -> Step {
        if inputs.normal_load > 0.0 {
            return self.re_contact(start, inputs);
        }
        let dissipated_energy = if start.normal_load > 0.0 { self.lift_off(start, inputs) } else { 0.0 };
        Step { force: 0.0, dissipated_energy, branch: Branch::Separated }
    }

    /// Force (N), not above the limit, and slope (N/m) with the slider at rest.
    #[inline(always)]
    fn stuck(&self, stretch: f64, normal_load: f64) -> (f64, f64) {
        let (stretch, slope) = self.spring(stretch);
        (cut_to(self.stiffness * stretch, self.friction * normal_load), slope)
    }

    /// A step in which the contact closes. The slider starts from the displacement at that instant;
    /// from there travel and reach grow linearly, the travel from zero and the reach from the play.
    fn re_contact(&self, start: Start, inputs: Inputs) -> Step {
        let load_change = inputs.normal_load - start.normal_load;
        let closed = inputs.normal_load / load_change;
        let travel = closed * (inputs.displacement - start.displacement);
        let slipped = travel.abs() - self.reach(inputs.normal_load);
        if slipped <= 0.0 {
            let (force, stiffness) = self.stuck(travel, inputs.normal_load);
            let branch = Branch::StickSinceContact { closed, load_change, stiffness };
            return Step { force, dissipated_energy: 0.0, branch };
        }
        let sign = travel.signum();
        let limit = self.friction * inputs.normal_load;
        // The limit when slip begins: none without play.
        let stuck = self.play / (self.play + slipped);
        let dissipated_energy = 0.5 * (1.0 + stuck) * limit * slipped;
        Step { force: sign * limit, dissipated_energy, branch: Branch::Slip { sign } }
    }

    /// How far (m) the stretch at the start of the step could still grow in the direction `sign`.
    /// Round-off may put a slipping state slightly beyond its limit, hence the cut at zero.
    fn margin(&self, sign: f64, start: Start) -> f64 {
        (self.reach(start.normal_load) - sign * (start.displacement - start.slider)).max(0.0)
    }

    /// Energy (J) dissipated on the way to the instant `N = 0` within the step: as the limit falls to
    /// zero the slider must give up all of the spring's stretch.
    fn lift_off(&self, start: Start, inputs: Inputs) -> f64 {
        let fraction = start.normal_load / (start.normal_load - inputs.normal_load);
        let travel = fraction * (inputs.displacement - start.displacement);
        let stretch = start.displacement + travel - start.slider;
        let slipped = stretch.abs() - self.play;
        if slipped <= 0.0 {
            return 0.0;
        }
        let margin = self.margin(stretch.signum(), start);
        let load_at_slip = start.normal_load * (slipped / (margin + slipped));
        0.5 * self.friction * load_at_slip * slipped
    }

    /// Slider position (m) after `step`. In stick it is kept to the last bit rather than recomputed from
    /// the force.
    #[inline]
    pub fn slider(&self, step: &Step, start: Start, inputs: Inputs) -> f64 {
        match step.branch {
            Branch::Stick { .. } => start.slider,
            Branch::Separated => inputs.displacement,
            Branch::Slip { sign } => inputs.displacement - sign * self.reach(inputs.normal_load),
            Branch::StickSinceContact { closed, .. } => {
                start.displacement + (1.0 - closed) * (inputs.displacement - start.displacement)
            }
        }
    }

    /// Derivatives of the force after `step` with respect to the inputs, and what the contact does.
    #[inline]
    pub fn tangents(&self, step: &Step, start: Start, inputs: Inputs) -> (Tangents, SlipState) {
        let (displacement, normal_load, slip_state) = match step.branch {
            Branch::Stick { stiffness } => (stiffness, 0.0, SlipState::Stick),
            Branch::StickSinceContact { closed, load_change, stiffness } => {
                let travel = inputs.displacement - start.displacement;
                let by_load = -stiffness * travel * (start.normal_load / load_change) / load_change;
                (stiffness * closed, by_load, SlipState::Stick)
            }
            Branch::Slip { sign } => (0.0, sign * self.friction, SlipState::Slip),
            Branch::Separated => (0.0, 0.0, SlipState::Separated),
        };
        (Tangents { displacement, velocity: 0.0, normal_load }, slip_state)
    }

    /// The other derivatives of the step from `start` to `inputs`.
    pub fn partials(&self, start: Start, inputs: Inputs) -> Partials {
        match self.evaluate(start, inputs).branch {
            Branch::Stick { stiffness } => {
                Partials { force_by_slider: -stiffness, slider_by_slider: 1.0, ..Partials::default() }
            }
            Branch::StickSinceContact { closed, load_change, stiffness } => {
                let travel = inputs.displacement - start.displacement;
                let slider_by_start_load = -travel * (closed / load_change);
                Partials {
                    force_by_start: -stiffness * closed,
                    force_by_start_load: -stiffness * slider_by_start_load,
                    slider_by_start: closed,
                    slider_by_start_load,
                    slider_by_displacement: 1.0 - closed,
                    slider_by_normal_load: travel * (start.normal_load / load_change) / load_change,
                    ..Partials::default()
                }
            }
            Branch::Slip { sign } => Partials {
                slider_by_displacement: 1.0,
                slider_by_normal_load: -sign * self.stretch_per_load,
                ..Partials::default()
            },
            Branch::Separated => Partials { slider_by_displacement: 1.0, ..Partials::default() },
        }
    }

    /// [`super::ContactLaw::step`] of a law that is one element with the state `[z, u, N]`.
    #[inline(always)]
    pub fn step(&self, state: &[f64], inputs: Inputs, next: &mut [f64]) -> super::Response {
        match self.step_closed(state, inputs, next) {
            Some(response) => response,
            None => self.step_open(state, inputs, next),
        }
    }

    /// [`Element::step`] of a contact that is closed from beginning to end; `None` of another.
    #[inline(always)]
    pub fn step_closed(&self, state: &[f64], inputs: Inputs, next: &mut [f64]) -> Option<super::Response> {
        let open = inputs.normal_load <= 0.0 || state[2] <= 0.0;
        if open { None } else { Some(self.step_any(state, inputs, next)) }
    }

    /// Out of the way of the closed contact, which then needs no copy of what it starts from.
    #[cold]
    fn step_open(&self, state: &[f64], inputs: Inputs, next: &mut [f64]) -> super::Response {
        self.step_any(state, inputs, next)
    }

    #[inline(always)]
    fn step_any(&self, state: &[f64], inputs: Inputs, next: &mut [f64]) -> super::Response {
        let start = Start { slider: state[0], displacement: state[1], normal_load: state[2] };
        let step = self.evaluate(start, inputs);
        next[0] = self.slider(&step, start, inputs);
        next[1] = inputs.displacement;
        next[2] = inputs.normal_load;
        let (tangents, slip_state) = self.tangents(&step, start, inputs);
        let Step { force, dissipated_energy, .. } = step;
        super::Response { force, tangents, dissipated_energy, slip_state }
    }

    /// [`super::ContactLaw::advance`] of such a law.
    pub fn advance(&self, state: &mut [f64], inputs: Inputs) -> f64 {
        let start = Start { slider: state[0], displacement: state[1], normal_load: state[2] };
        let step = self.evaluate(start, inputs);
        state[0] = self.slider(&step, start, inputs);
        state[1] = inputs.displacement;
        state[2] = inputs.normal_load;
        step.force
    }

    /// [`super::ContactLaw::set_state`] of such a law.
    pub fn set_state(&self, displacement: f64, normal_load: f64, force: f64, state: &mut [f64]) {
        state[0] = self.slider_carrying(displacement, cut_to(force, self.limit(normal_load)));
        state[1] = displacement;
        state[2] = normal_load;
    }

    /// [`super::ContactLaw::state_tangents`] of such a law.
    pub fn state_tangents(&self, state: &[f64], inputs: Inputs, out: &mut super::StateTangents) {
        out.reset(3);
        let start = Start { slider: state[0], displacement: state[1], normal_load: state[2] };
        let partials = self.partials(start, inputs);
        out.force_by_state[0] = partials.force_by_slider;
        out.force_by_state[1] = partials.force_by_start;
        out.force_by_state[2] = partials.force_by_start_load;
        out.next_by_state[0] = partials.slider_by_slider;
        out.next_by_state[1] = partials.slider_by_start;
        out.next_by_state[2] = partials.slider_by_start_load;
        out.next_by_displacement[0] = partials.slider_by_displacement;
        out.next_by_displacement[1] = 1.0;
        out.next_by_normal_load[0] = partials.slider_by_normal_load;
        out.next_by_normal_load[2] = 1.0;
    }
}
