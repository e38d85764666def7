//! Contacts that are smooth between reversals.
//!
//! The periodic states at the turning points come from [`Chain`]. Between two of them every force is one exact
//! step from the turning point behind, so that the force's integrals are Gauss–Legendre sums over panels.
//! A panel is halved until the force on it is resolved: near a reversal the unloading is steep. Panels meet where the
//! force jumps ([`Jump`]).

mod chain;
mod jump;

use nalgebra::DMatrix;

use super::motion::{Motion, Turning};
use super::piecewise::{Path, tip_stiffness};
use super::turning::turning_points;
use super::waves::{Waves, multiplication};
use super::{Cycle, CycleSummary, PeriodicContact};
use crate::contact::{Inputs, SlipState, StateTangents};
use crate::harmonic::HarmonicError;
use crate::numeric::HarmonicSet;
use crate::numeric::fourier::work_per_cycle;
use chain::{Chain, STEP_TOLERANCE, spring_step};
use jump::Jump;

/// Nodes of a panel.
const NODES: usize = 16;
/// Positive nodes and their weights of Gauss–Legendre quadrature with 16 nodes on [−1, 1].
const RULE: [(f64, f64); NODES / 2] = [
    (0.095_012_509_837_637_44, 0.189_450_610_455_068_5),
    (0.281_603_550_779_258_9, 0.182_603_415_044_923_6),
    (0.458_016_777_657_227_4, 0.169_156_519_395_002_54),
    (0.617_876_244_402_643_7, 0.149_595_988_816_576_73),
    (0.755_404_408_355_003, 0.124_628_971_255_533_87),
    (0.865_631_202_387_831_7, 0.095_158_511_682_492_78),
    (0.944_575_023_073_232_6, 0.062_253_523_938_647_89),
    (0.989_400_934_991_649_9, 0.027_152_459_411_754_095),
];
/// Largest half-width of a panel in radians of the highest harmonic.
const WIDEST: f64 = 7.0;
/// Fraction of the largest force that the highest Legendre coefficients on a panel may have.
const RESOLVED: f64 = 1e-6;
/// Fraction of it that the coefficients as far beyond them may have, where the rule ceases to be exact. Those of a smooth
/// force fall from order to order by a ratio, those of a force with a knee far slower.
const INTEGRATED: f64 = 1e-9;
/// Error of the step through the series spring at a node, as a fraction of the force.
const NODE_TOLERANCE: f64 = 1e-12;
/// Times a panel is halved at most.
const MAX_HALVINGS: u32 = 14;

/// What is known at a node.
#[derive(Debug, Clone, Copy, Default)]
struct Node {
    phase: f64,
    slope: f64,
    force: f64,
    stiffness: f64,
    damping: f64,
    stuck: bool,
}

/// The contact map of laws whose step between two reversals is exact.
#[derive(Debug)]
pub(crate) struct SmoothCycle {
    set: HarmonicSet,
    force: Vec<f64>,
    jacobian: DMatrix<f64>,
    by_frequency: Vec<f64>,
    displacement: Vec<f64>,
    motion: Motion,
    turnings: Vec<Turning>,
    /// One whole period.
    path: Path,
    fraction: f64,
    chain: Chain,
    rule: Rule,
    nodes: [Node; NODES],
    /// On the present leg.
    jump: Option<Jump>,
    /// Derivatives of the force at the nodes by the state behind.
    by_state: Vec<f64>,
    /// Whether a component of the state behind depends on the motion.
    depends: Vec<bool>,
    next: Vec<f64>,
    tangents: StateTangents,
    sums: Sums,
    matrix: DMatrix<f64>,
    pull: Vec<f64>,
    basis: Vec<f64>,
    /// Phase, weighted force, and weight at all nodes; the weight is negative in stick.
    history: Vec<(f64, f64, f64)>,
    rated: bool,
    compliance: f64,
    has_stick: bool,
    /// Whether only the force is asked for.
    alone: bool,
}

