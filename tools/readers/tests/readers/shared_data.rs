//! Every dataset that lies beside the repository can be read.

use stickslip::model::Structure;
use stickslip_readers::{check_columns, read_dataset, read_model};

use crate::external;

#[test]
fn the_hidden_effect_cases_are_read() {
    let Some(cases) = external::data("hidden-effect") else { return };
    for case in 1..=9 {
        let folder = cases.join(format!("case-{case}"));
        let dataset = read_dataset(&folder).unwrap_or_else(|error| panic!("{}", error.render(false)));
        assert_eq!(dataset.records.len(), 8, "case {case}");
        for record in &dataset.records {
            assert!(record.sample_step().is_some(), "case {case}, {}: uneven", record.name);
        }
        let model = read_model(folder.join("model.toml")).unwrap_or_else(|error| panic!("{error}"));
        check_columns(&dataset, &model).unwrap_or_else(|error| panic!("case {case}: {error}"));
        let is_oscillator = matches!(model.structure, Structure::Oscillator(_));
        assert_eq!(is_oscillator, matches!(case, 6 | 7), "case {case}");
        if is_oscillator {
            assert!(dataset.records[0].channel("displacement:m2").unwrap().noise.is_some());
        }
    }
}

#[test]
fn the_friction_damper_is_read_in_si() {
    let Some(folder) = external::data("friction-damper") else { return };
    let dataset = read_dataset(&folder).unwrap_or_else(|error| panic!("{}", error.render(false)));
    let model =
        read_model(folder.join("model.toml")).unwrap_or_else(|error| panic!("{}", error.render(false)));
    check_columns(&dataset, &model).unwrap();
    assert_eq!(dataset.records.len(), 10);
    for record in &dataset.records {
        // Block means of four samples at 1024 Hz; the strokes are half an inch to one and a half.
        let step = record.sample_step().expect("evenly sampled");
        assert!((step * 256.0 - 1.0).abs() < 1e-3, "{}: {step}", record.name);
        let stroke = record
            .channel("displacement")
            .unwrap()
            .values
            .iter()
            .fold(0.0, |most, value| f64::max(most, value.abs()));
        assert!((0.01..0.05).contains(&stroke), "{}: {stroke} m", record.name);
    }
}
