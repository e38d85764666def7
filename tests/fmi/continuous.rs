//! The continuous-time form, integrated here, against the steps of a slave.

use stickslip::fmi::{Instance, Setup, Stage, Template};

use crate::common::fmi::{Case, FRICTIONAL, JENKINS, MODAL, OSCILLATOR, PIN_RIG, SLIP_SLAP, VALANIS, Waves};

/// An importer that integrates by the classical scheme in equal steps, without a look at indicators.
struct Importer {
    instance: Instance,
    inputs: Vec<u32>,
    states: usize,
}

fn waves_at(waves: Waves, time: f64) -> Vec<f64> {
    waves
        .iter()
        .map(|(_, [amplitude, omega, phase, mean])| mean + amplitude * (omega * time + phase).sin())
        .collect()
}

fn references(instance: &Instance, waves: Waves) -> Vec<u32> {
    waves.iter().map(|(name, _)| instance.description().reference(name).expect(name)).collect()
}

fn initialize(instance: &mut Instance, inputs: &[u32], values: &[f64]) {
    instance.set_up(Setup { tolerance: Some(1e-10), ..Setup::default() }).unwrap();
    instance.enter_initialization().unwrap();
    instance.set_real(inputs, values).unwrap();
    instance.exit_initialization().unwrap();
}

impl Importer {
    fn new(case: &Case) -> Self {
        let mut instance = Template::parse(&case.model).unwrap().continuous_instance().unwrap();
        let inputs = references(&instance, case.waves);
        initialize(&mut instance, &inputs, &waves_at(case.waves, 0.0));
        assert_eq!(instance.stage(), Stage::Event);
        instance.new_discrete_states().unwrap();
        instance.enter_continuous_time().unwrap();
        let states = instance.description().states().len();
        Self { instance, inputs, states }
    }

    /// Derivatives at an instant.
    fn rates(&mut self, waves: Waves, time: f64, states: &[f64]) -> Vec<f64> {
        self.instance.set_time(time).unwrap();
        self.instance.set_real(&self.inputs, &waves_at(waves, time)).unwrap();
        self.instance.set_continuous_states(states).unwrap();
        let mut rates = vec![0.0; self.states];
        self.instance.state_derivatives(&mut rates).unwrap();
        rates
    }

    fn step(&mut self, waves: Waves, time: f64, step: f64) {
        let mut start = vec![0.0; self.states];
        self.instance.continuous_states(&mut start).unwrap();
        let (mut end, mut slope) = (start.clone(), vec![0.0; self.states]);
        for (weight, fraction) in [(1.0, 0.0), (2.0, 0.5), (2.0, 0.5), (1.0, 1.0)] {
            let at: Vec<f64> = start.iter().zip(&slope).map(|(x, rate)| x + fraction * step * rate).collect();
            slope = self.rates(waves, time + fraction * step, &at);
            end.iter_mut().zip(&slope).for_each(|(x, rate)| *x += weight / 6.0 * step * rate);
        }
        self.rates(waves, time + step, &end);
        if self.instance.completed_step().unwrap() {
            self.instance.enter_event().unwrap();
            self.instance.new_discrete_states().unwrap();
            self.instance.enter_continuous_time().unwrap();
        }
    }
}

fn outputs(instance: &mut Instance, names: &[&str]) -> Vec<f64> {
    let rows: Vec<u32> =
        names.iter().map(|name| instance.description().reference(name).expect(name)).collect();
    let mut values = vec![0.0; rows.len()];
    instance.get_real(&rows, &mut values).unwrap();
    values
}

/// The largest distance of each signal between the form, in `fine` steps for one of the slave's, and the slave, over the
/// signal's largest value. The slave is told the inputs' course by derivatives.
fn distance(case: &Case, names: &[&str], fine: usize) -> Vec<f64> {
    let mut importer = Importer::new(case);
    let mut slave = Instance::new(&case.model).unwrap();
    let inputs = references(&slave, case.waves);
    initialize(&mut slave, &inputs, &waves_at(case.waves, 0.0));
    let (mut far, mut most) = (vec![0.0_f64; names.len()], vec![0.0_f64; names.len()]);
    for k in 0..case.steps {
        let (time, step) = (k as f64 * case.step, case.step);
        for part in 0..fine {
            let step = step / fine as f64;
            importer.step(case.waves, time + part as f64 * step, step);
        }
        slave.set_real(&inputs, &waves_at(case.waves, time)).unwrap();
        let mut orders = Vec::new();
        for order in 1..=3 {
            let wave = |[amplitude, omega, phase, _]: [f64; 4]| {
                amplitude
                    * omega.powi(order)
                    * (omega * time + phase + f64::from(order) * std::f64::consts::FRAC_PI_2).sin()
            };
            orders.push(case.waves.iter().map(|(_, numbers)| wave(*numbers)).collect::<Vec<_>>());
        }
        for (order, values) in orders.iter().enumerate() {
            slave.set_input_derivatives(&inputs, &vec![order as i32 + 1; inputs.len()], values).unwrap();
        }
        slave.do_step(time, step).unwrap();
        let (here, there) = (outputs(&mut importer.instance, names), outputs(&mut slave, names));
        for (index, (here, there)) in here.iter().zip(&there).enumerate() {
            far[index] = far[index].max((here - there).abs());
            most[index] = most[index].max(there.abs());
        }
    }
    far.iter().zip(&most).map(|(far, most)| far / most).collect()
}

