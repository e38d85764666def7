//! The measured loops of a friction device, which have a licence of their own and stay where they are.

use crate::external;
use crate::support::{error, read_json, stickslip};

#[test]
fn measured_friction_damper_is_compared_where_its_data_are_present() {
    let Some(folder) = external::data("friction-damper") else { return };
    let out = tempfile::tempdir().unwrap();
    let (model, dataset) = (folder.join("model.toml"), folder.join("dataset.toml"));
    let (model, dataset) = (model.to_str().unwrap(), dataset.to_str().unwrap());
    let output =
        stickslip(out.path(), &["compare", model, dataset, "--json", "c.json", "--report", "r.html"]);
    assert!(output.status.success(), "{}", error(&output));
    let json = read_json(&out, "c.json");
    let error = |name: &str| json["error"][name].as_f64().unwrap();
    assert!(error("refitted") < 0.5 * error("baseline"), "{} {}", error("baseline"), error("refitted"));
    assert_eq!(json["stages"][1]["records"].as_array().unwrap().len(), 10);
}

/// Backlash takes most of the error, and what its records show beside it no effect of the catalogue describes: the maker of
/// the data names a second effect in the device.
#[test]
fn the_measured_friction_damper_lacks_backlash_and_something_unknown() {
    let Some(folder) = external::data("friction-damper") else { return };
    let out = tempfile::tempdir().unwrap();
    let (model, dataset) = (folder.join("model.toml"), folder.join("dataset.toml"));
    let (model, dataset) = (model.to_str().unwrap(), dataset.to_str().unwrap());
    let tried = ["--effects", "backlash,residual_stiffness"];
    let output =
        stickslip(out.path(), &[&["diagnose", model, dataset, "--json", "d.json"], &tried[..]].concat());
    assert_eq!(output.status.code(), Some(12), "{}", error(&output));
    let json = read_json(&out, "d.json");
    assert_eq!(json["verdict"], "unexplained");
    assert!(json["surrogates"].as_array().unwrap().contains(&"backlash".into()), "{}", json["surrogates"]);
    assert_eq!(json["candidates"][0]["effect"], "backlash");
    assert!(json["effects"].as_array().unwrap().is_empty());
    let error = |name: &str| json["error"][name].as_f64().unwrap();
    assert!(
        error("untouched") < 0.75 * error("untouched_refitted")
            && error("untouched") < 0.5 * error("baseline")
    );
    // The cycles that each record repeats tell its noise: the residual is far more.
    assert!((0.0..0.5 * error("final")).contains(&error("noise_floor")), "{}", error("noise_floor"));
}
