//! FMUs that crash, give up or give no number.
#![cfg(target_os = "linux")]

use std::fs;
use std::path::Path;

use crate::simulate::ended;
use crate::unruly;

/// `Unruly.fmu` misbehaving; what the program said on both channels.
fn unruly_ended(folder: &Path, code: i32, behaviour: &str, more: &[&str]) -> (String, String) {
    let set = format!("behaviour={behaviour}");
    let arguments = ["simulate", "Unruly.fmu", "--stop", "1", "--step", "0.1", "--set", "u=2", "--set", &set];
    ended(folder, code, &[&arguments[..], &["--out", "r.csv"], more].concat())
}

#[test]
fn an_fmu_that_is_not_of_this_program_crashes_alone_and_results_so_far_are_kept() {
    let (folder, _file) = unruly::file();
    // It aborts, segfaults, calls `_exit(7)` or `exit(0)`, fails, is lost, gives no number.
    for behaviour in ["1", "2", "3", "11", "5", "6", "12"] {
        for more in [&[][..], &["--isolate"]] {
            let (out, errors) = unruly_ended(folder.path(), 1, behaviour, more);
            assert!(out.contains("0.4 s") && out.contains("nruly"), "{behaviour}: {out}");
            assert_eq!(errors.contains("--no-isolate"), more.is_empty(), "{errors}");
            let csv = fs::read_to_string(folder.path().join("r.csv")).unwrap();
            let last: Vec<f64> =
                csv.lines().last().unwrap().split(',').map(|cell| cell.parse().unwrap()).collect();
            assert_eq!(csv.lines().count(), 1 + 5, "{csv}");
            assert!((last[0] - 0.4).abs() < 1e-12 && (last[1] - 0.8).abs() < 1e-12, "{last:?}");
            fs::remove_file(folder.path().join("r.csv")).unwrap();
        }
    }
    let (out, _) = unruly_ended(folder.path(), 1, "12", &[]);
    assert!(out.contains("`y`") && out.contains("NaN"), "{out}");
}

#[test]
fn what_ends_a_run_early_is_told_on_standard_error_also_to_the_quiet() {
    let (folder, _file) = unruly::file();
    for behaviour in ["3", "4", "5", "12"] {
        let (quiet, error) = unruly_ended(folder.path(), 1, behaviour, &["-q"]);
        assert_eq!((quiet.as_str(), error.lines().count()), ("", 1), "{error}");
        assert!(error.starts_with("error: at 0.4 s: ") && error.contains("nruly"), "{error}");
        let (out, errors) = unruly_ended(folder.path(), 1, behaviour, &[]);
        assert!(out.contains("ended early") && errors.contains(error.trim()), "{out}\n{errors}");
    }
}

#[test]
fn an_fmu_in_this_process_that_calls_exit_is_no_success() {
    let (folder, _file) = unruly::file();
    for quiet in [&["--no-isolate"][..], &["--no-isolate", "-q"]] {
        let (_, errors) = unruly_ended(folder.path(), 1, "11", quiet);
        assert!(errors.contains("`exit`") && errors.contains("nothing was written"), "{quiet:?} {errors}");
    }
    assert!(!folder.path().join("r.csv").exists());
}

#[test]
fn nothing_temporary_is_left_after_a_crash() {
    let (folder, _file) = unruly::file();
    let temporary = folder.path().join("temporary");
    fs::create_dir(&temporary).unwrap();
    for behaviour in ["1", "2", "3", "11"] {
        let set = format!("behaviour={behaviour}");
        let status = std::process::Command::new(env!("CARGO_BIN_EXE_stickslip"))
            .current_dir(folder.path())
            .env("TMPDIR", &temporary)
            .args(["simulate", "Unruly.fmu", "--no-isolate", "--stop", "1", "--step", "0.1", "--set", &set])
            .output()
            .unwrap()
            .status;
        assert!(!status.success(), "{behaviour}: {status}");
        let begin = std::time::Instant::now();
        while fs::read_dir(&temporary).unwrap().count() > 0 {
            assert!(begin.elapsed().as_secs() < 20, "{behaviour}: temporary folders are left");
            std::thread::sleep(std::time::Duration::from_millis(20));
        }
    }
}

