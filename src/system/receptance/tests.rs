use super::*;
use crate::system::{Anchor, Mass, Oscillator, Spring};

/// A chain of masses from the ground, contact at its end, excitation at the second mass. Its dampers are
/// proportional to the springs but for `extra` at the third mass.
fn chain(size: usize, damping: f64, extra: f64) -> LinearStructure {
    let at = |i: usize| if i == 0 { Anchor::Ground } else { Anchor::Mass(i - 1) };
    let stiffness = |i: usize| 1000.0 * (1.0 + 0.3 * ((7 * i) as f64).sin());
    let mut springs: Vec<Spring> = (0..size)
        .map(|i| Spring {
            between: [at(i), at(i + 1)],
            stiffness: stiffness(i),
            damping: damping * stiffness(i),
        })
        .collect();
    springs.push(Spring { between: [Anchor::Ground, at(3)], stiffness: 0.0, damping: extra });
    let mass = |i: usize| Mass { name: format!("m{}", i + 1), mass: 1.0 + 0.2 * ((3 * i) as f64).cos() };
    let masses = (0..size).map(mass).collect();
    let mut structure =
        Oscillator { masses, springs, contact: Some(size - 1), excitation: 1 }.structure().unwrap();
    structure.contacts.push(vec![(2, 1.0), (3, -1.0)]);
    structure
}

/// Factors of harmonic `h` of `omega`, with some self-excitation.
fn factors(h: f64, omega: f64, self_excitation: f64) -> (Complex<f64>, Complex<f64>) {
    let i = Complex::new(0.0, 1.0);
    let inertia = Complex::from(-(h * omega).powi(2)) - i * 2.0 * self_excitation * omega * h * omega;
    (i * h * omega, inertia)
}

fn evaluated(structure: &LinearStructure, method: Method, at: (Complex<f64>, Complex<f64>)) -> Compliance {
    let mut receptance = Receptance::with_method(structure, method).unwrap();
    let mut out = receptance.compliance(Rows::All);
    receptance.evaluate(at.0, at.1, Rows::All, &mut out).unwrap();
    out
}

/// Largest difference between two matrices over the largest entry.
fn distance(left: &DMatrix<Complex<f64>>, right: &DMatrix<Complex<f64>>) -> f64 {
    let largest = |matrix: &DMatrix<Complex<f64>>| matrix.iter().map(|z| z.norm()).fold(0.0, f64::max);
    largest(&(left - right)) / largest(right)
}

fn methods() -> Vec<Method> {
    vec![Method::Modal, Method::Dense, Method::Sparse]
}

/// Between the natural frequencies of the chain, and beyond them.
const FREQUENCIES: [f64; 4] = [0.0, 3.7, 21.0, 90.0];

#[test]
fn all_ways_give_the_same_compliances() {
    let structure = chain(40, 2e-3, 0.0);
    for omega in FREQUENCIES {
        for self_excitation in [0.0, 0.01, -0.3] {
            let at = factors(1.0, omega, self_excitation);
            let expected = evaluated(&structure, Method::Dense, at);
            for method in methods() {
                let found = evaluated(&structure, method, at);
                for (found, expected) in [
                    (&found.value, &expected.value),
                    (&found.by_damping, &expected.by_damping),
                    (&found.by_inertia, &expected.by_inertia),
                ] {
                    let distance = distance(found, expected);
                    assert!(distance < 1e-11, "{method:?} at {omega}: {distance:e}");
                }
            }
        }
    }
}

#[test]
fn compliances_invert_the_dynamic_stiffness() {
    // Every mass an output, a unit force on the second: Z x = e.
    let structure = chain(12, 1e-3, 5.0);
    let at = factors(3.0, 5.0, 0.02);
    let x = evaluated(&structure, Method::Dense, at).value;
    let column = structure.contacts.len();
    let mut force = vec![Complex::new(0.0, 0.0); structure.size];
    for (entries, factor) in
        [(&structure.stiffness, Complex::from(1.0)), (&structure.damping, at.0), (&structure.mass, at.1)]
    {
        for (i, j, value) in entries {
            force[*i] += factor * value * x[(structure.contacts.len() + j, column)];
        }
    }
    for (i, force) in force.iter().enumerate() {
        let expected = if i == 1 { 1.0 } else { 0.0 };
        assert!((force - expected).norm() < 1e-12, "{i}: {force}");
    }
}

