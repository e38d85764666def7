//! The magnitudes of a model and its data, by which effects are bounded.

use super::cycles;
use crate::data::{Channel, Dataset, Record};
use crate::effects::{Location, Scales};
use crate::model::{Model, PinnedBeam, Structure};

/// Magnitudes for the parameters of effects on `model` under `dataset`; what is unknown stays one.
pub(in crate::diagnose) fn of(model: &Model, dataset: &Dataset) -> Scales {
    let mut scales = Scales::default();
    let largest = |values: f64, found: &mut f64| {
        if values.is_finite() && values > 0.0 {
            *found = values;
        }
    };
    let step = fold(dataset, f64::min, |record| record.sample_step());
    largest(step, &mut scales.sample_step);
    if let Some(contact) = &model.contact {
        largest(contact.friction_coefficient * contact.normal_load, &mut scales.limit);
        largest(contact.tangential_stiffness, &mut scales.stiffness);
        largest(contact.normal_load, &mut scales.normal_load);
    }
    let yielding = scales.limit / scales.stiffness;
    let rate = |record: &Record| drive_rate(record);
    let frequency = |record: &Record| Some(rate(record)? / std::f64::consts::TAU).filter(|rate| *rate > 0.0);
    let lowest = |record: &Record| match record.channel("frequency") {
        Some(rows) => rows.values.iter().copied().reduce(f64::min),
        None => frequency(record),
    };
    largest(fold(dataset, f64::max, frequency), &mut scales.frequency);
    scales.lowest_frequency = scales.frequency;
    largest(fold(dataset, f64::min, lowest), &mut scales.lowest_frequency);
    let extreme = |name: &str| {
        fold(dataset, f64::max, |record| {
            record.channels_of(name).map(|channel| amplitude(&channel.values)).reduce(f64::max)
        })
    };
    largest(extreme("excitation"), &mut scales.structure_force);
    if let (Structure::PinRig(_), Some(contact)) = (&model.structure, &model.contact) {
        // It is not measured there: that by which the load presses the contact together.
        largest(contact.normal_load / contact.normal_stiffness, &mut scales.normal_displacement);
    }
    largest(extreme("normal_displacement"), &mut scales.normal_displacement);
    largest(
        scales.normal_displacement * scales.frequency * std::f64::consts::TAU,
        &mut scales.normal_velocity,
    );
    match &model.structure {
        Structure::Prescribed => {
            largest(extreme("displacement"), &mut scales.displacement);
            let speed = fold(dataset, f64::max, |record| {
                Some(rate(record)? * amplitude(&record.channel("displacement")?.values))
            });
            largest(speed, &mut scales.velocity);
            let travel = fold(dataset, f64::max, |record| {
                let motion = &record.channel("displacement")?.values;
                Some(motion.windows(2).map(|pair| (pair[1] - pair[0]).abs()).sum())
            });
            largest(travel, &mut scales.travel);
        }
        Structure::Oscillator(oscillator) => {
            largest(oscillator.masses.iter().map(|mass| mass.mass).sum(), &mut scales.structure_mass);
            structure_motion(dataset, &mut scales);
            largest(scales.structure_displacement, &mut scales.displacement);
            contact_motion(dataset, yielding, &mut scales);
        }
        Structure::Beam(beam) | Structure::PinRig(PinnedBeam { beam, .. }) => {
            let area = beam.width * beam.thickness;
            let points: f64 = beam.point_masses.iter().map(|mass| mass.mass).sum();
            largest(beam.density * area * beam.length + points, &mut scales.structure_mass);
            let bending = beam.youngs_modulus * beam.width * beam.thickness.powi(3) / 12.0;
            largest(bending / beam.length, &mut scales.rotational_stiffness);
            structure_motion(dataset, &mut scales);
            // The pin turns by about three times the deflection over the length.
            largest(
                3.0 * scales.structure_displacement * beam.offset.abs() / beam.length,
                &mut scales.displacement,
            );
            contact_motion(dataset, yielding, &mut scales);
        }
    }
    scales
}

/// The same for an effect at `location`: the channel's own size.
pub(in crate::diagnose) fn at(scales: &Scales, dataset: &Dataset, location: Option<&Location>) -> Scales {
    let Some(Location::Channel(name)) = location else { return *scales };
    let deviation = |channel: &Channel| crate::fit::predict::deviation(channel).ok();
    let channel = fold(dataset, f64::max, |record| record.channel(name).and_then(deviation));
    if channel.is_finite() && channel > 0.0 { Scales { channel, ..*scales } } else { *scales }
}

