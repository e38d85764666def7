//! The stiffness of a pin rig's contact from natural frequencies.

use std::fmt::Write as _;
use std::path::Path;

use serde_json::{Value, json};
use stickslip::identify::{ContactStiffness, Estimate, MeasuredFrequencies, contact_stiffness};
use stickslip::model::Structure;
use stickslip_report::Settings;

use super::Identify;
use super::slip_slap::rig_of;
use crate::Failure;
use crate::commands::{check_destinations, list, read_model, settings};
use crate::output::{Outputs, say};

impl Identify {
    /// Young's modulus, k_t and k_n from `--frequencies`.
    pub(super) fn run_stiffness(&self) -> Result<(), Failure> {
        check_destinations(&self.files, &self.out, &[&self.model])?;
        let model = read_model(&self.model)?;
        let Structure::PinRig(pinned) = &model.structure else {
            return Err(Failure::input("--frequencies: the model's kind must be \"pin_rig\""));
        };
        let rig = rig_of(&model, pinned)?;
        let measured = MeasuredFrequencies {
            frequencies: self.frequencies.clone(),
            deviation: self.frequency_error,
            modulus_deviation: self.modulus_error,
        };
        let found = contact_stiffness(&rig, &measured)
            .map_err(|error| Failure::input(format!("--frequencies: {error}")))?;
        say(&table(&measured, &found))?;
        let mut outputs = Outputs::default();
        if let Some(path) = &self.files.json {
            let how = settings(&[Path::new(&self.model)])?;
            outputs.add(path, format!("{:#}\n", document(&measured, &found, &how)));
        }
        list(&outputs.write()?)?;
        if found.fits {
            return Ok(());
        }
        Err(Failure::other(format!(
            "no stiffness of the contact gives the rig these frequencies: with the best χ² is {:.1}; check that they are the first of \
             the beam, and the model",
            found.chi_square
        )))
    }
}

/// Name, unit and estimate of each number.
fn numbers(found: &ContactStiffness) -> [(&'static str, &'static str, &'static str, &Estimate); 4] {
    [
        ("youngs_modulus", "Young’s modulus", "Pa", &found.youngs_modulus),
        ("tangential_stiffness", "tangential stiffness k_t", "N/m", &found.tangential),
        ("rotational_stiffness", "k_t times its lever squared", "N m/rad", &found.rotational),
        ("normal_stiffness", "normal stiffness k_n", "N/m", &found.normal),
    ]
}

fn table(measured: &MeasuredFrequencies, found: &ContactStiffness) -> String {
    let all = numbers(found);
    let untold: Vec<&str> =
        all.iter().filter(|(.., estimate)| !estimate.told).map(|(_, words, ..)| *words).collect();
    let mut text = if !found.fits {
        "No stiffness of the contact gives the rig these frequencies; what comes nearest:\n".to_owned()
    } else if untold.is_empty() {
        "The frequencies tell both stiffnesses of the contact.\n".to_owned()
    } else {
        format!("The frequencies do not tell: {}.\n", untold.join(", "))
    };
    let _ = writeln!(text, "\n{:<28}  {:>11}  {:<25}  unit", "", "value", "95 % interval");
    for (_, words, unit, estimate) in all {
        let interval = estimate.interval;
        let interval = match (interval.low > 0.0, interval.high.is_finite()) {
            (true, true) => format!("{:.4e} … {:.4e}", interval.low, interval.high),
            (true, false) => format!("at least {:.4e}", interval.low),
            (false, true) => format!("at most {:.4e}", interval.high),
            (false, false) => "not determined".to_owned(),
        };
        let _ = writeln!(text, "{words:<28}  {:>11.4e}  {interval:<25}  {unit}", estimate.value);
    }
    let _ = writeln!(text, "\n{:>14}  {:>14}", "measured (Hz)", "with these (Hz)");
    for (measured, found) in measured.frequencies.iter().zip(&found.frequencies) {
        let _ = writeln!(text, "{measured:>14.4}  {found:>14.4}");
    }
    text
}

fn document(measured: &MeasuredFrequencies, found: &ContactStiffness, how: &Settings) -> Value {
    let all: Vec<Value> = numbers(found)
        .iter()
        .map(|(name, _, unit, estimate)| {
            json!({
                "name": name, "unit": unit, "value": estimate.value, "told": estimate.told,
                // An end that the frequencies do not set is null.
                "low": Some(estimate.interval.low).filter(|low| *low > 0.0),
                "high": Some(estimate.interval.high).filter(|high| high.is_finite()),
            })
        })
        .collect();
    json!({
        "schema": "stickslip.stiffness/1", "command": how.command, "version": how.version,
        "measured_hz": measured.frequencies, "frequency_error": measured.deviation,
        "modulus_error": measured.modulus_deviation, "fitted_hz": found.frequencies,
        "chi_square": found.chi_square, "fits": found.fits, "parameters": all,
    })
}
