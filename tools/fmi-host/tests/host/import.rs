//! What an archive, a description or a library can do wrong.
#![cfg(target_os = "linux")]

use std::io::{Cursor, Write};
use std::sync::Arc;

use stickslip::cosim::{Severity, Slave as _, Stepped};
use stickslip_fmi_host::{Fmu, ImportError, ImportProblem, platforms};
use stickslip_readers::archive::{ArchiveProblem, Limits, unpack};
use zip::ZipWriter;
use zip::write::SimpleFileOptions;

use crate::unruly::{self, DESCRIPTION, archive, written};

fn opened(bytes: &[u8]) -> Result<Arc<Fmu>, ImportError> {
    let (_folder, file) = written("Broken.fmu", bytes);
    Fmu::open(&file)
}

/// The problem with these bytes; the message must name the file.
fn problem(bytes: &[u8]) -> ImportProblem {
    let error = opened(bytes).unwrap_err();
    assert!(error.to_string().contains("Broken.fmu"), "{error}");
    error.problem
}

/// An archive with the description changed, and a library that is none.
fn described(change: impl Fn(&str) -> String) -> Vec<u8> {
    let binary = format!("binaries/{}/Unruly.so", platforms()[0]);
    archive(&[("modelDescription.xml", change(DESCRIPTION).as_bytes()), (&binary, b"no library")])
}

#[test]
fn a_description_in_latin_1_is_read_as_the_same() {
    let binary = format!("binaries/{}/Unruly.so", platforms()[0]);
    let text = DESCRIPTION.replace("\"UTF-8\"", "\"ISO-8859-1\"").replace("name=\"y\"", "name=\"Größe µ\"");
    let latin: Vec<u8> = text.chars().map(|letter| u8::try_from(letter).unwrap()).collect();
    let fmu = opened(&archive(&[("modelDescription.xml", &latin), (&binary, b"no library")])).unwrap();
    assert!(fmu.description().position("Größe µ").is_some());
}

#[test]
fn every_cut_of_an_archive_is_refused() {
    let whole = described(str::to_owned);
    assert!(opened(&whole).is_ok());
    for length in (0..whole.len()).step_by(7) {
        assert!(opened(&whole[..length]).is_err(), "{length} bytes");
    }
}

#[test]
fn no_damaged_byte_makes_it_panic_or_write_elsewhere() {
    let whole = described(str::to_owned);
    for at in (0..whole.len()).step_by(5) {
        let mut bytes = whole.clone();
        bytes[at] ^= 0x55;
        let _ = opened(&bytes);
    }
    let damaged = {
        let mut bytes = archive(&[("modelDescription.xml", &DESCRIPTION.as_bytes().repeat(20))]);
        bytes[200] ^= 1;
        bytes
    };
    assert!(matches!(problem(&damaged), ImportProblem::Archive(ArchiveProblem::Entry { .. })));
}

#[test]
fn names_that_lead_outside_are_refused() {
    for name in
        ["../evil", "a/../../evil", "/etc/evil", "C:/evil", "..\\evil", "\\evil", "a/b/../../../evil", ""]
    {
        // The writer itself refuses nothing.
        let bytes = archive(&[("modelDescription.xml", DESCRIPTION.as_bytes()), (name, b"x")]);
        let (folder, file) = written("Broken.fmu", &bytes);
        let error = unpack(&file, Limits::default());
        assert!(matches!(error, Err(ArchiveProblem::Escapes(_))), "{name}: {error:?}");
        assert!(
            !folder.path().join("evil").exists() && !folder.path().parent().unwrap().join("evil").exists()
        );
    }
}

#[test]
fn links_are_not_followed() {
    let mut writer = ZipWriter::new(Cursor::new(Vec::new()));
    writer.add_symlink("resources", "/etc", SimpleFileOptions::default()).unwrap();
    writer.start_file("resources/evil", SimpleFileOptions::default()).unwrap();
    writer.write_all(b"x").unwrap();
    let bytes = writer.finish().unwrap().into_inner();
    assert!(matches!(problem(&bytes), ImportProblem::Archive(ArchiveProblem::Link(_))));
}

#[test]
fn huge_expansions_stop_at_the_limit() {
    let zeros = vec![0; 8 << 20];
    let (_folder, file) = written("Bomb.fmu", &archive(&[("a", &zeros), ("b", &zeros)]));
    assert!(std::fs::metadata(&file).unwrap().len() < 100_000);
    let limits = Limits { bytes: 10 << 20, ..Limits::default() };
    assert!(matches!(unpack(&file, limits), Err(ArchiveProblem::TooLarge(_))));
    assert!(unpack(&file, Limits::default()).is_ok());
    let limits = Limits { entries: 1, ..Limits::default() };
    assert!(matches!(unpack(&file, limits), Err(ArchiveProblem::TooLarge(_))));
}

