//! `[sensors]`: accelerometers, and the chain from motion to numbers.

use stickslip::data::ChannelName;
use stickslip::document::{DocumentError, Numbers, Table, suggestion};
use stickslip::model::Beam;
use stickslip::rig::{Accelerometer, Chain, ChannelFault, NoiseLevel, Plan};

use super::value::{checked, not_negative, whole};

const KEYS: [&str; 10] = [
    "positions",
    "mass",
    "masses_told",
    "noise",
    "noise_deviation",
    "noise_told",
    "gain",
    "gain_scatter",
    "delay",
    "seed",
];
/// The longest delay of a chain (s), and the widest scatter of gains.
const LONGEST_DELAY: f64 = 0.1;
const WIDEST_SCATTER: f64 = 0.5;

/// A plan without tests, and whether the dataset says what accelerometers weigh.
pub(super) fn read(root: &Table<'_>, beam: &Beam) -> Result<(Plan, bool), DocumentError> {
    // Without a list of its own the model's sensors are its point masses.
    let listed = || beam.sensors.clone();
    let Some(table) = root.table("sensors")? else {
        return Ok((with_sensors(Plan::of_sensors(&listed()), root)?, true));
    };
    table.allow(&KEYS)?;
    let positions = positions(&table, beam)?.unwrap_or_else(listed);
    let mut plan = with_sensors(Plan::of_sensors(&positions), &table)?;
    set_masses(&table, &mut plan.sensors)?;
    plan.chain = chain(&table, &positions)?;
    let masses_told = table.boolean("masses_told")?.is_none_or(|told| told.value);
    Ok((plan, masses_told))
}

fn with_sensors(plan: Plan, table: &Table<'_>) -> Result<Plan, DocumentError> {
    let missing = || table.missing("positions").with_help("neither the model nor the plan has a sensor");
    if plan.sensors.is_empty() { Err(missing()) } else { Ok(plan) }
}

fn positions(table: &Table<'_>, beam: &Beam) -> Result<Option<Vec<f64>>, DocumentError> {
    let Some(positions) = table.number_or_numbers("positions")? else { return Ok(None) };
    let positions = match positions {
        Numbers::One(position) => vec![position],
        Numbers::Many(positions) => positions,
    };
    let refuse = |message: String| Err(DocumentError::new(message, table.span_of("positions")));
    if let Some(outside) = positions.iter().find(|position| !(0.0..=beam.length).contains(*position)) {
        return refuse(format!("there is no beam at {outside} m: it runs from 0 to {} m", beam.length));
    }
    let mut sorted = positions.clone();
    sorted.sort_by(f64::total_cmp);
    match sorted.windows(2).find(|pair| pair[0] == pair[1]) {
        Some(pair) => refuse(format!("two sensors are at {} m", pair[0])),
        None => Ok(Some(positions)),
    }
}

/// One mass for all accelerometers, or one each.
fn set_masses(table: &Table<'_>, sensors: &mut [Accelerometer]) -> Result<(), DocumentError> {
    let masses = match table.number_or_numbers("mass")? {
        None => return Ok(()),
        Some(Numbers::One(mass)) => vec![mass; sensors.len()],
        Some(Numbers::Many(masses)) => masses,
    };
    if masses.len() != sensors.len() || masses.iter().any(|mass| *mass < 0.0) {
        let message = format!("`mass` must be one number, or one for each of the {} sensors", sensors.len());
        return Err(DocumentError::new(message, table.span_of("mass")).with_help("kg, not below 0"));
    }
    sensors.iter_mut().zip(masses).for_each(|(sensor, mass)| sensor.mass = mass);
    Ok(())
}

fn chain(table: &Table<'_>, positions: &[f64]) -> Result<Chain, DocumentError> {
    let mut names = vec!["excitation".to_owned()];
    names.extend(positions.iter().map(|position| format!("acceleration:x={position}")));
    let of =
        |key: &str, legal: &dyn Fn(f64) -> bool, bounds: &str| per_channel(table, key, &names, legal, bounds);
    let noise = of("noise", &|value| value >= 0.0, "0 or above")?;
    let deviation = of("noise_deviation", &|value| value >= 0.0, "0 or above")?;
    let gain = of("gain", &|_| true, "finite")?;
    let longest = format!("between 0 and {LONGEST_DELAY} s");
    let delay = of("delay", &|value| (0.0..=LONGEST_DELAY).contains(&value), &longest)?;
    let mut faults = Vec::with_capacity(names.len());
    for (channel, name) in names.iter().enumerate() {
        let noise = match (noise[channel], deviation[channel]) {
            (Some(_), Some(_)) => {
                let message = format!("`{name}` has both `noise` and `noise_deviation`");
                return Err(DocumentError::new(message, table.span_of("noise_deviation")));
            }
            (Some(fraction), None) => NoiseLevel::Fraction(fraction),
            (None, deviation) => NoiseLevel::Deviation(deviation.unwrap_or(0.0)),
        };
        let (gain, delay) = (gain[channel].unwrap_or(1.0), delay[channel].unwrap_or(0.0));
        faults.push(ChannelFault { gain, delay, noise });
    }
    let gain_scatter = not_negative(table, "gain_scatter")?.unwrap_or(0.0);
    if gain_scatter > WIDEST_SCATTER {
        let message = format!("`gain_scatter` must be at most {WIDEST_SCATTER}");
        return Err(DocumentError::new(message, table.span_of("gain_scatter")));
    }
    Ok(Chain {
        excitation: faults[0],
        accelerometers: faults.split_off(1),
        gain_scatter,
        seed: whole(table, "seed", 0)?.unwrap_or(0) as u64,
        noise_told: table.boolean("noise_told")?.is_some_and(|told| told.value),
    })
}

/// One number for all channels, or a table of them by the channels' names.
fn per_channel(
    table: &Table<'_>,
    key: &str,
    names: &[String],
    legal: &dyn Fn(f64) -> bool,
    bounds: &str,
) -> Result<Vec<Option<f64>>, DocumentError> {
    if let Ok(Some(number)) = table.number(key) {
        return Ok(vec![Some(checked(key, number, &legal, bounds)?); names.len()]);
    }
    let mut values = vec![None; names.len()];
    let Some(entries) = table.table(key)? else { return Ok(values) };
    for entry in entries.keys() {
        let parsed = ChannelName::parse(entry.value).map(|name| name.to_string());
        let channel = names.iter().position(|name| Ok(name) == parsed.as_ref());
        let Some(channel) = channel else {
            let known: Vec<&str> = names.iter().map(String::as_str).collect();
            return Err(entry
                .error(format!("the rig has no channel `{}`", entry.value))
                .with_help(suggestion(entry.value, &known, "channels")));
        };
        let number = entries.required_number(entry.value)?;
        values[channel] = Some(checked(entry.value, number, &legal, bounds)?);
    }
    Ok(values)
}
