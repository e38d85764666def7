//! Motions that are always stable, whatever they are: no multiplier has to be computed.
//!
//! Between two motions of a structure whose mass is positive, whose damping and stiffness nowhere negative, on sliders
//! without play, the energy of the difference, `½ δẋᵀM δẋ + ½ δxᵀK δx + ½ Σ δTᵢ²/kᵢ`, only falls: dampers take from it,
//! and so does every slip, since a slider's force is a monotone function of the rate of its slip (a play operator is a
//! contraction; see Visintin, *Differential Models of Hysteresis*, 1994, III.2).

use nalgebra::{Cholesky, DMatrix};

use crate::contact::Slider;
use crate::system::{Entries, LinearStructure};
use crate::time::LoadedContact;

/// Most degrees of freedom of a matrix that is factored to see its sign.
const MOST_FACTORED: usize = 300;
/// What rounding may leave of zero, as a fraction of the diagonal.
const ROUNDING: f64 = 1e-12;

/// Whether the energy of every disturbance falls. False where that cannot be seen.
pub(super) fn only_loses(structure: &LinearStructure, contacts: &[LoadedContact]) -> bool {
    contacts.iter().all(is_monotone) && is_passive(structure, &structure.stiffness)
}

/// Whether the law is sliders without play, perhaps with a damper beside them.
fn is_monotone(contact: &LoadedContact) -> bool {
    let mut sliders: Vec<Slider> = Vec::new();
    let no_play = |slider: &Slider| {
        let limits = slider.lower_limit >= 0.0 && slider.upper_limit >= 0.0;
        limits && slider.stiffness >= 0.0 && slider.play_below == slider.play_above
    };
    let damping = contact.law.sliders_and_damper(contact.normal_load, &mut sliders);
    damping.is_some_and(|damping| damping >= 0.0) && sliders.iter().all(no_play)
}

/// Whether the structure with this stiffness has positive masses and gains energy nowhere.
pub(super) fn is_passive(structure: &LinearStructure, stiffness: &Entries) -> bool {
    let size = structure.size;
    structure.check_symmetry().is_ok()
        && is_positive(&structure.mass, size, -ROUNDING)
        && is_positive(&structure.damping, size, ROUNDING)
        && is_positive(stiffness, size, ROUNDING)
}

/// Whether a symmetric matrix is positive definite, with a fraction `shift` of its diagonal added.
fn is_positive(entries: &Entries, size: usize, shift: f64) -> bool {
    let (mut diagonal, mut beside) = (vec![0.0; size], vec![0.0; size]);
    for &(i, j, value) in entries {
        if i >= size || j >= size || !value.is_finite() {
            return false;
        }
        if i == j { diagonal[i] += value } else { beside[i] += value.abs() }
    }
    let pairs = || diagonal.iter().zip(&beside);
    // A row of zeros is a direction without springs, dampers – or mass.
    let empty = |(d, b): (&f64, &f64)| *d == 0.0 && *b == 0.0 && shift > 0.0;
    if pairs().any(|pair| *pair.0 <= 0.0 && !empty(pair)) {
        return false;
    }
    // Gershgorin's circles tell of all that springs and dampers between masses make up.
    if pairs().all(|(d, b)| *b <= (1.0 + shift) * d) {
        return true;
    }
    if size > MOST_FACTORED {
        return false;
    }
    let scale = |i: usize| if diagonal[i] > 0.0 { diagonal[i].sqrt().recip() } else { 1.0 };
    let mut matrix = DMatrix::identity(size, size) * (size as f64 * shift.max(0.0));
    for &(i, j, value) in entries {
        matrix[(i, j)] += scale(i) * value * scale(j);
    }
    (0..size).filter(|i| diagonal[*i] == 0.0).for_each(|i| matrix[(i, i)] = 1.0);
    Cholesky::new(matrix).is_some()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_matrix_is_positive_where_its_eigenvalues_are() {
        let free = vec![(0, 0, 3.0), (1, 1, 3.0), (0, 1, -3.0), (1, 0, -3.0)];
        assert!(is_positive(&free, 2, ROUNDING), "a free body's springs");
        assert!(!is_positive(&free, 2, -ROUNDING), "are no mass");
        let full = |off: f64| vec![(0, 0, 1.0), (1, 1, 4.0), (0, 1, off), (1, 0, off)];
        assert!(is_positive(&full(1.9), 2, ROUNDING) && !is_positive(&full(2.1), 2, ROUNDING));
        assert!(is_positive(&vec![], 2, ROUNDING) && !is_positive(&vec![], 2, -ROUNDING));
        assert!(!is_positive(&vec![(0, 0, -1.0), (1, 1, 1.0)], 2, ROUNDING));
        assert!(!is_positive(&vec![(0, 1, 1.0), (1, 0, 1.0)], 2, ROUNDING));
    }
}
