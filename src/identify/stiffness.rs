//! Stiffness of the pin rig's contact from measured natural frequencies, with intervals that say how much of it they tell.

use std::f64::consts::TAU;

use super::WIDE;
use crate::fit::{FitError, Interval, Options, Parameter, Scale, fit};
use crate::system::{PinRig, PinRigModes, StructureError};

/// Bounds of the search, as factors of the rig's own values: far beyond what frequencies can tell.
const STIFFNESS: f64 = 1e6;
const MODULUS: f64 = 2.0;
/// Places of a grid on either side of the given k_t and k_n, and of these the best that are fitted from.
const TANGENTIAL: i32 = 12;
const NORMAL: i32 = 6;
const FITTED: usize = 4;
/// Rise of χ² to the ends of a 95 % interval, and the normal quantile beyond which χ² itself is no chance (99.9 %).
const RISE: f64 = WIDE * WIDE;
const CHANCE: f64 = 3.09;
/// First step towards the end of an interval, of the logarithm; the part of the way to it that is no matter, and divisions at most.
const STEP: f64 = 0.02;
const FINE: f64 = 1e-2;
const DIVISIONS: usize = 60;
/// The end of an interval over its beginning from which on it tells no more than an order of magnitude.
const VAGUE: f64 = 3.0;
/// Width of an interval over that of what was assumed, from which on it gives the assumption back.
const ECHO: f64 = 0.9;
/// Modes beside the beam's own among which those are searched: pendulum, bounce.
const OTHERS: usize = 4;

/// A number with its interval at 95 %.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// The value of the best fit.
    pub value: f64,
    /// Where the frequencies leave it: 0 below and ∞ above where they set no end.
    pub interval: Interval,
    /// Whether they tell it: not to an order of magnitude alone, nor what was assumed of it.
    pub told: bool,
}

/// Stiffness of a contact that sticks.
#[derive(Debug, Clone, PartialEq)]
pub struct ContactStiffness {
    /// Young's modulus of the beam (Pa).
    pub youngs_modulus: Estimate,
    /// k_t (N/m) at the rig's lever.
    pub tangential: Estimate,
    /// k_t r² (N m/rad): what the frequencies see of k_t, whatever the lever.
    pub rotational: Estimate,
    /// k_n (N/m). The frequencies hardly see it: its interval is what is known, the value is not.
    pub normal: Estimate,
    /// Natural frequencies of the fitted rig (Hz).
    pub frequencies: Vec<f64>,
    /// Sum of the squared deviations, that of the modulus among them, over their variances.
    pub chi_square: f64,
    /// Whether it may be chance: beyond its 99.9 % quantile no such rig has these frequencies.
    pub fits: bool,
}

/// What is measured, and how well.
#[derive(Debug, Clone, PartialEq)]
pub struct MeasuredFrequencies {
    /// The first natural frequencies of the beam's own modes (Hz), rising, at least three.
    pub frequencies: Vec<f64>,
    /// Standard deviation of each, as a fraction.
    pub deviation: f64,
    /// Standard deviation of Young's modulus about that of the rig, as a fraction.
    pub modulus_deviation: f64,
}

/// The first `count` natural frequencies (Hz) of the rig's modes that are the beam's own.
///
/// # Errors
/// As [`PinRigModes::new`].
pub fn beam_frequencies(rig: &PinRig, count: usize) -> Result<Vec<f64>, StructureError> {
    let modes = PinRigModes::new(rig, count + OTHERS)?;
    let own = modes.beam_modes();
    Ok(own.into_iter().take(count).map(|mode| modes.angular_frequency()[mode] / TAU).collect())
}

