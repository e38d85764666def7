//! The rig in its modes, and the system that it makes.

use super::end::{End, EndMotion};
use super::{PinRig, PinRigModes};
use std::sync::Arc;

use crate::contact::SlipSlap;
use crate::system::beam::checks::check_hung;
use crate::system::beam::damping_ratios;
use crate::system::{Core, Element, HangingMass, Port, Row, StructureError, System};

/// What the pin rests on.
enum Support {
    Contact(Arc<SlipSlap>),
    /// The springs that the modes have.
    Springs,
    /// Forces from outside.
    Outside,
}

/// A pin rig reduced to the modes of its base linear system, in which the contact is two springs.
#[derive(Debug, Clone, PartialEq)]
pub struct ModalPinRig {
    /// ωᵢ (rad/s), ascending.
    pub angular_frequency: Vec<f64>,
    /// ζᵢ (1).
    pub damping_ratio: Vec<f64>,
    /// Gᵢⱼ = ∫ φᵢ' φⱼ' dx (1/(kg m)), row-major.
    pub shortening: Vec<f64>,
    /// r φᵢ'(L) + uᵢ (kg^-1/2): ξ but for the shortening.
    pub tangential_shape: Vec<f64>,
    /// φᵢ(L) + r φᵢ'(L) (kg^-1/2): η.
    pub normal_shape: Vec<f64>,
    /// uᵢ − r φᵢ'(L) + l pᵢ (kg^-1/2): the hanging mass along the beam, but for the shortening.
    pub hanging_shape: Vec<f64>,
    /// φᵢ(S) (kg^-1/2).
    pub excitation_shape: Vec<f64>,
    /// Sensors: their distances from the clamp (m) and φᵢ there (kg^-1/2).
    pub sensors: Vec<(f64, Vec<f64>)>,
    /// The hanging mass (kg).
    pub hanging_mass: f64,
    /// Stiffness (N/m) of the springs that the modes have in place of the contact.
    pub stuck_stiffness: [f64; 2],
    /// Resonators hung at the contact, which follow ξ; none of them is in the modes.
    pub hung: Vec<HangingMass>,
}

impl ModalPinRig {
    /// Reduces a rig to its first `rig.beam.modes` modes.
    ///
    /// # Errors
    /// As [`PinRigModes::new`].
    pub fn new(rig: &PinRig) -> Result<Self, StructureError> {
        let beam = &rig.beam;
        let (modes, end) = (PinRigModes::new(rig, beam.modes)?, End::of(rig));
        let shape_at = |x: f64| (0..beam.modes).filter_map(|mode| modes.displacement(mode, x)).collect();
        let along = |row: &EndMotion| modes.ends().iter().map(|end| row.dot(end)).collect();
        let own: Vec<f64> = beam.point_masses.iter().map(|point| point.position).collect();
        let places = if beam.sensors.is_empty() { own } else { beam.sensors.clone() };
        Ok(Self {
            damping_ratio: damping_ratios(&beam.damping, modes.angular_frequency()),
            shortening: modes.shortening().to_vec(),
            tangential_shape: along(&end.tangential),
            normal_shape: along(&end.normal),
            hanging_shape: along(&end.hanging),
            excitation_shape: shape_at(beam.excitation_position),
            sensors: places.into_iter().map(|x| (x, shape_at(x))).collect(),
            hanging_mass: rig.string.mass,
            stuck_stiffness: rig.stuck_stiffness,
            angular_frequency: modes.angular_frequency().to_vec(),
            hung: Vec::new(),
        })
    }

    /// The rig with resonators hung at the contact.
    ///
    /// # Errors
    /// [`StructureError::OutOfBounds`] for a mass or a frequency that is not positive.
    pub fn with_hung(self, hung: &[HangingMass]) -> Result<Self, StructureError> {
        check_hung(hung)?;
        Ok(Self { hung: hung.to_vec(), ..self })
    }

    /// The rig as a system, its contact `contact` or, without one, the springs of the base linear system.
    ///
    /// Ports: the sensors (`x=0.55`), `excitation`, `contact` (ξ), `contact.normal` (η), `stuck` (ξ but for the shortening),
    /// `hanging` (the mass along the beam, but for the shortening) and `shortening`.
    ///
    /// The springs in the modes are taken away again where there is a contact. The mass's inertia along the beam is `m ḧ` of
    /// `h = hanging − shortening`; what is linear of it is in the modes.
    pub fn system(&self, contact: Option<Arc<SlipSlap>>) -> System {
        self.on(contact.map_or(Support::Springs, Support::Contact))
    }

    /// The same whose contact is not its own: both forces come from outside, S before N, and the springs are taken away.
    pub fn system_from_outside(&self) -> System {
        self.on(Support::Outside)
    }

    fn on(&self, support: Support) -> System {
        let row = |shape: &[f64]| -> Row { shape.iter().copied().enumerate().collect() };
        let mut ports: Vec<Port> =
            self.sensors.iter().map(|(x, shape)| Port::linear(&format!("x={x}"), row(shape))).collect();
        let sensors = 0..ports.len();
        let mut add = |name: &str, shape: &[f64], shortening: f64| {
            ports.push(Port { shortening, ..Port::linear(name, row(shape)) });
            ports.len() - 1
        };
        let excitation = add("excitation", &self.excitation_shape, 0.0);
        let tangential = add("contact", &self.tangential_shape, 1.0);
        let normal = add("contact.normal", &self.normal_shape, 0.0);
        let stuck = add("stuck", &self.tangential_shape, 0.0);
        let hanging = add("hanging", &self.hanging_shape, 0.0);
        let shortening = add("shortening", &[], -1.0);
        let [along, across] = self.stuck_stiffness;
        let springs = |ports: [usize; 2], stiffness| Element::Springs { ports, stiffness };
        let without = || springs([stuck, normal], [[-along, 0.0], [0.0, -across]]);
        let mut elements = match support {
            Support::Contact(contact) => {
                vec![Element::SlipSlap { ports: [tangential, normal], contact }, without()]
            }
            Support::Outside => {
                vec![Element::Outside { port: tangential }, Element::Outside { port: normal }, without()]
            }
            Support::Springs => vec![springs([tangential, stuck], [[along, 0.0], [0.0, -along]])],
        };
        let mass = self.hanging_mass;
        elements.push(Element::Inertia { ports: [hanging, shortening], mass: [[0.0, -mass], [-mass, mass]] });
        let ratio = self.damping_ratio.first().copied().unwrap_or(0.0);
        elements.extend(self.hung.iter().map(|one| one.at(tangential, ratio)));
        let core = Core::Modal {
            angular_frequency: self.angular_frequency.clone(),
            damping_ratio: self.damping_ratio.clone(),
        };
        let (shortening, driven) = (self.shortening.clone(), vec![excitation]);
        System { core, shortening, ports, elements, driven, sensors: sensors.collect() }
    }
}
