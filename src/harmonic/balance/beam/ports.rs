//! The ports that a balance is condensed to.

use std::ops::Range;

use crate::harmonic::HarmonicError;
use crate::system::{Element, ModalBeam, Port, Row, StructureError, System};

/// Names of the ports that a beam may be condensed to though it has no element there: a neighbour may.
const WITHOUT_ELEMENT: [&str; 2] = ["shortening", "string"];

/// The beam as a system, with every port that any beam has.
pub(super) fn system_of(beam: &ModalBeam) -> Result<System, HarmonicError> {
    let mut system = beam.system(None).map_err(|error| match error {
        StructureError::Law(error) => error.into(),
        _ => HarmonicError::InvalidInput("a list of the beam does not have one entry per mode"),
    })?;
    for name in WITHOUT_ELEMENT {
        if system.port(name).is_none() {
            let shortening = if name == "shortening" { -1.0 } else { 0.0 };
            system.ports.push(Port { shortening, ..Port::linear(name, Row::new()) });
        }
    }
    Ok(system)
}

/// The ports, besides that of the contact, to whose displacements a balance is condensed: two such lists are equal where
/// the names are.
#[derive(Debug, Clone, Default)]
pub(crate) struct Ports(Vec<Port>);

impl PartialEq for Ports {
    fn eq(&self, other: &Self) -> bool {
        self.names().eq(other.names())
    }
}

impl Ports {
    /// Those at which elements of `beam` act; none where the beam makes no system.
    pub fn of(beam: &ModalBeam) -> Self {
        let Ok(system) = beam.system(None) else { return Self::default() };
        let acting = system.elements.iter().filter(|element| !matches!(element, Element::Outside { .. }));
        let places = acting.flat_map(Element::ports);
        places.fold(Self::default(), |all, place| all.with(system.ports[*place].clone()))
    }

    /// These and one more.
    pub fn with(mut self, port: Port) -> Self {
        if let Err(place) = self.0.binary_search_by(|known| known.name.cmp(&port.name)) {
            self.0.insert(place, port);
        }
        self
    }

    /// These and others.
    pub fn or(self, others: &Self) -> Self {
        others.0.iter().cloned().fold(self, Self::with)
    }

    /// The names, ascending.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.0.iter().map(|port| port.name.as_str())
    }

    /// Where `name` is, counted with the contact's port first.
    pub fn place(&self, name: &str) -> Option<usize> {
        if name == "contact" {
            return Some(0);
        }
        self.names().position(|known| known == name).map(|place| place + 1)
    }

    /// The ports on a beam of `modes` modes as `system` has them, the contact's first with `wide` coefficients, the others
    /// with `count`.
    pub(super) fn condensed(
        &self,
        system: &System,
        modes: usize,
        wide: usize,
        count: usize,
    ) -> Vec<CondensedPort> {
        let contact = system.port("contact").map(|place| &system.ports[place]);
        let own =
            |port: &Port| system.port(&port.name).map_or(port.clone(), |place| system.ports[place].clone());
        let all = contact.cloned().into_iter().chain(self.0.iter().map(own));
        let mut first = 0;
        all.map(|port| {
            let length = if first == 0 { wide } else { count };
            let port = CondensedPort::new(&port, modes, first..first + length);
            first += length;
            port
        })
        .collect()
    }
}

/// A port with the unknowns that are the coefficients of its displacement.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct CondensedPort {
    /// b, an entry per mode.
    pub shape: Vec<f64>,
    /// γ, as [`Port::shortening`].
    pub shortening: f64,
    /// a (m/N).
    pub flexibility: f64,
    pub rows: Range<usize>,
}

impl CondensedPort {
    pub fn new(port: &Port, modes: usize, rows: Range<usize>) -> Self {
        let mut shape = vec![0.0; modes];
        for (mode, value) in port.row.iter().filter(|(mode, _)| *mode < modes) {
            shape[*mode] += value;
        }
        Self { shape, shortening: port.shortening, flexibility: port.flexibility, rows }
    }
}
