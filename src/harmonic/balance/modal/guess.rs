//! Starting points by equivalent linearisation of the contact.

use nalgebra::{Complex, DMatrix, SymmetricEigen};

use super::Balance;
use super::resonator::Resonator;
use crate::harmonic::HarmonicError;
use crate::harmonic::balance::equivalent::{Equivalent, settle};
use crate::harmonic::newton::system::{Operating, PeriodicSystem};

/// Rounds to find the resonance.
const ROUNDS: usize = 12;

/// Start for phase resonance, left in the balance's modal coefficients: angular frequency, force amplitude.
pub(crate) fn resonance(balance: &mut Balance, acceleration: f64) -> Result<(f64, f64), HarmonicError> {
    let modes = balance.modes();
    let mut equivalent = Equivalent { stiffness: stuck_stiffness(balance)?, damping: 0.0 };
    balance.q.fill(0.0);
    let mut angular_frequency = 0.0;
    for _ in 0..ROUNDS {
        let (frequency, vector) = lowest_mode(balance, equivalent.stiffness);
        let seen = (0..modes).map(|i| vector[i] * balance.system.driven[i]).sum::<f64>();
        if seen == 0.0 {
            return Err(HarmonicError::InvalidInput("the excitation does not move the first mode"));
        }
        let settled = (frequency - angular_frequency).abs() < 1e-5 * frequency;
        angular_frequency = frequency;
        let amplitude = acceleration / (frequency * frequency * seen);
        let sines = &mut balance.q[2 * modes..3 * modes];
        sines.iter_mut().zip(&vector).for_each(|(q, shape)| *q = amplitude * shape);
        if settled {
            break;
        }
        equivalent = equivalent.averaged(measure(balance, frequency, equivalent)?);
    }
    let displacement = acceleration / (angular_frequency * angular_frequency);
    balance.displace();
    let start = balance.start(angular_frequency);
    balance.take(&start);
    let loss = balance.viscous_energy(angular_frequency) + balance.dissipated_energy();
    Ok((angular_frequency, loss / (std::f64::consts::PI * displacement)))
}

/// Start for a forced response, left in the balance's modal coefficients.
pub(crate) fn forced(
    balance: &mut Balance,
    angular_frequency: f64,
    excitation: &[f64],
) -> Result<(), HarmonicError> {
    let stuck = Equivalent { stiffness: stuck_stiffness(balance)?, damping: 0.0 };
    settle(vec![stuck], |contacts| {
        linear_response(balance, angular_frequency, excitation, contacts[0]);
        Ok(vec![measure(balance, angular_frequency, contacts[0])?])
    })
}

/// Stiffness of the contact with its series spring under a motion too small to slip.
fn stuck_stiffness(balance: &mut Balance) -> Result<f64, HarmonicError> {
    if !balance.has_contact() {
        return Ok(0.0);
    }
    let mut u = vec![0.0; balance.displacement().len()];
    u[2] = 1e-10;
    balance.forget();
    let stiffness = balance.contact_force(1.0, &u, balance.flexibility())?[2] / u[2];
    balance.forget();
    Ok(stiffness.max(0.0))
}

/// The spring and damper nearest to what the contact does under `q`.
///
/// Behind the series spring the contact keeps the fraction `1 − a k` of the displacement, with the stiffness k
/// of the round `before`: no iteration through that spring, since the rounds settle it too.
fn measure(
    balance: &mut Balance,
    angular_frequency: f64,
    before: Equivalent,
) -> Result<Equivalent, HarmonicError> {
    if !balance.has_contact() {
        return Ok(Equivalent::default());
    }
    balance.displace();
    let series = balance.flexibility();
    let mut u = balance.displacement().to_vec();
    // What the contact and its flexibility would move by alone, under the same force.
    let alone = |hung: Complex<f64>| share(before.stiffness.into(), hung, series);
    balance.scale(&mut u, alone, &Operating::forced(angular_frequency, 0.0));
    balance.forget();
    let fraction = (1.0 - series * before.stiffness).clamp(0.0, 1.0);
    let kept: Vec<f64> = u.iter().map(|u| fraction * u).collect();
    let force = balance.contact_force(angular_frequency, &kept, 0.0)?;
    let pairs = force[1..].chunks_exact(2).zip(u[1..].chunks_exact(2)).enumerate();
    let harmonics = pairs.map(|(k, (force, u))| (k + 1, [force[0], force[1]], [u[0], u[1]]));
    let nearest = Equivalent::nearest(angular_frequency, harmonics);
    balance.forget();
    Ok(nearest)
}

