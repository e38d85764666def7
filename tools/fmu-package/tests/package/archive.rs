//! What is in the archive of an FMU.

use std::io::{Cursor, Read};

use stickslip_fmu_package::{
    Error, FmiVersion, Stamp, read_model_toml, standard_models, write_fmu, write_stamped_fmu,
};
use zip::ZipArchive;

#[test]
fn a_model_file_too_large_to_be_one_is_refused_and_not_cut() {
    let (name, model_toml) = standard_models()[0];
    let padded = format!("{model_toml}# {}\n", "-".repeat(2 << 20));
    let fmu = write_fmu(name, &padded).unwrap();
    assert!(matches!(read_model_toml(&fmu), Err(Error::Unreadable(_))));
}

/// A file in an FMU.
fn file(fmu: &[u8], name: &str) -> Option<Vec<u8>> {
    let mut archive = ZipArchive::new(Cursor::new(fmu)).unwrap();
    let mut content = Vec::new();
    archive.by_name(name).ok()?.read_to_end(&mut content).unwrap();
    Some(content)
}

fn text(fmu: &[u8], name: &str) -> String {
    String::from_utf8(file(fmu, name).unwrap_or_else(|| panic!("no {name}"))).unwrap()
}

#[test]
fn author_and_date_are_those_of_the_version_or_ones_own_and_change_nothing_else() {
    let (name, model_toml) = standard_models()[0];
    let usual = write_fmu(name, model_toml).unwrap();
    assert_eq!(usual, write_fmu(name, model_toml).unwrap(), "the same model gives the same bytes");
    let stamp = Stamp::new(Some("A. <Engineer>"), Some("2031-02-03T04:05:06Z")).unwrap();
    let own = write_stamped_fmu(FmiVersion::Two, name, model_toml, &stamp).unwrap();
    let (usual_xml, own_xml) = (text(&usual, "modelDescription.xml"), text(&own, "modelDescription.xml"));
    assert!(own_xml.contains("author=\"A. &lt;Engineer&gt;\""), "{own_xml}");
    let restored = own_xml.replace("A. &lt;Engineer&gt;", "The stickslip authors");
    assert_eq!(restored.replace("2031-02-03T04:05:06Z", "2026-11-21T00:00:00Z"), usual_xml);
}

#[test]
fn an_fmu_has_flanges_icons_reference_results_and_equations() {
    for (name, model_toml) in standard_models() {
        let fmu = write_fmu(name, model_toml).unwrap();
        let terminals = text(&fmu, "terminalsAndIcons/terminalsAndIcons.xml");
        let expected = match name {
            "FrictionalBeam" | "SlipSlapBeam" => 0,
            "ModalBeamTwoContacts" | "SlipSlapContact" | "PinnedBeam" => 2,
            _ => 1,
        };
        assert_eq!(terminals.matches("<Terminal name=").count(), expected, "{name}");
        assert_eq!(file(&fmu, "terminalsAndIcons/flange.png").is_some(), expected > 0, "{name}");
        for picture in ["model.png", "terminalsAndIcons/icon.png"] {
            assert!(file(&fmu, picture).unwrap().starts_with(b"\x89PNG"));
        }
        assert!(text(&fmu, "terminalsAndIcons/icon.svg").starts_with("<svg "));
        let folder = "extra/org.fmi-standard.fmi-ls-ref";
        let [stimuli, reference] =
            ["stimuli", "reference"].map(|file| text(&fmu, &format!("{folder}/{file}.csv")));
        assert_eq!((stimuli.lines().count(), reference.lines().count()), (202, 202), "{name}");
        let page = text(&fmu, "documentation/index.html");
        assert!(page.contains("<h2>Equations</h2>") && page.contains("<h2>Loops</h2>"), "{name}");
    }
}

/// Positive force on the body that resists in the direction of its motion, on the other against it: the sum over a plug is
/// zero, as the standard asks of what flows.
#[test]
fn what_flows_into_a_contact_flows_out_of_a_beam() {
    let xml = |name: &str| {
        let (name, model_toml) = standard_models().into_iter().find(|(other, _)| *other == name).unwrap();
        text(&write_fmu(name, model_toml).unwrap(), "terminalsAndIcons/terminalsAndIcons.xml")
    };
    let force = r#"variableName="force" memberName="force" variableKind="inflow""#;
    assert!(xml("ValanisContact").contains(force));
    let force = r#"variableName="contact_force" memberName="force" variableKind="outflow""#;
    assert!(xml("ModalBeam").contains(force));
}
