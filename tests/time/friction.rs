//! Time integration with a friction contact, against an exact solver and against laws of mechanics.

use std::sync::Arc;

use stickslip::contact::{ContactLaw, Jenkins, SlipState, Valanis};
use stickslip::system::ModalBeam;
use stickslip::time::{Integrator, Motion, Outputs, Ramp, Settings};

use crate::common::beam::{one_mode, steel_beam};
use crate::common::time::{ExactJenkins, at_end, held, rest, supported, supported_by, tolerance};

const STIFFNESS: f64 = 7.9e6;
const LOAD: f64 = 150.0;
const DAMPING: f64 = 0.003;

fn jenkins() -> Jenkins {
    Jenkins::new(STIFFNESS, 0.6).unwrap()
}

/// e0 = 7.9e6 N/m, e_t = 0, κ = 0.3, limit 90 N.
fn valanis() -> Valanis {
    Valanis::new(STIFFNESS, 0.6, 0.3, 0.0).unwrap()
}

fn laws() -> [Arc<dyn ContactLaw>; 2] {
    [Arc::new(jenkins()), Arc::new(valanis())]
}

/// A square wave of 50 Hz, held over communication steps of 1e-3 s or less.
fn square_wave(time: f64, force: f64) -> f64 {
    if (time * 100.0 + 1e-9).floor() as i64 % 2 == 0 { force } else { -force }
}

/// Advances from `from` (s) to `to` (s) in communication steps of `duration` under a square wave.
fn drive(
    integrator: &mut Integrator,
    motion: &mut Motion,
    force: f64,
    (from, to): (f64, f64),
    duration: f64,
    settings: &Settings,
) {
    let steps = ((to - from) / duration).round() as usize;
    for i in 0..steps {
        let excitation = square_wave(from + i as f64 * duration, force);
        integrator.advance(motion, duration, &held(excitation, LOAD), settings).unwrap();
    }
}

/// Largest errors in displacement (relative to the largest) and dissipated energy (relative) over
/// fifty cycles of a square wave, with the contact in stick and in slip in every cycle.
fn jenkins_errors(relative: f64, duration: f64) -> (f64, f64) {
    let (omega, shape, phi, force) = (330.0, 0.06, 1.2, 12.0);
    let mut exact = ExactJenkins {
        omega,
        zeta: DAMPING,
        shape,
        stiffness: STIFFNESS,
        limit: 0.6 * LOAD,
        q: 0.0,
        v: 0.0,
        slider: 0.0,
        dissipated: 0.0,
        slipping: 0.0,
    };
    let law = jenkins();
    let mut integrator = supported(&one_mode(omega, DAMPING, shape, phi, 0.0), law, LOAD);
    let mut motion = rest(&mut integrator);
    let (mut worst, mut largest, mut slips, mut sticks) = (0.0_f64, 0.0_f64, 0, 0);
    for half_cycle in 0..100 {
        let start = half_cycle as f64 * 0.01;
        let span = (start, start + 0.01);
        drive(&mut integrator, &mut motion, force, span, duration, &tolerance(relative));
        for _ in 0..10 {
            exact.advance(phi * square_wave(start, force), 1e-3);
            if exact.slipping == 0.0 { sticks += 1 } else { slips += 1 }
        }
        worst = worst.max((motion.modal_displacement()[0] - exact.q).abs());
        worst = worst.max((motion.modal_velocity()[0] - exact.v).abs() / omega);
        largest = largest.max(exact.q.abs()).max(exact.v.abs() / omega);
    }
    assert!(slips > 100 && sticks > 100, "the oracle should stick and slip: {sticks}, {slips}");
    (worst / largest, (at_end(&motion).dissipated_energy / exact.dissipated - 1.0).abs())
}

#[test]
fn jenkins_oscillator_follows_the_exact_event_solution_over_fifty_cycles() {
    for (relative, duration) in [(1e-6, 1e-3), (1e-6, 1e-4), (1e-9, 1e-3)] {
        let (error, dissipation) = jenkins_errors(relative, duration);
        assert!(error < 5.0 * relative, "tolerance {relative}, step {duration}: {error}");
        assert!(dissipation < 5.0 * relative, "tolerance {relative}, step {duration}: {dissipation}");
    }
}

