//! Piecewise-linear contacts, exactly: sliders side by side, from turning point to turning point.
//!
//! A slider's position is a number kept between two limits that move with the displacement. So a period maps
//! it to the nearest number of an interval, and once round leads to the periodic state. The start is the
//! turning point of the largest magnitude, to which the virgin slider is loaded.

mod bundle;
mod integrals;

use nalgebra::DMatrix;

use super::motion::{Motion, Turning};
use super::turning::turning_points;
use super::{Cycle, CycleSummary, PeriodicContact};
use crate::contact::Slider;
use crate::harmonic::HarmonicError;
use crate::numeric::HarmonicSet;
use bundle::{Books, Bundle, MOST_ROUNDS};
use integrals::{Piece, PiecewiseForceIntegrals, Source};

/// Rounds after which the state must repeat; one is enough for sliders on their own.
const MAX_ROUNDS: usize = 20;

/// Halvings that leave nothing of an interval.
const BISECTIONS: usize = 100;

/// The contact map of laws that are sliders side by side. A damper beside them is left to others.
#[derive(Debug)]
pub(crate) struct PiecewiseCycle {
    set: HarmonicSet,
    force: Vec<f64>,
    jacobian: DMatrix<f64>,
    by_frequency: Vec<f64>,
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

/// The turning points in the order they are met, from the largest magnitude on; the last is the first, a
/// period (half a period of an odd motion) later.
#[derive(Debug, Default)]
pub(super) struct Path {
    pub points: Vec<Turning>,
    /// The last point's displacement in terms of the first's: −1 over half a period.
    pub sign: f64,
}

/// What is needed to sum up a period.
#[derive(Debug, Default)]
pub(super) struct Record {
    /// Total force at the path's points but the last (N).
    pub force: Vec<f64>,
    /// Energy dissipated on the path (J).
    pub dissipated_energy: f64,
    /// Phases between which a slider slides or is apart.
    pub loose: Vec<(f64, f64)>,
}

/// A slider's limits as distances from its position.
#[derive(Debug, Clone, Copy)]
pub(super) struct Reach {
    pub slider: Slider,
    /// Largest and smallest u − z.
    pub above: f64,
    pub below: f64,
}

/// How the sliders went through a period.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Followed {
    /// Nothing moved.
    AtRest,
    /// Each on its own.
    Alone,
    /// Side by side behind one spring.
    Together,
}

/// Where on its polyline a slider is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Region {
    Below,
    Play,
    Above,
}

impl Path {
    /// From the turning points of one period of `motion`; of the full period if the contact is not `odd`.
    pub fn set(&mut self, turnings: &[Turning], motion: &Motion, odd: bool) {
        self.points.clear();
        self.points.extend_from_slice(turnings);
        self.sign = if motion.is_odd() { -1.0 } else { 1.0 };
        let later = |t: &Turning, sign: f64, by: f64| Turning { phase: t.phase + by, value: sign * t.value };
        if motion.is_odd() && !odd {
            self.points.extend(turnings.iter().map(|t| later(t, -1.0, std::f64::consts::PI)));
            self.sign = 1.0;
        }
        let period = if self.sign < 0.0 { std::f64::consts::PI } else { std::f64::consts::TAU };
        let mut first = 0;
        for (i, point) in self.points.iter().enumerate() {
            if point.value.abs() > self.points[first].value.abs() {
                first = i;
            }
        }
        let (sign, count) = (self.sign, self.points.len());
        self.points.iter_mut().take(first).for_each(|point| *point = later(point, sign, period));
        if count > 0 {
            self.points.rotate_left(first);
            self.points.push(later(&self.points[0], sign, period));
        }
    }

    /// Share of a period the path runs through.
    pub fn share(&self) -> f64 {
        if self.sign < 0.0 { 0.5 } else { 1.0 }
    }

    /// The source that point `index` is.
    fn source(&self, index: usize) -> Source {
        if index + 1 == self.points.len() {
            Source { index: 0, sign: self.sign }
        } else {
            Source { index, sign: 1.0 }
        }
    }
}

impl Reach {
    /// The slider behind a spring of its own of `compliance` (m/N).
    pub fn behind(slider: &Slider, compliance: f64) -> Self {
        let slider =
            Slider { stiffness: slider.stiffness / (1.0 + compliance * slider.stiffness), ..*slider };
        Self {
            slider,
            above: slider.play_above + slider.upper_limit / slider.stiffness,
            below: slider.play_below - slider.lower_limit / slider.stiffness,
        }
    }

    /// The slider's position nearest to `position` that holds at `displacement` (m).
    pub fn follow(&self, position: f64, displacement: f64) -> f64 {
        let (low, high) = (displacement - self.above, displacement - self.below);
        if position < low {
            low
        } else if position > high {
            high
        } else {
            position
        }
    }

    /// Region at `displacement` from which the slider moves on, up or down.
    pub fn region(&self, position: f64, displacement: f64, rising: bool) -> Region {
        let stretch = displacement - position;
        let Slider { play_below, play_above, .. } = self.slider;
        if play_below == play_above {
            return Region::Above;
        }
        let (above, below) = if rising {
            (stretch >= play_above, stretch < play_below)
        } else {
            (stretch > play_above, stretch <= play_below)
        };
        if above {
            Region::Above
        } else if below {
            Region::Below
        } else {
            Region::Play
        }
    }

