//! One mechanical system: a linear core, named ports, elements at ports.

use std::sync::Arc;

use crate::contact::{ContactLaw, SlipSlap};

/// A sparse row: `(degree of freedom, factor)`, e.g. a relative displacement `[(1, 1.0), (0, -1.0)]`.
pub type Row = Vec<(usize, f64)>;

/// Entries `(row, column, value)` of a symmetric matrix, both triangles, each place once, sorted.
pub type Entries = Vec<(usize, usize, f64)>;

/// `M q̈ + C q̇ + K q + Σ Jₚ(q)ᵀ Fₚ = Σ bₖ fₖ(t)`.
///
/// A new structure is a builder of it, a new physics an [`Element`]; solvers know neither.
///
/// ```
/// use std::sync::Arc;
/// use stickslip::contact::Jenkins;
/// use stickslip::system::{Core, Element, Port, System};
///
/// // A mass of 2 kg on a spring of 50 N/m, with a friction contact to the ground, driven at the mass.
/// let mass = Port::linear("mass", vec![(0, 1.0)]);
/// let contact = Element::Law { port: 0, law: Arc::new(Jenkins::new(30.0, 0.4)?), normal_load: 2.0 };
/// let system = System {
///     core: Core::Matrices {
///         size: 1,
///         mass: vec![(0, 0, 2.0)],
///         damping: vec![(0, 0, 0.1)],
///         stiffness: vec![(0, 0, 50.0)],
///     },
///     shortening: vec![],
///     ports: vec![mass],
///     elements: vec![contact],
///     driven: vec![0],
///     sensors: vec![0],
/// };
/// assert!(system.ports[0].is_linear());
/// # Ok::<(), stickslip::contact::LawError>(())
/// ```
#[derive(Debug, Clone)]
pub struct System {
    /// M, C and K.
    pub core: Core,
    /// G of the shortening `½ qᵀG q` (m), row-major and symmetric; empty where no port shortens.
    pub shortening: Vec<f64>,
    /// Where forces act and motion is seen.
    pub ports: Vec<Port>,
    /// What acts at ports.
    pub elements: Vec<Element>,
    /// Ports on which exciters push, as places in [`System::ports`]: `+ b f(t)` on the right-hand side.
    pub driven: Vec<usize>,
    /// Ports that are read, as places in [`System::ports`].
    pub sensors: Vec<usize>,
}

/// The linear part of a system.
///
/// ```
/// use stickslip::system::Core;
/// let core = Core::Modal { angular_frequency: vec![300.0, 1900.0], damping_ratio: vec![0.003; 2] };
/// assert_eq!(core.size(), 2);
/// ```
#[derive(Debug, Clone, PartialEq)]
pub enum Core {
    /// Coordinates of unit mass, each with a stiffness and a damper of its own.
    Modal {
        /// ωᵢ (rad/s).
        angular_frequency: Vec<f64>,
        /// ζᵢ (1).
        damping_ratio: Vec<f64>,
    },
    /// Symmetric matrices, both triangles of each.
    Matrices {
        /// Number of degrees of freedom.
        size: usize,
        /// M (kg).
        mass: Entries,
        /// C (N s/m).
        damping: Entries,
        /// K (N/m).
        stiffness: Entries,
    },
}

impl Core {
    /// Number of coordinates.
    pub fn size(&self) -> usize {
        match self {
            Self::Modal { angular_frequency, .. } => angular_frequency.len(),
            Self::Matrices { size, .. } => *size,
        }
    }
}

/// A generalised displacement `u = b·q − γ ½ qᵀG q − a F` (m), along which a force acts by `J = b − γ G q`.
///
/// ```
/// use stickslip::system::Port;
/// // The stretch between two coordinates.
/// let port = Port::linear("joint", vec![(0, -1.0), (1, 1.0)]);
/// assert!(port.is_linear());
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Port {
    /// Its name, the same in model files, CSV columns and FMI variables: `m2`, `x=0.55`, `contact`.
    pub name: String,
    /// b.
    pub row: Row,
    /// γ: 1 where the shortening pulls the port inwards, −1 (with b = 0) for the shortening itself, 0 where the port is
    /// linear.
    pub shortening: f64,
    /// a (m/N): flexibility in series with the element at the port.
    pub flexibility: f64,
}

