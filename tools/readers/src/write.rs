//! Datasets as text, for [`read_dataset`](crate::read_dataset) and others to read.

use std::fmt::Write as _;

use stickslip::data::{Dataset, Record};
use stickslip::rig::{NoiseLevel, Plan};
use toml_writer::ToTomlValue as _;

use crate::dataset::{REGIMES, SCHEMA, USES};

/// Digits behind the first of a measured value: more than any sensor has.
const DIGITS: usize = 9;

/// The `dataset.toml` of `dataset`.
///
/// ```
/// use stickslip::data::{Channel, Dataset, Record, Regime};
/// let force = Channel { name: "force".into(), unit: "N", values: vec![1.0], noise: Some(0.1) };
/// let record = Record { name: "r.csv".into(), regime: Regime::FromRest, use_for: None, channels: vec![force] };
/// let text = stickslip_readers::dataset_toml(&Dataset { title: None, records: vec![record] });
/// assert!(text.ends_with("file = \"r.csv\"\nregime = \"from-rest\"\nnoise = { \"force\" = 0.1 }\n"));
/// ```
pub fn dataset_toml(dataset: &Dataset) -> String {
    let mut text = format!("schema = {}\n", SCHEMA.to_toml_value());
    if let Some(title) = &dataset.title {
        text += &format!("title = {}\n", title.to_toml_value());
    }
    for record in &dataset.records {
        let regime = REGIMES.iter().find(|(_, regime)| *regime == record.regime).map_or("", |(name, _)| name);
        let file = record.name.to_toml_value();
        text += &format!("\n[[record]]\nfile = {file}\nregime = {}\n", regime.to_toml_value());
        if let Some((name, _)) = USES.iter().find(|(_, use_for)| Some(*use_for) == record.use_for) {
            text += &format!("use = {}\n", name.to_toml_value());
        }
        let told =
            record.channels.iter().filter_map(|channel| Some((&channel.name, rounded(channel.noise?))));
        let noise: Vec<String> = told.map(|(name, noise)| format!("\"{name}\" = {noise:?}")).collect();
        if !noise.is_empty() {
            text += &format!("noise = {{ {} }}\n", noise.join(", "));
        }
    }
    text
}

/// What a rig's plan drew and took for granted: the faults of every channel, and what the accelerometers weigh.
///
/// ```
/// use stickslip::rig::Plan;
/// let text = stickslip_readers::truth_toml(&Plan::of_sensors(&[0.3]));
/// assert!(text.contains("[[channel]]\nname = \"acceleration:x=0.3\"\ngain = 1.0\ndelay = 0.0 # s\nnoise_deviation = 0.0"));
/// ```
pub fn truth_toml(plan: &Plan) -> String {
    let mut text = "schema = \"stickslip.rig-truth/1\"\n".to_owned();
    let sensors = plan.sensors.iter().map(Some);
    for (sensor, fault) in std::iter::once(None).chain(sensors).zip(plan.chain.faults(plan.sensors.len())) {
        let name =
            sensor.map_or("excitation".to_owned(), |sensor| format!("acceleration:x={}", sensor.position));
        text += &format!("\n[[channel]]\nname = {}\n", name.to_toml_value());
        text += &format!("gain = {:?}\ndelay = {:?} # s\n", fault.gain, fault.delay);
        text += &match fault.noise {
            NoiseLevel::Fraction(part) => format!("noise = {part:?} # of the channel's root mean square\n"),
            NoiseLevel::Deviation(deviation) => format!("noise_deviation = {deviation:?}\n"),
        };
        if let Some(sensor) = sensor {
            text += &format!("mass = {:?} # kg\n", sensor.mass);
        }
    }
    text
}

/// The CSV file of a record: SI units, times to the last digit, values with ten digits.
///
/// ```
/// use stickslip::data::{Channel, Record, Regime};
/// let channel = |name: &str, unit, values: &[f64]| {
///     Channel { name: name.into(), unit, values: values.to_vec(), noise: None }
/// };
/// let channels = vec![channel("time", "s", &[0.0, 0.125]), channel("acceleration:x=0.3", "m/s^2", &[1.0 / 3.0, -2.0])];
/// let record = Record { name: "r.csv".into(), regime: Regime::FromRest, use_for: None, channels };
/// let expected = "time [s],acceleration:x=0.3 [m/s^2]\n0.0,0.3333333333\n0.125,-2.0\n";
/// assert_eq!(stickslip_readers::record_csv(&record), expected);
/// ```
pub fn record_csv(record: &Record) -> String {
    let heading = |channel: &stickslip::data::Channel| format!("{} [{}]", channel.name, channel.unit);
    let mut text = record.channels.iter().map(heading).collect::<Vec<_>>().join(",");
    for row in 0..record.len() {
        for (column, channel) in record.channels.iter().enumerate() {
            text.push(if column == 0 { '\n' } else { ',' });
            let value = channel.values[row];
            let value = if channel.name == "time" { value } else { rounded(value) };
            // Writing to a string cannot fail.
            let _ = write!(text, "{value:?}");
        }
    }
    text.push('\n');
    text
}

fn rounded(value: f64) -> f64 {
    format!("{value:.DIGITS$e}").parse().unwrap_or(value)
}
