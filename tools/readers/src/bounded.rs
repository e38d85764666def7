//! Files of a size that memory has room for.

use std::fs::File;
use std::io::Read as _;
use std::path::Path;

use crate::error::{InputError, Problem};

/// Largest file that is read (bytes): with the numbers in it, it takes less than a gigabyte of memory.
const LARGEST: u64 = 300 << 20;
/// What is read between two questions whether to go on.
const PART: usize = 4 << 20;

/// All bytes of a regular file that is not too large.
///
/// # Errors
/// What cannot be read; a pipe, a device or a folder; a file of more than 300 MB.
pub(crate) fn read(path: &Path) -> Result<Vec<u8>, InputError> {
    let refused = |reason: String| InputError {
        path: path.to_owned(),
        excerpt: None,
        problem: Box::new(Problem::Unreadable { what: "the file".to_owned(), reason }),
    };
    // A pipe without a writer would never be opened.
    let there = std::fs::metadata(path).map_err(|error| refused(error.to_string()))?;
    check(&there).map_err(refused)?;
    let mut file = File::open(path).map_err(|error| refused(error.to_string()))?;
    let mut bytes = Vec::with_capacity(usize::try_from(there.len()).unwrap_or(0));
    loop {
        let part = (&mut file)
            .take(PART as u64)
            .read_to_end(&mut bytes)
            .map_err(|error| refused(error.to_string()))?;
        if part == 0 {
            return Ok(bytes);
        }
        // It may have grown.
        if bytes.len() as u64 > LARGEST {
            return Err(refused(too_large(bytes.len() as u64)));
        }
    }
}

fn check(there: &std::fs::Metadata) -> Result<(), String> {
    if there.is_dir() {
        return Err("it is a folder".to_owned());
    }
    if !there.is_file() {
        return Err("it is a pipe or a device, which may never end: write it to a file first".to_owned());
    }
    if there.len() > LARGEST {
        return Err(too_large(there.len()));
    }
    Ok(())
}

fn too_large(length: u64) -> String {
    let megabytes = |bytes: u64| bytes >> 20;
    format!(
        "it has {} MB, and up to {} MB are read: export fewer channels, a shorter stretch or a lower rate, or split it",
        megabytes(length),
        megabytes(LARGEST)
    )
}