/// Displacement that a contact of the stiffness `contact` (N/m), its flexibility `series` (m/N) included, has with it, as a
/// fraction of the whole, where something of the stiffness `hung` pulls behind the same flexibility.
fn share(contact: Complex<f64>, hung: Complex<f64>, series: f64) -> Complex<f64> {
    // v = u (1 − a K) without it, and K = k (1 − a K) of the contact itself.
    1.0 / (1.0 + series * hung * (1.0 - series * contact))
}

/// Frequency and shape of the lowest mode with a spring at the contact, and what hangs there.
fn lowest_mode(balance: &Balance, stiffness: f64) -> (f64, Vec<f64>) {
    let (modes, system, shape) = (balance.modes(), &balance.system, &balance.ports[0].shape);
    let hung: Vec<&Resonator> = balance.hung().collect();
    let remaining = 1.0 - balance.flexibility() * stiffness;
    let pulls: f64 = hung.iter().map(|hung| hung.stiffness()).sum();
    // Contact and resonators behind the flexibility a: s Σ k y² − 2 s y Σ k p + Σ k p² − s a (Σ k p)².
    let series = balance.flexibility() * remaining;
    let part = 1.0 / (1.0 + series * pulls);
    let own = |i: usize| match i.checked_sub(modes) {
        None => system.angular_frequency[i].powi(2),
        Some(place) => hung[place].natural().powi(2),
    };
    // Of y, and of k p.
    let lever = |i: usize| match i.checked_sub(modes) {
        None => (shape[i], 0.0),
        Some(place) => (0.0, hung[place].natural() * hung[place].stiffness().sqrt()),
    };
    let size = modes + hung.len();
    let matrix = DMatrix::from_fn(size, size, |i, j| {
        let ((y_i, p_i), (y_j, p_j)) = (lever(i), lever(j));
        let straight = (stiffness + part * remaining * remaining * pulls) * y_i * y_j;
        let coupled = part * (remaining * (y_i * p_j + p_i * y_j) + series * p_i * p_j);
        straight - coupled + if i == j { own(i) } else { 0.0 }
    });
    let eigen = SymmetricEigen::new(matrix);
    let lowest = eigen.eigenvalues.imin();
    (eigen.eigenvalues[lowest].max(0.0).sqrt(), eigen.eigenvectors.column(lowest).iter().copied().collect())
}

/// Response of the beam with a spring and damper at the contact and what hangs there, harmonic by harmonic; the rank-one
/// contact is taken into the diagonal receptance by the Sherman–Morrison formula.
fn linear_response(balance: &mut Balance, angular_frequency: f64, excitation: &[f64], contact: Equivalent) {
    let (system, shape) = (&balance.system, &balance.ports[0].shape);
    let (modes, count) = (balance.modes(), balance.count);
    let (series, at) = (balance.flexibility(), Operating::forced(angular_frequency, 0.0));
    balance.q.fill(0.0);
    for h in 0..=count / 2 {
        let speed = h as f64 * angular_frequency;
        let force = match h {
            0 => Complex::new(excitation.first().copied().unwrap_or(0.0), 0.0),
            _ if 2 * h < excitation.len() => Complex::new(excitation[2 * h - 1], -excitation[2 * h]),
            _ => break,
        };
        let receptance = |mode: usize| system.dynamic_stiffness(mode, speed).inv();
        let (mut free, mut own) = (Complex::new(0.0, 0.0), Complex::new(0.0, 0.0));
        for (i, (shape, driven)) in shape.iter().zip(&system.driven).enumerate() {
            free += receptance(i) * shape * driven * force;
            own += receptance(i) * shape.powi(2);
        }
        let (contact, hung) = (contact.dynamic(speed), balance.hung_stiffness(&at, h));
        let stiffness = share(contact, hung, series) * (contact + hung * (1.0 - series * contact));
        let held = stiffness * free / (Complex::new(1.0, 0.0) + stiffness * own);
        for (i, (shape, driven)) in shape.iter().zip(&system.driven).enumerate() {
            let x = receptance(i) * (force * driven - held * shape);
            if x.re.is_finite() && x.im.is_finite() {
                if h == 0 {
                    balance.q[i] = x.re;
                } else {
                    balance.q[(2 * h - 1) * modes + i] = x.re;
                    balance.q[2 * h * modes + i] = -x.im;
                }
            }
        }
    }
}
