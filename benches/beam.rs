//! The published beam with its frictional support in the frequency domain.

use std::f64::consts::TAU;

use divan::Bencher;
use stickslip::contact::{Jenkins, Valanis};
use stickslip::harmonic::{ContactOnBeam, Method, Settings, backbone, forced_response, phase_resonance};
use stickslip::model::{Beam, Damping, Model, Structure};
use stickslip::structure::ModalBeam;

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
    let contact = ContactOnBeam { law: &law, normal_load: LOAD };
    let settings = Settings { harmonics, ..Settings::default() };
    let levels: Vec<f64> = (10..=70).map(f64::from).collect();
    bencher.bench(|| backbone(&beam, Some(contact), &levels, &settings, &[]).expect("converged"));
}

/// One level without a start.
#[divan::bench(args = [10.0, 40.0])]
fn cold_resonance_6_modes_9_harmonics(bencher: Bencher, level: f64) {
    let (beam, law) = (published(6), valanis());
    let contact = ContactOnBeam { law: &law, normal_load: LOAD };
    let settings = Settings { harmonics: 9, ..Settings::default() };
    bencher.bench(|| phase_resonance(&beam, Some(contact), level, &settings, None).expect("converged"));
}

/// A steady record at two harmonics of a period of 20 ms.
#[divan::bench(args = [(6, 30), (12, 30)])]
fn cold_steady_record(bencher: Bencher, (modes, harmonics): (usize, usize)) {
    let beam = published(modes);
    let law = Jenkins::new(7e6, 0.5).expect("a law");
    let contact = ContactOnBeam { law: &law, normal_load: LOAD };
    let settings =
        Settings { harmonics, method: Method::Sampled { samples: 256 }, tolerance: 1e-8, max_iterations: 40 };
    let mut force = [0.0; 7];
    (force[1], force[5]) = (6.0, 10.0);
    bencher.bench(|| {
        forced_response(&beam, Some(contact), TAU / (TAU * 51.0), &force, &settings, None).expect("converged")
    });
}
