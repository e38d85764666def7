//! What hangs at a contact, as it is balanced (a dynamic stiffness at the port) against the same system with its masses as
//! coordinates, on random beams.

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use stickslip::contact::{ContactLaw, Jenkins, Valanis};
use stickslip::harmonic::{
    Assembly, Control, CurveSettings, Point, Resonance, frequency_response, periodic_response,
    phase_resonance,
};
use stickslip::system::{Core, Element, HangingMass, ModalBeam, Port, System};

use crate::common::beam::steel_beam;

/// Numbers that look random and are the same in every run (Weyl's sequence, its bits mixed).
struct Random(u64);

impl Random {
    fn between(&mut self, low: f64, high: f64) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mixed = (self.0 ^ (self.0 >> 31)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        low + (high - low) * (mixed >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn below(&mut self, count: usize) -> usize {
        self.between(0.0, count as f64) as usize
    }
}

/// A beam of few modes with one or two masses at its contact, of frequencies from `lowest` times that of its first mode; and
/// a frequency (rad/s) near that.
fn random(random: &mut Random, bends: bool, lowest: f64) -> (ModalBeam, f64) {
    let mut beam = steel_beam(2 + random.below(3), random.between(0.002, 0.02));
    if !bends {
        beam.shortening.fill(0.0);
    }
    // Behind a flexibility the contact moves in harmonics that the masses' coordinates have not.
    beam.axial_flexibility *= if bends { random.between(0.0, 3.0) } else { 0.0 };
    let first = beam.angular_frequency[0] / TAU;
    for _ in 0..1 + random.below(2) {
        let frequency = first * random.between(lowest, 3.0);
        beam.hung.push(HangingMass { mass: random.between(0.3, 8.0), frequency });
    }
    (beam, TAU * first * random.between(0.7, 1.3))
}

fn law(random: &mut Random) -> Arc<dyn ContactLaw> {
    match random.below(2) {
        0 => Arc::new(Jenkins::new(random.between(2e6, 8e6), 0.5).unwrap()),
        _ => Arc::new(Valanis::new(random.between(2e6, 8e6), 0.5, random.between(0.2, 0.8), 1e4).unwrap()),
    }
}

/// As it is balanced, and with coordinates of its own.
fn both(system: System) -> [System; 2] {
    let expanded = system.expanded().into_owned();
    assert!(expanded.core.size() > system.core.size());
    [system, expanded]
}

/// Largest difference of the nodes' coefficients, as a fraction of the largest of each node.
fn apart(one: &Point, other: &Point) -> f64 {
    let size = |values: &[f64]| values.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    let nodes = one.nodes.iter().zip(&other.nodes);
    nodes
        .map(|(one, other)| {
            let difference: Vec<f64> = one.iter().zip(other).map(|(a, b)| a - b).collect();
            size(&difference) / size(one)
        })
        .fold(0.0, f64::max)
}

#[test]
fn responses_are_those_of_the_same_system_with_coordinates_for_the_masses() {
    let mut numbers = Random(17);
    let (mut slips, mut compared) = (0, 0);
    for case in 0..40 {
        // Where nothing shortens or yields both have the same harmonics; else coordinates have fewer than the contact.
        let bends = case % 2 == 1;
        let harmonics = if bends { 19 } else { 9 };
        let settings = CurveSettings { harmonics, tolerance: 1e-9, ..CurveSettings::default() };
        let (beam, angular_frequency) = random(&mut numbers, bends, 0.3);
        let level = Control::Level(numbers.between(2.0, 40.0));
        let systems = both(beam.system(Some((law(&mut numbers), 100.0))).unwrap());
        let [own, expanded] = systems.map(|system| {
            periodic_response(&Assembly::new(system), angular_frequency, &level, &settings, None)
        });
        let own = own.unwrap_or_else(|error| panic!("{case}: {error}"));
        // With more unknowns a search may lead nowhere.
        let Ok(expanded) = expanded else { continue };
        compared += 1;
        let limit = if bends { 1e-6 } else { 1e-8 };
        let apart = apart(&own, &expanded);
        assert!(apart < limit, "{case}: {apart:e}");
        let lost = own.dissipated_energy();
        let difference = (lost - expanded.dissipated_energy()).abs() / own.work;
        assert!(difference < limit, "{case}: {difference:e}");
        slips += usize::from(lost > 0.01 * own.work);
    }
    assert!(slips > 15 && compared > 35, "{slips} {compared}");
}

#[test]
fn resonances_are_those_of_the_same_system_with_coordinates_for_the_masses() {
    let mut numbers = Random(11);
    let settings = CurveSettings { harmonics: 5, tolerance: 1e-11, ..CurveSettings::default() };
    let mut compared = 0;
    for case in 0..10 {
        // The lowest mode of all is that of the beam.
        let (beam, _) = random(&mut numbers, case % 2 == 1, 1.2);
        let systems = both(beam.system(Some((law(&mut numbers), 100.0))).unwrap());
        let limit = if case % 2 == 1 { 1e-4 } else { 1e-7 };
        let near = |a: f64, b: f64| (a / b - 1.0).abs() < limit;
        let acceleration = 20.0;
        let found = phase_resonance(&systems[0], acceleration, &settings, None).unwrap();
        // From starts that lead nowhere as well.
        for scale in [30.0, 1e4, 1e8, 1e200] {
            let mut bad = found.clone();
            bad.coefficients.iter_mut().enumerate().for_each(|(i, q)| *q *= scale * (1.0 + (i as f64).sin()));
            bad.angular_frequency *= 0.8;
            let again = phase_resonance(&systems[0], acceleration, &settings, Some(&bad)).unwrap();
            assert!(near(again.force_amplitude, found.force_amplitude), "{case} {scale}");
        }
        let Resonance {
            angular_frequency, force_amplitude: force, dissipated_energy, viscous_energy, ..
        } = found;
        let work = PI * force * acceleration / angular_frequency.powi(2);
        let lost = dissipated_energy + viscous_energy;
        assert!(near(lost, work), "{case}: {lost:e} {work:e}");
        // A resonance of the other too: the displacement is a quarter period behind the force.
        let level = Control::Level(force);
        let expanded = Assembly::new(systems[1].clone());
        // With more unknowns a search may lead nowhere.
        let Ok(response) = periodic_response(&expanded, angular_frequency, &level, &settings, None) else {
            continue;
        };
        compared += 1;
        let [_, cosine, sine, ..] = response.nodes[response.nodes.len() - 1][..] else { panic!("{case}") };
        assert!(
            near(sine * angular_frequency.powi(2), acceleration) && cosine.abs() < limit * sine,
            "{case}"
        );
    }
    assert!(compared > 7, "{compared}");
}

#[test]
fn stability_is_that_of_the_same_system_with_coordinates_for_the_masses() {
    let mut numbers = Random(5);
    let settings = CurveSettings { harmonics: 15, stability: true, ..CurveSettings::default() };
    let mut decided = 0;
    for case in 0..6 {
        let (beam, angular_frequency) = random(&mut numbers, case % 2 == 1, 0.3);
        let level = Control::Level(numbers.between(2.0, 20.0));
        let systems = both(beam.system(Some((law(&mut numbers), 100.0))).unwrap());
        let last = systems.map(|system| {
            let (assembly, to) = (Assembly::new(system), 1.01 * angular_frequency);
            let curve =
                frequency_response(&assembly, angular_frequency, to, &level, &settings, &mut |_| true);
            curve.unwrap_or_else(|error| panic!("{case}: {error}")).points.pop().unwrap()
        });
        let [own, expanded] = &last;
        assert_eq!((own.stable, own.undecided), (expanded.stable, expanded.undecided), "{case}");
        decided += usize::from(own.stable.is_some());
    }
    assert!(decided > 3, "{decided}");
}

#[test]
fn a_resonance_without_a_contact_is_damped_as_the_linear_mode() {
    let settings = CurveSettings { harmonics: 3, tolerance: 1e-11, ..CurveSettings::default() };
    for (mass, frequency) in [(5.0, 60.0), (60.0, 55.0), (1.0, 120.0)] {
        let mut beam = steel_beam(3, 0.003);
        beam.hung = vec![HangingMass { mass, frequency }];
        let system = beam.system(None).unwrap();
        let linear = system.linear_part();
        let modes = linear.natural_modes().unwrap();
        let shape = modes.shapes.column(0);
        let rate: f64 = linear.damping.iter().map(|(i, j, c)| shape[*i] * c * shape[*j]).sum();
        let expected = 0.5 * rate / modes.angular_frequency[0];
        let found = phase_resonance(&system, 1e-3, &settings, None).unwrap();
        assert!((found.damping_ratio() / expected - 1.0).abs() < 0.02, "{mass}: {expected} {found:?}");
    }
}

#[test]
fn resonators_at_linear_ports_and_on_matrices_are_balanced() {
    let law: Arc<dyn ContactLaw> = Arc::new(Jenkins::new(30.0, 0.4).unwrap());
    let modal = Core::Modal { angular_frequency: vec![5.0, 11.0], damping_ratio: vec![0.02; 2] };
    let matrices = Core::Matrices {
        size: 2,
        mass: vec![(0, 0, 2.0), (1, 1, 1.0)],
        damping: vec![(0, 0, 0.2), (1, 1, 0.1)],
        stiffness: vec![(0, 0, 60.0), (0, 1, -20.0), (1, 0, -20.0), (1, 1, 40.0)],
    };
    let settings = CurveSettings { tolerance: 1e-10, ..CurveSettings::default() };
    for core in [modal, matrices] {
        for flexibility in [0.0, 1e-3] {
            if flexibility > 0.0 && matches!(core, Core::Matrices { .. }) {
                continue; // needs modal coordinates, with resonators or without
            }
            let contact = Port { flexibility, ..Port::linear("contact", vec![(0, 0.8), (1, -0.3)]) };
            let system = System {
                core: core.clone(),
                shortening: vec![],
                ports: vec![Port::linear("sensor", vec![(0, 1.0)]), contact],
                elements: vec![
                    Element::Law { port: 1, law: law.clone(), normal_load: 2.0 },
                    Element::Resonator { port: 1, mass: 0.3, angular_frequency: 6.0, damping_ratio: 0.02 },
                ],
                driven: vec![0],
                sensors: vec![0],
            };
            let [own, expanded] = both(system).map(|system| {
                let level = Control::Level(3.0);
                periodic_response(&Assembly::new(system), 5.5, &level, &settings, None).unwrap()
            });
            let apart = apart(&own, &expanded);
            assert!(apart < 1e-3, "{core:?} {flexibility}: {apart:e}");
        }
    }
}

/// Where harmonics that are left out meet the frequency of a light mass.
#[test]
fn estimated_errors_are_those_that_more_harmonics_show() {
    let law: Arc<dyn ContactLaw> = Arc::new(Jenkins::new(4e6, 0.5).unwrap());
    for frequency in [600.0, 800.0, 1000.0] {
        let mut beam = steel_beam(6, 0.003);
        beam.hung = vec![HangingMass { mass: 1.0, frequency }];
        let system = beam.system(Some((law.clone(), 100.0))).unwrap();
        let first = |harmonics| {
            let settings = CurveSettings { harmonics, ..CurveSettings::default() };
            let (assembly, level) = (Assembly::new(system.clone()), Control::Level(15.0));
            let mut curve =
                frequency_response(&assembly, 310.0, 310.1, &level, &settings, &mut |_| true).unwrap();
            curve.points.swap_remove(0)
        };
        let (few, many) = (first(9), first(40));
        let amplitudes = few.amplitude.iter().zip(&many.amplitude);
        let error = amplitudes.map(|(few, many)| (few / many - 1.0).abs()).fold(0.0, f64::max);
        let estimate = few.error_estimate;
        assert!((error..10.0 * error).contains(&estimate), "{frequency}: {error:e} {estimate:e}");
    }
}
