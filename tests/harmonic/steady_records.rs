//! Steady records of a beam with a hidden effect, made by another program: periods are found, and the
//! given model (which lacks the effect) answers every excitation from a cold start.

use std::f64::consts::TAU;

use stickslip::contact::Jenkins;
use stickslip::harmonic::fourier::{coefficient_count, from_samples, time_derivative, value};
use stickslip::harmonic::{Assembly, Control, CurveSettings, periodic_response, whole_periods};

use crate::common::contact::loaded;
use crate::common::{external, finite_elements};

/// Columns of a record: time, excitation, accelerations at 0.55, 0.3 and 0.1 m.
fn columns(path: &std::path::Path) -> Vec<Vec<f64>> {
    let text = std::fs::read_to_string(path).expect("a readable record");
    let mut columns = vec![Vec::new(); 5];
    for line in text.lines().skip(1) {
        for (column, cell) in columns.iter_mut().zip(line.split(',')) {
            column.push(cell.trim().parse().expect("a number"));
        }
    }
    columns
}

#[test]
fn every_steady_record_is_answered_from_a_cold_start() {
    let Some(folder) = external::data("hidden-effect/case-8") else { return };
    let masses = [(0.55, 0.025), (0.3, 0.005), (0.1, 0.005)];
    let mut beam = finite_elements::beam(193_737_638_546.993_47, &masses, 0.003_697_017_655_819_057_4, 6, 24);
    beam.sensors.truncate(3);
    let law = Jenkins::new(7_198_003.463_408_523, 0.400_647_880_176_607_24).unwrap();
    let contact = loaded(law, 149.899_456_390_378_36);
    let settings = CurveSettings { harmonics: 7, ..CurveSettings::default() };
    for record in [0, 1, 5, 7] {
        let columns = columns(&folder.join(format!("r{record}.csv")));
        let (time, excitation) = (&columns[0], &columns[1]);
        let periods = whole_periods(excitation).expect("the excitation stands out of the noise");
        let step = (time[time.len() - 1] - time[0]) / (time.len() - 1) as f64;
        let period = step * time.len() as f64 / periods as f64;
        let force = from_samples(excitation, periods, settings.harmonics);
        assert_eq!(force.len(), coefficient_count(settings.harmonics));
        let started = std::time::Instant::now();
        let assembly =
            Assembly { waveform: force.clone(), ..Assembly::new(beam.system(contact.clone()).unwrap()) };
        let (omega, control) = (TAU / period, Control::Level(1.0));
        let response = periodic_response(&assembly, omega, &control, &settings, None)
            .unwrap_or_else(|error| panic!("record {record}: {error}"));
        let elapsed = started.elapsed();
        let mut errors = Vec::new();
        for (sensor, measured) in response.nodes.iter().zip(&columns[2..]) {
            let acceleration = time_derivative(sensor, 2, omega);
            let model: Vec<f64> = time.iter().map(|t| value(&acceleration, omega * t)).collect();
            let power: f64 = measured.iter().map(|a| a * a).sum();
            let rest: f64 = measured.iter().zip(&model).map(|(a, m)| (a - m).powi(2)).sum();
            errors.push((rest / power).sqrt());
        }
        println!(
            "record {record}: {periods} periods of {period:.6} s, {} steps, {elapsed:?}, errors {errors:.3?}, force {:.2?}",
            response.iterations,
            &force[..9]
        );
        // A solution is found again without a step.
        let again = periodic_response(&assembly, omega, &control, &settings, Some(&response)).unwrap();
        assert_eq!(again.nodes, response.nodes);
        assert!(errors.iter().all(|e| *e < 1.0), "record {record}: errors {errors:?}");
    }
}
