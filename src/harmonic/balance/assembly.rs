//! A system under its excitation, and how its periodic responses are to be computed.

use crate::harmonic::{CurveSettings, HarmonicError};
use crate::system::{Element, System};

/// A system under a periodic excitation.
///
/// ```
/// use stickslip::prelude::*;
/// # let model = Model::parse(
/// #     r#"
/// #     schema = "stickslip.model/1"
/// #     kind = "oscillator"
/// #     mass = [{ name = "m1", mass = 1.0 }]
/// #     spring = [{ between = ["ground", "m1"], stiffness = 9.0, damping = 0.1 }]
/// #     contact = { at = "m1", law = "jenkins", tangential_stiffness = 7.0, friction_coefficient = 0.5, normal_load = 2.0 }
/// #     "#,
/// # )?;
/// let mut assembly = Assembly::new(model.system()?);
/// // A constant force of 0.2 beside the cosine; the normal load swings by 1 N in phase with it.
/// assembly.waveform = vec![0.2, 1.0, 0.0];
/// assembly.load_swings = vec![(0, vec![1.0, 0.0])];
/// assert_eq!(assembly.nodes(), ["m1"]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct Assembly {
    /// The system.
    pub system: System,
    /// Coefficients `[a0, c1, s1, …]` of the excitation at level 1: `[0, 1, 0]` is cos Ωt.
    pub waveform: Vec<f64>,
    /// Coefficients of an excitation beside it, per unit of the parameter; empty for none. Only systems in modal coordinates
    /// take one.
    pub second_waveform: Vec<f64>,
    /// Coefficients `[c1, s1, …]` (N) by which the normal load of an element's law swings about its mean, for elements by
    /// their places in [`System::elements`]. The others have a constant load.
    pub load_swings: Vec<(usize, Vec<f64>)>,
    /// Displacement (m) at which an element's law that never moved has no force, for elements by their places. A law that
    /// slips forgets it; one that sticks all through a steady state keeps the force it was left with.
    pub static_offsets: Vec<(usize, f64)>,
}

impl Assembly {
    /// Under the excitation cos Ωt, with constant normal loads.
    pub fn new(system: System) -> Self {
        let waveform = vec![0.0, 1.0, 0.0];
        Self {
            system,
            waveform,
            second_waveform: Vec::new(),
            load_swings: Vec::new(),
            static_offsets: Vec::new(),
        }
    }

    /// Names of the points whose responses are given: the sensors and, of a system that keeps its modal coordinates, the
    /// port driven.
    pub fn nodes(&self) -> Vec<String> {
        let driven = self.system.driven.iter().filter(|_| !self.is_condensed());
        let ports = self.system.sensors.iter().chain(driven);
        ports.filter_map(|port| Some(self.system.ports.get(*port)?.name.clone())).collect()
    }

    /// Whether the system is condensed to its ports by receptance: all that have an element are linear.
    pub(crate) fn is_condensed(&self) -> bool {
        let modal = |element: &Element| matches!(element, Element::SlipSlap { .. } | Element::Inertia { .. });
        if self.system.elements.iter().any(modal) {
            return false;
        }
        let rigid = |port: &usize| self.system.ports[*port].flexibility == 0.0;
        self.system.is_linear_at_ports() && self.system.elements.iter().flat_map(Element::ports).all(rigid)
    }

    /// Whether responses of odd harmonics alone are a closed family: every law odd, the excitation without
    /// bias and even harmonics.
    pub(crate) fn is_odd(&self) -> bool {
        let even = |k: &usize| k.div_ceil(2).is_multiple_of(2);
        self.is_condensed()
            && self.system.laws().all(|(_, law, _)| law.is_odd())
            && self.load_swings.is_empty()
            && self.static_offsets.is_empty()
            && (0..self.waveform.len()).filter(even).all(|k| self.waveform[k] == 0.0)
    }

    /// Refuses an excitation that a response with the harmonics of `settings` could not follow: the harmonics left out
    /// would be missing from the response and from the estimate of its error.
    pub(crate) fn check_excitation(&self, settings: &CurveSettings) -> Result<(), HarmonicError> {
        let highest_of =
            |list: &[f64]| list.iter().rposition(|f| *f != 0.0).map_or(0, |place| place.div_ceil(2));
        let highest = highest_of(&self.waveform).max(highest_of(&self.second_waveform));
        if highest > settings.harmonics {
            return Err(HarmonicError::InvalidInput(
                "the excitation has more harmonics than the response may have",
            ));
        }
        Ok(())
    }

    pub(crate) fn check(&self) -> Result<(), HarmonicError> {
        let refuse = |message| Err(HarmonicError::InvalidInput(message));
        let swings = self.load_swings.iter().flat_map(|(_, swing)| swing);
        let offsets = self.static_offsets.iter().map(|(_, offset)| offset);
        let Self { system, .. } = self;
        if system.core.size() == 0 {
            return refuse("a system without coordinates has no response of its own");
        }
        if self.waveform.iter().chain(&self.second_waveform).any(|f| !f.is_finite()) {
            return refuse("the excitation is not finite");
        }
        if system.laws().any(|(.., load)| !load.is_finite()) || swings.chain(offsets).any(|x| !x.is_finite())
        {
            return refuse("a normal load or a static offset is not finite");
        }
        let sound = |element: &Element| match *element {
            Element::Resonator { mass, angular_frequency: natural, damping_ratio: ratio, .. } => {
                let finite = mass.is_finite() && natural.is_finite() && ratio.is_finite();
                finite && mass > 0.0 && natural > 0.0 && ratio >= 0.0
            }
            _ => true,
        };
        if !system.elements.iter().all(sound) {
            return refuse("a resonator has no positive mass and frequency, or a negative damping");
        }
        let places =
            system.elements.iter().flat_map(Element::ports).chain(&system.driven).chain(&system.sensors);
        if places.into_iter().any(|port| *port >= system.ports.len()) {
            return refuse("an element, an exciter or a sensor is at a port that there is not");
        }
        Ok(())
    }
}

/// What holds the response at a point of a curve.
///
/// ```
/// use stickslip::prelude::*;
/// # let model = Model::parse(
/// #     r#"
/// #     schema = "stickslip.model/1"
/// #     kind = "oscillator"
/// #     mass = [{ name = "m1", mass = 1.0 }]
/// #     spring = [{ between = ["ground", "m1"], stiffness = 9.0, damping = 0.1 }]
/// #     contact = { at = "m1", law = "jenkins", tangential_stiffness = 7.0, friction_coefficient = 0.5, normal_load = 2.0 }
/// #     "#,
/// # )?;
/// // The first harmonic of the acceleration of the mass is held at 5 m/s²: the level of the force follows.
/// let held = Control::Held { node: 0, order: 1, derivative: 2, amplitude: 5.0 };
/// let settings = CurveSettings::default();
/// let curve = frequency_response(&Assembly::new(model.system()?), 2.0, 5.0, &held, &settings, &mut |_| true)?;
/// assert!(curve.points.iter().all(|point| point.level > 0.0));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Control {
    /// The excitation's level.
    Level(f64),
    /// Amplitude of a harmonic of a node, as a controlled shaker holds it; the level follows.
    Held {
        /// Which node.
        node: usize,
        /// Which harmonic, at least 1.
        order: usize,
        /// Of its displacement (0), velocity (1) or acceleration (2).
        derivative: usize,
        /// Amplitude (m, m/s or m/s²).
        amplitude: f64,
    },
}
