//! System structures: what they say, and where they are wrong.

use std::path::{Path, PathBuf};

use stickslip_readers::ssp::{
    End, Outline, OutlineComponent, OutlineConnection, OutlineConnector, OutlineParameter, SspProblem,
    SystemStructure, Value, read,
};
use stickslip_readers::units::{Linear, Unit};
use stickslip_readers::{InputError, Problem};
use tempfile::TempDir;

const HEAD: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<ssd:SystemStructureDescription version="1.0" name="test"
  xmlns:ssd="http://ssp-standard.org/SSP1/SystemStructureDescription"
  xmlns:ssc="http://ssp-standard.org/SSP1/SystemStructureCommon"
  xmlns:ssv="http://ssp-standard.org/SSP1/SystemStructureParameterValues"
  xmlns:ssm="http://ssp-standard.org/SSP1/SystemStructureParameterMapping">
"#;

const UNITS: &str = r#"<ssd:Units>
  <ssc:Unit name="m"><ssc:BaseUnit m="1"/></ssc:Unit>
  <ssc:Unit name="mm"><ssc:BaseUnit m="1" factor="0.001"/></ssc:Unit>
  <ssc:Unit name="s"><ssc:BaseUnit s="1"/></ssc:Unit>
</ssd:Units>
"#;

pub fn component(name: &str, connectors: &[(&str, &str, &str)], rest: &str) -> String {
    let connectors: String = connectors
        .iter()
        .map(|(name, kind, unit)| {
            let typed = if unit.is_empty() { String::new() } else { format!("<ssc:Real unit=\"{unit}\"/>") };
            format!("<ssd:Connector name=\"{name}\" kind=\"{kind}\">{typed}</ssd:Connector>\n")
        })
        .collect();
    format!(
        "<ssd:Component name=\"{name}\" source=\"{name}.fmu\"><ssd:Connectors>\n{connectors}</ssd:Connectors>{rest}</ssd:Component>\n"
    )
}

pub fn document(system: &str) -> String {
    format!(
        "{HEAD}<ssd:System name=\"root\">\n{system}</ssd:System>\n{UNITS}<ssd:DefaultExperiment startTime=\"0\" stopTime=\"0.5\"/>\n</ssd:SystemStructureDescription>\n"
    )
}

pub fn written(text: &str) -> (TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    for fmu in ["a.fmu", "b.fmu", "c.fmu"] {
        std::fs::write(folder.path().join(fmu), "").unwrap();
    }
    let file = folder.path().join("system.ssd");
    std::fs::write(&file, text).unwrap();
    (folder, file)
}

pub fn system(text: &str) -> Result<SystemStructure, InputError> {
    let (_folder, file) = written(text);
    read(file)
}

pub fn connection(start: &str, end: &str, rest: &str) -> String {
    let side = |name: &str, prefix: &str| match name.split_once('.') {
        Some((element, connector)) => {
            format!("{prefix}Element=\"{element}\" {prefix}Connector=\"{connector}\"")
        }
        None => format!("{prefix}Connector=\"{name}\""),
    };
    format!("<ssd:Connection {} {} {rest}\n", side(start, "start"), side(end, "end"))
}

/// Two components that exchange `x` and `f`.
pub fn pair(connections: &str) -> String {
    let a = component("a", &[("x", "output", "m"), ("f", "input", "")], "");
    let b = component("b", &[("x", "input", "mm"), ("f", "output", "")], "");
    format!("<ssd:Elements>{a}{b}</ssd:Elements><ssd:Connections>{connections}</ssd:Connections>")
}

#[test]
fn a_pair_is_read_with_its_units_whichever_way_the_connections_are_written() {
    for order in [["a.x", "b.x", "b.f", "a.f"], ["b.x", "a.x", "a.f", "b.f"]] {
        let connections = connection(order[0], order[1], "/>") + &connection(order[2], order[3], "/>");
        let system = system(&document(&pair(&connections))).unwrap();
        assert_eq!((system.start, system.stop), (Some(0.0), Some(0.5)));
        assert_eq!(system.remarks, Vec::<String>::new());
        let x = system.connections.iter().find(|one| one.to.variable == "x").unwrap();
        assert_eq!((x.from.component, x.to.component), (0, 1));
        let linear = x.route.linear(None, None).unwrap();
        assert!((linear.apply(0.002) - 2.0).abs() < 1e-12);
        let f = system.connections.iter().find(|one| one.to.variable == "f").unwrap();
        assert_eq!(f.route.linear(None, None).unwrap(), Linear::IDENTITY);
    }
}

