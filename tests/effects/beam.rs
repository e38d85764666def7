//! Effects on the beam's structure, against closed forms.

use std::f64::consts::PI;
use std::sync::Arc;

use stickslip::contact::{CubicSpring, Jenkins, Joint, JointChanges};
use stickslip::harmonic::{CurveSettings, Resonance, phase_resonance};
use stickslip::model::{Beam, Damping, PointMass};
use stickslip::system::{HangingMass, ModalBeam, NaturalModes, Place, StructureChanges};
use stickslip::time::{self, Integrator, Ramp};

use crate::common::time::{held, loaded, rest, supported, supported_by};

use crate::common::beam::{bare, forced_response, one_mode};

fn steel(modes: usize) -> Beam {
    let point_masses = vec![PointMass { position: 0.3, mass: 0.005 }];
    Beam { youngs_modulus: 2e11, modes, point_masses, sensors: vec![], ..bare() }
}

fn changed(beam: &Beam, changes: StructureChanges) -> ModalBeam {
    ModalBeam::with_changes(beam, &changes).expect("a legal beam")
}

fn hung(beam: &Beam, mass: f64, frequency: f64) -> ModalBeam {
    changed(
        beam,
        StructureChanges { hanging_masses: vec![HangingMass { mass, frequency }], ..Default::default() },
    )
}

#[test]
fn an_added_mass_is_a_point_mass_and_leaves_the_sensors_where_they_were() {
    let beam = steel(4);
    let added_masses = vec![(Place::Position(0.55), 0.02)];
    let with_effect = changed(&beam, StructureChanges { added_masses, ..Default::default() });
    let mut built_in = beam.clone();
    built_in.sensors = vec![0.3];
    built_in.point_masses.push(PointMass { position: 0.55, mass: 0.02 });
    assert_eq!(with_effect, ModalBeam::new(&built_in).unwrap());
    assert_eq!(with_effect.sensors.len(), 1);
}

#[test]
fn a_mass_below_zero_takes_away_what_is_there_and_no_more() {
    let beam = steel(4);
    let with =
        |mass| StructureChanges { added_masses: vec![(Place::Position(0.3), mass)], ..Default::default() };
    let mut lighter = beam.clone();
    lighter.point_masses[0].mass = 0.003;
    let taken = changed(&beam, with(-0.002));
    let built = ModalBeam::new(&lighter).unwrap();
    for (a, b) in taken.angular_frequency.iter().zip(&built.angular_frequency) {
        assert!((a / b - 1.0).abs() < 1e-12, "{a} {b}");
    }
    assert!(ModalBeam::with_changes(&beam, &with(-0.006)).is_err());
}

#[test]
fn a_stiff_clamp_is_a_rigid_one_and_two_in_series_are_softer() {
    let beam = steel(5);
    let rigid = ModalBeam::new(&beam).unwrap();
    let sprung =
        |clamp| changed(&beam, StructureChanges { clamp_stiffness: Some(clamp), ..Default::default() });
    for (stiff, limit) in sprung(1e10).angular_frequency.iter().zip(&rigid.angular_frequency) {
        assert!((stiff / limit - 1.0).abs() < 1e-6 && stiff < limit, "{stiff} {limit}");
    }
    let own = Beam { clamp_stiffness: Some(400.0), ..beam.clone() };
    let series = changed(&own, StructureChanges { clamp_stiffness: Some(400.0), ..Default::default() });
    assert_eq!(series, sprung(200.0));
}

/// Of the beam and what hangs at it, without a contact.
fn natural(beam: &ModalBeam) -> NaturalModes {
    beam.system(None).unwrap().linear_part().natural_modes().unwrap()
}

#[test]
fn a_mass_hung_stiffly_is_a_mass_at_the_contact() {
    let mut beam = steel(1);
    beam.point_masses.clear();
    let bare = ModalBeam::new(&beam).unwrap();
    let (omega, lever) = (bare.angular_frequency[0], bare.contact_shape[0]);
    // One mode with m (c q)² added to its mass: ω²/(1 + m c²). So small a mass does not feel the beam's length yield.
    let mass = 0.01 / (lever * lever);
    let modes = natural(&hung(&beam, mass, 1e4));
    let expected = omega / 1.01_f64.sqrt();
    assert!((modes.angular_frequency[0] / expected - 1.0).abs() < 1e-4, "{}", modes.angular_frequency[0]);
    assert!((modes.shapes[(0, 0)].abs() - 1.0 / 1.01_f64.sqrt()).abs() < 1e-4);
}

