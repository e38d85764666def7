//! Equations `given(assumed) = assumed`: fixed points, accelerated, and Newton's method.

#[cfg(test)]
mod tests;

use crate::cosim::settings::{Method, Strong};
use crate::numeric::gmres::Krylov;

/// The difference between what was assumed and what that gives.
pub(in crate::cosim) trait Coupling {
    /// Why the difference cannot be computed.
    type Trouble;

    /// Writes into `residual` what `assumed` gives, less `assumed`.
    fn evaluate(&mut self, assumed: &[f64], residual: &mut [f64]) -> Result<(), Self::Trouble>;

    /// Can other values be tried after this trouble, which these values may have made?
    fn recovers(&self, _trouble: &Self::Trouble) -> bool {
        false
    }

    /// Change of the residual where the values assumed last change by `direction`, as far as derivatives at the end
    /// of the step tell it; false if they do not.
    fn product(&mut self, direction: &[f64], change: &mut [f64]) -> Result<bool, Self::Trouble>;
}

/// How a solution ended.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::cosim) struct Solved {
    pub evaluations: u32,
    /// Largest difference left, over the largest magnitude of each unknown.
    pub residual: f64,
    pub converged: bool,
}

/// Relative to the size of the unknowns: changes that distinguish repeated evaluations from rounding.
const DIFFERENCE: f64 = 1e-6;
/// An iteration that multiplies the residual by this is not going to come back.
const HOPELESS: f64 = 1e6;
/// How often values that a slave refuses are taken back half way.
const RETREATS: u32 = 10;
/// Relative residual at which a Newton step is good enough.
const ENOUGH: f64 = 1e-10;
/// A column of differences that lies this close to the span of newer ones adds no information.
const DEPENDENT: f64 = 1e-10;
/// Least reduction of the residual that Newton's method must give before its derivatives are mistrusted.
const SLOW: f64 = 0.5;
/// Most past steps that correct the derivatives.
const CORRECTIONS: usize = 5;

/// A method with room for its vectors: nothing allocates while it solves.
#[derive(Debug)]
pub(in crate::cosim) struct Solver {
    settings: Strong,
    /// Largest magnitude of each unknown so far.
    pub peak: Vec<f64>,
    scale: Vec<f64>,
    residual: Vec<f64>,
    last_assumed: Vec<f64>,
    last_residual: Vec<f64>,
    best: Vec<f64>,
    trial: Vec<f64>,
    changed: Vec<f64>,
    /// Anderson: the last changes of unknowns and residuals, the newest at `newest`, and the same made orthogonal.
    steps: Vec<Vec<f64>>,
    changes: Vec<Vec<f64>>,
    orthogonal_steps: Vec<Vec<f64>>,
    orthogonal_changes: Vec<Vec<f64>>,
    newest: usize,
    stored: usize,
    relaxation: f64,
    krylov: Krylov,
    /// Right side of the Newton step.
    right: Vec<f64>,
    /// Newton: past changes of the unknowns, and what the derivatives missed of the changes of the residual, over the
    /// squares of their lengths: as much is added to products (C. G. Broyden, Mathematics of Computation 19 (1965)
    /// 577–593).
    secants: Vec<[Vec<f64>; 2]>,
    corrections: usize,
    /// Newton: the derivatives at the end of the step are not sufficient.
    repeated: bool,
    last_size: f64,
}

impl Solver {
    pub fn new(settings: Strong, unknowns: usize) -> Self {
        let zeros = || vec![0.0; unknowns];
        let depth = match settings.method {
            Method::Anderson { depth } => depth.clamp(1, 30).min(unknowns.max(1)),
            _ => 0,
        };
        let columns = || vec![zeros(); depth];
        Self {
            settings,
            peak: zeros(),
            scale: zeros(),
            residual: zeros(),
            last_assumed: zeros(),
            last_residual: zeros(),
            best: zeros(),
            trial: zeros(),
            changed: zeros(),
            steps: columns(),
            changes: columns(),
            orthogonal_steps: columns(),
            orthogonal_changes: columns(),
            newest: 0,
            stored: 0,
            relaxation: 1.0,
            krylov: Krylov::default(),
            right: zeros(),
            secants: (0..CORRECTIONS).map(|_| [zeros(), zeros()]).collect(),
            corrections: 0,
            repeated: false,
            last_size: f64::INFINITY,
        }
    }

