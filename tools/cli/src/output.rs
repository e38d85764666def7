//! Files are written whole or not at all.

use std::io::Write as _;
use std::path::{Path, PathBuf};

use crate::{Failure, progress, terminal};

/// Files to be written together once everything has succeeded.
#[derive(Default)]
pub struct Outputs {
    files: Vec<(PathBuf, Vec<u8>)>,
}

impl Outputs {
    /// Refuses, before any work is done, destinations that could not be written in the end, of which one
    /// would replace another, or that would replace one of the `inputs`.
    pub fn check<'p>(
        paths: impl IntoIterator<Item = &'p PathBuf>,
        inputs: &[impl AsRef<Path>],
    ) -> Result<(), Failure> {
        let mut places = Vec::new();
        for path in paths {
            if is_standard_output(path) {
                terminal::keep_for_data();
            } else {
                Self::check_one(path)?;
            }
            Self::check_inputs(path, inputs)?;
            // The folder is there, so it has one true name.
            let place = (folder_of(path).canonicalize().ok(), path.file_name());
            if places.contains(&place) {
                return Err(Failure::input(format!("two results would be written to {}", path.display())));
            }
            places.push(place);
        }
        Ok(())
    }

    fn check_one(path: &Path) -> Result<(), Failure> {
        let folder = folder_of(path);
        if path.is_dir() {
            return Err(Failure::input(format!("{} is a folder; name a file in it", path.display())));
        }
        check_regular(path)?;
        if !folder.is_dir() {
            return Err(Failure::input(format!(
                "cannot write {}: there is no folder {}",
                path.display(),
                folder.display()
            )));
        }
        // Whether a folder takes files is known for certain only when one is made; it is removed at once.
        match tempfile::Builder::new().prefix(".stickslip-").tempfile_in(&folder) {
            Ok(_) => Ok(()),
            Err(error) => Err(Failure::input(format!(
                "cannot write {}: no file can be made in {} ({})",
                path.display(),
                folder.display(),
                error.kind()
            ))),
        }
    }

    /// Links and other spellings of an input are that input.
    fn check_inputs(path: &Path, inputs: &[impl AsRef<Path>]) -> Result<(), Failure> {
        // Where there is no file yet, there is no input.
        let Ok(place) = path.canonicalize() else { return Ok(()) };
        let same = |input: &&Path| input.canonicalize().is_ok_and(|input| input == place);
        match inputs.iter().map(AsRef::as_ref).find(same) {
            Some(input) => Err(Failure::input(format!(
                "{} would replace the input {}; name another file",
                path.display(),
                input.display()
            ))),
            None => Ok(()),
        }
    }

    /// Adds a file.
    pub fn add(&mut self, path: &Path, bytes: impl Into<Vec<u8>>) {
        self.files.push((path.to_owned(), bytes.into()));
    }

    /// As [`Self::write`], of the results, before what is made of them and takes longer: reports and tables, which an interrupt
    /// does not wait for.
    pub fn write_results(&mut self) -> Result<Vec<PathBuf>, Failure> {
        let written = std::mem::take(self).write()?;
        progress::results_are_written();
        Ok(written)
    }

    /// Writes every file to a temporary neighbour first and renames them only when all are complete.
    /// Returns the paths.
    pub fn write(self) -> Result<Vec<PathBuf>, Failure> {
        progress::begin_to_write();
        let (printed, files): (Vec<_>, Vec<_>) =
            self.files.into_iter().partition(|(path, _)| is_standard_output(path));
        files.iter().try_for_each(|(path, _)| check_regular(path))?;
        let mut ready = Vec::new();
        for (path, bytes) in &files {
            let failed =
                |error: std::io::Error| Failure::other(format!("cannot write {}: {error}", path.display()));
            let mut file = tempfile::Builder::new()
                .prefix(".stickslip-")
                .permissions_if_unix()
                .tempfile_in(folder_of(path))
                .map_err(failed)?;
            file.write_all(bytes).map_err(failed)?;
            ready.push((path, file));
        }
        for (path, file) in ready {
            file.persist(path).map_err(|error| {
                Failure::other(format!("cannot write {}: {}", path.display(), error.error))
            })?;
        }
        printed.iter().try_for_each(|(_, bytes)| say_always(bytes))?;
        Ok(files.into_iter().map(|(path, _)| path).collect())
    }
}

/// A new folder of files, there whole or not at all.
pub struct Folder {
    path: PathBuf,
}

