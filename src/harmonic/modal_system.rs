//! A system in modal coordinates, its lists complete and its numbers legal.

use nalgebra::Complex;

use super::HarmonicError;
use crate::system::{Core, Element, Port, System};

/// [`System`] with a modal core and rows that have an entry per mode.
#[derive(Debug, Clone)]
pub(crate) struct ModalSystem {
    /// ωᵢ (rad/s) and ζᵢ (1).
    pub angular_frequency: Vec<f64>,
    pub damping_ratio: Vec<f64>,
    /// G, modes × modes.
    pub shortening: Vec<f64>,
    pub ports: Vec<ModalPort>,
    pub elements: Vec<Element>,
    /// What the exciters push on.
    pub driven: Vec<f64>,
    /// Rows of the sensors and, last, [`Self::driven`].
    pub observed: Vec<Vec<f64>>,
}

/// [`Port`] with an entry per mode.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct ModalPort {
    /// b.
    pub shape: Vec<f64>,
    /// γ, as [`Port::shortening`].
    pub shortening: f64,
    /// a (m/N).
    pub flexibility: f64,
}

impl ModalPort {
    pub fn new(port: &Port, modes: usize) -> Self {
        let mut shape = vec![0.0; modes];
        for (mode, value) in port.row.iter().filter(|(mode, _)| *mode < modes) {
            shape[*mode] += value;
        }
        Self { shape, shortening: port.shortening, flexibility: port.flexibility }
    }
}

impl ModalSystem {
    /// Refuses other cores, lists that do not fit and numbers that make no sense.
    pub fn new(system: &System) -> Result<Self, HarmonicError> {
        let refuse = |message| Err(HarmonicError::InvalidInput(message));
        let Core::Modal { angular_frequency, damping_ratio } = &system.core else {
            return refuse("a port that shortens or has a flexibility in series asks for modal coordinates");
        };
        let modes = angular_frequency.len();
        if modes == 0 {
            return refuse("the system has no modes");
        }
        let mut shortening = system.shortening.clone();
        if shortening.is_empty() {
            shortening.resize(modes * modes, 0.0);
        }
        if damping_ratio.len() != modes || shortening.len() != modes * modes {
            return refuse("a list of the system does not have one entry per mode");
        }
        if system.ports.iter().flat_map(|port| &port.row).any(|(mode, _)| *mode >= modes) {
            return refuse("a port moves with a mode that there is not");
        }
        let of_ports = system.ports.iter().flat_map(|port| {
            port.row.iter().map(|(_, value)| value).chain([&port.shortening, &port.flexibility])
        });
        let all = angular_frequency.iter().chain(damping_ratio).chain(&shortening).chain(of_ports);
        if all.into_iter().any(|x| !x.is_finite()) {
            return refuse("the system has a value that is not finite");
        }
        if angular_frequency.iter().any(|w| *w <= 0.0)
            || system.ports.iter().any(|port| port.flexibility < 0.0)
        {
            return refuse("a natural frequency is not positive, or a flexibility is negative");
        }
        if system.driven.iter().chain(&system.sensors).any(|port| !system.ports[*port].is_linear()) {
            return refuse("an exciter or a sensor is at a port that shortens");
        }
        let ports: Vec<ModalPort> = system.ports.iter().map(|port| ModalPort::new(port, modes)).collect();
        let mut driven = vec![0.0; modes];
        for port in &system.driven {
            driven.iter_mut().zip(&ports[*port].shape).for_each(|(sum, value)| *sum += value);
        }
        let sensors = system.sensors.iter().map(|port| ports[*port].shape.clone());
        Ok(Self {
            angular_frequency: angular_frequency.clone(),
            damping_ratio: damping_ratio.clone(),
            shortening,
            observed: sensors.chain([driven.clone()]).collect(),
            driven,
            elements: system.elements.clone(),
            ports,
        })
    }

    /// Dynamic stiffness ω² − Ω² + 2 i ζ ω Ω of a mode at the angular frequency `speed` (rad/s), per unit of modal mass.
    pub fn dynamic_stiffness(&self, mode: usize, speed: f64) -> Complex<f64> {
        let (natural, ratio) = (self.angular_frequency[mode], self.damping_ratio[mode]);
        Complex::new(natural * natural - speed * speed, 2.0 * ratio * natural * speed)
    }

    /// Number of modes.
    pub fn modes(&self) -> usize {
        self.angular_frequency.len()
    }
}
