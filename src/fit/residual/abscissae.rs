//! What a residual may depend on: the motion that belongs to a channel, and what was before.

use realfft::RealFftPlanner;
use realfft::num_complex::Complex;

use crate::data::{Channel, Record, Regime};
use crate::fit::predict::Motion;
use crate::numeric::whole_periods;

/// Change of direction that makes a reversal, as a fraction of the record's range.
const TURN: f64 = 0.05;

/// What could cause the residual of `measured`, with the role of each: the relative motion of a contact, the
/// motion of the same place of a structure (from a measured acceleration where the record is steady), the load,
/// the excitation. The measured value itself where its motion is not known.
pub fn causes(record: &Record, measured: &Channel) -> Vec<(&'static str, Channel)> {
    let mut found = Vec::new();
    let place = measured.name.split_once(':').map(|(_, place)| place);
    let named = |quantity: &str| match place {
        Some(place) => record.channel(&format!("{quantity}:{place}")),
        None => record.channel(quantity),
    };
    let time = record.time().filter(|time| time.len() == measured.values.len());
    let displacement = named("displacement").cloned().or_else(|| integral(record, measured, 2));
    let velocity = named("velocity").cloned().or_else(|| match named("displacement") {
        Some(channel) => Some(derivative(channel, time?)),
        None => integral(record, measured, 1),
    });
    if displacement.is_none() && measured.quantity() != "normal_load" {
        found.push(("measured value", measured.clone()));
    }
    found.extend(displacement.map(|channel| ("displacement", channel)));
    found.extend(velocity.map(|channel| ("velocity", channel)));
    found.extend(record.channel("normal_load").map(|channel| ("normal load", channel.clone())));
    found.extend(
        record.channel("normal_displacement").map(|channel| ("normal displacement", channel.clone())),
    );
    let excitation = record.channels.iter().find(|channel| channel.quantity() == "excitation");
    found.extend(excitation.map(|channel| ("excitation", channel.clone())));
    found.retain(|(_, channel)| channel.values.len() == measured.values.len());
    found
}

/// What drives the record: the displacement of a contact, the excitation of a structure.
pub fn drive<'r>(record: &'r Record, measured: &Channel) -> Option<&'r Channel> {
    match measured.name.as_str() {
        "force" => record.channel("displacement"),
        _ => record.channels.iter().find(|channel| channel.quantity() == "excitation"),
    }
}

/// Roles of what [`memories`] gives.
pub(super) const REMEMBERED: [&str; 2] = ["distance since the last reversal", "place of the last reversal"];

/// What the cycle and the past of `motion` say at each sample: its phase, the way since the last reversal in the direction of
/// the motion, and where that was.
pub(super) fn memories(motion: &Channel) -> Option<[(&'static str, &'static str, Vec<f64>); 3]> {
    let turns = reversals(&motion.values);
    if turns.len() < 2 {
        return None;
    }
    let count = motion.values.len();
    let [mut phase, mut distance, mut place] = [(); 3].map(|()| vec![f64::NAN; count]);
    for (k, &turn) in turns.iter().enumerate() {
        let next = turns.get(k + 1).copied();
        let end = next.unwrap_or(count);
        // The last branch is as long as the one before it.
        let length = next.map_or(turns[k] - turns[k.max(1) - 1], |next| next - turn).max(1);
        let rises = motion.values[turn] < motion.values[next.unwrap_or(count - 1)];
        for i in turn..end {
            let half = 0.5 * ((i - turn) as f64 / length as f64).min(1.0);
            phase[i] = half + if rises { 0.0 } else { 0.5 };
            distance[i] = motion.values[i] - motion.values[turn];
            place[i] = motion.values[turn];
        }
    }
    Some([
        ("phase of the cycle", "1", phase),
        (REMEMBERED[0], motion.unit, distance),
        (REMEMBERED[1], motion.unit, place),
    ])
}

/// Samples at which the motion turns.
pub(crate) fn reversals(values: &[f64]) -> Vec<usize> {
    let low = values.iter().copied().fold(f64::INFINITY, f64::min);
    let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let turn = TURN * (high - low);
    let (mut turns, mut extreme, mut direction) = (Vec::new(), 0, 0.0);
    for (index, value) in values.iter().enumerate() {
        let moved = value - values[extreme];
        if moved * direction > 0.0 {
            extreme = index;
        } else if moved.abs() > turn {
            if direction != 0.0 {
                turns.push(extreme);
            }
            direction = moved.signum();
            extreme = index;
        }
    }
    turns
}

