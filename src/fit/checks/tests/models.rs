//! Values of a model that no machine has are named with their key, and the models of this repository have none.

use std::fs;
use std::path::Path;

use crate::data::Dataset;
use crate::fit::checks::check;
use crate::model::Model;

const BEAM: &str = r#"
    schema = "stickslip.model/1"
    kind = "beam"
    beam.length = 0.6
    beam.width = 0.04
    beam.thickness = 0.005
    beam.density = 7850.0
    beam.youngs_modulus = 210e9
    beam.modes = 4
    beam.damping_ratio = 0.003
    beam.point_mass = [{ position = 0.55, mass = 0.025 }]
    support.offset = 0.006
    excitation.position = 0.55
    contact = { law = "jenkins", tangential_stiffness = 5e6, friction_coefficient = 0.5, normal_load = 150.0 }
"#;

fn said(text: &str) -> Vec<String> {
    let dataset = Dataset { title: None, records: Vec::new() };
    check(&Model::parse(text).unwrap(), &dataset).iter().map(ToString::to_string).collect()
}

#[test]
fn values_that_no_machine_has_are_named_with_their_key() {
    assert_eq!(said(BEAM), Vec::<String>::new());
    for (from, to, key) in [
        ("density = 7850.0", "density = 7.85", "beam.density"),
        ("density = 7850.0", "density = 78500.0", "beam.density"),
        ("youngs_modulus = 210e9", "youngs_modulus = 210e6", "beam.youngs_modulus"),
        ("youngs_modulus = 210e9", "youngs_modulus = 210e10", "beam.youngs_modulus"),
        ("offset = 0.006", "offset = 6", "support.offset"),
        ("friction_coefficient = 0.5", "friction_coefficient = 50", "contact.friction_coefficient"),
        ("mass = 0.025", "mass = 25", "beam.point_mass.1.mass"),
        ("tangential_stiffness = 5e6", "tangential_stiffness = 5", "contact.tangential_stiffness"),
    ] {
        let found = said(&BEAM.replace(from, to));
        assert!(found.len() == 1 && found[0].starts_with(&format!("`{key}`: ")), "{to}: {found:?}");
        assert!(found[0].contains("expected") && !found[0].ends_with(['?', '.']), "{to}: {found:?}");
    }
}

#[test]
fn what_machines_have_is_not_named() {
    for (from, to) in [
        // Polyethylene, lead, diamond.
        (
            "density = 7850.0\n    beam.youngs_modulus = 210e9",
            "density = 920\n    beam.youngs_modulus = 0.2e9",
        ),
        (
            "density = 7850.0\n    beam.youngs_modulus = 210e9",
            "density = 11340\n    beam.youngs_modulus = 16e9",
        ),
        (
            "density = 7850.0\n    beam.youngs_modulus = 210e9",
            "density = 3510\n    beam.youngs_modulus = 1.1e12",
        ),
        ("friction_coefficient = 0.5", "friction_coefficient = 2.0"),
        ("mass = 0.025", "mass = 9.0"),
        ("offset = 0.006", "offset = 0.0"),
    ] {
        assert_eq!(said(&BEAM.replace(from, to)), Vec::<String>::new(), "{to}");
    }
}

#[test]
fn the_models_of_this_repository_are_plausible() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut read = 0;
    for folder in
        ["modelDescription", "tools/cli/templates", "examples/frictional-support", "examples/slip-slap"]
    {
        for entry in fs::read_dir(root.join(folder)).unwrap() {
            let text = fs::read_to_string(entry.unwrap().path()).unwrap_or_default();
            let Ok(model) = Model::parse(&text) else { continue };
            assert_eq!(check(&model, &Dataset { title: None, records: Vec::new() }), []);
            read += 1;
        }
    }
    assert!(read > 10, "{read} models");
}
