//! Beam and contact coupled, against the same in one piece.

mod cosim_support;

use cosim_support::*;
use stickslip::cosim::{Method, Settings};

/// Friction settles the motion well within the run.
const SHAKER: Shaker = Shaker { amplitude: 6.0, omega: 324.0, growth: 0.1 };

fn steady_amplitude(rows: &Rows, from: f64) -> f64 {
    amplitude(rows.iter().filter(|(time, _)| *time >= from).map(|(_, values)| values[3]))
}

#[test]
fn strong_coupling_keeps_the_steady_amplitude_where_plain_jacobi_does_not() {
    let (step, stop, from) = (1e-4, 1.0, 0.9);
    for contact in [VALANIS, JENKINS] {
        let exact = monolithic(contact, SHAKER, 1e-5, stop, 10);
        let exact = amplitude(exact.iter().filter(|row| row[0] >= from).map(|row| row[2]));
        let error = |algorithm| {
            let (rows, report) =
                record(beam_with(contact, SHAKER), Settings::new(algorithm, step, stop)).unwrap();
            eprintln!("{:?}", report);
            (steady_amplitude(&rows, from) / exact - 1.0).abs()
        };
        let strong = error(strong(Method::Anderson { depth: 5 }));
        let jacobi = error(JACOBI);
        let gs = error(GAUSS_SEIDEL);
        eprintln!("{exact:e} strong {strong:e} jacobi {jacobi:e} gs {gs:e}");
        assert!(strong < 1e-3, "{strong:e}");
        assert!(jacobi > 20.0 * strong, "{jacobi:e} {strong:e}");
    }
}
