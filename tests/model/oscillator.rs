//! Oscillators in model files: read, written, refused at the line; their parameters; the two-mass example.

use std::collections::BTreeSet;

use proptest::prelude::*;
use stickslip::model::{Anchor, AssemblyError, Contact, Law, Mass, Model, Oscillator, Spring, Structure};
use stickslip::system::StructureError;

const TWO: &str = r#"schema = "stickslip.model/1"
kind = "oscillator"

[[mass]]
name = "m1"
mass = 1.4

[[mass]]
name = "m2"
mass = 1.1

[[spring]]
between = ["ground", "m1"]
stiffness = 38e3
damping = 5.2

[[spring]]
between = ["m1", "m2"]
stiffness = 14e3

[[spring]]
between = ["m2", "ground"]
damping = 0.3

[excitation]
at = "m1"

[contact]
at = "m2"
law = "jenkins"
tangential_stiffness = 7e3
friction_coefficient = 0.44
normal_load = 35.0
"#;

const EXAMPLE: &str = include_str!("../../examples/friction-vibration/model.toml");

#[track_caller]
fn refused(from: &str, to: &str, line: usize, at: &str, words: &[&str]) {
    assert!(TWO.contains(from), "{from}");
    let text = TWO.replacen(from, to, 1);
    let error = Model::parse(&text).expect_err(&text);
    let span = error.span.clone().unwrap_or(0..0);
    let found = (1 + text[..span.start].matches('\n').count(), &text[span]);
    assert_eq!(found, (line, at), "{error}");
    for word in words {
        assert!(error.to_string().contains(word), "`{word}` is missing from: {error}");
    }
}

fn two() -> Model {
    Model::parse(TWO).unwrap_or_else(|error| panic!("{error}"))
}

fn oscillator(model: &Model) -> &Oscillator {
    let Structure::Oscillator(oscillator) = &model.structure else { panic!("not an oscillator") };
    oscillator
}

#[test]
fn the_sample_is_read_as_it_stands() {
    let model = two();
    let found = oscillator(&model);
    assert_eq!(found.masses[1], Mass { name: "m2".into(), mass: 1.1 });
    let between = [Anchor::Mass(1), Anchor::Ground];
    assert_eq!(found.springs[2], Spring { between, stiffness: 0.0, damping: 0.3 });
    assert_eq!((found.excitation, found.contact), (0, Some(1)));
    assert_eq!(model.contact.unwrap().law, Law::named("jenkins", &[]).unwrap());
}

#[test]
fn the_excitation_is_at_the_first_mass_unless_said() {
    let text = TWO.replacen("[excitation]\nat = \"m1\"", "", 1);
    assert_eq!(Model::parse(&text).unwrap(), two());
    let text = TWO.replacen("[excitation]\nat = \"m1\"", "[excitation]\nat = \"m2\"", 1);
    assert_eq!(oscillator(&Model::parse(&text).unwrap()).excitation, 1);
}

#[test]
fn an_oscillator_may_have_no_contact() {
    let (head, _) = TWO.split_once("[contact]").unwrap();
    let model = Model::parse(head).unwrap();
    assert_eq!((model.contact, oscillator(&model).contact), (None, None));
    let system = model.system().unwrap();
    assert!(system.linear_part().contacts.is_empty() && system.laws().next().is_none());
    assert_eq!(Model::parse(&model.to_toml()).unwrap(), model);
}

#[test]
fn unknown_masses_are_refused_where_they_are_named() {
    refused("[\"m1\", \"m2\"]", "[\"m1\", \"m3\"]", 18, "\"m3\"", &["no mass \"m3\"", "did you mean `m"]);
    refused("[\"ground\", \"m1\"]", "[\"grund\", \"m1\"]", 13, "\"grund\"", &["did you mean `ground`"]);
    refused("at = \"m2\"", "at = \"M9\"", 29, "\"M9\"", &["`m1`, `m2`"]);
    refused("at = \"m2\"", "at = \"ground\"", 29, "\"ground\"", &["no mass \"ground\""]);
    refused("[excitation]\nat = \"m1\"", "[excitation]\nat = \"x\"", 26, "\"x\"", &["no mass \"x\""]);
}

