//! Sliders side by side behind one spring, exactly.
//!
//! In the contact's own displacement `v = u − a T` the force is `K v + C` between the ends of the sliders'
//! pieces, so that `u = v + a (K v + C)` leads from one end to the next. The sliders' positions follow `v` at the
//! turning points, whose derivatives depend on each other through the spring and are solved for together.
//!
//! Sliders with unequal limits can remember their first loading for ever, for it happened against other forces
//! behind the spring. Of turning points of equal magnitude the first in phase is then loaded to.

use super::integrals::{Piece, PiecewiseForceIntegrals, Source};
use super::path::{Path, Reach, Record, Region};
use crate::contact::Slider;
use crate::harmonic::period::motion::Motion;
use crate::numeric::elimination::solve_ranked;

/// Rounds after which the state is given up: each brings it closer by a fraction that the spring decides.
pub(super) const MOST_ROUNDS: usize = 500;
/// Fraction of the displacement by which positions may differ between rounds.
const PERIODIC: f64 = 1e-13;

/// A slider within the bundle.
#[derive(Debug, Clone, Copy)]
struct Member {
    reach: Reach,
    position: f64,
    /// Position at the start of the round.
    start: f64,
    source: Source,
    region: Region,
    /// Limit (N) at which it slides on the present leg, and that limit's distance from the position.
    slip: Option<(f64, f64)>,
    /// Phase from which on it slides or is apart.
    loose_since: f64,
}

/// An end of a piece on the present leg.
#[derive(Debug, Clone, Copy)]
struct End {
    /// Displacement of the contact (m).
    at: f64,
    member: usize,
    /// The region that follows, or none for slip.
    next: Option<Region>,
}

/// Sum of the members' pieces, over the contact's own displacement.
#[derive(Debug, Default)]
struct Total {
    stiffness: f64,
    constant: f64,
    /// Stiffness of the members whose positions follow each turning point, with its sign.
    pulls: Vec<f64>,
}

/// All sliders of a contact behind its spring.
#[derive(Debug, Default)]
pub(super) struct Bundle {
    compliance: f64,
    members: Vec<Member>,
    ends: Vec<End>,
    total: Total,
    /// The contact's own displacement at the point reached.
    contact: f64,
    /// Its derivatives at all points by the displacements at the points, row by row.
    pub by_points: Vec<f64>,
    system: Vec<f64>,
    pivots: Vec<usize>,
    before: Vec<f64>,
}

/// Where a recorded period goes to.
pub(super) struct PeriodTotals<'a> {
    pub integrals: &'a mut PiecewiseForceIntegrals,
    pub record: &'a mut Record,
    pub motion: &'a Motion,
}

impl Total {
    fn add(&mut self, member: &Member, sign: f64) {
        if member.slip.is_some() {
            return;
        }
        let piece = member.reach.piece(member.region, member.position);
        self.stiffness += sign * piece.stiffness;
        self.constant += sign * piece.constant;
        if let Some(pull) = self.pulls.get_mut(member.source.index) {
            *pull += sign * member.source.sign * piece.stiffness;
        }
    }

    /// The force over the displacement of contact and spring together.
    fn piece(&self, compliance: f64) -> Piece {
        let homotopy_compliance = 1.0 / (1.0 + compliance * self.stiffness);
        Piece {
            stiffness: homotopy_compliance * self.stiffness,
            constant: homotopy_compliance * self.constant,
        }
    }
}

