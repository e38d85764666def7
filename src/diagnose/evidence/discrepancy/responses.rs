//! What a structure shows of forces at its contact that follow the motion, to first order: the motion that they follow is that of
//! the model without them.

use rayon::prelude::*;

use super::tables::{ContactMotion, Extremes, largest, of_force};
use crate::data::{Channel, Record, Regime};
use crate::diagnose::evidence::joint::{first_failure, minus};
use crate::diagnose::evidence::latent::Latent;
use crate::diagnose::evidence::measured::{Measured, MeasuredChannel};
use crate::effects::Part;
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

/// Responses to the tables, of size one in the channels as they are where they are largest.
///
/// # Errors
/// Why there are none: only oscillators from rest pass a force on without any other change of their past.
pub(super) fn columns(data: &Measured, model: &Model) -> Result<Latent, String> {
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
    let motion = |k: usize| ContactMotion { motion: &contacts[k].motion, time: record(k).time() };
    let extremes = Extremes::of((0..count).map(motion));
    let strongest = largest(contacts.iter().flat_map(|contact| contact.force.iter().copied()));
    let of_record = |k: usize| {
        let tables = of_force(&motion(k), &contacts[k].force, &extremes);
        responses(data, model, k, (mass, SECANT * strongest), &tables)
    };
    let responses = first_failure((0..count).into_par_iter().map(of_record))?;
    data.bench.count(responses.iter().map(|of| 3 + of.len()).sum());
    Ok(of_size_one(data, responses))
}

/// Those tables that all records have a response to and some show.
fn of_size_one(data: &Measured, mut responses: Vec<Vec<Option<Vec<f64>>>>) -> Latent {
    let tables = responses.iter().map(Vec::len).min().unwrap_or(0);
    let channels = || data.channels.iter().flatten();
    let of = |process: usize| largest(channels().filter(|c| c.process == process).map(|c| c.size));
    let references: Vec<f64> = (0..data.processes).map(of).collect();
    let part = |column: &[f64], MeasuredChannel { range, process, .. }: &MeasuredChannel| {
        let square: f64 = column[range.clone()].iter().map(|x| x * x).sum();
        (square / range.len() as f64).sqrt() / references[*process]
    };
    let size = |w: usize| -> Option<f64> {
        let of = |(k, of): (usize, &Vec<Option<Vec<f64>>>)| {
            let column = of[w].as_ref()?;
            Some(largest(data.channels[k].iter().map(|channel| part(column, channel))))
        };
        Some(largest(responses.iter().enumerate().map(of).collect::<Option<Vec<f64>>>()?.into_iter()))
    };
    let sizes: Vec<Option<f64>> = (0..tables).map(size).collect();
    let least = NOTHING * largest(sizes.iter().flatten().copied());
    let mut latent = Latent { count: 0, columns: vec![Vec::new(); responses.len()] };
    for (w, size) in sizes.into_iter().enumerate() {
        let Some(size) = size.filter(|size| *size > least) else { continue };
        for (own, responses) in latent.columns.iter_mut().zip(&mut responses) {
            let mut column = responses[w].take().unwrap_or_default();
            column.iter_mut().for_each(|x| *x /= size);
            own.push((latent.count, column));
        }
        latent.count += 1;
    }
    latent
}

/// What moves the contact at `mass` of `model` through `record`, and its force.
fn of_contact(model: &Model, mass: &str, record: &Record) -> Result<OfContact, String> {
    let mut model = model.clone();
    model.effects.retain(|applied| applied.effect.part != Part::Sensor);
    let channel = |name: String, unit, values| Channel { name, unit, values, noise: None };
    let step = record.sample_step().ok_or("the samples are not evenly spaced")?;
    let still = vec![0.0; record.len()];
    let mut shown = record.clone();
    shown.channels.retain(|channel| ["time", "excitation", "normal_load"].contains(&channel.quantity()));
    shown.channels.push(channel(format!("displacement:{mass}"), "m", still.clone()));
    let first = |model: &Model, record: &Record| {
        let predicted = predict(model, record).map_err(|error| error.to_string())?;
        predicted.into_iter().next().map(|one| one.values).ok_or_else(|| "nothing is predicted".to_owned())
    };
    let values = first(&model, &shown)?;
    // The contact alone, moved as it is there.
    shown.channels.retain(|channel| ["time", "normal_load"].contains(&channel.quantity()));
    shown.channels.push(channel("displacement".to_owned(), "m", values.clone()));
    shown.channels.push(channel("force".to_owned(), "N", still));
    let force = first(&Model { structure: Structure::Prescribed, ..model }, &shown)?;
    Ok(OfContact { motion: Motion::even(&values, step), force })
}

