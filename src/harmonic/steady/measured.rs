//! Where a measured motion lies among the periodic responses of a beam.

use nalgebra::Complex;

use crate::harmonic::balance::modal::Balance;
use crate::harmonic::newton::system::Operating;

/// Modal coefficients, mode after mode, and coefficients of the contact's force (N) with which the linear part of the
/// beam moves as measured: harmonic by harmonic the one force at the contact, less what hangs there, that explains the
/// sensors best, by least squares. `excitation` (N) and `motion` are by coefficients: `motion` has the displacement coefficients (m) of every sensor; where all are zero there is no force.
pub(super) fn explained(
    balance: &Balance,
    angular_frequency: f64,
    excitation: &[f64],
    motion: &[Vec<f64>],
) -> (Vec<f64>, Vec<f64>) {
    let (system, modes, count) = (&balance.system, balance.modes(), balance.count);
    let (contact_shape, sensors) = (balance.contact_shape(), balance.sensors());
    let mut coefficients = vec![0.0; modes * count];
    let mut force = vec![0.0; balance.displacement().len()];
    let operating = Operating::forced(angular_frequency, 1.0);
    for order in 1..=count / 2 {
        let speed = order as f64 * angular_frequency;
        let at = |values: &[f64]| match values.get(2 * order - 1..=2 * order) {
            Some(pair) => Complex::new(pair[0], -pair[1]),
            None => Complex::new(0.0, 0.0),
        };
        let pushed = at(excitation);
        let receptance: Vec<Complex<f64>> =
            (0..modes).map(|mode| system.dynamic_stiffness(mode, speed).inv()).collect();
        let along = |shape: &[f64], acting: &[f64]| -> Complex<f64> {
            let terms = receptance.iter().zip(shape).zip(acting);
            terms.map(|((receptance, shape), acting)| receptance * (shape * acting)).sum()
        };
        let (mut found, mut size) = (Complex::new(0.0, 0.0), 0.0);
        if motion.iter().any(|sensor| at(sensor).norm_sqr() > 0.0) {
            for (sensor, measured) in sensors.iter().zip(motion) {
                let by_contact = along(sensor, contact_shape);
                let free = along(sensor, &system.driven) * pushed;
                found += by_contact.conj() * (free - at(measured));
                size += by_contact.norm_sqr();
            }
        }
        let contact = if size > 0.0 { found / size } else { Complex::new(0.0, 0.0) };
        let given = along(contact_shape, &system.driven) * pushed
            - along(contact_shape, contact_shape) * contact
            - contact * balance.flexibility();
        let of_law = contact - balance.hung_stiffness(&operating, order) * given;
        if of_law.re.is_finite() && of_law.im.is_finite() {
            (force[2 * order - 1], force[2 * order]) = (of_law.re, -of_law.im);
        }
        for mode in 0..modes {
            let acting = pushed * system.driven[mode] - contact * contact_shape[mode];
            let moved = receptance[mode] * acting;
            if moved.re.is_finite() && moved.im.is_finite() {
                coefficients[mode * count + 2 * order - 1] = moved.re;
                coefficients[mode * count + 2 * order] = -moved.im;
            }
        }
    }
    (coefficients, force)
}
