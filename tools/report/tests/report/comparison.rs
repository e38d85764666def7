//! What a report promises, whatever is compared.

use serde_json::Value;
use stickslip::data::{Record, Regime};
use stickslip::diagnose::Comparison;
use stickslip::diagnose::Noise;
use stickslip_report::Settings;

use crate::synthetic::{HOSTILE, backbone, beam_with_failure, contact, failed, hostile, settings};

/// Nothing is known of the noise, unless a test is about it.
const QUIET: &[Noise] = &[];

fn html(comparison: &Comparison, settings: &Settings) -> String {
    stickslip_report::html(comparison, QUIET, settings)
}

fn json(comparison: &Comparison) -> Value {
    stickslip_report::json(comparison, QUIET)
}

fn terminal_table(comparison: &Comparison, width: usize, color: bool) -> String {
    stickslip_report::terminal_table(comparison, QUIET, width, color)
}

/// The page without its scripts' text, whose sources hold addresses that nothing fetches.
fn markup(page: &str) -> String {
    let mut rest = page;
    let mut markup = String::new();
    while let Some(start) = rest.find("<script") {
        let body = start + rest[start..].find('>').unwrap() + 1;
        markup.push_str(&rest[..body]);
        rest = &rest[body + rest[body..].find("</script>").expect("every script element ends")..];
    }
    markup + rest
}

