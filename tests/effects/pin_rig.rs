//! Effects on the rig that slips and slaps.

use std::f64::consts::TAU;

use stickslip::effects::{AppliedEffect, find};
use stickslip::model::Model;
use stickslip::system::{Core, Element, System};
use stickslip::time::{ClassicalSteps, SteppedMotion};

fn rig() -> Model {
    let example = include_str!("../../examples/slip-slap/model.toml").replace("modes = 20", "modes = 8");
    Model::parse(&example[..example.find("[[effect]]").unwrap()]).unwrap()
}

fn with(model: &Model, id: &str, values: &[f64]) -> Model {
    let mut model = model.clone();
    model.effects.push(AppliedEffect { effect: find(id).unwrap(), location: None, values: values.to_vec() });
    model.check().unwrap();
    model
}

/// The resonator on its own is a dynamic stiffness at the contact: with the receptance of the rig without it, the closed form
/// of the frequencies with it.
#[test]
fn a_hanging_mass_is_a_resonator_at_the_contact() {
    let (mass, frequency) = (0.05, 60.0);
    let natural = TAU * frequency;
    let plain = rig().system().unwrap();
    let row = plain.ports[plain.port("contact").unwrap()].row.clone();
    let modes = plain.linear_part().natural_modes().unwrap();
    let lever = |mode: usize| row.iter().map(|(i, b)| b * modes.shapes[(*i, mode)]).sum::<f64>();
    let levers: Vec<f64> = (0..modes.angular_frequency.len()).map(lever).collect();
    let hung = with(&rig(), "hanging_mass", &[mass, frequency]).system().unwrap();
    let found = hung.linear_part().natural_modes().unwrap().angular_frequency;
    assert_eq!(found.len(), modes.angular_frequency.len() + 1);
    for speed in found {
        // What does not move the contact does not feel the resonator.
        if modes.angular_frequency.iter().any(|omega| (speed / omega - 1.0).abs() < 1e-6) {
            continue;
        }
        let square = speed * speed;
        let stiffness = -mass * square * natural * natural / (natural * natural - square);
        let terms = modes.angular_frequency.iter().zip(&levers);
        let receptance: f64 = terms.map(|(omega, c)| c * c / (omega * omega - square)).sum();
        // Relative to the larger of the two terms, which nearly cancel at frequencies that hardly move.
        let left = 1.0 + receptance * stiffness;
        let size = 1.0 + (receptance * stiffness).abs();
        assert!(left.abs() < 1e-5 * size, "{} Hz: {left}", speed / TAU);
    }
}

/// Energy (J) that a motion keeps: modes, springs and masses at ports, the contact's slider and its normal direction.
fn kept(system: &System, steps: &mut ClassicalSteps, motion: &SteppedMotion) -> f64 {
    let Core::Modal { angular_frequency, .. } = &system.core else { panic!("modal") };
    let modes = angular_frequency.iter().zip(&motion.displacement).zip(&motion.velocity);
    let mut kept: f64 = modes.map(|((omega, q), v)| 0.5 * (v * v + (omega * q).powi(2))).sum();
    let mut ports = Vec::new();
    steps.motions_of_ports(motion, &mut ports);
    let square = |matrix: &[[f64; 2]; 2], [x, y]: [f64; 2]| {
        0.5 * (matrix[0][0] * x * x + (matrix[0][1] + matrix[1][0]) * x * y + matrix[1][1] * y * y)
    };
    for element in &system.elements {
        kept += match element {
            Element::Springs { ports: at, stiffness } => square(stiffness, at.map(|port| ports[port].0)),
            Element::Inertia { ports: at, mass } => square(mass, at.map(|port| ports[port].1)),
            Element::SlipSlap { contact, .. } => {
                let now = motion.contacts[0];
                let normal = contact.normal();
                let pressed = normal.stored_energy(now.displacement[1]) - normal.stored_energy(0.0);
                now.force[0].powi(2) / (2.0 * STIFFNESS) + pressed + normal.preload() * now.displacement[1]
            }
            _ => panic!("not of a rig"),
        };
    }
    kept
}

const STIFFNESS: f64 = 3.95e6;

/// What the force brings in over two cycles from rest is in the motion or dissipated, with the effects of the normal direction
/// and a hanging mass, and the error falls with the square of the step.
#[test]
fn energy_balances_to_1e_6_a_cycle_with_every_effect() {
    let linear = rig().to_toml().replace("\"hertz\"", "\"linear\"");
    let kept_line =
        |line: &&str| !["normal_exponent", "impact_damping"].iter().any(|key| line.starts_with(key));
    let linear: String = linear.lines().filter(kept_line).map(|line| format!("{line}\n")).collect();
    let mut model = Model::parse(&linear).unwrap();
    for (id, values) in
        [("normal_hardening", &[1e17][..]), ("impact_damping", &[5.0]), ("hanging_mass", &[0.05, 60.0])]
    {
        model = with(&model, id, values);
    }
    let system = model.system().unwrap().expanded().into_owned();
    let missing = |of: usize| {
        let mut steps = ClassicalSteps::new(&system).unwrap();
        let mut motion = steps.rest();
        let step = 1.0 / 52.0 / of as f64;
        let force = |k: f64| 60.0 * (TAU * k / of as f64).sin();
        for k in 0..2 * of {
            let k = k as f64;
            steps.advance(&mut motion, step, [force(k), force(k + 0.5), force(k + 1.0)]);
        }
        let energies = motion.energies;
        let taken = energies.viscous + energies.friction + energies.impact;
        let size = energies.work.abs().max(taken);
        assert!(energies.impact > 0.0 && energies.friction > 1e-3 * size, "{energies:?}");
        (energies.work - taken - kept(&system, &mut steps, &motion)).abs() / size
    };
    let (coarse, fine) = (missing(10_000), missing(40_000));
    assert!(fine < 2e-6, "two cycles leave {fine}");
    assert!(fine < coarse / 8.0, "{coarse} {fine}");
}

/// Load at rest (N) of a pin that slaps.
const PRELOAD: f64 = 3.0;

/// A pin that is thrown at its support presses on it many times harder than at rest, and is damped as much more: in steps that
/// are right at rest the scheme follows it all the same.
#[test]
fn a_hard_slap_is_followed_in_steps_that_are_right_at_rest() {
    let mut model = rig();
    model.set("contact.normal_load", PRELOAD).unwrap();
    model.set("contact.impact_damping", 1000.0).unwrap();
    let system = model.system().unwrap();
    // Largest normal force (N), energy of the impacts (J), and times that the bodies part.
    let run = |finer: f64| {
        let mut steps = ClassicalSteps::new(&system).unwrap();
        let mut motion = steps.rest();
        let step = steps.longest_step() / finer;
        let force = |time: f64| 400.0 * (TAU * 52.0 * time).sin();
        let (mut most, mut partings) = (0.0_f64, 0);
        for k in 0..(0.02 / step) as usize {
            let time = k as f64 * step;
            let apart = motion.contacts[0].separation > 0.0;
            steps.advance(&mut motion, step, [0.0, 0.5, 1.0].map(|part| force(time + part * step)));
            most = most.max(motion.contacts[0].normal_force);
            partings += usize::from(motion.contacts[0].separation > 0.0 && !apart);
        }
        (most, motion.energies.impact, partings)
    };
    let (coarse, fine) = (run(1.0), run(32.0));
    assert!(fine.0 > 100.0 * PRELOAD && fine.2 >= 1, "{fine:?}");
    assert!((coarse.1 / fine.1 - 1.0).abs() < 0.01, "{coarse:?} {fine:?}");
}
