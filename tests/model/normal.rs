//! The normal direction of a contact in a model file.

use stickslip::contact::NormalLaw;
use stickslip::model::Model;

const CONTACT: &str = r#"schema = "stickslip.model/1"
kind = "contact"

[contact]
law = "jenkins"
tangential_stiffness = 3.95e6
friction_coefficient = 0.6
normal_load = 68.67
normal_stiffness = 2.37e7
"#;

fn with(lines: &str) -> String {
    format!("{CONTACT}{lines}")
}

#[track_caller]
fn refused(lines: &str, at: &str, words: &str) {
    let text = with(lines);
    let error = Model::parse(&text).expect_err(lines);
    assert_eq!(&text[error.span.clone().unwrap_or(0..0)], at, "{error}");
    assert!(error.to_string().contains(words), "{error}");
}

#[test]
fn every_normal_law_reads_back_as_written() {
    let laws = [
        "normal_law = \"linear\"",
        "normal_law = \"cubic\"\nnormal_cubic_stiffness = 1e18",
        "normal_law = \"hertz\"\nnormal_exponent = 1.3\nimpact_damping = 30.0",
        "normal_law = \"hertz\"",
    ];
    for law in laws {
        let model = Model::parse(&with(law)).unwrap();
        assert_eq!(Model::parse(&model.to_toml()).unwrap(), model, "{law}");
        let contact = model.slip_slap().unwrap().expect("two directions");
        assert_eq!((contact.normal().preload(), contact.normal().stiffness()), (68.67, 2.37e7));
    }
    assert!(Model::parse(CONTACT).unwrap().slip_slap().unwrap().is_none());
}

#[test]
fn its_numbers_are_parameters_by_path() {
    let mut model = Model::parse(&with("normal_law = \"hertz\"\nimpact_damping = 30.0")).unwrap();
    assert_eq!(model.get("contact.normal_exponent"), Some(1.5));
    assert_eq!(model.get("contact.impact_damping"), Some(30.0));
    model.set("contact.normal_exponent", 1.2).unwrap();
    model.set("contact.normal_stiffness", 1e7).unwrap();
    let direction = model.normal_direction().unwrap().unwrap();
    assert!((direction.static_approach() - 1.2 * 68.67 / 1e7).abs() < 1e-15);
    let refused = model.set("contact.normal_exponent", 2.5).unwrap_err();
    assert_eq!(refused.path, "contact.normal_exponent");
}

#[test]
fn what_is_wrong_is_pointed_at() {
    refused("normal_law = \"herz\"", "\"herz\"", "did you mean `hertz`");
    refused("normal_law = \"herz\"\nnormal_exponent = 1.5", "\"herz\"", "did you mean `hertz`");
    refused("normal_law = \"hertz\"\nnormal_exponent = 3.0", "3.0", "normal_exponent");
    refused("normal_law = \"cubic\"\nnormal_cubic_stiffness = -1.0", "-1.0", "at least 0");
    refused("normal_law = \"linear\"\nimpact_damping = -1.0", "-1.0", "at least 0");
    refused("normal_law = \"linear\"\nnormal_exponent = 1.5", "normal_exponent", "normal_law = \"hertz\"");
    refused("normal_exponent = 1.5", "normal_exponent", "without normal_law");
    refused("impact_damping = 1.0", "impact_damping", "without normal_law");
    let text = with("normal_law = \"linear\"").replace("normal_stiffness = 2.37e7\n", "");
    assert!(Model::parse(&text).unwrap_err().to_string().contains("`normal_stiffness` is missing"));
    let text = with("normal_law = \"linear\"").replace("2.37e7", "0.0");
    assert!(Model::parse(&text).unwrap_err().to_string().contains("normal_stiffness"));
}

#[test]
fn effects_of_the_normal_direction_change_it() {
    let effects = "\n[[effect]]\nid = \"normal_hardening\"\nnormal_cubic_stiffness = 1e18\n\n\
        [[effect]]\nid = \"impact_damping\"\nimpact_damping = 20.0\n";
    let model =
        Model::parse(&with(&format!("normal_law = \"linear\"\nimpact_damping = 10.0\n{effects}"))).unwrap();
    let direction = model.normal_direction().unwrap().unwrap();
    assert_eq!(direction.law(), NormalLaw::Cubic { cubic_stiffness: 1e18 });
    assert_eq!(direction.impact_damping(), 30.0);
    let hertz = Model::parse(&with(&format!("normal_law = \"hertz\"\n{effects}"))).unwrap_err();
    assert!(hertz.to_string().contains("hardens by itself"), "{hertz}");
}
