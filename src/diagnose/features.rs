//! What the views of the measurements and of the residual show, as numbers.

use super::loops::{self, Measured};
use super::select::{Search, State};
use crate::effects::Features;
use crate::measure::Record;
use crate::model::Structure;

/// Of the measurements, and of the residual of the model refitted without effects on the selecting records.
pub(super) fn of(search: &Search, base: &State) -> Features {
    let bench = search.bench;
    let mut found = Features::default();
    let (mut by_velocity, mut by_cube, mut by_rate, mut by_value) =
        (Correlation::default(), Correlation::default(), Correlation::default(), Correlation::default());
    let (mut normal_by_velocity, mut normal_by_cube) = (Correlation::default(), Correlation::default());
    let (mut sum, mut square, mut count) = (0.0, 0.0, 0.0);
    for scored in &base.scored {
        let lane = &bench.lanes[scored.record];
        for (name, range) in &lane.channels {
            let measured = &lane.measured[range.clone()];
            // Measured minus predicted: what the model lacks.
            let residual: Vec<f64> = scored.residuals[range.clone()].iter().map(|r| -r).collect();
            for (i, r) in residual.iter().enumerate() {
                sum += r;
                square += r * r;
                count += 1.0;
                by_value.add(*r, measured[i]);
                if i > 0 && i + 1 < measured.len() {
                    by_rate.add(*r, measured[i + 1] - measured[i - 1]);
                }
            }
            let motion = |name: &str| lane.record.channel(name).map(|channel| channel.values.as_slice());
            match *name {
                "force" => follow(&residual, motion("displacement"), &mut by_velocity, &mut by_cube),
                "normal_load" => {
                    follow(
                        &residual,
                        motion("normal_displacement"),
                        &mut normal_by_velocity,
                        &mut normal_by_cube,
                    );
                }
                _ => {}
            }
        }
    }
    if count > 0.0 && square > 0.0 {
        found.residual_mean = Some(sum / count / f64::sqrt(square / count));
    }
    found.residual_by_velocity = by_velocity.value();
    found.residual_by_cube = by_cube.value();
    found.residual_by_rate = by_rate.value();
    found.residual_by_value = by_value.value();
    found.normal_residual_by_velocity = normal_by_velocity.value();
    found.normal_residual_by_cube = normal_by_cube.value();
    if matches!(base.fitted.model.structure, Structure::Prescribed) {
        let seen = search.parts.seen();
        let record = |index: &usize| -> &Record { bench.lanes[*index].record };
        let measured: Vec<Measured> = seen.iter().filter_map(|index| Measured::of(record(index))).collect();
        loops::fill(&measured, &mut found);
    }
    found
}

/// Adds a residual against the rate of a motion, and against its cube with the linear part removed.
fn follow(residual: &[f64], motion: Option<&[f64]>, rate: &mut Correlation, cube: &mut Correlation) {
    let Some(motion) = motion else { return };
    let power = |exponent: i32| motion.iter().map(|u| u.powi(exponent)).sum::<f64>();
    let linear = power(4) / power(2).max(f64::MIN_POSITIVE);
    for (i, r) in residual.iter().enumerate() {
        if i > 0 && i + 1 < motion.len() {
            rate.add(*r, motion[i + 1] - motion[i - 1]);
        }
        cube.add(*r, motion[i].powi(3) - linear * motion[i]);
    }
}

/// Sums of a correlation.
#[derive(Default)]
pub(super) struct Correlation {
    count: f64,
    x: f64,
    y: f64,
    xx: f64,
    xy: f64,
    yy: f64,
}

impl Correlation {
    pub(super) fn add(&mut self, x: f64, y: f64) {
        self.count += 1.0;
        self.x += x;
        self.y += y;
        self.xx += x * x;
        self.xy += x * y;
        self.yy += y * y;
    }

    pub(super) fn value(&self) -> Option<f64> {
        let centred = |product: f64, a: f64, b: f64| product - a * b / self.count;
        let size = (centred(self.xx, self.x, self.x) * centred(self.yy, self.y, self.y)).sqrt();
        (self.count > 2.0 && size > 1e-9 * (self.xx * self.yy).sqrt())
            .then(|| centred(self.xy, self.x, self.y) / size)
    }
}
