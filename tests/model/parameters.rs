//! Parameters by path: what a fit may change, within which bounds, and what setting them refuses.

use stickslip::fit::Scale;
use stickslip::model::Model;

fn beam(law: &str, damping: &str, support: &str, fit: &str) -> Model {
    let text = format!(
        r#"schema = "stickslip.model/1"
kind = "beam"
[beam]
length = 0.6
width = 0.04
thickness = 0.005
density = 7850
youngs_modulus = 2e11
modes = 3
{damping}
[[beam.point_mass]]
position = 0.3
mass = 0.005
[support]
offset = 0.006
{support}
[excitation]
position = 0.55
[contact]
{law}
tangential_stiffness = 5e6
friction_coefficient = 0.5
normal_load = 150
{fit}"#
    );
    Model::parse(&text).unwrap_or_else(|error| panic!("{error}"))
}

fn free(model: &Model) -> Vec<String> {
    model
        .parameters()
        .into_iter()
        .filter(|parameter| parameter.free)
        .map(|parameter| parameter.path)
        .collect()
}

const VALANIS: &str = "law = \"valanis\"\nsmoothness = 0.3\nresidual_stiffness = 1e5";
const JENKINS: &str = "law = \"jenkins\"";
const UNIFORM: &str = "damping_ratio = 0.003";

#[test]
fn every_parameter_is_read_and_set_by_its_path() {
    let mut model = beam(VALANIS, "damping_ratio = [0.1, 0.2, 0.3]", "clamp_stiffness = 1e5", "");
    let parameters = model.parameters();
    assert!(parameters.iter().any(|parameter| parameter.path == "beam.damping_ratio.3"));
    assert!(parameters.iter().any(|parameter| parameter.path == "beam.point_mass.1.mass"));
    for parameter in parameters {
        let changed = 1.05 * parameter.value;
        model.set(&parameter.path, changed).unwrap();
        assert_eq!(model.get(&parameter.path), Some(changed), "{}", parameter.path);
    }
    model.check().unwrap();
}

#[test]
fn paths_are_distinct() {
    let model = beam(VALANIS, UNIFORM, "clamp_stiffness = 1e5\nrotational_stiffness = 3", "");
    let mut paths: Vec<_> = model.parameters().into_iter().map(|parameter| parameter.path).collect();
    let count = paths.len();
    paths.sort();
    paths.dedup();
    assert_eq!(paths.len(), count);
}

#[test]
fn contact_damping_and_stiffness_are_free_by_default_masses_and_geometry_are_not() {
    let contact = ["contact.tangential_stiffness", "contact.friction_coefficient"];
    let model = beam(JENKINS, UNIFORM, "", "");
    assert_eq!(free(&model), [&["beam.youngs_modulus", "beam.damping_ratio"], &contact[..]].concat());
    let model = beam(JENKINS, "mass_damping = 1", "rotational_stiffness = 3\nclamp_stiffness = 1e5", "");
    let springs = ["support.rotational_stiffness", "support.clamp_stiffness"];
    let damping = ["beam.youngs_modulus", "beam.mass_damping", "beam.stiffness_damping"];
    assert_eq!(free(&model), [&damping[..], &springs, &contact].concat());
}

#[test]
fn the_normal_load_is_free_only_when_named() {
    // Only the product of load and coefficient acts: free together, they have no unique fit.
    for (fit, expected) in [
        ("", false),
        ("[fit]\nfree = [\"contact.*\"]", false),
        ("[fit]\nfree = [\"*\"]", false),
        ("[fit]\nfree = [\"contact.normal_load\"]", true),
    ] {
        let model = beam(JENKINS, UNIFORM, "", fit);
        assert_eq!(free(&model).contains(&"contact.normal_load".to_owned()), expected, "{fit}");
    }
}

#[test]
fn patterns_replace_the_defaults() {
    let model = beam(VALANIS, UNIFORM, "", "[fit]\nfree = [\"*.mass\", \"contact.smoothness\"]");
    assert_eq!(free(&model), ["beam.point_mass.1.mass", "contact.smoothness"]);
    assert!(free(&beam(VALANIS, UNIFORM, "", "[fit]\nfree = []")).is_empty());
}

#[test]
fn fit_bounds_hold_the_value_are_legal_and_suit_the_scale() {
    let support = "rotational_stiffness = 3\nclamp_stiffness = 1e20";
    for damping in [UNIFORM, "damping_ratio = 0", "damping_ratio = 1", "mass_damping = 1e9"] {
        let model = beam(VALANIS, damping, support, "");
        for parameter in model.parameters() {
            let path = &parameter.path;
            assert!(parameter.lower <= parameter.value && parameter.value <= parameter.upper, "{path}");
            assert!(parameter.lower < parameter.upper, "{path}");
            assert!(parameter.scale == Scale::Linear || parameter.lower > 0.0, "{path}");
            for bound in [parameter.lower, parameter.upper] {
                model.clone().set(path, bound).unwrap_or_else(|error| panic!("{error}"));
            }
        }
    }
}

#[test]
fn smoothness_and_residual_stiffness_keep_their_distance_from_the_singular_laws() {
    let parameters = beam(VALANIS, UNIFORM, "", "").parameters();
    let bounds = |path: &str| {
        let parameter = parameters.iter().find(|parameter| parameter.path == path).unwrap();
        (parameter.lower, parameter.upper)
    };
    assert_eq!(bounds("contact.smoothness"), (0.0, 0.98));
    assert_eq!(bounds("contact.residual_stiffness"), (0.0, 0.9 * 5e6));
}

#[test]
fn a_refused_change_changes_nothing() {
    let mut model = beam(VALANIS, UNIFORM, "", "");
    let before = model.clone();
    for (path, value) in [
        ("contact.residual_stiffness", 5e6),
        ("contact.smoothness", 1.0),
        ("contact.friction_coefficient", 0.0),
        ("contact.normal_load", -1.0),
        ("beam.youngs_modulus", f64::NAN),
        ("beam.point_mass.1.position", 0.7),
        ("beam.length", 0.5),
        ("support.clamp_stiffness", f64::INFINITY),
        ("beam.point_mass.2.mass", 1.0),
        ("beam.damping_ratio.1", 0.1),
        ("", 1.0),
    ] {
        let error = model.set(path, value).expect_err(path);
        assert!(!error.message.is_empty() && !error.path.is_empty() || path.is_empty(), "{error}");
        assert_eq!(model, before, "{path} = {value}");
    }
    let error = model.set("contact.smothness", 0.1).unwrap_err();
    assert!(error.to_string().contains("did you mean `contact.smoothness`"), "{error}");
}

#[test]
fn joined_parameters_are_judged_after_all_are_set() {
    let mut model = beam(VALANIS, UNIFORM, "", "");
    let both = [("contact.residual_stiffness", 6e6), ("contact.tangential_stiffness", 7e6)];
    assert!(model.set(both[0].0, both[0].1).is_err(), "alone it exceeds the tangential stiffness");
    model.set_all(&both).unwrap();
    assert_eq!(model.get("contact.residual_stiffness"), Some(6e6));
}

#[test]
fn setting_a_clamp_stiffness_puts_the_spring_there() {
    let mut model = beam(JENKINS, UNIFORM, "", "");
    assert_eq!(model.get("support.clamp_stiffness"), None);
    model.set("support.clamp_stiffness", 2e4).unwrap();
    assert_eq!(model.get("support.clamp_stiffness"), Some(2e4));
    assert!(free(&model).contains(&"support.clamp_stiffness".to_owned()));
}
