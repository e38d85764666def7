//! Systems of FMUs as a user simulates them.
#![cfg(target_os = "linux")]

use std::fs;
use std::path::Path;

use serde_json::Value;
use tempfile::TempDir;

use crate::support::{read_json, stickslip};
use crate::unruly;

/// Runs and expects this exit code; standard output and error.
pub fn ended(folder: &Path, code: i32, arguments: &[&str]) -> (String, String) {
    let output = stickslip(folder, arguments);
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    let (out, errors) = (text(&output.stdout), text(&output.stderr));
    assert_eq!(output.status.code(), Some(code), "{arguments:?}\n{out}\n{errors}");
    (out, errors)
}

/// A folder with BeamWithJenkins.ssp.
fn systems() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    ended(folder.path(), 0, &["fmu", "BeamWithJenkins", "JenkinsContact"]);
    folder
}

fn column<'j>(json: &'j Value, name: &str) -> Vec<f64> {
    let columns = json["columns"].as_array().unwrap();
    let column: &'j Value = columns.iter().find(|column| column["name"] == name).unwrap();
    column["values"].as_array().unwrap().iter().map(|value| value.as_f64().unwrap()).collect()
}

#[test]
fn a_finer_explicit_coupling_approaches_the_strong_one_and_so_does_its_energy() {
    let folder = systems();
    let run = |algorithm: &str, step: &str, every: &str| {
        let arguments = [
            "simulate",
            "BeamWithJenkins.ssp",
            "--stop",
            "0.01",
            "--algorithm",
            algorithm,
            "--extrapolation",
            "0",
            "--step",
            step,
            "--every",
            every,
            "--out",
            "r.json",
        ];
        ended(folder.path(), 0, &arguments);
        read_json(&folder, "r.json")
    };
    let reference = run("strong", "5e-6", "20");
    let exact = column(&reference, "beam.displacement");
    let scale = exact.iter().fold(0.0_f64, |largest, value| largest.max(value.abs()));
    assert!(scale > 1e-7);
    let error = |json: &Value| {
        let found = column(json, "beam.displacement");
        assert_eq!(found.len(), exact.len());
        let worst = found.iter().zip(&exact).map(|(one, other)| (one - other).abs());
        worst.fold(0.0_f64, f64::max) / scale
    };
    let (coarse, fine) = (run("jacobi", "2e-5", "5"), run("jacobi", "1e-5", "10"));
    assert!(error(&fine) < 0.7 * error(&coarse), "{} {}", error(&fine), error(&coarse));
    let residual = |json: &Value| json["energy"][0]["magnitude"].as_f64().unwrap();
    assert!(residual(&fine) < 0.7 * residual(&coarse));
    let strong = run("strong", "2e-5", "5");
    assert!(error(&strong) < 0.3 * error(&coarse), "{} {}", error(&strong), error(&coarse));
}

#[test]
fn adapted_steps_are_few_from_rest_on_and_what_limits_them_is_reported() {
    let folder = systems();
    let run = |tolerance: &str| {
        let arguments = ["simulate", "BeamWithJenkins.ssp", "--stop", "0.02", "--algorithm", "adaptive"];
        let (out, _) = ended(
            folder.path(),
            0,
            &[&arguments[..], &["--tolerance", tolerance, "--out", "r.json"]].concat(),
        );
        (read_json(&folder, "r.json"), out)
    };
    let (usual, _) = run("1e-4");
    assert!(usual["steps"].as_u64().unwrap() < 2500 && usual["forced"] == 0, "{}", usual["steps"]);
    let (_, table) = run("1e-7");
    let table = table.split_whitespace().collect::<Vec<_>>().join(" ");
    // The loop's two variables limit the steps equally often.
    let named =
        ["beam.displacement", "contact.force"].map(|name| table.contains(&format!("because of {name}")));
    assert!(named.contains(&true) && table.contains("--algorithm strong"), "{table}");
}

