//! A step under control of its error, whose collocation equations are linear in a change.

use super::super::Ramp;
use super::super::propagator::{END, MIDDLE, NODES, weighed};
use super::super::solve::solve;
use super::super::step::{Span, StepSolver};
use super::{PAIR, Tangent, inputs};
use crate::contact::Inputs;

/// Sweeps over the weak terms of the linear collocation equations; each gains several digits.
const SWEEPS: usize = 30;
/// Change of the forcing, relative, at which the sweeps end.
const SETTLED: f64 = 1e-13;
/// How far inside a step, as part of a quarter of it, lies what the step is like up to a corner at one of its ends.
const INSIDE: f64 = 1e-4;

impl Tangent {
    /// Goes through the step that `solver` has tried with success and not yet committed.
    pub fn through(&mut self, solver: &StepSolver, span: &Span, by: &[Ramp]) {
        let plant = &solver.plant;
        for node in 0..=END {
            plant.shorten(&solver.q[node], &mut self.pull[node]);
            plant.shorten(&solver.v[node], &mut self.turning[node]);
        }
        for (node, at) in NODES.into_iter().enumerate() {
            self.linearise(solver, node, span.fraction(at), by);
        }
        self.force_without_laws(solver, 0, by, span.from);
        for e in 0..plant.contacts.len() {
            // A corner that ended the step before lies here, and the forces of this step begin behind it.
            let corner = solver.nodes[e][0].slip_state != solver.nodes[e][1].slip_state;
            self.nodes[0][e].force = if corner { self.answer(solver, e, 0) } else { self.contacts[e].force };
        }
        self.add_laws(solver, 0);
        self.start(solver);
        self.collocate(solver, span, by);
        for node in [1, 3] {
            self.place(solver, node, |change| &change.p);
            for e in 0..plant.contacts.len() {
                self.nodes[node][e].force = self.answer(solver, e, node);
            }
            self.force_without_laws(solver, node, by, span.fraction(NODES[node]));
            self.add_laws(solver, node);
        }
        self.take_over(solver);
    }

    /// The laws at a node, at `fraction` of the communication step; where a corner ended the step before, or ends this one,
    /// on the side of this step.
    fn linearise(&mut self, solver: &StepSolver, node: usize, fraction: f64, by: &[Ramp]) {
        for (e, contact) in solver.plant.contacts.iter().enumerate() {
            let here = &solver.nodes[e][node];
            let mut inputs = inputs(here, contact.series, here.normal_load);
            let beside = &solver.nodes[e][if node == 0 { 1 } else { node - 1 }];
            if [0, END].contains(&node) && beside.slip_state != here.slip_state {
                inputs.displacement += INSIDE * (beside.displacement - inputs.displacement);
                inputs.normal_load += INSIDE * (beside.normal_load - inputs.normal_load);
            }
            self.linearise_at(solver, (e, node), inputs, by[contact.input].at(fraction));
        }
    }

    /// Middle and end of the step: the forces of laws solved for, the weak terms by sweeps.
    fn collocate(&mut self, solver: &StepSolver, span: &Span, by: &[Ramp]) {
        for _ in 0..SWEEPS {
            for node in PAIR {
                self.force_without_laws(solver, node, by, span.fraction(NODES[node]));
            }
            for node in PAIR {
                self.place(solver, node, |change| &change.rest);
            }
            self.solve_laws(solver);
            let (mut moved, mut size) = (0.0_f64, 0.0_f64);
            for node in PAIR {
                self.product.copy_from_slice(&self.p[node]);
                self.add_laws(solver, node);
                for (p, before) in self.p[node].iter().zip(&self.product) {
                    moved = moved.max((p - before).abs());
                    size = size.max(p.abs());
                }
            }
            for node in PAIR {
                self.place(solver, node, |change| &change.p);
            }
            if moved <= SETTLED * size {
                return;
            }
        }
    }

