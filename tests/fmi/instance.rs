//! Models as slaves: the table, the stages, saved states, failed steps.

use std::collections::BTreeSet;
use stickslip::contact::{LAWS, Law};
use stickslip::fmi::{Causality, Error, Instance, Setup, Snapshot, Stage, VariableType};
use stickslip::model::{Contact, Model, Structure};

const MODELS: [(&str, &str); 8] = [
    ("JenkinsContact", include_str!("../../modelDescription/JenkinsContact.toml")),
    ("ValanisContact", include_str!("../../modelDescription/ValanisContact.toml")),
    ("ModalBeam", include_str!("../../modelDescription/ModalBeam.toml")),
    ("ModalBeamTwoContacts", include_str!("../../modelDescription/ModalBeamTwoContacts.toml")),
    ("FrictionalBeam", include_str!("../../modelDescription/FrictionalBeam.toml")),
    ("SlipSlapContact", include_str!("../../modelDescription/SlipSlapContact.toml")),
    ("PinnedBeam", include_str!("../../modelDescription/PinnedBeam.toml")),
    ("SlipSlapBeam", include_str!("../../modelDescription/SlipSlapBeam.toml")),
];

fn new(name: &str) -> Instance {
    let (_, text) = MODELS.iter().find(|(other, _)| *other == name).unwrap();
    Instance::new(text).unwrap()
}

fn initialize(instance: &mut Instance) {
    instance.enter_initialization().unwrap();
    instance.exit_initialization().unwrap();
}

fn running(name: &str) -> Instance {
    let mut instance = new(name);
    initialize(&mut instance);
    instance
}

fn set(instance: &mut Instance, name: &str, value: f64) -> Result<(), Error> {
    let reference = instance.description().reference(name).unwrap_or_else(|| panic!("no {name}"));
    instance.set_real(&[reference], &[value])
}

fn get(instance: &mut Instance, name: &str) -> f64 {
    let reference = instance.description().reference(name).unwrap_or_else(|| panic!("no {name}"));
    let mut value = [f64::NAN];
    instance.get_real(&[reference], &mut value).unwrap();
    value[0]
}

/// Bits of all Real outputs over twenty steps from step `first`.
fn outputs(instance: &mut Instance, first: u32) -> Vec<u64> {
    let rows = instance.description().references(Causality::Output);
    let is_real =
        |row: &u32| instance.description().variables[*row as usize].variable_type == VariableType::Real;
    let references: Vec<u32> = rows.filter(is_real).collect();
    let mut values = vec![0.0; references.len()];
    let mut all = Vec::new();
    for index in first..first + 20 {
        let time = f64::from(index) * 1e-3;
        for (name, size) in [("displacement", 5e-5), ("excitation", 20.0), ("contact_force", 30.0)] {
            let causality = instance
                .description()
                .reference(name)
                .map(|row| instance.description().variables[row as usize].causality);
            if causality == Some(Causality::Input) {
                set(instance, name, size * (300.0 * time).sin()).unwrap();
            }
        }
        instance.do_step(time, 1e-3).unwrap();
        instance.get_real(&references, &mut values).unwrap();
        all.extend(values.iter().map(|value| value.to_bits()));
    }
    all
}

#[test]
fn names_are_unique_and_starts_are_legal() {
    for (name, _) in MODELS {
        let instance = new(name);
        let variables = &instance.description().variables;
        let names: BTreeSet<&str> = variables.iter().map(|variable| &*variable.name).collect();
        assert_eq!(names.len(), variables.len(), "{name}");
        for variable in variables {
            assert!(variable.start().is_none_or(|start| variable.allows(start)), "{name} {}", variable.name);
        }
    }
}

#[test]
fn every_parameter_of_the_model_file_is_a_parameter_of_the_slave() {
    for (name, text) in MODELS {
        let model = Model::parse(text).unwrap();
        let expected = model.parameters().into_iter().filter(|parameter| {
            // An input, but of a contact in two directions.
            (parameter.path != "contact.normal_load" || name.starts_with("SlipSlap"))
                && !parameter.path.ends_with("position")
        });
        let instance = new(name);
        let found = instance.description().references(Causality::Parameter);
        let values: Vec<f64> =
            found.map(|row| instance.description().variables[row as usize].start).collect();
        assert_eq!(values, expected.map(|parameter| parameter.value).collect::<Vec<_>>(), "{name}");
    }
}

#[test]
fn masses_at_one_place_have_names_of_their_own() {
    let text = format!("{}\n[[beam.point_mass]]\nposition = 0.55\nmass = 0.02\n", MODELS[2].1);
    let instance = Instance::new(&text).unwrap();
    assert!(instance.description().reference("mass:x=0.55").is_some());
    assert!(instance.description().reference("mass:x=0.55:2").is_some());
    let sensors = instance.description().variables.iter();
    assert_eq!(sensors.filter(|variable| variable.name == "acceleration:x=0.55").count(), 1);
}