#[test]
fn suppressed_conversion_and_transformations_do_what_they_say() {
    let inside = "><ssc:LinearTransformation factor=\"3\" offset=\"1\"/></ssd:Connection>";
    for (suppress, expected) in [("true", 3.0 * 0.002 + 1.0), ("false", 3.0 * 2.0 + 1.0)] {
        let rest = format!("suppressUnitConversion=\"{suppress}\"{inside}");
        let system = system(&document(&pair(&connection("a.x", "b.x", &rest)))).unwrap();
        let linear = system.connections[0].route.linear(None, None).unwrap();
        assert!((linear.apply(0.002) - expected).abs() < 1e-12, "{suppress}");
    }
}

pub fn nested() -> String {
    let inner = format!(
        "<ssd:System name=\"rig\"><ssd:Connectors><ssd:Connector name=\"drive\" kind=\"input\"/><ssd:Connector name=\"shown\" kind=\"output\"><ssc:Real unit=\"mm\"/></ssd:Connector></ssd:Connectors>\
         <ssd:ParameterBindings><ssd:ParameterBinding><ssd:ParameterValues><ssv:ParameterSet version=\"1.0\" name=\"p\"><ssv:Parameters>\
         <ssv:Parameter name=\"a.k\"><ssv:Real value=\"1\"/></ssv:Parameter><ssv:Parameter name=\"drive\"><ssv:Real value=\"5\" unit=\"mm\"/></ssv:Parameter>\
         </ssv:Parameters></ssv:ParameterSet></ssd:ParameterValues></ssd:ParameterBinding></ssd:ParameterBindings>\
         <ssd:Elements>{}{}</ssd:Elements><ssd:Connections>{}{}{}</ssd:Connections></ssd:System>",
        component("a", &[("u", "input", "mm"), ("y", "output", "m")], ""),
        component("b", &[("u", "input", "m"), ("y", "output", "m")], ""),
        connection("drive", "a.u", "/>"),
        connection("a.y", "b.u", "/>"),
        connection("shown", "b.y", "/>"),
    );
    format!(
        "<ssd:Connectors><ssd:Connector name=\"in\" kind=\"input\"><ssc:Real unit=\"m\"/></ssd:Connector><ssd:Connector name=\"out\" kind=\"output\"/></ssd:Connectors>\
         <ssd:ParameterBindings><ssd:ParameterBinding prefix=\"rig.\"><ssd:ParameterValues><ssv:ParameterSet version=\"1.0\" name=\"p\"><ssv:Parameters>\
         <ssv:Parameter name=\"stiff\"><ssv:Real value=\"2\"/></ssv:Parameter><ssv:Parameter name=\"stray\"><ssv:Real value=\"2\"/></ssv:Parameter>\
         </ssv:Parameters></ssv:ParameterSet></ssd:ParameterValues><ssd:ParameterMapping><ssm:ParameterMapping version=\"1.0\">\
         <ssm:MappingEntry source=\"rig.stiff\" target=\"rig.a.k\"><ssc:LinearTransformation factor=\"10\"/></ssm:MappingEntry></ssm:ParameterMapping></ssd:ParameterMapping></ssd:ParameterBinding></ssd:ParameterBindings>\
         <ssd:Elements>{inner}{}</ssd:Elements><ssd:Connections>{}{}{}</ssd:Connections>",
        component("c", &[("u", "input", "")], ""),
        connection("in", "rig.drive", "/>"),
        connection("rig.shown", "c.u", "/>"),
        connection("rig.shown", "out", "/>"),
    )
}

#[test]
fn nested_systems_become_one() {
    let system = system(&document(&nested())).unwrap();
    let names: Vec<&str> = system.components.iter().map(|component| component.name.as_str()).collect();
    assert_eq!(names, ["rig.a", "rig.b", "c"]);
    let ends: Vec<(usize, usize)> =
        system.connections.iter().map(|one| (one.from.component, one.to.component)).collect();
    assert_eq!(ends, [(0, 1), (1, 2)]);
    // b.y in metres comes out of the rig in millimetres; c says nothing.
    let through = system.connections[1].route.linear(None, None).unwrap();
    assert!((through.apply(0.003) - 3.0).abs() < 1e-12);
    assert_eq!(system.inputs[0].name, "in");
    let (end, route) = &system.inputs[0].targets[0];
    assert_eq!(*end, End { component: 0, variable: "u".to_owned() });
    assert!((route.linear(None, None).unwrap().apply(0.003) - 3.0).abs() < 1e-12);
    assert_eq!((system.outputs[0].name.as_str(), system.outputs[0].from.component), ("out", 1));
}

