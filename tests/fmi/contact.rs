//! The slave of a contact against the law itself.

use fastrand::Rng;
use stickslip::contact::{ContactLaw, Inputs, Joint, JointChanges, LAWS, Law, LawKind, SlipState};
use stickslip::fmi::{Instance, Setup};
use stickslip::model::{Contact, Model, Structure};

const LOAD: f64 = 100.0;

/// A contact of `law`, and with the effect in `effect`, if it is not empty.
fn model(law: Law, effect: &str) -> Model {
    let contact = Contact {
        law,
        tangential_stiffness: 2e6,
        friction_coefficient: 0.5,
        normal_load: LOAD,
        normal_stiffness: 0.0,
        normal: None,
    };
    let plain =
        Model { structure: Structure::Prescribed, contact: Some(contact), effects: Vec::new(), free: None };
    Model::parse(&format!("{}\n{effect}", plain.to_toml())).unwrap()
}

/// Every law of the catalogue with numbers by chance.
fn laws(rng: &mut Rng) -> Vec<Law> {
    let between = |rng: &mut Rng, lower: f64, upper: f64| lower + rng.f64() * (upper - lower);
    let own = |kind: &'static LawKind, rng: &mut Rng| {
        let ranges = kind.parameters.iter().map(|one| (one.range)(2e6));
        let own: Vec<f64> = ranges.map(|(lower, upper, _)| between(rng, lower, upper)).collect();
        Law::new(kind, &own).unwrap()
    };
    LAWS.into_iter().map(|kind| own(kind, rng)).collect()
}

/// What a slave shows after a step, as bits: force, dissipated energy, slip state.
fn shown(slave: &mut Instance) -> [u64; 3] {
    let [force, energy, state] =
        ["force", "dissipated_energy", "slip_state"].map(|name| slave.description().reference(name).unwrap());
    let (mut reals, mut states) = ([0.0; 2], [0]);
    slave.get_real(&[force, energy], &mut reals).unwrap();
    slave.get_integer(&[state], &mut states).unwrap();
    [reals[0].to_bits(), reals[1].to_bits(), states[0] as u64]
}

/// The next inputs: a third of them held, some without a load, some at a limit's corner.
fn next(rng: &mut Rng, now: Inputs) -> Inputs {
    let size = 10_f64.powi(rng.i32(-8..-3));
    let displacement = if rng.u8(0..3) == 0 { now.displacement } else { size * (2.0 * rng.f64() - 1.0) };
    let normal_load = match rng.u8(0..6) {
        0 => 200.0 * rng.f64(),
        1 => -100.0 * rng.f64(),
        2 => 0.0,
        3 => LOAD,
        _ => now.normal_load,
    };
    Inputs { displacement, velocity: rng.f64() - 0.5, normal_load }
}

/// One fraction of the load's change reaches the contact.
const LOAD_GAIN: f64 = 0.7;

#[test]
fn slaves_of_every_law_step_as_the_law_itself_bit_by_bit() {
    let mut rng = Rng::with_seed(20);
    let varied = format!("[[effect]]\nid = \"normal_load_variation\"\nload_gain = {LOAD_GAIN:?}\n");
    for effect in ["", &varied] {
        for law in (0..20).flat_map(|_| laws(&mut Rng::with_seed(rng.u64(..)))).collect::<Vec<_>>() {
            if law.refuses(2e6, 0.5).is_none() {
                let base = law.base(2e6, 0.5).unwrap();
                if effect.is_empty() {
                    compare(&model(law, effect), &*base.into_law(), 1.0, &mut rng);
                } else {
                    let joint = Joint::new(base, JointChanges::default()).unwrap();
                    compare(&model(law, effect), &joint, LOAD_GAIN, &mut rng);
                }
            }
        }
    }
}

/// 400 steps of a slave of `model` and of its `law`, to whose contact `gain` of the load's change comes.
fn compare(model: &Model, law: &dyn ContactLaw, gain: f64, rng: &mut Rng) {
    let mut slave = Instance::from_model(model).unwrap();
    let rows =
        ["displacement", "velocity", "normal_load"].map(|name| slave.description().reference(name).unwrap());
    slave.set_up(Setup::default()).unwrap();
    slave.enter_initialization().unwrap();
    slave.exit_initialization().unwrap();
    let acting = |load: f64| if gain == 1.0 { load } else { LOAD + gain * (load - LOAD) };

    let (mut memory, mut after) = (vec![0.0; law.state_len()], vec![0.0; law.state_len()]);
    law.set_state(0.0, LOAD, 0.0, &mut memory);
    let mut inputs = Inputs { displacement: 0.0, velocity: 0.0, normal_load: LOAD };
    let mut energy = 0.0;
    let mut states = [0; 3];
    energy += law.step(&memory, inputs, &mut after).dissipated_energy;
    memory.copy_from_slice(&after);
    for index in 0..400 {
        inputs = next(rng, inputs);
        slave.set_real(&rows, &[inputs.displacement, inputs.velocity, inputs.normal_load]).unwrap();
        slave.do_step(f64::from(index) * 1e-3, 1e-3).unwrap();
        let acting = Inputs { normal_load: acting(inputs.normal_load), ..inputs };
        let response = law.step(&memory, acting, &mut after);
        memory.copy_from_slice(&after);
        energy += response.dissipated_energy;
        let expected = [response.force.to_bits(), energy.to_bits(), response.slip_state as u64];
        assert_eq!(shown(&mut slave), expected, "step {index} of {:?}: {acting:?}", model.contact);
        states[response.slip_state as usize] += 1;
    }
    // All three were there, where the law has all three.
    let least = if law.has_stick() { 1 } else { 0 };
    assert!(states[SlipState::Stick as usize] >= least && states[1] > 0 && states[2] > 0, "{states:?}");
}
