//! `stickslip fmu`

use std::path::PathBuf;

use stickslip_fmu_package::FmiVersion;

use super::export::fmi_version;
use crate::Failure;
use crate::output::Outputs;

/// Arguments of `stickslip fmu`.
#[derive(clap::Args)]
pub struct Fmu {
    /// Folder to write to; created if missing
    #[arg(long, value_name = "DIR", default_value = ".")]
    out: PathBuf,
    /// Version of FMI
    #[arg(long, value_name = "VERSION", value_parser = fmi_version, default_value = "2")]
    fmi: FmiVersion,
    /// Standard models (JenkinsContact, ValanisContact, SlipSlapContact, ModalBeam, ModalBeamTwoContacts,
    /// FrictionalBeam, PinnedBeam, SlipSlapBeam) and systems of them as .ssp (BeamWithValanis, BeamWithJenkins, BeamWithTwoContacts,
    /// BeamWithSlipSlap) to write; all when none is named
    #[arg(value_name = "MODEL")]
    models: Vec<String>,
}

impl Fmu {
    /// Writes the FMUs and systems.
    pub fn run(self) -> Result<(), Failure> {
        let standard = stickslip_fmu_package::standard_models();
        let systems = stickslip_fmu_package::standard_systems();
        let known: Vec<&str> = standard.iter().map(|(name, _)| *name).chain(systems.clone()).collect();
        if let Some(unknown) = self.models.iter().find(|name| !known.contains(&name.as_str())) {
            return Err(Failure::input(format!(
                "there is no standard model or system `{unknown}`; there are {}",
                known.join(", ")
            )));
        }
        let wanted = |name: &str| self.models.is_empty() || self.models.iter().any(|model| model == name);
        let standard: Vec<_> = standard.into_iter().filter(|(name, _)| wanted(name)).collect();
        let systems: Vec<_> = systems.into_iter().filter(|name| wanted(name)).collect();
        let fmu = |name: &str| self.out.join(format!("{name}.fmu"));
        let system = |name: &str| self.out.join(format!("{name}.ssp"));
        std::fs::create_dir_all(&self.out)
            .map_err(|error| Failure::input(format!("{} cannot be a folder: {error}", self.out.display())))?;
        let files: Vec<PathBuf> = standard
            .iter()
            .map(|(name, _)| fmu(name))
            .chain(systems.iter().map(|name| system(name)))
            .collect();
        Outputs::check(&files, &[] as &[PathBuf])?;
        let failed = |error: stickslip_fmu_package::Error| Failure::other(error.to_string());
        let mut outputs = Outputs::default();
        for (name, toml) in standard {
            outputs
                .add(&fmu(name), stickslip_fmu_package::write_fmu_of(self.fmi, name, toml).map_err(failed)?);
        }
        for name in systems {
            outputs
                .add(&system(name), stickslip_fmu_package::write_system_of(self.fmi, name).map_err(failed)?);
        }
        super::list(&outputs.write()?)
    }
}