#[test]
fn derivatives_are_those_of_central_differences() {
    let structure = chain(9, 2e-3, 0.0);
    let step = 1e-4;
    for method in methods() {
        let (damping, inertia) = factors(1.0, 11.0, 0.01);
        let exact = evaluated(&structure, method, (damping, inertia));
        for direction in [Complex::new(1.0, 0.0), Complex::new(0.0, 1.0)] {
            // The compliances are analytic functions: the derivative is the same along any direction.
            let by = |d: Complex<f64>, s: Complex<f64>| {
                let up = evaluated(&structure, method, (damping + d, inertia + s)).value;
                let down = evaluated(&structure, method, (damping - d, inertia - s)).value;
                (up - down) / (direction * 2.0 * step)
            };
            let zero = Complex::new(0.0, 0.0);
            let by_damping = by(direction * step, zero);
            let by_inertia = by(zero, direction * step);
            assert!(distance(&by_damping, &exact.by_damping) < 1e-7, "{method:?}");
            assert!(distance(&by_inertia, &exact.by_inertia) < 1e-7, "{method:?}");
        }
    }
}

#[test]
fn force_and_displacement_may_change_places() {
    for (extra, ways) in [(0.0, methods()), (5.0, methods()[1..].to_vec())] {
        let mut structure = chain(10, 1e-3, extra);
        structure.outputs = vec![crate::system::Output { name: "driven".into(), row: vec![(1, 1.0)] }];
        for method in ways {
            let found = evaluated(&structure, method, factors(1.0, 13.0, 0.0));
            // Contacts 0 and 1, then the output where the excitation acts; columns likewise.
            for matrix in [&found.value, &found.by_damping, &found.by_inertia] {
                assert!(distance(matrix, &matrix.transpose()) < 1e-12, "{method:?}");
            }
        }
    }
}

#[test]
fn the_bias_is_that_of_springs_in_series() {
    let structure = chain(8, 1e-3, 3.0);
    let mut receptance = Receptance::new(&structure).unwrap();
    let mut out = receptance.compliance(Rows::Contacts);
    let zero = Complex::new(0.0, 0.0);
    receptance.evaluate(zero, zero, Rows::Contacts, &mut out).unwrap();
    let flexibility = |i: usize| 1.0 / (1000.0 * (1.0 + 0.3 * ((7 * i) as f64).sin()));
    let (to_end, to_second): (f64, f64) = ((0..8).map(flexibility).sum(), (0..2).map(flexibility).sum());
    assert!((out.value[(0, 0)].re / to_end - 1.0).abs() < 1e-13);
    assert!((out.value[(0, 2)].re / to_second - 1.0).abs() < 1e-13, "the excitation is at the second mass");
    assert!(out.value.iter().all(|value| value.im == 0.0));
}

#[test]
fn one_damper_that_is_not_proportional_rules_the_modal_way_out() {
    assert_eq!(Receptance::new(&chain(20, 1e-3, 0.0)).unwrap().method(), Method::Modal);
    assert_eq!(Receptance::new(&chain(20, 0.0, 0.0)).unwrap().method(), Method::Modal);
    let structure = chain(20, 1e-3, 1e-6);
    assert_eq!(Receptance::new(&structure).unwrap().method(), Method::Dense);
    let refused = Receptance::with_method(&structure, Method::Modal).unwrap_err();
    assert!(refused.to_string().contains("do not diagonalise"), "{refused}");
    let large = Receptance::new(&chain(301, 1e-3, 0.0)).unwrap();
    assert_eq!(large.method(), Method::Sparse);
}

#[test]
fn at_an_undamped_resonance_the_error_names_it() {
    // m = 1, k = 4.
    let structure = LinearStructure {
        size: 1,
        mass: vec![(0, 0, 1.0)],
        damping: vec![],
        stiffness: vec![(0, 0, 4.0)],
        contacts: vec![vec![(0, 1.0)]],
        excitation: vec![(0, 1.0)],
        outputs: vec![],
    };
    for method in methods() {
        let mut receptance = Receptance::with_method(&structure, method).unwrap();
        let mut out = receptance.compliance(Rows::Contacts);
        let mut at = |omega| {
            let (damping, inertia) = factors(1.0, omega, 0.0);
            receptance.evaluate(damping, inertia, Rows::Contacts, &mut out).map(|()| out.value[(0, 0)].re)
        };
        assert_eq!(at(2.0), Err(StructureError::UndampedResonance { angular_frequency: 2.0 }), "{method:?}");
        let near = at(2.0 * (1.0 + 1e-9)).unwrap();
        assert!((near / (-1.0 / 8e-9) - 1.0).abs() < 1e-6, "{method:?}: {near:e}");
    }
}