#[test]
fn a_resonator_splits_a_mode_by_the_quadratic_of_two_masses() {
    let mut beam = steel(1);
    beam.point_masses.clear();
    let bare = ModalBeam::new(&beam).unwrap();
    let (omega, lever) = (bare.angular_frequency[0], bare.contact_shape[0]);
    let mass = 0.1 / (lever * lever);
    // With the beam's length in series the string is to be as stiff as m ω².
    let by_hand = omega / (1.0 - bare.axial_flexibility * mass * omega * omega).sqrt();
    let modes = natural(&hung(&beam, mass, by_hand / (2.0 * PI)));
    // λ² − (2 + μ) λ + 1 = 0 in units of ω², with the mass ratio μ.
    let (sum, ratio) = (2.1_f64, 0.1);
    for (found, sign) in modes.angular_frequency.iter().zip([-1.0, 1.0]) {
        let square = 0.5 * (sum + sign * (sum * sum - 4.0_f64).sqrt());
        assert!((found / omega / square.sqrt() - 1.0).abs() < 1e-12, "{ratio}");
    }
}

/// The modes of a beam and a mass on a string at its end, written down separately: `u` yields to what the spring at the
/// contact and the string pull, and the mass is damped as the first mode is. Rates of `[q, p, q̇, ṗ]`.
fn hanging_by_hand(
    bare: &ModalBeam,
    hanging: &HangingMass,
    spring: f64,
    push: f64,
    state: &[f64],
) -> Vec<f64> {
    let n = bare.angular_frequency.len();
    let (q, p) = (&state[..n], state[n]);
    let string = hanging.mass * (2.0 * PI * hanging.frequency).powi(2);
    let bent: Vec<f64> =
        bare.shortening.chunks_exact(n).map(|row| row.iter().zip(q).map(|(g, q)| g * q).sum()).collect();
    let moved: f64 = (0..n).map(|i| (bare.contact_shape[i] - 0.5 * bent[i]) * q[i]).sum();
    let a = bare.axial_flexibility;
    let u = (moved + a * string * p) / (1.0 + a * (spring + string));
    let force = spring * u + string * (u - p);
    let mut rates = state[n + 1..].to_vec();
    let damping = |i: usize, natural: f64| 2.0 * bare.damping_ratio[0] * natural * state[n + 1 + i];
    rates.extend((0..n).map(|i| {
        push * bare.excitation_shape[i]
            - bare.angular_frequency[i].powi(2) * q[i]
            - damping(i, bare.angular_frequency[i])
            - force * (bare.contact_shape[i] - bent[i])
    }));
    rates.push(string * (u - p) / hanging.mass - damping(n, 2.0 * PI * hanging.frequency));
    rates
}

/// The classical Runge-Kutta method with so many steps; displacement of the first sensor.
fn by_hand(bare: &ModalBeam, hanging: &HangingMass, spring: f64, push: f64, time: f64, steps: usize) -> f64 {
    let n = bare.angular_frequency.len();
    let mut state = vec![0.0; 2 * n + 2];
    let step = time / steps as f64;
    for _ in 0..steps {
        let ahead = |by: f64, rates: &[f64]| -> Vec<f64> {
            state.iter().zip(rates).map(|(x, rate)| x + by * rate).collect()
        };
        let first = hanging_by_hand(bare, hanging, spring, push, &state);
        let second = hanging_by_hand(bare, hanging, spring, push, &ahead(0.5 * step, &first));
        let third = hanging_by_hand(bare, hanging, spring, push, &ahead(0.5 * step, &second));
        let fourth = hanging_by_hand(bare, hanging, spring, push, &ahead(step, &third));
        for (i, x) in state.iter_mut().enumerate() {
            *x += step / 6.0 * (first[i] + 2.0 * second[i] + 2.0 * third[i] + fourth[i]);
        }
    }
    bare.sensors[0].shape.iter().zip(&state).map(|(shape, q)| shape * q).sum()
}

