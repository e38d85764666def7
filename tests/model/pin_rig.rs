//! Pin rigs in model files: read, written, refused at the line; the system that the builder makes; the example.

use std::sync::Arc;

use stickslip::contact::{Jenkins, NormalDirection, NormalLaw, SlipSlapInputs, SlipSlapWork};
use stickslip::model::{Model, PinnedBeam, Structure};
use stickslip::system::{Element, HangingString, ModalPinRig, Pin, PinRig, Port};

const RIG: &str = r#"schema = "stickslip.model/1"
kind = "pin_rig"

[beam]
length = 0.6
width = 0.04
thickness = 0.005
density = 7850.0
youngs_modulus = 215e9
modes = 6
damping_ratio = 0.003
point_mass = [{ position = 0.55, mass = 0.025 }, { position = 0.3, mass = 0.005 }]

[pin]
mass = 0.0355
inertia = 6.4e-7
tangential_lever = 0.006
normal_lever = 0.0085

[string]
stiffness = 1e5
length = 0.3
mass = 7.0
inertia = 0.005

[excitation]
position = 0.55

[contact]
law = "jenkins"
tangential_stiffness = 3.95e6
friction_coefficient = 0.6
normal_load = 60.0
normal_stiffness = 2.37e7
normal_law = "hertz"
impact_damping = 30.0
"#;

const EXAMPLE: &str = include_str!("../../examples/slip-slap/model.toml");

fn read(text: &str) -> Model {
    Model::parse(text).unwrap_or_else(|error| panic!("{error}"))
}

fn pinned(model: &Model) -> &PinnedBeam {
    let Structure::PinRig(pinned) = &model.structure else { panic!("no pin rig") };
    pinned
}

#[track_caller]
fn refused(from: &str, to: &str, line: usize, at: &str, words: &[&str]) {
    assert!(RIG.contains(from), "{from}");
    let text = RIG.replacen(from, to, 1);
    let error = Model::parse(&text).expect_err(&text);
    let span = error.span.clone().unwrap_or(0..0);
    let found = (1 + text[..span.start].matches('\n').count(), &text[span]);
    assert_eq!(found, (line, at), "{error}");
    for word in words {
        assert!(error.to_string().contains(word), "`{word}` is missing from: {error}");
    }
}

#[test]
fn the_rig_is_read_as_it_stands() {
    let model = read(RIG);
    let found = pinned(&model);
    assert_eq!(found.pin, Pin { mass: 0.0355, inertia: 6.4e-7, normal_lever: 0.0085 });
    assert_eq!(found.string, HangingString { stiffness: 1e5, length: 0.3, mass: 7.0, inertia: 0.005 });
    assert_eq!((found.beam.offset, &found.beam.sensors[..]), (0.006, &[0.55, 0.3][..]));
    assert_eq!(model.contact.unwrap().normal_load, 60.0);
    // The weight of the hanging mass, unless the file says what presses.
    let weighed = read(&RIG.replace("normal_load = 60.0\n", ""));
    assert!((weighed.contact.unwrap().normal_load - 68.67).abs() < 1e-9);
}

#[test]
fn every_rig_reads_back_as_written() {
    let spring = RIG.replace("normal_law = \"hertz\"\nimpact_damping = 30.0\n", "");
    let clamped = format!("{RIG}\n[support]\nclamp_stiffness = 1e5\n");
    let listed = format!("{RIG}\n[[sensor]]\nposition = 0.1\n");
    let unseen = RIG.replace("kind = \"pin_rig\"\n", "kind = \"pin_rig\"\nsensor = []\n");
    let varying = format!("{spring}\n[[effect]]\nid = \"normal_load_variation\"\nload_gain = 0.7\n");
    for text in [RIG, EXAMPLE, &spring, &clamped, &listed, &unseen, &varying] {
        let model = read(text);
        assert_eq!(Model::parse(&model.to_toml()).unwrap(), model, "{}", model.to_toml());
    }
}

