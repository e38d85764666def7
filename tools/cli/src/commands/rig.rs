//! `stickslip rig`

use std::path::{Path, PathBuf};
use std::sync::Arc;

use stickslip::data::{Dataset, Record};
use stickslip::rig::{RigError, RigProgress, Tested, test_with_truth_on};
use stickslip_readers::{RigPlan, dataset_toml, read_plan, record_csv, truth_toml};

use super::shown;
use crate::Failure;
use crate::output::{Folder, say};
use crate::progress::{self, Progress};

/// Arguments of `stickslip rig`.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  stickslip rig examples/frictional-support/rig.toml -o measured
  stickslip compare examples/frictional-support/valanis.toml measured

Exit codes: 0 done; 1 failed; 2 bad input; 130 interrupted by Ctrl-C. Where it is not 0 nothing is written.")]
pub struct Rig {
    /// The plan: the model of a beam or a pin rig, its sensors, the tests
    plan: PathBuf,
    /// Folder for dataset.toml, a CSV file per record, and what the rig knows beside it in truth/; made, or empty
    #[arg(short, long, value_name = "DIR")]
    out: PathBuf,
}

/// Parts of a record in which progress is shown.
const PARTS: f64 = 100.0;

impl Rig {
    /// Makes all tests and writes their records.
    pub fn run(self) -> Result<(), Failure> {
        let folder = Folder::check(&self.out)?;
        let plan = read_plan(&self.plan).map_err(shown)?;
        let tested = match made(&plan)? {
            Ok(tested) => tested,
            Err(RigError::Interrupted) => {
                tell!("note: interrupted; nothing was written");
                return Ok(());
            }
            Err(error @ RigError::Input(_)) => return Err(of_plan(&self.plan, &error, Failure::input)),
            Err(error) => return Err(of_plan(&self.plan, &error, Failure::other)),
        };
        let mut files = truth(&plan, &tested).map_err(|error| of_plan(&self.plan, &error, Failure::input))?;
        let records: Vec<Record> = tested.into_iter().map(|tested| tested.record).collect();
        say(&summary(&plan, &records))?;
        let dataset = Dataset { title: plan.title.clone(), records };
        files.push(("dataset.toml".to_owned(), dataset_toml(&dataset)));
        files.extend(dataset.records.iter().map(|record| (record.name.clone(), record_csv(record))));
        folder.write(&files)?;
        say(&format!("wrote {} with {} records\n", self.out.display(), dataset.records.len()))
    }
}

/// The records of all tests.
fn made(plan: &RigPlan) -> Result<Result<Vec<Tested>, RigError>, Failure> {
    let (model, tests) = (plan.model.clone(), plan.plan.clone());
    let meter = Arc::new(Progress::new());
    let shown = Arc::clone(&meter);
    let made = progress::left_when_interrupted(move || {
        test_with_truth_on(&model, &tests, &mut |at: &RigProgress| {
            shown.show(at.record, (PARTS * at.done) as usize, PARTS as usize * at.of);
            !progress::interrupted()
        })
    })?;
    meter.clear();
    Ok(made.unwrap_or(Err(RigError::Interrupted)))
}

/// What the rig knows, in `truth/`: the chain as it was drawn, the beam that was tested, what the contact did. Beside the
/// dataset the model with the masses of the accelerometers, if they have any and it is to be told.
fn truth(plan: &RigPlan, tested: &[Tested]) -> Result<Vec<(String, String)>, RigError> {
    let model = plan.plan.beam_under_test(&plan.model)?.to_toml();
    let weighing = plan.plan.sensors.iter().any(|sensor| sensor.mass != 0.0);
    let mut files = vec![("truth/rig.toml".to_owned(), truth_toml(&plan.plan))];
    if weighing && plan.masses_told {
        files.push(("model.toml".to_owned(), model.clone()));
    }
    files.push(("truth/model.toml".to_owned(), model));
    let contacts = tested.iter().filter_map(|tested| tested.contact.as_ref());
    files.extend(contacts.map(|record| (format!("truth/{}", record.name), record_csv(record))));
    Ok(files)
}

fn of_plan(plan: &Path, error: &RigError, failure: fn(String) -> Failure) -> Failure {
    failure(format!("{}: {error}", plan.display()))
}

/// A line per record and one about the gains.
fn summary(plan: &RigPlan, records: &[Record]) -> String {
    let width = records.iter().map(|record| record.name.len()).max().unwrap_or(0);
    let line = |record: &Record| {
        let largest = |name: &str| {
            let values = record.channels_of(name).flat_map(|channel| &channel.values);
            values.fold(0.0_f64, |most, value| most.max(value.abs()))
        };
        let force = match largest("excitation") {
            0.0 => "released".to_owned(),
            force => format!("force up to {force:.4} N"),
        };
        format!(
            "{:width$}  {} samples, {force}, acceleration up to {:.4} m/s^2\n",
            record.name,
            record.len(),
            largest("acceleration")
        )
    };
    let mut text: String = records.iter().map(line).collect();
    let faults = plan.plan.chain.faults(plan.plan.sensors.len());
    if faults.iter().any(|fault| fault.gain != 1.0) {
        let gains: Vec<String> = faults.iter().map(|fault| format!("{:.5}", fault.gain)).collect();
        text += &format!("gains of the load cell and the accelerometers: {}\n", gains.join(", "));
    }
    text
}