/// Integrals with the waves.
#[derive(Debug)]
struct Sums {
    waves: Waves,
    force: Waves,
    stiffness: Waves,
    damping: Waves,
    by_frequency: Waves,
    /// By the state behind, on the present leg.
    by_state: Vec<Waves>,
    by_source: Vec<Waves>,
}

/// Quadrature on a panel, and the test whether the panel is resolved.
#[derive(Debug)]
struct Rule {
    nodes: [f64; NODES],
    weights: [f64; NODES],
    /// Rows that give the three highest Legendre coefficients of values at the nodes.
    tail: [[f64; NODES]; 3],
    /// The same of the three whose orders are half as high.
    middle: [[f64; NODES]; 3],
}

impl Rule {
    fn new() -> Self {
        let mut rule = Self {
            nodes: [0.0; NODES],
            weights: [0.0; NODES],
            tail: [[0.0; NODES]; 3],
            middle: [[0.0; NODES]; 3],
        };
        for (i, (node, weight)) in RULE.iter().enumerate() {
            let (left, right) = (NODES / 2 - 1 - i, NODES / 2 + i);
            (rule.nodes[left], rule.nodes[right]) = (-node, *node);
            (rule.weights[left], rule.weights[right]) = (*weight, *weight);
        }
        for i in 0..NODES {
            let x = rule.nodes[i];
            let (mut before, mut legendre) = (1.0, x);
            for k in 1..NODES {
                let row = (k as f64 + 0.5) * rule.weights[i] * legendre;
                match k {
                    6..=8 => rule.middle[k - 6][i] = row,
                    13..NODES => rule.tail[k - 13][i] = row,
                    _ => (),
                }
                let k = k as f64;
                (before, legendre) = (legendre, ((2.0 * k + 1.0) * x * legendre - k * before) / (k + 1.0));
            }
        }
        rule
    }

    /// Whether nodes are too few for the force at them, `scale` (N) being its size.
    fn too_wide(&self, nodes: &[Node; NODES], scale: f64) -> bool {
        let coefficient =
            |row: &[f64; NODES]| row.iter().zip(nodes).map(|(r, node)| r * node.force).sum::<f64>().abs();
        let sum = |rows: &[[f64; NODES]; 3]| rows.iter().map(coefficient).sum::<f64>();
        let (middle, tail) = (sum(&self.middle), sum(&self.tail));
        // From order 7 to 14 by a ratio, from 14 to 28 by its square.
        let unfounded = tail > INTEGRATED * scale && tail.powi(3) > INTEGRATED * scale * middle * middle;
        tail > RESOLVED * scale || unfounded
    }
}

impl SmoothCycle {
    pub fn new(set: HarmonicSet) -> Self {
        let (single, product) = (Waves::single(set), Waves::product(set, set));
        let sums = Sums {
            waves: Waves::either(&single, &product),
            force: single.clone(),
            stiffness: product.clone(),
            damping: product,
            by_frequency: single,
            by_state: Vec::new(),
            by_source: Vec::new(),
        };
        let size = set.len();
        Self {
            set,
            force: vec![0.0; size],
            jacobian: DMatrix::zeros(size, size),
            by_frequency: vec![0.0; size],
            displacement: vec![0.0; size],
            motion: Motion::default(),
            turnings: Vec::new(),
            path: Path::default(),
            fraction: 1.0,
            chain: Chain::default(),
            rule: Rule::new(),
            nodes: [Node::default(); NODES],
            jump: None,
            by_state: Vec::new(),
            depends: Vec::new(),
            next: Vec::new(),
            tangents: StateTangents::default(),
            sums,
            matrix: DMatrix::zeros(size, size),
            pull: vec![0.0; size],
            basis: vec![0.0; size],
            history: Vec::new(),
            rated: false,
            compliance: 0.0,
            has_stick: false,
            alone: false,
        }
    }