impl Bundle {
    /// Runs through the periodic state of `sliders` behind a spring of `compliance` (m/N); false where the rounds do
    /// not lead to one.
    #[must_use]
    pub fn run(
        &mut self,
        sliders: &[Slider],
        compliance: f64,
        path: &Path,
        totals: &mut PeriodTotals,
    ) -> bool {
        self.compliance = compliance;
        let sources = path.points.len() - 1;
        self.total.pulls.clear();
        self.total.pulls.resize(sources, 0.0);
        self.before.clear();
        self.before.resize(sources, 0.0);
        self.load_virgin(sliders, path);
        let tolerance = PERIODIC * path.points[0].value.abs();
        let mut periodic = false;
        for _ in 0..MOST_ROUNDS {
            self.members.iter_mut().for_each(|member| member.start = member.position);
            for leg in 0..sources {
                self.leg(path, leg, None);
            }
            self.repeat(path.sign);
            periodic = self.members.iter().all(|member| (member.position - member.start).abs() <= tolerance);
            if periodic {
                break;
            }
        }
        if !periodic {
            return false;
        }
        self.system.clear();
        self.system.resize(2 * sources * sources, 0.0);
        let mut before = Piece::NONE;
        self.before.fill(0.0);
        for leg in 0..sources {
            self.start_leg(path, leg);
            let after = self.total.piece(compliance);
            totals.record.force[leg] += after.force(path.points[leg].value);
            totals.integrals.turn(leg, (before, Source::NONE), (after, Source::NONE));
            self.book_pulls(totals.integrals, Some(leg));
            self.leg(path, leg, Some(totals));
            before = self.total.piece(compliance);
            self.remember_pulls();
            self.arrive(path, leg + 1);
        }
        totals.integrals.turn(sources, (before, Source::NONE), (Piece::NONE, Source::NONE));
        self.total.pulls.fill(0.0);
        self.total.stiffness = 0.0;
        self.book_pulls(totals.integrals, Some(sources));
        self.solve_contact(sources);
        true
    }

    /// Loads a contact without history to the first point.
    fn load_virgin(&mut self, sliders: &[Slider], path: &Path) {
        self.members.clear();
        self.members.extend(sliders.iter().map(|slider| {
            let reach = Reach::behind(slider, 0.0);
            Member {
                reach,
                position: reach.follow(0.0, 0.0),
                start: 0.0,
                source: Source::NONE,
                region: Region::Above,
                slip: None,
                loose_since: 0.0,
            }
        }));
        self.contact = 0.0;
        self.travel(self.virgin_rises(path), path.points[0].value, path.source(0));
    }

    /// Whether loading from rest to the first point is upwards.
    fn virgin_rises(&self, path: &Path) -> bool {
        let force: f64 = self
            .members
            .iter()
            .map(|member| {
                let region = member.reach.region(member.position, 0.0, true);
                member.reach.piece(region, member.position).force(0.0)
            })
            .sum();
        path.points[0].value > self.compliance * force
    }

    /// Moves to the displacement `target` of contact and spring.
    fn travel(&mut self, rising: bool, target: f64, source: Source) {
        self.open(rising);
        let mut passed = 0;
        while let Some(end) = self.ends.get(passed).copied() {
            if (self.total_at(end.at) >= target) == rising {
                break;
            }
            self.pass(&end, rising);
            passed += 1;
        }
        self.settle(target, source);
    }

    /// Displacement of contact and spring where the contact's own is `contact`.
    fn total_at(&self, contact: f64) -> f64 {
        contact + self.compliance * (self.total.stiffness * contact + self.total.constant)
    }

    /// Finds the pieces and their ends ahead.
    fn open(&mut self, rising: bool) {
        let contact = self.contact;
        self.total.stiffness = 0.0;
        self.total.constant = 0.0;
        self.total.pulls.fill(0.0);
        self.ends.clear();
        for (index, member) in self.members.iter_mut().enumerate() {
            let reach = &member.reach;
            member.slip = None;
            member.region = reach.region(member.position, contact, rising);
            self.total.add(member, 1.0);
            let mut region = member.region;
            while let Some((next, end)) = reach.next(region, rising) {
                self.ends.push(End { at: member.position + end, member: index, next: Some(next) });
                region = next;
            }
            let end = if rising { reach.above } else { reach.below };
            self.ends.push(End { at: member.position + end, member: index, next: None });
        }
        self.ends.retain(|end| end.at.is_finite());
        // A stable sort keeps the ends of one member in order.
        if rising {
            self.ends.sort_by(|a, b| a.at.total_cmp(&b.at));
        } else {
            self.ends.sort_by(|a, b| b.at.total_cmp(&a.at));
        }
    }

    /// Passes an end of a piece.
    fn pass(&mut self, end: &End, rising: bool) {
        let member = &mut self.members[end.member];
        self.total.add(member, -1.0);
        match end.next {
            Some(region) => {
                member.region = region;
                self.total.add(member, 1.0);
            }
            None => {
                let slider = &member.reach.slider;
                let slip = if rising {
                    (slider.upper_limit, member.reach.above)
                } else {
                    (-slider.lower_limit, member.reach.below)
                };
                self.total.constant += slip.0;
                member.slip = Some(slip);
            }
        }
    }

