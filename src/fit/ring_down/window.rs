//! One vibration in a window: amplitude, frequency and damping in its middle, and their slopes.
//!
//! `y = exp(a₁ τ + a₂ τ²) (a cos θ + b sin θ) + c` with `θ = φ₁ τ + φ₂ τ²`, τ from −1 to 1, is fitted by least squares under a
//! Hann weight, which keeps out vibrations of other frequencies.

use std::f64::consts::{PI, TAU};

use nalgebra::{SMatrix, SVector};

/// Unknowns: a₁, a₂, φ₁, φ₂, a, b, c.
const UNKNOWNS: usize = 7;
const STEPS: usize = 40;
const TOLERANCE: f64 = 1e-10;
/// Lines beside the vibration that tell the noise about it: from the first on, in widths of a line of the window.
const BESIDE: f64 = 2.5;
const LINES: i32 = 6;
/// They lie nearer than this to the vibration's frequency, as a fraction of it: its harmonics are no noise.
const NEAR: f64 = 0.7;

/// What a window shows, in samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Fitted {
    /// Its middle, counted from the first sample.
    pub middle: f64,
    pub length: f64,
    /// Amplitude there, in the channel's unit, and its standard deviation by noise.
    pub amplitude: f64,
    pub amplitude_error: f64,
    /// Phase over time (rad), its standard deviation, and both of its slope over time.
    pub speed: f64,
    pub speed_error: f64,
    pub speed_slope: [f64; 2],
    /// −d ln(amplitude)/dt, its standard deviation, and both of its slope over time.
    pub rate: f64,
    pub rate_error: f64,
    pub rate_slope: [f64; 2],
    /// Degrees of freedom by which the noise is known.
    pub freedom: usize,
}

type Row = SVector<f64, UNKNOWNS>;
type Square = SMatrix<f64, UNKNOWNS, UNKNOWNS>;

/// A stretch of samples with its weights.
pub(super) struct Window<'a> {
    values: &'a [f64],
    /// τ of each, and its weight.
    places: Vec<(f64, f64)>,
    /// Its middle, counted from the first of all samples, and half of its length.
    middle: f64,
    half: f64,
}

impl<'a> Window<'a> {
    /// `length` samples from `first` on, as far as there are.
    pub fn new(all: &'a [f64], first: usize, length: usize) -> Self {
        let values = &all[first..(first + length).min(all.len())];
        let half = 0.5 * values.len() as f64;
        Self::weighted(values, first, first as f64 + half - 0.5, half)
    }

    /// The samples up to `half` away from `middle`, as far as there are.
    pub fn around(all: &'a [f64], middle: f64, half: f64) -> Self {
        let first = ((middle - half).ceil().max(0.0) as usize).min(all.len());
        let end = ((middle + half).floor().max(0.0) as usize + 1).clamp(first, all.len());
        Self::weighted(&all[first..end], first, middle, half)
    }

    fn weighted(values: &'a [f64], first: usize, middle: f64, half: f64) -> Self {
        let own_middle = middle - first as f64;
        let place = |index: usize| {
            let tau = (index as f64 - own_middle) / half;
            (tau, 0.5 * (1.0 + (PI * tau).cos()))
        };
        Self { values, places: (0..values.len()).map(place).collect(), middle, half }
    }

    /// Sum of squares, its gradient and curvature at `x`.
    fn sums(&self, x: &Row) -> (f64, Row, Square) {
        let (mut cost, mut gradient, mut curvature) = (0.0, Row::zeros(), Square::zeros());
        for (value, &(tau, weight)) in self.values.iter().zip(&self.places) {
            let (predicted, row) = model(x, tau);
            let residual = predicted - value;
            cost += weight * residual * residual;
            gradient += row * (weight * residual);
            curvature.ger(weight, &row, &row, 1.0);
        }
        (cost, gradient, curvature)
    }

    /// The best linear part at a given course of amplitude and phase.
    fn linear(&self, mut x: Row) -> Option<(f64, Row)> {
        x[4] = 0.0;
        x[5] = 0.0;
        x[6] = 0.0;
        let (_, gradient, curvature) = self.sums(&x);
        let part = curvature.fixed_view::<3, 3>(4, 4).into_owned();
        let step = part.lu().solve(&(-gradient.fixed_rows::<3>(4)))?;
        (0..3).for_each(|k| x[4 + k] = step[k]);
        Some((self.sums(&x).0, x))
    }

    /// The fit from a guess of the speed and its slope, and of the rate, all by samples; `around` are factors of the speed
    /// that are tried.
    pub fn fit(&self, guess: [f64; 3], around: &[f64]) -> Option<Fitted> {
        let x = self.solve(guess, around)?;
        self.told(&x, self.noise(&x))
    }

    /// The same of samples without noise.
    pub fn fit_exact(&self, guess: [f64; 3]) -> Option<Fitted> {
        self.told(&self.solve(guess, &[1.0])?, (0.0, 1))
    }

