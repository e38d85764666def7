//! Two harmonics of the rig's motion held at once, whatever the law of its contact.
//!
//! Items to verify: every law of the catalogue is held at the highest published level; under one slider the response turns back where
//! slip begins, and is followed around; what is found there is the motion in time.

use std::f64::consts::TAU;

use stickslip::contact::{LAWS, LawKind, LawParameter};
use stickslip::harmonic::fourier::{time_derivative, value};
use stickslip::harmonic::{Assembly, CurveSettings, DualTone, HarmonicError, HeldTone, dual_tone_response};
use stickslip::model::Model;
use stickslip::system::{Port, System};
use stickslip::time::ClassicalSteps;
use stickslip::vocabulary::Scale;

const FREQUENCY: f64 = 52.0;
const STIFFNESS: f64 = 3.95e6;
/// First and third harmonic of the acceleration (m/s²).
const HIGHEST: [f64; 2] = [20.0, 50.0];

/// The example's rig of few modes with a contact of `law`, whose normal force `normal` makes.
fn rig(law: &str, normal: &str, effect: &str) -> System {
    let example = include_str!("../../examples/slip-slap/model.toml");
    let rig = example[..example.find("[contact]").unwrap()].replace("modes = 20", "modes = 4");
    let contact = format!(
        "[contact]\n{law}tangential_stiffness = {STIFFNESS:?}\nfriction_coefficient = 0.6\nnormal_load = 68.67\n\
         normal_stiffness = 2.37e7\n{normal}{effect}"
    );
    Model::parse(&format!("{rig}{contact}")).unwrap().system().unwrap()
}

fn held(system: &System, [first, third]: [f64; 2], harmonics: usize) -> Result<DualTone, HarmonicError> {
    let assembly = Assembly::new(system.clone());
    let node = assembly.nodes().len() - 1;
    let tones = [(1, first), (3, third)];
    let tones = tones.map(|(order, amplitude)| HeldTone { order, amplitude, phase: 0.0 });
    let settings = CurveSettings { harmonics, ..CurveSettings::default() };
    dual_tone_response(&assembly, TAU * FREQUENCY, node, tones, &settings)
}

/// Amplitudes (m/s²) of the first and third harmonic where the force acts.
fn accelerations(found: &DualTone) -> [f64; 2] {
    let driven = time_derivative(found.point.nodes.last().unwrap(), 2, found.point.angular_frequency);
    [1, 3].map(|order| driven[2 * order - 1].hypot(driven[2 * order]))
}

/// The keys of a law, each of its own parameters in the middle of what a fit may try.
fn keys(law: &LawKind) -> String {
    let middle = |parameter: &LawParameter| {
        let (low, high, scale) = (parameter.range)(STIFFNESS);
        let value = if scale == Scale::Logarithmic { (low * high).sqrt() } else { 0.5 * (low + high) };
        format!("{} = {value:?}\n", parameter.quantity.name)
    };
    format!("law = \"{}\"\n{}", law.name, law.parameters.iter().map(middle).collect::<String>())
}

const MANY: &str = "[[effect]]\nid = \"micro_slip\"\nspread = 1.0\n";

#[test]
fn every_law_of_the_catalogue_is_held_at_the_highest_published_level() {
    let mut laws: Vec<(String, &str)> = LAWS.iter().map(|law| (keys(law), "")).collect();
    laws.push((keys(LAWS[0]), MANY));
    for (law, effect) in laws {
        let found = held(&rig(&law, "normal_law = \"linear\"\n", effect), HIGHEST, 3);
        let found = found.unwrap_or_else(|error| panic!("{law}: {error}"));
        let near = |(found, wanted): (f64, f64)| (found / wanted - 1.0).abs() < 1e-8;
        assert!(accelerations(&found).into_iter().zip(HIGHEST).all(near), "{law}");
    }
}

/// Where one slider begins to slip, the amplitudes that two tones hold turn back, and rise again once it slips at both ends: in
/// between three motions have the same amplitudes.
#[test]
fn one_slider_is_held_beyond_the_fold_where_slip_begins_and_moves_so_in_time() {
    let mut system = rig("law = \"jenkins\"\n", "normal_law = \"linear\"\n", "");
    for mode in 0..4 {
        system.sensors.push(system.ports.len());
        system.ports.push(Port::linear(&format!("mode {}", mode + 1), vec![(mode, 1.0)]));
    }
    let found = held(&system, [14.0, 34.0], 21).unwrap();
    let below = held(&system, [10.0, 10.0 * 34.0 / 14.0], 21).unwrap();
    assert_eq!(below.point.contacts[0].dissipated_energy, 0.0);
    assert!(found.point.contacts[0].dissipated_energy > 1e-4);
    // In time, from the motion found, under its tones.
    let [first, third] = found.force;
    let waveform = [0.0, 0.0, first, 0.0, 0.0, 0.0, third];
    let mut steps = ClassicalSteps::new(&system).unwrap();
    let modes = &found.point.nodes[3..7];
    let far = |k: &usize| value(&found.point.contacts[0].displacement, TAU * *k as f64 / 2000.0).abs();
    let begin = (0..2000).max_by(|a, b| far(a).total_cmp(&far(b))).unwrap();
    let phase = |k: f64| TAU * k / 2000.0;
    let there = |order: usize| -> Vec<f64> {
        let speed = TAU * FREQUENCY;
        modes.iter().map(|q| value(&time_derivative(q, order, speed), phase(begin as f64))).collect()
    };
    let mut motion = steps.moving(&there(0), &there(1));
    let mut squares = [[0.0; 2]; 2];
    for k in begin..begin + 3 * 2000 {
        let force = [0.0, 0.5, 1.0].map(|part| value(&waveform, phase(k as f64 + part)));
        steps.advance(&mut motion, 1.0 / FREQUENCY / 2000.0, force);
        let contact = &found.point.contacts[0];
        let time = &motion.contacts[0];
        let pairs = [(&contact.displacement, time.displacement[0]), (&contact.force, time.force[0])];
        for (sums, (balance, time)) in squares.iter_mut().zip(pairs) {
            let balance = value(balance, phase((k + 1) as f64));
            *sums = [sums[0] + (time - balance).powi(2), sums[1] + balance.powi(2)];
        }
    }
    for (name, [difference, size]) in ["ξ", "S"].iter().zip(squares) {
        let relative = (difference / size).sqrt();
        assert!(relative < 0.01, "{name} in time differs by {relative}");
    }
}
