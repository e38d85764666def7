//! What is in the archive of an FMU.

use stickslip_fmu_package::{Error, read_model_toml, standard_models, write_fmu};

#[test]
fn a_model_file_too_large_to_be_one_is_refused_and_not_cut() {
    let (name, model_toml) = standard_models()[0];
    let padded = format!("{model_toml}# {}\n", "-".repeat(2 << 20));
    let fmu = write_fmu(name, &padded).unwrap();
    assert!(matches!(read_model_toml(&fmu), Err(Error::Unreadable(_))));
}
