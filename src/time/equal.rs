//! Equal steps without control of their error, for records that are sampled finely and for slaves whose derivatives are
//! those of the very steps.
//!
//! The laws are asked at the ends of a step alone. Between them their forces are the parabolas that the forces and their
//! rates at both ends make: the error is of order four in the step while forces are smooth, and of order two over stick
//! and slip, where a corner falls somewhere into a step. The bow of those parabolas is added once the forces at the end are
//! found with straight lines, so that the end of a step is as smooth in its beginning as the laws are.

use super::coefficients::{PRECISION, SWEEPS, bow};
use super::integrator::Integrator;
use super::node::Answer;
use super::propagator::{END, MIDDLE, NODES};
use super::step::{Span, StepSolver};
use super::{IntegrationError, Motion, Ramp, Settings};

/// Radians of the fastest motion that counts, laws in stick, that a step may last.
const ANGLE: f64 = 0.2;
impl Integrator {
    /// The longest of equal steps (s) that resolves the motion with springs of `stiffness` (N/m) in place of laws and
    /// outside forces, in stick as a rule. With a corner in a force at every reversal, the error is then some 1e-4 of the
    /// motion.
    ///
    /// Nothing moves by itself or is driven above `fastest` (rad/s), infinite if anything may: what corners move of a mode there
    /// falls with the square of its frequency, and it counts as one as far below.
    pub fn longest_step(&self, stiffness: &[f64], fastest: f64) -> f64 {
        let plant = &self.solver.plant;
        let mobility = |e: usize| self.solver.row_norm[e] * self.solver.row_norm[e];
        let attached: f64 = stiffness.iter().enumerate().map(|(e, k)| k.abs() * mobility(e)).sum();
        let counted = |omega: f64| if omega <= fastest { omega } else { fastest * fastest / omega };
        let highest = plant.angular_frequency.iter().map(|omega| counted(*omega)).fold(0.0, f64::max);
        let lost = |i: usize| {
            let beside = plant.damping.chunks_exact(plant.size()).nth(i).unwrap_or(&[]);
            let own = 2.0 * plant.damping_ratio[i] * counted(plant.angular_frequency[i]);
            own + beside.iter().map(|d| d.abs()).sum::<f64>()
        };
        let damping = (0..plant.size()).map(lost).fold(0.0, f64::max);
        ANGLE / ((highest * highest + attached).sqrt() + damping)
    }

    /// Advances `motion` by `duration` (s) under `inputs` in so many equal steps, without events or control of the
    /// error.
    ///
    /// # Errors
    /// [`IntegrationError`]; `motion` is then unchanged.
    pub fn march(
        &mut self,
        motion: &mut Motion,
        duration: f64,
        inputs: &[Ramp],
        steps: usize,
    ) -> Result<(), IntegrationError> {
        self.check_duration(duration)?;
        self.take_up(motion, inputs)?;
        self.stride(duration, steps, |_, _| ())?;
        self.solver.unload(motion);
        Ok(())
    }

    /// Takes `motion` over, to be marched on from instant to instant without handing it back in between.
    pub(crate) fn take_up(&mut self, motion: &Motion, inputs: &[Ramp]) -> Result<(), IntegrationError> {
        self.begin(motion, 1.0, inputs, &Settings::default())?;
        if !self.solver.prepare(&Span::START) {
            return Err(IntegrationError::StepTooSmall { time: 0.0, step: 0.0 });
        }
        Ok(())
    }

    /// Hands back the motion that was taken up.
    #[cfg(feature = "analysis")]
    pub(crate) fn put_down(&self, motion: &mut Motion) {
        self.solver.unload(motion);
    }

    /// The inputs, to go on from where they ended.
    #[cfg(feature = "analysis")]
    pub(crate) fn inputs_mut(&mut self) -> &mut [Ramp] {
        &mut self.solver.ramps
    }

    /// Brings the forcing to where a stride ended, which reads sensors of accelerations; a linear plant goes on without it.
    #[cfg(feature = "analysis")]
    pub(crate) fn force_end(&mut self) {
        self.solver.force_modes(0, 1.0);
    }

    /// Marches on under the inputs there are; `tried` sees each step before it is taken.
    pub(crate) fn stride(
        &mut self,
        duration: f64,
        steps: usize,
        mut tried: impl FnMut(&StepSolver, &Span),
    ) -> Result<(), IntegrationError> {
        let step = rounded(duration / steps as f64);
        let mut span = Span { step, from: 0.0, to: 0.0, duration };
        self.solver.prepare_equal_steps(step);
        for k in 1..=steps {
            span.to = k as f64 / steps as f64;
            let went = self.solver.try_equal(&span) && {
                tried(&self.solver, &span);
                self.solver.take_equal(&span)
            };
            if !went {
                return Err(IntegrationError::Unbounded { time: span.from * duration });
            }
            span.from = span.to;
        }
        Ok(())
    }
}

/// Without the last digits, in which the lengths of equal communication steps differ from each other: the coefficients
/// of a step need not be computed again for those.
fn rounded(step: f64) -> f64 {
    const DIGITS: u64 = 0xfff;
    f64::from_bits((step.to_bits() + DIGITS / 2) & !DIGITS)
}

