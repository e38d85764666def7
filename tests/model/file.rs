//! The model file: it reads back exactly what was written, and says what is wrong and where.

use proptest::prelude::*;
use stickslip::contact::LAWS;
use stickslip::model::{Beam, Contact, Damping, Law, Model, PointMass, Structure};
use stickslip::vocabulary::Scale;

const CONTACT: &str = r#"schema = "stickslip.model/1"
kind = "contact"

[contact]
law = "valanis"
tangential_stiffness = 7.9e6   # N/m
friction_coefficient = 0.6
normal_load = 147.15
smoothness = 0.3
residual_stiffness = 3e5

[fit]
free = ["contact.*"]
"#;

const BEAM: &str = r#"schema = "stickslip.model/1"
kind = "beam"

[beam]
length = 0.6
width = 0.04
thickness = 0.005
density = 7850
youngs_modulus = 197.1e9
modes = 4
damping_ratio = [0.003, 0.003, 0.004, 0.005]

[[beam.point_mass]]
position = 0.55
mass = 0.02515

[[beam.point_mass]]
position = 0.1
mass = 0.005

[support]
offset = 0.006

[excitation]
position = 0.55

[contact]
law = "jenkins"
tangential_stiffness = 5e6
friction_coefficient = 0.5
normal_load = 150
"#;

/// The line (from 1) and the text an error points at, and its message with the help.
fn refusal(text: &str) -> (usize, String, String) {
    let error = Model::parse(text).expect_err(text);
    let span = error.span.clone().unwrap_or(0..0);
    let line = 1 + text[..span.start].matches('\n').count();
    (line, text[span].to_owned(), error.to_string())
}

#[track_caller]
fn refused(text: &str, line: usize, at: &str, words: &[&str]) {
    let (found_line, found_text, message) = refusal(text);
    assert_eq!((found_line, found_text.as_str()), (line, at), "{message}");
    for word in words {
        assert!(message.contains(word), "`{word}` is missing from: {message}");
    }
}

#[track_caller]
fn replaced(text: &str, from: &str, to: &str) -> String {
    assert!(text.contains(from));
    text.replacen(from, to, 1)
}

#[test]
fn the_samples_are_read_as_they_stand() {
    let model = Model::parse(CONTACT).unwrap();
    assert_eq!(model.structure, Structure::Prescribed);
    let contact = model.contact.unwrap();
    assert_eq!(contact.law, Law::named("valanis", &[0.3, 3e5]).unwrap());
    assert_eq!(contact.tangential_stiffness, 7.9e6);
    let Structure::Beam(beam) = Model::parse(BEAM).unwrap().structure else { panic!("not a beam") };
    assert_eq!(beam.density, 7850.0);
    assert_eq!(beam.damping, Damping::PerMode(vec![0.003, 0.003, 0.004, 0.005]));
    assert_eq!(beam.sensors, [0.55, 0.1], "without [[sensor]] they are where the masses are");
    assert_eq!((beam.rotational_stiffness, beam.clamp_stiffness), (0.0, None));
}

#[test]
fn contact_points_are_read_and_stand_on_the_moving_part_of_the_beam() {
    let with = |points: &[f64]| {
        let points: String =
            points.iter().map(|place| format!("\n[[contact_point]]\nposition = {place}\n")).collect();
        Model::parse(&format!("{BEAM}{points}"))
    };
    let Structure::Beam(beam) = with(&[0.3, 0.2]).unwrap().structure else { panic!("not a beam") };
    assert_eq!(beam.contact_points, [0.3, 0.2]);
    for (points, message) in [
        (&[0.3, 0.3][..], "listed twice"),
        (&[0.7], "is not on the beam"),
        (&[0.0], "does not move there"),
        (&[beam.length], "does not move there"),
    ] {
        let error = with(points).unwrap_err();
        assert!(error.message.contains(message), "{}", error.message);
        assert!(error.span.is_some());
    }
}

#[test]
fn a_byte_order_mark_and_carriage_returns_change_nothing() {
    let model = Model::parse(BEAM).unwrap();
    assert_eq!(Model::parse(&format!("\u{feff}{BEAM}")).unwrap(), model);
    assert_eq!(Model::parse(&BEAM.replace('\n', "\r\n")).unwrap(), model);
}

