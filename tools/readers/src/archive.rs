//! Zip archives from anywhere (FMUs, SSP packages), unpacked without trusting them.

use std::collections::BTreeSet;
use std::fs::File;
use std::io::{self, BufReader, Read, Write};
use std::path::{Component, Path, PathBuf};
use std::sync::{Mutex, OnceLock, PoisonError};

use tempfile::TempDir;
use thiserror::Error;
use zip::ZipArchive;
use zip::read::ZipFile;

/// How much an archive may unpack to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Limits {
    /// Bytes of all files together.
    pub bytes: u64,
    /// Number of entries.
    pub entries: usize,
    /// Bytes per byte of the archive, beyond the first [`Limits::FREE`].
    pub expansion: u64,
}

impl Limits {
    /// Bytes that any archive may unpack to, however small it is: zeros compress a thousandfold.
    pub const FREE: u64 = 64 << 20;
}

impl Default for Limits {
    /// 4 GiB, 100 000 entries, 200 bytes per byte.
    fn default() -> Self {
        Self { bytes: 4 << 30, entries: 100_000, expansion: 200 }
    }
}

/// What is wrong with an archive.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum ArchiveProblem {
    /// The file is not there, or not for us.
    #[error("the file cannot be read: {0}")]
    Unreadable(String),
    /// No zip, or a damaged one.
    #[error(
        "not a whole zip archive, as FMUs and .ssp files are: it is cut off or something else; copy or export it again ({0})"
    )]
    Damaged(String),
    /// A file inside cannot be read: its check sum is wrong, it ends too early, or its method is not known.
    #[error("`{entry}` in the archive cannot be read: {reason}")]
    Entry {
        /// The file's name in the archive.
        entry: String,
        /// What is wrong with it.
        reason: String,
    },
    /// A name that would lead out of the folder: absolute, with `..`, or with a drive.
    #[error("`{0}` in the archive would be written outside of it")]
    Escapes(String),
    /// A link, which could lead anywhere.
    #[error("`{0}` in the archive is a link; links are not followed")]
    Link(String),
    /// Two files of one name, of which nobody knows which is meant.
    #[error("`{0}` is in the archive twice")]
    Twice(String),
    /// More than [`Limits`] allow.
    #[error("the archive would unpack to more than {0}")]
    TooLarge(String),
    /// The system.
    #[error("the archive cannot be unpacked: {0}")]
    System(String),
}

/// A temporary folder with the content of an archive. It is removed when the value is dropped, or by
/// [`remove_unpacked`].
#[derive(Debug)]
pub struct Unpacked(TempDir);

/// The folders that are there now.
static UNPACKED: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

/// With this the names of such folders begin.
pub const PREFIX: &str = "stickslip-";

type Watcher = Box<dyn Fn(&Path) + Send + Sync>;

static WATCHER: OnceLock<Watcher> = OnceLock::new();

/// Tells `watcher` of every folder that an archive is going to be unpacked to, for somebody who removes it when this
/// process cannot. The first watcher stays.
pub fn watch(watcher: impl Fn(&Path) + Send + Sync + 'static) {
    let _ = WATCHER.set(Box::new(watcher));
}

impl Unpacked {
    fn new() -> io::Result<Self> {
        let folder = tempfile::Builder::new().prefix(PREFIX).tempdir()?;
        if let Some(watcher) = WATCHER.get() {
            watcher(folder.path());
        }
        UNPACKED.lock().unwrap_or_else(PoisonError::into_inner).insert(folder.path().to_owned());
        Ok(Self(folder))
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        self.0.path()
    }
}

impl Drop for Unpacked {
    fn drop(&mut self) {
        UNPACKED.lock().unwrap_or_else(PoisonError::into_inner).remove(self.path());
    }
}

/// Removes the folders of all archives that are unpacked, for a program that ends without dropping its values.
pub fn remove_unpacked() {
    for folder in UNPACKED.lock().unwrap_or_else(PoisonError::into_inner).iter() {
        // Another thread may be writing to it.
        let _ = (0..3).find(|_| std::fs::remove_dir_all(folder).is_ok());
    }
}

