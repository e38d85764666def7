//! Piecewise-linear contacts, exactly: sliders side by side, from turning point to turning point.
//!
//! A slider's position is a number kept between two limits that move with the displacement. So a period maps
//! it to the nearest number of an interval, and once round leads to the periodic state. The start is the
//! turning point of the largest magnitude, to which a slider without history is loaded.

mod bundle;
mod integrals;
mod path;

use super::motion::{Motion, Turning};
use super::turning::turning_points;
use super::{Cycle, CycleSummary, ForceMap, PeriodicContact};
use crate::contact::Slider;
use crate::harmonic::HarmonicError;
use crate::numeric::HarmonicSet;
use bundle::{Bundle, MOST_ROUNDS, PeriodTotals};
use integrals::{Piece, PiecewiseForceIntegrals, Source};
pub(super) use path::{Path, tip_stiffness};
use path::{Reach, Record, Region};

/// Rounds after which the state must repeat; one is enough for sliders on their own.
const MAX_ROUNDS: usize = 20;

/// Halvings that leave nothing of an interval.
const BISECTIONS: usize = 100;

/// The contact map of laws that are sliders side by side. A damper beside them is left to others.
#[derive(Debug)]
pub(crate) struct PiecewiseCycle {
    set: HarmonicSet,
    result: ForceMap,
    displacement: Vec<f64>,
    sliders: Vec<Slider>,
    motion: Motion,
    turnings: Vec<Turning>,
    path: Path,
    integrals: PiecewiseForceIntegrals,
    bundle: Bundle,
    record: Record,
    compliance: f64,
}

/// How the sliders went through a period.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Passage {
    /// Nothing moved.
    AtRest,
    /// Each on its own.
    Alone,
    /// Side by side behind one spring.
    Together,
}

impl PiecewiseCycle {
    pub fn new(set: HarmonicSet) -> Self {
        Self {
            set,
            result: ForceMap::new(set.len()),
            displacement: vec![0.0; set.len()],
            sliders: Vec::new(),
            motion: Motion::default(),
            turnings: Vec::new(),
            path: Path::default(),
            integrals: PiecewiseForceIntegrals::new(set),
            bundle: Bundle::default(),
            record: Record::default(),
            compliance: 0.0,
        }
    }

    /// The motion of a slider on its own over the period, to the integrals.
    fn run(&mut self, reach: &Reach) {
        let (mut position, mut source) = periodic_position(reach, &self.path);
        let mut before = (Piece::NONE, Source::NONE);
        for leg in 0..self.path.points.len() - 1 {
            let (from, to) = (self.path.points[leg], self.path.points[leg + 1]);
            let rising = to.value > from.value;
            let mut region = reach.region(position, from.value, rising);
            let mut piece = reach.piece(region, position);
            self.record.force[leg] += piece.force(from.value);
            self.integrals.turn(leg, before, (piece, source));
            let mut apart_since = from.phase;
            while let Some((next, end)) = reach.next(region, rising) {
                let target = position + end;
                if (target >= to.value) == rising {
                    break;
                }
                let phase = self.motion.phase_of(target, &from, &to);
                let after = reach.piece(next, position);
                self.integrals.change(phase, piece, after);
                self.integrals.pull(source, piece.stiffness - after.stiffness);
                if next == Region::Play {
                    apart_since = phase;
                } else {
                    self.record.loose.push((apart_since, phase));
                }
                (region, piece) = (next, after);
            }
            if region == Region::Play {
                self.record.loose.push((apart_since, to.phase));
            }
            let followed = reach.follow(position, to.value);
            if followed != position {
                let (limit, end) = if rising {
                    (reach.slider.upper_limit, reach.above)
                } else {
                    (-reach.slider.lower_limit, reach.below)
                };
                let phase = self.motion.phase_of(position + end, &from, &to);
                let slip = Piece { stiffness: 0.0, constant: limit };
                self.integrals.change(phase, piece, slip);
                self.integrals.pull(source, piece.stiffness);
                self.record.loose.push((phase, to.phase));
                self.record.dissipated_energy += limit * (followed - position);
                piece = slip;
                (position, source) = (followed, self.path.source(leg + 1));
                // From here on the position depends on the turning point ahead; in slip nothing pulls.
                before = (piece, Source::NONE);
            } else {
                before = (piece, source);
            }
        }
        self.integrals.turn(self.path.points.len() - 1, before, (Piece::NONE, Source::NONE));
    }