fn fold(dataset: &Dataset, by: fn(f64, f64) -> f64, of: impl Fn(&Record) -> Option<f64>) -> f64 {
    dataset.records.iter().filter_map(of).filter(|value| value.is_finite()).reduce(by).unwrap_or(f64::NAN)
}

/// Half of the range of values.
fn amplitude(values: &[f64]) -> f64 {
    let low = values.iter().copied().fold(f64::INFINITY, f64::min);
    let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    0.5 * (high - low)
}

/// Root mean square rate of the drive over its root mean square (rad/s); of a backbone table 2π times its
/// frequency.
pub(in crate::diagnose) fn drive_rate(record: &Record) -> Option<f64> {
    if let Some(frequency) = record.channel("frequency") {
        return Some(
            std::f64::consts::TAU * frequency.values.iter().sum::<f64>() / frequency.values.len() as f64,
        );
    }
    let step = record.sample_step()?;
    let motion = crate::fit::predict::Motion::even(&cycles::driver(record)?.values, step);
    let mean = motion.values.iter().sum::<f64>() / motion.values.len() as f64;
    let square: f64 = motion.values.iter().map(|x| (x - mean).powi(2)).sum();
    let rate: f64 = motion.rates.iter().map(|x| x * x).sum();
    (square > 0.0).then(|| (rate / square).sqrt())
}

/// Displacement and velocity of the structure from whatever motion was measured.
fn structure_motion(dataset: &Dataset, scales: &mut Scales) {
    let mut displacement = 0.0_f64;
    for record in &dataset.records {
        let Some(rate) = drive_rate(record) else { continue };
        for channel in &record.channels {
            let size = amplitude(&channel.values);
            displacement = displacement.max(match channel.quantity() {
                "displacement" => size,
                "velocity" => size / rate,
                "acceleration" | "amplitude" => size / (rate * rate),
                _ => 0.0,
            });
        }
    }
    if displacement > 0.0 {
        scales.structure_displacement = displacement;
        scales.structure_velocity = displacement * std::f64::consts::TAU * scales.frequency;
    }
}

/// Velocity and travel at a contact on a structure.
fn contact_motion(dataset: &Dataset, yielding: f64, scales: &mut Scales) {
    if scales.displacement < yielding {
        scales.displacement = yielding;
    }
    scales.velocity = scales.displacement * std::f64::consts::TAU * scales.frequency;
    let duration = fold(dataset, f64::max, |record| {
        let time = record.time()?;
        Some(time.last()? - time.first()?)
    });
    if duration.is_finite() {
        scales.travel = 4.0 * scales.displacement * scales.frequency * duration;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::Regime;

    #[test]
    fn the_lowest_frequency_is_that_of_the_slowest_record() {
        let text = "schema = \"stickslip.model/1\"\nkind = \"contact\"\n[contact]\nlaw = \"jenkins\"\n\
                    tangential_stiffness = 2e6\nfriction_coefficient = 0.5\nnormal_load = 100.0\n";
        let model = Model::parse(text).unwrap();
        let channel = |name: &str, unit, values| Channel { name: name.into(), unit, values, noise: None };
        let record = |frequency: f64| {
            let time: Vec<f64> = (0..500).map(|k| 1e-3 * f64::from(k)).collect();
            let motion = time.iter().map(|t| (std::f64::consts::TAU * frequency * t).sin()).collect();
            let channels = vec![channel("time", "s", time), channel("displacement", "m", motion)];
            Record { name: String::new(), regime: Regime::FromRest, use_for: None, channels }
        };
        let of = |frequencies: &[f64]| {
            let records = frequencies.iter().map(|frequency| record(*frequency)).collect();
            of(&model, &Dataset { title: None, records })
        };
        let scales = of(&[10.0, 6.0, 8.0]);
        assert!(
            (scales.frequency / 10.0 - 1.0).abs() < 0.01
                && (scales.lowest_frequency / 6.0 - 1.0).abs() < 0.01
        );
        // What does not move has no frequency.
        let still = of(&[10.0, 0.0]);
        assert_eq!(still.lowest_frequency, still.frequency);
    }
}