    fn solve(&self, [speed, slope, rate]: [f64; 3], around: &[f64]) -> Option<Row> {
        let half = self.half;
        let start = |factor: &f64| {
            let mut x = Row::zeros();
            (x[0], x[2], x[3]) = (-rate * half, factor * speed * half, 0.5 * slope * half * half);
            self.linear(x)
        };
        let (_, mut x) = around.iter().filter_map(start).min_by(|a, b| a.0.total_cmp(&b.0))?;
        let (mut cost, mut gradient, mut curvature) = self.sums(&x);
        let mut damping = 1e-3;
        for _ in 0..STEPS {
            let mut damped = curvature;
            (0..UNKNOWNS).for_each(|k| damped[(k, k)] *= 1.0 + damping);
            let step = damped.lu().solve(&-gradient)?;
            let trial = x + step;
            let reached = self.sums(&trial);
            if reached.0.is_finite() && reached.0 <= cost {
                let done = cost - reached.0 <= TOLERANCE * cost;
                (x, damping) = (trial, (0.1 * damping).max(1e-12));
                (cost, gradient, curvature) = reached;
                if done {
                    break;
                }
            } else {
                damping *= 10.0;
                if damping > 1e8 {
                    break;
                }
            }
        }
        Some(x)
    }

    /// What the solution says under this noise (standard deviation, degrees of freedom).
    fn told(&self, x: &Row, (noise, freedom): (f64, usize)) -> Option<Fitted> {
        let half = self.half;
        let (mut curvature, mut squares) = (Square::zeros(), Square::zeros());
        for &(tau, weight) in &self.places {
            let (_, row) = model(x, tau);
            curvature.ger(weight, &row, &row, 1.0);
            squares.ger(weight * weight, &row, &row, 1.0);
        }
        let inverse = curvature.try_inverse()?;
        let covariance = inverse * squares * inverse * (noise * noise);
        let amplitude = x[4].hypot(x[5]);
        let error = |k: usize| covariance[(k, k)].max(0.0).sqrt();
        let found = Fitted {
            middle: self.middle,
            length: 2.0 * half,
            amplitude,
            amplitude_error: error(4).max(error(5)),
            speed: x[2] / half,
            speed_slope: [x[3], error(3)].map(|slope| 2.0 * slope / (half * half)),
            speed_error: error(2) / half,
            rate: -x[0] / half,
            rate_error: error(0) / half,
            rate_slope: [-x[1], error(1)].map(|slope| 2.0 * slope / (half * half)),
            freedom,
        };
        [found.amplitude, found.speed, found.rate, found.speed_error]
            .iter()
            .all(|x| x.is_finite())
            .then_some(found)
    }

    /// Standard deviation of white noise that has as much as the residual beside the vibration's frequency, and its degrees
    /// of freedom.
    fn noise(&self, x: &Row) -> (f64, usize) {
        let left = |(value, &(tau, _)): (&f64, &(f64, f64))| model(x, tau).0 - value;
        let residual: Vec<f64> = self.values.iter().zip(&self.places).map(left).collect();
        let width = TAU / self.values.len() as f64;
        let speed = x[2] / self.half;
        let squares: f64 = self.places.iter().map(|(_, weight)| weight.powi(2)).sum();
        let power = |line: f64| {
            let (mut cosine, mut sine) = (0.0, 0.0);
            for (index, residual) in residual.iter().enumerate() {
                let (weight, phase) = (self.places[index].1, line * index as f64);
                cosine += weight * residual * phase.cos();
                sine += weight * residual * phase.sin();
            }
            (cosine * cosine + sine * sine) / squares
        };
        let near = |line: &f64| (line / speed - 1.0).abs() < NEAR;
        let beside = (0..LINES).map(|line| BESIDE + f64::from(line)).flat_map(|place| [-place, place]);
        let lines: Vec<f64> = beside.map(|place| speed + place * width).filter(near).map(power).collect();
        if lines.is_empty() {
            let (sum, freedom) = (residual.iter().map(|r| r * r).sum::<f64>(), residual.len() - UNKNOWNS);
            return ((sum / freedom as f64).sqrt(), freedom);
        }
        // Each has two, of which neighbours share a good part.
        ((lines.iter().sum::<f64>() / lines.len() as f64).sqrt(), lines.len())
    }
}

/// The value at τ, and its derivatives.
fn model(x: &Row, tau: f64) -> (f64, Row) {
    let growth = (x[0] * tau + x[1] * tau * tau).exp();
    let (sin, cos) = (x[2] * tau + x[3] * tau * tau).sin_cos();
    let (cosine, sine) = (growth * cos, growth * sin);
    let value = x[4] * cosine + x[5] * sine;
    let turned = x[5] * cosine - x[4] * sine;
    let square = tau * tau;
    let row = [tau * value, square * value, tau * turned, square * turned, cosine, sine, 1.0];
    (value + x[6], Row::from_column_slice(&row))
}
