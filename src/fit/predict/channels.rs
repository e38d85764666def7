//! Which columns of a record drive a model and which it predicts.

use crate::data::{Channel, Record, Regime};
use crate::model::{Model, Structure};

/// What a comparison does with the columns of a record.
struct Roles {
    /// Quantities that drive the model.
    inputs: &'static [&'static str],
    /// Quantities that it predicts.
    compared: &'static [&'static str],
}

fn roles(model: &Model, regime: Regime) -> Roles {
    match (&model.structure, regime) {
        (Structure::Prescribed, _) => Roles {
            inputs: &["time", "displacement", "velocity", "normal_load", "normal_displacement"],
            compared: &["force"],
        },
        (_, Regime::Backbone) => Roles {
            inputs: &["amplitude", "frequency_interval", "damping_interval", "window"],
            compared: &["frequency", "damping_ratio"],
        },
        (_, Regime::SteppedSine) => Roles {
            inputs: &["frequency", "excitation"],
            compared: &["acceleration", "velocity", "displacement", "phase"],
        },
        (_, _) => Roles {
            inputs: if follows_measured_load(model) {
                &["time", "excitation", "normal_load"]
            } else {
                &["time", "excitation"]
            },
            compared: &["acceleration", "velocity", "displacement"],
        },
    }
}

/// Whether the model's friction follows the load that was measured. That of a pin rig follows the rig's own.
fn follows_measured_load(model: &Model) -> bool {
    model.changes().joint.load_gain.is_some() && !matches!(model.structure, Structure::PinRig(_))
}

/// The channels of `record` that a model of this structure predicts. A contact's normal load is one where the
/// model has a normal stiffness and the approach was measured.
pub(crate) fn compared<'r>(model: &Model, record: &'r Record) -> Vec<&'r Channel> {
    let roles = roles(model, record.regime);
    let mut channels: Vec<&Channel> =
        roles.compared.iter().flat_map(|quantity| record.channels_of(quantity)).collect();
    let elastic = model.contact.is_some_and(|contact| contact.normal_stiffness > 0.0);
    if model.structure == Structure::Prescribed && elastic && record.channel("normal_displacement").is_some()
    {
        channels.extend(record.channel("normal_load"));
    }
    channels
}

/// Whether a `channel` of `record` drives a model of this structure; time does not.
pub(crate) fn drives(model: &Model, record: &Record, channel: &Channel) -> bool {
    let quantity = channel.quantity();
    let compared = || compared(model, record).iter().any(|compared| compared.name == channel.name);
    quantity != "time" && roles(model, record.regime).inputs.contains(&quantity) && !compared()
}

/// Time derivative of the displacement that a channel measures.
pub(crate) fn derivative_order(channel: &Channel) -> usize {
    match channel.quantity() {
        "acceleration" => 2,
        "velocity" => 1,
        _ => 0,
    }
}

/// Where on the beam (m) a channel was measured.
pub(super) fn position(channel: &Channel) -> Result<f64, String> {
    channel
        .position()
        .ok_or_else(|| format!("`{}` does not say where on the beam it was measured", channel.name))
}

/// Names of the columns of `record` that a comparison with `model` leaves aside: neither do they drive the
/// model nor does it predict them. A measured normal load is one, since a model's load is constant.
pub fn unused_columns<'r>(model: &Model, record: &'r Record) -> Vec<&'r str> {
    let Roles { inputs, compared } = roles(model, record.regime);
    let unused = record.channels.iter().filter(|channel| {
        let quantity = channel.quantity();
        !inputs.contains(&quantity) && !compared.contains(&quantity)
    });
    unused.map(|channel| channel.name.as_str()).collect()
}

/// A standard deviation below this fraction of the largest value is the rounding of a constant.
const ROUNDING: f64 = 1e-12;

/// Population standard deviation of a channel: what its errors are measured by.
pub(crate) fn deviation(channel: &Channel) -> Result<f64, String> {
    let Channel { name, values, .. } = channel;
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let deviation = (values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / count).sqrt();
    let largest = values.iter().fold(0.0_f64, |largest, value| largest.max(value.abs()));
    if !deviation.is_finite() {
        return Err(format!("`{name}` is too large to compare: its squares overflow"));
    }
    if deviation <= ROUNDING * largest {
        return Err(format!("`{name}` is the same number throughout; there is nothing to compare"));
    }
    Ok(deviation)
}