    /// Solves from `assumed`, where the solution is left; the last evaluation was there. Where nothing converges that is
    /// the best there was.
    pub fn solve<C: Coupling>(
        &mut self,
        coupling: &mut C,
        assumed: &mut [f64],
    ) -> Result<Solved, C::Trouble> {
        let mut solved = Solved { evaluations: 0, residual: f64::INFINITY, converged: false };
        (self.stored, self.relaxation, self.repeated) = (0, 1.0, false);
        self.corrections = 0;
        self.last_size = f64::INFINITY;
        self.scale.copy_from_slice(&self.peak);
        let mut best = f64::INFINITY;
        let mut first = f64::INFINITY;
        // Evaluations for products with the Jacobian do not count here.
        let (mut rounds, mut retreats) = (0, 0);
        loop {
            let evaluated = coupling.evaluate(assumed, &mut self.residual);
            solved.evaluations += 1;
            match evaluated {
                Ok(()) => {}
                // Half way back to the best there was.
                Err(trouble) if best.is_finite() && retreats < RETREATS && coupling.recovers(&trouble) => {
                    retreats += 1;
                    for (assumed, best) in assumed.iter_mut().zip(&self.best) {
                        *assumed = 0.5 * (*assumed + best);
                    }
                    continue;
                }
                Err(trouble) => return Err(trouble),
            }
            let size = self.measure(assumed);
            if size <= self.settings.tolerance {
                return Ok(Solved { residual: size, converged: true, ..solved });
            }
            if size < best {
                best = size;
                self.best.copy_from_slice(assumed);
            }
            if first.is_infinite() {
                first = size;
            }
            let lost = !size.is_finite() || size > HOPELESS * first;
            let start = rounds == 0;
            rounds += 1;
            if lost || rounds >= self.settings.iterations {
                break;
            }
            match self.settings.method {
                Method::FixedPoint => add(assumed, &self.residual, 1.0),
                Method::Aitken => self.aitken(assumed, start),
                Method::Anderson { .. } => self.anderson(assumed, start),
                Method::Newton => self.newton(coupling, assumed, size, &mut solved)?,
            }
        }
        if best.is_finite() && *assumed != *self.best {
            assumed.copy_from_slice(&self.best);
            coupling.evaluate(assumed, &mut self.residual)?;
            solved.evaluations += 1;
        }
        Ok(Solved { residual: best, ..solved })
    }

    /// Takes the largest magnitudes of `assumed` for the scale of later solutions.
    pub fn remember(&mut self, assumed: &[f64]) {
        for (peak, value) in self.peak.iter_mut().zip(assumed) {
            *peak = peak.max(value.abs());
        }
    }

    /// Largest residual over the size of its unknown; sets the scale.
    fn measure(&mut self, assumed: &[f64]) -> f64 {
        let mut largest = 0.0_f64;
        for (index, scale) in self.scale.iter_mut().enumerate() {
            let (value, residual) = (assumed[index], self.residual[index]);
            // An unknown that goes to zero is measured by where it came from.
            *scale = scale.max(value.abs()).max((value + residual).abs());
            if !scale.is_finite() || *scale == 0.0 {
                *scale = f64::MIN_POSITIVE;
            }
            let relative = if residual == 0.0 { 0.0 } else { residual.abs() / *scale };
            // NaN must not be lost in the comparison.
            if relative > largest || relative.is_nan() {
                largest = relative;
            }
        }
        largest
    }

    fn aitken(&mut self, assumed: &mut [f64], first: bool) {
        if !first {
            for ((change, now), before) in
                self.changed.iter_mut().zip(&self.residual).zip(&self.last_residual)
            {
                *change = now - before;
            }
            let scale = &self.scale;
            let square = dot(scale, &self.changed, &self.changed);
            let ratio = dot(scale, &self.last_residual, &self.changed) / square;
            let relaxation = -self.relaxation * ratio;
            // A change of nothing divides by zero, and a residual that hardly changes asks for too much.
            self.relaxation = if relaxation.is_finite() { relaxation.clamp(-10.0, 10.0) } else { 1.0 };
        }
        self.last_residual.copy_from_slice(&self.residual);
        add(assumed, &self.residual, self.relaxation);
    }

    /// assumed + residual − (steps + changes) γ, with γ the least squares solution of residual = changes γ.
    fn anderson(&mut self, assumed: &mut [f64], first: bool) {
        let depth = self.steps.len();
        if !first && depth > 0 {
            self.newest = (self.newest + 1) % depth;
            self.stored = (self.stored + 1).min(depth);
            let (step, change) = (&mut self.steps[self.newest], &mut self.changes[self.newest]);
            for index in 0..assumed.len() {
                step[index] = assumed[index] - self.last_assumed[index];
                change[index] = self.residual[index] - self.last_residual[index];
            }
        }
        self.last_assumed.copy_from_slice(assumed);
        self.last_residual.copy_from_slice(&self.residual);
        let kept = self.orthogonalize();
        self.changed.copy_from_slice(&self.residual);
        for (change, step) in self.orthogonal_changes.iter().zip(&self.orthogonal_steps).take(kept) {
            let fraction = dot(&self.scale, change, &self.changed);
            add(&mut self.changed, change, -fraction);
            add(assumed, step, -fraction);
        }
        add(assumed, &self.changed, 1.0);
    }

