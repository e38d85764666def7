//! The two masses with a Jenkins element, and its variations.

use std::sync::Arc;

use stickslip::contact::Jenkins;
use stickslip::harmonic::{
    Assembly, Control, Curve, CurveSettings, Peak, Point, frequency_response, periodic_response,
};
use stickslip::model::{Model, Oscillator, Structure};
use stickslip::system::LinearStructure;

use crate::Failure;

/// The example's model file.
pub const MODEL: &str = include_str!("../model.toml");
/// Amplitude of the force on the first mass (N), which a model file does not hold.
pub const FORCE: f64 = 0.4;
/// Where the first resonance lies, whatever the force, the friction (rad/s).
pub const FIRST_RESONANCE: (f64, f64) = (0.48, 0.72);
/// Below this (rad/s) the third harmonic meets the first resonance and makes small peaks of its own.
pub const ABOVE_SUPERHARMONICS: f64 = 0.3;
/// The range of the figures (rad/s).
pub const RANGE: (f64, f64) = (0.2, 2.0);
/// Places of the masses: x is the displacement of the first, y of the second, which rubs.
pub const X: usize = 0;
pub const Y: usize = 1;

/// The system with one set of its parameters.
#[derive(Debug, Clone)]
pub struct System {
    oscillator: Oscillator,
    structure: LinearStructure,
    /// k_t (N/m).
    pub stiffness: f64,
    /// μ.
    pub friction: f64,
    /// N₀ (N).
    pub normal_load: f64,
}

impl System {
    /// As the model file says.
    pub fn new() -> Result<Self, Failure> {
        let model = Model::parse(MODEL).map_err(|error| error.message)?;
        let (Structure::Oscillator(oscillator), Some(contact)) = (model.structure, model.contact) else {
            return Err(Failure::from("the example's model is not an oscillator with a contact"));
        };
        Ok(Self {
            structure: assembled(&oscillator)?,
            oscillator,
            stiffness: contact.tangential_stiffness,
            friction: contact.friction_coefficient,
            normal_load: contact.normal_load,
        })
    }

    /// With another coefficient of friction.
    pub fn with_friction(&self, friction: f64) -> Self {
        Self { friction, ..self.clone() }
    }

    /// With another stiffness of the contact (N/m).
    pub fn with_stiffness(&self, stiffness: f64) -> Self {
        Self { stiffness, ..self.clone() }
    }

    /// With the contact on another mass.
    pub fn with_contact_on(&self, mass: usize) -> Result<Self, Failure> {
        let oscillator = Oscillator { contact: Some(mass), ..self.oscillator.clone() };
        Ok(Self { structure: assembled(&oscillator)?, oscillator, ..self.clone() })
    }

    /// The masses and springs.
    pub fn structure(&self) -> &LinearStructure {
        &self.structure
    }

    /// The same with the contact stuck, as one more spring.
    pub fn stuck(&self) -> LinearStructure {
        let mut structure = self.structure.clone();
        for (i, a) in self.structure.contacts.iter().flatten() {
            for (j, b) in self.structure.contacts.iter().flatten() {
                let added = a * b * self.stiffness;
                match structure.stiffness.iter_mut().find(|entry| (entry.0, entry.1) == (*i, *j)) {
                    Some(entry) => entry.2 += added,
                    None => structure.stiffness.push((*i, *j, added)),
                }
            }
        }
        structure
    }

    /// μ N₀ (N).
    pub fn limit(&self) -> f64 {
        self.friction * self.normal_load
    }

    /// The contact law.
    pub fn law(&self) -> Result<Jenkins, Failure> {
        Jenkins::new(self.stiffness, self.friction).map_err(Failure::from)
    }

    /// The response over frequency under a force of amplitude `force` (N).
    pub fn curve(&self, force: f64, range: (f64, f64), settings: &CurveSettings) -> Result<Curve, Failure> {
        let control = Control::Level(force);
        frequency_response(&self.assembly()?, range.0, range.1, &control, settings, &mut |_: &Point| true)
            .map_err(Failure::from)
    }

    /// The response at one frequency (rad/s).
    pub fn point(
        &self,
        force: f64,
        angular_frequency: f64,
        settings: &CurveSettings,
    ) -> Result<Point, Failure> {
        let control = Control::Level(force);
        periodic_response(&self.assembly()?, angular_frequency, &control, settings, None)
            .map_err(Failure::from)
    }

    /// The first resonance of a node under `force` (N), with the state there.
    pub fn first_peak(&self, force: f64, node: usize) -> Result<Tracked, Failure> {
        let settings = fine();
        let curve = self.curve(force, FIRST_RESONANCE, &settings)?;
        let peaks = curve.peaks.iter().filter(|peak| peak.node == node);
        let peak = peaks.max_by(|a, b| a.amplitude.total_cmp(&b.amplitude)).copied().ok_or_else(|| {
            Failure::from(format!("no first resonance under {force} N with a friction of {}", self.friction))
        })?;
        Ok(Tracked { peak, point: self.point(force, peak.angular_frequency, &settings)? })
    }

    fn assembly(&self) -> Result<Assembly, Failure> {
        Ok(Assembly::new(self.structure.system(vec![(Arc::new(self.law()?), self.normal_load)])))
    }
}

/// A resonance.
#[derive(Debug, Clone)]
pub struct Tracked {
    pub peak: Peak,
    pub point: Point,
}

/// 21 harmonics, as most of the study has them.
pub fn fine() -> CurveSettings {
    CurveSettings { harmonics: 21, max_step: 0.01, ..CurveSettings::default() }
}

fn assembled(oscillator: &Oscillator) -> Result<LinearStructure, Failure> {
    oscillator.structure().map_err(Failure::from)
}

/// Where `of` is smallest between `low` and `high`, by Brent's golden section alone, to `tolerance`.
pub fn minimum(
    (mut low, mut high): (f64, f64),
    tolerance: f64,
    mut of: impl FnMut(f64) -> Result<f64, Failure>,
) -> Result<f64, Failure> {
    let golden = 0.5 * (5.0_f64.sqrt() - 1.0);
    let (mut left, mut right) = (high - golden * (high - low), low + golden * (high - low));
    let (mut at_left, mut at_right) = (of(left)?, of(right)?);
    while high - low > tolerance {
        if at_left < at_right {
            (high, right, at_right) = (right, left, at_left);
            left = high - golden * (high - low);
            at_left = of(left)?;
        } else {
            (low, left, at_left) = (left, right, at_right);
            right = low + golden * (high - low);
            at_right = of(right)?;
        }
    }
    Ok(0.5 * (low + high))
}

/// `count` values from `low` to `high`, evenly spaced on a logarithmic axis.
pub fn logarithmic(low: f64, high: f64, count: usize) -> Vec<f64> {
    (0..count).map(|k| low * (high / low).powf(k as f64 / (count - 1) as f64)).collect()
}

/// `count` values from `low` to `high`.
pub fn linear(low: f64, high: f64, count: usize) -> Vec<f64> {
    (0..count).map(|k| low + (high - low) * k as f64 / (count - 1) as f64).collect()
}
