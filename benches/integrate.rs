//! Time of one communication step of 1e-4 s of the beam of the frictional-support rig, and the
//! allocations it makes (none).

#[path = "../tests/common/mod.rs"]
mod common;

use std::sync::Arc;

use common::beam::steel_beam;
use common::time::{held, loaded, rest, supported_by};
use divan::{AllocProfiler, Bencher};
use stickslip::contact::{ContactLaw, Jenkins, Valanis};
use stickslip::time::{Ramp, Settings};

#[global_allocator]
static ALLOC: AllocProfiler = AllocProfiler::system();

const MODES: [usize; 5] = [2, 4, 6, 12, 20];
const STEP: f64 = 1e-4;
const LOAD: f64 = 150.0;

fn main() {
    divan::main();
}

/// A force near the first resonance, held over each step, that takes the contact through stick and
/// slip: the mean over many cycles, events included.
fn excitation(step: usize) -> f64 {
    20.0 * (330.0 * STEP * step as f64).sin()
}

fn friction(bencher: Bencher, modes: usize, law: Arc<dyn ContactLaw>) {
    let mut integrator = supported_by(&steel_beam(modes, 0.003), law, LOAD);
    let mut motion = rest(&mut integrator);
    let settings = Settings::default();
    let mut step = 0;
    let mut advance = move || {
        let inputs = held(excitation(step), LOAD);
        step += 1;
        integrator.advance(&mut motion, STEP, &inputs, &settings).expect("legal step");
    };
    (0..20_000).for_each(|_| advance()); // past the transient
    bencher.bench_local(advance);
}

#[divan::bench(args = MODES, sample_count = 50, sample_size = 1000)]
fn frictional_beam_jenkins(bencher: Bencher, modes: usize) {
    friction(bencher, modes, Arc::new(Jenkins::new(7.9e6, 0.6).expect("legal law")));
}

#[divan::bench(args = MODES, sample_count = 50, sample_size = 1000)]
fn frictional_beam_valanis(bencher: Bencher, modes: usize) {
    friction(bencher, modes, Arc::new(Valanis::new(7.9e6, 0.6, 0.3, 0.0).expect("legal law")));
}

#[divan::bench(args = MODES, sample_count = 50, sample_size = 1000)]
fn modal_beam_external_force(bencher: Bencher, modes: usize) {
    let mut integrator = loaded(&steel_beam(modes, 0.003));
    let mut motion = rest(&mut integrator);
    let settings = Settings::default();
    let mut step = 0;
    bencher.bench_local(move || {
        let force = 80.0 * (330.0 * STEP * step as f64).cos();
        let inputs = [Ramp::held(excitation(step)), Ramp::held(force)];
        step += 1;
        integrator.advance(&mut motion, STEP, &inputs, &settings).expect("legal step");
    });
}
