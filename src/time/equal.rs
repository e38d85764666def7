//! Equal steps without control of their error, for records that are sampled finely and for slaves whose derivatives are
//! those of the very steps.
//!
//! The laws are asked at the ends of a step alone. Between them their forces are the parabolas that the forces and their
//! rates at both ends make: the error is of order four in the step while forces are smooth, and of order two over stick
//! and slip, where a corner falls somewhere into a step. The bow of those parabolas is added once the forces at the end are
//! found with straight lines, so that the end of a step is as smooth in its beginning as the laws are.

use super::integrator::Integrator;
use super::node::{PRECISION, SWEEPS, bow};
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
        }
        for (e, contact) in self.plant.contacts.iter().enumerate() {
            let [middle, end] = match contact.law {
                Some(_) => {
                    let (force, rise) = (self.nodes[e][0].force, span.step * self.force_rate(0, e, span));
                    [force + 0.5 * rise, force + rise]
                }
                None => [0.5, 1.0].map(|node| self.ramps[contact.input].at(span.fraction(node))),
            };
            self.nodes[e][END] = self.nodes[e][0];
            (self.nodes[e][MIDDLE].force, self.nodes[e][END].force) = (middle, end);
        }
        self.force_ends(span);
        self.place_end();
        if !self.balance(span) {
            return false;
        }
        for e in 0..self.plant.contacts.len() {
            if self.plant.contacts[e].law.is_some() {
                let (before, after) = (self.force_rate(0, e, span), self.force_rate(END, e, span));
                self.shift(e, [bow(span.step * (before - after)), 0.0]);
            }
        }
        true
    }

    /// Modal state and forcing at the end.
    fn place_end(&mut self) {
        let ([q0, .., q4], [v0, .., v4]) = (&mut self.q, &mut self.v);
        let [p0, _, p2, _, p4] = &mut self.forcing;
        let rows = self.propagators[self.current].node(END);
        self.equal.end(rows, [q0, v0, p0, p2, p4], [q4, v4, &mut self.pushed]);
        std::mem::swap(p4, &mut self.pushed);
    }

    /// Forcing at the middle and at the end of a step: forces that are known there, and those that follow the motion by
    /// what it is under them.
    fn force_ends(&mut self, span: &Span) {
        if self.plant.follows_displacement() {
            for node in [MIDDLE, END, MIDDLE, END] {
                self.place(node);
                self.geometry(node);
                self.force_modes(node, span.fraction(NODES[node]));
            }
            return;
        }
        let [.., at_middle, _, at_end] = &mut self.forcing;
        at_middle.fill(0.0);
        at_end.fill(0.0);
        let mut push = |port: usize, middle: f64, end: f64| {
            let at = at_middle.iter_mut().zip(at_end.iter_mut());
            for ((at_middle, at_end), b) in at.zip(&self.plant.ports[port].row) {
                *at_middle += middle * b;
                *at_end += end * b;
            }
        };
        let middle = span.fraction(NODES[MIDDLE]);
        for (port, ramp) in self.plant.driven.iter().zip(&self.ramps) {
            push(*port, ramp.at(middle), ramp.at(span.to));
        }
        for (e, contact) in self.plant.contacts.iter().enumerate() {
            push(contact.port, -self.nodes[e][MIDDLE].force, -self.nodes[e][END].force);
        }
    }

    /// Forces at the placed end of the step, on straight lines from its start. False if a law fails.
    fn balance(&mut self, span: &Span) -> bool {
        for _ in 0..SWEEPS {
            self.geometry(END);
            let (mut moved, mut size) = (0.0_f64, 0.0_f64);
            for e in 0..self.plant.contacts.len() {
                let guess = self.nodes[e][END].force;
                if self.ask(e, END, span.to, self.equal.answers[e]).is_none() {
                    return false;
                }
                let force = self.nodes[e][END].force;
                self.shift(e, [0.5 * (force - guess), force - guess]);
                (moved, size) = (moved.max((force - guess).abs()), size.max(force.abs()));
            }
            if !self.plant.interacts() || moved <= PRECISION * size {
                break;
            }
        }
        true
    }

    /// Moves the end of the step as a force at a port does that is larger by so much (N) at the middle and at the end.
    fn shift(&mut self, e: usize, [middle, end]: [f64; 2]) {
        let state = self.q[END].iter_mut().zip(&mut self.v[END]).zip(&mut self.forcing[END]);
        for (((q, v), p), [by_q, by_v, by_p]) in state.zip(&self.equal.pushed[e]) {
            *q -= by_q[0] * middle + by_q[1] * end;
            *v -= by_v[0] * middle + by_v[1] * end;
            *p -= by_p[0] * middle + by_p[1] * end;
        }
    }

    /// Rate of a law's force at a node (N/s), what the velocity itself changes left out.
    fn force_rate(&self, node: usize, e: usize, span: &Span) -> f64 {
        let (contact, at) = (&self.plant.contacts[e], &self.nodes[e][node]);
        let load_rate = span.rate_at(self.ramps[contact.input], NODES[node]);
        at.tangent * at.velocity(self.plant.ports[contact.port].flexibility, load_rate)
            + at.load_tangent * load_rate
    }

    /// Takes over the step tried last. False, with the state no longer usable, if the state is not finite.
    fn take_equal(&mut self, span: &Span) -> bool {
        self.q.swap(0, END);
        self.v.swap(0, END);
        self.forcing.swap(0, END);
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
