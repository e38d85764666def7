//! Contacts that are smooth between reversals.
//!
//! The periodic states at the turning points come from [`Chain`]. Between two of them every force is one exact
//! step from the turning point behind, so that the force's integrals are Gauss–Legendre sums over panels.
//! A panel is halved until the force on it is resolved: near a reversal the unloading is steep. Panels meet where the
//! force jumps ([`Jump`]).

mod chain;
mod jump;
mod panels;
mod rule;

use nalgebra::DMatrix;

use super::motion::{Motion, Turning};
use super::piecewise::{Path, tip_stiffness};
use super::turning::turning_points;
use super::waves::Waves;
use super::{Cycle, CycleSummary, ForceMap, PeriodicContact};
use crate::contact::{Inputs, SlipState, StateTangents};
use crate::harmonic::HarmonicError;
use crate::numeric::HarmonicSet;
use crate::numeric::fourier::work_per_cycle;
use crate::numeric::multiplication::Multiplication;
use chain::{Chain, STEP_TOLERANCE, spring_step};
use jump::Jump;
use rule::{NODES, Node, Rule};

/// The contact map of laws whose step between two reversals is exact.
#[derive(Debug)]
pub(crate) struct SmoothCycle {
    set: HarmonicSet,
    result: ForceMap,
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
    product: Multiplication,
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
            result: ForceMap::new(size),
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
            product: Multiplication::default(),
            pull: vec![0.0; size],
            basis: vec![0.0; size],
            history: Vec::new(),
            rated: false,
            compliance: 0.0,
            has_stick: false,
            alone: false,
        }
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
        self.sums.force.coefficients(set, fraction, &mut self.result.force);
        let size = set.len();
        self.sums.stiffness.multiply(set, set, fraction, &mut self.product);
        self.product.write(self.result.jacobian.as_mut_slice().chunks_exact_mut(size));
        self.sums.by_frequency.coefficients(set, fraction, &mut self.result.by_frequency);
        if self.rated {
            self.sums.damping.multiply(set, set, fraction, &mut self.product);
            self.product.write(self.matrix.as_mut_slice().chunks_exact_mut(size));
            add_by_slope(set, &self.matrix, &mut self.result.jacobian);
        }
        let sources = (self.path.points.len() - 1) / if fraction < 1.0 { 2 } else { 1 };
        for source in 0..sources {
            self.sums.by_source[source].coefficients(set, fraction, &mut self.pull);
            self.sums.waves.fill(self.path.points[source].phase);
            self.sums.waves.basis(set, &mut self.basis);
            for (column, b) in self.result.jacobian.as_mut_slice().chunks_exact_mut(size).zip(&self.basis) {
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
        self.result.force.fill(0.0);
        self.result.by_frequency.fill(0.0);
        self.result.jacobian.fill(0.0);
        self.result.jacobian.fill_diagonal(stiffness * soft(stiffness));
        if damping != 0.0 {
            self.matrix.fill(0.0);
            self.matrix.fill_diagonal(angular_frequency * damping * soft(stiffness));
            add_by_slope(self.set, &self.matrix, &mut self.result.jacobian);
        }
        if !self.set.is_odd() {
            self.result.force[0] = loading.force;
            let stiffness = loading.tangents.displacement;
            self.result.jacobian[(0, 0)] = stiffness * soft(stiffness);
        }
        self.chain.dissipated_energy = 0.0;
        self.history.push((0.0, 0.0, if loading.slip_state == SlipState::Stick { -1.0 } else { 1.0 }));
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

    fn result(&self) -> &ForceMap {
        &self.result
    }

    /// The nodes resolve harmonics up to about twice the highest of the cycle's own set.
    fn force_on(&mut self, set: HarmonicSet, out: &mut [f64]) {
        let half = self.fraction < 1.0;
        if self.path.points.is_empty() {
            self.set.convert(&self.result.force, set, out);
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
            self.set.convert(&self.result.force, full, &mut force);
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
