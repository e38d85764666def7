//! From an archive to something that can be instantiated.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::{Arc, Mutex, PoisonError};

use stickslip_readers::InputError;
use stickslip_readers::archive::{ArchiveProblem, Limits, Unpacked, unpack};

use crate::component::{Error, Library, Slave};
use crate::description::{FmiVersion, ModelDescription};
use crate::fmi3::{Library3, Slave3};
use crate::isolate::IsolatedSlave;
use crate::log::Log;
use crate::slave::{Component, FmuSlave};

/// Why an FMU cannot be used.
#[derive(Debug, thiserror::Error)]
#[error("{fmu}: {problem}")]
pub struct ImportError {
    /// The file as the user named it.
    pub fmu: String,
    /// What is wrong.
    pub problem: ImportProblem,
}

/// What is wrong with an FMU.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ImportProblem {
    /// The archive.
    #[error(transparent)]
    Archive(#[from] ArchiveProblem),
    /// An archive without a description.
    #[error("there is no `modelDescription.xml` in the archive: it is no FMU")]
    NoDescription,
    /// The description.
    #[error(transparent)]
    Description(#[from] InputError),
    /// Another version of FMI.
    #[error("it is an FMU of FMI {0}; FMI 2.0 and 3.0 are read")]
    Version(String),
    /// Model exchange only.
    #[error("it has no co-simulation (no element `CoSimulation`): it needs a solver that comes from outside")]
    NoCoSimulation,
    /// Clocks, which a master must activate.
    #[error("it has clocks (`{0}` and others), which this master does not drive")]
    Clocks(String),
    /// No library for this platform.
    #[error("it has no library for this platform: `{wanted}` is missing; it has {present}")]
    NoBinary {
        /// Where it should be.
        wanted: String,
        /// The platforms it is for.
        present: String,
    },
    /// The library.
    #[error("{0}")]
    Library(String),
    /// `fmi2Instantiate` or its like returned NULL.
    #[error("it refuses to be instantiated{}", said(.0))]
    Instantiate(Option<String>),
    /// Its second instance.
    #[error(
        "it allows one instance in a process, and there is one already; run each in a process of its own (--isolate)"
    )]
    OncePerProcess,
    /// The process it was to run in.
    #[error("it cannot be run in a process of its own: {0}")]
    Process(String),
}

fn said(words: &Option<String>) -> String {
    let Some(words) = words else { return String::new() };
    let words_for = words.to_lowercase();
    let help = if ["guid", "instantiationtoken"].iter().any(|word| words_for.contains(word)) {
        "; its modelDescription.xml and what else is in it do not belong together: export the FMU again"
    } else {
        ""
    };
    format!("; it says: {words}{help}")
}

/// Folders in `binaries/` whose library runs here, the best first.
pub fn platforms() -> &'static [&'static str] {
    match (std::env::consts::OS, std::env::consts::ARCH) {
        ("linux", "x86_64") => &["linux64", "x86_64-linux"],
        ("linux", "x86") => &["linux32", "x86-linux"],
        ("linux", "aarch64") => &["aarch64-linux", "linuxaarch64"],
        ("windows", "x86_64") => &["win64", "x86_64-windows"],
        ("windows", "x86") => &["win32", "x86-windows"],
        ("macos", "x86_64") => &["darwin64", "x86_64-darwin"],
        ("macos", "aarch64") => &["aarch64-darwin", "darwin64"],
        _ => &[],
    }
}

fn extension() -> &'static str {
    match std::env::consts::OS {
        "windows" => "dll",
        "macos" => "dylib",
        _ => "so",
    }
}

/// An unpacked FMU. Its folder is removed when the last of its instances is gone.
#[derive(Debug)]
pub struct Fmu {
    /// As the user named it.
    name: String,
    description: ModelDescription,
    library: PathBuf,
    /// Before the folder: some systems do not remove a library that is loaded.
    loaded: Mutex<Option<Loaded>>,
    folder: Folder,
}

/// The library of an FMU of either version.
#[derive(Debug, Clone)]
enum Loaded {
    Two(Arc<Library>),
    Three(Arc<Library3>),
}

#[derive(Debug)]
enum Folder {
    /// To be removed.
    Own(Unpacked),
    /// Somebody else's.
    Other(PathBuf),
}