/// Young's modulus, k_t and k_n of the rig from `measured` frequencies, wherever in a wide range about those of `rig`.
///
/// # Errors
/// Fewer than three frequencies or more than the rig has, frequencies that do not rise, deviations that are not positive, a rig without
/// modes.
pub fn contact_stiffness(
    rig: &PinRig,
    measured: &MeasuredFrequencies,
) -> Result<ContactStiffness, FitError<StructureError>> {
    let MeasuredFrequencies { frequencies, deviation, modulus_deviation } = measured;
    let positive = |value: &f64| *value > 0.0 && value.is_finite();
    if frequencies.len() < 3 || !frequencies.iter().all(positive) {
        return Err(FitError::InvalidInput("at least three positive frequencies are needed"));
    }
    if frequencies.windows(2).any(|pair| pair[0] >= pair[1]) {
        return Err(FitError::InvalidInput("the frequencies do not rise"));
    }
    if ![deviation, modulus_deviation].into_iter().all(positive) {
        return Err(FitError::InvalidInput("the deviations are not positive"));
    }
    let own =
        beam_frequencies(rig, frequencies.len()).map_err(|error| FitError::NoStart { first: Some(error) })?;
    if own.len() < frequencies.len() {
        return Err(FitError::InvalidInput("the model does not tell so many modes of the beam"));
    }
    let search = Search { rig, measured };
    let spare = (frequencies.len() - 2) as f64;
    let best = search.best();
    let best = best.ok_or(FitError::InvalidInput("no stiffness within reach gives the rig so many modes"))?;
    let fits = best.chi_square <= quantile(spare);
    let lever = rig.beam.offset * rig.beam.offset;
    let assumed = 2.0 * WIDE * modulus_deviation;
    let intervals: [Interval; 3] = std::array::from_fn(|k| search.interval(&best, k));
    let estimate = |k: usize, factor: f64| {
        let Interval { low, high } = intervals[k];
        let width = (high / low).ln();
        let told = fits && width < VAGUE.ln() && (k > 0 || width < ECHO * assumed);
        Estimate {
            value: factor * best.values[k],
            interval: Interval { low: factor * low, high: factor * high },
            told,
        }
    };
    Ok(ContactStiffness {
        youngs_modulus: estimate(0, 1.0),
        tangential: estimate(1, 1.0),
        rotational: estimate(1, lever),
        normal: estimate(2, 1.0),
        frequencies: beam_frequencies(&with(rig, &best.values), frequencies.len())
            .map_err(|error| FitError::NoStart { first: Some(error) })?,
        chi_square: best.chi_square,
        fits,
    })
}

/// The quantile of χ² of so many degrees of freedom (Wilson and Hilferty 1931).
fn quantile(degrees: f64) -> f64 {
    let ninth = 2.0 / (9.0 * degrees);
    degrees * (1.0 - ninth + CHANCE * ninth.sqrt()).powi(3)
}

/// A fit: modulus, k_t, k_n.
#[derive(Clone, Copy)]
struct Found {
    values: [f64; 3],
    chi_square: f64,
}

struct Search<'a> {
    rig: &'a PinRig,
    measured: &'a MeasuredFrequencies,
}

