//! What the views of the measurements and of the residual show, as numbers.

use super::select::{Search, State};
use crate::effects::Features;

/// Of the measurements, and of the residual of the model refitted without effects on the selecting records.
pub(super) fn of(search: &Search, base: &State) -> Features {
    let bench = search.bench;
    let mut found = Features::default();
    let (mut by_velocity, mut by_cube, mut by_rate, mut by_value) =
        (Correlation::default(), Correlation::default(), Correlation::default(), Correlation::default());
    let (mut sum, mut square, mut count) = (0.0, 0.0, 0.0);
    for scored in &base.scored {
        let lane = &bench.lanes[scored.record];
        let displacement = lane.record.channel("displacement").map(|channel| channel.values.as_slice());
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
                if let Some(u) = displacement.filter(|_| *name == "force") {
                    if i > 0 && i + 1 < u.len() {
                        by_velocity.add(*r, u[i + 1] - u[i - 1]);
                    }
                    by_cube.add(*r, u[i].powi(3));
                }
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
    found
}

/// Sums of a correlation.
#[derive(Default)]
struct Correlation {
    count: f64,
    x: f64,
    y: f64,
    xx: f64,
    xy: f64,
    yy: f64,
}

impl Correlation {
    fn add(&mut self, x: f64, y: f64) {
        self.count += 1.0;
        self.x += x;
        self.y += y;
        self.xx += x * x;
        self.xy += x * y;
        self.yy += y * y;
    }

    fn value(&self) -> Option<f64> {
        let centred = |product: f64, a: f64, b: f64| product - a * b / self.count;
        let size = (centred(self.xx, self.x, self.x) * centred(self.yy, self.y, self.y)).sqrt();
        (self.count > 2.0 && size > 0.0).then(|| centred(self.xy, self.x, self.y) / size)
    }
}
