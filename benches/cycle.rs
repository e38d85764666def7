//! Time of a contact carried over a period, force and Jacobian: `cargo bench --bench cycle`.

use divan::{AllocProfiler, Bencher, black_box};
use stickslip::contact::{ContactLaw, Iwan, IwanSpacing, Jenkins, Valanis};
use stickslip::harmonic::{ContactMapping, HarmonicSet, Method};

#[global_allocator]
static ALLOCATOR: AllocProfiler = AllocProfiler::system();

const LOAD: f64 = 147.15;

fn main() {
    divan::main();
}

/// A first harmonic with a fraction of the others that falls with the cube of their order, as responses have.
fn displacement(set: HarmonicSet, amplitude: f64) -> Vec<f64> {
    let mut u = vec![0.0; set.len()];
    for (order, place) in set.orders().filter(|(order, _)| *order > 0) {
        let fraction = amplitude / (order * order * order) as f64;
        (u[place], u[place + 1]) = (0.8 * fraction, 0.6 * fraction);
    }
    u
}

fn evaluate(bencher: Bencher, law: &dyn ContactLaw, set: HarmonicSet, method: Method, amplitude: f64) {
    evaluate_behind(bencher, law, set, method, amplitude, 0.0);
}

/// The same behind a spring of `compliance` (m/N).
fn evaluate_behind(
    bencher: Bencher,
    law: &dyn ContactLaw,
    set: HarmonicSet,
    method: Method,
    amplitude: f64,
    compliance: f64,
) {
    let u = displacement(set, amplitude);
    let mut map = ContactMapping::new(set, method);
    let mut run = move || map.evaluate(law, LOAD, compliance, 300.0, black_box(&u));
    run().expect("the contact has a periodic state");
    bencher.bench_local(run);
}

fn jenkins() -> Jenkins {
    Jenkins::new(7.9e6, 0.617).unwrap()
}

fn valanis() -> Valanis {
    Valanis::from_lambda(7.9e6, 0.0, 0.3, 8.7e4, LOAD).unwrap()
}

#[divan::bench(args = [1, 3, 7, 21, 51, 101])]
fn jenkins_odd_harmonics(bencher: Bencher, highest: usize) {
    evaluate(bencher, &jenkins(), HarmonicSet::odd(highest), Method::Exact, 40e-6);
}

#[divan::bench(args = [1, 3, 7, 21, 51])]
fn jenkins_all_harmonics(bencher: Bencher, highest: usize) {
    evaluate(bencher, &jenkins(), HarmonicSet::full(highest), Method::Exact, 40e-6);
}

fn iwan(sliders: usize) -> Iwan {
    Iwan::new(7.9e6, 0.617, -0.5, 0.0, sliders, IwanSpacing::Equal).unwrap()
}

#[divan::bench(args = [1, 4, 16, 64, 256])]
fn sliders_at_21_odd_harmonics(bencher: Bencher, sliders: usize) {
    evaluate(bencher, &iwan(sliders), HarmonicSet::odd(21), Method::Exact, 40e-6);
}

#[divan::bench(args = [4, 16, 64, 256])]
fn sliders_behind_a_spring_at_21_odd_harmonics(bencher: Bencher, sliders: usize) {
    evaluate_behind(bencher, &iwan(sliders), HarmonicSet::odd(21), Method::Exact, 40e-6, 1e-8);
}

#[divan::bench]
fn valanis_9_harmonics_behind_a_spring(bencher: Bencher) {
    evaluate_behind(bencher, &valanis(), HarmonicSet::full(9), Method::Exact, 20e-6, 1e-8);
}

#[divan::bench(args = [5, 9, 18, 36])]
fn valanis_all_harmonics(bencher: Bencher, highest: usize) {
    evaluate(bencher, &valanis(), HarmonicSet::full(highest), Method::Exact, 20e-6);
}

#[divan::bench(args = [1e-6, 10e-6, 100e-6])]
fn valanis_18_harmonics(bencher: Bencher, amplitude: f64) {
    evaluate(bencher, &valanis(), HarmonicSet::full(18), Method::Exact, amplitude);
}

#[divan::bench(args = [9, 21])]
fn valanis_odd_harmonics(bencher: Bencher, highest: usize) {
    evaluate(bencher, &valanis(), HarmonicSet::odd(highest), Method::Exact, 20e-6);
}

#[divan::bench]
fn jenkins_21_odd_harmonics_by_1024_samples(bencher: Bencher) {
    evaluate(bencher, &jenkins(), HarmonicSet::odd(21), Method::Sampled { samples: 1024 }, 40e-6);
}