#[test]
fn a_hanging_mass_moves_as_the_beam_and_the_mass_written_down_separately() {
    let beam = Beam { damping: Damping::Uniform(0.05), ..steel(3) };
    let (bare, spring) = (ModalBeam::new(&beam).unwrap(), 4e6);
    let hanging = HangingMass { mass: 5.0, frequency: 60.0 };
    let changes = StructureChanges { hanging_masses: vec![hanging], ..Default::default() };
    let modal = changed(&beam, changes);
    // Hard enough that the beam's end is drawn in by as much as the clamp's turning moves it.
    let (push, time) = (60.0, 0.02);
    let law = CubicSpring::new(spring, 0.0).unwrap();
    let mut integrator = supported(&modal, law, 1.0);
    let mut motion = rest(&mut integrator);
    let inputs = held(push, 1.0);
    let tight = time::Settings { tolerance: 1e-9, ..Default::default() };
    integrator.advance(&mut motion, time, &inputs, &tight).unwrap();
    let found: f64 = modal.sensors[0].shape.iter().zip(motion.modal_displacement()).map(|(s, q)| s * q).sum();
    let expected = by_hand(&bare, &hanging, spring, push, time, 20_000);
    assert!((found / expected - 1.0).abs() < 1e-6, "{found} {expected}");
    let mut unbent = modal.system(Some((Arc::new(law), 1.0))).unwrap().expanded().into_owned();
    unbent.ports.iter_mut().filter(|port| port.flexibility == 0.0).for_each(|port| port.shortening = 0.0);
    let mut without = Integrator::new(&unbent).unwrap();
    let mut motion = rest(&mut without);
    without.advance(&mut motion, time, &inputs, &tight).unwrap();
    let found: f64 = modal.sensors[0].shape.iter().zip(motion.modal_displacement()).map(|(s, q)| s * q).sum();
    assert!(
        (found / expected - 1.0).abs() > 1e-3,
        "the shortening matters to the string: {found} {expected}"
    );
}

#[test]
fn masses_off_the_beam_are_refused() {
    for place in [Place::Mass("m1".into()), Place::Position(0.7), Place::Position(-0.1)] {
        let changes = StructureChanges { added_masses: vec![(place, 0.01)], ..Default::default() };
        assert!(ModalBeam::with_changes(&steel(2), &changes).is_err());
    }
}

/// Phase resonance with the displacement amplitude `a` (m) at the excitation, by iteration on the frequency.
fn resonance(beam: &ModalBeam, amplitude: f64) -> Resonance {
    let settings = CurveSettings { harmonics: 5, tolerance: 1e-11, ..CurveSettings::default() };
    let mut found = None;
    let mut frequency = beam.angular_frequency[0];
    for _ in 0..8 {
        let acceleration = amplitude * frequency * frequency;
        let resonance = phase_resonance(&beam.system(None).unwrap(), acceleration, &settings, found.as_ref())
            .expect("a resonance");
        frequency = resonance.angular_frequency;
        found = Some(resonance);
    }
    found.expect("at least one round")
}

#[test]
fn stretching_raises_the_resonance_by_three_eighths_of_k3_a2_over_k() {
    let cubic_stiffness = 3e10;
    let modal = changed(&steel(1), StructureChanges { cubic_stiffness, ..Default::default() });
    let (omega, phi) = (modal.angular_frequency[0], modal.excitation_shape[0]);
    let stiffness = omega * omega / (phi * phi);
    for amplitude in [2e-4_f64, 4e-4] {
        let fraction = cubic_stiffness * amplitude * amplitude / stiffness;
        let shift = resonance(&modal, amplitude).angular_frequency / omega - 1.0;
        // The next term of the backbone is of second order in the fraction.
        assert!((shift - 0.375 * fraction).abs() < 0.2 * fraction * fraction, "{shift} {fraction}");
        assert!(fraction > 1e-3 && fraction < 0.1, "{fraction}");
    }
}

