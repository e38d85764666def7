//! The published beam with its frictional support in the frequency domain.

use std::f64::consts::TAU;
use std::sync::Arc;

use divan::Bencher;
use stickslip::contact::{Jenkins, Valanis};
use stickslip::harmonic::{
    Assembly, Control, CurveSettings, backbone, frequency_response, periodic_response, phase_resonance,
};
use stickslip::model::{Beam, Damping, Model, Structure};
use stickslip::system::ModalBeam;

const LOAD: f64 = 147.15;

fn main() {
    divan::main();
}

fn published(modes: usize) -> ModalBeam {
    let model = Model::parse(include_str!("../examples/frictional-support/published.toml")).expect("a model");
    let Structure::Beam(beam) = model.structure else { panic!("the example is a beam") };
    ModalBeam::new(&Beam { modes, damping: Damping::Uniform(0.003), ..beam }).expect("a beam")
}

fn valanis() -> Valanis {
    Valanis::from_lambda(7.9e6, 0.0, 0.3, 8.7e4, LOAD).expect("a law")
}

/// 61 levels from 10 to 70 m/s², each from the one below.
#[divan::bench(args = [(4, 5), (6, 9)])]
fn backbone_of_61_levels(bencher: Bencher, (modes, harmonics): (usize, usize)) {
    let (beam, law) = (published(modes), valanis());
    let system = beam.system(Some((Arc::new(law), LOAD))).expect("a system");
    let settings = CurveSettings { harmonics, tolerance: 1e-9, ..CurveSettings::default() };
    let levels: Vec<f64> = (10..=70).map(f64::from).collect();
    bencher.bench(|| backbone(&system, &levels, &settings, &[]).expect("converged"));
}

/// One level without a start.
#[divan::bench(args = [10.0, 40.0])]
fn cold_resonance_6_modes_9_harmonics(bencher: Bencher, level: f64) {
    let (beam, law) = (published(6), valanis());
    let system = beam.system(Some((Arc::new(law), LOAD))).expect("a system");
    let settings = CurveSettings { harmonics: 9, tolerance: 1e-9, ..CurveSettings::default() };
    bencher.bench(|| phase_resonance(&system, level, &settings, None).expect("converged"));
}

/// A steady response to two harmonics of a period of 20 ms, with the estimate of its error.
#[divan::bench(args = [(6, 30), (12, 30)])]
fn cold_steady_response(bencher: Bencher, (modes, harmonics): (usize, usize)) {
    let beam = published(modes);
    let law = Jenkins::new(7e6, 0.5).expect("a law");
    let system = beam.system(Some((Arc::new(law), LOAD))).expect("a system");
    let settings = CurveSettings { harmonics, tolerance: 1e-8, ..CurveSettings::default() };
    let waveform = vec![0.0, 6.0, 0.0, 0.0, 0.0, 10.0, 0.0];
    let assembly = Assembly { waveform, ..Assembly::new(system) };
    let control = Control::Level(1.0);
    bencher.bench(|| periodic_response(&assembly, TAU * 51.0, &control, &settings, None).expect("converged"));
}

/// A response over 48 … 56 Hz, 6 modes and 9 harmonics; the number of points is printed.
#[divan::bench(args = ["held at 30 m/s²", "at 8 N"])]
fn frequency_response_6_modes_9_harmonics(bencher: Bencher, control: &str) {
    let (beam, law) = (published(6), valanis());
    let assembly = Assembly::new(beam.system(Some((Arc::new(law), LOAD))).expect("a system"));
    let node = beam.sensors.len();
    let control = match control {
        "at 8 N" => Control::Level(8.0),
        _ => Control::Held { node, order: 1, derivative: 2, amplitude: 30.0 },
    };
    let settings = CurveSettings { harmonics: 9, tolerance: 1e-9, ..CurveSettings::default() };
    let run = || {
        frequency_response(&assembly, TAU * 48.0, TAU * 56.0, &control, &settings, &mut |_| true)
            .expect("a curve")
    };
    let curve = run();
    let steps: usize = curve.points.iter().map(|point| point.iterations).sum();
    eprintln!("{control:?}: {} points, {steps} Newton steps, {:?}", curve.points.len(), curve.ending);
    bencher.bench(run);
}