impl StepSolver {
    /// The coefficients of steps of `step` (s).
    fn prepare_equal_steps(&mut self, step: f64) {
        self.select_propagator(step);
        let (propagator, equal) = (&self.propagators[self.current], &mut self.equal);
        if equal.step == step {
            return;
        }
        equal.step = step;
        equal.fill(&self.plant, propagator);
    }

    /// Tries a step. False if a law fails.
    fn try_equal(&mut self, span: &Span) -> bool {
        if self.plant.follows_displacement() {
            self.begin(&[MIDDLE, END]);
            self.go_on(span);
            self.follow(span);
        } else {
            self.drive(span);
            self.go_on(span);
            let ([q0, .., q4], [v0, .., v4]) = (&mut self.q, &mut self.v);
            self.equal.end([q0, v0], [q4, v4]);
        }
        self.geometry(END);
        if !self.balance(span) {
            return false;
        }
        for e in 0..self.plant.contacts.len() {
            if self.plant.contacts[e].law.is_some() {
                let less = self.equal.rises[e] - span.step * self.force_rate(END, e, span);
                self.equal.bend(e, bow(less), [&mut self.q[END], &mut self.v[END]]);
            }
        }
        true
    }

    /// Forces on driven ports.
    fn drive(&mut self, span: &Span) {
        for (forces, input) in self.equal.forces.iter_mut().zip(&self.ramps[..self.plant.driven.len()]) {
            *forces = span.values(input);
        }
    }

    /// Forces from outside, and those of laws where they go on as they begin.
    fn go_on(&mut self, span: &Span) {
        for e in 0..self.plant.contacts.len() {
            let input = self.plant.contacts[e].input;
            let forces = if self.plant.contacts[e].law.is_some() {
                let (force, rise) = (self.nodes[e][0].force, span.step * self.force_rate(0, e, span));
                self.equal.rises[e] = rise;
                [force, force + 0.5 * rise, force + rise]
            } else {
                span.values(&self.ramps[input])
            };
            self.equal.forces[input] = forces;
            let [start, _, middle, _, end] = &mut self.nodes[e];
            start.begin();
            end.began = start.began;
            [_, middle.force, end.force] = forces;
            end.tangent = start.tangent;
        }
    }

    /// The end where forces follow displacements, by what the motion is under them.
    fn follow(&mut self, span: &Span) {
        for node in [MIDDLE, END, MIDDLE, END] {
            self.place(node);
            self.geometry(node);
            self.force_modes(node, span.fraction(NODES[node]));
        }
        self.place(END);
    }

    /// Forces at the placed end of the step, on straight lines from its start. False if a law fails.
    fn balance(&mut self, span: &Span) -> bool {
        for sweep in 0..SWEEPS {
            if sweep > 0 && self.plant.follows_displacement() {
                self.geometry(END);
            }
            let (mut moved, mut size) = (0.0_f64, 0.0_f64);
            for e in 0..self.plant.contacts.len() {
                if self.plant.contacts[e].law.is_none() {
                    continue;
                }
                let guess = self.nodes[e][END].force;
                let from = Some(if sweep == 0 { 0 } else { END });
                let answer = Answer { from, ..self.equal.answers[e] };
                if self.ask(e, END, span.to, answer).is_none() {
                    return false;
                }
                let force = self.nodes[e][END].force;
                self.shift(e, force - guess);
                (moved, size) = (moved.max((force - guess).abs()), size.max(force.abs()));
            }
            if !self.plant.interacts || moved <= PRECISION * size {
                break;
            }
        }
        true
    }

    /// Moves the end of the step as a law's force does that grows to be larger by so much (N).
    fn shift(&mut self, e: usize, by: f64) {
        self.equal.shift(e, by, [&mut self.q[END], &mut self.v[END]]);
        for (nodes, [by_u, by_v]) in self.nodes.iter_mut().zip(self.equal.shift_of_ports(e)) {
            nodes[END].geometric_displacement += by_u * by;
            nodes[END].geometric_velocity += by_v * by;
        }
    }

    /// Rate of a law's force at a node (N/s), what the velocity itself changes left out.
    fn force_rate(&self, node: usize, e: usize, span: &Span) -> f64 {
        let (contact, at) = (&self.plant.contacts[e], &self.nodes[e][node]);
        let load_rate = span.rate_at(self.ramps[contact.input], NODES[node]);
        at.tangent * at.own_velocity(self.plant.ports[contact.port].flexibility, load_rate)
            + at.load_tangent * load_rate
    }

    /// Takes over the step tried last. False, with the state no longer usable, if the state is not finite.
    fn take_equal(&mut self, span: &Span) -> bool {
        self.q.swap(0, END);
        self.v.swap(0, END);
        std::mem::swap(&mut self.memory, &mut self.memory_next);
        if !self.drop_negligible() {
            return false;
        }
        for (energy, at) in self.dissipated_energy.iter_mut().zip(&mut self.nodes) {
            at[0] = at[END];
            *energy += at[0].energy;
        }
        self.geometry(0);
        if self.plant.follows_displacement() {
            self.force_modes(0, span.to);
        }
        true
    }
}