impl Port {
    /// A port that is linear in the coordinates.
    pub fn linear(name: &str, row: Row) -> Self {
        Self { name: name.to_owned(), row, shortening: 0.0, flexibility: 0.0 }
    }

    /// Whether the displacement is linear in the coordinates.
    pub fn is_linear(&self) -> bool {
        self.shortening == 0.0
    }
}

/// What acts at a port.
///
/// ```
/// use std::sync::Arc;
/// use stickslip::contact::Jenkins;
/// use stickslip::system::Element;
/// let friction = Element::Law { port: 2, law: Arc::new(Jenkins::new(2e6, 0.5)?), normal_load: 100.0 };
/// let spring = Element::Springs { ports: [0, 1], stiffness: [[50.0, -50.0], [-50.0, 50.0]] };
/// assert_eq!((friction.ports(), spring.ports()), (&[2][..], &[0, 1][..]));
/// # Ok::<(), stickslip::contact::LawError>(())
/// ```
#[derive(Debug, Clone)]
pub enum Element {
    /// A restoring force by a law: a friction contact, a spring, a damper, drag.
    Law {
        /// Where, as a place in [`System::ports`].
        port: usize,
        /// The law.
        law: Arc<dyn ContactLaw>,
        /// Constant normal load (N); laws that know none ignore it.
        normal_load: f64,
    },
    /// Linear springs between the motions of two ports: `F = K u`, K symmetric.
    Springs {
        /// Where, as places in [`System::ports`].
        ports: [usize; 2],
        /// K (N/m).
        stiffness: [[f64; 2]; 2],
    },
    /// A contact in two directions at once, whose friction follows the normal force.
    SlipSlap {
        /// Tangential and normal, as places in [`System::ports`]; the normal displacement opens the contact.
        ports: [usize; 2],
        /// The contact.
        contact: Arc<SlipSlap>,
    },
    /// Masses that move with two ports, beside those of the core: `F = M ü`, M symmetric.
    Inertia {
        /// Where, as places in [`System::ports`].
        ports: [usize; 2],
        /// M (kg).
        mass: [[f64; 2]; 2],
    },
    /// A mass on a spring that follows a port: `m p̈ + 2 ζ ω m ṗ + m ω² (p − u) = 0`, `F = m ω² (u − p)`. Solvers that know
    /// none take [`System::expanded`].
    Resonator {
        /// Where it hangs, as a place in [`System::ports`].
        port: usize,
        /// m (kg).
        mass: f64,
        /// ω (rad/s), the port held.
        angular_frequency: f64,
        /// ζ (1), of a damper between the mass and the ground.
        damping_ratio: f64,
    },
    /// A restoring force (N) given from outside, as by another simulator.
    Outside {
        /// Where, as a place in [`System::ports`].
        port: usize,
    },
}

impl Element {
    /// Where it acts, as places in [`System::ports`].
    pub fn ports(&self) -> &[usize] {
        match self {
            Self::Law { port, .. } | Self::Resonator { port, .. } | Self::Outside { port } => {
                std::slice::from_ref(port)
            }
            Self::Springs { ports, .. } | Self::SlipSlap { ports, .. } | Self::Inertia { ports, .. } => ports,
        }
    }
}

impl System {
    /// The port called `name`, as a place in [`System::ports`].
    pub fn port(&self, name: &str) -> Option<usize> {
        self.ports.iter().position(|port| port.name == name)
    }

    /// The laws in the order of the elements: where each acts, as a place in [`System::ports`], and its normal load (N).
    pub fn laws(&self) -> impl Iterator<Item = (usize, &Arc<dyn ContactLaw>, f64)> {
        self.elements.iter().filter_map(|element| match element {
            Element::Law { port, law, normal_load } => Some((*port, law, *normal_load)),
            _ => None,
        })
    }

    /// The contacts in two directions, in the order of the elements, with their ports as places in [`System::ports`].
    pub fn slip_slaps(&self) -> impl Iterator<Item = ([usize; 2], &Arc<SlipSlap>)> {
        self.elements.iter().filter_map(|element| match element {
            Element::SlipSlap { ports, contact } => Some((*ports, contact)),
            _ => None,
        })
    }

    /// Whether every port with an element is linear in the coordinates.
    pub fn is_linear_at_ports(&self) -> bool {
        self.elements.iter().flat_map(Element::ports).all(|port| self.ports[*port].is_linear())
    }
}
