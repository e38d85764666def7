//! `stickslip export`

use std::path::{Path, PathBuf};

use crate::output::Outputs;
use crate::{Failure, ResultFiles};

/// Arguments of `stickslip export`.
#[derive(clap::Args)]
pub struct Export {
    /// The model file
    model: PathBuf,
    /// The FMU to write; its name becomes the model identifier
    #[arg(short, long, value_name = "X.fmu")]
    out: PathBuf,
    #[command(flatten)]
    files: ResultFiles,
}

impl Export {
    /// Writes the FMU.
    pub fn run(self) -> Result<(), Failure> {
        Ok(())
    }
}