    /// The force in a region.
    fn piece(&self, region: Region, position: f64) -> Piece {
        let stiffness = self.slider.stiffness;
        match region {
            Region::Play => Piece::NONE,
            Region::Above => Piece { stiffness, constant: -stiffness * (position + self.slider.play_above) },
            Region::Below => Piece { stiffness, constant: -stiffness * (position + self.slider.play_below) },
        }
    }

    /// The next region on the way, and the end of this one relative to the position.
    pub fn next(&self, region: Region, rising: bool) -> Option<(Region, f64)> {
        match (region, rising) {
            (Region::Below, true) => Some((Region::Play, self.slider.play_below)),
            (Region::Play, true) => Some((Region::Above, self.slider.play_above)),
            (Region::Above, false) if self.slider.play_below < self.slider.play_above => {
                Some((Region::Play, self.slider.play_above))
            }
            (Region::Play, false) => Some((Region::Below, self.slider.play_below)),
            _ => None,
        }
    }
}

impl PiecewiseCycle {
    pub fn new(set: HarmonicSet) -> Self {
        Self {
            set,
            force: vec![0.0; set.len()],
            jacobian: DMatrix::zeros(set.len(), set.len()),
            by_frequency: vec![0.0; set.len()],
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

    /// Follows the contact through the period and keeps the books; at rest they are complete.
    fn follow(&mut self, contact: &PeriodicContact, u: &[f64]) -> Result<Followed, HarmonicError> {
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
            return Ok(Followed::AtRest);
        }
        self.integrals.start(&self.path.points);
        if contact.compliance != 0.0 && self.sliders.len() > 1 {
            let Self { bundle, sliders, path, integrals, record, motion, .. } = self;
            if !bundle.run(sliders, contact.compliance, path, &mut Books { integrals, record, motion }) {
                return Err(HarmonicError::ContactNotPeriodic { cycles: MOST_ROUNDS });
            }
            return Ok(Followed::Together);
        }
        for i in 0..self.sliders.len() {
            let reach = Reach::behind(&self.sliders[i], contact.compliance);
            self.run(&reach);
        }
        Ok(Followed::Alone)
    }

    /// A contact at rest: the virgin contact loaded to the mean displacement. What slid on the way follows a
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
        self.force.fill(0.0);
        self.jacobian.fill(0.0);
        self.jacobian.fill_diagonal(stiffness / (1.0 + compliance * stiffness));
        if !self.set.is_odd() {
            self.force[0] = force;
            self.jacobian[(0, 0)] = bias_stiffness / (1.0 + compliance * bias_stiffness);
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
        let together = match self.follow(contact, u)? {
            Followed::AtRest => return Ok(()),
            Followed::Alone => false,
            Followed::Together => true,
        };
        let contact_by_points = together.then_some(self.bundle.by_points.as_slice());
        let (force, jacobian) = (&mut self.force, &mut self.jacobian);
        self.integrals.integrate(self.set, self.path.share(), u, contact_by_points, force, jacobian);
        Ok(())
    }

    fn force_alone(
        &mut self,
        contact: &PeriodicContact,
        _angular_frequency: f64,
        u: &[f64],
        set: HarmonicSet,
        out: &mut [f64],
    ) -> Result<(), HarmonicError> {
        self.follow(contact, u)?;
        self.force_on(set, out);
        Ok(())
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

    fn forget(&mut self) {}

    fn force_on(&mut self, set: HarmonicSet, out: &mut [f64]) {
        if self.path.points.is_empty() {
            self.set.convert(&self.force, set, out);
        } else {
            self.integrals.force_on(set, self.set, self.path.share(), &self.displacement, out);
        }
    }

    fn summary(&mut self) -> CycleSummary {
        let apart = self.sliders.is_empty();
        self.record.summary(&self.path, self.compliance, apart)
    }
}

impl Record {
    pub fn clear(&mut self, points: usize) {
        self.force.clear();
        self.force.resize(points.saturating_sub(1), 0.0);
        self.dissipated_energy = 0.0;
        self.loose.clear();
    }

    /// Sums up a period behind a spring of `compliance` (m/N); `apart` where there is no contact at all.
    pub fn summary(&mut self, path: &Path, compliance: f64, apart: bool) -> CycleSummary {
        self.loose.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        let mut loose = 0.0;
        let mut covered = f64::NEG_INFINITY;
        for (from, to) in &self.loose {
            loose += (to - from.max(covered)).max(0.0);
            covered = covered.max(*to);
        }
        let period = path.share() * std::f64::consts::TAU;
        let stick_fraction = if apart { 0.0 } else { (1.0 - loose / period).clamp(0.0, 1.0) };
        CycleSummary {
            dissipated_energy: self.dissipated_energy / path.share(),
            equivalent_stiffness: tip_stiffness(path, &self.force, compliance),
            stick_fraction: Some(stick_fraction),
        }
    }
}

/// Slope between the extreme displacements of the contact, from the forces at the path's points.
pub(super) fn tip_stiffness(path: &Path, force: &[f64], compliance: f64) -> f64 {
    let points = path.points.iter().zip(force).map(|(point, force)| (point.value, *force));
    let by_value = |a: &(f64, f64), b: &(f64, f64)| a.0.total_cmp(&b.0);
    let (Some(mut low), Some(mut high)) = (points.clone().min_by(by_value), points.max_by(by_value)) else {
        return f64::NAN;
    };
    if path.sign < 0.0 {
        let tip = if high.0 >= -low.0 { high } else { (-low.0, -low.1) };
        (low, high) = ((-tip.0, -tip.1), tip);
    }
    let force = high.1 - low.1;
    force / (high.0 - low.0 - compliance * force)
}
