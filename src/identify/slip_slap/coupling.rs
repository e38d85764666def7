//! How far the limit of friction follows the normal force.
//!
//! Sliders side by side, whose parts are free and positive, describe any contact that slips by Masing's rule. Each yields at a limit
//! `μ [N0 + κ (N_c(t) − N0)]`: κ = 0 is a constant limit, κ = 1 Coulomb's law under the identified normal force. κ and the
//! sliders' parts are fitted to the identified tangential forces of all records together. How much of what the constant limit
//! leaves the following one explains says how much of the limit's variation the normal force explains.

use std::f64::consts::TAU;

use nalgebra::{DMatrix, DVector};

use crate::contact::{ContactLaw, Inputs, Jenkins};
use crate::identify::ContactPeriod;
use crate::identify::measured::half_range;
use crate::numeric::fourier::{from_samples, value};
use crate::numeric::nonnegative::nonnegative;

/// Samples of a period, and periods until the motion repeats.
const SAMPLES: usize = 512;
const PERIODS: usize = 2;
/// Motions at which sliders yield, over the largest of all records: the first ones never do.
const KNOTS: usize = 14;
const WIDEST: f64 = 4.0;
const SPACING: f64 = 1.5;
/// Values of κ that are tried.
const LEAST: f64 = -0.5;
const MOST: f64 = 2.0;
const TRIED: usize = 50;
/// Square of the standard errors of a 95 % interval.
const WIDE: f64 = 1.96 * 1.96;

/// How far the limit of the tangential force follows the normal force.
#[derive(Debug, Clone, PartialEq)]
pub struct Coupling {
    /// κ: relative change of the limit over that of the normal force; 0 where the limit is constant, 1 where it is in
    /// proportion.
    pub following: f64,
    /// Its 95 % interval.
    pub interval: [f64; 2],
    /// Fraction of what a constant limit leaves of S that a following one explains, by squares; 0 where the interval holds 0.
    pub explained: f64,
    /// Residual of S over S, root mean square: by a constant limit, and by the one that follows.
    pub left: [f64; 2],
}

/// The coupling that the contact's periods along and across the beam show under `preload` (N); `None` where no sliders describe
/// them.
pub(super) fn coupling(along: &[ContactPeriod], across: &[ContactPeriod], preload: f64) -> Option<Coupling> {
    let sliding = Sliding::new(along, across, preload);
    let step = (MOST - LEAST) / TRIED as f64;
    let places = (0..=TRIED).map(|k| LEAST + step * k as f64);
    let tried = places.map(|following| Some((following, sliding.squares_left(following)?)));
    let tried: Vec<(f64, f64)> = tried.collect::<Option<_>>()?;
    let constant = sliding.squares_left(0.0)?;
    let best = (0..tried.len()).min_by(|a, b| tried[*a].1.total_cmp(&tried[*b].1))?;
    let following = lowest(&tried, best, step);
    let least = sliding.squares_left(following)?.min(tried[best].1);
    let freedom = sliding.forces.len().saturating_sub(KNOTS + 1).max(1) as f64;
    let outside = |place: &usize| tried[*place].1 > least * (1.0 + WIDE / freedom);
    let low = (0..best).rev().find(outside).map_or(LEAST, |place| tried[place].0);
    let high = (best + 1..tried.len()).find(outside).map_or(MOST, |place| tried[place].0);
    let size = sliding.forces.norm_squared();
    Some(Coupling {
        following,
        interval: [low, high],
        explained: if low > 0.0 || high < 0.0 { 1.0 - least / constant } else { 0.0 },
        left: [constant, least].map(|squares| (squares / size).sqrt()),
    })
}

/// Where a parabola through the best value tried and its neighbours is lowest.
fn lowest(tried: &[(f64, f64)], best: usize, step: f64) -> f64 {
    if best == 0 || best + 1 == tried.len() {
        return tried[best].0;
    }
    let [before, at, after] = [best - 1, best, best + 1].map(|place| tried[place].1);
    let bend = before - 2.0 * at + after;
    if bend > 0.0 { tried[best].0 + 0.5 * step * (before - after) / bend } else { tried[best].0 }
}

/// The motion under which sliders slip, and the force that they are to describe.
struct Sliding {
    preload: f64,
    /// Motions (m) at which the sliders yield under the preload.
    knots: Vec<f64>,
    /// Per record: harmonics of the force; displacement (m), velocity (m/s) and N (N) over a period.
    records: Vec<(usize, Vec<[f64; 3]>)>,
    /// Coefficients of the tangential forces but the means, record after record.
    forces: DVector<f64>,
}

impl Sliding {
    fn new(along: &[ContactPeriod], across: &[ContactPeriod], preload: f64) -> Self {
        let widest = along.iter().map(half_range).fold(0.0, f64::max);
        let record = |(along, across): (&ContactPeriod, &ContactPeriod)| {
            let at = |k: usize| {
                let phase = TAU * k as f64 / SAMPLES as f64;
                [&along.displacement, &along.velocity, &across.force].map(|one| value(one, phase))
            };
            (along.force.len() / 2, (0..SAMPLES).map(at).collect())
        };
        let forces = along.iter().flat_map(|period| period.force[1..].iter().copied());
        Self {
            preload,
            knots: (0..KNOTS as i32).map(|k| WIDEST * widest / SPACING.powi(k)).collect(),
            records: along.iter().zip(across).map(record).collect(),
            forces: DVector::from_vec(forces.collect()),
        }
    }

    /// Sum of squares (N²) that the best sliders leave of the tangential forces, limits following by so much.
    fn squares_left(&self, following: f64) -> Option<f64> {
        let column = |knot: &f64| {
            let mut column = Vec::with_capacity(self.forces.len());
            for (harmonics, samples) in &self.records {
                let force = self.slider(samples, [*knot, following])?;
                column.extend_from_slice(&from_samples(&force, 1, *harmonics)[1..]);
            }
            Some(DVector::from_vec(column))
        };
        let columns: Vec<DVector<f64>> = self.knots.iter().map(column).collect::<Option<_>>()?;
        let matrix = DMatrix::from_columns(&columns);
        let (parts, _) = nonnegative(&matrix, &self.forces)?;
        Some((&matrix * parts - &self.forces).norm_squared())
    }

    /// Force over a period of a slider of unit stiffness that yields at `knot` (m) under the preload.
    fn slider(&self, samples: &[[f64; 3]], [knot, following]: [f64; 2]) -> Option<Vec<f64>> {
        let law = Jenkins::new(1.0, knot / self.preload).ok()?;
        let mut state = vec![0.0; law.state_len()];
        let mut force = Vec::new();
        for _ in 0..PERIODS {
            let step = |[displacement, velocity, normal]: &[f64; 3]| {
                let normal_load = (self.preload - following * normal).max(0.0);
                law.advance(
                    &mut state,
                    Inputs { displacement: *displacement, velocity: *velocity, normal_load },
                )
            };
            force = samples.iter().map(step).collect();
        }
        Some(force)
    }
}
