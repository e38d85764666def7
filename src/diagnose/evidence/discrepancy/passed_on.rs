//! What a structure passes on of forces at its contact that follow the motion, to first order: the motion that they follow is that
//! of the model without them.

use rayon::prelude::*;

use super::tables::{Extremes, Moved, largest, of_force};
use crate::data::{Channel, Record, Regime};
use crate::diagnose::evidence::joint::{first_failure, minus};
use crate::diagnose::evidence::latent::Latent;
use crate::diagnose::evidence::measured::Measured;
use crate::diagnose::evidence::posterior::Posterior;
use crate::fit::predict::{Motion, predict};
use crate::model::{Model, Structure};

/// Size of the forces that derivatives are taken by, as a fraction of the contact's own.
const SECANT: f64 = 1e-3;
/// A response, as a fraction of the largest, that is none.
const NOTHING: f64 = 1e-9;

/// How the contact moves through one record, and its force (N).
struct OfContact {
    motion: Motion,
    force: Vec<f64>,
}

/// Responses to the tables, each of size one in the record where it is largest.
///
/// # Errors
/// Why there are none: only oscillators from rest pass a force on without any other change of their past.
pub(super) fn columns(data: &Measured, posterior: &Posterior) -> Result<Latent, String> {
    let model = &posterior.model;
    let mass = match &model.structure {
        Structure::Oscillator(structure) => structure.contact.map(|at| structure.masses[at].name.as_str()),
        _ => None,
    };
    let mass = mass.ok_or("no force at a contact is tried")?;
    let record = |k: usize| data.lane(k).record;
    let count = data.records.len();
    if (0..count).any(|k| record(k).regime != Regime::FromRest) {
        return Err("no force is tried that changes an unknown past".to_owned());
    }
    let contact = |k: usize| of_contact(model, mass, record(k));
    let contacts = first_failure((0..count).into_par_iter().map(contact))?;
    let moved = |k: usize| Moved { motion: &contacts[k].motion, time: record(k).time() };
    let most = Extremes::of((0..count).map(moved));
    let strongest = largest(contacts.iter().flat_map(|contact| contact.force.iter().copied()));
    let responses = |k: usize| {
        let tables = of_force(&moved(k), &contacts[k].force, &most);
        let of = |table: &Vec<f64>| {
            data.bench.unless_interrupted()?;
            response(data, posterior, k, (mass, SECANT * strongest), table)
        };
        first_failure(tables.par_iter().map(of))
    };
    let mut responses = first_failure((0..count).into_par_iter().map(responses))?;
    let tables = responses.iter().map(Vec::len).max().unwrap_or(0);
    data.bench.count(count * (2 + tables));
    let mut latent = Latent { count: 0, columns: vec![Vec::new(); count] };
    let sizes: Vec<f64> = (0..tables)
        .map(|w| largest(responses.iter().enumerate().map(|(k, of)| data.size_of(k, &of[w]))))
        .collect();
    let least = NOTHING * largest(sizes.iter().copied());
    for w in (0..tables).filter(|w| sizes[*w] > least) {
        for (own, responses) in latent.columns.iter_mut().zip(&mut responses) {
            let mut column = std::mem::take(&mut responses[w]);
            column.iter_mut().for_each(|x| *x /= sizes[w]);
            own.push((latent.count, column));
        }
        latent.count += 1;
    }
    Ok(latent)
}

/// What moves the contact at `mass` of `model` through `record`, and its force.
fn of_contact(model: &Model, mass: &str, record: &Record) -> Result<OfContact, String> {
    let channel = |name: String, unit, values| Channel { name, unit, values, noise: None };
    let step = record.sample_step().ok_or("the samples are not evenly spaced")?;
    let still = vec![0.0; record.len()];
    let is_input = |channel: &&Channel| ["time", "excitation", "normal_load"].contains(&channel.quantity());
    let mut shown =
        Record { channels: record.channels.iter().filter(is_input).cloned().collect(), ..record.clone() };
    shown.channels.push(channel(format!("displacement:{mass}"), "m", still.clone()));
    let first = |model: &Model, record: &Record| {
        let predicted = predict(model, record).map_err(|error| error.to_string())?;
        predicted.into_iter().next().map(|one| one.values).ok_or_else(|| "nothing is predicted".to_owned())
    };
    let values = first(model, &shown)?;
    // The contact alone, moved as it is there.
    shown.channels.retain(|channel| ["time", "normal_load"].contains(&channel.quantity()));
    shown.channels.push(channel("displacement".to_owned(), "m", values.clone()));
    shown.channels.push(channel("force".to_owned(), "N", still));
    let force = first(&Model { structure: Structure::Prescribed, ..model.clone() }, &shown)?;
    Ok(OfContact { motion: Motion::even(&values, step), force })
}