#[test]
fn a_bias_that_nothing_holds_is_refused_by_name() {
    // A chain cut behind its third mass: five masses are free.
    let mut structure = chain(8, 1e-3, 0.0);
    structure.stiffness.retain(|(i, j, _)| (*i < 3) == (*j < 3));
    for (i, _, value) in structure.stiffness.iter_mut().filter(|(i, j, _)| i == j && (*i == 2 || *i == 3)) {
        *value -= 1000.0 * (1.0 + 0.3 * 21f64.sin()) * f64::from(*i == 2 || *i == 3);
    }
    for method in methods() {
        // Without damping, for the cut leaves only the springs' part consistent.
        structure.damping.clear();
        let mut receptance = Receptance::with_method(&structure, method).unwrap();
        let mut out = receptance.compliance(Rows::Contacts);
        let zero = Complex::new(0.0, 0.0);
        let refused = receptance.evaluate(zero, zero, Rows::Contacts, &mut out).unwrap_err();
        assert_eq!(
            refused,
            StructureError::FreeBody { part: "`m4` … `m8` (5 outputs)".into() },
            "{method:?}"
        );
        let (damping, inertia) = factors(1.0, 4.0, 0.0);
        receptance.evaluate(damping, inertia, Rows::Contacts, &mut out).unwrap();
    }
}

#[test]
fn a_free_mass_is_driven_by_its_inertia_alone() {
    let mass = Mass { name: "m".into(), mass: 2.0 };
    let free = Oscillator { masses: vec![mass], springs: vec![], contact: Some(0), excitation: 0 };
    let mut receptance = Receptance::new(&free.structure().unwrap()).unwrap();
    let mut out = receptance.compliance(Rows::All);
    let (damping, inertia) = factors(1.0, 3.0, 0.0);
    receptance.evaluate(damping, inertia, Rows::All, &mut out).unwrap();
    assert!((out.value[(1, 1)].re * -18.0 - 1.0).abs() < 1e-15);
    let zero = Complex::new(0.0, 0.0);
    let refused = receptance.evaluate(zero, zero, Rows::All, &mut out).unwrap_err();
    assert!(refused.to_string().starts_with("`m` is not connected to the ground"), "{refused}");
}

#[test]
fn a_beam_in_modal_coordinates_has_its_modal_compliances() {
    let beam = crate::system::ModalBeam {
        angular_frequency: vec![300.0, 1000.0],
        damping_ratio: vec![0.01, 0.02],
        contact_shape: vec![0.5, 1.5],
        excitation_shape: vec![2.0, -1.0],
        shortening: vec![0.0; 4],
        axial_flexibility: 0.0,
        stretching_stiffness: 0.0,
        hung: Vec::new(),
        quadratic_damping: 0.0,
        sensors: vec![crate::system::Sensor { position: 0.55, shape: vec![2.0, -1.0] }],
        contact_points: vec![],
    };
    let held: std::sync::Arc<dyn crate::contact::ContactLaw> =
        std::sync::Arc::new(crate::contact::CubicSpring::new(1.0, 0.0).unwrap());
    let structure = beam.system(Some((held, 0.0))).unwrap().linear_part();
    assert_eq!(structure.outputs[0].name, "x=0.55");
    let mut receptance = Receptance::new(&structure).unwrap();
    assert_eq!(receptance.method(), Method::Modal);
    let mut out = receptance.compliance(Rows::All);
    let (damping, inertia) = factors(1.0, 310.0, 0.0);
    receptance.evaluate(damping, inertia, Rows::All, &mut out).unwrap();
    let term =
        |omega: f64, zeta: f64| 1.0 / Complex::new(omega * omega - 310.0 * 310.0, 2.0 * zeta * omega * 310.0);
    let (first, second) = (term(300.0, 0.01), term(1000.0, 0.02));
    let expected = [first * 0.25 + second * 2.25, first * 1.0 - second * 1.5, first * 4.0 + second * 1.0];
    for (found, expected) in [out.value[(0, 0)], out.value[(0, 1)], out.value[(1, 1)]].iter().zip(expected) {
        assert!((found - expected).norm() < 1e-14 * expected.norm());
    }
}

#[test]
fn what_is_beyond_the_structure_is_refused() {
    let mut structure = chain(4, 0.0, 0.0);
    structure.contacts.push(vec![(4, 1.0)]);
    let refused = Receptance::new(&structure).unwrap_err();
    assert_eq!(refused, StructureError::NoSuchFreedom { index: 4, size: 4 });
    let mut structure = chain(4, 0.0, 0.0);
    structure.stiffness[0].2 = f64::NAN;
    assert!(matches!(Receptance::new(&structure), Err(StructureError::NotComputable { .. })));
    let mut receptance = Receptance::new(&chain(4, 0.0, 0.0)).unwrap();
    let mut out = receptance.compliance(Rows::All);
    let nan = Complex::new(f64::NAN, 0.0);
    let refused = receptance.evaluate(nan, nan, Rows::All, &mut out);
    assert!(matches!(refused, Err(StructureError::NotComputable { .. })));
}
