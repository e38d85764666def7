//! A random force of a flat spectrum in a band.

use realfft::RealFftPlanner;
use realfft::num_complex::Complex;

use super::bench::Bench;
use super::error::RigError;
use super::march::{Drive, March, Sampling};
use super::measured::Measured;
use super::plan::RandomTest;
use crate::numeric::random::Random;

/// One record.
pub(super) fn measured(
    bench: &Bench,
    test: &RandomTest,
    delays: &[f64],
    watch: &mut dyn FnMut(f64) -> bool,
) -> Result<Measured, RigError> {
    let force = RandomForce::new(test);
    let sampling = Sampling {
        step: 1.0 / test.sampling,
        count: (test.duration * test.sampling).round() as usize,
        delays: &delays[1..],
    };
    let before_zero = sampling.before() as f64 * sampling.step;
    let on = Drive { force: &|time| force.at(time), smooth: 2.0 * force.step };
    let mut march = March::at_rest(bench, -before_zero.max(test.lead))?;
    let from_rest = test.lead == 0.0;
    if !from_rest {
        march.run_in(-before_zero, &on, watch)?;
    }
    let before = if from_rest { &Drive::NONE } else { &on };
    let (accelerations, contact) = march.sample(&sampling, [before, &on], watch)?;
    let shown = |time: &f64| {
        let then = time - delays[0];
        if then < 0.0 { (before.force)(then) } else { force.at(then) }
    };
    let time = sampling.times();
    let excitation = Some(time.iter().map(shown).collect());
    Ok(Measured { time, excitation, accelerations, contact })
}

/// A force that repeats after the duration, on a grid so fine that a cubic follows it.
struct RandomForce {
    values: Vec<f64>,
    /// Time between two values (s).
    step: f64,
}

impl RandomForce {
    /// Normal variables at every line of the band, scaled to the root mean square exactly.
    fn new(test: &RandomTest) -> Self {
        let samples = (test.duration * test.sampling).round();
        let duration = samples / test.sampling;
        let finer = test.values_per_sample();
        let transform = RealFftPlanner::<f64>::new().plan_fft_inverse((samples * finer) as usize);
        let mut spectrum = transform.make_input_vec();
        let mut random = Random::new(test.seed);
        let [low, high] = test.band.map(|frequency| frequency * duration);
        for line in &mut spectrum[low.ceil() as usize..=high.floor() as usize] {
            *line = Complex::new(random.normal(), random.normal());
        }
        let mut values = transform.make_output_vec();
        // Lengths are those of the transform, and the band leaves out the lines without a phase: it cannot fail.
        let _ = transform.process(&mut spectrum, &mut values);
        let mean_square = values.iter().map(|value| value * value).sum::<f64>() / values.len() as f64;
        let scale = test.force / mean_square.sqrt();
        values.iter_mut().for_each(|value| *value *= scale);
        Self { values, step: 1.0 / test.sampling / finer }
    }

    /// The force (N) at a time (s): Lagrange's cubic through the four values around it.
    fn at(&self, time: f64) -> f64 {
        let place = time / self.step;
        // On the grid but for rounding.
        let (whole, s) = match place.round() {
            near if (place - near).abs() < 1e-6 => return self.value(near as i64),
            _ => (place.floor(), place - place.floor()),
        };
        let [a, b, c, d] = [-1, 0, 1, 2].map(|ahead| self.value(whole as i64 + ahead));
        let outer = s * (s - 1.0) / 6.0;
        outer * ((s + 1.0) * d - (s - 2.0) * a) + 0.5 * (s + 1.0) * (s - 2.0) * ((s - 1.0) * b - s * c)
    }

    fn value(&self, index: i64) -> f64 {
        self.values[index.rem_euclid(self.values.len() as i64) as usize]
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    fn test() -> RandomTest {
        RandomTest { force: 0.3, band: [10.0, 200.0], duration: 4.0, sampling: 1000.0, lead: 0.0, seed: 7 }
    }

    #[test]
    fn the_force_has_its_root_mean_square_and_nothing_outside_its_band() {
        let force = RandomForce::new(&test());
        let samples: Vec<f64> = (0..4000).map(|k| force.at(f64::from(k) * 1e-3)).collect();
        let square = samples.iter().map(|f| f * f).sum::<f64>() / 4000.0;
        assert!((square.sqrt() / 0.3 - 1.0).abs() < 1e-9);
        let line = |frequency: f64| {
            let wave = |k: usize| Complex::from_polar(samples[k], -TAU * frequency * 1e-3 * k as f64);
            (0..4000).map(wave).sum::<Complex<f64>>().norm()
        };
        let inside: f64 = (40..=800).map(|k| line(0.25 * f64::from(k)).powi(2)).sum();
        let outside: f64 = (1..40).chain(801..2000).map(|k| line(0.25 * f64::from(k)).powi(2)).sum();
        assert!(outside < 1e-18 * inside, "{outside:e} {inside:e}");
    }

    #[test]
    fn between_the_values_of_the_grid_it_runs_smoothly() {
        let coarse = RandomForce::new(&test());
        let fine = RandomForce::new(&RandomTest { sampling: 8000.0, ..test() });
        let worst = (0..4000)
            .map(|k| f64::from(k) * 0.9973e-3)
            .map(|time| (coarse.at(time) - fine.at(time)).abs())
            .fold(0.0, f64::max);
        assert!(worst < 1e-4 * 0.3, "{worst:e}");
    }
}
