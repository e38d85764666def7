//! System structures: attributes, namespaces, names given twice, types and encodings.

use stickslip_readers::Problem;
use stickslip_readers::ssp::{DeclaredType, SspProblem, read};

use crate::ssp::{component, connection, document, nested, pair, system, written};

/// A pair whose connection has this transformation.
fn transformed(transformation: &str) -> String {
    let inside = format!("><ssc:{transformation}/></ssd:Connection>");
    document(&pair(&connection("a.x", "b.x", &inside)))
}

#[test]
fn a_misspelt_attribute_of_the_standard_is_an_error_that_names_it() {
    let good = transformed("LinearTransformation factor=\"0.5\"");
    assert!(
        (system(&good).unwrap().connections[0].route.linear(None, None).unwrap().factor - 500.0).abs() < 1e-9
    );
    let bound = document(&nested());
    let mapped = "ssc:LinearTransformation factor=\"10\"";
    for (text, wrong, of, meant) in [
        (good.replace(" factor", " faktor"), "faktor", "LinearTransformation", Some("factor")),
        (good.replace(" factor", " ssc:factor"), "factor", "LinearTransformation", None),
        (
            good.replace("ssd:", "").replace(" factor", " faktor"),
            "faktor",
            "LinearTransformation",
            Some("factor"),
        ),
        (
            good.replace("startConnector", "startConector"),
            "startConector",
            "Connection",
            Some("startConnector"),
        ),
        (good.replace("m=\"1\" factor", "m=\"1\" faktor"), "faktor", "BaseUnit", Some("factor")),
        (good.replace("stopTime", "stoptime"), "stoptime", "DefaultExperiment", Some("stopTime")),
        (good.replace("<ssc:Real unit", "<ssc:Real units"), "units", "Real", Some("unit")),
        // A connector has no value.
        (good.replace("<ssc:Real unit", "<ssc:Real value=\"1\" unit"), "value", "Real", None),
        (bound.replace("value=\"5\" unit", "value=\"5\" units"), "units", "Real", Some("unit")),
        (bound.replace("prefix=", "prefx="), "prefx", "ParameterBinding", Some("prefix")),
        (bound.replace("target=", "traget="), "traget", "MappingEntry", Some("target")),
        (
            bound.replace(mapped, "ssc:LinearTransformation fctor=\"10\""),
            "fctor",
            "LinearTransformation",
            Some("factor"),
        ),
    ] {
        let error = system(&text).unwrap_err();
        assert!(error.line().is_some_and(|line| line > 7), "{error}");
        let shown = error.render(false);
        let told = ["system.ssd".to_owned(), format!("`{wrong}` of <{of}>")];
        assert!(told.iter().all(|part| shown.contains(part)), "{wrong}: {shown}");
        if let Some(meant) = meant {
            assert!(shown.contains(&format!("`{meant}`?")), "{shown}");
        }
    }
}

#[test]
fn attributes_that_are_not_used_and_those_of_others_are_accepted() {
    let geometry = "<ssd:ElementGeometry x1=\"0\" y1=\"0\" x2=\"1\" y2=\"1\" rotation=\"0\" iconSource=\"i.png\" \
                    iconRotation=\"0\" iconFlip=\"false\" iconFixedAspectRatio=\"true\"/>";
    let annotated = "<ssd:Annotations><ssc:Annotation type=\"org.example\"><v:any v:x=\"1\" y=\"2\"/></ssc:Annotation></ssd:Annotations>";
    let text = transformed("LinearTransformation factor=\"0.5\" v:factor=\"3\" v:other=\"4\"")
        .replace(
            "version=\"1.0\" name=\"test\"",
            "version=\"1.0\" name=\"test\" id=\"i\" description=\"d\" author=\"a\" fileversion=\"1\" copyright=\"c\" license=\"l\" \
             generationTool=\"t\" generationDateAndTime=\"2026-01-01T00:00:00Z\" xmlns:v=\"http://vendor.example\" \
             xmlns:xsi=\"http://www.w3.org/2001/XMLSchema-instance\" xsi:schemaLocation=\"a b\"",
        )
        .replace("source=\"a.fmu\"", "source=\"a.fmu\" implementation=\"any\" type=\"application/x-fmu-sharedlibrary\"")
        .replace("</ssd:Connectors></ssd:Component>", &format!("</ssd:Connectors>{geometry}{annotated}</ssd:Component>"))
        .replace("kind=\"output\">", "kind=\"output\" id=\"c\" description=\"d\" v:colour=\"red\">")
        .replace("</ssd:System>", "<ssd:SystemGeometry x1=\"0\" y1=\"0\" x2=\"1\" y2=\"1\"/><ssd:GraphicalElements>\
             <ssd:Note x1=\"0\" y1=\"0\" x2=\"1\" y2=\"1\" text=\"n\"/></ssd:GraphicalElements></ssd:System>");
    let system = system(&text).unwrap();
    assert_eq!(system.remarks, Vec::<String>::new());
    // What a vendor calls a factor is none.
    assert!((system.connections[0].route.linear(None, None).unwrap().factor - 500.0).abs() < 1e-9);
}

