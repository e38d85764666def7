//! The force of a piecewise-linear contact over a period, as the changes of its pieces.
//!
//! On a piece the force is `k u(θ) + c`, with `c` depending on displacements at turning points alone. Its
//! integrals with the basis functions are differences of antiderivatives, so that a period is a list of
//! phases with the changes of `k` and `c` there. The force is continuous, hence a change's phase needs
//! no derivative; and a turning point's displacement has the derivative `b(θ*)`, for its slope vanishes.

use nalgebra::DMatrix;

use crate::harmonic::period::motion::Turning;
use crate::harmonic::period::waves::Waves;
use crate::numeric::HarmonicSet;
use crate::numeric::multiplication::Multiplication;

/// A turning point on which a slider's position depends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Source {
    /// Which turning point.
    pub index: usize,
    /// ∂position/∂its displacement: ±1, or 0 for a position that depends on none.
    pub sign: f64,
}

impl Source {
    pub const NONE: Self = Self { index: 0, sign: 0.0 };
}

/// A piece of the force: `stiffness · u + constant`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Piece {
    pub stiffness: f64,
    pub constant: f64,
}

impl Piece {
    pub const NONE: Self = Self { stiffness: 0.0, constant: 0.0 };

    pub fn force(&self, displacement: f64) -> f64 {
        self.stiffness * displacement + self.constant
    }
}

/// A change at a phase: of the piece, left less right.
#[derive(Debug, Clone, Copy)]
struct Change {
    phase: f64,
    piece: Piece,
}

/// A change of `−∂c/∂(displacement of a turning point)`, left less right, at the change `at`.
#[derive(Debug, Clone, Copy)]
struct Pull {
    at: usize,
    source: Source,
    stiffness: f64,
}

/// Sums of the force on another set than the displacement's.
#[derive(Debug)]
struct Other {
    kept: HarmonicSet,
    waves: Waves,
    stiffness: Waves,
    constant: Waves,
    force: Vec<f64>,
}

/// The list, and the sums it makes up.
#[derive(Debug, Default)]
pub(super) struct PiecewiseForceIntegrals {
    changes: Vec<Change>,
    pulls: Vec<Pull>,
    /// Pulls at the turning points: `turning points × sources`.
    turning_pulls: Vec<f64>,
    sources: usize,
    waves: Waves,
    by_stiffness: Waves,
    by_constant: Waves,
    by_source: Vec<Waves>,
    spare: Vec<Waves>,
    product: Multiplication,
    basis: Vec<f64>,
    pull: Vec<f64>,
    other: Option<Other>,
}

impl PiecewiseForceIntegrals {
    pub fn new(set: HarmonicSet) -> Self {
        let by_stiffness = Waves::product(set, set);
        let by_constant = Waves::single(set);
        Self {
            waves: Waves::either(&by_stiffness, &by_constant),
            by_stiffness,
            by_constant,
            basis: vec![0.0; set.len()],
            pull: vec![0.0; set.len()],
            ..Self::default()
        }
    }

    /// Starts a period that runs through `points`, the last of which is the first a period later.
    pub fn start(&mut self, points: &[Turning]) {
        self.changes.clear();
        self.pulls.clear();
        self.changes.extend(points.iter().map(|point| Change { phase: point.phase, piece: Piece::NONE }));
        self.sources = points.len() - 1;
        self.turning_pulls.clear();
        self.turning_pulls.resize(points.len() * self.sources, 0.0);
        while self.by_source.len() < self.sources {
            self.by_source.push(self.by_constant.clone());
        }
    }

    /// At turning point `index` one piece follows another.
    pub fn turn(&mut self, index: usize, before: (Piece, Source), after: (Piece, Source)) {
        let change = &mut self.changes[index].piece;
        change.stiffness += before.0.stiffness - after.0.stiffness;
        change.constant += before.0.constant - after.0.constant;
        self.pull_at_turn(index, before.1, before.0.stiffness);
        self.pull_at_turn(index, after.1, -after.0.stiffness);
    }

    /// Adds to the pull of a source at turning point `index`.
    pub fn pull_at_turn(&mut self, index: usize, source: Source, stiffness: f64) {
        self.turning_pulls[index * self.sources + source.index] += source.sign * stiffness;
    }

    /// Between two turning points one piece follows another.
    pub fn change(&mut self, phase: f64, before: Piece, after: Piece) {
        let piece = Piece {
            stiffness: before.stiffness - after.stiffness,
            constant: before.constant - after.constant,
        };
        self.changes.push(Change { phase, piece });
    }

    /// At the last change the pull of a source changes by `stiffness`, left less right.
    pub fn pull(&mut self, source: Source, stiffness: f64) {
        if source.sign != 0.0 && stiffness != 0.0 {
            self.pulls.push(Pull { at: self.changes.len() - 1, source, stiffness });
        }
    }