    /// Arrives at `target`: what slid stays there. Returns the energy dissipated (J).
    fn settle(&mut self, target: f64, source: Source) -> f64 {
        self.contact =
            (target - self.compliance * self.total.constant) / (1.0 + self.compliance * self.total.stiffness);
        let mut dissipated = 0.0;
        for member in &mut self.members {
            if let Some((limit, end)) = member.slip {
                let position = self.contact - end;
                dissipated += (limit * (position - member.position)).max(0.0);
                (member.position, member.source) = (position, source);
            }
        }
        dissipated
    }

    fn start_leg(&mut self, path: &Path, leg: usize) {
        self.open(path.points[leg + 1].value > path.points[leg].value);
    }

    /// Runs through a leg; with totals, after its start.
    fn leg(&mut self, path: &Path, leg: usize, totals: Option<&mut PeriodTotals>) {
        let (from, to) = (path.points[leg], path.points[leg + 1]);
        let rising = to.value > from.value;
        let source = path.source(leg + 1);
        let Some(totals) = totals else {
            return self.travel(rising, to.value, source);
        };
        let play = |member: &Member| member.region == Region::Play && member.slip.is_none();
        self.members.iter_mut().for_each(|member| member.loose_since = from.phase);
        let mut passed = 0;
        while let Some(end) = self.ends.get(passed).copied() {
            let target = self.total_at(end.at);
            if (target >= to.value) == rising {
                break;
            }
            let phase = totals.motion.phase_of(target, &from, &to);
            let before = self.total.piece(self.compliance);
            self.remember_pulls();
            let apart = play(&self.members[end.member]);
            self.pass(&end, rising);
            let member = &mut self.members[end.member];
            if apart {
                totals.record.loose.push((member.loose_since, phase));
            }
            member.loose_since = phase;
            totals.integrals.change(phase, before, self.total.piece(self.compliance));
            self.book_pulls(totals.integrals, None);
            passed += 1;
        }
        for member in self.members.iter().filter(|member| play(member) || member.slip.is_some()) {
            totals.record.loose.push((member.loose_since, to.phase));
        }
        totals.record.dissipated_energy += self.settle(to.value, source);
    }

    /// The pulls that remain of a change, reduced by the spring.
    fn remember_pulls(&mut self) {
        let homotopy_compliance = 1.0 / (1.0 + self.compliance * self.total.stiffness);
        for (before, pull) in self.before.iter_mut().zip(&self.total.pulls) {
            *before = homotopy_compliance * pull;
        }
    }

    /// Writes the change of the pulls since they were remembered, at a turning point or at the last change.
    fn book_pulls(&mut self, integrals: &mut PiecewiseForceIntegrals, turning: Option<usize>) {
        let homotopy_compliance = 1.0 / (1.0 + self.compliance * self.total.stiffness);
        for (index, (before, pull)) in self.before.iter().zip(&self.total.pulls).enumerate() {
            let source = Source { index, sign: 1.0 };
            let change = before - homotopy_compliance * pull;
            match turning {
                Some(point) => integrals.pull_at_turn(point, source, change),
                None => integrals.pull(source, change),
            }
        }
    }

    /// A period later everything is the same, or the opposite.
    fn repeat(&mut self, sign: f64) {
        self.contact *= sign;
        for member in &mut self.members {
            member.position *= sign;
            member.source.sign *= sign;
        }
    }

    /// The equation of `dv` at the point arrived at: `(1 + a K) dv = b + a Σ pull dv_source`.
    fn arrive(&mut self, path: &Path, point: usize) {
        let sources = path.points.len() - 1;
        let source = path.source(point);
        let row = &mut self.system[source.index * 2 * sources..(source.index + 1) * 2 * sources];
        for (x, pull) in row.iter_mut().zip(&self.total.pulls) {
            *x = -self.compliance * source.sign * pull;
        }
        row[source.index] += 1.0 + self.compliance * self.total.stiffness;
        row[sources + source.index] = 1.0;
    }

    /// Solves for the derivatives of the contact's own displacement at the points.
    fn solve_contact(&mut self, sources: usize) {
        self.pivots.clear();
        self.pivots.resize(sources, 0);
        self.by_points.clear();
        self.by_points.resize(sources * sources, 0.0);
        // Diagonally dominant: never singular.
        solve_ranked(&mut self.system, &mut self.pivots, sources, 0.0, &mut self.by_points);
    }
}