    /// Integrates over the leg from point `leg`.
    fn integrate_leg(&mut self, contact: &PeriodicContact, angular_frequency: f64, leg: usize) {
        for (component, depends) in self.depends.iter_mut().enumerate() {
            *depends = self.chain.by_points(leg, component).iter().any(|d| *d != 0.0);
        }
        let (from, to) = (self.path.points[leg], self.path.points[leg + 1]);
        let scratch = (self.next.as_mut_slice(), &mut self.tangents);
        self.jump = Jump::find(contact, self.chain.state(leg), &self.motion, (&from, &to), scratch);
        let (from, to) = (from.phase, to.phase);
        let Some(jump) = &self.jump else {
            self.integrate_part(contact, angular_frequency, leg, (from, to));
            return;
        };
        let (mut first, mut last) = (jump.phase, jump.phase);
        if contact.compliance == 0.0 {
            self.add_jump(angular_frequency);
        } else {
            let other = jump.other_end(contact, angular_frequency, &self.motion, (from, to));
            (first, last) = (first.min(other), last.max(other));
        }
        for part in [(from, first), (first, last), (last, to)] {
            self.integrate_part(contact, angular_frequency, leg, part);
        }
    }

    fn integrate_part(
        &mut self,
        contact: &PeriodicContact,
        angular_frequency: f64,
        leg: usize,
        (from, to): (f64, f64),
    ) {
        let width = to - from;
        if width <= 0.0 {
            return;
        }
        let panels = (0.5 * width * self.set.highest() as f64 / WIDEST).ceil().max(1.0);
        for panel in 0..panels as usize {
            let left = from + width * (panel as f64 / panels);
            self.integrate_panel(
                contact,
                angular_frequency,
                leg,
                (left, left + width / panels),
                MAX_HALVINGS,
            );
        }
    }

    fn integrate_panel(
        &mut self,
        contact: &PeriodicContact,
        angular_frequency: f64,
        leg: usize,
        (left, right): (f64, f64),
        halvings: u32,
    ) {
        self.visit(contact, angular_frequency, leg, left, right);
        // A drag has no force at the turning points, by which the chain measures.
        let nodes = self.nodes.iter();
        let scale = nodes.fold(self.chain.force_scale, |scale, node| scale.max(node.force.abs()));
        if halvings > 0 && self.rule.too_wide(&self.nodes, scale) {
            let middle = 0.5 * (left + right);
            self.integrate_panel(contact, angular_frequency, leg, (left, middle), halvings - 1);
            self.integrate_panel(contact, angular_frequency, leg, (middle, right), halvings - 1);
            return;
        }
        self.add(angular_frequency, 0.5 * (right - left));
    }

    /// Evaluates the law at the nodes of a panel.
    fn visit(
        &mut self,
        contact: &PeriodicContact,
        angular_frequency: f64,
        leg: usize,
        left: f64,
        right: f64,
    ) {
        let n = self.next.len();
        // Force, stiffness and displacement at the node before, to start the next one from.
        let mut before = (self.chain.force[leg], 0.0, 0.0);
        for (i, node) in self.nodes.iter_mut().enumerate() {
            node.phase = 0.5 * ((left + right) + (right - left) * self.rule.nodes[i]);
            let (displacement, slope) = self.motion.value_and_slope(node.phase);
            node.slope = slope;
            let mut inputs = Inputs {
                displacement,
                velocity: angular_frequency * slope,
                normal_load: contact.normal_load,
            };
            let (scale, state) = (self.chain.force_scale, self.chain.state(leg));
            let by_state = &mut self.by_state[i * n..(i + 1) * n];
            if contact.compliance != 0.0
                && let Some(jump) = &self.jump
                && let Some(force) = jump.taken_up(contact.compliance, displacement, inputs.velocity)
            {
                (node.force, node.stiffness) = (force, 1.0 / contact.compliance);
                (node.damping, node.stuck) = (0.0, true);
                before = (force, node.stiffness, displacement);
                let scaled = jump.by_state.iter().map(|by_state| by_state / contact.compliance);
                by_state.iter_mut().zip(scaled).for_each(|(to, from)| *to = from);
                continue;
            }
            if self.alone && contact.compliance == 0.0 {
                // A law of many sliders has a tenth of the work with it.
                self.next.copy_from_slice(state);
                node.force = contact.law.advance(&mut self.next, inputs);
                continue;
            }
            let response = if contact.compliance == 0.0 {
                contact.law.force_and_tangents(state, inputs, &mut self.next, &mut self.tangents)
            } else {
                let guess = before.0 + before.1 * (displacement - before.2);
                let response =
                    spring_step(contact, state, &mut inputs, guess, scale, NODE_TOLERANCE, &mut self.next);
                contact.law.state_tangents(state, inputs, &mut self.tangents);
                response
            };
            let homotopy_compliance = 1.0 / (1.0 + contact.compliance * response.tangents.displacement);
            node.force = response.force;
            node.stiffness = homotopy_compliance * response.tangents.displacement;
            before = (node.force, node.stiffness, displacement);
            node.damping = homotopy_compliance * response.tangents.velocity;
            node.stuck = response.slip_state == SlipState::Stick;
            for (to, from) in by_state.iter_mut().zip(&self.tangents.force_by_state) {
                *to = homotopy_compliance * from;
            }
        }
    }