#[test]
fn the_guid_is_the_same_for_the_same_model_only() {
    for (name, text) in MODELS {
        assert_eq!(new(name).guid(), new(name).guid());
        let spaced = text.replace(" = ", "   =   ");
        assert_eq!(Instance::new(&spaced).unwrap().guid(), new(name).guid(), "{name}: layout is no content");
    }
    let six = Instance::new(MODELS[2].1).unwrap().guid();
    let seven = Instance::new(&MODELS[2].1.replace("modes = 6", "modes = 7")).unwrap().guid();
    assert_ne!(six, seven, "what no variable shows counts too");
    let all: BTreeSet<_> = MODELS.iter().map(|(name, _)| new(name).guid()).collect();
    assert_eq!(all.len(), MODELS.len());
}

#[test]
fn restored_slaves_continue_bit_by_bit() {
    for (name, _) in MODELS {
        let mut instance = running(name);
        outputs(&mut instance, 0);
        let snapshot = Snapshot::from_bytes(&instance.snapshot().to_bytes()).unwrap();
        let expected = outputs(&mut instance, 20);
        instance.restore(&snapshot).unwrap();
        assert_eq!(outputs(&mut instance, 20), expected, "{name}");
        let mut other = new(name);
        other.restore(&snapshot).unwrap();
        assert_eq!(outputs(&mut other, 20), expected, "{name}");
        other.reset();
        initialize(&mut other);
        let mut fresh = running(name);
        assert_eq!(outputs(&mut other, 0), outputs(&mut fresh, 0), "{name}");
    }
}

/// The slave of a contact of every law of the catalogue.
#[test]
fn restored_contacts_of_every_law_continue_bit_by_bit() {
    for kind in LAWS {
        let own: Vec<f64> =
            kind.parameters.iter().map(|one| (one.range)(2e6)).map(|(a, b, _)| 0.5 * (a + b)).collect();
        let contact = Contact {
            law: Law::new(kind, &own).unwrap(),
            tangential_stiffness: 2e6,
            friction_coefficient: 0.5,
            normal_load: 100.0,
            normal_stiffness: 0.0,
            normal: None,
        };
        let model = Model {
            structure: Structure::Prescribed,
            contact: Some(contact),
            effects: Vec::new(),
            free: None,
        };
        let mut slave = Instance::from_model(&Model::parse(&model.to_toml()).unwrap()).unwrap();
        initialize(&mut slave);
        let forces = |slave: &mut Instance, from: u32| -> Vec<u64> {
            let one = |k: u32| {
                let time = 1e-3 * f64::from(k);
                set(slave, "displacement", 40e-6 * (200.0 * time).sin()).unwrap();
                slave.do_step(time, 1e-3).unwrap();
                get(slave, "force").to_bits()
            };
            (from..from + 60).map(one).collect()
        };
        forces(&mut slave, 0);
        let saved = slave.snapshot();
        let first = forces(&mut slave, 60);
        slave.restore(&Snapshot::from_bytes(&saved.to_bytes()).unwrap()).unwrap();
        assert_eq!(forces(&mut slave, 60), first, "{kind:?}");
    }
}

#[test]
fn a_restored_slave_has_the_saved_parameters_too() {
    for (name, parameter, value) in
        [("ValanisContact", "smoothness", 0.6), ("FrictionalBeam", "youngs_modulus", 2.1e11)]
    {
        let mut instance = new(name);
        set(&mut instance, parameter, value).unwrap();
        initialize(&mut instance);
        outputs(&mut instance, 0);
        let snapshot = instance.snapshot();
        let expected = outputs(&mut instance, 20);
        let mut other = running(name);
        outputs(&mut other, 0);
        other.restore(&snapshot).unwrap();
        assert_eq!(outputs(&mut other, 20), expected, "{name}");
    }
}

#[test]
fn a_step_that_fails_leaves_the_state_before_it() {
    let mut beam = running("ModalBeam");
    outputs(&mut beam, 0);
    let good = beam.snapshot();
    set(&mut beam, "contact_force", 1e30).unwrap();
    // Behind the header, which tells the stage, and before the checksum.
    let numbers = |beam: &Instance| {
        let bytes = beam.snapshot().to_bytes();
        bytes[24..bytes.len() - 8].to_vec()
    };
    let before = numbers(&beam);
    let error = beam.do_step(0.02, 1e-3).unwrap_err();
    assert!(matches!(error, Error::Step { .. }), "{error}");
    assert_eq!(beam.stage(), Stage::StepFailed);
    assert_eq!(numbers(&beam), before);
    assert!(matches!(beam.do_step(0.02, 1e-3), Err(Error::Stage(Stage::StepFailed))));
    beam.restore(&good).unwrap();
    let mut expected = running("ModalBeam");
    outputs(&mut expected, 0);
    assert_eq!(outputs(&mut beam, 20), outputs(&mut expected, 20));
}

