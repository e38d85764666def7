//! `stickslip fmu`

use std::path::PathBuf;

use crate::Failure;
use crate::output::Outputs;

/// Arguments of `stickslip fmu`.
#[derive(clap::Args)]
pub struct Fmu {
    /// Folder to write to; made if it is not there
    #[arg(long, value_name = "DIR", default_value = ".")]
    out: PathBuf,
    /// Standard models (JenkinsContact, ValanisContact, ModalBeam, ModalBeamTwoContacts, FrictionalBeam) and systems of
    /// them as .ssp (BeamWithValanis, BeamWithJenkins, BeamWithTwoContacts) to write; all when none is named
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
        let mut outputs = Outputs::default();
        for (name, toml) in standard.iter().filter(|(name, _)| wanted(name)) {
            let bytes = stickslip_fmu_package::write_fmu(name, toml)
                .map_err(|error| Failure::other(error.to_string()))?;
            outputs.add(&self.out.join(format!("{name}.fmu")), bytes);
        }
        for name in systems.iter().filter(|name| wanted(name)) {
            let bytes = stickslip_fmu_package::write_system(name)
                .map_err(|error| Failure::other(error.to_string()))?;
            outputs.add(&self.out.join(format!("{name}.ssp")), bytes);
        }
        std::fs::create_dir_all(&self.out)
            .map_err(|error| Failure::other(format!("cannot make {}: {error}", self.out.display())))?;
        super::list(&outputs.write()?)
    }
}
