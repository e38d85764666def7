//! The ports that a balance is condensed to.

use std::ops::{Deref, Range};

use crate::harmonic::modal_system::{ModalPort, ModalSystem};
use crate::system::{Element, Port, Row, System};

/// The port that a beam may be condensed to though it has no element there: a neighbour may.
const WITHOUT_ELEMENT: &str = "shortening";

/// The system with every port that any beam has.
pub(super) fn completed(system: &System) -> System {
    let mut system = system.clone();
    if system.port(WITHOUT_ELEMENT).is_none() {
        system.ports.push(Port { shortening: -1.0, ..Port::linear(WITHOUT_ELEMENT, Row::new()) });
    }
    system
}

/// Whether every limit that follows the velocity behind a flexibility is that of the contact, at whose port nothing but
/// resonators acts beside it: others cannot be balanced.
pub(super) fn can_be_in_front(system: &System, ports: &Ports) -> bool {
    let flexible = |element: &Element| {
        element.ports().iter().any(|port| system.ports.get(*port).is_some_and(|port| port.flexibility > 0.0))
    };
    let follows = |element: &Element| {
        flexible(element) && matches!(element, Element::Law { law, .. } if law.limit_follows_velocity())
    };
    let Some((first, others)) = system.elements.split_first() else { return true };
    let beside = |other: &Element| {
        let passive = matches!(other, Element::Resonator { .. } | Element::Outside { .. });
        !passive && other.ports().iter().any(|port| first.ports().contains(port))
    };
    let behind = others.iter().any(follows) || follows(first) && !ports.in_front();
    let shared = ports.in_front() && others.iter().any(beside);
    !behind && !shared
}

/// All ports but those of the sensors, by their names.
pub(super) fn named(completed: &System, modal: &ModalSystem) -> Vec<(String, ModalPort)> {
    let places = 0..completed.ports.len();
    let places = places.filter(|place| !completed.sensors.contains(place));
    places.map(|place| (completed.ports[place].name.clone(), modal.ports[place].clone())).collect()
}

/// The port of the contact, which is that of the first element, and the others to whose displacements a balance is
/// condensed: two such lists are equal where the names are.
#[derive(Debug, Clone)]
pub(crate) struct Ports {
    contact: Port,
    others: Vec<Port>,
    /// Whether the contact's unknown is its displacement in front of its flexibility, not what that leaves of it.
    in_front: bool,
}

impl PartialEq for Ports {
    fn eq(&self, other: &Self) -> bool {
        let same = self.contact.name == other.contact.name && self.in_front == other.in_front;
        same && self.names().eq(other.names())
    }
}

impl Ports {
    /// Those at which elements of `system` act by themselves, and the first in any case.
    pub fn of(system: &System) -> Self {
        let port = |place: &usize| system.ports.get(*place).cloned();
        let contact = system.elements.first().and_then(|element| port(element.ports().first()?));
        let contact = contact.unwrap_or_else(|| Port::linear("contact", Row::new()));
        let acting = system.elements.iter().filter(|element| !matches!(element, Element::Outside { .. }));
        let ports = acting.flat_map(Element::ports).filter_map(port);
        // Behind the flexibility a limit that falls with the speed would make the speed run away within no time: what the
        // flexibility lets go as the limit falls adds to the speed. Such a limit follows that in front.
        let follows =
            |element: &Element| matches!(element, Element::Law { law, .. } if law.limit_follows_velocity());
        let in_front = contact.flexibility > 0.0 && system.elements.first().is_some_and(follows);
        ports.fold(Self { contact, others: Vec::new(), in_front }, Self::with)
    }

    /// That of the contact.
    pub fn contact(&self) -> &Port {
        &self.contact
    }

    /// These and one more.
    pub fn with(mut self, port: Port) -> Self {
        let known = self.others.binary_search_by(|known| known.name.cmp(&port.name));
        if let (Err(place), true) = (known, port.name != self.contact.name) {
            self.others.insert(place, port);
        }
        self
    }

    /// These and others, the contact's unknown being what it is.
    pub fn or(self, others: &Self) -> Self {
        others.others.iter().cloned().fold(self, Self::with)
    }

    /// The same with the contact's displacement in front of its flexibility as unknown.
    pub fn moved_in_front(self) -> Self {
        Self { in_front: true, ..self }
    }

    /// Whether the contact's unknown is its displacement in front of its flexibility.
    pub fn in_front(&self) -> bool {
        self.in_front
    }

    /// The names of the others, ascending.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.others.iter().map(|port| port.name.as_str())
    }

    /// Where `name` is, counted with the contact's port first.
    pub fn place(&self, name: &str) -> Option<usize> {
        std::iter::once(self.contact.name.as_str()).chain(self.names()).position(|known| known == name)
    }

    /// The ports by `modes` modes as `system` has them, the contact's first with `wide` coefficients, the others
    /// with `count`.
    pub(super) fn condensed(
        &self,
        system: &System,
        modes: usize,
        wide: usize,
        count: usize,
    ) -> Vec<CondensedPort> {
        let mut first = 0;
        let mut condensed = Vec::with_capacity(1 + self.others.len());
        for port in std::iter::once(&self.contact).chain(&self.others) {
            let length = if first == 0 { wide } else { count };
            let own = system.port(&port.name).map_or(port, |place| &system.ports[place]);
            condensed.push(CondensedPort { port: ModalPort::new(own, modes), rows: first..first + length });
            first += length;
        }
        condensed
    }
}

/// A port with the unknowns that are the coefficients of its displacement.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct CondensedPort {
    port: ModalPort,
    pub rows: Range<usize>,
}

impl Deref for CondensedPort {
    type Target = ModalPort;

    fn deref(&self) -> &ModalPort {
        &self.port
    }
}