impl Folder {
    fn path(&self) -> &Path {
        match self {
            Folder::Own(folder) => folder.path(),
            Folder::Other(folder) => folder,
        }
    }
}

impl Fmu {
    /// Unpacks the FMU at `path` to a temporary folder, and reads its description. Its library is not loaded yet.
    ///
    /// # Errors
    /// [`ImportProblem`]: everything that makes it impossible to run it here.
    pub fn open(path: &Path) -> Result<Arc<Self>, ImportError> {
        Self::open_as(path, &path.display().to_string())
    }

    /// As [`Fmu::open`], for a file that the user knows as `name`.
    ///
    /// # Errors
    /// As [`Fmu::open`].
    pub fn open_as(path: &Path, name: &str) -> Result<Arc<Self>, ImportError> {
        let name = name.to_owned();
        let named = |problem| ImportError { fmu: name.clone(), problem };
        let folder = unpack(path, Limits::default()).map_err(|problem| named(problem.into()))?;
        Self::unpacked(name.clone(), Folder::Own(folder)).map_err(named)
    }

    /// An FMU that is unpacked already, in `folder`, which stays. Errors call it `name`.
    ///
    /// # Errors
    /// As [`Fmu::open`].
    pub fn in_folder(folder: &Path, name: &str) -> Result<Arc<Self>, ImportError> {
        let named = |problem| ImportError { fmu: name.to_owned(), problem };
        Self::unpacked(name.to_owned(), Folder::Other(folder.to_owned())).map_err(named)
    }

    fn unpacked(name: String, folder: Folder) -> Result<Arc<Self>, ImportProblem> {
        let file = folder.path().join("modelDescription.xml");
        if !file.is_file() {
            return Err(ImportProblem::NoDescription);
        }
        let description = ModelDescription::read(&file)?;
        let library =
            library(folder.path(), &description.co_simulation.model_identifier, description.version)?;
        Ok(Arc::new(Self { name, folder, description, library, loaded: Mutex::new(None) }))
    }

    /// As the user named it.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// What it says of itself.
    pub fn description(&self) -> &ModelDescription {
        &self.description
    }

    /// Where it is unpacked.
    pub fn folder(&self) -> &Path {
        self.folder.path()
    }

    /// Whether its library is this one, byte by byte: then its code is known.
    pub fn has_library(&self, library: &[u8]) -> bool {
        let length = std::fs::metadata(&self.library).map_or(0, |metadata| metadata.len());
        length == library.len() as u64 && std::fs::read(&self.library).is_ok_and(|bytes| bytes == library)
    }

    /// What a user should know before it runs.
    pub fn remarks(&self) -> Vec<String> {
        let abilities = &self.description.co_simulation;
        let mut remarks = Vec::new();
        if abilities.needs_execution_tool {
            let tool = self.description.generation_tool.as_deref().unwrap_or("the program it was made with");
            remarks.push(format!("{}: needs another program to run, probably {tool}", self.name));
        }
        remarks
    }

    /// An instance called `name` in this process.
    ///
    /// # Errors
    /// [`ImportProblem::Library`], [`ImportProblem::Instantiate`], [`ImportProblem::OncePerProcess`].
    pub fn instantiate(self: &Arc<Self>, name: &str) -> Result<FmuSlave, ImportError> {
        self.instance(name).map_err(|problem| ImportError { fmu: self.name.clone(), problem })
    }

    /// An instance called `name` in a process of its own. `command` starts a program that calls [`crate::serve`] with
    /// [`Fmu::folder`], [`Fmu::name`] and `name`. Once `interrupted`, a process that does not answer is ended.
    ///
    /// # Errors
    /// [`ImportProblem::Process`], and what [`Fmu::instantiate`] fails with over there.
    pub fn isolated(
        self: &Arc<Self>,
        name: &str,
        command: Command,
        interrupted: fn() -> bool,
    ) -> Result<IsolatedSlave, ImportError> {
        IsolatedSlave::start(Arc::clone(self), name, command, interrupted)
            .map_err(|problem| ImportError { fmu: self.name.clone(), problem })
    }

