//! A beam in its modes, and the system that it makes.

use std::sync::Arc;

use crate::contact::{ContactLaw, Drag};
use crate::system::{Core, Element, HangingMass, Port, Row, StructureError, System};

/// A beam reduced to mass-normalised modes with a contact at its end.
///
/// `q̈ᵢ + 2 ζᵢ ωᵢ q̇ᵢ + ωᵢ² qᵢ + T [cᵢ − Σⱼ Gᵢⱼ qⱼ] = f φᵢ(S)` and, at the contact,
/// `u = Σ cᵢ qᵢ − ½ qᵀ G q − T · axial_flexibility` with `cᵢ = r φᵢ'(L)`.
///
/// Effects add to T the pull of what hangs at the contact and to the left-hand side of mode i stretching of the mid-plane,
/// `κ e Σⱼ Gᵢⱼ qⱼ` with `e = qᵀ G q`, and drag at the excitation, `d |ẏ| ẏ φᵢ(S)` with `y = Σ φᵢ(S) qᵢ`; see
/// [`ModalBeam::with_changes`].
///
/// Every mode has a positive slope at the contact, so `contact_shape` has the sign of the offset.
#[derive(Debug, Clone, PartialEq)]
pub struct ModalBeam {
    /// ωᵢ (rad/s), ascending.
    pub angular_frequency: Vec<f64>,
    /// ζᵢ (1).
    pub damping_ratio: Vec<f64>,
    /// cᵢ = r φᵢ'(L) (kg^-1/2).
    pub contact_shape: Vec<f64>,
    /// φᵢ(S) (kg^-1/2).
    pub excitation_shape: Vec<f64>,
    /// Gᵢⱼ = ∫ φᵢ' φⱼ' dx (1/(kg m)), row-major, symmetric.
    pub shortening: Vec<f64>,
    /// Flexibility in series with the contact (m/N): L/(E A), with the static correction also
    /// r² times the rotational compliance that the modes lack.
    pub axial_flexibility: f64,
    /// κ (N/m): stretching, the derivative of the potential `κ/4 (qᵀ G q)²`; 0 for none.
    pub stretching_stiffness: f64,
    /// d (N s²/m²): drag at the excitation; 0 for none.
    pub quadratic_damping: f64,
    /// Resonators hung at the contact, which follow u; none of them is in the modes.
    pub hung: Vec<HangingMass>,
    /// Sensors.
    pub sensors: Vec<Sensor>,
    /// Where forces from outside push across the beam besides the contact at its end: each adds `Tₖ φᵢ(xₖ)` to the
    /// left-hand side of mode i.
    pub contact_points: Vec<Sensor>,
}

/// A sensor on a [`ModalBeam`], or another place of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Sensor {
    /// Distance from the clamp (m).
    pub position: f64,
    /// φᵢ(position) (kg^-1/2).
    pub shape: Vec<f64>,
}

impl ModalBeam {
    /// The beam as a system. Ports: the sensors and the contact points (`x=0.55`), `excitation`, `contact`; where
    /// the mid-plane stretches `shortening`. `contact` is the law at the end with its
    /// normal load (N); the contact points, and the end without a law, take forces from outside.
    ///
    /// Stretching has the potential `κ h²` of the shortening h.
    ///
    /// # Errors
    /// Lists without one entry per mode, numbers that make no law.
    ///
    /// ```
    /// use std::sync::Arc;
    /// use stickslip::contact::{ContactLaw, Jenkins};
    /// use stickslip::system::{Beam, Damping, ModalBeam};
    /// # let beam = Beam {
    /// #     length: 0.6, width: 0.04, thickness: 0.005, density: 7850.0, youngs_modulus: 2e11,
    /// #     modes: 4, static_correction: false, damping: Damping::Uniform(0.003), point_masses: vec![],
    /// #     offset: 0.006, rotational_stiffness: 0.0, clamp_stiffness: None,
    /// #     excitation_position: 0.55, sensors: vec![0.3], contact_points: vec![],
    /// # };
    /// let law: Arc<dyn ContactLaw> = Arc::new(Jenkins::new(7.9e6, 0.3)?);
    /// let system = ModalBeam::new(&beam)?.system(Some((law, 150.0)))?;
    /// let ports: Vec<&str> = system.ports.iter().map(|port| port.name.as_str()).collect();
    /// assert_eq!(ports, ["x=0.3", "excitation", "contact"]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn system(&self, contact: Option<(Arc<dyn ContactLaw>, f64)>) -> Result<System, StructureError> {
        self.check_lengths()?;
        let row = |shape: &[f64]| -> Row { shape.iter().copied().enumerate().collect() };
        let places = self.sensors.iter().chain(&self.contact_points);
        let mut ports: Vec<Port> =
            places.map(|at| Port::linear(&format!("x={}", at.position), row(&at.shape))).collect();
        let excitation = ports.len();
        ports.push(Port::linear("excitation", row(&self.excitation_shape)));
        let end = ports.len();
        ports.push(Port {
            name: "contact".into(),
            row: row(&self.contact_shape),
            shortening: 1.0,
            flexibility: self.axial_flexibility,
        });
        let mut elements = vec![match contact {
            Some((law, normal_load)) => Element::Law { port: end, law, normal_load },
            None => Element::Outside { port: end },
        }];
        let first_point = self.sensors.len();
        elements.extend((first_point..excitation).map(|port| Element::Outside { port }));
        if self.quadratic_damping != 0.0 {
            let law = Arc::new(Drag::new(self.quadratic_damping)?);
            elements.push(Element::Law { port: excitation, law, normal_load: 0.0 });
        }
        if self.stretching_stiffness != 0.0 {
            let shortening = ports.len();
            ports.push(Port { shortening: -1.0, ..Port::linear("shortening", Row::new()) });
            let stiffness = [[2.0 * self.stretching_stiffness, 0.0], [0.0, 0.0]];
            elements.push(Element::Springs { ports: [shortening; 2], stiffness });
        }
        let ratio = self.damping_ratio.first().copied().unwrap_or(0.0);
        elements.extend(self.hung.iter().map(|one| one.at(end, ratio)));
        Ok(System {
            core: Core::Modal {
                angular_frequency: self.angular_frequency.clone(),
                damping_ratio: self.damping_ratio.clone(),
            },
            shortening: self.shortening.clone(),
            ports,
            elements,
            driven: vec![excitation],
            sensors: (0..first_point).collect(),
        })
    }

    fn check_lengths(&self) -> Result<(), StructureError> {
        let modes = self.angular_frequency.len();
        let check = |field: &'static str, expected: usize, found: usize| {
            if expected == found { Ok(()) } else { Err(StructureError::Entries { field, expected, found }) }
        };
        check("angular_frequency", modes.max(1), modes)?;
        check("damping_ratio", modes, self.damping_ratio.len())?;
        check("contact_shape", modes, self.contact_shape.len())?;
        check("excitation_shape", modes, self.excitation_shape.len())?;
        check("shortening", modes * modes, self.shortening.len())?;
        self.sensors.iter().try_for_each(|at| check("sensor shape", modes, at.shape.len()))?;
        self.contact_points.iter().try_for_each(|at| check("contact point's shape", modes, at.shape.len()))
    }
}