fn case<'a>(name: &'a str, model: &str, (step, steps): (f64, usize), waves: Waves<'a>) -> Case<'a> {
    Case { name, model: model.to_owned(), step, steps, tolerance: 1e-10, span: 1e-5, waves }
}

/// Displacement through slip both ways, with its velocity, under a load that varies.
const OF_A_CONTACT: Waves = &[
    ("displacement", [8e-5, 300.0, 0.0, 0.0]),
    ("velocity", [8e-5 * 300.0, 300.0, std::f64::consts::FRAC_PI_2, 0.0]),
    ("normal_load", [60.0, 170.0, 0.3, 140.0]),
];
/// Far enough apart, and together again.
const OF_SLIP_AND_SLAP: Waves = &[
    ("displacement", [4e-5, 300.0, 0.0, 0.0]),
    ("velocity", [4e-5 * 300.0, 300.0, std::f64::consts::FRAC_PI_2, 0.0]),
    ("opening", [1.2e-5, 170.0, 0.0, 0.0]),
    ("opening_velocity", [1.2e-5 * 170.0, 170.0, std::f64::consts::FRAC_PI_2, 0.0]),
];
const OF_A_PIN_RIG: Waves = &[("excitation", [300.0, 800.0, 0.0, 0.0])];
const OF_A_PINNED_BEAM: Waves =
    &[("excitation", [20.0, 800.0, 0.0, 0.0]), ("contact_force", [5.0, 500.0, 0.0, 0.0])];
const HELD_LOAD: Waves = &[
    ("displacement", [8e-5, 300.0, 0.0, 0.0]),
    ("velocity", [8e-5 * 300.0, 300.0, std::f64::consts::FRAC_PI_2, 0.0]),
    ("normal_load", [0.0, 0.0, 0.0, 140.0]),
];
const OF_A_BEAM: Waves =
    &[("excitation", [20.0, 330.0, 0.0, 0.0]), ("contact_force", [20.0, 200.0, 0.0, 0.0])];
const OF_A_FRICTIONAL_BEAM: Waves =
    &[("excitation", [120.0, 330.0, 0.0, 0.0]), ("normal_load", [0.0, 0.0, 0.0, 60.0])];
const OF_AN_OSCILLATOR: Waves =
    &[("excitation:m1", [0.9, 0.54, 0.0, 0.0]), ("normal_load", [0.0, 0.0, 0.0, 1.0])];

#[test]
fn a_contact_carries_the_same_force_and_takes_the_same_energy() {
    for model in [JENKINS, VALANIS] {
        let errors = |step: f64, fine, waves| {
            let case = case("contact", model, (step, (0.03 / step) as usize), waves);
            distance(&case, &["force", "dissipated_energy"], fine)
        };
        // A reversal lies between accepted instants: the steps from one to the next decide.
        let (coarse, fine) = (errors(1e-4, 2, HELD_LOAD), errors(1e-4, 8, HELD_LOAD));
        assert!(fine.iter().all(|error| *error < 2e-5), "{fine:?}");
        assert!(fine.iter().zip(&coarse).all(|(fine, coarse)| *fine < 0.2 * coarse), "{coarse:?} {fine:?}");
        // A load that varies bends the path within the slave's steps too.
        let fine = errors(2.5e-5, 8, OF_A_CONTACT);
        assert!(fine.iter().all(|error| *error < 5e-5), "{fine:?}");
    }
}

#[test]
fn a_contact_in_two_directions_slips_parts_and_meets_again_as_the_slave() {
    let case = case("SlipSlapContact", SLIP_SLAP, (2.5e-5, 1200), OF_SLIP_AND_SLAP);
    let names = ["force", "normal_force", "separation", "dissipated_energy", "impact_energy"];
    let error = distance(&case, &names, 8);
    assert!(error.iter().all(|error| *error < 5e-5), "{error:?}");
}

#[test]
fn a_beam_whose_pin_slips_and_slaps_moves_as_the_slave() {
    let case = case("SlipSlapBeam", PIN_RIG, (1e-4, 60), OF_A_PIN_RIG);
    let names = ["force", "normal_force", "separation", "dissipated_energy", "displacement:x=0.55"];
    let error = distance(&case, &names, 400);
    assert!(error.iter().all(|error| *error < 2e-5), "{error:?}");
}

#[test]
fn a_beam_whose_pin_is_moved_by_other_models_moves_as_the_slave() {
    let model = include_str!("../../modelDescription/PinnedBeam.toml");
    let case = case("PinnedBeam", model, (1e-4, 60), OF_A_PINNED_BEAM);
    let names = ["displacement", "opening", "displacement:x=0.55", "acceleration:x=0.55"];
    let error = distance(&case, &names, 400);
    assert!(error.iter().all(|error| *error < 2e-5), "{error:?}");
}

