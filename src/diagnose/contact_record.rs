//! A contact driven along a measured displacement.

use crate::contact::{ContactLaw, Inputs, periodic_state};
use crate::measure::{Record, Regime};

/// Share of a record by which an unknown initial force is judged: long enough to see it, and no longer,
/// since a contact that slips forgets it.
const INITIAL_SHARE: f64 = 0.25;
/// Candidates for the initial force before the refinement: the error has several minima in it when the
/// record starts with small loops.
const INITIAL_CANDIDATES: usize = 17;
/// Golden-section steps after that; each shrinks the bracket by 0.618.
const INITIAL_REFINEMENTS: usize = 24;

/// The contact force (N) that `law` predicts at every sample of `record`, under a constant `normal_load` (N).
pub(super) fn predict(law: &dyn ContactLaw, normal_load: f64, record: &Record) -> Result<Vec<f64>, String> {
    let displacement = &record.channel("displacement").ok_or("there is no `displacement` column")?.values;
    let velocity = match record.channel("velocity") {
        Some(channel) => channel.values.clone(),
        None => {
            differentiate(&record.channel("time").ok_or("there is no `time` column")?.values, displacement)
        }
    };
    let path = Path { law, normal_load, displacement, velocity: &velocity };
    let mut start = vec![0.0; law.state_len()];
    match record.regime {
        Regime::FromRest => law.set_state(0.0, normal_load, 0.0, &mut start),
        Regime::Steady => {
            law.set_state(displacement[0], normal_load, 0.0, &mut start);
            let load = vec![normal_load; displacement.len()];
            periodic_state(law, displacement, &load, &mut start).map_err(|error| error.to_string())?;
        }
        Regime::UnknownInitialState => {
            let measured = &record.channel("force").ok_or("there is no `force` column")?.values;
            let force = path.initial_force(measured);
            law.set_state(displacement[0], normal_load, force, &mut start);
        }
        Regime::Backbone => {
            return Err("a backbone table belongs to a beam or an oscillator, not to a bare contact".into());
        }
    }
    Ok(path.forces(&start, displacement.len()))
}

struct Path<'a> {
    law: &'a dyn ContactLaw,
    normal_load: f64,
    displacement: &'a [f64],
    velocity: &'a [f64],
}

impl Path<'_> {
    fn forces(&self, start: &[f64], samples: usize) -> Vec<f64> {
        let mut forces = Vec::with_capacity(samples);
        self.walk(start, samples, |_, force| forces.push(force));
        forces
    }

    fn walk(&self, start: &[f64], samples: usize, mut visit: impl FnMut(usize, f64)) {
        let mut state = start.to_vec();
        let mut next = start.to_vec();
        for index in 0..samples {
            let inputs = Inputs {
                displacement: self.displacement[index],
                velocity: self.velocity[index],
                normal_load: self.normal_load,
            };
            visit(index, self.law.step(&state, inputs, &mut next).force);
            std::mem::swap(&mut state, &mut next);
        }
    }

    /// The force at the first sample that fits the beginning of the record best: a nuisance of the
    /// record, not a parameter of the model.
    fn initial_force(&self, measured: &[f64]) -> f64 {
        let samples = ((measured.len() as f64 * INITIAL_SHARE) as usize).max(2).min(measured.len());
        let mut start = vec![0.0; self.law.state_len()];
        let mut misfit = |force: f64| {
            self.law.set_state(self.displacement[0], self.normal_load, force, &mut start);
            let mut sum = 0.0;
            self.walk(&start, samples, |index, force| sum += (force - measured[index]).powi(2));
            sum
        };
        let limit = self.law.limit(self.normal_load);
        let spacing = 2.0 * limit / (INITIAL_CANDIDATES - 1) as f64;
        let best = (0..INITIAL_CANDIDATES)
            .map(|index| -limit + spacing * index as f64)
            .map(|force| (misfit(force), force))
            .min_by(|left, right| left.0.total_cmp(&right.0))
            .map_or(0.0, |(_, force)| force);
        golden_section((best - spacing).max(-limit), (best + spacing).min(limit), &mut misfit)
    }
}

fn golden_section(mut low: f64, mut high: f64, cost: &mut impl FnMut(f64) -> f64) -> f64 {
    let ratio = (5.0_f64.sqrt() - 1.0) / 2.0;
    let mut inner = [high - ratio * (high - low), low + ratio * (high - low)];
    let mut costs = [cost(inner[0]), cost(inner[1])];
    for _ in 0..INITIAL_REFINEMENTS {
        if costs[0] <= costs[1] {
            high = inner[1];
            inner = [high - ratio * (high - low), inner[0]];
            costs = [cost(inner[0]), costs[0]];
        } else {
            low = inner[0];
            inner = [inner[1], low + ratio * (high - low)];
            costs = [costs[1], cost(inner[1])];
        }
    }
    if costs[0] <= costs[1] { inner[0] } else { inner[1] }
}

/// Central differences of `values` over `time`, one-sided at the ends.
fn differentiate(time: &[f64], values: &[f64]) -> Vec<f64> {
    let last = time.len() - 1;
    (0..=last)
        .map(|index| {
            let (before, after) = (index.saturating_sub(1), (index + 1).min(last));
            let span = time[after] - time[before];
            if span > 0.0 { (values[after] - values[before]) / span } else { 0.0 }
        })
        .collect()
}
