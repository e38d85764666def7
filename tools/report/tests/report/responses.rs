//! What page, table and JSON of response curves promise, whatever was found.

use stickslip::harmonic::stability::Undecided;
use stickslip::harmonic::{Contacting, Curve, Ending, Fold, Peak, Point};
use stickslip_report::Settings;
use stickslip_report::responses::{
    ContactLoop, FrequencyUnit, Held, Losses, ResponseCurve, Responses, responses_html, responses_json,
    responses_table,
};

const HOSTILE: &str = "</script><script>alert(1)</script>\u{1b}[31m";

fn point(angular_frequency: f64, level: f64) -> Point {
    let amplitude = level / ((1.0 - angular_frequency.powi(2)).powi(2) + 0.01).sqrt();
    Point {
        angular_frequency,
        level,
        parameter: 0.0,
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
        undecided: None,
        stable: (angular_frequency < 1.5).then_some(angular_frequency < 1.2),
        error_estimate: 1e-7,
        resolved: angular_frequency < 1.8,
        harmonics: 7,
        iterations: 3,
    }
}

fn curve(level: f64, ending: Ending) -> ResponseCurve {
    let points = (1..=100).map(|k| point(f64::from(k) * 0.02, level)).collect();
    let peaks =
        vec![Peak { node: 0, angular_frequency: 1.0, amplitude: 10.0 * level, level, parameter: 1.0 }];
    let folds = vec![Fold { angular_frequency: 1.2, level, parameter: 1.0, amplitude: vec![2.0] }];
    let loops = vec![ContactLoop {
        name: "at 1".into(),
        displacement: vec![-1.0, 1.0],
        force: vec![-1.0, 1.0],
        is_normal: false,
    }];
    let curve = Curve { nodes: vec![HOSTILE.into()], points, peaks, folds, ending };
    ResponseCurve { level, curve, phase_resonances: Vec::new(), loops, failure: None, seconds: 0.01 }
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
        losses: Losses { contact: 1, ..Losses::default() },
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
    assert!(table(4).contains("turned back and left the range") && table(4).contains("held acceleration"));
    let json = responses_json(&examples()[4], &Settings::default());
    assert_eq!((json["complete"].as_bool(), json["points"][0]["held"].as_f64()), (Some(false), Some(1.0)));
}

/// A copy of the plain example with every point changed.
fn changed(change: impl Fn(&mut Point)) -> Responses {
    let mut example = examples().swap_remove(0);
    example.curves[0].curve.points.iter_mut().for_each(change);
    example
}

#[test]
fn an_unknown_error_is_neither_nothing_nor_resolved() {
    let example = changed(|point| (point.error_estimate, point.resolved) = (f64::NAN, false));
    let json = responses_json(&example, &Settings::default());
    for at in [&json["points"][0], &json["peaks"][0]] {
        assert!(at["error_estimate"].is_null() && at["resolved"].is_null(), "{at}");
    }
    let table = responses_table(&example, 200, false);
    assert!(table.contains("The truncation error is unknown") && table.contains("unknown  "), "{table}");
    assert!(!table.contains("does not meet") && !table.contains("Largest estimate"), "{table}");
    let page = responses_html(&example, &Settings::default());
    assert!(page.contains("the truncation error is unknown") && !page.contains("Largest estimate"));
}

#[test]
fn errors_above_one_per_cent_are_reported_and_their_peaks_marked() {
    let mut example = changed(|point| {
        point.error_estimate = if point.angular_frequency < 1.1 { 1.8 } else { 1e-3 };
        point.resolved = point.error_estimate <= stickslip::harmonic::UNRESOLVED;
    });
    example.tolerance = None;
    let table = responses_table(&example, 200, false);
    assert!(table.contains("54 points of 100: the error estimate is above 0.01"), "{table}");
    assert!(table.contains("Among them 1 peak of 1.") && table.contains("1.8 !"), "{table}");
    assert!(responses_html(&example, &Settings::default()).contains("1.8, unresolved"));
    let json = responses_json(&example, &Settings::default());
    assert_eq!(
        (json["peaks"][0]["resolved"].as_bool(), json["peaks"][0]["error_estimate"].as_f64()),
        (Some(false), Some(1.8))
    );
}