#[test]
fn tables_have_units_and_reports_the_energy() {
    let folder = systems();
    let (table, _) = ended(
        folder.path(),
        0,
        &[
            "simulate",
            "BeamWithJenkins.ssp",
            "--stop",
            "0.005",
            "--step",
            "1e-4",
            "--out",
            "r.csv",
            "--report",
            "r.html",
        ],
    );
    assert!(table.contains("beam.contact_force") && table.contains("strong"), "{table}");
    let csv = fs::read_to_string(folder.path().join("r.csv")).unwrap();
    let header = csv.lines().next().unwrap();
    assert!(header.starts_with("time [s],beam.displacement [m],beam.velocity [m/s]"), "{header}");
    assert!(header.contains("contact.slip_state [1]"), "{header}");
    assert_eq!(csv.lines().count(), 52);
    let page = fs::read_to_string(folder.path().join("r.html")).unwrap();
    assert!(page.contains("Energy residual") && page.contains("contact.force"));
    ended(folder.path(), 0, &["simulate", "BeamWithJenkins.ssp", "--stop", "0.005", "--out", "r.parquet"]);
    let parquet = fs::read(folder.path().join("r.parquet")).unwrap();
    assert!(parquet.starts_with(b"PAR1") && parquet.ends_with(b"PAR1"));
}

#[test]
fn values_from_the_command_line_and_from_a_file_act() {
    let folder = systems();
    let path = folder.path();
    let force = |more: &[&str]| {
        let base = ["simulate", "JenkinsContact.fmu", "--stop", "0.01", "--step", "1e-3", "--out", "r.json"];
        ended(path, 0, &[&base[..], more].concat());
        column(&read_json(&folder, "r.json"), "JenkinsContact.force")
    };
    // 0.6 · 147.15 N, or less normal load, once the displacement is beyond the limit.
    let held = force(&["--set", "displacement=1e-4"]);
    assert!((held[5] - 0.6 * 147.15).abs() < 1e-9, "{held:?}");
    let light = force(&["--set", "displacement=1e-4", "--set", "JenkinsContact.normal_load=10"]);
    assert!((light[5] - 6.0).abs() < 1e-9, "{light:?}");
    fs::write(path.join("push.csv"), "time [s],displacement [m]\n0,0\n0.004,4e-6\n0.1,4e-6\n").unwrap();
    let driven = force(&["--input", "push.csv", "--algorithm", "gauss-seidel"]);
    assert!((driven[2] - 7.9e6 * 2e-6).abs() < 1e-9 && (driven[9] - 31.6).abs() < 1e-9, "{driven:?}");
}

/// BeamWithJenkins.ssp unpacked, with this parameter set.
fn with_parameters(folder: &TempDir, parameters: &str) -> std::path::PathBuf {
    let mut archive =
        zip::ZipArchive::new(fs::File::open(folder.path().join("BeamWithJenkins.ssp")).unwrap()).unwrap();
    let unpacked = folder.path().join("unpacked");
    archive.extract(&unpacked).unwrap();
    let set = format!(
        "<ssv:ParameterSet xmlns:ssv=\"http://ssp-standard.org/SSP1/SystemStructureParameterValues\" version=\"1.0\" \
         name=\"p\"><ssv:Parameters>{parameters}</ssv:Parameters></ssv:ParameterSet>"
    );
    fs::write(unpacked.join("resources/parameters.ssv"), set).unwrap();
    unpacked.join("SystemStructure.ssd")
}

#[test]
fn a_parameter_that_belongs_to_nothing_is_one_note() {
    let folder = systems();
    let parameter = "<ssv:Parameter name=\"contact.normal_laod\"><ssv:Real value=\"1\"/></ssv:Parameter>";
    let system = with_parameters(&folder, parameter);
    let arguments = ["simulate", system.to_str().unwrap(), "--stop", "0.001", "--out", "r.json"];
    let (out, errors) = ended(folder.path(), 0, &arguments);
    assert_eq!(format!("{out}{errors}").matches("normal_laod").count(), 1, "{out}{errors}");
    assert!(
        errors.contains("did you mean `normal_load`?") && errors.contains("parameters.ssv:1"),
        "{errors}"
    );
    assert!(read_json(&folder, "r.json")["notes"][0].as_str().unwrap().contains("normal_laod"));
}

