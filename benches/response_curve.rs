//! Time per point of response curves of the two-mass oscillator with a Jenkins element:
//! `cargo bench --bench response_curve`.
//!
//! Curves are followed by arc length from 0.2 to 2 rad/s under an amplitude of 0.4 N, with the
//! truncation error of every point estimated and the peaks located.

use std::sync::Arc;

use divan::Bencher;
use stickslip::contact::Jenkins;
use stickslip::harmonic::{Assembly, Control, Curve, CurveSettings, frequency_response};
use stickslip::system::{LinearStructure, Output};

fn main() {
    let curve = follow(21, false);
    let steps: usize = curve.points.iter().map(|point| point.iterations).sum();
    println!("21 harmonics: {} points, {steps} Newton steps, {:?}", curve.points.len(), curve.ending);
    let mut times: Vec<f64> = (0..41)
        .map(|_| {
            let start = std::time::Instant::now();
            let points = divan::black_box(follow(21, false)).points.len();
            start.elapsed().as_secs_f64() / points as f64
        })
        .collect();
    times.sort_by(f64::total_cmp);
    println!("per point: median {:.1} µs, fastest {:.1} µs", 1e6 * times[20], 1e6 * times[0]);
    divan::main();
}

fn follow(harmonics: usize, all_harmonics: bool) -> Curve {
    let output = |name: &str, k| Output { name: name.into(), row: vec![(k, 1.0)] };
    let structure = LinearStructure {
        size: 2,
        mass: vec![(0, 0, 1.0), (1, 1, 1.0)],
        damping: vec![(0, 0, 0.1), (1, 1, 0.1)],
        stiffness: vec![(0, 0, 1.5), (0, 1, -0.5), (1, 0, -0.5), (1, 1, 0.5)],
        contacts: vec![vec![(1, 1.0)]],
        excitation: vec![(0, 1.0)],
        outputs: vec![output("x", 0), output("y", 1)],
    };
    let law = Jenkins::new(0.2, 0.02).expect("legal parameters");
    let assembly = Assembly::new(structure.system(vec![(Arc::new(law), 1.0)]));
    let settings = CurveSettings { harmonics, all_harmonics, ..CurveSettings::default() };
    frequency_response(&assembly, 0.2, 2.0, &Control::Level(0.4), &settings, &mut |_| true)
        .expect("the curve has a first point")
}

/// A whole curve on the odd harmonics, which its symmetry allows.
#[divan::bench(args = [3, 7, 21, 51, 101])]
fn odd_harmonics(bencher: Bencher, harmonics: usize) {
    let points = follow(harmonics, false).points.len();
    bencher.counter(divan::counter::ItemsCount::new(points)).bench(|| follow(harmonics, false));
}

/// The same with bias and even harmonics among the unknowns.
#[divan::bench(args = [7, 21])]
fn all_harmonics(bencher: Bencher, harmonics: usize) {
    let points = follow(harmonics, true).points.len();
    bencher.counter(divan::counter::ItemsCount::new(points)).bench(|| follow(harmonics, true));
}
