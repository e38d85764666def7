//! A friction contact, step by step: displacement in, force out. The loop's area is the dissipated energy.
//!
//! `cargo run --release -p stickslip --example jenkins_step`

use std::f64::consts::TAU;

use stickslip::prelude::*;

fn main() -> Result<(), LawError> {
    let (stiffness, friction, normal_load) = (5.1e6, 0.47, 162.0); // N/m, 1, N
    let (amplitude, samples) = (50e-6, 400);
    let law = Jenkins::new(stiffness, friction)?;

    // The law remembers nothing by itself: its memory is this slice, which we own.
    let mut state = vec![0.0; law.state_len()];
    let mut next = state.clone();
    law.set_state(0.0, normal_load, 0.0, &mut state);

    let mut dissipated = 0.0;
    for k in 1..=2 * samples {
        let phase = TAU * k as f64 / samples as f64;
        let inputs = Inputs { displacement: amplitude * phase.sin(), velocity: 0.0, normal_load };
        let response = law.step(&state, inputs, &mut next);
        std::mem::swap(&mut state, &mut next);
        if k > samples {
            dissipated += response.dissipated_energy; // the second period is the steady one
        }
        if k % 50 == 0 {
            let displacement = 1e6 * inputs.displacement;
            println!("{displacement:8.2} µm {:8.2} N  {:?}", response.force, response.slip_state);
        }
    }
    let limit = law.limit(normal_load);
    let exact = 4.0 * limit * (amplitude - limit / stiffness);
    println!("dissipated per cycle: {dissipated:.6e} J; closed form: {exact:.6e} J");
    Ok(())
}
