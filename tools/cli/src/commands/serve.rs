//! The hidden command that runs one FMU in a process of its own.

use std::path::PathBuf;

use crate::Failure;

/// How it is called.
pub const NAME: &str = "serve-fmu";

/// Arguments of `stickslip serve-fmu`, which only this program itself gives.
#[derive(clap::Args)]
pub struct Serve {
    /// Where the FMU is unpacked
    folder: PathBuf,
    /// The FMU as the user knows it
    fmu: String,
    /// Name of the instance
    name: String,
}

impl Serve {
    /// Serves until the other side goes away.
    pub fn run(self) -> Result<(), Failure> {
        stickslip_fmi_host::serve(&self.folder, &self.fmu, &self.name)
            .map_err(|error| Failure::other(error.to_string()))
    }
}