fn derivative(displacement: &Channel, time: &[f64]) -> Channel {
    let values = Motion::uneven(&displacement.values, time).rates;
    let name = displacement.name.replacen("displacement", "velocity", 1);
    Channel { name, unit: "m/s", values, noise: None }
}
/// The integral of order `order` of a steady acceleration, without the lines below its fundamental.
fn integral(record: &Record, measured: &Channel, order: i32) -> Option<Channel> {
    if record.regime != Regime::Steady || measured.quantity() != "acceleration" {
        return None;
    }
    let step = record.sample_step()?;
    let count = measured.values.len();
    let first = drive(record, measured).and_then(|drive| whole_periods(&drive.values)).unwrap_or(1);
    let mut planner = RealFftPlanner::<f64>::new();
    let (forward, backward) = (planner.plan_fft_forward(count), planner.plan_fft_inverse(count));
    let mut lines = forward.make_output_vec();
    forward.process(&mut measured.values.clone(), &mut lines).ok()?;
    let resolution = std::f64::consts::TAU / (step * count as f64);
    for (k, line) in lines.iter_mut().enumerate() {
        *line = if k < first {
            Complex::new(0.0, 0.0)
        } else {
            *line / Complex::new(0.0, k as f64 * resolution).powi(order) / count as f64
        };
    }
    // What the inverse transform demands of a real signal.
    if let (true, Some(end)) = (count.is_multiple_of(2), lines.last_mut()) {
        end.im = 0.0;
    }
    let mut values = backward.make_output_vec();
    backward.process(&mut lines, &mut values).ok()?;
    let (quantity, unit) = if order == 2 { ("displacement", "m") } else { ("velocity", "m/s") };
    let name = measured.name.replacen("acceleration", quantity, 1);
    Some(Channel { name, unit, values, noise: None })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    fn channel(name: &str, unit: &'static str, value: impl Fn(f64) -> f64) -> Channel {
        let values = (0..1000).map(|i| value(f64::from(i) * 1e-3)).collect();
        Channel { name: name.into(), unit, values, noise: None }
    }

    #[test]
    fn central_differences_are_exact_for_a_parabola() {
        let times: Vec<f64> = (0..50).map(|i| f64::from(i) * 0.01).collect();
        let values: Vec<f64> = times.iter().map(|t| 3.0 * t * t).collect();
        let moved = Channel { name: "displacement".into(), unit: "m", values, noise: None };
        let velocity = derivative(&moved, &times);
        for (velocity, t) in velocity.values.iter().zip(&times).take(49).skip(1) {
            assert!((velocity - 6.0 * t).abs() < 1e-12);
        }
    }

    #[test]
    fn the_motion_of_a_steady_acceleration_is_its_integral() {
        let rate = TAU * 20.0;
        let channels = vec![
            channel("time", "s", |t| t),
            channel("excitation", "N", |t| (rate * t).sin()),
            channel("acceleration:x=0.5", "m/s^2", |t| 3.0 + 5.0 * (rate * t).cos()),
        ];
        let record = Record { name: "r".into(), regime: Regime::Steady, use_for: None, channels };
        let causes = causes(&record, &record.channels[2]);
        let of = |role: &str| &causes.iter().find(|(name, _)| *name == role).unwrap().1;
        for (index, time) in record.time().unwrap().iter().enumerate() {
            let (displacement, velocity) =
                (-5.0 * (rate * time).cos() / rate.powi(2), 5.0 * (rate * time).sin() / rate);
            assert!((of("displacement").values[index] - displacement).abs() < 1e-9 * 5.0);
            assert!((of("velocity").values[index] - velocity).abs() < 1e-9 * 5.0);
        }
    }

    #[test]
    fn the_past_of_a_triangle_is_its_corner_and_the_way_from_there() {
        // Between −1 and 1, four samples to a corner.
        let values: Vec<f64> = (0..41).map(|i| (f64::from(i % 16) / 4.0 - 2.0).abs() - 1.0).collect();
        let motion = Channel { name: "displacement".into(), unit: "m", values: values.clone(), noise: None };
        let [(_, _, phase), (_, _, distance), (_, _, place)] = memories(&motion).unwrap();
        for i in 8..40 {
            let falls = i % 16 < 8;
            assert_eq!(place[i], if falls { 1.0 } else { -1.0 }, "{i}");
            assert!((distance[i] - (values[i] - place[i])).abs() < 1e-12);
            let expected = (i % 8) as f64 / 16.0 + if falls { 0.5 } else { 0.0 };
            assert!((phase[i] - expected).abs() < 1e-12, "{i}: {} for {expected}", phase[i]);
        }
    }
}