#[test]
fn parameters_find_their_variables_and_the_outer_ones_hold() {
    let system = system(&document(&nested())).unwrap();
    let of = |variable: &str| -> Vec<_> {
        let all = system.parameters.iter();
        all.filter(|one| one.target.variable == variable).collect()
    };
    let k = of("k");
    assert_eq!(k.len(), 2);
    assert_eq!((k[0].value.clone(), k[0].transformation), (Value::Real(1.0), Linear::IDENTITY));
    assert_eq!((k[1].value.clone(), k[1].transformation.factor), (Value::Real(2.0), 10.0));
    let through = of("u");
    assert_eq!(through.len(), 1);
    assert_eq!(through[0].target.component, 0);
    assert_eq!(through[0].unit.as_ref().unwrap().name, "mm");
    assert!(system.remarks.iter().any(|remark| remark.contains("stray")), "{:?}", system.remarks);
}

#[test]
fn what_is_not_in_the_standard_is_remarked_on() {
    let text = document(&pair(&connection("a.x", "b.x", "/>")))
        .replace("<ssd:Elements>", "<v:Gears xmlns:v=\"http://vendor.example\"/><ssd:Elements>");
    let system = system(&text).unwrap();
    assert_eq!(system.remarks.len(), 1);
    assert!(
        system.remarks[0].contains("Gears") && system.remarks[0].starts_with("system.ssd:"),
        "{:?}",
        system.remarks
    );
}

#[test]
fn a_misspelt_element_of_the_standard_is_an_error_that_names_it() {
    let good = document(&pair(&connection("a.x", "b.x", "/>")));
    let without_prefixes = good.replace("<ssd:", "<").replace("</ssd:", "</");
    let bound = document(&nested()).replace("ssv:Parameters>", "ssv:Paramters>");
    for (text, wrong, meant) in [
        (good.replace("ssd:Connections>", "ssd:Conections>"), "Conections", "Connections"),
        (good.replace("ssd:Connection ", "ssd:Conection "), "Conection", "Connection"),
        (without_prefixes.replace("Connections>", "Conections>"), "Conections", "Connections"),
        (bound, "Paramters", "Parameters"),
    ] {
        let error = system(&text).unwrap_err();
        assert!(error.line().is_some_and(|line| line > 7), "{error}");
        let shown = error.render(false);
        assert!(shown.contains(&format!("<{wrong}>")) && shown.contains(&format!("`{meant}`?")), "{shown}");
    }
}

#[test]
fn a_mapping_of_booleans_is_told_from_a_linear_one() {
    let inside = "><ssc:BooleanMappingTransformation><ssc:MapEntry source=\"true\" target=\"false\"/>\
                  <ssc:MapEntry source=\"false\" target=\"true\"/></ssc:BooleanMappingTransformation></ssd:Connection>";
    // The connectors say that they are Real.
    let error = system(&document(&pair(&connection("a.x", "b.x", inside)))).unwrap_err();
    assert!(matches!(&*error.problem, Problem::Ssp(SspProblem::BooleanMapping(_))), "{error}");
    assert!(error.to_string().contains("`b.x`") || error.to_string().contains("`a.x`"), "{error}");
    // These say nothing: who knows the variables can see.
    let system = system(&document(&pair(&connection("b.f", "a.f", inside)))).unwrap();
    assert!(system.connections[0].route.maps_booleans());
    let of_units = self::system(&document(&pair(&connection("a.x", "b.x", "/>")))).unwrap();
    assert!(!of_units.connections[0].route.maps_booleans());
}