#[test]
fn names_are_distinct_and_fit_for_columns() {
    refused("name = \"m2\"", "name = \"m1\"", 9, "\"m1\"", &["listed twice", "mass 1"]);
    refused("name = \"m2\"", "name = \"ground\"", 9, "\"ground\"", &["no mass can be called"]);
    refused("name = \"m2\"", "name = \"a b\"", 9, "\"a b\"", &["letters, digits"]);
    refused("name = \"m2\"", "name = \"\"", 9, "\"\"", &["letters, digits"]);
}

#[test]
fn what_is_missing_is_reported_at_its_table() {
    refused("name = \"m2\"", "", 8, "[[mass]]", &["`name`"]);
    refused("mass = 1.1", "", 8, "[[mass]]", &["`mass`", "[kg]"]);
    refused("between = [\"m1\", \"m2\"]", "", 17, "[[spring]]", &["`between`", "between = ["]);
    refused("stiffness = 14e3", "", 17, "[[spring]]", &["`stiffness`", "`damping`", "or both"]);
    refused("at = \"m2\"", "", 28, "[contact]", &["`at`", "a mass and the ground"]);
    refused("[excitation]\nat = \"m1\"", "[excitation]", 25, "[excitation]", &["`at`"]);
    let error = Model::parse("schema = \"stickslip.model/1\"\nkind = \"oscillator\"\n").unwrap_err();
    assert!(error.to_string().contains("at least one mass"), "{error}");
}

#[test]
fn values_out_of_bounds_are_refused_at_the_value() {
    refused("mass = 1.1", "mass = 0", 10, "0", &["above 0"]);
    refused("mass = 1.1", "mass = nan", 10, "nan", &["finite"]);
    refused("stiffness = 14e3", "stiffness = -1", 19, "-1", &["at least 0"]);
    refused("damping = 0.3", "damping = -0.3", 23, "-0.3", &["at least 0"]);
    refused("damping = 0.3", "damping = \"0.3\"", 23, "\"0.3\"", &["number", "string"]);
    refused("normal_load = 35.0", "normal_load = 0", 33, "0", &["above 0"]);
}

#[test]
fn springs_have_two_different_ends() {
    refused("[\"m1\", \"m2\"]", "[\"m1\"]", 18, "[\"m1\"]", &["two ends, not 1"]);
    let three = "[\"m1\", \"m2\", \"ground\"]";
    refused("[\"m1\", \"m2\"]", three, 18, three, &["two ends, not 3"]);
    refused("[\"m1\", \"m2\"]", "[\"m1\", \"m1\"]", 18, "[\"m1\", \"m1\"]", &["both ends are at \"m1\""]);
    refused("[\"m1\", \"m2\"]", "\"m1\"", 18, "\"m1\"", &["array of strings"]);
}

#[test]
fn keys_and_tables_of_other_kinds_say_where_they_belong() {
    refused("stiffness = 14e3", "stifness = 14e3", 19, "stifness", &["did you mean `stiffness`"]);
    refused("[excitation]\nat", "[excitation]\nposition", 26, "position", &["unknown key", "`at`"]);
    refused("[excitation]", "[support]", 25, "support", &["does not belong", "kind = \"beam\""]);
    refused("\"oscillator\"", "\"contact\"", 4, "mass", &["does not belong", "kind = \"oscillator\""]);
    refused("\"oscillator\"", "\"beam\"", 4, "mass", &["does not belong", "kind = \"oscillator\""]);
    refused("law = \"jenkins\"", "law = \"jenkins\"\nsmoothness = 0.1", 31, "smoothness", &["valanis"]);
}

