//! A beam pushed at several places from outside: work and energy, reciprocity, symmetry, and two contacts coupled to it
//! against the same in one piece.

use stickslip::contact::Jenkins;
use stickslip::cosim::{Algorithm, Method, Settings, Source, Strong, System};
use stickslip::fmi::Instance;
use stickslip::model::{Damping, Model, Structure};
use stickslip::system::{LinearStructure, ModalBeam, Sensor};
use stickslip::time::{Excitation, LoadedContact, OscillatorFlow, Outputs, Ramp, Settings as Accuracy};

use crate::common::cosim::*;
use crate::common::time::{loaded, rest};

/// The standard beam with contact points at `places`, which are its sensors as well.
fn beam(places: &[f64], damping: f64) -> ModalBeam {
    let Structure::Beam(mut beam) = Model::parse(BEAM).unwrap().structure else { panic!("a beam") };
    beam.damping = Damping::Uniform(damping);
    beam.sensors = places.to_vec();
    beam.contact_points = places.to_vec();
    ModalBeam::new(&beam).unwrap()
}

fn along(shape: &[f64], q: &[f64]) -> f64 {
    shape.iter().zip(q).map(|(a, b)| a * b).sum()
}

#[test]
fn the_work_of_held_forces_is_the_energy_of_an_undamped_beam() {
    let beam = beam(&[0.2, 0.37], 0.0);
    let mut integrator = loaded(&beam);
    let mut motion = rest(&mut integrator);
    let accuracy = Accuracy { tolerance: 1e-12, ..Accuracy::default() };
    // What the end's force T does work on is c·q − ½ qᵀG q; the axial spring takes none of it back under a held force.
    let places = |q: &[f64]| {
        let turned: Vec<f64> = beam.shortening.chunks_exact(q.len()).map(|row| along(row, q)).collect();
        [
            along(&beam.excitation_shape, q),
            -(along(&beam.contact_shape, q) - 0.5 * along(q, &turned)),
            -along(&beam.contact_points[0].shape, q),
            -along(&beam.contact_points[1].shape, q),
        ]
    };
    let (mut work, mut turnover) = (0.0, 0.0);
    for k in 0..300 {
        let time = f64::from(k) * 1e-4;
        let forces = [
            20.0 * (324.0 * time).sin(),
            60.0 * (150.0 * time).cos(),
            8.0 * (700.0 * time).sin(),
            5.0 * (90.0 * time).cos(),
        ];
        let inputs = forces.map(Ramp::held);
        let before = places(motion.modal_displacement());
        integrator.advance(&mut motion, 1e-4, &inputs, &accuracy).unwrap();
        let after = places(motion.modal_displacement());
        for (force, (after, before)) in forces.iter().zip(after.iter().zip(before)) {
            work += force * (after - before);
            turnover += (force * (after - before)).abs();
        }
    }
    let (q, v) = (motion.modal_displacement(), motion.modal_velocity());
    let terms = beam.angular_frequency.iter().zip(q.iter().zip(v));
    let energy: f64 = terms.map(|(omega, (q, v))| 0.5 * (omega * omega * q * q + v * v)).sum();
    assert!(energy > 0.05 * turnover, "{energy:e} {turnover:e}");
    assert!((work - energy).abs() < 1e-9 * turnover, "{work:e} {energy:e}");
}

#[test]
fn a_force_at_the_exciter_is_the_excitation_turned_round() {
    let run = |turned: bool| {
        let beam = beam(&[0.55], 0.003);
        let mut integrator = loaded(&beam);
        let mut motion = rest(&mut integrator);
        for k in 0..100 {
            let (start, end) = (f64::from(k).sin(), f64::from(k + 1).sin());
            let push = Ramp::line(9.0 * start, 9.0 * end);
            let (pull, none) = (Ramp::line(-push.start, -push.end), Ramp::held(0.0));
            let inputs = if turned { [none, none, pull] } else { [push, none, none] };
            integrator.advance(&mut motion, 2e-4, &inputs, &Accuracy::default()).unwrap();
        }
        motion
    };
    assert_eq!(run(false).modal_displacement(), run(true).modal_displacement());
}

#[test]
fn what_one_place_does_to_another_the_other_does_to_it() {
    let beam = beam(&[0.1, 0.4], 0.003);
    let mut integrator = loaded(&beam);
    let mut outputs = Outputs::default();
    let mut crossed = |pushed: usize| {
        let mut motion = rest(&mut integrator);
        let mut seen = Vec::new();
        for k in 0..50 {
            let mut inputs = [Ramp::held(0.0); 4];
            inputs[2 + pushed] = Ramp::held(if k < 3 { 7.0 } else { 0.0 });
            integrator.advance(&mut motion, 3e-4, &inputs, &Accuracy::default()).unwrap();
            integrator.outputs(&motion, f64::INFINITY, &inputs, &mut outputs).unwrap();
            seen.push(outputs.sensors[1 - pushed].displacement);
        }
        seen
    };
    let (there, back) = (crossed(0), crossed(1));
    let size = amplitude(there.iter().copied());
    assert!(size > 1e-6);
    assert!(there.iter().zip(&back).all(|(a, b)| (a - b).abs() < 1e-9 * size));
}