#[test]
fn a_beam_may_have_a_spring_instead_of_a_contact() {
    let (head, _) = BEAM.split_once("[contact]").unwrap();
    let text = replaced(head, "offset = 0.006", "rotational_stiffness = 197.4\nclamp_stiffness = 1e5");
    let model = Model::parse(&text).unwrap();
    assert_eq!(model.contact, None);
    assert_eq!(model.get("support.rotational_stiffness"), Some(197.4));
    assert_eq!(model.get("support.clamp_stiffness"), Some(1e5));
}

#[test]
fn an_unknown_key_is_refused_with_the_nearest_legal_one() {
    let text = replaced(CONTACT, "tangential_stiffness", "tangental_stiffness");
    let words = ["unknown key", "[contact]", "did you mean `tangential_stiffness`"];
    refused(&text, 6, "tangental_stiffness", &words);
    let text = replaced(BEAM, "mass = 0.005", "weight = 0.005");
    refused(&text, 19, "weight", &["[beam.point_mass]", "`mass`"]);
    refused(&replaced(BEAM, "[support]", "[suport]"), 21, "suport", &["did you mean `support`"]);
    refused(&replaced(CONTACT, "free =", "fre ="), 13, "fre", &["did you mean `free`"]);
}

#[test]
fn a_key_of_another_law_or_kind_says_where_it_belongs() {
    let text = replaced(CONTACT, "\"valanis\"", "\"jenkins\"");
    refused(&text, 9, "smoothness", &["law = \"jenkins\"", "belongs to law = \"valanis\""]);
    let text = replaced(BEAM, "\"beam\"", "\"contact\"");
    refused(&text, 4, "beam", &["does not belong", "kind = \"beam\""]);
}

#[test]
fn schema_kind_and_law_are_refused_with_the_legal_ones() {
    let text = replaced(CONTACT, "model/1", "model/2");
    refused(&text, 1, "\"stickslip.model/2\"", &["stickslip.model/1"]);
    let text = replaced(CONTACT, "\"contact\"", "\"plate\"");
    refused(&text, 2, "\"plate\"", &["unknown kind", "`beam`"]);
    let text = replaced(CONTACT, "\"valanis\"", "\"valans\"");
    refused(&text, 5, "\"valans\"", &["did you mean `valanis`"]);
    refused(&replaced(CONTACT, "law = \"valanis\"", "law = 3"), 5, "3", &["string", "number"]);
    refused("", 1, "", &["`schema` is missing", "stickslip.model/1"]);
    refused(&replaced(CONTACT, "kind = \"contact\"", ""), 1, "", &["`kind` is missing", "`contact`, `beam`"]);
}

#[test]
fn a_missing_key_is_reported_at_its_table_with_its_unit() {
    refused(&replaced(CONTACT, "normal_load = 147.15", ""), 4, "[contact]", &["`normal_load`", "[N]"]);
    refused(&replaced(BEAM, "offset = 0.006", ""), 21, "[support]", &["`offset`", "[m]"]);
    let (_, _, message) = refusal(&replaced(BEAM, "[excitation]\nposition = 0.55", ""));
    assert!(message.contains("`excitation` is missing"), "{message}");
    let text = replaced(BEAM, "damping_ratio = [0.003, 0.003, 0.004, 0.005]", "");
    refused(&text, 4, "[beam]", &["`mass_damping`"]);
}

#[test]
fn values_out_of_bounds_are_refused_at_the_value() {
    refused(&replaced(BEAM, "mass = 0.005", "mass = 0"), 19, "0", &["above 0"]);
    refused(&replaced(BEAM, "length = 0.6", "length = -0.6"), 5, "-0.6", &["above 0"]);
    refused(&replaced(BEAM, "length = 0.6", "length = 1e300"), 5, "1e300", &["physical"]);
    refused(&replaced(BEAM, "modes = 4", "modes = 0"), 10, "0", &["at least 1 and at most 40"]);
    refused(&replaced(BEAM, "modes = 4", "modes = 3.5"), 10, "3.5", &["whole number"]);
    refused(&replaced(BEAM, "modes = 4", "modes = 1e25"), 10, "1e25", &["at most 40"]);
    refused(
        &replaced(BEAM, "modes = 4", "modes = 4\nstatic_correction = 1"),
        11,
        "1",
        &["`true` or `false`"],
    );
    refused(&replaced(BEAM, "0.005]", "1.5]"), 11, "1.5", &["at most 1"]);
    for number in ["nan", "-inf", "1e999"] {
        refused(&replaced(CONTACT, "0.6", number), 7, number, &["finite"]);
    }
    refused(&replaced(CONTACT, "0.6", "\"0.6\""), 7, "\"0.6\"", &["number", "string"]);
    refused(&replaced(CONTACT, "147.15", "0.0"), 8, "0.0", &["above 0"]);
}