#[test]
fn what_is_missing_is_named() {
    assert!(matches!(problem(&archive(&[("a", b"b")])), ImportProblem::NoDescription));
    let only =
        archive(&[("modelDescription.xml", DESCRIPTION.as_bytes()), ("binaries/win64/Unruly.dll", b"MZ")]);
    match problem(&only) {
        ImportProblem::NoBinary { wanted, present } => {
            assert_eq!((wanted.ends_with("Unruly.so"), present.as_str()), (true, "win64"));
        }
        other => panic!("{other}"),
    }
    let exchange = described(|text| text.replace("CoSimulation", "ModelExchange"));
    assert!(matches!(problem(&exchange), ImportProblem::NoCoSimulation));
    let other_version = described(|text| text.replace("fmiVersion=\"2.0\"", "fmiVersion=\"4.0\""));
    assert!(matches!(problem(&other_version), ImportProblem::Version(version) if version == "4.0"));
    let escaping = described(|text| text.replace("\"Unruly\" can", "\"../../Unruly\" can"));
    assert!(matches!(problem(&escaping), ImportProblem::NoBinary { .. }));
    assert!(Fmu::open("nowhere.fmu".as_ref()).unwrap_err().to_string().contains("nowhere.fmu"));
}

#[test]
fn faults_in_the_description_point_at_their_line() {
    let cases = [
        (r#"guid="unruly-guid""#, "", 2),
        (r#"valueReference="1""#, "", 18),
        (r#"valueReference="1""#, r#"valueReference="-1""#, 18),
        (r#"name="y""#, r#"name="u""#, 18),
        (r#"causality="output""#, r#"causality="exit""#, 18),
        (r#"index="3""#, r#"index="99""#, 25),
        (r#"dependencies="""#, r#"dependencies="1 x""#, 25),
        ("<Real/>", "", 18),
        (r#"kg="1""#, r#"kg="one""#, 5),
        ("</ModelVariables>", "", 27),
    ];
    for (old, new, line) in cases {
        assert!(DESCRIPTION.contains(old), "{old}");
        match problem(&described(|text| text.replacen(old, new, 1))) {
            ImportProblem::Description(error) => {
                assert_eq!(error.line(), Some(line), "{old} -> {new}: {error}");
            }
            other => panic!("{old} -> {new}: {other}"),
        }
    }
}

#[test]
fn a_library_that_is_none_is_refused_and_the_folder_removed() {
    let fmu = opened(&described(str::to_owned)).unwrap();
    let folder = fmu.folder().to_owned();
    let error = fmu.instantiate("one").unwrap_err();
    assert!(matches!(error.problem, ImportProblem::Library(_)), "{error}");
    drop(fmu);
    assert!(!folder.exists());
}

/// An FMU with this library; what it says when it is to be run.
fn loaded(library: &[u8]) -> Result<(), String> {
    let binary = format!("binaries/{}/Unruly.so", platforms()[0]);
    let fmu =
        opened(&archive(&[("modelDescription.xml", DESCRIPTION.as_bytes()), (&binary, library)])).unwrap();
    fmu.instantiate("one").map(drop).map_err(|error| error.to_string())
}

#[test]
fn a_library_that_is_cut_off_is_refused_before_the_system_maps_it() {
    let whole = unruly::library();
    assert_eq!(loaded(&whole), Ok(()));
    // Behind the last segment are tables that nobody needs at run time.
    for length in (0..whole.len() / 2).step_by(whole.len() / 40) {
        let error = loaded(&whole[..length]).unwrap_err();
        assert!(error.starts_with("Broken.fmu") || error.contains("Broken.fmu: "), "{error}");
        assert!(error.contains("get the FMU again"), "{length}: {error}");
    }
    let mut zeros = whole.clone();
    zeros[0x1000..].fill(0);
    assert!(loaded(&zeros).unwrap_err().contains("table of symbols"));
}

#[test]
fn a_library_for_another_computer_or_none_is_reported_as_such() {
    let with = |at: usize, byte: u8| {
        let mut library = unruly::library();
        library[at] = byte;
        loaded(&library).unwrap_err()
    };
    assert!(with(18, 40).contains("is for arm, this program for x86_64"), "{}", with(18, 40));
    assert!(with(16, 2).contains("a program or an object file"), "{}", with(16, 2));
    assert!(with(0, b'M').contains("does not begin like a library"), "{}", with(0, b'M'));
}

#[test]
fn a_wrong_guid_is_refused_in_the_words_of_the_fmu() {
    let binary = format!("binaries/{}/Unruly.so", platforms()[0]);
    let description = DESCRIPTION.replace("unruly-guid", "other-guid");
    let bytes = archive(&[("modelDescription.xml", description.as_bytes()), (&binary, &unruly::library())]);
    let fmu = opened(&bytes).unwrap();
    let error = fmu.instantiate("one").unwrap_err();
    for words in ["the GUID is not other-guid", "export the FMU again"] {
        assert!(error.to_string().contains(words), "{error}");
    }
}

#[test]
fn an_fmu_that_allows_one_instance_gets_one_at_a_time() {
    let binary = format!("binaries/{}/Unruly.so", platforms()[0]);
    let description =
        DESCRIPTION.replace("<CoSimulation ", "<CoSimulation canBeInstantiatedOnlyOncePerProcess=\"true\" ");
    let library = unruly::library();
    let bytes = archive(&[("modelDescription.xml", description.as_bytes()), (&binary, &library)]);
    let (fmu, copy) = (opened(&bytes).unwrap(), opened(&bytes).unwrap());
    let first = fmu.instantiate("one").unwrap();
    assert!(matches!(copy.instantiate("two").unwrap_err().problem, ImportProblem::OncePerProcess));
    drop(first);
    assert!(copy.instantiate("two").is_ok());
}

#[test]
fn variables_come_with_types_units_and_dependencies() {
    let (_folder, file) = unruly::file();
    let fmu = Fmu::open(&file).unwrap();
    let slave = fmu.instantiate("one").unwrap();
    let names: Vec<&str> = slave.variables().iter().map(|row| &*row.name).collect();
    assert_eq!(names, ["u", "y", "behaviour", "flag"], "texts are not among the numbers");
    assert_eq!(slave.variables()[1].depends_on.as_deref(), Some(&[][..]));
    assert_eq!(slave.variables()[0].unit.as_deref(), Some("N"));
    assert_eq!(slave.variables()[3].start, Some(0.0));
    let description = fmu.description();
    // A million variables have room because what describes them and the master's table share their texts.
    assert!(Arc::ptr_eq(&description.variables[0].name, &slave.variables()[0].name));
    assert!(Arc::ptr_eq(
        description.variables[0].unit.as_ref().unwrap(),
        slave.variables()[0].unit.as_ref().unwrap()
    ));
    let unit = description.unit(&description.variables[0]).unwrap();
    assert_eq!(unit.exponents.unwrap()[..3], [1, 1, -2]);
}

#[test]
fn discarded_steps_report_how_far_they_came_and_shorter_ones_succeed() {
    let (_folder, file) = unruly::file();
    let fmu = Fmu::open(&file).unwrap();
    let mut slave = unruly::running(&fmu, unruly::DISCARD);
    assert_eq!(slave.do_step(0.0, 0.4).unwrap(), Stepped::Done);
    match slave.do_step(0.4, 0.1).unwrap() {
        Stepped::Discarded(time) => assert!((time - 0.45).abs() < 1e-12),
        other => panic!("{other:?}"),
    }
    assert_eq!(slave.do_step(0.4, 0.02).unwrap(), Stepped::Done);
    let mut slave = unruly::running(&fmu, unruly::END);
    let error = slave.do_step(0.4, 0.1).unwrap_err();
    assert!(error.message.contains("end of the simulation"), "{}", error.message);
}

#[test]
fn errors_name_the_fmu_the_variable_and_the_fmus_own_words() {
    let (_folder, file) = unruly::file();
    let fmu = Fmu::open(&file).unwrap();
    let mut slave = unruly::running(&fmu, unruly::FAIL);
    let error = slave.set(&[0], &[2e6]).unwrap_err();
    assert_eq!(error.severity, Severity::Call);
    for word in ["unruly", "`u`", "Unruly.fmu", "u = 2e+06 is more than 1000000"] {
        assert!(error.to_string().contains(word), "{word}: {error}");
    }
    assert!(slave.set(&[2], &[0.5]).unwrap_err().message.contains("`behaviour` is a whole number"));
    assert!(slave.get(&[99], &mut [0.0]).is_err());
    assert!(slave.restore(0).unwrap_err().message.contains("slot 0"));
    let error = slave.do_step(0.4, 0.1).unwrap_err();
    assert_eq!(error.severity, Severity::Slave);
    assert!(error.message.contains("unruly gave up at 0.40 s"), "{}", error.message);
    slave.terminate().unwrap();
}

#[test]
fn after_a_fatal_error_nothing_is_called() {
    let (_folder, file) = unruly::file();
    let fmu = Fmu::open(&file).unwrap();
    let mut slave = unruly::running(&fmu, unruly::FATAL);
    let error = slave.do_step(0.4, 0.1).unwrap_err();
    assert_eq!(error.severity, Severity::Fatal);
    assert!(error.message.contains("100 % lost"), "{}", error.message);
    assert_eq!(slave.get(&[1], &mut [0.0]).unwrap_err().severity, Severity::Fatal);
}

#[test]
fn a_flood_of_messages_is_kept_within_bounds() {
    let (_folder, file) = unruly::file();
    let fmu = Fmu::open(&file).unwrap();
    let mut slave = unruly::running(&fmu, unruly::FLOOD);
    for step in 0..40 {
        slave.do_step(f64::from(step) * 0.01, 0.01).unwrap();
    }
    assert!(slave.log().messages().len() <= 200);
    assert_eq!(slave.log().forgotten(), 40_000 - 200);
    assert_eq!(slave.log().messages().last().unwrap().text, "message 999 at 0.390000");
    slave.set_text("note", "µ").unwrap();
    assert_eq!(slave.text("note").unwrap(), "µ");
    assert!(slave.set_text("u", "1").is_err());
}