#[test]
fn as_many_forces_are_needed_as_contact_points() {
    let mut integrator = loaded(&beam(&[0.3], 0.003));
    let mut motion = rest(&mut integrator);
    let mut advance = |at_points: &[f64]| {
        let forces = [1.0, 0.0].iter().chain(at_points).copied();
        let inputs: Vec<Ramp> = forces.map(Ramp::held).collect();
        integrator.advance(&mut motion, 1e-4, &inputs, &Accuracy::default())
    };
    assert!(advance(&[]).unwrap_err().to_string().contains("2 inputs for 3"));
    assert!(advance(&[f64::NAN]).unwrap_err().to_string().contains("contact_force"));
    advance(&[1.0]).unwrap();
}

/// The beam of `text` under a shaker, with contacts of these models at these places.
fn coupled(text: &str, shaker: Shaker, contacts: &[(f64, &str)]) -> System {
    let mut system = System::new();
    let source = Source::new("shaker", "force", "N", move |time| shaker.force(time));
    system.add(Box::new(source.with_derivative(move |time| shaker.rate(time)))).unwrap();
    system.add(native("beam", text)).unwrap();
    system.connect(("shaker", "force"), ("beam", "excitation"), 1.0, 0.0).unwrap();
    for (place, contact) in contacts {
        let name = format!("contact at {place}");
        system.add(native(&name, contact)).unwrap();
        for quantity in ["displacement", "velocity"] {
            let from = format!("{quantity}:x={place}");
            system.connect(("beam", &from), (&name, quantity), 1.0, 0.0).unwrap();
        }
        let to = format!("contact_force:x={place}");
        system.connect((&name, "force"), ("beam", &to), 1.0, 0.0).unwrap();
        system.observe(&name, "force").unwrap();
    }
    system
}

/// The standard beam's file with contact points at `places`.
fn with_points(places: &[f64]) -> String {
    let points = places.iter().map(|place| format!("\n[[contact_point]]\nposition = {place}\n"));
    points.fold(BEAM.to_owned(), |text, point| text + &point)
}

const SHAKER: Shaker = Shaker { amplitude: 40.0, omega: 400.0, growth: 0.01 };

#[test]
fn contacts_symmetric_about_midspan_carry_the_same_force() {
    // Equal springs at both ends, no mass but in the middle, pushed there.
    let mut model = Model::parse(&with_points(&[0.15, 0.45])).unwrap();
    let Structure::Beam(beam) = &mut model.structure else { panic!("a beam") };
    beam.point_masses.retain(|point| point.position == 0.3);
    beam.sensors = vec![0.3];
    (beam.rotational_stiffness, beam.clamp_stiffness) = (1000.0, Some(1000.0));
    beam.excitation_position = 0.3;
    let damper = damper(10.0);
    let system = coupled(&model.to_toml(), SHAKER, &[(0.15, &damper), (0.45, &damper)]);
    let settings = Settings::new(strong(Method::Anderson { depth: 5 }), 2e-5, 0.04);
    let (rows, report) = record(system, settings).unwrap();
    assert_eq!(report.unconverged, 0);
    let largest = rows.iter().fold(0.0_f64, |most, (_, values)| most.max(values[0].abs()));
    assert!((largest - 6.0).abs() < 1e-9, "both slip: {largest}");
    for (time, values) in &rows {
        assert!((values[0] - values[1]).abs() < 1e-5 * largest, "{time}: {values:?}");
    }
}

/// Two friction dampers on the beam, in one piece and exact between events: no force acts at the pin, so that the
/// beam is linear. Forces of both at multiples of `interval` (s).
fn in_one_piece(places: [f64; 2], loads: [f64; 2], interval: f64, count: usize) -> Vec<[f64; 2]> {
    let beam = beam(&places, 0.003);
    let row = |point: &Sensor| point.shape.iter().copied().enumerate().collect();
    let contacts = beam.contact_points.iter().map(row).collect();
    let structure = LinearStructure { contacts, ..beam.system(None).unwrap().linear_part() };
    let laws = [(); 2].map(|()| Jenkins::new(7.9e6, 0.6).unwrap());
    let loaded = [0, 1].map(|i| LoadedContact { law: &laws[i], normal_load: loads[i] });
    let mut flow = OscillatorFlow::new(&structure, &loaded).unwrap();
    let mut motion = flow.rest();
    // As fine as the shaker's force needs.
    let fine = interval / 100.0;
    let values: Vec<f64> = (0..=100 * count).map(|k| SHAKER.force(k as f64 * fine)).collect();
    let excitation = Excitation::Sampled { interval: fine, values };
    let mut rows = vec![[0.0; 2]];
    for _ in 0..count {
        flow.advance(&mut motion, interval, &excitation).unwrap();
        let forces = flow.contact_forces(&motion);
        rows.push([forces[0], forces[1]]);
    }
    rows
}