    /// Adds a panel's nodes to the sums.
    fn add(&mut self, angular_frequency: f64, half_width: f64) {
        if self.alone {
            let nodes = self.nodes.iter().zip(&self.rule.weights);
            let weighted = nodes.map(|(node, weight)| (half_width * weight, node));
            self.history.extend(weighted.map(|(weight, node)| (node.phase, weight * node.force, weight)));
            return;
        }
        let n = self.next.len();
        let sums = &mut self.sums;
        for (i, node) in self.nodes.iter().enumerate() {
            let weight = half_width * self.rule.weights[i];
            sums.waves.fill(node.phase);
            sums.force.add(weight * node.force, &sums.waves);
            sums.stiffness.add(weight * node.stiffness, &sums.waves);
            if node.damping != 0.0 {
                self.rated = true;
                sums.damping.add(weight * angular_frequency * node.damping, &sums.waves);
                sums.by_frequency.add(weight * node.damping * node.slope, &sums.waves);
            }
            add_by_state(sums, weight, &self.by_state[i * n..(i + 1) * n], &self.depends);
            let marked = if node.stuck { -weight } else { weight };
            self.history.push((node.phase, weight * node.force, marked));
        }
    }

    /// Adds what the coefficients change by as the jump moves.
    fn add_jump(&mut self, angular_frequency: f64) {
        let (Some(jump), sums) = (&self.jump, &mut self.sums) else { return };
        let weight = angular_frequency * jump.damping.abs();
        sums.waves.fill(jump.phase);
        sums.stiffness.add(weight, &sums.waves);
        add_by_state(sums, weight, &jump.by_state, &self.depends);
    }

    /// Hands a leg's derivatives by its state on to the turning points the state depends on.
    fn hand_on(&mut self, leg: usize) {
        let points = self.path.points.len() - 1;
        for (component, sum) in self.sums.by_state.iter_mut().enumerate().take(self.next.len()) {
            for (l, weight) in self.chain.by_points(leg, component).iter().enumerate() {
                // The second half of an odd period mirrors the first.
                let (index, sign) =
                    if self.fraction < 1.0 && l >= points / 2 { (l - points / 2, -1.0) } else { (l, 1.0) };
                if *weight != 0.0 {
                    self.sums.by_source[index].add(sign * weight, sum);
                }
            }
            sum.clear();
        }
    }

