//! The committed model descriptions are those of the standard models.

use std::path::{Path, PathBuf};
use stickslip::fmi::Instance;
use stickslip_fmu_package::{
    model_description_xml, model_description_xml3, standard_models, terminals_and_icons_xml,
};

/// `STICKSLIP_GOLDEN=write cargo test -p stickslip-fmu-package --test package` writes them again.
#[test]
fn committed_model_descriptions_are_fresh() {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../modelDescription");
    for (name, model_toml) in standard_models() {
        let instance = Instance::new(model_toml).unwrap_or_else(|error| panic!("{name}: {error}"));
        let (file, description) = (format!("{name}.xml"), instance.description());
        compare(&folder.join(&file), &model_description_xml(name, description));
        compare(&folder.join("fmi3").join(&file), &model_description_xml3(name, description));
        compare(&folder.join("terminalsAndIcons").join(&file), &terminals_and_icons_xml(description));
    }
}

fn compare(file: &Path, xml: &str) {
    if std::env::var_os("STICKSLIP_GOLDEN").is_some_and(|value| value == "write") {
        std::fs::create_dir_all(file.parent().unwrap()).unwrap();
        return std::fs::write(file, xml).unwrap();
    }
    let committed = std::fs::read_to_string(file).unwrap_or_default();
    let advice = "is stale: set STICKSLIP_GOLDEN=write, run this test, and review the difference";
    assert_eq!(committed.replace("\r\n", "\n"), xml, "{} {advice}", file.display());
}

#[test]
fn the_name_of_a_standard_model_is_the_one_its_description_has() {
    for (name, model_toml) in standard_models() {
        assert_eq!(Instance::new(model_toml).unwrap().description().name, name);
    }
}
