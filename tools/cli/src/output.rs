//! Files are written whole or not at all.

use std::io::Write as _;
use std::path::{Path, PathBuf};

use crate::Failure;

/// Files to be written together once everything has succeeded.
#[derive(Default)]
pub struct Outputs {
    files: Vec<(PathBuf, Vec<u8>)>,
}

impl Outputs {
    /// Refuses, before any work is done, destinations that could not be written in the end, or of which one
    /// would replace another.
    pub fn check<'p>(paths: impl IntoIterator<Item = &'p PathBuf>) -> Result<(), Failure> {
        let mut places = Vec::new();
        for path in paths {
            Self::check_one(path)?;
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
        if !folder.is_dir() {
            return Err(Failure::input(format!(
                "cannot write {}: there is no folder {}",
                path.display(),
                folder.display()
            )));
        }
        Ok(())
    }

    /// Adds a file.
    pub fn add(&mut self, path: &Path, bytes: impl Into<Vec<u8>>) {
        self.files.push((path.to_owned(), bytes.into()));
    }

    /// Writes every file to a temporary neighbour first and renames them only when all are complete.
    /// Returns the paths.
    pub fn write(self) -> Result<Vec<PathBuf>, Failure> {
        let mut ready = Vec::new();
        for (path, bytes) in &self.files {
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
        Ok(self.files.into_iter().map(|(path, _)| path).collect())
    }
}

/// Writes to standard output. A reader that has seen enough and closed the pipe does not stop the program:
/// the files are still to be written.
pub fn say(text: &str) -> Result<(), Failure> {
    let mut out = std::io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => {
            Err(Failure::other(format!("cannot write to standard output: {error}")))
        }
        _ => Ok(()),
    }
}

/// Temporary files are private by default; results should have the rights of any other new file.
trait PermissionsIfUnix {
    fn permissions_if_unix(&mut self) -> &mut Self;
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
}

fn folder_of(path: &Path) -> PathBuf {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder.to_owned(),
        _ => PathBuf::from("."),
    }
}
