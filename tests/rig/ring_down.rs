//! Free decay.

use std::f64::consts::TAU;

use stickslip::data::{Record, Regime};
use stickslip::model::{Model, Structure};
use stickslip::rig::{Release, RingDown, SteppedSine, TestKind};
use stickslip::system::ModalBeam;

use crate::{accelerations, published, record_of};

fn released(model: &Model, from: Release, duration: f64) -> Record {
    record_of(model, TestKind::RingDown(RingDown { from: vec![from], duration, sampling: 4096.0 }))
}

/// Frequency (Hz) and damping ratio of the sensor at the middle between two times (s), by its crossings of zero and the
/// extremes between them.
fn decay(record: &Record, from: f64, to: f64) -> (f64, f64) {
    let (time, values) = (record.time().unwrap(), accelerations(record)[1]);
    let inside = |k: &usize| (from..to).contains(&time[*k]) && values[*k - 1] < 0.0 && values[*k] >= 0.0;
    let rising: Vec<usize> = (1..values.len()).filter(inside).collect();
    let crossing = |k: usize| time[k] - values[k] / (values[k] - values[k - 1]) * (time[1] - time[0]);
    let cycles = (rising.len() - 1) as f64;
    let (first, last) = (rising[0], rising[rising.len() - 1]);
    let frequency = cycles / (crossing(last) - crossing(first));
    // Energy of the first and of the last quarter of the cycles.
    let quarter = rising.len() / 4;
    let energy = |from: usize, to: usize| values[from..to].iter().map(|a| a * a).sum::<f64>();
    let begun = energy(first, rising[quarter]);
    let ended = energy(rising[rising.len() - 1 - quarter], last);
    let apart = cycles - quarter as f64;
    (frequency, (begun / ended).ln() / (2.0 * TAU * apart))
}

#[test]
fn a_beam_without_friction_decays_with_its_damping() {
    let model = Model::parse(include_str!("../../examples/frictional-support/linear.toml")).unwrap();
    for from in [Release::Held(5.0), Release::Force(2.0)] {
        let record = released(&model, from, 6.0);
        assert_eq!(record.regime, Regime::UnknownInitialState);
        assert!(record.channel("excitation").is_none());
        let (frequency, damping) = decay(&record, 1.0, 6.0);
        assert!((frequency / 52.85 - 1.0).abs() < 3e-4, "{from:?}: {frequency}");
        assert!((damping / 0.003 - 1.0).abs() < 0.01, "{from:?}: {damping}");
    }
}

#[test]
fn a_beam_with_a_hanging_mass_decays_as_the_linear_mode_of_both() {
    let hung = "\n[[effect]]\nid = \"hanging_mass\"\nmass = 3.0\nhanging_frequency = 90.0\n";
    let text = include_str!("../../examples/frictional-support/linear.toml");
    let model = Model::parse(&format!("{text}{hung}")).unwrap();
    let linear = model.system().unwrap().linear_part();
    let modes = linear.natural_modes().unwrap();
    let (omega, shape) = (modes.angular_frequency[0], modes.shapes.column(0));
    let rate: f64 = linear.damping.iter().map(|(i, j, c)| shape[*i] * c * shape[*j]).sum();
    for from in [Release::Held(5.0), Release::Force(2.0)] {
        let (frequency, damping) = decay(&released(&model, from, 6.0), 1.0, 6.0);
        assert!((frequency * TAU / omega - 1.0).abs() < 3e-4, "{from:?}: {frequency}");
        assert!((damping / (0.5 * rate / omega) - 1.0).abs() < 0.01, "{from:?}: {damping}");
    }
}

#[test]
fn with_friction_it_decays_faster_and_lower_the_larger_it_moves() {
    let model = published(6, |text| text);
    let record = released(&model, Release::Held(40.0), 6.0);
    let early = decay(&record, 0.0, 0.15);
    let late = decay(&record, 4.0, 6.0);
    assert!(early.1 > 10.0 * late.1 && early.0 < late.0 - 1.0, "{early:?} {late:?}");
    // The contact hardly slips any more: it stiffens the beam, whose dampers are those of the beam without it.
    let Structure::Beam(beam) = &model.structure else { panic!("a beam") };
    let free = ModalBeam::new(beam).unwrap().angular_frequency[0] / TAU;
    assert!((late.1 / (0.003 * free / late.0) - 1.0).abs() < 0.03, "{late:?} {free}");
}

#[test]
fn the_record_begins_where_the_force_of_the_steady_record_passes_zero() {
    let model = published(6, |text| text);
    let record = released(&model, Release::Held(40.0), 0.5);
    let steady = record_of(&model, TestKind::SteppedSine(SteppedSine::at(vec![40.0])));
    for (free, held) in accelerations(&record).into_iter().zip(accelerations(&steady)) {
        // A quarter of 256 samples after the force's largest value.
        assert!((free[0] / held[64] - 1.0).abs() < 0.01, "{} {}", free[0], held[64]);
        let largest = free[1500..].iter().fold(0.0_f64, |most, a| most.max(a.abs()));
        assert!(largest < 0.5 * held[64].abs(), "{largest}");
    }
}