#[test]
fn utf_16_is_read_as_the_same() {
    let text = document(&pair(&connection("a.x", "b.x", "/>"))).replace("UTF-8", "UTF-16");
    let little: Vec<u8> =
        std::iter::once(0xfeff).chain(text.encode_utf16()).flat_map(u16::to_le_bytes).collect();
    let big: Vec<u8> =
        std::iter::once(0xfeff).chain(text.encode_utf16()).flat_map(u16::to_be_bytes).collect();
    for bytes in [little, big] {
        let (_folder, file) = written("");
        std::fs::write(&file, bytes).unwrap();
        assert_eq!(read(&file).unwrap().connections.len(), 1);
        std::fs::write(&file, [0xff, 0xfe, 0x00, 0xd8, 0x41]).unwrap();
        let error = read(&file).unwrap_err();
        assert!(error.render(false).contains("UTF-16"), "{error}");
    }
}

#[test]
fn faults_are_typed_and_point_at_their_line() {
    let good = pair(&connection("a.x", "b.x", "/>"));
    type Check = fn(&SspProblem) -> bool;
    let cases: [(String, Check); 12] = [
        (
            good.replace("\"b\" endConnector", "\"nix\" endConnector"),
            |p| matches!(p, SspProblem::UnknownElement(name) if name == "nix"),
        ),
        (good.replace("endConnector=\"x\"", "endConnector=\"nix\""), |p| {
            matches!(p, SspProblem::UnknownConnector { .. })
        }),
        (pair(&connection("a.x", "b.f", "/>")), |p| matches!(p, SspProblem::Direction { .. })),
        (
            pair(&(connection("a.x", "b.x", "/>") + &connection("a.x", "b.x", "/>"))),
            |p| matches!(p, SspProblem::TwoSources(name) if name == "b.x"),
        ),
        (good.replace("name=\"b\" source", "name=\"a\" source"), |p| matches!(p, SspProblem::Twice { .. })),
        (good.replace("a.fmu", "http://x/a.fmu"), |p| matches!(p, SspProblem::Source { .. })),
        (good.replace("a.fmu", "lost.fmu"), |p| matches!(p, SspProblem::Source { .. })),
        (good.replace("kind=\"output\"", "kind=\"inout\""), |p| matches!(p, SspProblem::Unsupported(_))),
        (good.replace("unit=\"mm\"", "unit=\"furlong\""), |p| matches!(p, SspProblem::UnknownUnit(_))),
        (good.replace("source=\"a.fmu\"", "source=\"a.fmu\" type=\"application/x-ssp-package\""), |p| {
            matches!(p, SspProblem::Unsupported(_))
        }),
        (
            good.replace(
                "</ssd:Elements>",
                "<ssd:SignalDictionaryReference name=\"d\" dictionary=\"d\"/></ssd:Elements>",
            ),
            |p| matches!(p, SspProblem::Unsupported(_)),
        ),
        (
            pair(
                "<ssd:Connection startElement=\"a\" startConnector=\"x\" endElement=\"b\" endConnector=\"x\"><ssc:IntegerMappingTransformation/></ssd:Connection>",
            ),
            |p| matches!(p, SspProblem::Unsupported(_)),
        ),
    ];
    for (text, check) in cases {
        let error = system(&document(&text)).unwrap_err();
        assert!(matches!(&*error.problem, Problem::Ssp(problem) if check(problem)), "{error}");
        assert!(error.line().is_some_and(|line| line > 7), "{error}");
        assert!(error.render(false).contains("system.ssd"));
    }
    let version = document(&good).replace("version=\"1.0\" name=\"test\"", "version=\"2.0\" name=\"test\"");
    assert!(matches!(&*system(&version).unwrap_err().problem, Problem::Ssp(SspProblem::Version(_))));
    // The units do not fit: that is told where the FMUs' own are known.
    let system = system(&document(&good.replace("unit=\"mm\"", "unit=\"s\""))).unwrap();
    assert!(system.connections[0].route.linear(None, None).is_err());
}

#[test]
fn connectors_in_a_circle_are_found() {
    let inner = |name: &str| {
        format!(
            "<ssd:System name=\"{name}\"><ssd:Connectors><ssd:Connector name=\"i\" kind=\"input\"/><ssd:Connector name=\"o\" kind=\"output\"/></ssd:Connectors><ssd:Connections>{}</ssd:Connections></ssd:System>",
            connection("i", "o", "/>")
        )
    };
    let text = format!(
        "<ssd:Elements>{}{}{}</ssd:Elements><ssd:Connections>{}{}{}</ssd:Connections>",
        inner("p"),
        inner("q"),
        component("a", &[("u", "input", "")], ""),
        connection("p.o", "q.i", "/>"),
        connection("q.o", "p.i", "/>"),
        connection("q.o", "a.u", "/>"),
    );
    let error = system(&document(&text)).unwrap_err();
    assert!(matches!(&*error.problem, Problem::Ssp(SspProblem::Circle(_))), "{error}");
}