#[test]
fn the_work_of_the_exciter_is_stored_damped_or_dissipated() {
    let beam = steel_beam(4, 0.01);
    let law = jenkins();
    let mut integrator = supported(&beam, law, LOAD);
    let mut motion = rest(&mut integrator);
    // Every sensor reads one mode, so that modal accelerations are known too.
    let stored = |motion: &Motion| -> f64 {
        let force = at_end(motion).force;
        let modal: f64 = (0..4)
            .map(|i| {
                let (q, v) = (motion.modal_displacement()[i], motion.modal_velocity()[i]);
                0.5 * v * v + 0.5 * (beam.angular_frequency[i] * q).powi(2)
            })
            .sum();
        modal + 0.5 * force * force * (1.0 / STIFFNESS + beam.axial_flexibility)
    };
    let damping_power = |motion: &Motion| -> f64 {
        (0..4)
            .map(|i| {
                let rate = 2.0 * beam.damping_ratio[i] * beam.angular_frequency[i];
                rate * motion.modal_velocity()[i].powi(2)
            })
            .sum()
    };
    let excited = |motion: &Motion| -> f64 {
        motion.modal_displacement().iter().zip(&beam.excitation_shape).map(|(q, phi)| q * phi).sum()
    };
    let duration = 1e-5;
    let (mut work, mut damped) = (0.0, 0.0);
    for i in 0..2000 {
        let force = square_wave(2.0 * i as f64 * duration, 40.0);
        let (before, power) = (excited(&motion), damping_power(&motion));
        let half = 0.5 * duration;
        integrator.advance(&mut motion, half, &held(force, LOAD), &tolerance(1e-8)).unwrap();
        let middle = damping_power(&motion);
        integrator.advance(&mut motion, half, &held(force, LOAD), &tolerance(1e-8)).unwrap();
        work += force * (excited(&motion) - before);
        damped += duration / 6.0 * (power + 4.0 * middle + damping_power(&motion));
    }
    let dissipated = at_end(&motion).dissipated_energy;
    assert!(dissipated > 0.05 * work, "the contact should slip: {dissipated} of {work}");
    let balance = work - stored(&motion) - damped - dissipated;
    assert!(balance.abs() < 1e-6 * work, "{balance} of {work}");
}

#[test]
fn a_state_written_back_gives_the_same_future_bit_for_bit() {
    for law in laws() {
        let beam = steel_beam(4, DAMPING);
        let settings = Settings::default();
        let mut integrator = supported_by(&beam, law.clone(), LOAD);
        let mut motion = rest(&mut integrator);
        drive(&mut integrator, &mut motion, 40.0, (0.0, 0.0237), 1e-4, &settings);
        let mut saved = vec![0.0; motion.state_len()];
        assert!(motion.write_state(&mut saved));
        drive(&mut integrator, &mut motion, 40.0, (0.0237, 0.04), 1e-4, &settings);
        // Another integrator, with buffers that know nothing of the first run.
        let mut other = supported_by(&beam, law.clone(), LOAD);
        let mut again = rest(&mut other);
        assert!(again.read_state(&saved));
        drive(&mut other, &mut again, 40.0, (0.0237, 0.04), 1e-4, &settings);
        let bits = |motion: &Motion| motion.state().iter().map(|x| x.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(&motion), bits(&again));
        assert!(!again.read_state(&saved[1..]));
    }
}

#[test]
fn the_trajectory_does_not_depend_on_the_communication_step() {
    for law in laws() {
        let beam = steel_beam(4, DAMPING);
        let run = |duration: f64| {
            let mut integrator = supported_by(&beam, law.clone(), LOAD);
            let mut motion = rest(&mut integrator);
            drive(&mut integrator, &mut motion, 40.0, (0.0, 0.05), duration, &tolerance(1e-7));
            motion
        };
        let (coarse, fine) = (run(1e-3), run(1e-5));
        let scale = coarse.modal_displacement().iter().fold(0.0_f64, |m, q| m.max(q.abs()));
        for (a, b) in coarse.modal_displacement().iter().zip(fine.modal_displacement()) {
            assert!((a - b).abs() < 1e-6 * scale, "{a} {b}");
        }
        assert!((at_end(&coarse).force - at_end(&fine).force).abs() < 1e-5 * law.limit(LOAD));
        let (a, b) = (at_end(&coarse).dissipated_energy, at_end(&fine).dissipated_energy);
        assert!(a > 0.0 && (a - b).abs() < 1e-6 * a, "{a} {b}");
    }
}