#[test]
fn its_numbers_are_parameters_by_path() {
    let mut model = read(RIG);
    for parameter in model.parameters() {
        let (low, value, high) = (parameter.lower, parameter.value, parameter.upper);
        assert!(low <= value && value <= high && low < high, "{}: {low} {value} {high}", parameter.path);
        model.set(&parameter.path, value).unwrap();
        assert!(model.clone().set(&parameter.path, high).is_ok(), "{} = {high}", parameter.path);
    }
    for (path, value) in [
        ("pin.mass", 0.05),
        ("pin.inertia", 1e-6),
        ("pin.tangential_lever", 0.0085),
        ("pin.normal_lever", 0.004),
        ("string.stiffness", 1e6),
        ("string.length", 0.4),
        ("string.mass", 5.0),
        ("string.inertia", 0.0),
        ("beam.youngs_modulus", 2e11),
        ("contact.normal_stiffness", 2e7),
        ("contact.normal_exponent", 1.2),
        ("support.clamp_stiffness", 1e5),
    ] {
        model.set(path, value).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(model.get(path), Some(value), "{path}");
    }
    assert_eq!(pinned(&model).beam.offset, 0.0085);
    let error = model.set("string.mass", -1.0).unwrap_err();
    assert_eq!(error.path, "string.mass");
    assert!(model.set("support.offset", 0.006).is_err());
}

#[test]
fn its_system_is_that_of_the_builder() {
    let model = read(RIG);
    let PinnedBeam { beam, pin, string, .. } = pinned(&model).clone();
    let rig = PinRig { beam, pin, string, stuck_stiffness: [3.95e6, 2.37e7] };
    let normal = NormalDirection::new(NormalLaw::Hertz { exponent: 1.5 }, 60.0, 2.37e7, 30.0).unwrap();
    let law = Arc::new(Jenkins::new(3.95e6, 0.6).unwrap());
    let contact = stickslip::contact::SlipSlap::new(law, normal);
    let built = ModalPinRig::new(&rig).unwrap().system(Some(Arc::new(contact)));
    let system = model.system().unwrap();
    assert_eq!(system.core, built.core);
    let named = |ports: &[Port]| ports.iter().map(|port| format!("{port:?}")).collect::<Vec<_>>();
    assert_eq!(named(&system.ports), named(&built.ports));
    assert_eq!(system.shortening, built.shortening);
    let Element::SlipSlap { contact, .. } = &system.elements[0] else { panic!("two directions") };
    assert_eq!(*contact.normal(), normal);
}

/// S (N) where the pin slides and has opened by 1 µm, N_c (N) there, and the coefficient of friction times the load.
fn opened(model: &Model) -> [f64; 2] {
    let contact = model.slip_slap().unwrap().expect("two directions");
    let (mut state, mut next) = (vec![0.0; contact.state_len()], vec![0.0; contact.state_len()]);
    contact.set_state([0.0; 2], 0.0, &mut state);
    let inputs = SlipSlapInputs { displacement: [100e-6, 1e-6], velocity: [0.0; 2] };
    let response = contact.step(&state, inputs, &mut next, &mut SlipSlapWork::default());
    [response.force[0], response.normal_force]
}

#[test]
fn without_a_normal_law_the_friction_is_under_a_constant_load() {
    let spring = RIG.replace("normal_law = \"hertz\"\nimpact_damping = 30.0\n", "");
    let [force, normal] = opened(&read(&spring));
    assert!((normal - (60.0 - 23.7)).abs() < 1e-9 && (force - 0.6 * 60.0).abs() < 1e-9);
    let varying = |gain: f64| {
        read(&format!("{spring}\n[[effect]]\nid = \"normal_load_variation\"\nload_gain = {gain}\n"))
    };
    let [force, normal] = opened(&varying(0.5));
    assert!((force - 0.6 * (60.0 - 0.5 * 23.7)).abs() < 1e-9 && (normal - 36.3).abs() < 1e-9);
    // All of it is what a linear law does.
    let linear = read(&format!("{spring}normal_law = \"linear\"\n"));
    assert_eq!(opened(&varying(1.0)), opened(&linear));
}

