//! The library of an FMU, loaded.

use std::path::Path;
use std::sync::Arc;

use super::Error;
use crate::binding::Functions;

/// A loaded library with its functions.
#[derive(Debug)]
pub struct Library {
    pub(super) functions: Functions,
    /// Keeps the functions callable.
    _library: libloading::Library,
}

impl Library {
    /// Loads the library at `path` (absolute, or the system searches its own folders).
    ///
    /// # Errors
    /// A file that is no library of this platform, or lacks a function of FMI 2.0 co-simulation.
    pub fn load(path: &Path) -> Result<Arc<Self>, Error> {
        let library = opened(path)?;
        // SAFETY: the names have the signatures of the FMI 2.0 headers.
        let functions = unsafe { Functions::bind(&library)? };
        Ok(Arc::new(Self { functions, _library: library }))
    }
}

/// The library at `path`, loaded, if it is whole.
pub(crate) fn opened(path: &Path) -> Result<libloading::Library, Error> {
    #[cfg(all(target_os = "linux", target_endian = "little"))]
    crate::elf::check(path).map_err(|problem| Error::Damaged(problem.to_string()))?;
    // SAFETY: loading runs the library's constructors. The user chose to run this FMU.
    Ok(unsafe { open(path)? })
}

/// # Safety
/// Runs the library's constructors.
unsafe fn open(path: &Path) -> Result<libloading::Library, libloading::Error> {
    #[cfg(windows)]
    {
        // The libraries it needs are in its own folder.
        use libloading::os::windows::{LOAD_WITH_ALTERED_SEARCH_PATH, Library};
        // SAFETY: the caller's promise.
        unsafe { Library::load_with_flags(path, LOAD_WITH_ALTERED_SEARCH_PATH).map(Into::into) }
    }
    #[cfg(not(windows))]
    // SAFETY: the caller's promise.
    unsafe {
        libloading::Library::new(path)
    }
}
