//! Oscillators as co-simulation slaves.

use stickslip::contact::Jenkins;
use stickslip::fmi::{Causality, Instance, Setup};
use stickslip::model::Model;
use stickslip::time::{Excitation, LoadedContact, OscillatorFlow};

const MODEL: &str = include_str!("../../examples/friction-vibration/model.toml");

fn running() -> Instance {
    let mut instance = Instance::new(MODEL).unwrap();
    instance.set_up(Setup::default()).unwrap();
    instance.enter_initialization().unwrap();
    instance.exit_initialization().unwrap();
    instance
}

fn read(instance: &mut Instance, name: &str) -> f64 {
    let reference = instance.description().reference(name).unwrap();
    let mut value = [0.0];
    instance.get_real(&[reference], &mut value).unwrap();
    value[0]
}

fn push(instance: &mut Instance, force: f64) {
    let reference = instance.description().reference("excitation:m1").unwrap();
    instance.set_real(&[reference], &[force]).unwrap();
}

#[test]
fn every_mass_can_be_driven_and_observed() {
    let instance = running();
    let names = |causality| -> Vec<String> {
        let references = instance.description().references(causality);
        references.map(|row| instance.description().variables[row as usize].name.to_string()).collect()
    };
    assert_eq!(names(Causality::Input), ["excitation:m1", "excitation:m2", "normal_load"]);
    let outputs = names(Causality::Output);
    assert_eq!(outputs[..4], ["force", "dissipated_energy", "slip_state", "slip_fraction"]);
    for mass in ["m1", "m2"] {
        for quantity in ["displacement", "velocity", "acceleration"] {
            assert!(outputs.contains(&format!("{quantity}:{mass}")), "{outputs:?}");
        }
    }
}

#[test]
fn a_slave_follows_the_exact_flow_under_forces_that_run_linearly_between_communication_points() {
    let mut instance = running();
    let model = Model::parse(MODEL).unwrap();
    let contact = model.contact.unwrap();
    let law = Jenkins::new(contact.tangential_stiffness, contact.friction_coefficient).unwrap();
    let contacts = [LoadedContact { law: &law, normal_load: contact.normal_load }];
    let mut flow = OscillatorFlow::new(&model.system().unwrap().linear_part(), &contacts).unwrap();
    let step = 0.25;
    let values: Vec<f64> = (0..400).map(|k| 0.4 * (0.5 * step * f64::from(k)).sin()).collect();
    let excitation = Excitation::Sampled { interval: step, values: values.clone() };
    let mut motion = flow.rest();
    let mut dissipated = 0.0;
    for (k, force) in values.iter().enumerate().skip(1) {
        push(&mut instance, *force);
        instance.do_step((k - 1) as f64 * step, step).unwrap();
        dissipated +=
            flow.advance(&mut motion, step, &excitation).unwrap().dissipated_energy.iter().sum::<f64>();
        let exact = flow.displacement(&motion);
        for (name, exact) in [("displacement:m1", exact[0]), ("displacement:m2", exact[1])] {
            let found = read(&mut instance, name);
            assert!((found - exact).abs() < 1e-5, "{name} at step {k}: {found} {exact}");
        }
        let force = read(&mut instance, "force");
        assert!((force - flow.contact_forces(&motion)[0]).abs() < 1e-5, "force at step {k}");
    }
    let found = read(&mut instance, "dissipated_energy");
    assert!(dissipated > 0.1 && (found / dissipated - 1.0).abs() < 1e-4, "{found} {dissipated}");
}

#[test]
fn a_restored_instance_continues_bit_by_bit_whatever_steps_came_between() {
    let mut instance = running();
    let run = |instance: &mut Instance, from: u32, to: u32| -> Vec<f64> {
        (from..to)
            .map(|k| {
                push(instance, 0.4 * f64::from(k % 7));
                // As a master adds times up: no two steps have quite the same length.
                let (start, end) = (f64::from(k) * 0.1, f64::from(k + 1) * 0.1);
                instance.do_step(instance.time(), end - start).unwrap();
                read(instance, "displacement:m2")
            })
            .collect()
    };
    run(&mut instance, 0, 30);
    let saved = instance.snapshot();
    let first = run(&mut instance, 30, 60);
    instance.do_step(instance.time(), 0.037).unwrap();
    instance.restore(&saved).unwrap();
    assert_eq!(run(&mut instance, 30, 60), first);
    let mut other = Instance::new(MODEL).unwrap();
    other.restore(&saved).unwrap();
    assert_eq!(run(&mut other, 30, 60), first);
}

#[test]
fn a_step_too_long_for_the_motion_is_refused_and_the_state_kept() {
    let mut instance = running();
    push(&mut instance, 1.0);
    assert!(instance.do_step(0.0, 1e12).is_err());
    assert_eq!(read(&mut instance, "displacement:m1"), 0.0);
}
