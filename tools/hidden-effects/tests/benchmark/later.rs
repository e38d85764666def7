//! What the later cases are unlike the first in, as their files show it.

use serde_json::Value;
use stickslip_hidden_effects::cases::case::{Case, Kind};
use stickslip_hidden_effects::cases::files;
use stickslip_hidden_effects::cases::sealed::sealed;
use stickslip_hidden_effects::motion::drive::Drive;
use stickslip_hidden_effects::records::record::{Record, Regime};
use stickslip_hidden_effects::rigs::setting::Setting;

fn with(setting: Setting) -> Vec<Case> {
    let cases: Vec<Case> = sealed().into_iter().filter(|case| case.setting == setting).collect();
    assert!(!cases.is_empty(), "{setting:?}");
    cases
}

fn named(name: &str) -> Case {
    sealed().into_iter().find(|case| case.name() == name).unwrap()
}

fn samples_apart(record: &Record) -> f64 {
    record.columns[0].values[1]
}

#[test]
fn cases_of_many_records_have_as_many_and_no_two_alike() {
    for (setting, count) in [(Setting::Records32, 32), (Setting::Records128, 128)] {
        for case in with(setting).iter().filter(|case| case.kind == Kind::Contact) {
            let records = case.draw().unwrap().rig.respond();
            assert_eq!(records.len(), count);
            let largest =
                |record: &Record| record.columns[1].values.iter().fold(0.0_f64, |most, x| most.max(*x));
            let mut reached: Vec<f64> = records.iter().map(largest).collect();
            reached.sort_by(f64::total_cmp);
            assert!(reached.windows(2).all(|pair| pair[0] < pair[1]));
        }
    }
}

#[test]
fn noise_is_not_told_where_the_name_says_so_nor_of_ramped_records() {
    let ramped: Vec<Case> = sealed().into_iter().filter(|case| case.drive == Drive::Ramped).collect();
    assert!(ramped.len() >= 8 && ramped.iter().all(|case| case.name().ends_with("-ramped")));
    for case in with(Setting::NoiseUntold).iter().take(1).chain(&ramped[..2]) {
        for record in case.draw().unwrap().measure() {
            assert!(record.told.is_empty() && record.regime == Regime::FromRest, "{}", case.name());
        }
    }
    let usual = named("oscillator-backlash-full-1%-white-1").draw().unwrap();
    assert!(usual.measure().iter().all(|record| record.told.len() == 2));
}

#[test]
fn long_delays_are_beyond_twenty_samples_of_the_fastest_record() {
    for case in with(Setting::LongDelay) {
        let drawn = case.draw().unwrap();
        let delay = drawn.hidden().iter().find(|hidden| hidden.id == "sensor_delay").unwrap().parameters[0].1;
        let shortest = drawn.rig.respond().iter().map(samples_apart).fold(f64::INFINITY, f64::min);
        assert!(delay / shortest > 20.0, "{delay} {shortest}");
    }
}

#[test]
fn the_models_wrong_mass_is_five_percent_off_and_the_truth_says_where() {
    let mut signs = Vec::new();
    for case in with(Setting::MassOff) {
        let truth = files::truth(&case).unwrap();
        let place = truth["places"]["added_mass"].as_str().unwrap().to_owned();
        let lacking = truth["parameters"]["added_mass"]["mass"].as_f64().unwrap();
        let model = case.draw().unwrap().model();
        let (_, after) = model.split_once(&format!("name = \"{place}\"\nmass = ")).unwrap();
        let given: f64 = after.lines().next().unwrap().parse().unwrap();
        assert!((lacking.abs() / given - 0.05).abs() < 1e-12, "{lacking} {given}");
        signs.push(lacking > 0.0);
    }
    assert!(signs.contains(&true) && signs.contains(&false));
}

#[test]
fn where_samples_are_coarse_few_show_a_cycle() {
    let case = &with(Setting::Coarse)[0];
    let records = case.draw().unwrap().rig.respond();
    assert!(records.iter().all(|record| (samples_apart(record) - 5e-4).abs() < 1e-12));
    // The last but one is driven at the second resonance: its excitation crosses zero twice a cycle.
    let force = &records[6].columns[1].values;
    let crossings = force.windows(2).filter(|pair| pair[0] * pair[1] < 0.0).count();
    let per_cycle = 2.0 * force.len() as f64 / crossings as f64;
    assert!((8.0..25.0).contains(&per_cycle), "{per_cycle}");
}

#[test]
fn the_truth_tells_law_question_and_names_of_faults() {
    let truth = |name: &str| files::truth(&named(name)).unwrap();
    let dahl = truth("contact-micro_slip-dahl-full-1%-white-1");
    assert_eq!([&dahl["effect"], &dahl["law"], &dahl["question"]], ["micro_slip", "dahl", "dahl"]);
    assert_eq!(dahl["described_by"], Value::from(vec!["bouc_wen", "valanis"]));
    let hum = truth("contact-unknown-hum-full-1%-white-1");
    assert!(hum["faults"].as_array().unwrap().contains(&Value::from("mains_hum")));
    assert_eq!([&hum["effect"], &hum["question"]], ["unknown:hum", "hum"]);
    let first = truth("contact-micro_slip-full-1%-white-1");
    assert!(["law", "question", "faults"].iter().all(|key| first.get(key).is_none()));
}

#[test]
fn the_first_papers_model_has_the_stiffness_and_the_limit_of_its_contact() {
    let case = &with(Setting::HeldLevels)[0];
    let model = case.draw().unwrap().model();
    let number = |name: &str| -> f64 {
        let (_, after) = model.split_once(&format!("\n{name} = ")).unwrap();
        after.lines().next().unwrap().parse().unwrap()
    };
    assert!(model.contains("law = \"jenkins\""));
    assert_eq!(number("tangential_stiffness"), 7.9e6);
    let limit = number("friction_coefficient") * number("normal_load");
    assert!((limit / 90.804_598 - 1.0).abs() < 1e-8, "{limit}");
}

#[test]
fn a_kind_refuses_a_setting_that_it_does_not_have() {
    let beam = &with(Setting::HeldLevels)[0];
    assert!(Case { setting: Setting::Records128, ..beam.clone() }.draw().is_err());
    assert!(Case { kind: Kind::Contact, setting: Setting::MassOff, ..beam.clone() }.draw().is_err());
}
