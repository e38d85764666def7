//! First-harmonic responses: of linear oscillators, whose response is known.

use std::f64::consts::TAU;

use stickslip::data::{Record, Regime};
use stickslip::diagnose::{Comparison, RecordResult};
use stickslip_report::html;

use crate::synthetic::{channel, result, settings, stage};

/// Displacement over force of 1 kg at `natural` (Hz) with damping ratio `damping`: size (m/N) and phase (rad).
fn receptance(frequency: f64, natural: f64, damping: f64) -> (f64, f64) {
    let (own, omega) = (TAU * natural, TAU * frequency);
    let (real, imaginary) = (own * own - omega * omega, 2.0 * damping * own * omega);
    (1.0 / real.hypot(imaginary), -imaginary.atan2(real))
}

fn compared(records: Vec<(Record, RecordResult)>) -> Comparison {
    let (records, results) = records.into_iter().unzip();
    Comparison {
        title: "Oscillator".into(),
        records,
        ring_downs: vec![],
        findings: vec![],
        notes: vec![],
        stages: vec![stage("as given", vec![], results, 0)],
    }
}

/// The section of the page, as text without marks.
fn section(comparison: &Comparison) -> Option<String> {
    let page = html(comparison, &[], &settings());
    let section = page.split("<section id=\"responses\">").nth(1)?.split("</section>").next()?.to_owned();
    let text: Vec<&str> =
        section.split('<').filter_map(|part| part.split_once('>')).map(|(_, text)| text).collect();
    Some(text.join(" ").split_whitespace().collect::<Vec<_>>().join(" "))
}

#[test]
fn a_stepped_sine_gives_the_damping_of_both_oscillators() {
    let frequency: Vec<f64> = (0..60).map(|i| 40.0 + 0.35 * f64::from(i)).collect();
    let column = |natural: f64, damping: f64| -> Vec<f64> {
        let omega = |f: f64| TAU * f;
        frequency.iter().map(|f| 2.0 * omega(*f).powi(2) * receptance(*f, natural, damping).0).collect()
    };
    let measured = channel("acceleration:m1", "m/s^2", column(50.0, 0.02));
    let result = result(&measured, column(51.0, 0.03));
    let force = channel("excitation:m1", "N", vec![2.0; 60]);
    let record = Record {
        name: "sine.csv".into(),
        regime: Regime::SteppedSine,
        use_for: None,
        channels: vec![channel("frequency", "Hz", frequency), force, measured],
    };
    let text = section(&compared(vec![(record, result)])).unwrap();
    let row = text.split("sine.csv ").nth(1).unwrap();
    // Heights of accelerations per force are 1/(2 D m) at the peak.
    assert!(row.starts_with("50.00 25 2.00 51.00 17 3.00"), "{text}");
}

#[test]
fn steady_records_give_amplitude_and_phase_at_their_frequency() {
    let of = |frequency: f64| {
        let (size, phase) = receptance(frequency, 50.0, 0.05);
        let time: Vec<f64> = (0..1000).map(|i| f64::from(i) * 10.0 / frequency / 1000.0).collect();
        let sine = |amplitude: f64, ahead: f64| -> Vec<f64> {
            time.iter().map(|t| amplitude * (TAU * frequency * t + ahead).cos()).collect()
        };
        let measured = channel("displacement:m1", "m", sine(3.0 * size, phase));
        // The model answers by a tenth more, and 90° later.
        let result = result(&measured, sine(3.3 * size, phase - TAU / 4.0));
        let force = channel("excitation:m1", "N", sine(3.0, 0.7));
        let channels = vec![channel("time", "s", time), force, measured];
        (Record { name: format!("{frequency}.csv"), regime: Regime::Steady, use_for: None, channels }, result)
    };
    let text = section(&compared(vec![of(30.0), of(50.0)])).unwrap();
    // In resonance 90° behind, of which the force's own 0.7 rad go off once more.
    let behind = -90.0 - 0.7 * 360.0 / TAU;
    assert!(text.contains("50.00 3 N") && text.contains("+10 %"), "{text}");
    assert!(
        text.contains(&format!("−{:.1}", -behind)) && text.contains(&format!("{:.1}", behind + 270.0)),
        "{text}"
    );
}

#[test]
fn a_slow_sweep_gives_the_peak_that_it_passes() {
    let (natural, damping, step) = (20.0, 0.03, 5e-4);
    let (own, rate) = (TAU * natural, 0.25);
    let time: Vec<f64> = (0..80_000).map(|i| f64::from(i) * step).collect();
    let force: Vec<f64> = time.iter().map(|t| (TAU * (14.0 * t + 0.5 * rate * t * t)).sin()).collect();
    // Semi-implicit steps of 1 kg, from rest.
    let (mut place, mut speed) = (0.0, 0.0);
    let moved: Vec<f64> = (force.iter())
        .map(|force| {
            speed += step * (force - 2.0 * damping * own * speed - own * own * place);
            place += step * speed;
            place
        })
        .collect();
    let measured = channel("displacement:m1", "m", moved.clone());
    let result = result(&measured, moved);
    let channels = vec![channel("time", "s", time), channel("excitation:m1", "N", force), measured];
    let record = Record { name: "sweep.csv".into(), regime: Regime::FromRest, use_for: None, channels };
    let text = section(&compared(vec![(record, result)])).unwrap();
    let row: Vec<&str> = text.split("sweep.csv ").nth(1).unwrap().split(' ').collect();
    let (found, decay): (f64, f64) = (row[0].parse().unwrap(), row[2].parse().unwrap());
    assert!((found / natural - 1.0).abs() < 0.01 && (decay / 3.0 - 1.0).abs() < 0.1, "{text}");
}

#[test]
fn records_that_are_neither_have_no_such_section() {
    assert!(section(&crate::synthetic::backbone()).is_none());
}