impl Folder {
    /// Refuses, before any work is done, a folder that holds files or could not be made.
    pub fn check(path: &Path) -> Result<Self, Failure> {
        let refused = |reason: &str| Failure::input(format!("{}: {reason}", path.display()));
        match std::fs::read_dir(path).map(|mut entries| entries.next().is_some()) {
            Ok(true) => {
                return Err(refused("the folder is not empty; name a new one, or empty it"));
            }
            Ok(false) => {}
            Err(_) if path.exists() => return Err(refused("this is no folder")),
            Err(_) => {}
        }
        let folder = Self { path: path.to_owned() };
        match folder.temporary() {
            Ok(_) => Ok(folder),
            Err(error) => Err(refused(&format!("no folder can be made there ({})", error.kind()))),
        }
    }

    fn temporary(&self) -> std::io::Result<tempfile::TempDir> {
        // An empty folder may be given as `.`, which no other can replace: its true name has a parent.
        let true_path = self.path.canonicalize().unwrap_or_else(|_| self.path.clone());
        tempfile::Builder::new()
            .prefix(".stickslip-")
            .permissions_of_folder()
            .tempdir_in(folder_of(&true_path))
    }

    /// Writes every file to a temporary neighbour, which takes the folder's place when all are complete.
    pub fn write(&self, files: &[(String, impl AsRef<[u8]>)]) -> Result<(), Failure> {
        progress::begin_to_write();
        let failed =
            |error: std::io::Error| Failure::other(format!("cannot write {}: {error}", self.path.display()));
        let temporary = self.temporary().map_err(failed)?;
        for (name, bytes) in files {
            let path = temporary.path().join(name);
            std::fs::create_dir_all(path.parent().unwrap_or(temporary.path())).map_err(failed)?;
            std::fs::write(path, bytes).map_err(failed)?;
        }
        if self.path.exists() {
            // Only an empty folder is removed.
            std::fs::remove_dir(&self.path).map_err(failed)?;
        }
        std::fs::rename(temporary.path(), &self.path).map_err(failed)?;
        // It is not temporary any more.
        let _ = temporary.keep();
        Ok(())
    }
}

/// What is written to a terminal that was closed fails with this (Unix).
const INPUT_OUTPUT_ERROR: i32 = 5;

/// Writes to standard output. A reader that has seen enough and closed the pipe, or the terminal, does not stop the
/// program: the files are still to be written. Nothing is written where nothing but errors is wanted, or where standard output is
/// kept for a result.
pub fn say(text: &str) -> Result<(), Failure> {
    if terminal::is_for_people() { say_always(text.as_bytes()) } else { Ok(()) }
}

/// As [`say`], whatever the terminal is for.
pub fn say_always(text: &[u8]) -> Result<(), Failure> {
    let mut out = std::io::stdout().lock();
    let gone = |error: &std::io::Error| {
        error.kind() == std::io::ErrorKind::BrokenPipe
            || cfg!(unix) && error.raw_os_error() == Some(INPUT_OUTPUT_ERROR)
    };
    match out.write_all(text).and_then(|()| out.flush()) {
        Err(error) if !gone(&error) => {
            Err(Failure::other(format!("cannot write to standard output: {error}")))
        }
        _ => Ok(()),
    }
}

/// Temporary files and folders are private by default; results should have the rights of any other new ones.
trait PermissionsIfUnix {
    fn permissions_if_unix(&mut self) -> &mut Self;
    fn permissions_of_folder(&mut self) -> &mut Self;
}

impl PermissionsIfUnix for tempfile::Builder<'_, '_> {
    fn permissions_if_unix(&mut self) -> &mut Self {
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt as _;
            // The process's umask still applies.
            self.permissions(std::fs::Permissions::from_mode(0o666));
        }
        self
    }

    fn permissions_of_folder(&mut self) -> &mut Self {
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt as _;
            self.permissions(std::fs::Permissions::from_mode(0o777));
        }
        self
    }
}

/// `-`, as everywhere.
fn is_standard_output(path: &Path) -> bool {
    path == Path::new("-")
}

/// A device or a pipe would be replaced by a file.
fn check_regular(path: &Path) -> Result<(), Failure> {
    match path.metadata() {
        Ok(present) if !present.is_file() => {
            let what = path.display();
            Err(Failure::input(format!(
                "{what} is not a regular file (a device or a pipe?); it is not replaced"
            )))
        }
        _ => Ok(()),
    }
}

fn folder_of(path: &Path) -> PathBuf {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder.to_owned(),
        _ => PathBuf::from("."),
    }
}
