//! What effects change, gathered for the builders of joints, structures and sensors.

use super::Location;
use crate::contact::JointChanges;
use crate::system::StructureChanges;

/// All that the effects of a model change together; the default changes nothing.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Changes {
    /// The law of the contact.
    pub joint: JointChanges,
    /// The structure.
    pub structure: StructureChanges,
    /// What the sensors show.
    pub sensors: Vec<SensorFault>,
}

/// What a faulty sensor shows: `gain · y(t (1 + clock_error) − delay) + bias`.
#[derive(Debug, Clone, PartialEq)]
pub struct SensorFault {
    /// Name of the channel.
    pub channel: String,
    /// Lateness (s).
    pub delay: f64,
    /// Relative error of the clock's rate (1); without meaning in a steady state.
    pub clock_error: f64,
    /// Reading over true value (1).
    pub gain: f64,
    /// In the SI unit of the channel.
    pub bias: f64,
}

impl SensorFault {
    /// Whether the sensor shows each moment at that moment.
    pub fn is_on_time(&self) -> bool {
        self.delay == 0.0 && self.clock_error == 0.0
    }

    /// The moment that the sensor shows at sample `index`, in samples `step` seconds apart.
    pub fn place(&self, index: usize, step: f64) -> f64 {
        index as f64 * (1.0 + self.clock_error) - self.delay / step
    }
}

impl Changes {
    /// The fault of `channel`, which is made where there is none.
    pub(super) fn sensor(&mut self, channel: Option<&Location>) -> &mut SensorFault {
        let name = channel.map(ToString::to_string).unwrap_or_default();
        let index = self.sensors.iter().position(|fault| fault.channel == name).unwrap_or_else(|| {
            self.sensors.push(SensorFault {
                channel: name,
                delay: 0.0,
                clock_error: 0.0,
                gain: 1.0,
                bias: 0.0,
            });
            self.sensors.len() - 1
        });
        &mut self.sensors[index]
    }
}
