//! FMUs of FMI 3.0: every type of variable, arrays, inputs told within steps, and what is refused.
#![cfg(target_os = "linux")]

use std::sync::Arc;

use stickslip::cosim::{Causality, Kind, Severity, Slave, Stepped};
use stickslip_fmi_host::{FmiVersion, Fmu, FmuSlave, ImportProblem, ModelDescription, TypeOfVariable};

use crate::kinds::{self, DESCRIPTION, beginning};
use crate::unruly::{archive, written};

fn opened() -> (tempfile::TempDir, Arc<Fmu>) {
    let (folder, file) = kinds::file();
    (folder, Fmu::open(&file).unwrap())
}

fn position(slave: &FmuSlave, name: &str) -> usize {
    slave.variables().iter().position(|row| *row.name == *name).unwrap_or_else(|| panic!("{name}"))
}

fn positions(slave: &FmuSlave, names: &[&str]) -> Vec<usize> {
    names.iter().map(|name| position(slave, name)).collect()
}

/// The least and the largest value of every type, and one beyond.
const NUMBERS: [(&str, f64, f64, f64); 11] = [
    ("f64", -1.5e5, 3.25, f64::NAN),
    ("f32", -0.5, 1.5e5, f64::NAN),
    ("i8", -128.0, 127.0, 128.0),
    ("u8", 0.0, 255.0, -1.0),
    ("i16", -32768.0, 32767.0, 32768.0),
    ("u16", 0.0, 65535.0, 65536.0),
    ("i32", -2147483648.0, 2147483647.0, 2147483648.0),
    ("u32", 0.0, 4294967295.0, 4294967296.0),
    ("i64", -9007199254740992.0, 9007199254740992.0, 1e19),
    ("u64", 0.0, 9007199254740992.0, 2e19),
    ("mode", 1.0, 4.0, 1.5),
];

#[test]
fn numbers_of_every_type_go_in_and_come_out() {
    let (_folder, fmu) = opened();
    let mut slave = beginning(&fmu);
    slave.exit_initialization().unwrap();
    let of = |way: &str| NUMBERS.map(|(name, ..)| format!("{way}_{name}"));
    let inputs: Vec<usize> = of("in").iter().map(|name| position(&slave, name)).collect();
    let outputs: Vec<usize> = of("out").iter().map(|name| position(&slave, name)).collect();
    for (round, values) in [NUMBERS.map(|row| row.1), NUMBERS.map(|row| row.2)].into_iter().enumerate() {
        slave.set(&inputs, &values).unwrap();
        assert_eq!(slave.do_step(0.1 * round as f64, 0.1).unwrap(), Stepped::Done);
        let mut found = [0.0; NUMBERS.len()];
        slave.get(&outputs, &mut found).unwrap();
        assert_eq!(found, values);
    }
    for (number, (name, .., beyond)) in NUMBERS.iter().enumerate().filter(|(_, row)| !row.3.is_nan()) {
        let error = slave.set(&[inputs[number]], &[*beyond]).unwrap_err();
        assert!(error.message.contains(&format!("in_{name}")), "{error:?}");
        assert_eq!(error.severity, Severity::Call);
    }
    let (flag, out) = (position(&slave, "in_boolean"), position(&slave, "out_boolean"));
    let mut found = [9.0];
    for value in [1.0, 0.0] {
        slave.set(&[flag], &[value]).unwrap();
        slave.do_step(0.2 + 0.1 * (1.0 - value), 0.1).unwrap();
        slave.get(&[out], &mut found).unwrap();
        assert_eq!(found, [value]);
    }
    slave.set_text("text", "größer").unwrap();
    assert_eq!(slave.text("text").unwrap(), "größer");
}

#[test]
fn elements_of_an_array_are_variables_and_the_others_stay() {
    let (_folder, fmu) = opened();
    let mut slave = beginning(&fmu);
    let inputs = positions(&slave, &["in_list[1]", "in_list[2]", "in_list[3]"]);
    let starts: Vec<_> = inputs.iter().map(|row| slave.variables()[*row].start).collect();
    assert_eq!(starts, [Some(1.0), Some(2.0), Some(3.0)]);
    slave.set(&[inputs[1]], &[7.0]).unwrap();
    slave.exit_initialization().unwrap();
    // Between others, and out of order.
    let read = positions(&slave, &["out_list[3]", "out_f64", "out_list[1]", "out_list[2]"]);
    let mut found = [0.0; 4];
    slave.get(&read, &mut found).unwrap();
    assert_eq!(found, [3.0, 1.0, 1.0, 7.0]);
    slave.set(&inputs, &[4.0, 5.0, 6.0]).unwrap();
    slave.set(&[position(&slave, "in_f64"), inputs[0]], &[2.0, -1.0]).unwrap();
    slave.do_step(0.0, 0.1).unwrap();
    slave.get(&read, &mut found).unwrap();
    assert_eq!(found, [6.0, 2.0, -1.0, 5.0]);
    // An output of an array depends on all of the array it is declared to depend on.
    let row = &slave.variables()[position(&slave, "out_list[2]")];
    assert_eq!(row.depends_on.as_deref(), Some(&inputs[..]));
    assert_eq!((row.kind, row.causality), (Kind::Real, Causality::Output));
}