#[test]
fn a_normal_load_that_lifts_off_and_returns_is_followed_at_any_communication_step() {
    // Valanis' law is of second order in the step under a varying load, so less is asked of it.
    for (law, (relative, agreement, fine, milliseconds)) in
        laws().into_iter().zip([(1e-7, 1e-8, 20, 30), (1e-5, 1e-5, 20, 30)])
    {
        let beam = steel_beam(3, DAMPING);
        // Straight pieces with corners at whole milliseconds, below zero now and then.
        let load = |time: f64| {
            let knot = |i: f64| 80.0 + 110.0 * (0.7 * i).sin();
            let t = time * 1e3;
            let i = (t + 1e-9).floor();
            knot(i) + (t - i) * (knot(i + 1.0) - knot(i))
        };
        let run = |per_millisecond: usize| {
            let duration = 1e-3 / per_millisecond as f64;
            let mut integrator = supported_by(&beam, law.clone(), load(0.0));
            let mut motion = rest(&mut integrator);
            let mut separated = 0;
            for i in 0..milliseconds * per_millisecond {
                let time = i as f64 * duration;
                let normal_load = Ramp::line(load(time), load(time + duration));
                let inputs = [Ramp::held(square_wave(time, 40.0)), normal_load];
                integrator.advance(&mut motion, duration, &inputs, &tolerance(relative)).unwrap();
                separated += usize::from(at_end(&motion).slip_state == SlipState::Separated);
            }
            assert!(separated > 0);
            motion
        };
        let (coarse, fine) = (run(1), run(fine));
        let scale = coarse.modal_displacement().iter().fold(0.0_f64, |m, q| m.max(q.abs()));
        for (a, b) in coarse.modal_displacement().iter().zip(fine.modal_displacement()) {
            assert!((a - b).abs() < agreement * scale, "{law:?}: {a} {b}");
        }
    }
}

#[test]
fn mirrored_forces_give_the_mirrored_motion() {
    let mut beam = steel_beam(3, DAMPING);
    beam.shortening.fill(0.0); // shortening is the one thing that knows a direction
    for law in laws() {
        let mut integrator = supported_by(&beam, law.clone(), LOAD);
        let mut run = |force: f64| {
            let mut motion = rest(&mut integrator);
            drive(&mut integrator, &mut motion, force, (0.0, 0.03), 1e-4, &Settings::default());
            motion
        };
        let (plus, minus) = (run(40.0), run(-40.0));
        let scale = plus.modal_displacement().iter().fold(0.0_f64, |m, q| m.max(q.abs()));
        for (a, b) in plus.modal_displacement().iter().zip(minus.modal_displacement()) {
            assert!((a + b).abs() <= 1e-13 * scale, "{a} {b}");
        }
        assert_eq!(at_end(&plus).dissipated_energy, at_end(&minus).dissipated_energy);
    }
}

#[test]
fn an_axial_spring_in_series_with_jenkins_is_jenkins_with_the_series_stiffness() {
    let flexibility = 1e-7; // a k = 0.79: nothing negligible
    let (law, series) = (jenkins(), Jenkins::new(STIFFNESS / (1.0 + flexibility * STIFFNESS), 0.6).unwrap());
    let run = |law: Jenkins, flexibility: f64| {
        let mut beam = steel_beam(3, DAMPING);
        beam.axial_flexibility = flexibility;
        let mut integrator = supported(&beam, law, LOAD);
        let mut motion = rest(&mut integrator);
        drive(&mut integrator, &mut motion, 40.0, (0.0, 0.05), 1e-4, &tolerance(1e-8));
        motion
    };
    let (with, without) = (run(law, flexibility), run(series, 0.0));
    let scale = with.modal_displacement().iter().fold(0.0_f64, |m, q| m.max(q.abs()));
    for (a, b) in with.modal_displacement().iter().zip(without.modal_displacement()) {
        assert!((a - b).abs() < 1e-7 * scale, "{a} {b}");
    }
    let (a, b) = (at_end(&with).force, at_end(&without).force);
    assert!((a - b).abs() < 1e-6 * 90.0, "{a} {b}");
    let (a, b) = (at_end(&with).dissipated_energy, at_end(&without).dissipated_energy);
    assert!((a - b).abs() < 1e-7 * a, "{a} {b}");
}