/// The figures as the page's script reads them.
fn figures(page: &str) -> Value {
    let start = page.find(r#"id="figures">"#).unwrap() + r#"id="figures">"#.len();
    serde_json::from_str(&page[start..start + page[start..].find("</script>").unwrap()]).unwrap()
}

fn examples() -> Vec<Comparison> {
    let mut one_stage = backbone();
    one_stage.stages.truncate(1);
    let mut all_failed = beam_with_failure();
    for stage in &mut all_failed.stages {
        stage.records.iter_mut().for_each(|record| *record = failed("no"));
    }
    let empty = Comparison {
        title: String::new(),
        records: vec![],
        ring_downs: vec![],
        findings: vec![],
        notes: vec![],
        stages: vec![],
    };
    vec![backbone(), contact(1_000), beam_with_failure(), hostile(), one_stage, all_failed, empty]
}

#[test]
fn page_fetches_nothing() {
    for comparison in examples() {
        let page = html(&comparison, &settings());
        let markup = markup(&page);
        for attribute in
            [" src=", " href=\"h", " href=\"/", "@import", "url(", "<link", "<iframe", "<object", "<base"]
        {
            let place = markup.find(attribute);
            // Inside text a name may spell anything; only a bracket makes it an element.
            let in_tag = place.is_some_and(|at| {
                let before = &markup[..at];
                before.rfind('<').unwrap_or(0) > before.rfind('>').unwrap_or(0)
            });
            assert!(!in_tag, "{attribute} in {}", comparison.title);
        }
        assert!(markup.contains("default-src 'none'"));
        assert!(page.contains("showSendToCloud: false"), "the library's button that shares a figure is off");
        assert_eq!(page.matches("plotly.js v3").count(), 1, "the library is embedded once");
        assert!(page.len() < 1_600_000, "the library is packed, what no page draws and MathJax left out");
        assert_eq!(markup.matches("<script").count(), 3, "figures, plotly.js, the page's own");
    }
}

#[test]
fn every_element_that_is_opened_is_closed_in_order() {
    for comparison in examples() {
        let markup = markup(&html(&comparison, &settings()));
        let mut open: Vec<&str> = Vec::new();
        for tag in markup.split('<').skip(1) {
            let tag = tag.split('>').next().unwrap();
            let name = tag.split([' ', '\n']).next().unwrap();
            if let Some(name) = name.strip_prefix('/') {
                assert_eq!(open.pop(), Some(name));
            } else if !["!DOCTYPE", "input", "meta", "wbr"].contains(&name) {
                open.push(name);
            }
        }
        assert!(open.is_empty(), "{open:?}");
    }
}

#[test]
fn names_from_files_stay_text() {
    let page = html(&hostile(), &settings());
    let markup = markup(&page);
    assert_eq!(markup.matches("<script").count(), 3, "figures, plotly.js, the page's own");
    assert!(
        !markup.contains("<img") && !markup.replace("<a href=\"#", "").contains("<a "),
        "no element from a name"
    );
    assert!(!markup.contains("\" onmouseover"), "no attribute from a name");
    assert!(markup.contains("&lt;/script&gt;&lt;script&gt;alert(1)"));
    assert!(!page.contains('\u{1b}') && !page.contains('\u{202e}'));
    // Plotly reads tags in names too.
    for figure in figures(&page)["figures"].as_array().unwrap() {
        for trace in figure["data"].as_array().unwrap() {
            assert!(!trace["name"].as_str().unwrap_or("").contains('<'));
        }
    }
    let table = terminal_table(&hostile(), 80, false);
    assert!(!table.contains('\u{1b}') && !table.contains('\u{202e}'));
    assert_eq!(json(&hostile())["title"], HOSTILE[0]);
}

#[test]
fn the_same_comparison_gives_the_same_bytes() {
    assert_eq!(html(&contact(500), &settings()), html(&contact(500), &settings()));
    assert_eq!(json(&contact(500)).to_string(), json(&contact(500)).to_string());
    let dated = Settings { date: Some("2026-11-21".into()), ..settings() };
    assert!(html(&backbone(), &dated).contains("2026-11-21"));
}

#[test]
fn long_records_are_thinned_and_the_page_says_so() {
    let page = html(&contact(15_000), &settings());
    let library = html(
        &Comparison {
            title: String::new(),
            records: vec![],
            ring_downs: vec![],
            findings: vec![],
            notes: vec![],
            stages: vec![],
        },
        &settings(),
    )
    .len();
    assert!(page.len() - library < 1_500_000, "{} bytes of data", page.len() - library);
    assert!(page.contains("Long records are drawn with about 2500"));
    let channel = &figures(&page)["explorer"]["records"][0]["channels"][0];
    assert_eq!(channel["samples"], 15_000);
    assert!(channel["drawn"].as_u64().unwrap() <= 2_502);
    assert!(!html(&contact(100), &settings()).contains("Long records are drawn"));
}

/// The numbers of a stored column.
fn column(explorer: &Value, number: &Value) -> Vec<f64> {
    let column = &explorer["columns"][number.as_u64().unwrap() as usize];
    let (from, step) = (column["from"].as_f64().unwrap(), column["step"].as_f64().unwrap());
    let Some(codes) = column["codes"].as_str() else {
        return (0..column["count"].as_u64().unwrap()).map(|i| from + step * i as f64).collect();
    };
    let digit = |c: char| match c {
        'A'..='Z' => c as u32 - 'A' as u32,
        'a'..='z' => c as u32 - 'a' as u32 + 26,
        '0'..='9' => c as u32 - '0' as u32 + 52,
        '+' => 62,
        _ => 63,
    };
    let bits: Vec<u8> = codes
        .trim_end_matches('=')
        .chars()
        .flat_map(|c| (0..6).rev().map(move |bit| (digit(c) >> bit & 1) as u8))
        .collect();
    let byte = |bits: &[u8]| bits.iter().fold(0_u32, |byte, bit| byte << 1 | u32::from(*bit));
    let bytes: Vec<u32> = bits.chunks_exact(8).map(byte).collect();
    let value = |pair: &[u32]| match pair[0] | pair[1] << 8 {
        0xffff => f64::NAN,
        code => from + step * f64::from(code),
    };
    bytes.chunks_exact(2).map(value).collect()
}

#[test]
fn views_hold_the_residuals_of_every_stage() {
    let comparison = contact(600);
    let figures = figures(&html(&comparison, &settings()));
    let explorer = &figures["explorer"];
    let entry = &explorer["records"][0];
    let record =
        comparison.records.iter().position(|record| record.name == entry["name"].as_str().unwrap()).unwrap();
    let measured = &comparison.records[record].channel("force").unwrap().values;
    for (stage, residual) in
        comparison.stages.iter().zip(entry["channels"][0]["residuals"].as_array().unwrap())
    {
        let stored = column(explorer, residual);
        let predicted = &stage.records[record].channels[0].predicted;
        assert_eq!(stored.len(), 600);
        let range = stored.iter().fold(0.0_f64, |top, value| top.max(value.abs()));
        for ((stored, predicted), measured) in stored.iter().zip(predicted).zip(measured) {
            assert!((stored - (predicted - measured)).abs() <= 2.0 * range / 65_534.0);
        }
    }
    let worst = (0..10).max_by(|a, b| {
        let error = |record: usize| comparison.stages[2].records[record].error;
        error(*a).total_cmp(&error(*b))
    });
    assert_eq!(worst, Some(record), "the record that the last stage predicts worst comes first");
}

#[test]
fn every_trace_has_columns_of_one_length() {
    for comparison in examples() {
        let figures = figures(&html(&comparison, &settings()));
        let length = |axis: &Value| match axis {
            Value::Number(column) => {
                figures["columns"][column.as_u64().unwrap() as usize].as_array().unwrap().len()
            }
            other => other.as_array().unwrap().len(),
        };
        for figure in figures["figures"].as_array().unwrap() {
            for trace in figure["data"].as_array().unwrap().iter().filter(|trace| !trace["x"].is_null()) {
                assert_eq!(length(&trace["x"]), length(&trace["y"]));
                assert!(length(&trace["x"]) > 0);
            }
        }
    }
}

#[test]
fn figures_hold_the_residuals_of_the_predictions() {
    let figures = figures(&html(&backbone(), &settings()));
    let traces = figures["figures"][0]["data"].as_array().unwrap();
    let residual =
        traces.iter().find(|t| t["yaxis"] == "y2" && t["name"] == "2  Valanis, published").unwrap();
    let column = &figures["columns"][residual["y"].as_u64().unwrap() as usize];
    assert!((column[0].as_f64().unwrap() - (54.04 - 52.85)).abs() < 1e-4);
    assert!((column[7].as_f64().unwrap() - (49.41 - 50.11)).abs() < 1e-4);
    assert_eq!(traces.len(), 5 + 1 + 5);
}

#[test]
fn a_contact_is_seen_in_every_view() {
    let page = markup(&html(&contact(600), &settings()));
    for view in [
        "time",
        "loop",
        "parity",
        "cause:displacement",
        "cause:velocity",
        "cause:normal load",
        "slow",
        "spectrum",
    ] {
        assert_eq!(page.matches(&format!("data-view=\"{view}\"")).count(), 1, "{view}");
    }
    assert!(page.contains("id=\"choose-record\"") && page.matches("class=\"choose-stage\"").count() == 3);
}

#[test]
fn the_verdict_is_what_the_numbers_say() {
    let verdict = |comparison: &Comparison| json(comparison)["verdict"].as_str().unwrap().to_owned();
    let falls = backbone();
    assert_eq!(
        verdict(&falls),
        "The error falls from 1.81 Hz to 0.10 Hz RMS (−94 %). How much of it is noise is unknown: state `noise` in dataset.toml, or measure it again."
    );

    let mut rises = backbone();
    rises.stages.reverse();
    assert!(verdict(&rises).starts_with("The error rises from 0.10 Hz to 1.81 Hz RMS"));
    assert!(json(&rises)["notes"][0].as_str().unwrap().contains("Valanis with residual stiffness"));

    let mut same = backbone();
    same.stages = vec![same.stages[3].clone(), same.stages[3].clone()];
    assert!(verdict(&same).starts_with("The error does not fall: 0.15 Hz before, 0.15 Hz RMS after"));

    let mut none = backbone();
    none.stages.last_mut().unwrap().records[0] = failed("no convergence");
    assert_eq!(verdict(&none), "The errors cannot be compared: no record is predicted by every stage.");

    // Two channels: no RMS in units, but the normalised error over what both stages predict.
    let partial = beam_with_failure();
    let both = |stage: usize| {
        ((partial.stages[stage].records[0].error.powi(2) + partial.stages[stage].records[2].error.powi(2))
            / 2.0)
            .sqrt()
    };
    assert!(
        verdict(&partial).contains(&format!("from {:.2} to {:.4}", both(0), both(1))),
        "{}",
        verdict(&partial)
    );
    assert!(verdict(&partial).contains("over the 2 records that every stage predicts."));
}

#[test]
fn a_failure_is_shown_with_its_reason_everywhere() {
    let comparison = beam_with_failure();
    let reason = "did not converge at 50.3 Hz";
    assert!(markup(&html(&comparison, &settings())).contains(reason));
    assert!(terminal_table(&comparison, 200, false).contains(reason));
    let json = json(&comparison);
    let record = &json["stages"][1]["records"][1];
    assert!(record["failure"].as_str().unwrap().contains(reason));
    assert!(record["error"].is_null());
    // In the headline, and in no error.
    let [skipped] = &json["skipped"].as_array().unwrap()[..] else { panic!("{}", json["skipped"]) };
    assert_eq!(skipped["file"].as_str(), Some(comparison.records[1].name.as_str()));
    assert!(skipped["reason"].as_str().unwrap().contains(reason));
    let notes: Vec<&str> =
        json["notes"].as_array().unwrap().iter().filter_map(|note| note.as_str()).collect();
    assert!(
        notes.iter().any(|note| note.contains(&comparison.records[1].name) && note.contains(reason)),
        "{notes:?}"
    );
    let over_the_others = json["error"]["refitted"].as_f64().unwrap();
    let first = &comparison.stages[1].records[0];
    assert!((over_the_others - first.error).abs() < 1e-12);
}

#[test]
fn json_holds_every_number_but_no_array_of_samples() {
    let comparison = contact(1_000);
    let json = json(&comparison);
    assert_eq!(json["schema"], "stickslip.comparison/1");
    assert_eq!(json["error"]["baseline"], comparison.stages[0].error);
    assert_eq!(json["error"]["refitted"], comparison.stages[2].error);
    assert_eq!(json["rms"]["unit"], "N");
    let force = &json["stages"][2]["records"][4]["channels"]["force"];
    assert_eq!(force["rms"], comparison.stages[2].records[4].channels[0].rms);
    assert_eq!(force["unit"], "N");
    assert_eq!(json["stages"][2]["records"][4]["file"], "r4.csv");
    assert_eq!(json["stages"][2]["records"][4]["regime"], "from-rest");
    let parameter = &json["stages"][1]["parameters"]["contact.tangential_stiffness"];
    assert_eq!((parameter["value"].as_f64(), parameter["fitted_from"].as_f64()), (Some(4.7e6), Some(5.1e6)));
    assert_eq!(json["stages"][1]["evaluations"], 88);
    assert!(json.to_string().len() < 30_000);
}

/// Columns that a line takes, without colour sequences; all characters used here are one column wide.
fn columns(line: &str) -> usize {
    let mut plain = String::new();
    let mut rest = line;
    while let Some(start) = rest.find('\u{1b}') {
        plain.push_str(&rest[..start]);
        rest = &rest[start + rest[start..].find('m').unwrap() + 1..];
    }
    plain.push_str(rest);
    plain.chars().count()
}

#[test]
fn the_terminal_table_keeps_its_width() {
    for comparison in examples() {
        for width in [40, 60, 80, 120] {
            for color in [false, true] {
                let table = terminal_table(&comparison, width, color);
                for line in table.lines() {
                    assert!(columns(line) <= width, "{width}: {line:?}");
                }
                assert_eq!(table.contains('\u{1b}'), color, "colour only where asked for");
            }
        }
    }
}

#[test]
fn terminal_bars_are_proportional_to_the_error() {
    let table = terminal_table(&backbone(), 80, false);
    let bar = |name: &str| {
        let line = table.lines().find(|line| line.contains(name)).unwrap();
        line.chars().filter(|c| *c == '█').count() as f64
    };
    let comparison = backbone();
    let rms = |stage: usize| comparison.stages[stage].records[0].channels[0].rms;
    let fraction = bar("Valanis, published") / bar("linear beam");
    assert!((fraction - rms(1) / rms(0)).abs() < 0.04, "{fraction}");
    // Residuals at each level, aligned: every row of the level table is as wide as its heading.
    let rows: Vec<&str> = table.lines().skip_while(|line| !line.starts_with("amplitude")).take(9).collect();
    assert_eq!(rows.len(), 9);
    assert!(rows.iter().all(|row| row.chars().count() == rows[0].chars().count()), "{table}");
    assert!(rows[8].contains("+2.75") && rows[8].contains("−0.70"));
}

#[test]
fn gaps_and_short_predictions_do_not_panic() {
    let mut comparison = contact(300);
    comparison.stages[0].records[0].channels[0].predicted.truncate(7);
    comparison.stages[2].records[1].channels[0].predicted.fill(f64::NAN);
    comparison.stages[2].records[2].channels.clear();
    comparison.stages[1].records.truncate(3);
    comparison.stages[2].error = f64::NAN;
    comparison.records[4].channels.remove(0);
    comparison.records[5].channels.clear();
    comparison.records[6].channels[1].values.truncate(3);
    comparison.records[7].channels[0].values.clear();
    comparison.records[8].channels[2].values.clear();
    let mut levels = backbone();
    levels.stages[4].records[0].channels[0].predicted[3] = f64::NAN;
    levels.stages[3].records[0].channels[0].predicted.truncate(2);
    levels.records[0].channels[0].values.truncate(5);
    let mut bare = backbone();
    bare.records =
        vec![Record { name: "x".into(), regime: Regime::Backbone, use_for: None, channels: vec![] }];
    bare.stages.iter_mut().for_each(|stage| stage.records.clear());
    for comparison in [comparison, levels, bare] {
        assert!(html(&comparison, &settings()).ends_with("</html>"));
        assert!(!terminal_table(&comparison, 80, true).is_empty());
        assert!(!json(&comparison).to_string().contains("NaN"));
    }
}
