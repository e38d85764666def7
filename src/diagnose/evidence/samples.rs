//! Measurements for tests, and searches in them.

use super::measured::Measured;
use super::posterior::Posterior;
use super::search::Search;
use super::{again, first, probe};
use crate::data::{Channel, Dataset, Record, Regime};
use crate::diagnose::assumptions::Assumptions;
use crate::diagnose::candidates::tried;
use crate::diagnose::measurements::magnitudes;
use crate::diagnose::measurements::weighted_dataset::WeightedDataset;
use crate::fit::predict::predict;
use crate::model::Model;

/// A beam of a modulus (Pa) and a coefficient of friction, with what `effects` write.
pub(super) fn beam(modulus: f64, friction: f64, effects: &str) -> Model {
    Model::parse(&format!(
        "schema = \"stickslip.model/1\"\nkind = \"beam\"\nsupport = {{ offset = 0.006 }}\n\
         excitation = {{ position = 0.55 }}\n[contact]\nlaw = \"jenkins\"\ntangential_stiffness = 7e6\n\
         friction_coefficient = {friction}\nnormal_load = 150.0\n[beam]\nlength = 0.6\nwidth = 0.04\n\
         thickness = 0.005\ndensity = 7850.0\nyoungs_modulus = {modulus}\nmodes = 3\n\
         damping_ratio = 0.004\n{effects}"
    ))
    .unwrap()
}

/// A beam at three levels with a little noise, the support within what it yields at and beyond.
pub(super) fn steady(truth: &Model) -> Dataset {
    steady_at(truth, &[(1.0, 55.0), (6.0, 55.0), (15.0, 55.0)])
}

/// The same under forces (N) at frequencies (Hz).
pub(super) fn steady_at(truth: &Model, levels: &[(f64, f64)]) -> Dataset {
    const SAMPLES: usize = 96;
    let channel = |name: &str, unit, values| Channel { name: name.into(), unit, values, noise: None };
    let mut noise = fastrand::Rng::with_seed(7);
    let mut record = |(amplitude, frequency): &(f64, f64)| {
        let time: Vec<f64> = (0..SAMPLES).map(|k| k as f64 / (SAMPLES as f64 * frequency)).collect();
        let cosine = |t: &f64| amplitude * (std::f64::consts::TAU * frequency * t).cos();
        let force = time.iter().map(cosine).collect();
        let channels = vec![
            channel("time", "s", time),
            channel("excitation", "N", force),
            channel("acceleration:x=0.55", "m/s^2", (0..SAMPLES).map(|k| k as f64).collect()),
        ];
        let name = format!("{amplitude} N at {frequency} Hz");
        let mut record = Record { name, regime: Regime::Steady, use_for: None, channels };
        let motion = predict(truth, &record).unwrap()[0].values.clone();
        let size = 0.01 * motion.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        record.channels[2].values = motion.iter().map(|x| x + size * (noise.f64() - 0.5)).collect();
        record
    };
    Dataset { title: None, records: levels.iter().map(&mut record).collect() }
}

/// A contact that is moved as measured: one slider, with what `effects` write.
pub(super) fn slider(effects: &str) -> Model {
    Model::parse(&format!(
        "schema = \"stickslip.model/1\"\nkind = \"contact\"\n[contact]\nlaw = \"jenkins\"\n\
         tangential_stiffness = 2e6\nfriction_coefficient = 0.5\nnormal_load = 100.0\n{effects}"
    ))
    .unwrap()
}

/// It is moved from rest by `motion` (m) of the number of a sample, `count` of them every `step` seconds; its force is exact.
pub(super) fn moved(truth: &Model, count: u32, step: f64, motion: impl Fn(u32) -> f64) -> Record {
    let channel = |name: &str, unit, values| Channel { name: name.into(), unit, values, noise: None };
    let channels = vec![
        channel("time", "s", (0..count).map(|i| step * f64::from(i)).collect()),
        channel("displacement", "m", (0..count).map(motion).collect()),
        channel("force", "N", vec![0.0; count as usize]),
    ];
    let mut record = Record { name: "r".into(), regime: Regime::FromRest, use_for: None, channels };
    record.channels[2].values = predict(truth, &record).unwrap()[0].values.clone();
    record
}

/// A mass on a spring and a contact.
pub(super) fn oscillator(stiffness: f64, friction: f64) -> Model {
    Model::parse(&format!(
        "schema = \"stickslip.model/1\"\nkind = \"oscillator\"\n[[mass]]\nname = \"m1\"\nmass = 1.0\n\
         [[spring]]\nbetween = [\"ground\", \"m1\"]\nstiffness = 4e3\ndamping = 1.0\n[contact]\nat = \"m1\"\n\
         law = \"jenkins\"\ntangential_stiffness = {stiffness}\nfriction_coefficient = {friction}\n\
         normal_load = 10.0\n"
    ))
    .unwrap()
}

/// It is excited from rest by a sine of so many newtons, which the contact slips at; its motion is not measured yet.
pub(super) fn from_rest(amplitude: f64) -> Record {
    let channel = |name: &str, unit, values| Channel { name: name.into(), unit, values, noise: None };
    let channels = vec![
        channel("time", "s", (0..800).map(|i| f64::from(i) * 2e-3).collect()),
        channel("excitation:m1", "N", (0..800).map(|i| amplitude * (0.13 * f64::from(i)).sin()).collect()),
        channel("displacement:m1", "m", vec![0.0; 800]),
    ];
    Record { name: "r".into(), regime: Regime::FromRest, use_for: None, channels }
}

/// What `of` makes of a search for these effects, for all where `only` names none, beside `given` in all records of `dataset`, and
/// of the fit without them. Where motions are solved for, first looks are about those that were measured.
pub(super) fn searching<T>(
    given: &Model,
    dataset: &Dataset,
    only: &[&str],
    most: usize,
    of: impl FnOnce(&Search, Posterior) -> T,
) -> T {
    let bench = WeightedDataset::new(given, dataset, Assumptions::default(), None).unwrap();
    let about = bench.linearised_at_measurement();
    let records: Vec<usize> = (0..dataset.records.len()).collect();
    let measured = |bench| Measured::new(bench, &records, &[], &[]);
    let (data, looks) = (measured(&bench), about.as_ref().map(measured));
    let base = first(&data, None, given).and_then(|(first, _)| again(&data, &first)).unwrap();
    let only: Vec<String> = only.iter().map(|id| (*id).to_owned()).collect();
    let (tried, _) = tried(given, &bench, (!only.is_empty()).then_some(&only[..]));
    let scales = magnitudes::of(given, dataset);
    let candidates = probe::prepare(&data, &base, &tried, &scales, dataset).unwrap().prepared;
    let (candidates, looks) = (&candidates[..], looks.as_ref());
    of(&Search { data: &data, looks, beginnings: &[], candidates, most, report: &|_| {} }, base)
}