#[test]
fn an_element_in_another_namespace_of_the_standard_is_an_error() {
    let good = transformed("LinearTransformation factor=\"0.5\"");
    for (text, element, space) in [
        (good.replace("ssd:Connections>", "ssc:Connections>"), "<Connections>", "SystemStructureDescription"),
        (
            good.replace("ssc:LinearTransformation", "ssd:LinearTransformation"),
            "<LinearTransformation>",
            "SystemStructureCommon",
        ),
        (
            document(&nested()).replace("ssv:Parameters>", "ssd:Parameters>"),
            "<Parameters>",
            "ParameterValues",
        ),
    ] {
        let error = system(&text).unwrap_err();
        assert!(matches!(&*error.problem, Problem::Ssp(SspProblem::Namespace { .. })), "{error}");
        assert!(error.line().is_some_and(|line| line > 7), "{error}");
        assert!(error.to_string().contains(element) && error.to_string().contains(space), "{error}");
    }
}

#[test]
fn a_parameter_given_twice_in_one_set_is_an_error() {
    let one = "<ssv:Parameter name=\"stiff\"><ssv:Real value=\"2\"/></ssv:Parameter>";
    let text = document(&nested());
    assert!(system(&text).is_ok() && text.contains(one));
    let error = system(&text.replace(one, &format!("{one}\n{}", one.replace('2', "3")))).unwrap_err();
    assert!(error.to_string().contains("the parameter `stiff` is listed twice"), "{error}");
}

#[test]
fn the_types_that_connectors_declare_are_told() {
    let a = component("a", &[("x", "output", "m"), ("n", "output", "")], "");
    let a = a.replace("name=\"n\" kind=\"output\">", "name=\"n\" kind=\"output\"><ssc:Integer/>");
    let system = system(&document(&format!("<ssd:Elements>{a}</ssd:Elements>"))).unwrap();
    let types = &system.components[0].types;
    let told: Vec<(&str, &str)> =
        types.iter().map(|DeclaredType { variable, name, .. }| (&**variable, *name)).collect();
    assert_eq!(told, [("n", "Integer"), ("x", "Real")]);
    assert!(types[0].place.starts_with("system.ssd:"), "{types:?}");
}

#[test]
fn a_file_is_read_in_the_encoding_that_it_shows_or_declares() {
    let named =
        document(&pair(&connection("a.x", "b.x", "/>"))).replace("name=\"test\"", "name=\"Prüfstand µ\"");
    let declared = |encoding: &str| named.replace("\"UTF-8\"", encoding);
    let latin =
        |encoding: &str| declared(encoding).chars().map(|letter| u8::try_from(letter).unwrap()).collect();
    let wide = declared("\"UTF-16\"");
    let files: [Vec<u8>; 7] = [
        latin("\"ISO-8859-1\""),
        latin("'iso-8859-1'"),
        latin("\"windows-1252\""),
        latin("\"US-ASCII\""),
        wide.encode_utf16().flat_map(u16::to_le_bytes).collect(),
        wide.encode_utf16().flat_map(u16::to_be_bytes).collect(),
        // It is UTF-8, or this could not be read at all.
        wide.clone().into(),
    ];
    let (_folder, file) = written("");
    for (index, bytes) in files.into_iter().enumerate() {
        std::fs::write(&file, bytes).unwrap();
        let system = read(&file).unwrap_or_else(|error| panic!("{index}: {error}"));
        assert_eq!((system.name.as_str(), system.connections.len()), ("Prüfstand µ", 1), "{index}");
    }
    std::fs::write(&file, latin("\"EBCDIC\"") as Vec<u8>).unwrap();
    let shown = read(&file).unwrap_err().render(false);
    assert!(shown.contains("`EBCDIC`") && shown.contains("ISO-8859-1"), "{shown}");
}