#[test]
fn parameters_that_make_no_model_are_named() {
    let mut valanis = new("ValanisContact");
    set(&mut valanis, "residual_stiffness", 8e6).unwrap();
    valanis.enter_initialization().unwrap();
    let error = valanis.exit_initialization().unwrap_err().to_string();
    assert!(error.starts_with("residual_stiffness"), "{error}");
    assert_eq!(valanis.stage(), Stage::Initialization);

    let mut beam = new("ModalBeam");
    set(&mut beam, "length", 0.2).unwrap();
    beam.enter_initialization().unwrap();
    let error = beam.exit_initialization().unwrap_err().to_string();
    assert!(error.contains("not on the beam"), "{error}");
    set(&mut beam, "length", 0.6).unwrap();
    beam.exit_initialization().unwrap();
}

#[test]
fn a_static_force_bends_the_beam_by_its_modal_flexibility() {
    // Long after a step of the force the displacement is T Σ cᵢ²/ωᵢ² plus the axial spring's, against T.
    let text = MODELS[2].1.replace("damping_ratio = 0.003", "damping_ratio = 0.7");
    let Ok(model) = Model::parse(&text) else { panic!("a model") };
    let stickslip::model::Structure::Beam(beam) = &model.structure else { panic!("a beam") };
    let modal = stickslip::system::ModalBeam::new(beam).unwrap();
    let mut instance = Instance::from_model(&model).unwrap();
    initialize(&mut instance);
    let force = 1e-3;
    set(&mut instance, "contact_force", force).unwrap();
    for step in 0..20 {
        instance.do_step(f64::from(step) * 0.02, 0.02).unwrap();
    }
    let modes = modal.contact_shape.iter().zip(&modal.angular_frequency);
    let flexibility: f64 = modes.map(|(shape, omega)| (shape / omega).powi(2)).sum();
    let expected = -force * (flexibility + modal.axial_flexibility);
    let found = get(&mut instance, "displacement");
    assert!((found / expected - 1.0).abs() < 1e-5, "{found} {expected}");
}

#[test]
fn a_smaller_tolerance_gives_a_smaller_error() {
    let run = |tolerance: f64| {
        let mut beam = new("FrictionalBeam");
        beam.set_up(Setup { tolerance: Some(tolerance), ..Setup::default() }).unwrap();
        initialize(&mut beam);
        for index in 0..50 {
            let time = f64::from(index) * 1e-3;
            set(&mut beam, "excitation", 40.0 * (330.0 * time).sin()).unwrap();
            beam.do_step(time, 1e-3).unwrap();
        }
        get(&mut beam, "displacement:x=0.55")
    };
    let exact = run(1e-11);
    let (coarse, fine) = ((run(1e-3) - exact).abs(), (run(1e-7) - exact).abs());
    assert!(fine < coarse && fine < 1e-5 * exact.abs(), "{coarse:e} {fine:e} {exact:e}");
}

#[test]
fn the_contact_of_a_beam_only_dissipates() {
    let mut beam = running("FrictionalBeam");
    let mut last = 0.0;
    for index in 0..100 {
        let time = f64::from(index) * 1e-3;
        set(&mut beam, "excitation", 40.0 * (330.0 * time).sin()).unwrap();
        beam.do_step(time, 1e-3).unwrap();
        let energy = get(&mut beam, "dissipated_energy");
        assert!(energy >= last);
        last = energy;
    }
    assert!(last > 0.0);
}

#[test]
fn a_model_without_sense_is_refused_with_its_line() {
    let text = MODELS[0].1.replace("friction_coefficient", "friction_coeficient");
    let error = Instance::new(&text).unwrap_err().to_string();
    assert!(error.contains("line 7") && error.contains("friction_coeficient"), "{error}");
    let mut model = Model::parse(MODELS[0].1).unwrap();
    model.contact = None;
    assert!(Instance::from_model(&model).is_err());
}

#[test]
fn numbers_in_messages_are_as_short_as_their_exponents_allow() {
    let mut contact = new("JenkinsContact");
    let refused = set(&mut contact, "displacement", 1e31).unwrap_err().to_string();
    assert_eq!(refused, "displacement = 1e31 is refused; it must be at most 1e30 in magnitude");
    initialize(&mut contact);
    contact.do_step(0.0, 1e-300).unwrap();
    let refused = contact.do_step(1.0, 1e-3).unwrap_err().to_string();
    assert!(refused.ends_with("it must be the end of the last step, 1e-300"), "{refused}");
}