/// What a force at a mass, of so many newtons, changes of the predictions of record `k` where it follows `table`.
fn response(
    data: &Measured,
    posterior: &Posterior,
    k: usize,
    (mass, size): (&str, f64),
    table: &[f64],
) -> Result<Vec<f64>, String> {
    let (lane, model) = (data.lane(k), &posterior.model);
    let mut driven = lane.record.clone();
    let name = format!("excitation:{mass}");
    let place = driven.channels.iter().position(|channel| channel.name == name);
    let place = place.unwrap_or_else(|| {
        let values = vec![0.0; lane.record.len()];
        driven.channels.push(Channel { name, unit: "N", values, noise: None });
        driven.channels.len() - 1
    });
    driven.channels[place].values.iter_mut().zip(table).for_each(|(force, part)| *force += size * part);
    let mut shown = lane.shown_as(model, &driven, None)?;
    let mut predicted = Vec::new();
    shown.predict(model, &[], &mut predicted)?;
    Ok(minus(&predicted, &posterior.predictions[k]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::Dataset;
    use crate::diagnose::Assumptions;
    use crate::diagnose::evidence::samples::{from_rest, oscillator};
    use crate::diagnose::evidence::{again, doubt, first};
    use crate::diagnose::measurements::weighted_dataset::WeightedDataset;

    /// N/m.
    const STIFFNESS: f64 = 2e3;

    /// Records of `truth` with `noise` of so many samples, as fractions of the channel.
    fn measured(truth: &Model, mut noise: impl FnMut() -> f64) -> Dataset {
        let record = |amplitude: f64| {
            let mut record = from_rest(amplitude);
            let mut values = predict(truth, &record).unwrap()[0].values.clone();
            let size = (values.iter().map(|x| x * x).sum::<f64>() / values.len() as f64).sqrt();
            values.iter_mut().for_each(|x| *x += size * noise());
            record.channels[2].values = values;
            record
        };
        Dataset { title: None, records: [6.0, 9.0, 14.0].map(record).to_vec() }
    }

    /// Log evidence of a discrepancy beside the fit of a model without effects to `dataset`, of whose noise nothing is known.
    fn doubted(dataset: &Dataset) -> f64 {
        let given = oscillator(1.05 * STIFFNESS, 0.45);
        let bench = WeightedDataset::new(&given, dataset, Assumptions::default(), None).unwrap();
        let data = Measured::new(&bench, &[0, 1, 2], &[], &[]);
        let fitted = first(&data, None, &given).and_then(|(first, _)| again(&data, &first)).unwrap();
        doubt(&data, &fitted).unwrap()
    }

    #[test]
    fn noise_of_an_unknown_size_is_no_force_whatever_its_colour() {
        for (size, memory) in [(0.003, 0.0), (0.03, 0.0), (0.01, 0.8)] {
            let (mut random, mut last) = (fastrand::Rng::with_seed(3), 0.0);
            let noise = || {
                last = memory * last + size * (random.f64() + random.f64() + random.f64() - 1.5);
                last
            };
            let doubt = doubted(&measured(&oscillator(STIFFNESS, 0.4), noise));
            assert!(doubt < 0.0, "{size}, {memory}: {doubt}");
        }
    }

    #[test]
    fn what_the_contact_does_besides_is_no_noise_of_an_unknown_size() {
        let least = Assumptions::default().certainty();
        for effect in [
            "id = \"velocity_weakening\"\nweakening = 0.6\nweakening_velocity = 0.05\n",
            "id = \"asymmetry\"\nasymmetry = 0.3\n",
            "id = \"stiffening\"\ncubic_stiffness = 2e7\n",
        ] {
            let truth = format!("{}[[effect]]\n{effect}", oscillator(STIFFNESS, 0.4).to_toml());
            let mut random = fastrand::Rng::with_seed(3);
            let noise = || 0.01 * (random.f64() - 0.5);
            let doubt = doubted(&measured(&Model::parse(&truth).unwrap(), noise));
            assert!(doubt > least, "{effect}: {doubt}");
        }
    }

    /// In stick, and under a force that begins at once, as the records' do not.
    #[test]
    fn a_constant_force_moves_a_mass_as_a_spring_and_a_damper_let_it() {
        let (model, dataset) = (oscillator(STIFFNESS, 50.0), measured(&oscillator(STIFFNESS, 50.0), || 0.0));
        let bench = WeightedDataset::new(&model, &dataset, Assumptions::default(), None).unwrap();
        let data = Measured::new(&bench, &[0, 1, 2], &[], &[]);
        let (posterior, _) = first(&data, None, &model).unwrap();
        let force = 0.5;
        let moved = response(&data, &posterior, 1, ("m1", force), &[1.0; 800]).unwrap();
        let stiffness = 4e3 + STIFFNESS;
        let (decay, frequency) = (0.5, (stiffness - 0.25_f64).sqrt());
        for (i, moved) in moved.iter().enumerate() {
            let time = 2e-3 * i as f64;
            let swing = (frequency * time).cos() + decay / frequency * (frequency * time).sin();
            let expected = force / stiffness * (1.0 - (-decay * time).exp() * swing);
            assert!((moved - expected).abs() < 0.02 * force / stiffness, "{time} s: {moved} for {expected}");
        }
    }
}