#[test]
fn what_is_wrong_is_pointed_at() {
    let contact = &RIG[RIG.find("[contact]").unwrap()..];
    refused(contact, "", 1, "", &["needs [contact]"]);
    refused("normal_lever", "normal_leverage", 18, "normal_leverage", &["did you mean `normal_lever`"]);
    refused("normal_stiffness = 2.37e7\n", "", 29, "[contact]", &["normal_stiffness", "N/m"]);
    refused("modes = 6", "static_correction = true\nmodes = 6", 10, "static_correction", &[]);
    refused("[string]\n", "[support]\noffset = 0.006\n[string]\n", 21, "offset", &["clamp_stiffness"]);
    refused("[pin]", "[support]", 15, "mass", &["clamp_stiffness"]);
    refused("mass = 7.0", "mass = 0", 23, "0", &["above 0"]);
    refused("\"hertz\"", "\"herz\"", 35, "\"herz\"", &["hertz"]);
    let foreign = RIG.replace("pin_rig", "beam");
    assert!(Model::parse(&foreign).unwrap_err().to_string().contains("kind = \"pin_rig\""));
    let twice = format!("{RIG}\n[[effect]]\nid = \"normal_load_variation\"\nload_gain = 1.0\n");
    assert!(Model::parse(&twice).unwrap_err().to_string().contains("normal_law"));
    let alien = format!("{RIG}\n[[effect]]\nid = \"geometric_stiffening\"\ncubic_stiffness = 1e9\n");
    assert!(Model::parse(&alien).unwrap_err().to_string().contains("pin_rig"));
}

#[test]
fn effects_change_the_rig_and_its_contact() {
    let hardened = RIG.replace("\"hertz\"", "\"linear\"");
    let text = format!(
        "{hardened}\n[[effect]]\nid = \"normal_hardening\"\nnormal_cubic_stiffness = 1e18\n\
         [[effect]]\nid = \"impact_damping\"\nimpact_damping = 5.0\n\
         [[effect]]\nid = \"added_mass\"\nat = \"x=0.3\"\nmass = 0.01\n"
    );
    let model = read(&text);
    let normal = model.normal_direction().unwrap().unwrap();
    assert_eq!(normal.law(), NormalLaw::Cubic { cubic_stiffness: 1e18 });
    assert_eq!(normal.impact_damping(), 35.0);
    let built_in = read(&RIG.replace("mass = 0.005 }", "mass = 0.015 }"));
    assert_eq!(model.system().unwrap().core, built_in.system().unwrap().core);
}

/// A rig whose contact is another program's: its springs stand in [pin], and its forces come from outside.
#[test]
fn a_rig_without_a_contact_takes_both_forces_from_outside() {
    let text = include_str!("../../modelDescription/PinnedBeam.toml");
    let model = read(text);
    assert_eq!(Model::parse(&model.to_toml()).unwrap(), model);
    assert_eq!(model.get("pin.normal_stiffness"), Some(2.37e7));
    let system = model.system().unwrap();
    let given: Vec<&str> = system
        .elements
        .iter()
        .filter_map(|element| match element {
            Element::Outside { port } => Some(system.ports[*port].name.as_str()),
            _ => None,
        })
        .collect();
    assert_eq!(given, ["contact", "contact.normal"]);
    let missing = Model::parse(&text.replace("normal_stiffness = 2.37e7", "")).unwrap_err();
    assert!(missing.to_string().contains("normal_stiffness"), "{missing}");
    refused(
        "normal_lever = 0.0085",
        "normal_lever = 0.0085\ntangential_stiffness = 1e6\nnormal_stiffness = 1e7",
        19,
        "1e6",
        &["contact"],
    );
}