#[test]
fn smoothness_one_is_refused_and_says_why() {
    refused(&replaced(CONTACT, "= 0.3", "= 1.0"), 9, "1.0", &["corner", "Jenkins", "law = \"jenkins\""]);
    refused(&replaced(CONTACT, "= 0.3", "= 1.1"), 9, "1.1", &["at least 0 and below 1"]);
    assert!(Model::parse(&replaced(CONTACT, "= 0.3", "= 0")).is_ok());
}

#[test]
fn residual_stiffness_stays_below_tangential_stiffness() {
    refused(&replaced(CONTACT, "3e5", "7.9e6"), 10, "7.9e6", &["below `tangential_stiffness`"]);
    let without = Model::parse(&replaced(CONTACT, "residual_stiffness = 3e5", "")).unwrap();
    assert_eq!(without.get("contact.residual_stiffness"), Some(0.0));
}

#[test]
fn every_law_of_the_catalogue_is_read_written_and_fitted_by_its_own_keys() {
    for kind in LAWS {
        let keys = kind.parameters.iter().filter(|parameter| parameter.default.is_none());
        let value = |range: fn(f64) -> (f64, f64, Scale)| 0.5 * (range(7.9e6).0 + range(7.9e6).1);
        let keys: String =
            keys.map(|key| format!("{} = {:?}\n", key.quantity.name, value(key.range))).collect();
        let text = replaced(CONTACT, "smoothness = 0.3\nresidual_stiffness = 3e5\n", &keys);
        let model = Model::parse(&replaced(&text, "\"valanis\"", &format!("\"{}\"", kind.name))).unwrap();
        assert_eq!(Model::parse(&model.to_toml()).unwrap(), model);
        assert!(model.law().unwrap().unwrap().limit(100.0) > 0.0);
        for (parameter, value) in model.contact.unwrap().law.parameters() {
            let path = format!("contact.{}", parameter.quantity.name);
            let found = model.parameters().into_iter().find(|found| found.path == path).unwrap();
            assert!(found.free && found.value == value && found.upper <= (parameter.range)(7.9e6).1);
        }
    }
}

#[test]
fn positions_and_counts_must_fit_the_beam() {
    refused(&replaced(BEAM, "position = 0.1", "position = 0.61"), 18, "0.61", &["0 to 0.6 m"]);
    let text = replaced(BEAM, "[excitation]\nposition = 0.55", "[excitation]\nposition = 0.7");
    refused(&text, 25, "0.7", &["0 to 0.6 m"]);
    let text = format!("{BEAM}\n[[sensor]]\nposition = 0.3\n\n[[sensor]]\nposition = 0.9\n");
    refused(&text, 37, "0.9", &["not on the beam"]);
    let text = replaced(BEAM, "[0.003, 0.003, 0.004, 0.005]", "[0.003, 0.003]");
    refused(&text, 11, "[0.003, 0.003]", &["2 damping ratios for 4 modes"]);
    let text = replaced(BEAM, "[0.003, 0.003, 0.004, 0.005]", "0.1\nmass_damping = 1");
    refused(&text, 11, "0.1", &["excludes"]);
}

#[test]
fn a_free_pattern_that_frees_nothing_is_refused_at_the_pattern() {
    let text = replaced(CONTACT, "\"contact.*\"", "\"contact.*\", \"beam.*\"");
    refused(&text, 13, "\"beam.*\"", &["names no parameter", "contact.smoothness"]);
    let text = replaced(CONTACT, "contact.*", "contact.smothness");
    refused(&text, 13, "\"contact.smothness\"", &["did you mean `contact.smoothness`"]);
    refused(&replaced(CONTACT, "[\"contact.*\"]", "[3]"), 13, "3", &["array of strings"]);
}

#[test]
fn broken_toml_is_refused_where_it_breaks() {
    let (line, _, message) = refusal(&replaced(CONTACT, "smoothness = 0.3", "smoothness 0.3"));
    assert_eq!(line, 9, "{message}");
    assert!(message.starts_with("not TOML"), "{message}");
    let (line, _, message) = refusal(&replaced(CONTACT, "smoothness = 0.3", "law = \"jenkins\""));
    assert_eq!(line, 9, "{message}");
}

fn positive() -> impl Strategy<Value = f64> + Clone {
    (-20.0..20.0f64).prop_map(|exponent| 10f64.powf(exponent))
}

