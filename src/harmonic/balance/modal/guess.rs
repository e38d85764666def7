//! Starting points by equivalent linearisation: the contact as the spring and damper that do the same
//! first-order work at the amplitude at hand (describing function, Krylov & Bogoliubov).

use nalgebra::{Complex, DMatrix, SymmetricEigen};

use super::Balance;
use crate::harmonic::HarmonicError;
use crate::harmonic::newton::system::PeriodicSystem;
use crate::numeric::fourier::work_per_cycle;

const ROUNDS: usize = 12;

/// Spring (N/m) and damper (N s/m) in place of the contact.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Equivalent {
    stiffness: f64,
    damping: f64,
}

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
        equivalent = averaged(equivalent, measure(balance, frequency, equivalent)?);
    }
    let displacement = acceleration / (angular_frequency * angular_frequency);
    balance.weigh();
    let loss = balance.viscous_energy(angular_frequency) + balance.dissipated_energy();
    Ok((angular_frequency, loss / (std::f64::consts::PI * displacement)))
}

/// Start for a forced response, left in the balance's modal coefficients.
pub(crate) fn forced(
    balance: &mut Balance,
    angular_frequency: f64,
    excitation: &[f64],
) -> Result<(), HarmonicError> {
    let mut equivalent = Equivalent { stiffness: stuck_stiffness(balance)?, damping: 0.0 };
    for _ in 0..ROUNDS {
        linear_response(balance, angular_frequency, excitation, equivalent);
        let next = averaged(equivalent, measure(balance, angular_frequency, equivalent)?);
        let settled = (next.stiffness - equivalent.stiffness).abs() <= 0.01 * equivalent.stiffness.abs();
        equivalent = next;
        if settled {
            break;
        }
    }
    Ok(())
}

/// Halfway between both, which tames the alternation of stiff-small and soft-large.
fn averaged(a: Equivalent, b: Equivalent) -> Equivalent {
    Equivalent { stiffness: 0.5 * (a.stiffness + b.stiffness), damping: 0.5 * (a.damping + b.damping) }
}

/// Stiffness of the contact with its series spring under a motion too small to slip.
fn stuck_stiffness(balance: &mut Balance) -> Result<f64, HarmonicError> {
    if !balance.has_contact() {
        return Ok(0.0);
    }
    let mut u = vec![0.0; balance.displacement().len()];
    u[2] = 1e-10;
    balance.forget();
    let stiffness = balance.contact_force(1.0, &u, balance.ports[0].flexibility)?[2] / u[2];
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
        return Ok(Equivalent { stiffness: 0.0, damping: 0.0 });
    }
    balance.weigh();
    let u = balance.displacement().to_vec();
    balance.forget();
    let fraction = (1.0 - balance.ports[0].flexibility * before.stiffness).clamp(0.0, 1.0);
    let kept: Vec<f64> = u.iter().map(|u| fraction * u).collect();
    let force = balance.contact_force(angular_frequency, &kept, 0.0)?;
    let work = work_per_cycle(force, &u);
    let (mut along, mut squares, mut rates) = (0.0, 0.0, 0.0);
    for m in 1..u.len() {
        let order = m.div_ceil(2) as f64;
        along += force[m] * u[m];
        squares += u[m] * u[m];
        rates += order * order * u[m] * u[m];
    }
    balance.forget();
    if squares == 0.0 {
        return Ok(Equivalent { stiffness: 0.0, damping: 0.0 });
    }
    let damping = work / (std::f64::consts::PI * angular_frequency * rates);
    Ok(Equivalent { stiffness: (along / squares).max(0.0), damping: damping.max(0.0) })
}

/// Frequency and shape of the lowest mode with a spring at the contact.
fn lowest_mode(balance: &Balance, stiffness: f64) -> (f64, Vec<f64>) {
    let (modes, system, shape) = (balance.modes(), &balance.system, &balance.ports[0].shape);
    let matrix = DMatrix::from_fn(modes, modes, |i, j| {
        let diagonal = if i == j { system.angular_frequency[i].powi(2) } else { 0.0 };
        diagonal + stiffness * shape[i] * shape[j]
    });
    let eigen = SymmetricEigen::new(matrix);
    let lowest = eigen.eigenvalues.imin();
    (eigen.eigenvalues[lowest].max(0.0).sqrt(), eigen.eigenvectors.column(lowest).iter().copied().collect())
}

/// Response of the beam with a spring and damper at the contact, harmonic by harmonic; the rank-one
/// contact is taken into the diagonal receptance by the Sherman–Morrison formula.
fn linear_response(balance: &mut Balance, angular_frequency: f64, excitation: &[f64], contact: Equivalent) {
    let (system, shape) = (&balance.system, &balance.ports[0].shape);
    let (modes, count) = (balance.modes(), balance.count);
    balance.q.fill(0.0);
    for h in 0..=count / 2 {
        let speed = h as f64 * angular_frequency;
        let force = match h {
            0 => Complex::new(excitation.first().copied().unwrap_or(0.0), 0.0),
            _ if 2 * h < excitation.len() => Complex::new(excitation[2 * h - 1], -excitation[2 * h]),
            _ => break,
        };
        let receptance = |i: usize| {
            let natural = system.angular_frequency[i];
            let dynamic = natural * natural - speed * speed;
            Complex::new(dynamic, 2.0 * system.damping_ratio[i] * natural * speed).inv()
        };
        let (mut free, mut own) = (Complex::new(0.0, 0.0), Complex::new(0.0, 0.0));
        for (i, (shape, driven)) in shape.iter().zip(&system.driven).enumerate() {
            free += receptance(i) * shape * driven * force;
            own += receptance(i) * shape.powi(2);
        }
        let stiffness = Complex::new(contact.stiffness, contact.damping * speed);
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
