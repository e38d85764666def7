//! Time of one period of the two-mass system with a Jenkins contact in the exact flow, of a periodic motion by
//! shooting, and of the Floquet multipliers along a given displacement.

#[path = "../tests/common/mod.rs"]
mod common;

use std::f64::consts::TAU;

use common::oscillator::two_masses;
use divan::Bencher;
use stickslip::contact::Jenkins;
use stickslip::harmonic::stability::floquet;
use stickslip::time::{Excitation, LoadedContact, OscillatorFlow, ShootingSettings, shoot};

const FREQUENCIES: [f64; 3] = [0.5, 1.0, 1.3];

fn main() {
    divan::main();
}

#[divan::bench(args = FREQUENCIES)]
fn one_period_of_the_exact_flow(bencher: Bencher, omega: f64) {
    let law = Jenkins::new(0.2, 0.02).expect("legal law");
    let contacts = [LoadedContact { law: &law, normal_load: 1.0 }];
    let mut flow = OscillatorFlow::new(&two_masses(0.1), &contacts).expect("legal structure");
    let excitation = Excitation::cosine(omega, 0.4);
    let mut motion = flow.rest();
    let mut advance = move || flow.advance(&mut motion, TAU / omega, &excitation).expect("legal step");
    (0..100).for_each(|_| drop(advance()));
    bencher.bench_local(advance);
}

#[divan::bench(args = FREQUENCIES)]
fn periodic_motion_by_shooting(bencher: Bencher, omega: f64) {
    let law = Jenkins::new(0.2, 0.02).expect("legal law");
    let contacts = [LoadedContact { law: &law, normal_load: 1.0 }];
    let mut flow = OscillatorFlow::new(&two_masses(0.1), &contacts).expect("legal structure");
    let excitation = Excitation::cosine(omega, 0.4);
    bencher
        .bench_local(|| shoot(&mut flow, &excitation, None, &ShootingSettings::default()).expect("periodic"));
}

#[divan::bench]
fn floquet_multipliers_of_a_displacement_of_21_harmonics(bencher: Bencher) {
    let law = Jenkins::new(0.2, 0.02).expect("legal law");
    let contacts = [LoadedContact { law: &law, normal_load: 1.0 }];
    let mut displacement = vec![0.0; 43];
    (displacement[1], displacement[2], displacement[5]) = (0.2, 1.7, 0.01);
    let structure = two_masses(0.1);
    bencher.bench_local(|| floquet(&structure, &contacts, &[&displacement], 0.5).expect("multipliers"));
}