impl Search<'_> {
    fn given(&self) -> [f64; 3] {
        let [tangential, normal] = self.rig.stuck_stiffness;
        [self.rig.beam.youngs_modulus, tangential, normal]
    }

    fn bounds(&self, k: usize) -> [f64; 2] {
        let reach = if k == 0 { MODULUS } else { STIFFNESS };
        [self.given()[k] / reach, self.given()[k] * reach]
    }

    /// Deviations of frequencies and modulus over their standard deviations.
    fn residual(&self, values: &[f64; 3], out: &mut [f64]) -> Result<(), StructureError> {
        let MeasuredFrequencies { frequencies, deviation, modulus_deviation } = self.measured;
        let count = frequencies.len();
        let found = beam_frequencies(&with(self.rig, values), count)?;
        // A mode that is lost to the mass on its string is as far away as can be.
        let relative = |(k, f): (usize, &f64)| found.get(k).map_or(-1.0, |found| found / f - 1.0) / deviation;
        out.iter_mut().zip(frequencies.iter().enumerate().map(relative)).for_each(|(out, r)| *out = r);
        out[count] = (values[0] / self.rig.beam.youngs_modulus - 1.0) / modulus_deviation;
        Ok(())
    }

    /// The fit from `start` on, number `held` where it is.
    fn from(&self, start: &[f64; 3], held: Option<usize>) -> Option<Found> {
        let free: Vec<usize> = (0..3).filter(|k| Some(*k) != held).collect();
        let whole = |values: &[f64]| {
            let mut all = *start;
            free.iter().zip(values).for_each(|(k, value)| all[*k] = *value);
            all
        };
        let parameter = |k: &usize| {
            let [lower, upper] = self.bounds(*k);
            Parameter { start: start[*k].clamp(lower, upper), lower, upper, scale: Scale::Logarithmic }
        };
        let parameters: Vec<Parameter> = free.iter().map(parameter).collect();
        let options = Options { tolerance: 1e-6, ..Options::default() };
        let residual = |values: &[f64], out: &mut [f64]| self.residual(&whole(values), out);
        let found = fit(residual, self.measured.frequencies.len() + 1, &parameters, &options).ok()?;
        let chi_square = found.residuals.iter().map(|r| r * r).sum();
        Some(Found { values: whole(&found.parameters), chi_square })
    }

    /// The best fit, from the given values and from the best of a grid of both stiffnesses.
    fn best(&self) -> Option<Found> {
        let given = self.given();
        let grid =
            |count: i32| (-count..=count).map(move |k| STIFFNESS.powf(f64::from(k) / f64::from(count)));
        let places =
            grid(TANGENTIAL).flat_map(|t| grid(NORMAL).map(move |n| [given[0], t * given[1], n * given[2]]));
        let mut out = vec![0.0; self.measured.frequencies.len() + 1];
        let mut seen: Vec<([f64; 3], f64)> = Vec::new();
        for values in places {
            if self.residual(&values, &mut out).is_ok() {
                seen.push((values, out.iter().map(|r| r * r).sum()));
            }
        }
        seen.sort_by(|a, b| a.1.total_cmp(&b.1));
        let starts = std::iter::once(given).chain(seen.iter().take(FITTED).map(|(values, _)| *values));
        starts
            .filter_map(|start| self.from(&start, None))
            .min_by(|a, b| a.chi_square.total_cmp(&b.chi_square))
    }

    /// Where number `k` may be, whatever the others are: χ² rises by less than at the ends of 95 %.
    fn interval(&self, best: &Found, k: usize) -> Interval {
        let ends = [-1.0, 1.0].map(|side| self.end(best, k, side));
        Interval { low: ends[0].unwrap_or(0.0), high: ends[1].unwrap_or(f64::INFINITY) }
    }

    /// The end on one side; `None` beyond the bound.
    fn end(&self, best: &Found, k: usize, side: f64) -> Option<f64> {
        let [lower, upper] = self.bounds(k);
        let room = if side < 0.0 { best.values[k] / lower } else { upper / best.values[k] }.ln();
        let value = |away: f64| best.values[k] * (side * away).exp();
        let at = |near: &Found, away: f64| {
            let mut start = near.values;
            start[k] = value(away);
            self.from(&start, Some(k))
        };
        // The root of the rise, over that at the end: about proportional to the way.
        let far = |found: &Option<Found>| {
            let rise = found.map_or(f64::INFINITY, |found| found.chi_square - best.chi_square);
            (rise.max(0.0) / RISE).sqrt()
        };
        let (mut near, mut inside, mut outside) = (*best, [0.0, 0.0], STEP);
        let mut beyond = loop {
            if outside > room {
                return None;
            }
            let found = at(&near, outside);
            match (far(&found), found) {
                (there, Some(found)) if there < 1.0 => {
                    (near, inside, outside) = (found, [outside, there], 2.0 * outside)
                }
                (there, _) => break there,
            }
        };
        for _ in 0..DIVISIONS {
            if outside - inside[0] <= FINE * outside {
                break;
            }
            let part = (1.0 - inside[1]) / (beyond - inside[1]);
            let part = if part.is_finite() { part.clamp(0.1, 0.9) } else { 0.5 };
            let middle = inside[0] + part * (outside - inside[0]);
            let found = at(&near, middle);
            match (far(&found), found) {
                (there, Some(found)) if there < 1.0 => (near, inside) = (found, [middle, there]),
                (there, _) => (beyond, outside) = (there, middle),
            }
        }
        Some(value(inside[0]))
    }
}

/// The rig with another modulus, k_t and k_n.
fn with(rig: &PinRig, values: &[f64; 3]) -> PinRig {
    let mut rig = rig.clone();
    rig.beam.youngs_modulus = values[0];
    rig.stuck_stiffness = [values[1], values[2]];
    rig
}