    /// Integrates force and derivatives over the period, `fraction` of which was run through. The sources are
    /// displacements at the turning points, or what depends on them by the rows of `by_points`.
    pub fn integrate(
        &mut self,
        set: HarmonicSet,
        fraction: f64,
        u: &[f64],
        by_points: Option<&[f64]>,
        force: &mut [f64],
        jacobian: &mut DMatrix<f64>,
    ) {
        self.sum();
        self.by_stiffness.integrate();
        self.by_constant.integrate();
        self.by_stiffness.multiply(set, set, fraction, &mut self.product);
        self.product.write(jacobian.as_mut_slice().chunks_exact_mut(force.len()));
        self.by_constant.coefficients(set, fraction, force);
        self.product.add_product(u, force);
        for source in 0..self.sources {
            self.by_source[source].integrate();
        }
        if let Some(by_points) = by_points {
            self.spread(by_points);
        }
        for source in 0..self.sources {
            self.by_source[source].coefficients(set, fraction, &mut self.pull);
            self.waves.fill(self.changes[source].phase);
            self.waves.basis(set, &mut self.basis);
            subtract_product(jacobian, &self.pull, &self.basis);
        }
    }

    /// Spreads what belongs to the sources over the turning points.
    fn spread(&mut self, by_points: &[f64]) {
        while self.spare.len() < self.sources {
            self.spare.push(self.by_constant.clone());
        }
        std::mem::swap(&mut self.spare, &mut self.by_source);
        for (point, target) in self.by_source[..self.sources].iter_mut().enumerate() {
            target.clear();
            for (source, waves) in self.spare[..self.sources].iter().enumerate() {
                target.add(by_points[source * self.sources + point], waves);
            }
        }
    }

    /// Sums the antiderivatives at all changes.
    fn sum(&mut self) {
        self.by_stiffness.clear();
        self.by_constant.clear();
        self.by_source[..self.sources].iter_mut().for_each(Waves::clear);
        let mut pulls = self.pulls.iter().peekable();
        for (at, change) in self.changes.iter().enumerate() {
            antiderivative(&mut self.waves, change.phase);
            self.by_stiffness.add(change.piece.stiffness, &self.waves);
            self.by_constant.add(change.piece.constant, &self.waves);
            let row = self.turning_pulls.get(at * self.sources..(at + 1) * self.sources).unwrap_or(&[]);
            for (by_source, weight) in self.by_source.iter_mut().zip(row) {
                if *weight != 0.0 {
                    by_source.add(*weight, &self.waves);
                }
            }
            while let Some(pull) = pulls.next_if(|pull| pull.at == at) {
                self.by_source[pull.source.index].add(pull.source.sign * pull.stiffness, &self.waves);
            }
        }
    }

    /// Coefficients on `other` of the force for the displacement `u` on `set`. Of half a period of an odd
    /// motion only odd harmonics follow, and there are no others.
    pub fn force_on(
        &mut self,
        other: HarmonicSet,
        set: HarmonicSet,
        fraction: f64,
        u: &[f64],
        out: &mut [f64],
    ) {
        let half = fraction < 1.0;
        if half && other.highest() == 0 {
            out.fill(0.0);
            return;
        }
        let kept = if half { HarmonicSet::odd(other.highest()) } else { other };
        if self.other.as_ref().is_none_or(|other| other.kept != kept) {
            let (stiffness, constant) = (Waves::product(kept, set), Waves::single(kept));
            self.other = Some(Other {
                kept,
                waves: Waves::either(&stiffness, &constant),
                stiffness,
                constant,
                force: vec![0.0; kept.len()],
            });
        }
        let Some(Other { waves, stiffness, constant, force, .. }) = &mut self.other else { return };
        stiffness.clear();
        constant.clear();
        for change in &self.changes {
            antiderivative(waves, change.phase);
            stiffness.add(change.piece.stiffness, waves);
            constant.add(change.piece.constant, waves);
        }
        stiffness.integrate();
        constant.integrate();
        constant.coefficients(kept, fraction, force);
        stiffness.multiply(kept, set, fraction, &mut self.product);
        self.product.add_product(u, force);
        kept.convert(force, other, out);
    }
}

/// Waves whose integral is meant: the phase in place of the constant.
fn antiderivative(waves: &mut Waves, phase: f64) {
    waves.fill(phase);
    if let Some(constant) = waves.even.first_mut() {
        constant[0] = phase;
    }
}

/// `matrix −= left · rightᵀ`.
fn subtract_product(matrix: &mut DMatrix<f64>, left: &[f64], right: &[f64]) {
    for (column, r) in matrix.as_mut_slice().chunks_exact_mut(left.len()).zip(right) {
        column.iter_mut().zip(left).for_each(|(m, l)| *m -= l * r);
    }
}
