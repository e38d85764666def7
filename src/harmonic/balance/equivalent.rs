//! Equivalent linearisation: a contact as the spring and damper that do the same work at the amplitude at hand
//! (describing function, Krylov & Bogoliubov).

use nalgebra::Complex;

use crate::harmonic::HarmonicError;

const ROUNDS: usize = 20;
/// Change of every stiffness in a round, as a fraction of it, that counts as none.
const SETTLED: f64 = 0.01;

/// Spring (N/m) and damper (N s/m) in place of a contact.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Equivalent {
    pub stiffness: f64,
    pub damping: f64,
}

impl Equivalent {
    /// The nearest to a contact by cosine and sine coefficients of its harmonics: `(order, force, displacement)`.
    pub fn nearest(
        angular_frequency: f64,
        harmonics: impl Iterator<Item = (usize, [f64; 2], [f64; 2])>,
    ) -> Self {
        let (mut along, mut squares, mut rates, mut power) = (0.0, 0.0, 0.0, 0.0);
        for (order, force, u) in harmonics {
            let h = order as f64;
            let square = u[0] * u[0] + u[1] * u[1];
            along += force[0] * u[0] + force[1] * u[1];
            squares += square;
            rates += h * h * square;
            power += h * (force[0] * u[1] - force[1] * u[0]);
        }
        if squares == 0.0 {
            return Self::default();
        }
        let damping = power / (angular_frequency * rates);
        Self { stiffness: (along / squares).max(0.0), damping: damping.max(0.0) }
    }

    /// Halfway between both, which tames the alternation of stiff-small and soft-large.
    pub fn averaged(self, other: Self) -> Self {
        Self {
            stiffness: 0.5 * (self.stiffness + other.stiffness),
            damping: 0.5 * (self.damping + other.damping),
        }
    }

    /// Force over displacement at a frequency of `speed` (rad/s).
    pub fn dynamic(self, speed: f64) -> Complex<f64> {
        Complex::new(self.stiffness, self.damping * speed)
    }
}

/// Rounds from `contacts` on, until their stiffness no longer changes: `round` has the structure respond with such
/// contacts, and measures what they do then.
pub(super) fn settle(
    mut contacts: Vec<Equivalent>,
    mut round: impl FnMut(&[Equivalent]) -> Result<Vec<Equivalent>, HarmonicError>,
) -> Result<(), HarmonicError> {
    for _ in 0..ROUNDS {
        let measured = round(&contacts)?;
        let mut settled = true;
        for (old, new) in contacts.iter_mut().zip(measured) {
            let next = old.averaged(new);
            settled &= (next.stiffness - old.stiffness).abs() <= SETTLED * old.stiffness.abs();
            *old = next;
        }
        if settled {
            break;
        }
    }
    Ok(())
}
