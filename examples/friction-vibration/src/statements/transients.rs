//! The paper's deviations between harmonic balance and time integration, held against transients that had not died out.

use std::f64::consts::TAU;

use stickslip_report::document::scientific;

use super::{Statement, Verdict};
use crate::Failure;
use crate::system::{FORCE, System, X, Y, fine};
use crate::time_domain;

/// Periods from rest that are looked at.
const PERIODS: usize = 40;
/// Time after which all of the paper's deviations would come about together (s).
const FIXED_TIME: f64 = 75.0;

/// How a quantity of the motion from rest differs from the periodic state, period by period (%).
struct Transient {
    angular_frequency: f64,
    deviation: Vec<f64>,
    /// What the paper states (%).
    stated: f64,
}

impl Transient {
    fn new(angular_frequency: f64, stated: f64, values: impl Iterator<Item = f64>, periodic: f64) -> Self {
        let deviation = values.map(|value| 100.0 * (value / periodic - 1.0)).collect();
        Self { angular_frequency, deviation, stated }
    }

    /// Deviation in the period of that number.
    fn after(&self, periods: usize) -> f64 {
        self.deviation[periods - 1]
    }

    /// The deviations in some periods, as a list.
    fn list(&self, periods: impl IntoIterator<Item = usize>) -> String {
        list(&periods.into_iter().map(|periods| self.after(periods)).collect::<Vec<_>>())
    }

    /// Number of the period whose deviation, of either sign, comes nearest to what the paper states.
    fn nearest(&self) -> usize {
        let off = |periods: &usize| (self.after(*periods).abs() - self.stated).abs();
        (2..=PERIODS).min_by(|a, b| off(a).total_cmp(&off(b))).unwrap_or(PERIODS)
    }

    /// Periods within the fixed time, to the nearest whole one.
    fn periods_of_fixed_time(&self) -> usize {
        ((FIXED_TIME * self.angular_frequency / TAU).round() as usize).clamp(1, PERIODS)
    }
}

pub fn statements(system: &System) -> Result<[Statement; 2], Failure> {
    let (first, second) = (0.5, 1.3);
    let limit = time_domain::periodic(system, FORCE, second, false)?;
    let balance = system.point(FORCE, second, &fine())?;
    let rest = time_domain::from_rest(system, FORCE, second, PERIODS)?;
    let relative = |node: usize| (balance.amplitude[node] / limit.amplitude[node] - 1.0).abs();
    let exact = relative(X).max(relative(Y));
    let of = |node: usize, stated: f64| {
        let values = rest.iter().map(|period| period.amplitude[node]);
        Transient::new(second, stated, values, balance.amplitude[node])
    };
    let (x, y) = (of(X, 2.0), of(Y, 3.4));
    let amplitudes = format!(
        "Against the periodic state the deviation of harmonic balance is {}. From rest, at ω = {second} rad/s, \
         {} in x and {} in y remain after 12, 14, 16, 18 and 40 periods. Deviations of that size would be consistent with an \
         unfinished transient.",
        scientific(exact),
        x.list([12, 14, 16, 18, PERIODS]),
        y.list([12, 14, 16, 18, PERIODS]),
    );
    let limit = time_domain::periodic(system, FORCE, first, false)?;
    let balance = system.point(FORCE, first, &fine())?;
    let rest = time_domain::from_rest(system, FORCE, first, PERIODS)?;
    let loops = (balance.dissipated_energy() / limit.dissipated - 1.0).abs();
    let values = rest.iter().map(|period| period.dissipated);
    let energy = Transient::new(first, 1.8, values, balance.dissipated_energy());
    let energies = format!(
        "Against the periodic state the deviation of harmonic balance is {}. From rest, at ω = {first} rad/s, the \
         loop’s energy is off by {} after 2, 3, 4, 5, 6 and 14 periods. {}",
        scientific(loops),
        energy.list([2, 3, 4, 5, 6, 14]),
        duration(&x, &y, &energy)
    );
    Ok([
        Statement {
            figure: "4, 5",
            said: "Harmonic balance and time integration differ by 2 % in the second resonance of m1 and 3.4 % in that of m2.",
            found: amplitudes,
            verdict: Verdict::of(exact > 0.01),
        },
        Statement {
            figure: "6",
            said: "Their dissipated energies at ω = 0.5 rad/s differ by 1.8 %.",
            found: energies,
            verdict: Verdict::of(loops > 0.01),
        },
    ])
}

/// Which duration of an unfinished transient would give the deviations that the paper states.
fn duration(x: &Transient, y: &Transient, energy: &Transient) -> String {
    let (slow, fast) = (energy.periods_of_fixed_time(), x.periods_of_fixed_time());
    let time = |periods: usize, one: &Transient| periods as f64 * TAU / one.angular_frequency;
    format!(
        "The stated deviations come nearest after {} periods in x, {} in y and {} here: no one number of periods explains all \
         three. One fixed time of about {FIXED_TIME:.0} s comes nearer: {slow} periods here ({:.1} s) leave {} of the energy, \
         {fast} periods at ω = {} rad/s ({:.1} s) leave {} in x, though {} in y, where the stated deviation belongs to \
         {:.1} s.",
        x.nearest(),
        y.nearest(),
        energy.nearest(),
        time(slow, energy),
        energy.list([slow]),
        x.angular_frequency,
        time(fast, x),
        x.list([fast]),
        y.list([fast]),
        time(y.nearest(), y),
    )
}

/// Percentages as a list.
fn list(values: &[f64]) -> String {
    let all: Vec<String> = values
        .iter() // Adding zero makes a rounded −0 positive.
        .map(|value| format!("{:+.2}\u{a0}%", (100.0 * value).round() / 100.0 + 0.0).replace('-', "−"))
        .collect();
    all.join(", ")
}