#[test]
fn the_description_is_read_with_declared_types_aliases_and_structural_parameters() {
    let (_folder, fmu) = opened();
    let description = fmu.description();
    assert_eq!((description.version, description.guid.as_str()), (FmiVersion::Three, "kinds-token"));
    let row = |name: &str| &description.variables[description.position(name).unwrap()];
    assert_eq!(row("in_f64").unit.as_deref(), Some("N"));
    let items = vec![("off".to_owned(), 1), ("on".to_owned(), 4)];
    assert_eq!(row("in_mode").kind, TypeOfVariable::Enumeration(items.into()));
    assert_eq!((row("same_f64").reference, row("same_f64").causality), (101, Causality::Local));
    assert_eq!(description.dependencies[&description.position("level").unwrap()][..], []);
    assert_eq!(row("in_list[3]").passed.size, 3);
    let slave = fmu.instantiate("one").unwrap();
    // Inputs that change at events only are not asked for within steps, and one is not enough.
    assert!(slave.abilities().saves_state && !slave.abilities().interpolates_inputs);
}

/// A description with an output and an input that are arrays of half a million elements each, and what is `told` of outputs.
fn with_long_arrays(told: &str) -> Result<ModelDescription, ImportProblem> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("modelDescription.xml");
    let array = |name: &str, reference: u32, causality: &str| {
        format!(
            "<Float64 name=\"{name}\" valueReference=\"{reference}\" causality=\"{causality}\" start=\"0\">\
             <Dimension start=\"499000\"/></Float64>"
        )
    };
    let text = format!(
        "<fmiModelDescription fmiVersion=\"3.0\" instantiationToken=\"t\"><CoSimulation modelIdentifier=\"T\"/>\
         <ModelVariables>{}{}<Float64 name=\"y\" valueReference=\"3\" causality=\"output\"/></ModelVariables>\
         <ModelStructure>{told}</ModelStructure></fmiModelDescription>",
        array("u", 1, "input"),
        array("v", 2, "output"),
    );
    std::fs::write(&path, text).unwrap();
    ModelDescription::read(&path)
}

#[test]
fn a_few_words_about_long_arrays_take_no_more_memory_than_the_arrays() {
    let told = "<Output valueReference=\"2\" dependencies=\"1 1\"/><Output valueReference=\"3\" dependencies=\"1\"/>";
    let description = with_long_arrays(told).unwrap();
    let dependencies = &description.dependencies;
    assert_eq!((dependencies.len(), dependencies[&499_000].len()), (499_001, 499_000));
    assert!(Arc::ptr_eq(&dependencies[&499_000], &dependencies[&997_999]));
    let Err(ImportProblem::Description(error)) =
        with_long_arrays(&"<Output valueReference=\"3\" dependencies=\"1\"/>".repeat(30))
    else {
        panic!("15 million dependencies in 2 kB");
    };
    assert!(error.render(false).contains("fit in memory"), "{}", error.render(false));
}

#[test]
fn a_saved_state_is_gone_back_to_and_the_end_that_the_fmu_wants_is_an_error() {
    let (_folder, fmu) = opened();
    let mut slave = beginning(&fmu);
    slave.set(&[position(&slave, "limit")], &[0.25]).unwrap();
    slave.exit_initialization().unwrap();
    let (input, output) = (position(&slave, "in_f64"), position(&slave, "out_f64"));
    slave.set(&[input], &[5.0]).unwrap();
    slave.do_step(0.0, 0.1).unwrap();
    slave.save(0).unwrap();
    slave.set(&[input], &[6.0]).unwrap();
    slave.do_step(0.1, 0.1).unwrap();
    slave.restore(0).unwrap();
    let mut found = [0.0];
    slave.get(&[output], &mut found).unwrap();
    assert_eq!(found, [5.0]);
    slave.do_step(0.1, 0.1).unwrap();
    let error = slave.do_step(0.2, 0.1).unwrap_err();
    assert!(error.message.contains("asks for the end of the simulation"), "{error:?}");
}

#[test]
fn what_the_fmu_says_is_heard_and_names_its_variables() {
    let (_folder, fmu) = opened();
    let mut slave = beginning(&fmu);
    slave.exit_initialization().unwrap();
    let error = slave.set(&[position(&slave, "in_f64")], &[2e6]).unwrap_err();
    assert!(error.message.contains("fmi3SetFloat64 returned Discard"), "{error:?}");
    assert!(error.message.contains("in_f64 is more than 1e6"), "{error:?}");
    assert_eq!(error.severity, Severity::Call);
    let error = slave.set(&[position(&slave, "level")], &[0.0]).unwrap_err();
    assert!(error.message.contains("cannot be set"), "{error:?}");
    assert_eq!(error.severity, Severity::Slave);
}