#[test]
fn parameters_are_reached_by_path_and_springs_that_are_there_are_free() {
    let mut model = two();
    let free: Vec<_> = model
        .parameters()
        .into_iter()
        .filter(|parameter| parameter.free)
        .map(|parameter| parameter.path)
        .collect();
    let expected = [
        "spring.1.stiffness",
        "spring.1.damping",
        "spring.2.stiffness",
        "spring.3.damping",
        "contact.tangential_stiffness",
        "contact.friction_coefficient",
    ];
    assert_eq!(free, expected);
    for parameter in model.parameters() {
        let (path, lower, upper) = (&parameter.path, parameter.lower, parameter.upper);
        assert!(lower <= parameter.value && parameter.value <= upper && lower < upper, "{path}");
        for value in [lower, upper, 1.05 * parameter.value] {
            model.set(path, value).unwrap_or_else(|error| panic!("{error}"));
            assert_eq!(model.get(path), Some(value), "{path}");
        }
    }
    for (path, value) in [("mass.1.mass", 0.0), ("mass.3.mass", 1.0), ("spring.2.stiffness", -1.0)] {
        let before = model.clone();
        model.set(path, value).expect_err(path);
        assert_eq!(model, before);
    }
}

#[test]
fn a_model_built_in_code_keeps_the_rules_of_the_file() {
    let break_it: [fn(&mut Oscillator); 6] = [
        |oscillator| oscillator.masses.clear(),
        |oscillator| oscillator.masses[0].name = "a b".into(),
        |oscillator| oscillator.excitation = 2,
        |oscillator| oscillator.contact = Some(2),
        |oscillator| oscillator.contact = None,
        |oscillator| oscillator.springs[0].between[1] = Anchor::Mass(7),
    ];
    for change in break_it {
        let mut model = two();
        let Structure::Oscillator(oscillator) = &mut model.structure else { panic!("an oscillator") };
        change(oscillator);
        model.check().expect_err("broken");
        model.to_toml(); // writes what it can, without a panic
    }
}

#[test]
fn the_example_has_the_matrices_and_frequencies_of_the_published_system() {
    let model = Model::parse(EXAMPLE).unwrap_or_else(|error| panic!("{error}"));
    let system = model.system().unwrap();
    let structure = system.linear_part();
    assert_eq!(structure.stiffness, [(0, 0, 1.5), (0, 1, -0.5), (1, 0, -0.5), (1, 1, 0.5)]);
    assert_eq!(structure.damping, [(0, 0, 0.1), (1, 1, 0.1)]);
    assert_eq!(structure.contacts, [vec![(1, 1.0)]]);
    let (_, law, normal_load) = system.laws().next().unwrap();
    assert_eq!(law.limit(normal_load), 0.02);
    let mut frequencies = structure.natural_modes().unwrap().angular_frequency;
    let mut stuck = structure.clone();
    stuck.stiffness[3].2 += model.get("contact.tangential_stiffness").unwrap();
    frequencies.extend(stuck.natural_modes().unwrap().angular_frequency);
    for (found, published) in frequencies.iter().zip([0.5411961, 1.3065630, 0.6780026, 1.3192090]) {
        assert!((found - published).abs() < 5e-8, "{found}");
    }
}

#[test]
fn a_contact_alone_is_an_element_without_a_structure() {
    let (_, contact) = TWO.split_once("[contact]\nat = \"m2\"\n").unwrap();
    let text = format!("schema = \"stickslip.model/1\"\nkind = \"contact\"\n[contact]\n{contact}");
    let system = Model::parse(&text).unwrap().system().unwrap();
    assert_eq!((system.core.size(), system.laws().count()), (0, 1));
    let mut model = two();
    let Structure::Oscillator(oscillator) = &mut model.structure else { panic!("an oscillator") };
    oscillator.excitation = 5;
    let refused = model.system().unwrap_err();
    assert!(matches!(refused, AssemblyError::Structure(StructureError::UnknownMass { mass: 5, .. })));
}