#[test]
fn drag_gives_a_damping_ratio_in_proportion_to_amplitude() {
    let quadratic_damping = 2.0;
    let modal = changed(&steel(1), StructureChanges { quadratic_damping, ..Default::default() });
    let phi = modal.excitation_shape[0];
    for amplitude in [1e-4, 3e-4, 1e-3] {
        let expected = 4.0 * quadratic_damping * amplitude * phi * phi / (3.0 * PI);
        let added = resonance(&modal, amplitude).damping_ratio() - 0.003;
        assert!((added / expected - 1.0).abs() < 2e-3, "{added} {expected}");
    }
}

#[test]
fn time_integration_settles_to_the_balance_with_stretching_and_drag() {
    let mut beam = one_mode(300.0, 0.05, 0.06, 0.9, 0.0);
    beam.shortening = vec![30.0];
    beam.stretching_stiffness = 3e5;
    beam.quadratic_damping = 0.8;
    settles_to_the_balance(&beam);
}

#[test]
fn time_integration_settles_to_the_balance_with_a_mass_whose_string_the_shortening_stretches() {
    let mut beam = one_mode(300.0, 0.05, 0.06, 0.9, 0.0);
    beam.shortening = vec![30.0];
    beam.stretching_stiffness = 3e5;
    beam.hung = vec![HangingMass { mass: 0.5, frequency: 60.0 }];
    settles_to_the_balance(&beam);
}

#[test]
fn masses_hang_behind_a_flexibility_too() {
    let mut beam = one_mode(300.0, 0.05, 0.06, 0.9, 0.0);
    beam.shortening = vec![30.0];
    beam.axial_flexibility = 1e-6;
    beam.hung = vec![HangingMass { mass: 4.0, frequency: 70.0 }, HangingMass { mass: 1.0, frequency: 120.0 }];
    settles_to_the_balance(&beam);
}

fn settles_to_the_balance(beam: &ModalBeam) {
    let period = 2.0 * PI / 290.0;
    let settings = CurveSettings { harmonics: 9, tolerance: 1e-11, ..CurveSettings::default() };
    let amplitude = 120.0;
    let response = |beam: &ModalBeam| {
        let system = beam.system(None).unwrap();
        let point = forced_response(system, period, &[0.0, amplitude], &settings).unwrap();
        // Of the one mode.
        point.nodes[0].clone()
    };
    let periodic = response(beam);
    let linear =
        ModalBeam { stretching_stiffness: 0.0, quadratic_damping: 0.0, hung: Vec::new(), ..beam.clone() };
    let without = response(&linear);
    assert!((periodic[2] / without[2] - 1.0).abs() > 0.05, "the effects matter");

    let error = apart(&mut loaded(beam), &periodic, amplitude, period);
    assert!(error < 2e-4, "{error:e}");
}

/// How far the one mode is from its `periodic` motion (by coefficients) after 40 periods under a cosine of so much force,
/// as a fraction of its first harmonic, which the lines between the samples of the force lower by (π/256)²/3.
fn apart(integrator: &mut Integrator, periodic: &[f64], amplitude: f64, period: f64) -> f64 {
    let mut motion = rest(integrator);
    let parts = 256;
    let force = |k: usize| amplitude * (2.0 * PI * (k % parts) as f64 / parts as f64).cos();
    let tight = time::Settings { tolerance: 1e-8, ..Default::default() };
    for k in 0..40 * parts {
        let excitation = Ramp::line(force(k), force(k + 1));
        let mut inputs = integrator.held_inputs();
        inputs[0] = excitation;
        integrator.advance(&mut motion, period / parts as f64, &inputs, &tight).unwrap();
    }
    let expected: f64 = periodic[0] + periodic.iter().skip(1).step_by(2).sum::<f64>();
    (motion.modal_displacement()[0] - expected).abs() / periodic[1].hypot(periodic[2])
}

