//! Free decay from a held level or a constant force.

use std::f64::consts::{PI, TAU};

use super::bench::Bench;
use super::error::RigError;
use super::march::{Drive, March, Sampling};
use super::measured::Measured;
use super::plan::{Release, RingDown};
use crate::numeric::fourier::{time_derivative, value};

/// Periods driven in time from the balanced steady state, so that a contact that remembers more than its force has its
/// steady memory, and periods of the first mode over which a constant force is applied.
const DRIVEN: f64 = 20.0;
const PULLED: f64 = 40.0;
/// Radians of the first harmonic over which a parabola follows a force.
const SMOOTH: f64 = 0.3;

/// Record `index` of a test.
pub(super) fn measured(
    bench: &Bench,
    test: &RingDown,
    index: usize,
    delays: &[f64],
    watch: &mut dyn FnMut(f64) -> bool,
) -> Result<Measured, RigError> {
    let sampling = Sampling {
        step: 1.0 / test.sampling,
        count: (test.duration * test.sampling).round() as usize,
        delays: &delays[1..],
    };
    let before_zero = sampling.before() as f64 * sampling.step;
    let (accelerations, contact) = match test.from[index] {
        Release::Held(amplitude) => {
            let steady = bench.resonance(None, amplitude)?;
            let speed = steady.angular_frequency;
            // The force passes zero at time 0, where the displacement is largest.
            let phase = |time: f64| speed * time + 0.5 * PI;
            let force = |time: f64| steady.force_amplitude * phase(time).cos();
            let on = Drive { force: &force, smooth: SMOOTH / speed };
            let periods = DRIVEN + (before_zero * speed / TAU).ceil();
            let begin = -periods * TAU / speed;
            let per_mode = steady.contact_displacement.len() / 2 + 1;
            let modes = || steady.coefficients.chunks_exact(per_mode);
            let displacement: Vec<f64> = modes().map(|mode| value(mode, phase(begin))).collect();
            let velocity: Vec<f64> =
                modes().map(|mode| value(&time_derivative(mode, 1, speed), phase(begin))).collect();
            let contact_force = value(&steady.contact_force, phase(begin));
            let mut march = March::moving(bench, begin, [&displacement, &velocity], contact_force)?;
            march.run_in(-before_zero, &on, watch)?;
            march.sample(&sampling, [&on, &Drive::NONE], watch)?
        }
        Release::Force(size) => {
            let period = TAU / bench.lowest();
            let force = |time: f64| {
                // Applied without a jump in its second derivative, then held.
                let s = (time / (PULLED * period) + 1.25).clamp(0.0, 1.0);
                size * s * s * s * (10.0 - 15.0 * s + 6.0 * s * s)
            };
            let on = Drive { force: &force, smooth: 0.5 * period };
            let begin = -1.25 * PULLED * period - before_zero;
            let mut march = March::at_rest(bench, begin)?;
            march.run_in(-before_zero, &on, watch)?;
            march.sample(&sampling, [&on, &Drive::NONE], watch)?
        }
    };
    Ok(Measured { time: sampling.times(), excitation: None, accelerations, contact })
}