/// A system of two of them, called `one` and `other`, with a type of `one.y`, and these connections.
fn two_of_them(declared: &str, connections: &str) -> String {
    let component = |name: &str, declared: &str| {
        format!(
            "<Component name=\"{name}\" source=\"Unruly.fmu\"><Connectors><Connector name=\"u\" kind=\"input\"/>\
             <Connector name=\"y\" kind=\"output\">{declared}</Connector></Connectors></Component>"
        )
    };
    format!(
        "<SystemStructureDescription version=\"1.0\" name=\"s\"><System name=\"s\"><Elements>{}{}</Elements>\
         <Connections>{connections}</Connections></System></SystemStructureDescription>",
        component("one", declared),
        component("other", "")
    )
}

const THERE: &str =
    "<Connection startElement=\"one\" startConnector=\"y\" endElement=\"other\" endConnector=\"u\"/>";
const BACK: &str =
    "<Connection startElement=\"other\" startConnector=\"y\" endElement=\"one\" endConnector=\"u\"/>";

#[test]
fn a_coupling_without_units_is_a_note_everywhere() {
    let (folder, _file) = unruly::file();
    fs::write(folder.path().join("s.ssd"), two_of_them("", &[THERE, BACK].concat())).unwrap();
    let run =
        ["simulate", "s.ssd", "--stop", "1", "--step", "0.1", "--algorithm", "jacobi", "--report", "r.html"];
    let note = "coupling of one and other is not watched: their units do not tell which force and motion belong together; if they exchange power, give --power";
    let (out, _) = ended(folder.path(), 0, &[&run[..], &["--out", "r.json"]].concat());
    assert!(out.split_whitespace().collect::<Vec<_>>().join(" ").contains(note), "{out}");
    for file in ["r.json", "r.html"] {
        assert!(fs::read_to_string(folder.path().join(file)).unwrap().contains(note), "{file}");
    }
    let (out, _) = ended(folder.path(), 0, &[&run[..], &["--power", "one.u=other.u"]].concat());
    assert!(!out.contains("not watched"), "{out}");
}

#[test]
fn a_connector_of_another_type_than_its_variable_is_refused() {
    let (folder, _file) = unruly::file();
    for (declared, code) in [("Real", 0), ("Boolean", 2), ("Integer", 2), ("String", 2)] {
        fs::write(folder.path().join("s.ssd"), two_of_them(&format!("<{declared}/>"), THERE)).unwrap();
        let arguments = ["simulate", "s.ssd", "--stop", "1", "--step", "0.1"];
        let (_, errors) = ended(folder.path(), code, &arguments);
        let told = ["s.ssd:1", "`one.y`", &format!("declared {declared}"), "is Real"];
        assert_eq!(told.iter().all(|part| errors.contains(part)), code == 2, "{declared}: {errors}");
    }
}

#[test]
fn a_mapping_of_booleans_between_real_variables_is_refused() {
    let (folder, _file) = unruly::file();
    let mapping = "><BooleanMappingTransformation><MapEntry source=\"true\" target=\"false\"/></BooleanMappingTransformation>\
                   </Connection>";
    fs::write(folder.path().join("s.ssd"), two_of_them("", &THERE.replace("/>", mapping))).unwrap();
    let arguments = ["simulate", "s.ssd", "--stop", "1", "--step", "0.1", "--out", "r.csv"];
    let (_, errors) = ended(folder.path(), 2, &arguments);
    assert!(errors.contains("BooleanMapping") && errors.contains("`one.y`"), "{errors}");
    assert!(errors.contains("s.ssd:1") && !folder.path().join("r.csv").exists(), "{errors}");
}

#[test]
fn a_run_that_fails_in_its_first_step_writes_nothing() {
    let (folder, _file) = unruly::file();
    let arguments =
        ["simulate", "Unruly.fmu", "--stop", "1", "--step", "0.5", "--set", "behaviour=5", "--out", "r.csv"];
    let (_, errors) = ended(folder.path(), 1, &arguments);
    assert!(errors.contains("gave up") && errors.contains("nothing was written"), "{errors}");
    assert!(!folder.path().join("r.csv").exists());
}

#[test]
fn discarded_steps_are_repeated_shorter_or_reported() {
    let (folder, _file) = unruly::file();
    let arguments =
        ["simulate", "Unruly.fmu", "--stop", "1", "--step", "0.1", "--set", "behaviour=4", "--out", "r.csv"];
    let (out, _) = ended(folder.path(), 1, &arguments);
    assert!(out.contains("gave up") && out.contains("0.45"), "{out}");
}
