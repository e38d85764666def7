//! `[[effect]]` in model files: what is read, what is refused and where, parameters, round trip.

use stickslip::effects::{AppliedEffect, CATALOGUE, Kind, Location, PlaceKind, Scales};
use stickslip::model::{Law, Model};

const CONTACT: &str = r#"
schema = "stickslip.model/1"
kind = "contact"

[contact]
law = "jenkins"
tangential_stiffness = 5.1e6
friction_coefficient = 0.47
normal_load = 162.0
"#;

const OSCILLATOR: &str = r#"
schema = "stickslip.model/1"
kind = "oscillator"
mass = [{ name = "m1", mass = 1.0 }, { name = "m2", mass = 2.0 }]
spring = [{ between = ["ground", "m1"], stiffness = 9.0, damping = 0.1 }, { between = ["m1", "m2"], stiffness = 4.0 }]

[contact]
at = "m2"
law = "jenkins"
tangential_stiffness = 5.1e6
friction_coefficient = 0.47
normal_load = 162.0
"#;

const BEAM: &str = r#"
schema = "stickslip.model/1"
kind = "beam"
beam = { length = 0.6, width = 0.04, thickness = 0.003, density = 7850.0, youngs_modulus = 2.1e11, modes = 4, damping_ratio = 0.003 }
support = { offset = 0.006 }
excitation = { position = 0.3 }

[contact]
law = "jenkins"
tangential_stiffness = 5.1e6
friction_coefficient = 0.47
normal_load = 162.0
"#;

fn with(base: &str, effect: &str) -> String {
    format!("{base}\n[[effect]]\n{effect}\n")
}

/// The text at the place of the error, and message with help.
fn refused(text: &str) -> (String, String) {
    let error = Model::parse(text).unwrap_err();
    let place = error.span.map_or(String::new(), |span| text[span].to_owned());
    (place, format!("{} ({})", error.message, error.help.unwrap_or_default()))
}

#[track_caller]
fn check_refused(base: &str, effect: &str, place: &str, words: &[&str]) {
    let (found, message) = refused(&with(base, effect));
    assert_eq!(found, place, "{message}");
    for word in words {
        assert!(message.contains(word), "{message} lacks {word}");
    }
}

#[test]
fn every_effect_reads_back_as_written_in_every_kind_it_belongs_to() {
    for (base, kind) in [(CONTACT, Kind::Contact), (OSCILLATOR, Kind::Oscillator), (BEAM, Kind::Beam)] {
        let mut model = Model::parse(base).unwrap();
        for effect in CATALOGUE.iter().copied().filter(|effect| effect.kinds.contains(&kind)) {
            let location = match effect.place {
                PlaceKind::Nowhere => None,
                PlaceKind::Structure if kind == Kind::Beam => Some(Location::Position(0.1 + 0.2)),
                PlaceKind::Structure => Some(Location::Mass("m2".to_owned())),
                PlaceKind::Channel => Some(Location::parse_channel("force").unwrap()),
            };
            let value = |start: f64| start / 3.0 * 1.000_000_000_000_1;
            let values = effect.parameters.iter().map(|p| value((p.range)(&Scales::default()).starts[0]));
            model.effects.push(AppliedEffect { effect, location, values: values.collect() });
        }
        model.check().unwrap();
        assert_eq!(Model::parse(&model.to_toml()).unwrap(), model, "{}", model.to_toml());
        for parameter in model.parameters().iter().filter(|parameter| parameter.path.starts_with("effect.")) {
            assert!(parameter.free, "{}", parameter.path);
            assert!(
                parameter.lower < parameter.value && parameter.value < parameter.upper,
                "{}",
                parameter.path
            );
            for value in [parameter.lower, parameter.upper] {
                model.clone().set(&parameter.path, value).unwrap();
            }
        }
    }
}

#[test]
fn parameters_are_counted_in_the_files_order() {
    let text = with(&with(CONTACT, "id = \"wear\"\nrate = 2.5"), "id = \"backlash\"\nhalf_gap = 1e-5");
    let mut model = Model::parse(&text).unwrap();
    assert_eq!(model.get("effect.2.half_gap"), Some(1e-5));
    model.set("effect.1.rate", -0.5).unwrap();
    assert_eq!((model.changes().joint.wear, model.changes().joint.half_gap), (-0.5, 1e-5));
    let error = model.set("effect.2.half_gap", -1.0).unwrap_err();
    assert_eq!(error.path, "effect.2.half_gap");
    let fixed = Model::parse(&format!("{text}\n[fit]\nfree = [\"effect.1.*\"]\n")).unwrap();
    let free: Vec<String> = fixed.parameters().into_iter().filter(|p| p.free).map(|p| p.path).collect();
    assert_eq!(free, ["effect.1.rate"]);
}

