//! The rig that slips and slaps in two parts, beam and contact, against the rig in one piece.

use stickslip::cosim::{Algorithm, Method, Report, Settings, System};
use stickslip::fmi::{Instance, Setup};

use crate::common::cosim::*;

const BEAM: &str = include_str!("../../modelDescription/PinnedBeam.toml");
const CONTACT: &str = include_str!("../../modelDescription/SlipSlapContact.toml");
const WHOLE: &str = include_str!("../../modelDescription/SlipSlapBeam.toml");

/// Force of the exciter (N), which is there from the start on: the pin slips.
const EXCITATION: f64 = 60.0;
const STOP: f64 = 4e-3;
const COARSEST: f64 = 1e-5;

const OBSERVED: [(&str, &str); 8] = [
    ("beam", "displacement"),
    ("beam", "opening"),
    ("beam", "velocity"),
    ("beam", "velocity:x=0.55"),
    ("contact", "force"),
    ("contact", "opening_force"),
    ("contact", "dissipated_energy"),
    ("contact", "impact_energy"),
];

/// Fewer modes: steps of 10 µs follow them.
fn few(model: &str) -> String {
    model.replace("modes = 20", "modes = 8")
}

fn coupled() -> System {
    let mut system = System::new();
    system.add(native("beam", &few(BEAM))).unwrap();
    system.add(native("contact", CONTACT)).unwrap();
    for name in ["displacement", "velocity", "opening", "opening_velocity"] {
        system.connect(("beam", name), ("contact", name), 1.0, 0.0).unwrap();
    }
    for (from, to) in [("force", "contact_force"), ("opening_force", "opening_force")] {
        system.connect(("contact", from), ("beam", to), 1.0, 0.0).unwrap();
    }
    system.declare_power(("beam", "contact_force"), ("contact", "displacement")).unwrap();
    system.declare_power(("beam", "opening_force"), ("contact", "opening")).unwrap();
    system.start("beam", "excitation", EXCITATION).unwrap();
    for (slave, variable) in OBSERVED {
        system.observe(slave, variable).unwrap();
    }
    system
}

/// The same in one piece: a row every [`COARSEST`].
fn whole() -> Vec<[f64; 8]> {
    let mut instance = Instance::new(&few(WHOLE)).unwrap();
    let reference = |instance: &Instance, name: &str| instance.description().reference(name).unwrap();
    let excitation = reference(&instance, "excitation");
    instance.set_real(&[excitation], &[EXCITATION]).unwrap();
    instance.set_up(Setup { tolerance: Some(1e-9), ..Setup::default() }).unwrap();
    instance.enter_initialization().unwrap();
    instance.exit_initialization().unwrap();
    let references = OBSERVED.map(|(_, name)| reference(&instance, name));
    let mut rows = Vec::new();
    let count = (STOP / COARSEST).round() as usize;
    for k in 0..=count {
        let mut row = [0.0; 8];
        instance.get_real(&references, &mut row).unwrap();
        rows.push(row);
        if k < count {
            instance.do_step(k as f64 * COARSEST, COARSEST).unwrap();
        }
    }
    rows
}

/// Of every signal the error in the mean square over that signal, and the report.
fn errors(algorithm: &Algorithm, step: f64, exact: &[[f64; 8]]) -> ([f64; 8], Report) {
    let (rows, report) = record(coupled(), Settings::new(algorithm.clone(), step, STOP)).unwrap();
    let every = (COARSEST / step).round() as usize;
    let norm = |of: &dyn Fn(usize) -> f64| (0..exact.len()).map(|row| of(row).powi(2)).sum::<f64>().sqrt();
    let errors = std::array::from_fn(|signal| {
        norm(&|row| rows[row * every].1[signal] - exact[row][signal]) / norm(&|row| exact[row][signal])
    });
    (errors, report)
}

#[test]
fn strong_coupling_of_beam_and_contact_converges_with_order_two_to_the_whole() {
    let exact = whole();
    let [.., friction, impact] = exact[exact.len() - 1];
    assert!(friction > 1e-5 && impact > 0.0, "{friction} {impact}");
    let level = |divisor: f64| {
        let (errors, report) = errors(&strong(Method::Newton), COARSEST / divisor, &exact);
        assert_eq!(report.unconverged, 0);
        assert!(report.energy.iter().all(|pair| pair.magnitude < 1e-9 * friction), "{:?}", report.energy);
        errors
    };
    let (coarse, fine) = (level(1.0), level(8.0));
    for (signal, (_, name)) in OBSERVED.iter().enumerate() {
        let order = (coarse[signal] / fine[signal]).log2() / 3.0;
        assert!(order > 1.7, "{name}: {:e} to {:e}, {order}", coarse[signal], fine[signal]);
    }
    // Without iteration the works of both sides differ, and the difference falls with the step.
    let [first, last] = [2.0, 16.0].map(|divisor| errors(&JACOBI, COARSEST / divisor, &exact).1.energy);
    for (first, last) in first.iter().zip(&last) {
        assert!(last.magnitude < first.magnitude / 6.0, "{first:?} to {last:?}");
    }
}