/// Unpacks the archive at `path` to a new temporary folder, which is removed when the value is dropped.
///
/// Nothing is written outside of that folder, whatever the archive says, and no link is made.
///
/// # Errors
/// [`ArchiveProblem`].
pub fn unpack(path: &Path, limits: Limits) -> Result<Unpacked, ArchiveProblem> {
    let file = File::open(path).map_err(|error| match error.kind() {
        io::ErrorKind::NotFound => ArchiveProblem::Unreadable("there is no such file".to_owned()),
        _ => ArchiveProblem::Unreadable(error.to_string()),
    })?;
    let packed = file.metadata().map_or(0, |metadata| metadata.len());
    let mut archive =
        ZipArchive::new(BufReader::new(file)).map_err(|error| ArchiveProblem::Damaged(error.to_string()))?;
    if archive.len() > limits.entries {
        return Err(ArchiveProblem::TooLarge(format!("{} files", limits.entries)));
    }
    let folder = Unpacked::new().map_err(|error| ArchiveProblem::System(error.to_string()))?;
    let allowed = limits.bytes.min(Limits::FREE.saturating_add(packed.saturating_mul(limits.expansion)));
    let mut left = allowed;
    for index in 0..archive.len() {
        let entry = archive.by_index(index).map_err(|error| ArchiveProblem::Entry {
            entry: format!("number {}", index + 1),
            reason: error.to_string(),
        })?;
        write_entry(entry, folder.path(), &mut left, allowed)?;
    }
    Ok(folder)
}

/// Writes one entry below `folder`, with at most `left` bytes, of which it takes what it needs.
fn write_entry<R: Read>(
    entry: ZipFile<'_, R>,
    folder: &Path,
    left: &mut u64,
    allowed: u64,
) -> Result<(), ArchiveProblem> {
    let name = entry.name().map_err(|error| ArchiveProblem::Damaged(error.to_string()))?.replace('\\', "/"); // some Windows programs write names this way
    let system = |error: io::Error| ArchiveProblem::System(format!("{name}: {error}"));
    if entry.is_symlink() {
        return Err(ArchiveProblem::Link(name));
    }
    let target = folder.join(inner_path(&name)?);
    if entry.is_dir() || name.ends_with('/') {
        return std::fs::create_dir_all(&target).map_err(system);
    }
    if let Some(parent) = target.parent() {
        std::fs::create_dir_all(parent).map_err(system)?;
    }
    let executable = entry.unix_mode().is_some_and(|mode| mode & 0o111 != 0);
    let mut file = match File::create_new(&target) {
        Ok(file) => file,
        Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {
            return Err(ArchiveProblem::Twice(name));
        }
        Err(error) => return Err(system(error)),
    };
    // The size stated in the archive is not trusted.
    let mut content = entry.take(left.saturating_add(1));
    let mut buffer = vec![0; 64 << 10];
    loop {
        let read = match content.read(&mut buffer) {
            Ok(0) => break,
            Ok(read) => read,
            Err(error) => {
                return Err(ArchiveProblem::Entry { entry: name, reason: error.to_string() });
            }
        };
        *left = match left.checked_sub(read as u64) {
            Some(left) => left,
            None => return Err(ArchiveProblem::TooLarge(format!("{} MiB", allowed >> 20))),
        };
        file.write_all(&buffer[..read]).map_err(system)?;
    }
    make_executable(&file, executable).map_err(system)
}

/// The relative path of an entry, which stays inside.
fn inner_path(name: &str) -> Result<PathBuf, ArchiveProblem> {
    let mut inner = PathBuf::new();
    // A colon is a drive or a stream on Windows; an archive that is refused there should be refused here.
    let foreign = name.contains(['\0', ':']);
    for component in Path::new(name).components() {
        match component {
            Component::Normal(part) if !foreign => inner.push(part),
            Component::CurDir => {}
            _ => return Err(ArchiveProblem::Escapes(name.to_owned())),
        }
    }
    if inner.as_os_str().is_empty() { Err(ArchiveProblem::Escapes(name.to_owned())) } else { Ok(inner) }
}

/// FMUs may bring programs that they start.
fn make_executable(file: &File, executable: bool) -> io::Result<()> {
    #[cfg(unix)]
    if executable {
        use std::os::unix::fs::PermissionsExt as _;
        file.set_permissions(std::fs::Permissions::from_mode(0o700))?;
    }
    #[cfg(not(unix))]
    let _ = (file, executable);
    Ok(())
}