    /// Coefficients and derivatives from the sums.
    fn finish(&mut self) {
        let (set, fraction) = (self.set, self.fraction);
        self.sums.force.coefficients(set, fraction, &mut self.force);
        multiplication(&self.sums.stiffness, set, set, fraction, &mut self.jacobian);
        self.sums.by_frequency.coefficients(set, fraction, &mut self.by_frequency);
        if self.rated {
            multiplication(&self.sums.damping, set, set, fraction, &mut self.matrix);
            add_by_slope(set, &self.matrix, &mut self.jacobian);
        }
        let sources = (self.path.points.len() - 1) / if fraction < 1.0 { 2 } else { 1 };
        for source in 0..sources {
            self.sums.by_source[source].coefficients(set, fraction, &mut self.pull);
            self.sums.waves.fill(self.path.points[source].phase);
            self.sums.waves.basis(set, &mut self.basis);
            let size = self.pull.len();
            for (column, b) in self.jacobian.as_mut_slice().chunks_exact_mut(size).zip(&self.basis) {
                column.iter_mut().zip(&self.pull).for_each(|(m, p)| *m += p * b);
            }
        }
    }

    /// The contact along one period; sums over it, unless the force is wanted `alone`.
    fn run_through(
        &mut self,
        contact: &PeriodicContact,
        angular_frequency: f64,
        u: &[f64],
        alone: bool,
    ) -> Result<(), HarmonicError> {
        self.alone = alone;
        if !self.motion.set(self.set, u) {
            return Err(HarmonicError::InvalidInput("a displacement that is not finite"));
        }
        self.displacement.copy_from_slice(u);
        self.compliance = contact.compliance;
        self.has_stick = contact.law.has_stick();
        turning_points(&self.motion, &mut self.turnings);
        self.path.set(&self.turnings, &self.motion, false);
        self.fraction = if self.motion.is_odd() && contact.law.is_odd() { 0.5 } else { 1.0 };
        self.reset(contact.law.state_len());
        if self.path.points.is_empty() {
            self.rest(contact, angular_frequency);
            return Ok(());
        }
        self.chain.solve(contact, &self.path.points)?;
        let legs = self.path.points.len() - 1;
        for leg in 0..if self.fraction < 1.0 { legs / 2 } else { legs } {
            self.integrate_leg(contact, angular_frequency, leg);
            if !self.alone {
                self.hand_on(leg);
            }
        }
        if !self.alone {
            self.finish();
        }
        Ok(())
    }

    fn reset(&mut self, state_len: usize) {
        let points = self.path.points.len().saturating_sub(1);
        self.history.clear();
        self.rated = false;
        self.next.resize(state_len, 0.0);
        self.by_state.resize(NODES * state_len, 0.0);
        self.depends.resize(state_len, false);
        let sums = &mut self.sums;
        while sums.by_state.len() < state_len {
            sums.by_state.push(Waves::single(self.set));
        }
        while sums.by_source.len() < points {
            sums.by_source.push(Waves::single(self.set));
        }
        for sum in [&mut sums.force, &mut sums.stiffness, &mut sums.damping, &mut sums.by_frequency] {
            sum.clear();
        }
        sums.by_state.iter_mut().for_each(Waves::clear);
        sums.by_source.iter_mut().for_each(Waves::clear);
    }

    /// A contact at rest: a contact without history loaded to the mean displacement. A change of the mean loads it
    /// further, all else unloads it.
    fn rest(&mut self, contact: &PeriodicContact, angular_frequency: f64) {
        let mut state = vec![0.0; self.next.len()];
        contact.law.set_state(0.0, contact.normal_load, 0.0, &mut state);
        let total =
            Inputs { displacement: self.motion.bias(), velocity: 0.0, normal_load: contact.normal_load };
        let mut inputs = total;
        let loading = spring_step(contact, &state, &mut inputs, 0.0, 0.0, STEP_TOLERANCE, &mut self.next);
        let loaded = self.next.clone();
        let unloading = contact.law.step(&loaded, inputs, &mut self.next);
        let soft = |stiffness: f64| 1.0 / (1.0 + contact.compliance * stiffness);
        let (stiffness, damping) = (unloading.tangents.displacement, unloading.tangents.velocity);
        self.force.fill(0.0);
        self.by_frequency.fill(0.0);
        self.jacobian.fill(0.0);
        self.jacobian.fill_diagonal(stiffness * soft(stiffness));
        if damping != 0.0 {
            self.matrix.fill(0.0);
            self.matrix.fill_diagonal(angular_frequency * damping * soft(stiffness));
            add_by_slope(self.set, &self.matrix, &mut self.jacobian);
        }
        if !self.set.is_odd() {
            self.force[0] = loading.force;
            let stiffness = loading.tangents.displacement;
            self.jacobian[(0, 0)] = stiffness * soft(stiffness);
        }
        self.chain.dissipated_energy = 0.0;
        self.history.push((0.0, 0.0, if loading.slip_state == SlipState::Stick { -1.0 } else { 1.0 }));
    }
}