fn contact() -> impl Strategy<Value = Contact> {
    // κ and e_t/e0 of the Valanis law.
    let law = prop::option::of((0.0..0.999f64, 0.0..0.999f64));
    (law, positive(), positive(), positive()).prop_map(|(law, stiffness, coefficient, load)| Contact {
        law: match law {
            None => Law::named("jenkins", &[]).unwrap(),
            Some((smoothness, ratio)) => Law::named("valanis", &[smoothness, ratio * stiffness]).unwrap(),
        },
        tangential_stiffness: stiffness,
        friction_coefficient: coefficient,
        normal_load: load,
        normal_stiffness: 0.0,
        normal: None,
    })
}

fn damping() -> impl Strategy<Value = (usize, Damping)> {
    prop_oneof![
        (1usize..=40, (0.0..=1.0f64).prop_map(Damping::Uniform)),
        prop::collection::vec(0.0..=1.0f64, 1..=40)
            .prop_map(|ratios| (ratios.len(), Damping::PerMode(ratios))),
        (1usize..=40, positive(), positive())
            .prop_map(|(modes, mass, stiffness)| (modes, Damping::Proportional { mass, stiffness })),
    ]
}

fn beam() -> impl Strategy<Value = Beam> {
    let numbers = (positive(), positive(), positive(), positive(), positive(), positive(), 0.0..1e3f64);
    let place = 0.0..=1.0f64;
    let masses = prop::collection::vec((place.clone(), positive()), 0..4);
    let sensors = prop::option::of(prop::collection::vec(place.clone(), 0..4));
    let points = prop::collection::btree_set(1u8..100, 0..3);
    (numbers, damping(), masses, sensors, points, prop::option::of(positive()), place).prop_map(
        |(numbers, (modes, damping), masses, sensors, points, clamp_stiffness, excitation)| {
            let (length, width, thickness, density, youngs_modulus, offset, rotational_stiffness) = numbers;
            let mass = |(place, mass)| PointMass { position: place * length, mass };
            let point_masses: Vec<_> = masses.into_iter().map(mass).collect();
            let sensors = match sensors {
                Some(places) => places.into_iter().map(|place| place * length).collect(),
                None => point_masses.iter().map(|mass| mass.position).collect(),
            };
            Beam {
                length,
                width,
                thickness,
                density,
                youngs_modulus,
                modes,
                static_correction: modes % 2 == 0,
                damping,
                point_masses,
                offset,
                rotational_stiffness,
                clamp_stiffness,
                excitation_position: excitation * length,
                sensors,
                contact_points: points.into_iter().map(|place| f64::from(place) / 100.0 * length).collect(),
            }
        },
    )
}

fn model() -> impl Strategy<Value = Model> {
    let free = prop::option::of(prop::sample::subsequence(vec!["*", "*stiffness", "contact.*"], 0..=3));
    let structure = prop_oneof![Just(Structure::Prescribed), beam().prop_map(Structure::Beam)];
    (structure, contact(), prop::bool::ANY, free).prop_map(|(structure, contact, bare, free)| {
        let bare = bare && structure != Structure::Prescribed;
        let patterns =
            |patterns: Vec<&str>| patterns.into_iter().filter(|_| !bare).map(str::to_owned).collect();
        Model {
            structure,
            contact: (!bare).then_some(contact),
            effects: Vec::new(),
            free: free.map(patterns),
        }
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]

    #[test]
    fn what_is_written_reads_back_the_same(model in model()) {
        prop_assert_eq!(model.check(), Ok(()));
        let text = model.to_toml();
        let read = Model::parse(&text).map_err(|error| format!("{error}\n{text}"));
        prop_assert_eq!(read.as_ref(), Ok(&model));
    }

    #[test]
    fn an_error_points_inside_the_text_at_character_boundaries(
        cut in 0usize..700, length in 0usize..40, insert in "[\\PC\n\r\t]{0,12}", beam in prop::bool::ANY,
    ) {
        let text = if beam { BEAM } else { CONTACT };
        let start = cut.min(text.len());
        let end = (start + length).min(text.len());
        let mutated = format!("{}{insert}{}", &text[..start], &text[end..]);
        if let Err(error) = Model::parse(&mutated) && let Some(span) = error.span {
            prop_assert!(mutated.get(span.clone()).is_some(), "{span:?} in {mutated:?}");
        }
    }

    #[test]
    fn any_text_at_all_is_read_or_refused(text in "\\PC{0,200}") {
        let _ = Model::parse(&text);
    }
}