/// What a force at a mass, of so many newtons, changes of the predictions of record `k` where it follows each of `tables`; `None`
/// where that cannot be predicted.
fn responses(
    data: &Measured,
    model: &Model,
    k: usize,
    (mass, size): (&str, f64),
    tables: &[Vec<f64>],
) -> Result<Vec<Option<Vec<f64>>>, String> {
    let lane = data.lane(k);
    let predicted = |record: &Record| {
        let mut predicted = Vec::new();
        lane.shown_as(model, record, None)?.predict(model, &[], &mut predicted)?;
        Ok::<_, String>(predicted)
    };
    let mut still = lane.record.clone();
    let name = format!("excitation:{mass}");
    let place = still.channels.iter().position(|channel| channel.name == name);
    let place = place.unwrap_or_else(|| {
        let values = vec![0.0; still.len()];
        still.channels.push(Channel { name, unit: "N", values, noise: None });
        still.channels.len() - 1
    });
    let here = predicted(&still)?;
    let of = |table: &Vec<f64>| {
        data.bench.unless_interrupted()?;
        let mut driven = still.clone();
        driven.channels[place].values.iter_mut().zip(table).for_each(|(force, part)| *force += size * part);
        let finite = |there: &Vec<f64>| there.iter().all(|x| x.is_finite());
        Ok(predicted(&driven).ok().filter(finite).map(|there| minus(&there, &here)))
    };
    first_failure(tables.par_iter().map(of))
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

    /// Log evidence of a discrepancy that matters beside the fit of a model without effects to `dataset`, of whose noise nothing is
    /// known.
    fn doubted(dataset: &Dataset) -> Option<f64> {
        let given = oscillator(1.05 * STIFFNESS, 0.45);
        let bench = WeightedDataset::new(&given, dataset, Assumptions::default(), None).unwrap();
        let data = Measured::new(&bench, &[0, 1, 2], &[], &[]);
        let fitted = first(&data, None, &given).and_then(|(first, _)| again(&data, &first)).unwrap();
        doubt(&data, &fitted).ok()
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
            assert!(doubt.is_none_or(|doubt| doubt < 0.0), "{size}, {memory}: {doubt:?}");
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
            assert!(doubt.is_some_and(|doubt| doubt > least), "{effect}: {doubt:?}");
        }
    }

    /// In stick, and under a force that begins at once, as the records' do not.
    #[test]
    fn a_constant_force_moves_a_mass_as_a_spring_and_a_damper_let_it() {
        let (model, dataset) = (oscillator(STIFFNESS, 50.0), measured(&oscillator(STIFFNESS, 50.0), || 0.0));
        let bench = WeightedDataset::new(&model, &dataset, Assumptions::default(), None).unwrap();
        let data = Measured::new(&bench, &[0, 1, 2], &[], &[]);
        let force = 0.5;
        let moved = responses(&data, &model, 1, ("m1", force), &[vec![1.0; 800]]).unwrap().remove(0).unwrap();
        let stiffness = 4e3 + STIFFNESS;
        let (decay, frequency) = (0.5, (stiffness - 0.25_f64).sqrt());
        for (i, moved) in moved.iter().enumerate() {
            let time = 2e-3 * i as f64;
            let swing = (frequency * time).cos() + decay / frequency * (frequency * time).sin();
            let expected = force / stiffness * (1.0 - (-decay * time).exp() * swing);
            assert!((moved - expected).abs() < 0.02 * force / stiffness, "{time} s: {moved} for {expected}");
        }
    }

    #[test]
    fn a_force_at_a_mass_that_nothing_excites_moves_both() {
        let two = Model::parse(
            "schema = \"stickslip.model/1\"\nkind = \"oscillator\"\n[[mass]]\nname = \"m1\"\nmass = 1.0\n\
             [[mass]]\nname = \"m2\"\nmass = 2.0\n[[spring]]\nbetween = [\"ground\", \"m1\"]\nstiffness = 4e3\n\
             damping = 30.0\n[[spring]]\nbetween = [\"m1\", \"m2\"]\nstiffness = 2e3\ndamping = 30.0\n[contact]\n\
             at = \"m2\"\nlaw = \"jenkins\"\ntangential_stiffness = 1e3\nfriction_coefficient = 50.0\n\
             normal_load = 10.0\n",
        )
        .unwrap();
        let mut record = from_rest(1.0);
        let other = Channel { name: "displacement:m2".into(), ..record.channels[2].clone() };
        record.channels.push(other);
        for channel in 2..4 {
            record.channels[channel].values = predict(&two, &record).unwrap()[channel - 2].values.clone();
        }
        let dataset = Dataset { title: None, records: vec![record] };
        let bench = WeightedDataset::new(&two, &dataset, Assumptions::default(), None).unwrap();
        let data = Measured::new(&bench, &[0], &[], &[]);
        let moved = responses(&data, &two, 0, ("m2", 0.5), &[vec![1.0; 800]]).unwrap().remove(0).unwrap();
        // At rest in the end: three springs, the one of the contact beside a chain of the two others.
        let at_m2 = 0.5 / (1e3 + 1.0 / (1.0 / 4e3 + 1.0 / 2e3));
        for (end, expected) in [(moved[799], at_m2 * 2e3 / 6e3), (moved[1599], at_m2)] {
            assert!((end / expected - 1.0).abs() < 0.01, "{end} m for {expected} m");
        }
    }
}