#[test]
fn common_units_are_converted_without_a_definition_and_unknown_ones_refused() {
    let folder = systems();
    let path = folder.path();
    let force = |column: &str, scale: f64| {
        let table = format!("time [s],{column}\n0,0\n0.004,{}\n0.1,{}\n", 4.0 * scale, 4.0 * scale);
        fs::write(path.join("push.csv"), table).unwrap();
        let arguments =
            ["simulate", "JenkinsContact.fmu", "--stop", "0.01", "--step", "1e-3", "--input", "push.csv"];
        ended(path, 0, &[&arguments[..], &["--out", "r.json"]].concat());
        column_of(&read_json(&folder, "r.json"))
    };
    let metres = force("displacement [m]", 1e-6);
    for (column, scale) in
        [("displacement [mm]", 1e-3), ("displacement [um]", 1.0), ("displacement [µm]", 1.0)]
    {
        assert!((force(column, scale) - metres).abs() < 1e-9 * metres.abs(), "{column}");
    }
    let load = |unit: &str, value: &str| {
        format!(
            "<ssv:Parameter name=\"contact.normal_load\"><ssv:Real value=\"{value}\" unit=\"{unit}\"/></ssv:Parameter>"
        )
    };
    let dissipated = |parameter: &str| {
        let system = with_parameters(&folder, parameter);
        let arguments = ["simulate", system.to_str().unwrap(), "--stop", "0.002", "--out", "r.json"];
        ended(path, 0, &arguments);
        column(&read_json(&folder, "r.json"), "contact.force")
    };
    assert_eq!(dissipated(&load("kN", "0.125")), dissipated(&load("N", "125")));
    let system = with_parameters(&folder, &load("furlong", "1"));
    let (_, errors) = ended(path, 2, &["simulate", system.to_str().unwrap(), "--stop", "0.002"]);
    assert!(errors.contains("`furlong`") && errors.contains("parameters.ssv:1"), "{errors}");
}

#[test]
fn a_variable_without_a_unit_has_that_of_its_connector() {
    let description = unruly::DESCRIPTION.replace("<Real unit=\"N\" start", "<Real start");
    let binary = "binaries/linux64/Unruly.so";
    let fmu =
        unruly::archive(&[("modelDescription.xml", description.as_bytes()), (binary, &unruly::library())]);
    let (folder, _file) = unruly::written("Unruly.fmu", &fmu);
    let system = "<SystemStructureDescription version=\"1.0\" name=\"s\"><System name=\"s\"><Elements>\
        <Component name=\"one\" source=\"Unruly.fmu\"><Connectors><Connector name=\"u\" kind=\"input\"><Real unit=\"N\"/>\
        </Connector></Connectors></Component></Elements></System></SystemStructureDescription>";
    fs::write(folder.path().join("s.ssd"), system).unwrap();
    fs::write(folder.path().join("push.csv"), "time [s],one.u [kN]\n0,2\n1,2\n").unwrap();
    let arguments =
        ["simulate", "s.ssd", "--stop", "1", "--step", "0.1", "--input", "push.csv", "--out", "r.json"];
    ended(folder.path(), 0, &arguments);
    let last = *column(&read_json(&folder, "r.json"), "one.y").last().unwrap();
    assert!((last - 2000.0).abs() < 1e-6, "{last}");
}

#[test]
fn outputs_of_the_system_are_columns_in_their_own_units() {
    let (folder, _file) = unruly::file();
    let system = "<SystemStructureDescription version=\"1.0\" name=\"s\"><System name=\"s\"><Connectors>\
        <Connector name=\"seen\" kind=\"output\"><Real unit=\"kN\"/></Connector></Connectors><Elements>\
        <Component name=\"one\" source=\"Unruly.fmu\"><Connectors><Connector name=\"y\" kind=\"output\"><Real unit=\"N\"/>\
        </Connector></Connectors></Component></Elements><Connections><Connection startElement=\"one\" startConnector=\"y\" \
        endConnector=\"seen\"/></Connections></System></SystemStructureDescription>";
    fs::write(folder.path().join("s.ssd"), system).unwrap();
    let arguments =
        ["simulate", "s.ssd", "--stop", "1", "--step", "0.1", "--set", "one.u=2000", "--out", "r.csv"];
    ended(folder.path(), 0, &arguments);
    let csv = fs::read_to_string(folder.path().join("r.csv")).unwrap();
    let cells = |line: &str| line.split(',').map(str::to_owned).collect::<Vec<_>>();
    assert_eq!(cells(csv.lines().next().unwrap()), ["time [s]", "one.y [N]", "seen [kN]"]);
    let last = cells(csv.lines().last().unwrap());
    let [own, seen] = [1, 2].map(|cell: usize| last[cell].parse::<f64>().unwrap());
    assert!((own - 2000.0).abs() < 1e-9 && (seen - 2.0).abs() < 1e-12, "{last:?}");
}

/// The last force of the contact.
fn column_of(json: &Value) -> f64 {
    *column(json, "JenkinsContact.force").last().unwrap()
}