#[test]
fn the_slip_fraction_is_the_share_of_the_sliders_that_slip() {
    let contact = |law: &str| {
        format!(
            "schema = \"stickslip.model/1\"\nkind = \"contact\"\n[contact]\n{law}tangential_stiffness = 2e6\n\
             friction_coefficient = 0.5\nnormal_load = 100.0\n"
        )
    };
    let fractions = |law: &str, displacements: &[f64], load: f64| -> Vec<[f64; 2]> {
        let mut instance = Instance::new(&contact(law)).unwrap();
        let row = |name: &str| instance.description().reference(name).unwrap();
        let (inputs, [state, fraction]) =
            ([row("displacement"), row("normal_load")], ["slip_state", "slip_fraction"].map(row));
        instance.enter_initialization().unwrap();
        instance.exit_initialization().unwrap();
        let step = |(k, displacement): (usize, &f64)| {
            instance.set_real(&inputs, &[*displacement, load]).unwrap();
            instance.do_step(k as f64, 1.0).unwrap();
            let (mut whole, mut part) = ([0], [0.0]);
            instance.get_integer(&[state], &mut whole).unwrap();
            instance.get_real(&[fraction], &mut part).unwrap();
            [f64::from(whole[0]), part[0]]
        };
        displacements.iter().enumerate().map(step).collect()
    };
    // One slider sticks or slips; back from slip it sticks again; apart, none sticks.
    let jenkins = "law = \"jenkins\"\n";
    let found = fractions(jenkins, &[1e-5, 4e-5, 3.9e-5, -5e-5], 100.0);
    assert_eq!(found, [[0.0, 0.0], [1.0, 1.0], [0.0, 0.0], [1.0, 1.0]]);
    assert_eq!(fractions(jenkins, &[4e-5], 0.0), [[2.0, 1.0]]);
    // Many of them slip one after the other, and a residual spring never does.
    for law in [
        "law = \"iwan\"\nexponent = -0.5\nratio = 0.5\n",
        "law = \"valanis\"\nsmoothness = 0.3\nresidual_stiffness = 1e5\n",
    ] {
        let found = fractions(law, &[1e-7, 1e-5, 2e-5, 1e-2], 100.0);
        let parts: Vec<f64> = found.iter().map(|found| found[1]).collect();
        assert!(parts.windows(2).all(|pair| pair[0] < pair[1]), "{parts:?}");
        assert!(parts[0] < 0.1 && parts[3] > 0.99, "{parts:?}");
    }
}

#[test]
fn the_bounds_that_are_declared_are_allowed_and_nothing_beyond_them_is() {
    let mut open = 0;
    for (_, model) in MODELS {
        let instance = Instance::new(model).unwrap();
        for variable in &instance.description().variables {
            let (min, max) = variable.allowed_range();
            open += usize::from(min != variable.quantity.min) + usize::from(max != variable.quantity.max);
            // Zero is excluded by the least number of full precision.
            let below = |min: f64| if min == f64::MIN_POSITIVE { 0.0 } else { min.next_down() };
            for (bound, beyond) in [(min, min.map(below)), (max, max.map(f64::next_up))] {
                assert!(bound.is_none_or(|bound| variable.allows(bound)), "{}", variable.name);
                assert!(beyond.is_none_or(|beyond| !variable.allows(beyond)), "{}", variable.name);
            }
        }
    }
    assert!(open > 20, "{open}");
}

#[test]
fn a_step_that_would_take_seconds_is_refused_at_once() {
    use crate::common::fmi::{FRICTIONAL, MODAL, OSCILLATOR};
    for model in [MODAL, FRICTIONAL, OSCILLATOR] {
        let mut instance = Instance::new(model).unwrap();
        instance.enter_initialization().unwrap();
        instance.exit_initialization().unwrap();
        let saved = instance.snapshot();
        for step in [1e6, 1e300] {
            let begin = std::time::Instant::now();
            let message = instance.do_step(0.0, step).expect_err("too long").to_string();
            // Taken, it lasts many seconds.
            assert!(begin.elapsed().as_secs_f64() < 1.0, "{:?}", begin.elapsed());
            assert!(message.contains("too long"), "{message}");
            instance.restore(&saved).unwrap();
        }
        instance.do_step(0.0, 0.1).unwrap();
    }
    // A contact that is never out of its corner takes as many attempts as it may, and no more.
    let mut instance = Instance::new(FRICTIONAL).unwrap();
    for input in ["normal_load", "excitation"] {
        let reference = instance.description().reference(input).unwrap();
        instance.set_real(&[reference], &[1e12]).unwrap();
    }
    instance.enter_initialization().unwrap();
    instance.exit_initialization().unwrap();
    let begin = std::time::Instant::now();
    instance.do_step(0.0, 0.1).expect_err("too many attempts");
    assert!(begin.elapsed().as_secs_f64() < 3.0, "{:?}", begin.elapsed());
}
