//! Time and allocations of condensing a structure: `cargo bench --bench receptance`.
//!
//! One evaluation is one harmonic: compliances of one contact against contact and excitation, with their
//! derivatives. `eleven_harmonics` is what one Newton step on 21 odd harmonics of the two-mass system takes.

use divan::{AllocProfiler, Bencher, black_box};
use nalgebra::Complex;
use stickslip::model::{Anchor, Mass, Oscillator, Spring};
use stickslip::system::{Method, Receptance, Rows};

#[global_allocator]
static ALLOCATOR: AllocProfiler = AllocProfiler::system();

fn main() {
    divan::main();
}

/// A chain from the ground, excited at its first mass, with the contact at its last. With `ground_damping`
/// its dampers are not proportional to its springs and masses.
fn chain(size: usize, ground_damping: f64) -> Oscillator {
    let at = |i: usize| if i == 0 { Anchor::Ground } else { Anchor::Mass(i - 1) };
    let spring = |i| Spring { between: [at(i), at(i + 1)], stiffness: 1.0, damping: 0.02 };
    let mut springs: Vec<Spring> = (0..size).map(spring).collect();
    springs.push(Spring { between: [Anchor::Ground, at(1)], stiffness: 0.0, damping: ground_damping });
    let masses = (0..size).map(|i| Mass { name: format!("m{}", i + 1), mass: 1.0 }).collect();
    Oscillator { masses, springs, contact: Some(size - 1), excitation: 0 }
}

fn harmonics(bencher: Bencher, size: usize, method: Method, ground_damping: f64, count: usize) {
    let structure = chain(size, ground_damping).structure().expect("a chain");
    let mut receptance = Receptance::with_method(&structure, method).expect("open");
    let mut out = receptance.compliance(Rows::Contacts);
    bencher.bench_local(|| {
        for harmonic in (1..2 * count).step_by(2) {
            let omega = black_box(0.7) * harmonic as f64;
            let (damping, inertia) = (Complex::new(0.0, omega), Complex::new(-omega * omega, 0.0));
            receptance.evaluate(damping, inertia, Rows::Contacts, &mut out).expect("regular");
            black_box(&out);
        }
    });
}

#[divan::bench]
fn eleven_harmonics_modal(bencher: Bencher) {
    harmonics(bencher, 2, Method::Modal, 0.0, 11);
}

#[divan::bench]
fn eleven_harmonics_dense(bencher: Bencher) {
    harmonics(bencher, 2, Method::Dense, 0.1, 11);
}

#[divan::bench(args = [2, 10, 30, 100, 300])]
fn modal(bencher: Bencher, size: usize) {
    harmonics(bencher, size, Method::Modal, 0.0, 1);
}

#[divan::bench(args = [2, 10, 30, 100, 300])]
fn dense(bencher: Bencher, size: usize) {
    harmonics(bencher, size, Method::Dense, 0.1, 1);
}

#[divan::bench(args = [2, 10, 30, 100, 300, 1000, 10_000])]
fn sparse(bencher: Bencher, size: usize) {
    harmonics(bencher, size, Method::Sparse, 0.1, 1);
}