#[test]
fn two_coupled_contacts_approach_the_two_in_one_piece_with_the_order_of_the_algorithm() {
    let (places, loads) = ([0.3, 0.45], [15.0, 10.0]);
    let (interval, count) = (2.5e-4, 80);
    let exact = in_one_piece(places, loads, interval, count);
    let size = exact.iter().fold(0.0_f64, |most, row| most.max(row[0].abs()));
    assert!((size - 9.0).abs() < 1e-6, "it slips: {size}");
    let text = with_points(&places);
    let dampers = loads.map(damper);
    let error = |algorithm: &Algorithm, step: f64| {
        let contacts = [(places[0], dampers[0].as_str()), (places[1], dampers[1].as_str())];
        let settings = Settings::new(algorithm.clone(), step, interval * count as f64);
        let settings = Settings { tolerance: Some(1e-9), ..settings };
        let (rows, report) = record(coupled(&text, SHAKER, &contacts), settings).unwrap();
        assert_eq!(report.unconverged, 0);
        let every = (interval / step).round() as usize;
        let squares = rows
            .iter()
            .step_by(every)
            .zip(&exact)
            .map(|((_, values), exact)| (values[0] - exact[0]).powi(2) + (values[1] - exact[1]).powi(2));
        (squares.sum::<f64>() / count as f64).sqrt() / size
    };
    for (algorithm, least) in [
        (strong(Method::Anderson { depth: 5 }), 1.6),
        (strong(Method::Newton), 1.6),
        (Algorithm::Jacobi { extrapolation: 1 }, 1.5),
        (JACOBI, 0.8),
    ] {
        let [coarse, fine] = [1e-5, 2.5e-6].map(|step| error(&algorithm, step));
        let order = (coarse / fine).log(4.0);
        println!("{algorithm:?}: {coarse:e} {fine:e} order {order}");
        assert!(order > least && fine < 0.02, "{algorithm:?}: {coarse:e} {fine:e} order {order}");
    }
}

/// Displacement at the exciter and forces of both contacts of the shipped system BeamWithTwoContacts under the default
/// algorithm, from `start` (s) on.
fn shipped(step: f64, stop: f64, start: f64, force: impl Fn(f64) -> f64 + Send + 'static) -> Vec<Vec<f64>> {
    let mut system = beam_with_two_contacts(Source::new("shaker", "force", "N", force));
    for (slave, variable) in [("beam", "displacement:x=0.55"), ("contact", "force"), ("damper", "force")] {
        system.observe(slave, variable).unwrap();
    }
    let settings = Settings::new(Algorithm::Strong(Strong::default()), step, stop);
    let (rows, report) = record(system, settings).unwrap();
    assert_eq!(report.unconverged, 0);
    rows.into_iter().filter(|(time, _)| *time > start - 0.5 * step).map(|(_, values)| values).collect()
}

/// The communication step that the beam of the shipped system proposes (s).
fn proposed() -> f64 {
    Instance::new(TWO_CONTACTS).unwrap().description().experiment.step
}

#[test]
fn the_proposed_step_gives_the_steady_amplitude_under_a_shaker() {
    let shaker = Shaker { amplitude: 20.0, omega: 1000.0, growth: 0.05 };
    let steady = |step: f64| {
        let rows = shipped(step, 0.15, 0.13, move |time| shaker.force(time));
        [0, 1, 2].map(|column| amplitude(rows.iter().map(|row| row[column])))
    };
    let [found, half] = [proposed(), 0.5 * proposed()].map(steady);
    for (found, half) in found.iter().zip(half) {
        // Of second order: a third of the difference is left.
        assert!((found / half - 1.0).abs() < 1e-3, "{found:e} {half:e}");
    }
}

#[test]
fn the_proposed_step_follows_the_ring_of_the_shipped_start() {
    let step = proposed();
    let (found, fine) = (shipped(step, 0.08, 0.0, |_| 20.0), shipped(0.25 * step, 0.08, 0.0, |_| 20.0));
    for (column, most) in [(0, 1e-3), (1, 1e-3), (2, 1e-2)] {
        let pairs = found.iter().zip(fine.iter().step_by(4));
        let worst = pairs.map(|(a, b)| (a[column] - b[column]).abs()).fold(0.0, f64::max);
        let size = amplitude(fine.iter().map(|row| row[column]));
        println!("{column}: {:e}", worst / size);
        assert!(worst < most * size, "{column}: {:e}", worst / size);
    }
}
