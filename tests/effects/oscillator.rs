//! Effects on oscillators, by independent models: what is hung or added is a mass of a larger model, and harmonic
//! balance agrees with time integration.

use std::f64::consts::TAU;

use stickslip::effects::{AppliedEffect, Location, find};
use stickslip::harmonic::{
    Assembly, Control, CurveSettings, Ending, Point, frequency_response, periodic_response,
};
use stickslip::model::Model;
use stickslip::time::{Integrator, Ramp};

const TWO_MASSES: &str = r#"
schema = "stickslip.model/1"
kind = "oscillator"
mass = [{ name = "m1", mass = 1.0 }, { name = "m2", mass = 1.2 }]
spring = [
    { between = ["ground", "m1"], stiffness = 1.0, damping = 0.1 },
    { between = ["m1", "m2"], stiffness = 0.5, damping = 0.05 },
    { between = ["ground", "m2"], damping = 0.05 },
]
contact = { at = "m2", law = "jenkins", tangential_stiffness = 0.2, friction_coefficient = 0.02, normal_load = 1.0 }
"#;

fn model(text: &str) -> Model {
    Model::parse(text).unwrap()
}

fn with(model: &Model, id: &str, at: Option<&str>, values: &[f64]) -> Model {
    let mut changed = model.clone();
    let location = at.map(|name| Location::Mass(name.into()));
    changed.effects.push(AppliedEffect { effect: find(id).unwrap(), location, values: values.to_vec() });
    changed
}

#[test]
fn an_added_mass_is_a_heavier_mass() {
    let heavier = model(&TWO_MASSES.replace("mass = 1.2", "mass = 1.5"));
    let added = with(&model(TWO_MASSES), "added_mass", Some("m2"), &[0.3]).system().unwrap();
    assert_eq!(added.linear_part(), heavier.system().unwrap().linear_part());
    let nowhere = with(&model(TWO_MASSES), "added_mass", Some("m3"), &[0.3]);
    assert!(nowhere.system().unwrap_err().to_string().contains("m3"));
}

#[test]
fn a_hanging_mass_is_a_third_mass_on_a_spring() {
    let (mass, frequency) = (0.2, 0.15);
    let stiffness = mass * (TAU * frequency) * (TAU * frequency);
    let third = TWO_MASSES.replace("mass = 1.2 }]", "mass = 1.2 }, { name = \"m3\", mass = 0.2 }]").replace(
        "{ between = [\"ground\", \"m2\"]",
        &format!(
            "{{ between = [\"m2\", \"m3\"], stiffness = {stiffness} }},\n{{ between = [\"ground\", \"m2\"]"
        ),
    );
    let expected = model(&third).system().unwrap().linear_part().natural_modes().unwrap();
    let hung =
        with(&model(TWO_MASSES), "hanging_mass", None, &[mass, frequency]).system().unwrap().linear_part();
    assert_eq!((hung.size, hung.outputs.len()), (3, 2));
    let found = hung.natural_modes().unwrap();
    for (found, expected) in found.angular_frequency.iter().zip(&expected.angular_frequency) {
        assert!((found / expected - 1.0).abs() < 1e-12, "{found} {expected}");
    }
}

/// Largest displacement of both masses over a period under `force cos Ωt`, by marching.
fn marched(model: &Model, omega: f64, force: f64, periods: usize, steps: usize) -> [f64; 2] {
    let mut integrator = Integrator::new(&model.system().unwrap()).unwrap();
    let mut inputs = integrator.held_inputs();
    let mut motion = integrator.rest(&inputs).unwrap();
    let h = TAU / omega / steps as f64;
    let at = |k: usize| force * (omega * h * k as f64).cos();
    let mut largest = [0.0_f64; 2];
    for k in 0..periods * steps {
        inputs[0] = Ramp::line(at(k), at(k + 1));
        integrator.march(&mut motion, h, &inputs, 1).unwrap();
        if k >= (periods - 1) * steps {
            for (largest, x) in largest.iter_mut().zip(integrator.displacement(&motion)) {
                *largest = largest.max(x.abs());
            }
        }
    }
    largest
}

#[test]
fn harmonic_balance_with_effects_of_the_structure_agrees_with_time_integration() {
    let plain = model(TWO_MASSES);
    let variants = [
        with(&plain, "geometric_stiffening", None, &[1.0]),
        with(&plain, "quadratic_damping", None, &[0.4]),
        with(&with(&plain, "geometric_stiffening", None, &[0.2]), "quadratic_damping", None, &[0.2]),
        with(&with(&plain, "hanging_mass", None, &[0.1, 0.2]), "quadratic_damping", None, &[0.6]),
    ];
    let (omega, force) = (0.9, 0.4);
    let before = marched(&plain, omega, force, 60, 400);
    for changed in &variants {
        let assembly = Assembly::new(changed.system().unwrap());
        let settings = CurveSettings { harmonics: 31, ..CurveSettings::default() };
        let point = periodic_response(&assembly, omega, &Control::Level(force), &settings, None).unwrap();
        let found = marched(changed, omega, force, 60, 400);
        for (balanced, found) in point.amplitude.iter().zip(&found) {
            assert!((balanced / found - 1.0).abs() < 1e-3, "{:?}: {balanced} {found}", changed.effects);
        }
        let moved = (0..2).any(|node| (found[node] / before[node] - 1.0).abs() > 0.01);
        assert!(moved, "the effect shows: {found:?} {before:?}");
    }
}

/// The whole curve from 0.2 rad/s to `until`, and the response at `omegas`.
fn curve_agrees_with_time_integration(
    changed: &Model,
    harmonics: usize,
    until: f64,
    omegas: &[f64],
    stability: bool,
) {
    let assembly = Assembly::new(changed.system().unwrap());
    let settings = CurveSettings { harmonics, max_points: 400, stability, ..CurveSettings::default() };
    let force = Control::Level(0.4);
    let curve = frequency_response(&assembly, 0.2, until, &force, &settings, &mut |_| true).unwrap();
    let last = curve.points.last().unwrap().angular_frequency;
    assert_eq!(curve.ending, Ending::Complete, "{} points up to {last}", curve.points.len());
    let stable = |point: &Point| point.stable == Some(true);
    assert!(!stability || curve.points.iter().all(stable), "some point is not stable");
    for omega in omegas {
        let point = periodic_response(&assembly, *omega, &force, &settings, None).unwrap();
        let found = marched(changed, *omega, 0.4, 60, 400);
        for (balanced, found) in point.amplitude.iter().zip(&found) {
            assert!((balanced / found - 1.0).abs() < 1e-3, "{omega}: {balanced} {found}");
        }
    }
}

/// Where the play closes with a velocity the force jumps.
fn damper_behind_play() -> Model {
    with(&with(&model(TWO_MASSES), "backlash", None, &[0.2]), "contact_damping", None, &[0.05])
}

#[test]
fn a_damper_behind_a_play_has_a_curve_that_agrees_with_time_integration() {
    curve_agrees_with_time_integration(&damper_behind_play(), 31, 2.0, &[0.3, 0.65, 0.9, 1.5], true);
}

#[test]
fn with_weakening_besides_too() {
    let weakening = with(&damper_behind_play(), "velocity_weakening", None, &[0.5, 0.1]);
    curve_agrees_with_time_integration(&weakening, 7, 0.5, &[0.3], false);
}
