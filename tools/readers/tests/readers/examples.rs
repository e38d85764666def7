//! The examples in the repository are good input, and say what their README says.

use std::path::{Path, PathBuf};

use stickslip::data::Regime;
use stickslip::model::{Law, Model};
use stickslip_readers::{check_columns, read_dataset, read_model};

const MODELS: [&str; 5] = ["linear", "published", "jenkins", "valanis", "valanis-residual"];

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/frictional-support")
}

fn model(name: &str) -> Model {
    let path = folder().join(name).with_extension("toml");
    read_model(path).unwrap_or_else(|error| panic!("{}", error.render(false)))
}

#[test]
fn every_model_can_be_compared_with_the_backbone() {
    let dataset = read_dataset(folder()).unwrap_or_else(|error| panic!("{}", error.render(false)));
    let record = &dataset.records[0];
    assert_eq!((record.regime, record.len(), dataset.records.len()), (Regime::Backbone, 8, 1));
    assert_eq!(record.channel("frequency").unwrap().values[7], 50.11);
    assert!(dataset.title.unwrap().contains("Mechanical Systems and Signal Processing"));
    let dataset = read_dataset(folder()).unwrap();
    for name in MODELS {
        check_columns(&dataset, &model(name)).unwrap();
    }
}

#[test]
fn the_models_differ_in_support_contact_and_fit_only() {
    let beam = |model: &Model| {
        let mut parameters = model.parameters();
        parameters.retain(|parameter| !parameter.path.starts_with("contact."));
        parameters.retain(|parameter| parameter.path != "support.rotational_stiffness");
        parameters.into_iter().map(|parameter| (parameter.path, parameter.value)).collect::<Vec<_>>()
    };
    for name in MODELS {
        assert_eq!(beam(&model(name)), beam(&model("published")), "{name}");
    }
}

#[test]
fn the_published_contact_has_the_limit_of_table_3() {
    for name in &MODELS[1..] {
        let contact = model(name).contact.unwrap();
        let limit = contact.friction_coefficient * contact.normal_load;
        assert!((limit - 7.9e6 / 8.7e4).abs() < 1e-12, "{name}: {limit}");
        assert_eq!(contact.tangential_stiffness, 7.9e6);
    }
    let contact = model("published").contact.unwrap();
    assert_eq!(contact.law, Law::named("valanis", &[0.3, 0.0]).unwrap());
}

#[test]
fn a_fit_changes_the_contact_only() {
    let free = |name: &str| {
        let parameters = model(name).parameters().into_iter();
        parameters.filter(|parameter| parameter.free).map(|parameter| parameter.path).collect::<Vec<_>>()
    };
    let contact = |names: &[&str]| names.iter().map(|name| format!("contact.{name}")).collect::<Vec<_>>();
    assert_eq!(free("linear"), ["support.rotational_stiffness"]);
    assert!(free("published").is_empty());
    let mut names = vec!["tangential_stiffness", "friction_coefficient"];
    assert_eq!(free("jenkins"), contact(&names));
    names.push("smoothness");
    assert_eq!(free("valanis"), contact(&names));
    names.push("residual_stiffness");
    assert_eq!(free("valanis-residual"), contact(&names));
}
