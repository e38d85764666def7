//! `stickslip effects`

use stickslip_report::{catalogue_table, effect_table};

use super::{colored, diagnose::effect};
use crate::Failure;
use crate::output::say;

/// Arguments of `stickslip effects`.
#[derive(clap::Args)]
pub struct Effects {
    /// Show what this effect is, its parameters, and how to confirm it
    #[arg(value_name = "ID")]
    id: Option<String>,
}

impl Effects {
    /// Prints the catalogue, or the entry of one effect.
    pub fn run(self) -> Result<(), Failure> {
        say(&match self.id {
            None => catalogue_table(80, colored()),
            Some(id) => effect_table(effect(&id)?, 80, colored()),
        })
    }
}