#[test]
fn six_modes_with_valanis_reach_a_steady_and_repeatable_amplitude() {
    let beam = steel_beam(6, DAMPING);
    let law = valanis();
    let run = || {
        let mut integrator = supported(&beam, law, LOAD);
        let mut motion = rest(&mut integrator);
        let duration = 2e-4; // a hundred steps a cycle at 50 Hz
        let force = |t: f64| 15.0 * (2.0 * std::f64::consts::PI * 50.0 * t).sin();
        let mut peaks = Vec::new();
        for cycle in 0..60 {
            let mut peak = 0.0_f64;
            for i in 0..100 {
                let t = (cycle * 100 + i) as f64 * duration;
                let excitation = Ramp::line(force(t), force(t + duration));
                let inputs = [excitation, Ramp::held(LOAD)];
                integrator.advance(&mut motion, duration, &inputs, &tolerance(1e-5)).unwrap();
                peak = peak.max(at_end(&motion).displacement);
            }
            peaks.push(peak);
        }
        peaks
    };
    let peaks = run();
    let (last, before) = (peaks[59], peaks[58]);
    assert!(last > 5e-6 && last < 1e-3, "{last}");
    assert!((last - before).abs() < 2e-3 * last, "{last} {before}");
    assert_eq!(peaks, run());
}

#[test]
fn twenty_undamped_modes_on_a_stuck_contact_keep_their_energy() {
    let beam: ModalBeam = steel_beam(20, 0.0);
    let law = Jenkins::new(STIFFNESS, 1e3).unwrap();
    let mut integrator = supported(&beam, law, LOAD);
    let q: Vec<f64> = beam.angular_frequency.iter().map(|omega| 0.01 / omega).collect();
    let mut motion = integrator.moving(&q, &[0.0; 20], &held(0.0, LOAD), &[]).unwrap();
    let energy = |motion: &Motion| -> f64 {
        let modes = motion.modal_displacement().iter().zip(motion.modal_velocity());
        let modal: f64 = modes
            .zip(&beam.angular_frequency)
            .map(|((q, v), omega)| 0.5 * (v * v + omega * omega * q * q))
            .sum();
        modal + 0.5 * at_end(motion).force.powi(2) * (1.0 / STIFFNESS + beam.axial_flexibility)
    };
    let start = energy(&motion);
    for _ in 0..50 {
        integrator.advance(&mut motion, 1e-4, &held(0.0, LOAD), &tolerance(1e-6)).unwrap();
    }
    let end = energy(&motion);
    assert!((end / start - 1.0).abs() < 1e-4, "{start} {end}");
    assert_eq!(at_end(&motion).dissipated_energy, 0.0);
}

#[test]
fn outputs_agree_with_differences_of_the_motion() {
    let beam = steel_beam(3, DAMPING);
    let law = valanis();
    let mut integrator = supported(&beam, law, LOAD);
    let mut motion = rest(&mut integrator);
    let settings = tolerance(1e-10);
    drive(&mut integrator, &mut motion, 40.0, (0.0, 0.013), 1e-3, &settings);
    let mut outputs = [Outputs::default(), Outputs::default(), Outputs::default()];
    let (inputs, h) = (held(-40.0, LOAD), 1e-6);
    for out in &mut outputs {
        integrator.outputs(&motion, f64::INFINITY, &inputs, out).unwrap();
        integrator.advance(&mut motion, h, &inputs, &settings).unwrap();
    }
    let [before, now, after] = outputs;
    let slope = (after.contacts[0].displacement - before.contacts[0].displacement) / (2.0 * h);
    let velocity = now.contacts[0].velocity;
    assert!((velocity - slope).abs() < 1e-4 * velocity.abs(), "{velocity} {slope}");
    for i in 0..3 {
        let (a, b, c) = (before.sensors[i], now.sensors[i], after.sensors[i]);
        let slope = (c.displacement - a.displacement) / (2.0 * h);
        assert!((b.velocity - slope).abs() < 1e-4 * b.velocity.abs().max(1e-3), "{} {slope}", b.velocity);
        let slope = (c.velocity - a.velocity) / (2.0 * h);
        assert!((b.acceleration - slope).abs() < 1e-4 * b.acceleration.abs().max(1.0));
    }
}