#[test]
fn what_is_wrong_is_reported_at_its_place() {
    let unknown = "id = \"backlahs\"\nhalf_gap = 1e-5";
    check_refused(CONTACT, unknown, "\"backlahs\"", &["unknown effect", "did you mean `backlash`"]);
    check_refused(CONTACT, "half_gap = 1e-5", "[[effect]]", &["`id` is missing"]);
    check_refused(CONTACT, "id = \"backlash\"", "[[effect]]", &["`half_gap`", "[m]"]);
    check_refused(CONTACT, "id = \"backlash\"\nhalf_gap = -1.0", "-1.0", &["at least 0"]);
    check_refused(
        CONTACT,
        "id = \"backlash\"\nhalf_gap = 1.0\ngap = 2",
        "gap",
        &["unknown key `gap`", "half_gap"],
    );
    check_refused(CONTACT, "id = \"backlash\"\nhalf_gap = 1.0\nat = \"m1\"", "at", &["unknown key `at`"]);
    check_refused(CONTACT, "id = \"asymmetry\"\nasymmetry = 1.0", "1.0", &["above -1 and below 1"]);
    let drag = "id = \"quadratic_damping\"\nquadratic_damping = 1.0";
    check_refused(
        CONTACT,
        drag,
        "\"quadratic_damping\"",
        &["kind \"contact\"", "\"oscillator\" or \"beam\""],
    );
    check_refused(OSCILLATOR, "id = \"added_mass\"\nmass = 0.1", "[[effect]]", &["`at` is missing", "m1"]);
    check_refused(OSCILLATOR, "id = \"added_mass\"\nmass = 0.1\nat = \"m3\"", "\"m3\"", &["no mass \"m3\""]);
    check_refused(OSCILLATOR, "id = \"added_mass\"\nmass = 0.1\nat = \"x=0.2\"", "\"x=0.2\"", &["no mass"]);
    check_refused(BEAM, "id = \"added_mass\"\nmass = 0.1\nat = \"x=0.7\"", "\"x=0.7\"", &["not on the beam"]);
    check_refused(BEAM, "id = \"added_mass\"\nmass = 0.1\nat = \"m1\"", "\"m1\"", &["no position"]);
    check_refused(BEAM, "id = \"sensor_gain\"\ngain = 1.1", "[[effect]]", &["`channel` is missing"]);
    check_refused(BEAM, "id = \"sensor_gain\"\ngain = 1.1\nchannel = \"mood\"", "\"mood\"", &["not a place"]);
    let twice = "id = \"wear\"\nrate = 1.0\n\n[[effect]]\nid = \"wear\"\nrate = 2.0";
    check_refused(CONTACT, twice, "\"wear\"", &["listed twice"]);
}

#[test]
fn gradual_laws_take_no_micro_slip() {
    let iwan = CONTACT.replace("\"jenkins\"", "\"iwan\"\nexponent = -0.4\nratio = 2.0");
    check_refused(&iwan, "id = \"micro_slip\"\nspread = 0.5", "\"micro_slip\"", &["law = \"iwan\""]);
}

#[test]
fn effects_in_the_contact_need_one() {
    let bare = BEAM.split("[contact]").next().unwrap();
    check_refused(bare, "id = \"backlash\"\nhalf_gap = 0.0", "\"backlash\"", &["no [contact]"]);
    Model::parse(&with(bare, "id = \"added_mass\"\nmass = 0.1\nat = \"x=0.2\"")).unwrap();
}

#[test]
fn iwans_law_and_the_normal_stiffness_read_back() {
    let text = CONTACT
        .replace("\"jenkins\"", "\"iwan\"\nexponent = -0.4\nratio = 2.0")
        .replace("normal_load = 162.0", "normal_load = 162.0\nnormal_stiffness = 2e7");
    let model = Model::parse(&text).unwrap();
    let contact = model.contact.unwrap();
    assert_eq!(contact.law, Law::named("iwan", &[-0.4, 2.0]).unwrap());
    assert_eq!(contact.normal_stiffness, 2e7);
    assert_eq!(Model::parse(&model.to_toml()).unwrap(), model);
    assert_eq!(model.get("contact.exponent"), Some(-0.4));
    let limit = model.law().unwrap().unwrap().limit(162.0);
    assert!((limit / (0.47 * 162.0) - 1.0).abs() < 1e-12);
    let (place, message) = refused(&text.replace("-0.4", "0.4"));
    assert_eq!(place, "0.4", "{message}");
    let (place, message) = refused(&CONTACT.replace("\"jenkins\"", "\"jenkins\"\nratio = 2.0"));
    assert_eq!((place.as_str(), message.contains("\"iwan\"")), ("ratio", true), "{message}");
}
