//! What the page of both forces of a contact promises.

use stickslip::data::Dataset;
use stickslip::identify::{IdentifyOptions, ModeCount, SlipSlapIdentification, identify_slip_slap};
use stickslip::rig::{Chain, ChannelFault, DualMode, NoiseLevel, Separation, Slap, dual_mode_on};
use stickslip::system::ModalPinRig;
use stickslip_report::Settings;
use stickslip_report::slip_slap::{SlipSlapReport, slip_slap_html, slip_slap_json, slip_slap_table};

use crate::pin_rig::{contact, model_b};

const HOSTILE: &str = "</script><script>alert(1)</script>\u{1b}[31m";

/// A record of few harmonics and modes.
fn found() -> SlipSlapIdentification {
    let mut rig = model_b();
    rig.beam.modes = 10;
    let system = ModalPinRig::new(&rig).unwrap().system(Some(contact(&rig)));
    let test = DualMode {
        harmonics: 7,
        periods: 4,
        samples_per_period: 64,
        ..DualMode::at(52.0, vec![[7.0, 17.0]])
    };
    let fault = ChannelFault { noise: NoiseLevel::Fraction(0.003), ..ChannelFault::default() };
    let chain = Chain { accelerometers: vec![fault; 3], ..Chain::default() };
    let tested = dual_mode_on(&system, &[0.55, 0.3, 0.05], &chain, &test).unwrap();
    let mut records: Vec<_> = tested.into_iter().map(|tested| tested.record).collect();
    records[0].name = HOSTILE.to_owned();
    let options = IdentifyOptions { modes: ModeCount::Model, harmonics: 7, ..IdentifyOptions::default() };
    identify_slip_slap(&rig, &Dataset { title: None, records }, &options).unwrap()
}

#[test]
fn page_table_and_json_say_what_was_found_and_what_was_not() {
    let found = found();
    let separation = [Separation {
        amplitudes: [7.0, 17.0],
        least_normal_force: 59.0,
        onset: Some(8.5),
        forces: [1.0; 2],
    }];
    let slap = Slap {
        preload: 6.5,
        time: vec![0.0, 1.0],
        normal_force: vec![3.0, 0.0],
        separation: vec![0.0, 1e-6],
        partings: 3,
        impact_energy: 1e-3,
    };
    let report = SlipSlapReport {
        title: HOSTILE.to_owned(),
        found: &found,
        truth: &[],
        separation: &separation,
        slap: Some(&slap),
        notes: &["loop.csv: the regime was guessed".to_owned()],
    };
    let page = slip_slap_html(&report, &Settings::default());
    let text = slip_slap_table(&report, 100, false);
    assert!(!page.contains("<script>alert(1)"), "page");
    assert!(!text.contains('\u{1b}'), "{text}");
    let untold = "These records do not tell whether the pin leaves its support";
    for words in [untold, "Coupling", "normal_displacement", "do not trust"] {
        assert!(page.contains(words), "{words}");
        assert!(text.replace('\n', " ").contains(words.split(' ').next().unwrap()), "{words}");
    }
    assert!(page.contains("leaves its support 3 times") && page.contains("8.5"));
    let json = slip_slap_json(&report);
    assert_eq!(json["schema"], "stickslip.identification/1");
    assert_eq!(json["separates"], serde_json::Value::Null);
    assert!(text.contains("normal force is not told"), "{text}");
    assert_eq!(json["records"][0]["published"]["trusted"], false);
    assert!(json["unidentified"].as_array().unwrap().iter().any(|name| name == "normal_stiffness"));
    assert_eq!(json["separation"][0]["onset"], 8.5);
    // The terminal was told when the file was read.
    assert!(page.contains("How the measurements were read") && page.contains("the regime was guessed."));
    assert!(!text.contains("were read"), "{text}");
    assert_eq!(json["notes"][0], "loop.csv: the regime was guessed");
}

/// What the terminal says of `found`, in one line, and what programs are told of separation.
fn told(found: &SlipSlapIdentification) -> (String, serde_json::Value) {
    let title = "t".to_owned();
    let report = SlipSlapReport { title, found, truth: &[], separation: &[], slap: None, notes: &[] };
    let text = slip_slap_table(&report, 400, false).replace('\n', " ");
    (text, slip_slap_json(&report)["separates"].clone())
}

/// Separation is told as far as the normal force is, with its interval.
#[test]
fn the_headline_says_no_more_of_separation_than_the_normal_force_tells() {
    let mut found = found();
    found.unidentified.clear();
    for (least, interval, separates, words) in [
        (42.0, 1.0, Some(false), "never leaves its support"),
        (42.0, 50.0, None, "whether the pin leaves its support is not told"),
        (-5.0, 1.0, Some(true), "the pin leaves its support"),
        (-5.0, 10.0, None, "whether the pin leaves its support is not told"),
    ] {
        for record in &mut found.records {
            (record.normal_force[0], record.force_intervals[1]) = (least, interval);
        }
        let (text, separation) = told(&found);
        assert!(
            text.contains("Both forces of the contact were identified") && text.contains(words),
            "{text}"
        );
        assert_eq!(separation, serde_json::json!(separates));
    }
    for (name, words) in
        [("normal_force", "the normal force is not told"), ("tangential_force", "the tangential was not")]
    {
        found.unidentified = vec![stickslip::identify::Unidentified { name, reason: String::new() }];
        let (text, _) = told(&found);
        assert!(!text.contains("Both forces") && text.contains(words), "{text}");
    }
}
