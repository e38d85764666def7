//! Resonators as coordinates of their own, for solvers that know none.

use std::borrow::Cow;

use super::ports::{Core, Element, Port, Row, System};

/// A resonator with its coordinate.
#[derive(Debug, Clone, Copy)]
struct Hung {
    /// Its place in [`System::elements`].
    element: usize,
    /// Where it hangs, as a place in [`System::ports`], and where its mass is.
    port: usize,
    own: usize,
    /// Its coordinate, which moves the mass by `lever`.
    coordinate: usize,
    lever: f64,
    mass: f64,
    angular_frequency: f64,
    damping_ratio: f64,
    /// k (N/m).
    stiffness: f64,
}

impl System {
    /// The same system whose resonators are coordinates with springs: coordinates, ports and elements that are there stay in
    /// their places.
    ///
    /// Springs kᵢ to masses at pᵢ and an element with the force T pull at a port with the flexibility a by
    /// `F = T + Σ kᵢ (u − pᵢ)`, `u = y − a F`, y being the displacement in front of the flexibility. With
    /// `s = 1/(1 + a Σ kᵢ)` that is an element at `u = s (y + a Σ kᵢ pᵢ) − s a T`, and springs with the potential
    /// `½ (s Σ kᵢ y² − 2 s y Σ kᵢ pᵢ + Σ kᵢ pᵢ² − s a (Σ kᵢ pᵢ)²)`.
    pub fn expanded(&self) -> Cow<'_, Self> {
        if !self.elements.iter().any(|element| matches!(element, Element::Resonator { .. })) {
            return Cow::Borrowed(self);
        }
        let mut system = self.clone();
        let hung = system.add_masses();
        system.shortening = widened(&self.shortening, self.core.size(), system.core.size());
        for port in 0..self.ports.len() {
            let here: Vec<Hung> = hung.iter().copied().filter(|one| one.port == port).collect();
            if !here.is_empty() {
                system.hang(port, &here);
            }
        }
        Cow::Owned(system)
    }

    /// A coordinate and a port for the mass of every resonator.
    fn add_masses(&mut self) -> Vec<Hung> {
        let mut hung = Vec::new();
        let modal = matches!(self.core, Core::Modal { .. });
        for (element, hanging) in self.elements.clone().into_iter().enumerate() {
            let Element::Resonator { port, mass, angular_frequency, damping_ratio } = hanging else {
                continue;
            };
            let coordinate = self.core.size();
            self.core.grow();
            // Coordinates of a modal core have a mass of one.
            let lever = if modal { 1.0 / mass.sqrt() } else { 1.0 };
            let own = self.ports.len();
            let name = if hung.is_empty() { "string".into() } else { format!("string {}", hung.len() + 1) };
            self.ports.push(Port::linear(&name, vec![(coordinate, lever)]));
            let stiffness = mass * angular_frequency * angular_frequency;
            hung.push(Hung {
                element,
                port,
                own,
                coordinate,
                lever,
                mass,
                angular_frequency,
                damping_ratio,
                stiffness,
            });
        }
        hung
    }

    /// Hangs resonators at a port.
    fn hang(&mut self, port: usize, hung: &[Hung]) {
        let Port { row, shortening, flexibility, name } = self.ports[port].clone();
        let all: f64 = hung.iter().map(|one| one.stiffness).sum();
        let share = 1.0 / (1.0 + flexibility * all);
        let in_front = self.ports.len();
        let name = format!("{name} in front");
        self.ports.push(Port { name, row: row.clone(), shortening, flexibility: 0.0 });
        for (place, one) in hung.iter().enumerate() {
            let pull = share * one.stiffness;
            // The rest of the spring, which acts where all but its mass is held, is in the core.
            let stiffness = [[pull, -pull], [-pull, 0.0]];
            self.elements[one.element] = Element::Springs { ports: [in_front, one.own], stiffness };
            for other in &hung[..place] {
                let coupled = -flexibility * pull * other.stiffness;
                let stiffness = [[0.0, coupled], [coupled, 0.0]];
                self.elements.push(Element::Springs { ports: [other.own, one.own], stiffness });
            }
            self.core.set(one, 1.0 - flexibility * pull);
        }
        let of_masses = hung.iter().map(|one| (one.coordinate, flexibility * one.stiffness * one.lever));
        let row: Row =
            row.into_iter().chain(of_masses).map(|(place, value)| (place, share * value)).collect();
        let own = &mut self.ports[port];
        (own.row, own.shortening, own.flexibility) = (row, share * shortening, share * flexibility);
    }
}

impl Core {
    /// One more coordinate.
    fn grow(&mut self) {
        match self {
            Self::Modal { angular_frequency, damping_ratio } => {
                angular_frequency.push(0.0);
                damping_ratio.push(0.0);
            }
            Self::Matrices { size, .. } => *size += 1,
        }
    }

    /// Mass, damper and what is `left` of the spring where all but the mass is held, as a fraction of it.
    fn set(&mut self, hung: &Hung, left: f64) {
        let Hung { coordinate: at, mass, angular_frequency: natural, damping_ratio: ratio, .. } = *hung;
        match self {
            Self::Modal { angular_frequency, damping_ratio } => {
                angular_frequency[at] = natural * left.sqrt();
                damping_ratio[at] = ratio / left.sqrt();
            }
            Self::Matrices { mass: masses, damping, stiffness, .. } => {
                masses.push((at, at, mass));
                damping.push((at, at, 2.0 * ratio * natural * mass));
                stiffness.push((at, at, left * hung.stiffness));
            }
        }
    }
}

/// A matrix, row-major, with zeros for coordinates that it lacks; empty as it was.
fn widened(matrix: &[f64], size: usize, wider: usize) -> Vec<f64> {
    if matrix.is_empty() {
        return Vec::new();
    }
    let mut all = vec![0.0; wider * wider];
    for (to, from) in all.chunks_exact_mut(wider.max(1)).zip(matrix.chunks_exact(size.max(1))) {
        to[..size].copy_from_slice(from);
    }
    all
}
