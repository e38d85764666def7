//! What page, table and JSON of response curves promise, whatever was found.

use stickslip::harmonic::{Contacting, Curve, Ending, Fold, Peak, Point};
use stickslip_report::Settings;
use stickslip_report::responses::{
    ContactLoop, FrequencyUnit, Held, ResponseCurve, Responses, responses_html, responses_json,
    responses_table,
};

const HOSTILE: &str = "</script><script>alert(1)</script>\u{1b}[31m";

fn point(angular_frequency: f64, level: f64) -> Point {
    let amplitude = level / ((1.0 - angular_frequency.powi(2)).powi(2) + 0.01).sqrt();
    Point {
        angular_frequency,
        level,
        amplitude: vec![amplitude],
        nodes: vec![vec![0.0, amplitude, 0.0]],
        contacts: vec![Contacting {
            dissipated_energy: 0.1,
            equivalent_stiffness: f64::NAN,
            stick_fraction: None,
            displacement: vec![0.0, amplitude, 0.0],
            force: vec![0.0, 1.0, 0.0],
        }],
        work: 0.2,
        stable: (angular_frequency < 1.5).then_some(angular_frequency < 1.2),
        error_estimate: 1e-7,
        resolved: angular_frequency < 1.8,
        harmonics: 7,
        iterations: 3,
    }
}

fn curve(level: f64, ending: Ending) -> ResponseCurve {
    let points = (1..=100).map(|k| point(f64::from(k) * 0.02, level)).collect();
    let peaks = vec![Peak { node: 0, angular_frequency: 1.0, amplitude: 10.0 * level, level }];
    let folds = vec![Fold { angular_frequency: 1.2, level, amplitude: vec![2.0] }];
    let loops =
        vec![ContactLoop { name: "at 1".into(), displacement: vec![-1.0, 1.0], force: vec![-1.0, 1.0] }];
    let curve = Curve { nodes: vec![HOSTILE.into()], points, peaks, folds, ending };
    ResponseCurve { level, curve, loops, failure: None, seconds: 0.01 }
}

fn responses(curves: Vec<ResponseCurve>) -> Responses {
    Responses {
        title: HOSTILE.into(),
        unit: FrequencyUnit::RadiansPerSecond,
        range: (0.02, 2.0),
        held: None,
        harmonics: 7,
        tolerance: Some(1e-6),
        stability: true,
        curves,
        seconds: 0.02,
    }
}

fn examples() -> Vec<Responses> {
    let mut empty = curve(1.0, Ending::Stuck);
    empty.curve.points.clear();
    empty.curve.peaks.clear();
    empty.curve.folds.clear();
    empty.loops.clear();
    empty.failure = Some("no balance".into());
    let held = Some(Held { node: HOSTILE.into(), derivative: 2 });
    vec![
        responses(vec![curve(1.0, Ending::Complete)]),
        responses(vec![
            curve(1.0, Ending::Complete),
            curve(2.0, Ending::Stuck),
            curve(3.0, Ending::Interrupted),
        ]),
        responses(vec![empty]),
        responses(vec![]),
        Responses {
            held,
            tolerance: None,
            stability: false,
            ..responses(vec![curve(1.0, Ending::Returned)])
        },
    ]
}

#[test]
fn names_stay_text_and_nothing_is_fetched() {
    for example in examples() {
        let page = responses_html(&example, &Settings::default());
        assert_eq!(page.matches("plotly.js v3").count(), 1, "the library is embedded once");
        assert!(page.contains("default-src 'none'"));
        assert!(!page.contains("<script>alert(1)") && !page.contains('\u{1b}'));
        for width in [40, 80] {
            let table = responses_table(&example, width, false);
            assert!(!table.contains('\u{1b}'));
            assert!(table.lines().all(|line| line.chars().count() <= width), "{table}");
        }
    }
}

#[test]
fn json_has_null_where_a_number_does_not_exist() {
    let json = responses_json(&examples()[0], &Settings::default());
    let first = &json["points"][0];
    assert!(first["equivalent_stiffness"].is_null() && first["stick_fraction"].is_null());
    assert!(json["points"][99]["stable"].is_null() && first["stable"] == true);
    assert_eq!(json["points"][70]["stable"], false);
    assert_eq!((json["complete"].as_bool(), json["folds"].as_array().map(Vec::len)), (Some(true), Some(1)));
    assert!(first["held"].is_null() && !json.to_string().contains("NaN"));
}

#[test]
fn what_is_missing_is_said() {
    let table = |index: usize| responses_table(&examples()[index], 200, false);
    // Points 91 to 100 of the only curve: from 1.8 rad/s on.
    assert!(
        table(0).contains("11 points of 100: the error estimate does not meet the tolerance"),
        "{}",
        table(0)
    );
    assert!(table(1).contains("steps became too small") && table(1).contains("Interrupted: the curve at 3"));
    assert!(table(2).contains("no balance") && table(2).contains("No point"));
    assert!(table(4).contains("turned and left the range") && table(4).contains("held acceleration"));
    let json = responses_json(&examples()[4], &Settings::default());
    assert_eq!((json["complete"].as_bool(), json["points"][0]["held"].as_f64()), (Some(false), Some(1.0)));
}
