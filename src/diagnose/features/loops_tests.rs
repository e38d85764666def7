use super::*;
use crate::contact::Inputs;
use crate::effects::AppliedEffect;
use crate::model::Model;

const STIFFNESS: f64 = 2e6;
const LIMIT: f64 = 50.0;
/// Level over the yield displacement, and frequency (Hz).
const RUNS: [(f64, f64); 3] = [(4.0, 1.0), (8.0, 1.0), (8.0, 5.0)];
const YIELD: f64 = LIMIT / STIFFNESS;

/// Loops of Jenkins' element with an effect under sines; the load swings by `swing` of its mean.
fn features(effect: Option<(&str, &[f64])>, swing: f64) -> Features {
    let mut model = Model::parse(&format!(
        "schema = \"stickslip.model/1\"\nkind = \"contact\"\n[contact]\nlaw = \"jenkins\"\n\
         tangential_stiffness = {STIFFNESS}\nfriction_coefficient = 0.5\nnormal_load = 100.0\n"
    ))
    .unwrap();
    if let Some((id, values)) = effect {
        let effect = crate::effects::find(id).unwrap();
        model.effects.push(AppliedEffect { effect, location: None, values: values.to_vec() });
    }
    let law = model.law().unwrap().unwrap();
    let runs: Vec<[Vec<f64>; 3]> = RUNS
        .map(|(level, frequency)| {
            let rate = std::f64::consts::TAU * frequency;
            let mut state = vec![0.0; law.state_len()];
            law.set_state(0.0, 100.0, 0.0, &mut state);
            let mut next = state.clone();
            let mut columns: [Vec<f64>; 3] = Default::default();
            for i in 0..1600 {
                let angle = std::f64::consts::TAU * f64::from(i) / 400.0;
                let displacement = level * YIELD * angle.sin();
                let velocity = level * YIELD * rate * angle.cos();
                let normal_load = 100.0 * (1.0 + swing * (0.7 * angle).sin());
                let inputs = Inputs { displacement, velocity, normal_load };
                let force = law.step(&state, inputs, &mut next).force;
                std::mem::swap(&mut state, &mut next);
                columns[0].push(displacement);
                columns[1].push(force);
                columns[2].push(normal_load);
            }
            columns
        })
        .to_vec();
    let measured: Vec<Measured> = runs
        .iter()
        .zip(RUNS)
        .map(|([displacement, force, load], (_, frequency))| Measured {
            displacement: displacement.clone(),
            force,
            load: Some(load),
            step: 1.0 / 400.0 / frequency,
        })
        .collect();
    let mut found = Features::default();
    fill(&measured, &mut found);
    found
}

fn close(value: Option<f64>, expected: f64, tolerance: f64) {
    assert!(value.is_some_and(|value| (value - expected).abs() < tolerance), "{value:?}, not {expected}");
}

#[test]
fn a_plain_slider_shows_nothing() {
    let seen = features(None, 0.0);
    close(seen.plateau_fraction, 0.0, 0.003);
    close(seen.slip_slope_fraction, 0.0, 0.002);
    close(seen.corner_fraction, 0.0, 0.05);
    close(seen.loop_asymmetry, 0.0, 1e-3);
    close(seen.height_by_speed, 0.0, 1e-3);
    close(seen.height_per_slip.map(|rate| rate * YIELD), 0.0, 1e-4);
    assert_eq!(seen.height_by_load, None);
}

#[test]
fn play_takes_its_half_width_over_the_amplitude_of_the_stroke() {
    let gap = 0.8 * YIELD;
    // The stroke is twice the amplitude, the slack twice the half-width; two of three records reach 8.
    close(features(Some(("backlash", &[gap])), 0.0).plateau_fraction, gap / (8.0 * YIELD), 0.006);
}

#[test]
fn a_spring_beside_the_slider_is_the_slope_in_slip() {
    let seen = features(Some(("residual_stiffness", &[0.1 * STIFFNESS])), 0.0);
    // In stick both carry.
    close(seen.slip_slope_fraction, 0.1 / 1.1, 0.004);
}

#[test]
fn yielding_all_at_once_has_a_corner_and_spread_yielding_has_none() {
    // Uniform yield displacements from 0 to 2: f = s − s²/4, and its inverse gives the four levels of the rise.
    let s = |rise: f64| 2.0 * (1.0 - (1.0_f64 - rise).sqrt());
    let expected = 1.0 - (s(0.4) - s(0.1)) / (s(0.9) - s(0.6));
    close(features(Some(("micro_slip", &[1.0])), 0.0).corner_fraction, expected, 0.04);
}

#[test]
fn a_limit_by_direction_shifts_the_plateaus_by_twice_the_asymmetry() {
    close(features(Some(("asymmetry", &[0.2])), 0.0).loop_asymmetry, 0.4, 0.01);
}

#[test]
fn wear_is_the_growth_of_the_height_per_slip() {
    let rate = 0.002 / YIELD;
    close(features(Some(("wear", &[rate])), 0.0).height_per_slip.map(|found| found / rate), 1.0, 0.1);
}

#[test]
fn weakening_lowers_the_fast_loop() {
    // At the slowest record's speed the limit is (1 + δ e^(−v/v_s)) times that at speed.
    let speed = 8.0 * YIELD * std::f64::consts::TAU;
    let seen = features(Some(("velocity_weakening", &[0.5, 2.0 * speed])), 0.0).height_by_speed.unwrap();
    assert!((-0.3..-0.1).contains(&seen), "{seen}");
}

#[test]
fn a_limit_that_follows_the_load_correlates_with_it_and_a_constant_one_does_not() {
    let seen = features(Some(("normal_load_variation", &[1.0])), 0.4);
    assert!(seen.height_by_load.unwrap() > 0.95, "{seen:?}");
}
