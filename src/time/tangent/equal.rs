//! An equal step, linear in a change: sweep by sweep what the step itself does.

use super::super::Ramp;
use super::super::coefficients::{SWEEPS, bow};
use super::super::node::Answer;
use super::super::propagator::{END, MIDDLE, NODES};
use super::super::step::{Span, StepSolver};
use super::{PAIR, Tangent, inputs};
use crate::contact::Inputs;

/// A step, and the change of the inputs over the communication step.
struct PerturbedStep<'a> {
    span: &'a Span,
    by: &'a [Ramp],
}

impl Tangent {
    /// Goes through the step that `solver` has tried with success and not yet taken over.
    pub fn through_equal(&mut self, solver: &StepSolver, span: &Span, by: &[Ramp]) {
        let (plant, perturbed) = (&solver.plant, &PerturbedStep { span, by });
        for node in PAIR {
            plant.shorten(&solver.q[node], &mut self.pull[node]);
            plant.shorten(&solver.v[node], &mut self.turning[node]);
        }
        self.now(solver, span.from, by);
        self.start(solver);
        for (e, contact) in plant.contacts.iter().enumerate() {
            let node = &solver.nodes[e][END];
            let inputs = inputs(node, contact.series, node.normal_load);
            self.linearise_at(solver, (e, END), inputs, by[contact.input].at(span.to));
            if contact.law.is_some() {
                let change = (self.geometric(solver, e, 0).1, self.contacts[e].tangent);
                self.rates[e] = [rate(solver, (e, 0), change, perturbed); 2];
                self.nodes[END][e].force = self.contacts[e].force + span.step * self.rates[e][0];
            }
        }
        self.straighten();
        for _ in 0..if plant.follows_motion() { 2 } else { 1 } {
            PAIR.into_iter().for_each(|node| self.push(solver, node, perturbed));
        }
        for _ in 0..if plant.interacts { SWEEPS } else { 1 } {
            self.place(solver, END, |change| &change.p);
            (0..plant.contacts.len()).for_each(|e| self.answer_at_end(solver, e));
            self.straighten();
            PAIR.into_iter().for_each(|node| self.push(solver, node, perturbed));
        }
        for e in 0..plant.contacts.len() {
            self.rate_at_end(solver, e, perturbed);
            let [before, after] = self.rates[e];
            self.nodes[MIDDLE][e].force += bow(span.step * (before - after));
        }
        self.push(solver, MIDDLE, perturbed);
        for e in 0..plant.contacts.len() {
            let [displacement, velocity] = self.seen[e];
            let (load, change) = (solver.nodes[e][END].normal_load, self.nodes[END][e].load);
            self.contact_step(solver, e, END, load, (displacement, velocity, change));
        }
        self.place(solver, END, |change| &change.p);
        self.q.swap(0, END);
        self.v.swap(0, END);
    }

    /// The forcing at the present, which `solver` has reached, at `fraction` of the communication step.
    pub fn now(&mut self, solver: &StepSolver, fraction: f64, by: &[Ramp]) {
        solver.plant.shorten(&solver.q[0], &mut self.pull[0]);
        solver.plant.shorten(&solver.v[0], &mut self.turning[0]);
        for (e, contact) in solver.plant.contacts.iter().enumerate() {
            if contact.law.is_none() {
                self.contacts[e].force = by[contact.input].at(fraction);
            }
            self.nodes[0][e].force = self.contacts[e].force;
        }
        self.force_without_laws(solver, 0, by, fraction);
        self.add_laws(solver, 0);
    }

    /// Change of a law's force at the end, which is placed by the guess of the force.
    fn answer_at_end(&mut self, solver: &StepSolver, e: usize) {
        let contact = &solver.plant.contacts[e];
        if contact.law.is_none() {
            return;
        }
        let (Answer { yielding, slowing, .. }, at) = (solver.equal.answers[e], self.nodes[END][e]);
        let flexibility = solver.plant.ports[contact.port].flexibility;
        let (displacement, velocity) = self.geometric(solver, e, END);
        let (stiff, damped) = (at.tangents.displacement, at.tangents.velocity);
        let own = self.own_force(solver, e, END) + (stiff * yielding + damped * slowing) * at.force;
        let force = own / (1.0 + stiff * (flexibility + yielding) + damped * slowing);
        self.seen[e] =
            [displacement - yielding * (force - at.force), velocity - slowing * (force - at.force)];
        self.nodes[END][e].force = force;
    }

    /// Change of the rate of a law's force at the end.
    fn rate_at_end(&mut self, solver: &StepSolver, e: usize, perturbed: &PerturbedStep) {
        let contact = &solver.plant.contacts[e];
        let Some(law) = contact.law.as_deref() else { return };
        let flexibility = solver.plant.ports[contact.port].flexibility;
        let ([displacement, velocity], at) = (self.seen[e], self.nodes[END][e]);
        let by =
            Inputs { displacement: displacement - flexibility * at.force, velocity, normal_load: at.load };
        let node = &solver.nodes[e][END];
        let tangent =
            self.sensitivity[e].look(law, inputs(node, contact.series, node.normal_load), by).tangent;
        self.rates[e][1] = rate(solver, (e, END), (velocity, tangent), perturbed);
    }

    /// Forces at the middle of the step on straight lines between its ends.
    fn straighten(&mut self) {
        for e in 0..self.contacts.len() {
            self.nodes[MIDDLE][e].force = 0.5 * (self.nodes[0][e].force + self.nodes[END][e].force);
        }
    }

    /// Forcing at a node from forces that are known there.
    fn push(&mut self, solver: &StepSolver, node: usize, perturbed: &PerturbedStep) {
        if solver.plant.follows_motion() {
            self.place(solver, node, |change| &change.p);
        }
        self.force_without_laws(solver, node, perturbed.by, perturbed.span.fraction(NODES[node]));
        self.add_laws(solver, node);
    }
}

/// Change of the rate of a law's force at a node (N/s), where its port's velocity and its tangent change so.
fn rate(
    solver: &StepSolver,
    (e, node): (usize, usize),
    (velocity, tangent): (f64, f64),
    perturbed: &PerturbedStep,
) -> f64 {
    let (contact, at) = (&solver.plant.contacts[e], &solver.nodes[e][node]);
    let flexibility = solver.plant.ports[contact.port].flexibility;
    tangent * at.own_velocity(flexibility, perturbed.span.rate(solver.ramps[contact.input]))
        + at.tangent * velocity / (1.0 + flexibility * at.tangent)
        + at.load_tangent * perturbed.span.rate(perturbed.by[contact.input])
}