/// Adds derivatives by the state behind, of the components that depend on the motion.
fn add_by_state(sums: &mut Sums, weight: f64, by_state: &[f64], depends: &[bool]) {
    for (sum, (by_state, depends)) in sums.by_state.iter_mut().zip(by_state.iter().zip(depends)) {
        if *depends && *by_state != 0.0 {
            sum.add(weight * by_state, &sums.waves);
        }
    }
}

/// Adds to `jacobian` the derivatives by the displacement of what `matrix` makes of its slope.
fn add_by_slope(set: HarmonicSet, matrix: &DMatrix<f64>, jacobian: &mut DMatrix<f64>) {
    for (order, place) in set.orders().filter(|(order, _)| *order > 0) {
        // (c cos hθ + s sin hθ)' = h s cos hθ − h c sin hθ.
        let h = order as f64;
        for row in 0..matrix.nrows() {
            jacobian[(row, place)] -= h * matrix[(row, place + 1)];
            jacobian[(row, place + 1)] += h * matrix[(row, place)];
        }
    }
}

impl Cycle for SmoothCycle {
    fn evaluate(
        &mut self,
        contact: &PeriodicContact,
        angular_frequency: f64,
        u: &[f64],
    ) -> Result<(), HarmonicError> {
        self.run_through(contact, angular_frequency, u, false)
    }

    fn follow(
        &mut self,
        contact: &PeriodicContact,
        angular_frequency: f64,
        u: &[f64],
    ) -> Result<(), HarmonicError> {
        self.run_through(contact, angular_frequency, u, true)
    }

    fn force(&self) -> &[f64] {
        &self.force
    }

    fn jacobian(&self) -> &DMatrix<f64> {
        &self.jacobian
    }

    fn by_frequency(&self) -> &[f64] {
        &self.by_frequency
    }

    /// The nodes resolve harmonics up to about twice the highest of the cycle's own set.
    fn force_on(&mut self, set: HarmonicSet, out: &mut [f64]) {
        let half = self.fraction < 1.0;
        if self.path.points.is_empty() {
            self.set.convert(&self.force, set, out);
            return;
        }
        if half && set.highest() == 0 {
            out.fill(0.0);
            return;
        }
        let kept = if half { HarmonicSet::odd(set.highest()) } else { set };
        let mut sum = Waves::single(kept);
        let mut waves = sum.clone();
        for (phase, force, _) in &self.history {
            waves.fill(*phase);
            sum.add(*force, &waves);
        }
        let mut force = vec![0.0; kept.len()];
        sum.coefficients(kept, self.fraction, &mut force);
        kept.convert(&force, set, out);
    }

    fn summary(&mut self) -> CycleSummary {
        let (mut stuck, mut all) = (0.0, 0.0);
        for (_, _, weight) in &self.history {
            stuck += (-weight).max(0.0);
            all += weight.abs();
        }
        let dissipated_energy = if self.rated {
            let full = HarmonicSet::full(self.set.highest());
            let (mut force, mut displacement) = (vec![0.0; full.len()], vec![0.0; full.len()]);
            self.set.convert(&self.force, full, &mut force);
            self.set.convert(&self.displacement, full, &mut displacement);
            work_per_cycle(&force, &displacement)
        } else {
            self.chain.dissipated_energy
        };
        CycleSummary {
            dissipated_energy,
            equivalent_stiffness: tip_stiffness(&self.path, &self.chain.force, self.compliance),
            stick_fraction: self.has_stick.then(|| stuck / all),
        }
    }
}
