//! The structure whose contact is looked for, in modes, without that contact.

use nalgebra::Complex;

use crate::system::{ModalBeam, ModalPinRig};

/// A structure in modes, with what is read, and where and how the contact acts on it.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::identify) struct Structure {
    /// ωᵢ (rad/s) and ζᵢ of the modes.
    pub angular_frequency: Vec<f64>,
    pub damping_ratio: Vec<f64>,
    /// Gᵢⱼ (1/(kg m)), row-major.
    pub shortening: Vec<f64>,
    pub excitation_shape: Vec<f64>,
    /// Shapes at the sensors.
    pub sensors: Vec<Vec<f64>>,
    /// The contact: along the beam, then across it if it acts there, too.
    pub directions: Vec<Direction>,
    /// Stiffnesses (N/m) and rows of springs to the ground that the modes do not have; negative where they have one too many.
    pub springs: Vec<(f64, Vec<f64>)>,
    pub hanging: Option<Hanging>,
}

/// How the contact acts in one direction.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::identify) struct Direction {
    /// The contact's displacement in every mode.
    pub shape: Vec<f64>,
    /// Whether the shortening of the beam takes part in it.
    pub shortened: bool,
    /// Flexibility in series (m/N).
    pub flexibility: f64,
}

/// A mass that hangs from the end of the beam and moves along it with its shortening.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::identify) struct Hanging {
    /// kg; its inertia without the shortening is in the modes.
    pub mass: f64,
    pub shape: Vec<f64>,
}

impl From<&ModalBeam> for Structure {
    fn from(beam: &ModalBeam) -> Self {
        Self {
            angular_frequency: beam.angular_frequency.clone(),
            damping_ratio: beam.damping_ratio.clone(),
            shortening: beam.shortening.clone(),
            excitation_shape: beam.excitation_shape.clone(),
            sensors: beam.sensors.iter().map(|sensor| sensor.shape.clone()).collect(),
            directions: vec![Direction {
                shape: beam.contact_shape.clone(),
                shortened: true,
                flexibility: beam.axial_flexibility,
            }],
            springs: Vec::new(),
            hanging: None,
        }
    }
}

impl From<&ModalPinRig> for Structure {
    /// The springs that the modes have in place of the contact are taken off.
    fn from(rig: &ModalPinRig) -> Self {
        let shapes = [&rig.tangential_shape, &rig.normal_shape];
        let direction = |(place, shape): (usize, &&Vec<f64>)| Direction {
            shape: shape.to_vec(),
            shortened: place == 0,
            flexibility: 0.0,
        };
        Self {
            angular_frequency: rig.angular_frequency.clone(),
            damping_ratio: rig.damping_ratio.clone(),
            shortening: rig.shortening.clone(),
            excitation_shape: rig.excitation_shape.clone(),
            sensors: rig.sensors.iter().map(|(_, shape)| shape.clone()).collect(),
            directions: shapes.iter().enumerate().map(direction).collect(),
            springs: rig.stuck_stiffness.into_iter().zip(shapes).map(|(k, b)| (-k, b.clone())).collect(),
            hanging: Some(Hanging { mass: rig.hanging_mass, shape: rig.hanging_shape.clone() }),
        }
    }
}

impl Structure {
    /// Dynamic stiffness of mode `i` at `omega` (rad/s).
    pub fn stiffness(&self, i: usize, omega: f64) -> Complex<f64> {
        let (natural, damping) = (self.angular_frequency[i], self.damping_ratio[i]);
        Complex::new(natural * natural - omega * omega, 2.0 * damping * natural * omega)
    }
}

impl Direction {
    /// Displacement of the contact by mode `i` of a beam with this `slope`.
    pub fn lever(&self, i: usize, slope: f64) -> f64 {
        if self.shortened { self.shape[i] - slope } else { self.shape[i] }
    }
}