/// With all other inputs discrete ones of other types gone, `rate` alone is asked for.
fn with_rate_alone() -> (tempfile::TempDir, Arc<Fmu>) {
    let fewer: Vec<&str> = DESCRIPTION
        .lines()
        .filter(|line| !["in_f64", "in_f32", "in_list", "out_list"].iter().any(|name| line.contains(name)))
        .filter(|line| !["\"101\" dep", "\"102\" dep", "\"113\" dep"].iter().any(|text| line.contains(text)))
        .collect();
    let binary = "binaries/x86_64-linux/Kinds.so";
    let bytes =
        archive(&[("modelDescription.xml", fewer.join("\n").as_bytes()), (binary, &kinds::library())]);
    let (folder, file) = written("Kinds.fmu", &bytes);
    (folder, Fmu::open(&file).unwrap())
}

#[test]
#[cfg(target_arch = "x86_64")]
fn inputs_with_derivatives_are_told_within_the_step_as_they_run() {
    let (_folder, fmu) = with_rate_alone();
    let mut slave = beginning(&fmu);
    assert!(slave.abilities().interpolates_inputs);
    assert_eq!(slave.abilities().input_derivative_order, 3);
    slave.exit_initialization().unwrap();
    let (rate, level) = (position(&slave, "rate"), position(&slave, "level"));
    // 1 + 2 t + 3 t² − t³, whose trapezoidal sum over ten parts of a step of 1 s is known.
    slave.set(&[rate], &[1.0]).unwrap();
    for (order, value) in [(1, 2.0), (2, 6.0), (3, -6.0)] {
        slave.set_input_derivatives(&[rate], order, &[value]).unwrap();
    }
    slave.do_step(0.0, 1.0).unwrap();
    let course = |t: f64| 1.0 + t * (2.0 + t * (3.0 - t));
    let sum: f64 =
        (0..10).map(|k| 0.05 * (course(f64::from(k) / 10.0) + course(f64::from(k + 1) / 10.0))).sum();
    let mut found = [0.0; 2];
    slave.get(&[level, rate], &mut found).unwrap();
    assert!((found[0] - sum).abs() < 1e-12 && (found[1] - 5.0).abs() < 1e-12, "{found:?} {sum}");
    // They held for one step.
    slave.do_step(1.0, 1.0).unwrap();
    slave.get(&[level, rate], &mut found).unwrap();
    assert!((found[0] - sum - 5.0).abs() < 1e-12, "{found:?}");
}

#[test]
fn clocks_other_tokens_and_descriptions_that_contradict_themselves_are_refused() {
    let described = |change: &dyn Fn(&str) -> String| {
        let binary = "binaries/x86_64-linux/Kinds.so";
        let xml = change(DESCRIPTION);
        let bytes = archive(&[("modelDescription.xml", xml.as_bytes()), (binary, &kinds::library())]);
        let (_folder, file) = written("Kinds.fmu", &bytes);
        Fmu::open(&file).and_then(|fmu| fmu.instantiate("one").map(drop)).map_err(|error| error.problem)
    };
    assert!(described(&|xml| xml.to_owned()).is_ok());
    let refused = |from: &str, to: &str| {
        assert!(DESCRIPTION.contains(from), "{from}");
        described(&|xml| xml.replacen(from, to, 1)).unwrap_err()
    };
    let clock =
        r#"<Clock name="tick" valueReference="30" causality="input" intervalVariability="constant"/>"#;
    assert!(matches!(
        refused("<ModelVariables>", &format!("<ModelVariables>{clock}")),
        ImportProblem::Clocks(name) if name == "tick"
    ));
    assert!(matches!(
        refused("kinds-token", "another"),
        ImportProblem::Instantiate(Some(words)) if words.contains("instantiationToken")
    ));
    assert!(matches!(refused(r#"fmiVersion="3.0""#, r#"fmiVersion="3.1""#), ImportProblem::Version(_)));
    for (from, to) in [
        (r#"name="in_f32""#, r#"name="in_f64""#),
        (r#"<Dimension valueReference="20"/>"#, r#"<Dimension valueReference="21"/>"#),
        (r#"<Dimension start="3"/>"#, r#"<Dimension start="4000000000"/>"#),
        (r#"<Output valueReference="103"/>"#, r#"<Output valueReference="999"/>"#),
        (r#"dependencies="13""#, r#"dependencies="998""#),
        (r#"causality="output" variability="continuous""#, r#"causality="exit" variability="continuous""#),
    ] {
        assert!(matches!(refused(from, to), ImportProblem::Description(_)), "{to}");
    }
}