#[test]
fn a_beam_under_forces_from_outside_moves_as_the_slave() {
    let case = case("ModalBeam", MODAL, (1e-4, 100), OF_A_BEAM);
    let error = distance(
        &case,
        &["displacement", "displacement:x=0.55", "velocity:x=0.55", "acceleration:x=0.55"],
        20,
    );
    assert!(error.iter().all(|error| *error < 1e-6), "{error:?}");
}

#[test]
fn a_frictional_beam_slips_and_sticks_as_the_slave() {
    let case = case("FrictionalBeam", FRICTIONAL, (1e-4, 200), OF_A_FRICTIONAL_BEAM);
    let names = ["force", "dissipated_energy", "displacement", "velocity:x=0.55"];
    let error = distance(&case, &names, 40);
    assert!(error.iter().all(|error| *error < 1e-3), "{error:?}");
}

#[test]
fn an_oscillator_slips_and_sticks_as_the_slave() {
    let case = case("Oscillator", OSCILLATOR, (0.1, 400), OF_AN_OSCILLATOR);
    let names = ["force", "dissipated_energy", "displacement:m1", "velocity:m2"];
    let error = distance(&case, &names, 10);
    assert!(error.iter().all(|error| *error < 2e-3), "{error:?}");
}

#[test]
fn a_look_leaves_no_trace() {
    let case = case("contact", JENKINS, (1e-3, 1), OF_A_CONTACT);
    let mut importer = Importer::new(&case);
    let before = importer.instance.snapshot();
    let force = |importer: &mut Importer, displacement: f64| {
        importer.instance.set_real(&importer.inputs, &[displacement, 0.0, 140.0]).unwrap();
        outputs(&mut importer.instance, &["force"])[0]
    };
    let first = force(&mut importer, 2e-5);
    force(&mut importer, 9e-5);
    assert_eq!(force(&mut importer, 2e-5), first);
    importer.instance.restore(&before).unwrap();
    assert_eq!(importer.instance.snapshot(), before);
    // Accepted, it is remembered: the slider has moved, and coming back takes less force.
    force(&mut importer, 9e-5);
    importer.instance.completed_step().unwrap();
    assert!(force(&mut importer, 2e-5) < first - 1.0);
}

#[test]
fn indicators_change_their_sign_at_slip_reversal_and_lift_off() {
    let case = case("contact", JENKINS, (1e-3, 1), OF_A_CONTACT);
    let mut importer = Importer::new(&case);
    let mut signs = |inputs: [f64; 3]| {
        importer.instance.set_real(&importer.inputs, &inputs).unwrap();
        let mut indicators = [0.0; 3];
        importer.instance.event_indicators(&mut indicators).unwrap();
        importer.instance.completed_step().unwrap();
        indicators.map(f64::signum)
    };
    assert_eq!(signs([1e-6, 0.1, 100.0]), [1.0, 1.0, 1.0]);
    assert_eq!(signs([9e-5, 0.1, 100.0]), [1.0, -1.0, 1.0]);
    // It has not moved: nothing has happened.
    assert_eq!(signs([9e-5, 0.1, 100.0]), [1.0, -1.0, 1.0]);
    assert_eq!(signs([8.9e-5, -0.1, 100.0]), [-1.0, 1.0, 1.0]);
    assert_eq!(signs([8.9e-5, -0.1, -1.0])[2], -1.0);
}

#[test]
fn after_the_end_the_last_outputs_are_still_there_and_a_saved_instance_goes_on_from_where_it_was() {
    let case = case("FrictionalBeam", FRICTIONAL, (1e-4, 20), OF_A_FRICTIONAL_BEAM);
    let mut importer = Importer::new(&case);
    let names = ["force", "displacement", "modal_velocity:mode=2", "modal_acceleration:mode=2"];
    for k in 0..20 {
        importer.step(case.waves, f64::from(k) * 1e-5, 1e-5);
    }
    let saved = importer.instance.snapshot();
    importer.step(case.waves, 2e-4, 1e-5);
    let next = outputs(&mut importer.instance, &names);
    importer.instance.restore(&saved).unwrap();
    importer.step(case.waves, 2e-4, 1e-5);
    assert_eq!(outputs(&mut importer.instance, &names), next);
    importer.instance.set_continuous_states(&vec![1e-6; importer.states]).unwrap();
    importer.instance.terminate().unwrap();
    let last = outputs(&mut importer.instance, &names);
    assert_eq!(last[2], 1e-6);
    assert_eq!(outputs(&mut importer.instance, &names), last);
}

#[test]
fn an_instance_is_for_one_interface_and_says_so() {
    let mut slave = Instance::new(JENKINS).unwrap();
    initialize(&mut slave, &[], &[]);
    assert!(slave.event_indicators(&mut [0.0; 3]).unwrap_err().to_string().contains("model exchange"));
    let mut continuous = Template::parse(JENKINS).unwrap().continuous_instance().unwrap();
    initialize(&mut continuous, &[], &[]);
    assert!(continuous.do_step(0.0, 1e-3).is_err());
    assert!(continuous.restore(&slave.snapshot()).is_err());
    assert!(slave.restore(&continuous.snapshot()).is_err());
}