#[test]
fn bad_input_is_reported_with_names_and_nothing_is_written() {
    let folder = systems();
    let path = folder.path();
    fs::write(path.join("broken.ssd"), "<a>").unwrap();
    fs::write(path.join("broken.fmu"), "PK").unwrap();
    fs::write(path.join("driven.csv"), "time [s],contact.displacement [mm]\n0,0\n1,1\n").unwrap();
    fs::write(path.join("furlong.csv"), "time [s],beam.excitation [furlong]\n0,0\n1,1\n").unwrap();
    let system = "BeamWithJenkins.ssp";
    let cases: [(&[&str], &str); 17] = [
        (&["nowhere.ssp"], "there is no such file"),
        (&["broken.ssd"], "broken.ssd"),
        (&["broken.fmu"], "broken.fmu"),
        (&[system, "--set", "contact.nix=1"], "contact (resources/JenkinsContact.fmu) has no variable `nix`"),
        (&[system, "--set", "gear.nix=1"], "the system has beam, contact"),
        (&[system, "--set", "contact.normal_load=much"], "`much`"),
        (&[system, "--set", "contact.friction_coefficient=-1", "--out", "r.csv"], "friction_coefficient"),
        (&[system, "--set", "contact.normal_laod=1"], "did you mean `normal_load`?"),
        (&[system, "--set", "contact.displacement=1"], "takes its values from `beam.displacement`"),
        (&[system, "--input", "driven.csv"], "takes its values from `beam.displacement`"),
        (&[system, "--input", "furlong.csv"], "`furlong` is no unit"),
        (&[system, "--algorithm", "adaptive", "--tolerance", "1e-30"], "from 1e-10 to 1"),
        (&[system, "--report", "r.pdf"], ".html"),
        (&[system, "--step=-1"], "step"),
        (&[system, "--step=1e-15"], "longer --step"),
        (&[system, "--out", "r.xlsx"], ".parquet"),
        (&[system, "--out", "BeamWithJenkins.ssp"], "would replace the input"),
    ];
    for (arguments, message) in cases {
        let whole: Vec<&str> = ["simulate"].iter().chain(arguments).copied().collect();
        let (_, errors) = ended(path, 2, &whole);
        assert!(errors.contains(message), "{arguments:?}: {errors}");
    }
    assert!(!path.join("r.xlsx").exists() && !path.join("r.csv").exists());
}

#[test]
fn a_run_that_explodes_is_told_on_standard_error() {
    let folder = systems();
    let run =
        ["simulate", "BeamWithJenkins.ssp", "--stop", "0.2", "--step", "1e-3", "--algorithm", "jacobi", "-q"];
    let (out, errors) = ended(folder.path(), 1, &run);
    assert!(
        out.is_empty() && errors.starts_with("error: ") && errors.contains("explodes"),
        "{out}\n{errors}"
    );
}

#[test]
fn a_system_is_no_model() {
    let folder = systems();
    for arguments in
        [&["export", "BeamWithJenkins.ssp", "-o", "x.fmu"][..], &["check", "BeamWithJenkins.ssp"]]
    {
        let (_, errors) = ended(folder.path(), 2, arguments);
        assert!(errors.contains("system of FMUs") && errors.contains("stickslip simulate"), "{errors}");
    }
}

#[test]
fn two_contacts_on_one_beam_share_it_and_take_its_energy() {
    let folder = tempfile::tempdir().unwrap();
    ended(folder.path(), 0, &["fmu", "BeamWithTwoContacts"]);
    // With the step that the beam proposes.
    let arguments = ["simulate", "BeamWithTwoContacts.ssp", "--stop", "0.02", "--out", "r.json"];
    ended(folder.path(), 0, &arguments);
    let json = read_json(&folder, "r.json");
    let energy = json["energy"].as_array().unwrap();
    assert_eq!(energy.len(), 2, "{energy:?}");
    for one in energy {
        let (magnitude, exchanged) = (one["magnitude"].as_f64().unwrap(), one["exchanged"].as_f64().unwrap());
        assert!(exchanged > 0.0 && magnitude < 0.01 * exchanged, "{one}");
    }
    let force = column(&json, "damper.force");
    let largest = force.iter().fold(0.0_f64, |most, force| most.max(force.abs()));
    assert!((largest - 0.6 * 15.0).abs() < 1e-9, "the damper slips at its limit: {largest}");
    for contact in ["contact", "damper"] {
        let dissipated = column(&json, &format!("{contact}.dissipated_energy"));
        assert!(
            dissipated.windows(2).all(|pair| pair[1] >= pair[0] - 1e-15) && *dissipated.last().unwrap() > 0.0
        );
    }
}