    /// The changes of force of all laws at both nodes, which move all ports at both.
    fn solve_laws(&mut self, solver: &StepSolver) {
        let plant = &solver.plant;
        let laws = || plant.contacts.iter().enumerate().filter(|(_, contact)| contact.law.is_some());
        let count = 2 * laws().count();
        self.matrix.clear();
        self.right.clear();
        for (half, node) in PAIR.into_iter().enumerate() {
            let rows = solver.propagators[solver.current].node(node);
            for (e, contact) in laws() {
                let t = self.nodes[node][e].tangents;
                let (port, own) = (&plant.ports[contact.port], self.own_force(solver, e, node));
                self.right.push(own);
                for (other_half, other_node) in PAIR.into_iter().enumerate() {
                    for (other, pusher) in laws() {
                        let pusher = &plant.ports[pusher.port];
                        let (mut moved, mut sped) = (0.0, 0.0);
                        for (i, row) in rows.iter().enumerate() {
                            let seen = port.row[i] - port.shortening * self.pull[node][i];
                            let pushed = pusher.row[i] - pusher.shortening * self.pull[other_node][i];
                            let [by_q, by_v] = row[3 + other_half];
                            moved += seen * pushed * by_q;
                            sped += seen * pushed * by_v;
                        }
                        let itself = half == other_half && e == other;
                        let one = if itself { 1.0 + port.flexibility * t.displacement } else { 0.0 };
                        self.matrix.push(one + t.displacement * moved + t.velocity * sped);
                    }
                }
            }
        }
        // Forces that are not to be found stay as they were, and the sweeps go on.
        if count > 0 && solve(&mut self.matrix, &mut self.right) {
            for (half, node) in PAIR.into_iter().enumerate() {
                for (k, (e, _)) in laws().enumerate() {
                    self.nodes[node][e].force = self.right[half * (count / 2) + k];
                }
            }
        }
    }

    /// The end of the step from the quartic, and the middle of a step under loads that run.
    fn take_over(&mut self, solver: &StepSolver) {
        for (e, contact) in solver.plant.contacts.iter().enumerate().filter(|(_, contact)| contact.remembers)
        {
            let ramp = solver.ramps[contact.input];
            if !ramp.is_held() {
                let straight = self.energy_straight(solver, e);
                self.contacts[e].bent = Some([self.contacts[e].dissipated_energy, straight]);
                let (displacement, velocity) = self.geometric(solver, e, MIDDLE);
                let (load, change) = (solver.nodes[e][MIDDLE].normal_load, self.nodes[MIDDLE][e].load);
                self.contact_step(solver, e, MIDDLE, load, (displacement, velocity, change));
            }
        }
        let propagator = &solver.propagators[solver.current];
        for (i, (start, quartic)) in propagator.node(END).iter().zip(&propagator.quartic).enumerate() {
            let due = weighed(&start[..2], &[self.q[0][i], self.v[0][i]]);
            let forced = weighed(quartic, &self.p.each_ref().map(|p| p[i]));
            (self.q[0][i], self.v[0][i]) = (due[0] + forced[0], due[1] + forced[1]);
        }
    }

    /// Change of the energy (J) that a law would take on a straight line to the end of the step.
    fn energy_straight(&mut self, solver: &StepSolver, e: usize) -> f64 {
        let contact = &solver.plant.contacts[e];
        let Some(law) = contact.law.as_deref() else { return 0.0 };
        let (displacement, velocity) = self.geometric(solver, e, END);
        let (at, change) = (&solver.nodes[e][END], &self.nodes[END][e]);
        let flexibility = solver.plant.ports[contact.port].flexibility;
        let displacement = displacement - flexibility * change.force;
        let by = Inputs { displacement, velocity, normal_load: change.load };
        self.sensitivity[e].look(law, inputs(at, contact.series, at.normal_load), by).dissipated_energy
    }
}