#[test]
fn a_chain_of_ten_thousand_masses_is_read() {
    use std::fmt::Write;
    let mut text = String::from("schema = \"stickslip.model/1\"\nkind = \"oscillator\"\n");
    for i in 1..=10_000 {
        let before = if i == 1 { "ground".to_owned() } else { format!("m{}", i - 1) };
        writeln!(text, "[[mass]]\nname = \"m{i}\"\nmass = 1\n[[spring]]").unwrap();
        writeln!(text, "between = [\"{before}\", \"m{i}\"]\nstiffness = 1").unwrap();
    }
    let model = Model::parse(&text).unwrap();
    assert_eq!(model.system().unwrap().linear_part().stiffness.len(), 3 * 10_000 - 2);
    let error = Model::parse(&text.replacen("\"m77\"]", "\"m77x\"]", 1)).unwrap_err().to_string();
    assert!(error.contains("did you mean") && error.len() < 400, "{error}");
}

fn positive() -> impl Strategy<Value = f64> + Clone {
    (-20.0..20.0f64).prop_map(|exponent| 10f64.powf(exponent))
}

fn oscillators() -> impl Strategy<Value = Model> {
    let zero_or = || prop_oneof![Just(0.0), positive()];
    let masses = prop::collection::vec(("[a-zé0-9_-]{1,6}", positive()), 1..6);
    let springs = prop::collection::vec((0usize..100, 0usize..100, zero_or(), zero_or()), 0..6);
    (masses, springs, prop::option::of((0usize..100, positive())), 0usize..100).prop_map(
        |(masses, springs, contact, excitation)| {
            let mut names = BTreeSet::from(["ground".to_owned()]);
            let masses: Vec<Mass> = masses
                .into_iter()
                .filter(|(name, _)| names.insert(name.clone()))
                .map(|(name, mass)| Mass { name, mass })
                .collect();
            let count = masses.len();
            let anchor = |i: usize| {
                if i.is_multiple_of(count + 1) { Anchor::Ground } else { Anchor::Mass(i % (count + 1) - 1) }
            };
            let springs = springs
                .into_iter()
                .map(|(i, j, stiffness, damping)| Spring {
                    between: [anchor(i), anchor(j)],
                    stiffness,
                    damping,
                })
                .filter(|spring| spring.between[0] != spring.between[1])
                .collect();
            Model {
                structure: Structure::Oscillator(Oscillator {
                    masses,
                    springs,
                    contact: contact.map(|(mass, _)| mass % count.max(1)),
                    excitation: excitation % count.max(1),
                }),
                contact: contact.map(|(_, stiffness)| Contact {
                    law: Law::named("jenkins", &[]).unwrap(),
                    tangential_stiffness: stiffness,
                    friction_coefficient: 0.5,
                    normal_load: 3.0,
                    normal_stiffness: 0.0,
                    normal: None,
                }),
                effects: Vec::new(),
                free: None,
            }
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]

    #[test]
    fn what_is_written_reads_back_the_same(model in oscillators()) {
        prop_assume!(!oscillator(&model).masses.is_empty());
        prop_assert_eq!(model.check(), Ok(()));
        let text = model.to_toml();
        let read = Model::parse(&text).map_err(|error| format!("{error}\n{text}"));
        prop_assert_eq!(read.as_ref(), Ok(&model));
        prop_assert!(model.system().is_ok());
    }

    #[test]
    fn a_mangled_file_is_read_or_refused_inside_the_text(
        cut in 0usize..700, length in 0usize..40, insert in "[\\PC\n\r\t]{0,12}",
    ) {
        let start = cut.min(TWO.len());
        let end = (start + length).min(TWO.len());
        let mutated = format!("{}{insert}{}", &TWO[..start], &TWO[end..]);
        match Model::parse(&mutated) {
            Ok(model) => prop_assert!(model.system().is_ok()),
            Err(error) => if let Some(span) = error.span {
                prop_assert!(mutated.get(span.clone()).is_some(), "{span:?} in {mutated:?}");
            }
        }
    }
}