#[test]
fn stability_is_claimed_only_where_it_is_known() {
    let none = responses_table(&examples()[2], 200, false);
    assert!(!none.contains("stable."), "{none}");
    let undetermined = responses_table(&changed(|point| point.stable = None), 200, false);
    assert!(
        undetermined.contains("stability cannot be determined.") && undetermined.contains("?"),
        "{undetermined}"
    );
    let some = responses_table(&examples()[0], 200, false);
    assert!(some.contains("15 unstable; at 26 the stability cannot be determined"), "{some}");
}

#[test]
fn a_curve_that_ended_early_has_no_peak_only_as_far_as_it_came() {
    let mut example = responses(vec![curve(1.0, Ending::Stuck)]);
    example.curves[0].curve.peaks.clear();
    example.curves[0].curve.points.truncate(20);
    let table = responses_table(&example, 200, false);
    assert!(table.contains("no peak up to 0.4\u{a0}rad/s, where the curve ended"), "{table}");
    assert!(!responses_html(&example, &Settings::default()).contains("between the ends of the range"));
}

#[test]
fn phases_are_negative_where_the_displacement_lags() {
    // The displacement sin Ωt is a quarter period behind cos Ωt; −cos Ωt half a period.
    for (node, phase) in [([0.0, 0.0, 2.0], -0.5), ([0.0, -2.0, 0.0], 1.0), ([0.0, 1.0, -1.0], 0.25)] {
        let example = changed(|point| point.nodes = vec![node.to_vec()]);
        let json = responses_json(&example, &Settings::default());
        let found = json["points"][0]["phase1"][HOSTILE].as_f64().unwrap();
        assert!((found - phase * std::f64::consts::PI).abs() < 1e-15, "{found}");
    }
}

#[test]
fn an_undamped_structure_may_have_no_end() {
    let stuck = |undamped: bool, contact: bool| {
        let losses = Losses { contact: usize::from(contact), undamped, ..Losses::default() };
        let example = Responses { losses, ..responses(vec![curve(1.0, Ending::Stuck)]) };
        responses_table(&example, 1000, false)
    };
    assert!(stuck(true, true).contains("4/π of its limit") && stuck(true, false).contains("without bound"));
    assert!(!stuck(false, true).contains("without bound"));
}

/// A page that is made again is the same, however long it took.
#[test]
fn the_time_of_computing_stands_on_the_terminal_alone() {
    let (quick, slow) = (responses(vec![]), Responses { seconds: 12.0, ..responses(vec![]) });
    let page = |one: &Responses| responses_html(one, &Settings::default());
    assert_eq!(page(&quick), page(&slow));
    assert!(responses_table(&slow, 80, false).contains("Computed in 12"));
}

#[test]
fn why_stability_cannot_be_determined_is_reported() {
    let why = Some(Undecided::TooLong);
    let example = changed(|point| (point.stable, point.undecided) = (None, why));
    let table = responses_table(&example, 1000, false);
    assert!(table.contains("stability cannot be determined (it would take too long"), "{table}");
    let json = responses_json(&example, &Settings::default());
    assert!(json["points"][0]["undecided"].as_str().unwrap().contains("too long"));
}

/// What is behind the model's contact belongs to the structure; without one, all of it does.
#[test]
fn the_structure_s_own_nonlinearities_are_no_contact() {
    let with = |contact: bool| {
        let mut example = changed(|point| point.contacts.push(point.contacts[0].clone()));
        example.losses = Losses { contact: usize::from(contact), ..Losses::default() };
        let point = responses_json(&example, &Settings::default())["points"][0].clone();
        let number = |key: &str| point[key].as_f64().unwrap();
        assert!(point.get("contacts").is_none());
        (
            number("dissipated"),
            number("dissipated_by_structure"),
            responses_html(&example, &Settings::default()),
        )
    };
    let (contact, structure, page) = with(true);
    assert!((contact - 0.1).abs() < 1e-15 && (structure - 0.1).abs() < 1e-15);
    assert!(page.contains("that the contact takes") && page.contains("nonlinearities (drag) take"));
    let (contact, structure, page) = with(false);
    assert!(contact == 0.0 && (structure - 0.2).abs() < 1e-15);
    assert!(!page.contains("that the contact takes"));
}