    fn instance(self: &Arc<Self>, name: &str) -> Result<FmuSlave, ImportProblem> {
        let lone = self.lone()?;
        let library = self.load()?;
        // Looked up: there may be a million of them, and few are ever in a message. A log does not keep the FMU.
        let fmu = Arc::downgrade(self);
        let named =
            move |letter, reference| fmu.upgrade()?.description.named(letter, reference).map(str::to_owned);
        let log = Arc::new(Log::new(named));
        let resources = self.folder().join("resources");
        let guid = &self.description.guid;
        let slave = match library {
            Loaded::Two(library) => {
                let slave = Slave::logging(library, name, guid, &resources, Arc::clone(&log), true);
                slave.map(Component::Two)
            }
            Loaded::Three(library) => {
                let required = self.description.told_within_steps();
                let slave = Slave3::logging(library, name, guid, &resources, Arc::clone(&log), &required);
                slave.map(Component::Three)
            }
        };
        let slave = slave.map_err(|error| match error {
            Error::Instantiate => {
                let last = || log.messages().pop().map(|message| message.text);
                ImportProblem::Instantiate(log.take_failure().or_else(last))
            }
            other => ImportProblem::Library(other.to_string()),
        })?;
        Ok(FmuSlave::new(Arc::clone(self), name, slave, lone))
    }

    fn load(&self) -> Result<Loaded, ImportProblem> {
        let mut loaded = self.loaded.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(library) = &*loaded {
            return Ok(library.clone());
        }
        let library = match self.description.version {
            FmiVersion::Two => Library::load(&self.library).map(Loaded::Two),
            FmiVersion::Three => Library3::load(&self.library).map(Loaded::Three),
        };
        let library = library.map_err(|error| {
            let mut reason = error.to_string();
            if reason.contains("undefined symbol") && reason.contains("Py") {
                reason += "; it needs the library of Python: start this program with LD_PRELOAD=libpython3.so or the like";
            }
            ImportProblem::Library(reason)
        })?;
        *loaded = Some(library.clone());
        Ok(library)
    }

    /// The right to be the one instance, if only one is allowed.
    fn lone(&self) -> Result<Option<Lone>, ImportProblem> {
        if !self.description.co_simulation.once_per_process {
            return Ok(None);
        }
        let key = self.description.guid.clone();
        let mut running = RUNNING.lock().unwrap_or_else(PoisonError::into_inner);
        if !running.insert(key.clone()) {
            return Err(ImportProblem::OncePerProcess);
        }
        Ok(Some(Lone(key)))
    }
}

/// FMUs that allow one instance and have it.
static RUNNING: Mutex<BTreeSet<String>> = Mutex::new(BTreeSet::new());

/// Given back when the instance is gone.
#[derive(Debug)]
pub(crate) struct Lone(String);

impl Drop for Lone {
    fn drop(&mut self) {
        RUNNING.lock().unwrap_or_else(PoisonError::into_inner).remove(&self.0);
    }
}

/// The library for this platform in the unpacked `folder`.
fn library(folder: &Path, identifier: &str, version: FmiVersion) -> Result<PathBuf, ImportProblem> {
    let mut platforms = platforms().to_vec();
    // FMI 3.0 has names of its own, with a hyphen.
    platforms.sort_by_key(|name| name.contains('-') != (version == FmiVersion::Three));
    let file = format!("{identifier}.{}", extension());
    // The identifier becomes part of a path.
    let plain = !identifier.is_empty() && !identifier.contains(['/', '\\', '\0']) && identifier != "..";
    if plain {
        for platform in &platforms {
            let path = folder.join("binaries").join(platform).join(&file);
            if path.is_file() {
                // Absolute, or the system would look in its own folders.
                return std::path::absolute(path).map_err(|error| ImportProblem::Library(error.to_string()));
            }
        }
    }
    let mut present: Vec<String> = std::fs::read_dir(folder.join("binaries"))
        .map(|entries| {
            entries.flatten().map(|entry| entry.file_name().to_string_lossy().into_owned()).collect()
        })
        .unwrap_or_default();
    present.sort();
    let present = if present.is_empty() { "none".to_owned() } else { present.join(", ") };
    let wanted = format!("binaries/{}/{file}", platforms.first().unwrap_or(&"?"));
    Err(ImportProblem::NoBinary { wanted, present })
}
