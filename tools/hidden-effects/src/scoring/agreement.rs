//! The program's models with everything hidden written into them, against the generator's data: where the two
//! mean the same physics only the noise is left.

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};

use rayon::prelude::*;
use serde_json::Value;

use crate::cases::case::Case;
use crate::cases::files;

/// Prints the error of each case's true model over the noise.
///
/// # Errors
/// A folder that cannot be written, a case that cannot be made.
pub fn show(program: &Path, root: &Path, models: &Path, cases: &[Case]) -> Result<(), String> {
    fs::create_dir_all(models).map_err(|error| format!("{}: {error}", models.display()))?;
    println!("| case | error over noise |\n|---|---:|");
    cases.par_iter().filter(|case| !case.is_outside()).try_for_each(|case| {
        let said = match compare(program, root, models, case)? {
            Ok(error) => format!("{:.3}", error / case.noise.share),
            Err(message) => message.replace('\n', " "),
        };
        println!("| {} | {said} |", case.name());
        Ok(())
    })
}

/// The error that `compare` tells, or its message.
fn compare(program: &Path, root: &Path, models: &Path, case: &Case) -> Result<Result<f64, String>, String> {
    let folder = files::write(root, case)?;
    let model = models.join(format!("{}.toml", case.name()));
    let answer = models.join(format!("{}.json", case.name()));
    let text = case.draw()?.true_model().ok_or("outside the catalogue")?;
    fs::write(&model, text).map_err(|error| format!("{}: {error}", model.display()))?;
    let mut command = Command::new(program);
    command.arg("compare").arg(&model).arg(folder.join("dataset.toml")).arg("--json").arg(&answer);
    let output =
        command.stdin(Stdio::null()).output().map_err(|error| format!("{}: {error}", program.display()))?;
    let json = fs::read_to_string(&answer).ok().and_then(|text| serde_json::from_str::<Value>(&text).ok());
    let error = json.as_ref().and_then(|json| json.get("error")?.get("baseline")?.as_f64());
    Ok(error.ok_or_else(|| String::from_utf8_lossy(&output.stderr).into_owned()))
}
