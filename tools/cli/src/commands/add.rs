//! `stickslip add`

use std::path::PathBuf;

use stickslip::data::Dataset;
use stickslip::diagnose::{Comparison, add, noise_of};
use stickslip::effects::{Effect, Location, PlaceKind};
use stickslip::model::{Model, Structure};
use stickslip_report::diagnosis::added_json;

use super::diagnose::{effect, failed, watched};
use super::{
    Measured, check_destinations, checked, colored, dataset_file, list, read_measured, read_model, settings,
    tables, title_of, unused,
};
use crate::output::{Outputs, say};
use crate::{Failure, LoneFile, ResultFiles, progress};

/// Arguments of `stickslip add`.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  stickslip add model.toml backlash --fit data/ -o improved.toml
  stickslip add model.toml added_mass@m2 --fit data/ -o improved.toml --report before-and-after.html
  stickslip add model.toml sensor_offset@force --fit data/ -o improved.toml

Exit codes: 0 done; 1 failed; 2 bad input (nothing is written); 130 interrupted by Ctrl-C.")]
pub struct Add {
    /// The model file, or an FMU that carries one
    model: PathBuf,
    /// The effect (see `stickslip effects`), with its place if it has one: a mass, a position x=0.55, a channel
    #[arg(value_name = "EFFECT[@PLACE]")]
    effect: String,
    /// The dataset that the new model is fitted to: `dataset.toml` or the folder that holds it
    #[arg(long, value_name = "DATASET")]
    fit: PathBuf,
    /// The new model
    #[arg(short, long, value_name = "NEW.toml")]
    out: PathBuf,
    /// Write measured, predicted and residual values of every record, `RECORD-compared.csv`, to this folder
    #[arg(long, value_name = "DIR")]
    csv: Option<PathBuf>,
    #[command(flatten)]
    lone: LoneFile,
    #[command(flatten)]
    files: ResultFiles,
}

impl Add {
    /// Adds the effect, refits, and shows the error before and after.
    pub fn run(self) -> Result<(), Failure> {
        check_destinations(&self.files, [&self.out], &[self.model.clone(), dataset_file(&self.fit)])?;
        let (id, place) = match self.effect.split_once('@') {
            Some((id, place)) => (id, Some(place)),
            None => (self.effect.as_str(), None),
        };
        let effect = effect(id)?;
        let model = read_model(&self.model)?;
        let Measured { dataset, ring_downs, mut notes, files } =
            read_measured(&self.fit, &model, &self.lone)?;
        check_kind(effect, &model)?;
        let location = location(effect, place, &model, &dataset)?;
        if model.effects.iter().any(|other| other.effect == effect && other.location == location) {
            return Err(Failure::input(format!(
                "{} has the effect `{}` already; `stickslip compare` fits its values",
                self.model.display(),
                self.effect
            )));
        }
        let mut read = vec![self.model.clone()];
        read.extend(files);
        let folder = self.csv.as_deref();
        let out = Some(self.out.clone());
        tables::check(&self.files, &out, folder, tables::compared(folder, &dataset.records), &read)?;
        let settings = settings(&read.iter().map(PathBuf::as_path).collect::<Vec<_>>())?;

        let findings = checked(&model, &dataset);
        notes.extend(unused(&model, &dataset));
        let noise = noise_of(&model, &dataset);
        let done = watched(|watch| add(&model, effect, location.clone(), &dataset, watch)).map_err(failed)?;
        if progress::interrupted() {
            tell!("note: interrupted; these are the results so far");
        }
        let data = title_of(&dataset, &self.fit);
        let title = format!("{} added: {data}", effect.title);
        let comparison =
            Comparison { title, records: dataset.records, ring_downs, findings, notes, stages: done.stages };
        say(&stickslip_report::terminal_table(&comparison, &noise, 80, colored()))?;
        let mut outputs = Outputs::default();
        outputs.add(&self.out, done.model.to_toml());
        if let Some(path) = &self.files.json {
            let place = location.as_ref().map(ToString::to_string);
            let json = stickslip_report::json(&comparison, &noise);
            let out = self.out.display().to_string();
            outputs.add(path, format!("{:#}\n", added_json(id, place.as_deref(), &out, &json)));
        }
        list(&outputs.write_results()?)?;
        if let Some(path) = &self.files.report {
            outputs.add(path, stickslip_report::html(&comparison, &noise, &settings));
        }
        tables::add(folder, &comparison, &mut outputs)?;
        list(&outputs.write()?)
    }
}

fn check_kind(effect: &Effect, model: &Model) -> Result<(), Failure> {
    if effect.kinds.contains(&model.kind()) {
        return Ok(());
    }
    let kind = format!("{:?}", model.kind()).to_lowercase();
    Err(Failure::input(format!("`{}` is no effect of a model of kind \"{kind}\"", effect.id)))
}

/// The place of the effect, as the effect needs it.
fn location(
    effect: &Effect,
    place: Option<&str>,
    model: &Model,
    dataset: &Dataset,
) -> Result<Option<Location>, Failure> {
    let id = effect.id;
    let parsed = match (effect.place, place) {
        (PlaceKind::Nowhere, None) => return Ok(None),
        (PlaceKind::Nowhere, Some(place)) => {
            return Err(Failure::input(format!("`{id}` needs no place; remove `@{place}`")));
        }
        (_, None) => {
            let places = places(effect, model, dataset);
            return Err(Failure::input(format!("say where: {}", places.join(", "))));
        }
        (PlaceKind::Structure, Some(place)) => Location::parse_at(place),
        (PlaceKind::Channel, Some(place)) => Location::parse_channel(place),
    };
    let location = parsed.map_err(|error| Failure::input(error.to_string()))?;
    let missing = match (&location, &model.structure) {
        (Location::Mass(name), Structure::Oscillator(oscillator)) => {
            !oscillator.masses.iter().any(|mass| mass.name == *name)
        }
        (Location::Position(at), structure) if structure.beam().is_some() => {
            structure.beam().is_none_or(|beam| !(0.0..=beam.length).contains(at))
        }
        (Location::Channel(name), _) => {
            !dataset.records.iter().any(|record| record.channels.iter().any(|channel| channel.name == *name))
        }
        _ => true,
    };
    if missing {
        let places = places(effect, model, dataset);
        let place = place.unwrap_or_default();
        return Err(Failure::input(format!(
            "there is no place `{place}`; possible are {}",
            places.join(", ")
        )));
    }
    Ok(Some(location))
}

/// What could be written on the command line.
fn places(effect: &Effect, model: &Model, dataset: &Dataset) -> Vec<String> {
    let id = effect.id;
    let mut all: Vec<String> = match (effect.place, &model.structure) {
        (PlaceKind::Channel, _) => {
            let channels = dataset.records.iter().flat_map(|record| &record.channels);
            channels
                .filter(|channel| channel.name != "time")
                .map(|channel| format!("{id}@{}", channel.name))
                .collect()
        }
        (_, Structure::Oscillator(oscillator)) => {
            oscillator.masses.iter().map(|mass| format!("{id}@{}", mass.name)).collect()
        }
        (_, structure) => {
            structure.beam().map(|beam| format!("{id}@x=0 … {id}@x={}", beam.length)).into_iter().collect()
        }
    };
    let mut seen = Vec::new();
    all.retain(|place| {
        !seen.contains(place) && {
            seen.push(place.clone());
            true
        }
    });
    all
}