#[test]
fn time_integration_settles_to_the_balance_with_forces_that_follow_the_speed_behind_a_flexibility() {
    let mut beam = one_mode(300.0, 0.05, 0.06, 0.9, 4e-8);
    beam.shortening = vec![30.0];
    let hung = ModalBeam { hung: vec![HangingMass { mass: 2.0, frequency: 70.0 }], ..beam.clone() };
    let weakening = |share: f64| JointChanges { weakening: Some((share, 5e-3)), ..JointChanges::default() };
    let damper = JointChanges { damping: 300.0, ..JointChanges::default() };
    let settings = CurveSettings { harmonics: 31, tolerance: 1e-10, ..CurveSettings::default() };
    let period = 2.0 * PI / 290.0;
    for (beam, changes) in [
        (&beam, weakening(0.6)),
        (&beam, weakening(-0.4)),
        (&hung, weakening(0.6)),
        (&beam, JointChanges { damping: 300.0, ..weakening(0.6) }),
        (&beam, damper),
        (&hung, damper),
    ] {
        let law: Arc<Joint> = Arc::new(Joint::new(Jenkins::new(5e6, 0.6).unwrap(), changes).unwrap());
        for amplitude in [40.0, 120.0] {
            let system = beam.system(Some((law.clone(), 60.0))).unwrap();
            let point = forced_response(system, period, &[0.0, amplitude], &settings).unwrap();
            let mut integrator = supported_by(beam, law.clone(), 60.0);
            let error = apart(&mut integrator, &point.nodes[0], amplitude, period);
            // A damper in front of the flexibility in place of behind it would be 3e-4 away and more.
            let accepted = if changes.damping > 0.0 { 1e-4 } else { 6e-4 };
            assert!(error < accepted, "{changes:?}, {} hung, {amplitude} N: {error:e}", beam.hung.len());
        }
    }
}

/// The end of ten periods under a cosine of so much force, the largest displacement on the way, and steps.
fn ten_periods(integrator: &mut Integrator, push: f64, tolerance: f64) -> (f64, f64, usize) {
    let (mut motion, mut largest, mut steps) = (rest(integrator), 0.0_f64, 0);
    let settings = time::Settings { tolerance, ..Default::default() };
    let force = |k: usize| push * (2.0 * PI * (k % 32) as f64 / 32.0).cos();
    for k in 0..10 * 32 {
        let inputs = [Ramp::line(force(k), force(k + 1)), Ramp::held(60.0)];
        steps += integrator.advance(&mut motion, 2.0 * PI / 290.0 / 32.0, &inputs, &settings).unwrap();
        largest = largest.max(motion.modal_displacement()[0].abs());
    }
    (motion.modal_displacement()[0], largest, steps)
}

#[test]
fn forces_that_follow_the_speed_behind_a_flexibility_are_integrated_in_few_steps() {
    let mut random = fastrand::Rng::with_seed(20);
    for _ in 0..100 {
        let mut log = |low: f64, high: f64| (low.ln() + random.f64() * (high / low).ln()).exp();
        let (flexibility, damping, speed) = (log(1e-9, 1e-7), log(3.0, 1e3), log(1e-3, 0.1));
        let (push, gap) = (log(5.0, 200.0), log(1e-6, 2e-5));
        let weakening = random.bool().then(|| (1.4 * random.f64() - 0.5, speed));
        let damping = if random.bool() { damping } else { 0.0 };
        let damping = if random.u8(..) < 64 { -0.1 * damping } else { damping };
        let changes = JointChanges {
            damping,
            weakening,
            // Where play closes a damper may push it open again (docs/limits.md).
            half_gap: if random.bool() && damping == 0.0 { gap } else { 0.0 },
            spread: if random.bool() { 0.5 } else { 0.0 },
            ..JointChanges::default()
        };
        let law: Arc<Joint> = Arc::new(Joint::new(Jenkins::new(5e6, 0.6).unwrap(), changes).unwrap());
        let mut beam = one_mode(300.0, 0.05, 0.06, 0.9, flexibility);
        beam.shortening = vec![30.0];
        let [loose, tight] = [1e-5, 1e-8]
            .map(|tolerance| ten_periods(&mut supported_by(&beam, law.clone(), 60.0), push, tolerance));
        let (error, steps) = ((loose.0 - tight.0).abs() / tight.1, tight.2);
        // Within a step a limit that follows the velocity is that of its end.
        let accepted = if weakening.is_some() { 3e-3 } else { 3e-4 };
        assert!(error < accepted && steps < 10_000, "{flexibility:e} {changes:?} {push}: {error:e} {steps}");
    }
}
