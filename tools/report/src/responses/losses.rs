//! Where the energy goes: the contact, the structure's own nonlinearities, its dampers.

use std::f64::consts::PI;

use stickslip::harmonic::{Contacting, Point};

use super::Responses;

/// What of the model takes energy.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Losses {
    /// How many of a point's contacts are the model's: the first, both directions of one that slips and slaps, or none. What
    /// comes behind are nonlinearities of the structure itself.
    pub contact: usize,
    /// Entries of the matrix of dampers (N s/m) between the nodes; `None` where the nodes do not tell what the
    /// dampers take.
    pub dampers: Option<Vec<(usize, usize, f64)>>,
    /// Whether nothing but friction takes energy.
    pub undamped: bool,
}

impl Losses {
    /// The model's contact.
    pub(super) fn contact<'p>(&self, point: &'p Point) -> Option<&'p Contacting> {
        point.contacts.first().filter(|_| self.contact > 0)
    }

    /// Energy (J) that the contact takes per cycle.
    pub(super) fn of_contact(&self, point: &Point) -> f64 {
        point.contacts.iter().take(self.contact).map(|contact| contact.dissipated_energy).sum()
    }

    /// Energy (J) that the structure's own nonlinearities take per cycle.
    pub(super) fn of_structure(&self, point: &Point) -> f64 {
        let own = point.contacts.iter().skip(self.contact);
        own.map(|contact| contact.dissipated_energy).sum()
    }

    /// Energy (J) that the dampers take per cycle, where it is known.
    pub(super) fn of_dampers(&self, point: &Point) -> Option<f64> {
        let entries = self.dampers.as_ref()?;
        let pair = |&(i, j, c): &(usize, usize, f64)| -> Option<f64> {
            let pairs = point.nodes.get(i)?.iter().zip(point.nodes.get(j)?).enumerate().skip(1);
            // Coefficient k is of harmonic ⌈k/2⌉.
            Some(c * pairs.map(|(k, (a, b))| (k.div_ceil(2) as f64).powi(2) * a * b).sum::<f64>())
        };
        let sum = entries.iter().map(pair).sum::<Option<f64>>()?;
        Some(PI * point.angular_frequency * sum)
    }
}

impl Responses {
    /// Whether nonlinearities of the structure itself take energy anywhere.
    pub(super) fn structure_takes_energy(&self) -> bool {
        self.points().any(|point| self.losses.of_structure(point) > 0.0)
    }

    /// Why a curve of a structure without dampers may have no end.
    pub(super) fn unbounded_hint(&self) -> &'static str {
        match (self.losses.undamped && self.held.is_none(), self.losses.contact > 0) {
            (false, _) => "",
            (true, true) => {
                " The structure has no dampers: near a resonance friction cannot dissipate the work of a force of \
                 more than 4/π of its limit (4µN/π, where the force acts at the contact), and the response \
                 grows without bound. Reduce the force, or add damping."
            }
            (true, false) => {
                " The structure has no dampers: at a resonance the response grows without bound."
            }
        }
    }
}
