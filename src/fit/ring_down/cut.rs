//! A free decay cut into windows, each as long as its amplitude takes to fall by a third.

use std::f64::consts::TAU;

use super::envelope::{amplitudes, beginning};
use super::window::{Fitted, Window};

/// Fall of the logarithm of the amplitude over a window.
const FALL: f64 = 0.4;
/// Fewest cycles of a window: its fit has seven unknowns.
const FEWEST_CYCLES: f64 = 5.0;
/// The next window begins after this fraction of one: under their weights the two then share next to nothing.
const HOP: f64 = 0.7;
/// Standard deviations by noise that an amplitude must have, and its damping.
const CLEAR: [f64; 2] = [10.0, 2.0];
/// Most windows.
const MOST: usize = 60;
/// Change of the frequency from window to window beyond which another vibration was taken.
const SAME: f64 = 0.1;

/// The windows of the decay of the vibration at about `cycles_per_sample`, the first with the largest amplitude.
pub(super) fn windows(values: &[f64], cycles_per_sample: f64) -> Result<Vec<Fitted>, String> {
    let (seen, stride) = amplitudes(values, cycles_per_sample);
    let mut first = beginning(&seen, stride);
    let at = |sample: f64| seen.get((sample / stride) as usize).copied();
    let mut speed = TAU * cycles_per_sample;
    // The rate over a first few cycles.
    let short = FEWEST_CYCLES / cycles_per_sample;
    let (Some(here), Some(ahead)) = (at(first), at(first + short)) else {
        return Err("the record ends before the vibration decays".into());
    };
    let mut rate = ((here / ahead).ln() / short).max(0.0);
    let (mut slope, mut found) = (0.0, Vec::<Fitted>::new());
    let anywhere: Vec<f64> = (-12..=12).map(|k| 1.0 + 0.02 * f64::from(k)).collect();
    let near: Vec<f64> = (-3..=3).map(|k| 1.0 + 0.005 * f64::from(k)).collect();
    while found.len() < MOST {
        let fewest = FEWEST_CYCLES * TAU / speed;
        let longest = 0.25 * values.len() as f64;
        let length = (FALL / rate.max(1e-12)).min(longest).max(fewest);
        if first + length > values.len() as f64 {
            break;
        }
        let window = Window::new(values, first as usize, length as usize);
        let around = if found.is_empty() { &anywhere } else { &near };
        let Some(fitted) = window.fit([speed, slope, rate], around) else { break };
        let clear = fitted.amplitude > CLEAR[0] * fitted.amplitude_error
            && fitted.rate > CLEAR[1] * fitted.rate_error
            && (found.is_empty() || (fitted.speed / speed - 1.0).abs() < SAME);
        if !clear {
            break;
        }
        let hop = HOP * length;
        rate = fitted.rate;
        (speed, slope) = (fitted.speed + hop * fitted.speed_slope[0], fitted.speed_slope[0]);
        if (speed / fitted.speed - 1.0).abs() > 0.5 * SAME {
            (speed, slope) = (fitted.speed, 0.0);
        }
        found.push(fitted);
        first += hop;
    }
    Ok(found)
}