    /// Orthogonal changes of length one in scaled units with the steps that belong to them, the newest first; what
    /// older ones no longer add is dropped. How many are left.
    fn orthogonalize(&mut self) -> usize {
        let depth = self.steps.len().max(1);
        let mut kept = 0;
        for back in 0..self.stored {
            let column = (self.newest + depth - back) % depth;
            let mut change = std::mem::take(&mut self.orthogonal_changes[kept]);
            let mut step = std::mem::take(&mut self.orthogonal_steps[kept]);
            change.copy_from_slice(&self.changes[column]);
            step.copy_from_slice(&self.steps[column]);
            let before = dot(&self.scale, &change, &change).sqrt();
            for newer in 0..kept {
                let fraction = dot(&self.scale, &self.orthogonal_changes[newer], &change);
                add(&mut change, &self.orthogonal_changes[newer], -fraction);
                add(&mut step, &self.orthogonal_steps[newer], -fraction);
            }
            let length = dot(&self.scale, &change, &change).sqrt();
            let independent = length > DEPENDENT * before && length.is_finite();
            if independent {
                change.iter_mut().chain(&mut step).for_each(|value| *value /= length);
            }
            self.orthogonal_changes[kept] = change;
            self.orthogonal_steps[kept] = step;
            kept += usize::from(independent);
        }
        kept
    }

    /// One Newton step from `assumed`, whose residual has the size `size`.
    fn newton<C: Coupling>(
        &mut self,
        coupling: &mut C,
        assumed: &mut [f64],
        size: f64,
        solved: &mut Solved,
    ) -> Result<(), C::Trouble> {
        if size > SLOW * self.last_size {
            self.repeated = true;
        }
        self.look_back(coupling, assumed)?;
        self.last_size = size;
        self.last_assumed.copy_from_slice(assumed);
        self.last_residual.copy_from_slice(&self.residual);
        self.direction(coupling, solved)?;
        add(assumed, &self.changed, 1.0);
        Ok(())
    }

    /// Compares the last step with what the derivatives say of it, if there was one.
    fn look_back<C: Coupling>(&mut self, coupling: &mut C, assumed: &[f64]) -> Result<(), C::Trouble> {
        let Self { scale, secants, corrections, last_assumed, residual, last_residual, .. } = self;
        if self.repeated || self.last_size.is_infinite() || *corrections == CORRECTIONS {
            return Ok(());
        }
        let (known, [[secant, missed], ..]) = secants.split_at_mut(*corrections) else { return Ok(()) };
        for (secant, (now, before)) in secant.iter_mut().zip(assumed.iter().zip(last_assumed.iter())) {
            *secant = now - before;
        }
        let square = dot(scale, secant, secant);
        if square > 0.0 && coupling.product(secant, missed)? {
            correct(known, scale, secant, missed);
            for (missed, (now, before)) in missed.iter_mut().zip(residual.iter().zip(last_residual.iter())) {
                *missed = (now - before - *missed) / square;
            }
            *corrections += 1;
        }
        Ok(())
    }

    /// The Newton direction into `changed`.
    fn direction<C: Coupling>(&mut self, coupling: &mut C, solved: &mut Solved) -> Result<(), C::Trouble> {
        let Self {
            krylov,
            right,
            scale,
            last_assumed,
            last_residual,
            trial,
            residual,
            repeated,
            changed,
            secants,
            corrections,
            ..
        } = self;
        // In units of the scale, where one is as large as the other.
        for ((right, residual), scale) in right.iter_mut().zip(last_residual.iter()).zip(scale.iter()) {
            *right = -residual / scale;
        }
        let product = |vector: &[f64], product: &mut [f64]| {
            for ((step, part), scale) in trial.iter_mut().zip(vector).zip(scale.iter()) {
                *step = part * scale;
            }
            let derived = !*repeated && coupling.product(trial, product)?;
            if derived {
                correct(&secants[..*corrections], scale, trial, product);
            } else {
                *repeated = true;
                // The vector has length one in scaled units.
                for (step, base) in trial.iter_mut().zip(last_assumed.iter()) {
                    *step = base + DIFFERENCE * *step;
                }
                coupling.evaluate(trial, residual)?;
                solved.evaluations += 1;
                for ((out, with), without) in
                    product.iter_mut().zip(residual.iter()).zip(last_residual.iter())
                {
                    *out = (with - without) / DIFFERENCE;
                }
            }
            product.iter_mut().zip(scale.iter()).for_each(|(value, scale)| *value /= scale);
            Ok(())
        };
        krylov.try_solve(product, right, changed, ENOUGH)?;
        changed.iter_mut().zip(scale.iter()).for_each(|(value, scale)| *value *= scale);
        Ok(())
    }
}

/// What the secants say that the derivatives miss along `trial`.
fn correct(secants: &[[Vec<f64>; 2]], scale: &[f64], trial: &[f64], product: &mut [f64]) {
    for [secant, missed] in secants {
        add(product, missed, dot(scale, secant, trial));
    }
}

/// In units of `scale`.
fn dot(scale: &[f64], a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).zip(scale).map(|((a, b), scale)| (a / scale) * (b / scale)).sum()
}

fn add(to: &mut [f64], what: &[f64], factor: f64) {
    for (to, what) in to.iter_mut().zip(what) {
        *to += factor * what;
    }
}
