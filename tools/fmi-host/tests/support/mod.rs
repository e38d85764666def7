//! A standard FMU, unpacked and loaded.

use std::sync::Arc;
use stickslip::fmi::Instance;
use stickslip_fmi_host::{Error, Library, Slave};
use stickslip_fmu_package::{library, standard_models};
use tempfile::TempDir;

pub struct Unpacked {
    pub folder: TempDir,
    pub guid: String,
    pub library: Arc<Library>,
}

pub fn unpack(name: &str) -> Unpacked {
    let (_, model_toml) = standard_models().into_iter().find(|(other, _)| *other == name).unwrap();
    let folder = tempfile::Builder::new().prefix("with space and ü ").tempdir().unwrap();
    let file = folder.path().join(format!("{name}.{}", library().extension));
    std::fs::write(&file, library().bytes).unwrap();
    std::fs::write(folder.path().join("model.toml"), model_toml).unwrap();
    let guid = format!("{{{}}}", Instance::new(model_toml).unwrap().guid());
    Unpacked { library: Library::load(&file).unwrap(), folder, guid }
}

impl Unpacked {
    pub fn slave(&self) -> Result<Slave, Error> {
        Slave::new(Arc::clone(&self.library), "one", &self.guid, self.folder.path())
    }

    pub fn running(&self) -> Slave {
        let mut slave = self.slave().unwrap();
        initialize(&mut slave);
        slave
    }
}

pub fn initialize(slave: &mut Slave) {
    slave.set_up(Some(1e-8), 0.0).unwrap();
    slave.enter_initialization().unwrap();
    slave.exit_initialization().unwrap();
}