fn unit(name: &str, exponents: [i32; 8]) -> Unit {
    Unit { name: name.to_owned(), exponents: Some(exponents), factor: 1.0, offset: 0.0 }
}

fn outline() -> Outline {
    let connector = |name: &str, input: bool, unit: &str| OutlineConnector {
        name: name.to_owned(),
        input,
        unit: unit.to_owned(),
    };
    let component = |name: &str, connectors: Vec<OutlineConnector>| OutlineComponent {
        name: name.to_owned(),
        source: format!("resources/{name}.fmu"),
        connectors,
    };
    let end = |element: &str, connector: &str| {
        ((!element.is_empty()).then(|| element.to_owned()), connector.to_owned())
    };
    Outline {
        name: "pair".to_owned(),
        description: "< & >".to_owned(),
        connectors: vec![connector("push", true, "N"), connector("seen", false, "m")],
        components: vec![
            component(
                "a",
                vec![connector("x", false, "m"), connector("f", true, "N"), connector("push", true, "N")],
            ),
            component("b", vec![connector("x", true, "m"), connector("f", false, "N")]),
        ],
        connections: vec![
            OutlineConnection {
                start: end("a", "x"),
                end: end("b", "x"),
                transformation: Some(Linear { factor: -1.0, offset: 2e-6 }),
            },
            OutlineConnection { start: end("b", "f"), end: end("a", "f"), transformation: None },
            OutlineConnection { start: end("", "push"), end: end("a", "push"), transformation: None },
            OutlineConnection { start: end("a", "x"), end: end("", "seen"), transformation: None },
        ],
        parameters: vec![OutlineParameter { name: "b.k".to_owned(), value: 7.9e6, unit: "N".to_owned() }],
        units: vec![unit("m", [0, 1, 0, 0, 0, 0, 0, 0]), unit("N", [1, 1, -2, 0, 0, 0, 0, 0])],
        experiment: (0.0, 0.2),
    }
}

#[test]
fn a_package_that_was_written_is_read_back() {
    let files =
        [("resources/a.fmu".to_owned(), b"a".to_vec()), ("resources/b.fmu".to_owned(), b"b".to_vec())];
    let bytes = outline().package(&files).unwrap();
    assert_eq!(bytes, outline().package(&files).unwrap());
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("pair.ssp");
    std::fs::write(&file, &bytes).unwrap();
    let system = read(&file).unwrap();
    assert_eq!(system.remarks, Vec::<String>::new());
    assert_eq!(system.name, "pair");
    assert_eq!(std::fs::read(&system.components[1].file).unwrap(), b"b");
    let x = system.connections.iter().find(|one| one.to.variable == "x").unwrap();
    assert_eq!(x.route.linear(None, None).unwrap(), Linear { factor: -1.0, offset: 2e-6 });
    assert_eq!((system.connections.len(), system.inputs.len(), system.outputs.len()), (2, 1, 1));
    assert_eq!(system.parameters[0].value, Value::Real(7.9e6));
    assert_eq!(system.parameters[0].target, End { component: 1, variable: "k".to_owned() });
    assert_eq!((system.start, system.stop), (Some(0.0), Some(0.2)));
    let unpacked = system.components[1].file.clone();
    drop(system);
    assert!(!unpacked.exists(), "the unpacked files go with the system");

    // Whatever is cut off, there is an error and no panic.
    for length in (0..bytes.len()).step_by(11) {
        std::fs::write(&file, &bytes[..length]).unwrap();
        assert!(read(&file).is_err(), "{length}");
    }
}

#[test]
fn a_package_reaches_nothing_outside() {
    let mut outline = outline();
    outline.components[0].source = "../a.fmu".to_owned();
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("pair.ssp");
    std::fs::write(&file, outline.package(&[]).unwrap()).unwrap();
    assert!(matches!(&*read(&file).unwrap_err().problem, Problem::Ssp(SspProblem::Source { .. })));
    std::fs::write(&file, Outline::default().package(&[]).unwrap()).unwrap();
    assert!(read(&file).unwrap().components.is_empty());
    assert!(read(Path::new("nowhere.ssp")).is_err());
}