    /// Follows the contact through the period and sums the integrals; at rest they are complete.
    fn run_through(&mut self, contact: &PeriodicContact, u: &[f64]) -> Result<Passage, HarmonicError> {
        if contact.law.sliders_and_damper(contact.normal_load, &mut self.sliders).is_none() {
            return Err(HarmonicError::InvalidInput("the contact law is not piecewise linear"));
        }
        if !self.motion.set(self.set, u) {
            return Err(HarmonicError::InvalidInput("a displacement that is not finite"));
        }
        self.displacement.copy_from_slice(u);
        self.compliance = contact.compliance;
        turning_points(&self.motion, &mut self.turnings);
        let odd = self.sliders.iter().all(Slider::is_odd);
        self.path.set(&self.turnings, &self.motion, odd);
        self.record.clear(self.path.points.len());
        if self.path.points.is_empty() {
            self.rest();
            return Ok(Passage::AtRest);
        }
        self.integrals.start(&self.path.points);
        if contact.compliance != 0.0 && self.sliders.len() > 1 {
            let Self { bundle, sliders, path, integrals, record, motion, .. } = self;
            if !bundle.run(sliders, contact.compliance, path, &mut PeriodTotals { integrals, record, motion })
            {
                return Err(HarmonicError::ContactNotPeriodic { cycles: MOST_ROUNDS });
            }
            return Ok(Passage::Together);
        }
        for i in 0..self.sliders.len() {
            let reach = Reach::behind(&self.sliders[i], contact.compliance);
            self.run(&reach);
        }
        Ok(Passage::Alone)
    }

    /// A contact at rest: a contact without history loaded to the mean displacement. What slid on the way follows a
    /// change of the mean and resists all else.
    fn rest(&mut self) {
        let (total, compliance) = (self.motion.bias(), self.compliance);
        // T = F(u − a T) by bisection: F grows with the displacement.
        let loaded = |force: f64| -> f64 {
            self.sliders.iter().map(|slider| slider.step(0.0, total - compliance * force).0).sum()
        };
        let mut force = loaded(0.0);
        if compliance > 0.0 {
            let (mut low, mut high) = (force.min(0.0), force.max(0.0));
            for _ in 0..BISECTIONS {
                force = 0.5 * (low + high);
                if loaded(force) > force { low = force } else { high = force }
            }
        }
        let contact = total - compliance * force;
        let (mut bias_stiffness, mut stiffness) = (0.0, 0.0);
        for slider in &self.sliders {
            let (_, position) = slider.step(0.0, contact);
            let stretch = contact - position;
            if stretch >= slider.play_above || stretch <= slider.play_below {
                stiffness += slider.stiffness;
                bias_stiffness += if position == 0.0 { slider.stiffness } else { 0.0 };
            }
        }
        self.result.force.fill(0.0);
        self.result.jacobian.fill(0.0);
        self.result.jacobian.fill_diagonal(stiffness / (1.0 + compliance * stiffness));
        if !self.set.is_odd() {
            self.result.force[0] = force;
            self.result.jacobian[(0, 0)] = bias_stiffness / (1.0 + compliance * bias_stiffness);
        }
    }
}

/// Position of a slider at the start of the path, and what it depends on.
fn periodic_position(reach: &Reach, path: &Path) -> (f64, Source) {
    let mut position = reach.follow(0.0, path.points[0].value);
    let mut source = if position == 0.0 { Source::NONE } else { path.source(0) };
    for _ in 0..MAX_ROUNDS {
        let start = position;
        for (index, point) in path.points.iter().enumerate().skip(1) {
            let followed = reach.follow(position, point.value);
            if followed != position {
                position = followed;
                source = path.source(index);
            }
        }
        position *= path.sign;
        source.sign *= path.sign;
        if position == start {
            break;
        }
    }
    (position, source)
}

impl Cycle for PiecewiseCycle {
    fn evaluate(
        &mut self,
        contact: &PeriodicContact,
        _angular_frequency: f64,
        u: &[f64],
    ) -> Result<(), HarmonicError> {
        let together = match self.run_through(contact, u)? {
            Passage::AtRest => return Ok(()),
            Passage::Alone => false,
            Passage::Together => true,
        };
        let contact_by_points = together.then_some(self.bundle.by_points.as_slice());
        let (force, jacobian) = (&mut self.result.force, &mut self.result.jacobian);
        self.integrals.integrate(self.set, self.path.fraction(), u, contact_by_points, force, jacobian);
        Ok(())
    }

    fn follow(
        &mut self,
        contact: &PeriodicContact,
        _angular_frequency: f64,
        u: &[f64],
    ) -> Result<(), HarmonicError> {
        self.run_through(contact, u).map(drop)
    }

    fn result(&self) -> &ForceMap {
        &self.result
    }

    fn force_on(&mut self, set: HarmonicSet, out: &mut [f64]) {
        if self.path.points.is_empty() {
            self.set.convert(&self.result.force, set, out);
        } else {
            self.integrals.force_on(set, self.set, self.path.fraction(), &self.displacement, out);
        }
    }

    fn summary(&mut self) -> CycleSummary {
        let apart = self.sliders.is_empty();
        self.record.summary(&self.path, self.compliance, apart)
    }
}
