//! Files that are no text: one file per format, each behind one function from bytes to [`Series`].
//!
//! A [`Format`] is found by the first bytes of a file. What it holds are series of numbers with names, in groups, with a time
//! base where the format has one; `series.rs` makes tables of them. Foreign code reads in a thread of its own
//! ([`guarded`]): whatever it does with a broken file, the answer is a sentence.

mod hdf5;
mod mat;
mod parquet;
mod series;
mod tdms;
mod universal;

pub(super) use series::tables;

use super::{Refusal, refuse};

/// Numbers under a name.
#[derive(Debug, Clone, Default)]
pub(super) struct Series {
    /// The record that it belongs to: a group of the file; empty for the whole file.
    pub group: String,
    pub name: String,
    pub unit: Option<String>,
    pub values: Vec<f64>,
    /// Start and step of equally spaced samples, in seconds.
    pub times: Option<[f64; 2]>,
    /// Seconds of a clock.
    pub clock: bool,
}

impl Series {
    fn new(group: &str, name: &str, values: Vec<f64>) -> Self {
        Self { group: group.to_owned(), name: name.to_owned(), values, ..Self::default() }
    }
}

/// Most bytes that the numbers of a packed file may take, eight each: as many as a file may have.
const LARGEST: u64 = 300 << 20;

/// The room in memory for the numbers of a packed file, all together.
#[derive(Debug, Default)]
struct Room {
    taken: u64,
}

impl Room {
    fn left(&self) -> u64 {
        LARGEST.saturating_sub(self.taken)
    }

    /// Whether so many bytes have room, with what was taken.
    fn has(&self, bytes: u64) -> Result<(), String> {
        let most = LARGEST >> 20;
        let refused =
            || format!("its numbers take more than {most} MB of memory, and up to {most} MB are read");
        (bytes <= self.left()).then_some(()).ok_or_else(refused)
    }

    fn take(&mut self, bytes: u64) -> Result<(), String> {
        self.has(bytes)?;
        self.taken += bytes;
        Ok(())
    }
}

/// What reads a file of a format.
type Read = fn(&[u8], &mut Vec<String>) -> Result<Vec<Series>, Refusal>;

/// A format of files.
pub(super) struct Format {
    /// With its article: `a MAT file (version 5)`.
    pub name: &'static str,
    /// Whether a file that starts with these bytes is one.
    pub is: fn(&[u8]) -> bool,
    /// Its series, with notes of what was left out.
    pub read: Read,
    /// What to do where it cannot be read.
    pub help: &'static str,
}

/// The formats that are read.
pub(super) const FORMATS: [&Format; 6] =
    [&mat::VERSION_5, &mat::VERSION_7_3, &hdf5::FORMAT, &universal::FORMAT, &tdms::FORMAT, &parquet::FORMAT];

/// Bytes of the head that a format is found in.
const HEAD: usize = 1024;

/// The format of a file that starts as `bytes`.
pub(super) fn find(bytes: &[u8]) -> Option<&'static Format> {
    let head = &bytes[..bytes.len().min(HEAD)];
    FORMATS.into_iter().find(|format| (format.is)(head))
}

/// The series of `bytes`, a file of `format`.
pub(super) fn read(format: &Format, bytes: &[u8], notes: &mut Vec<String>) -> Result<Vec<Series>, Refusal> {
    notes.push(format!("this is {}", format.name));
    let series = (format.read)(bytes, notes)?;
    if series.is_empty() {
        return Err(unreadable(format, "it holds no series of numbers"));
    }
    Ok(series)
}

fn unreadable(format: &Format, reason: impl std::fmt::Display) -> Refusal {
    refuse(format!("{} could not be read: {reason}", capital(format.name)), format.help)
}

fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

/// The name of threads in which foreign code may panic; a panic there becomes a sentence, and needs no other message.
pub const GUARDED: &str = "foreign-format";
/// Room for files that nest deeply.
const STACK: usize = 64 << 20;

/// What `work` returns; a panic of it is an error.
fn guarded<T: Send>(work: impl FnOnce() -> Result<T, String> + Send) -> Result<T, String> {
    std::thread::scope(|scope| {
        let builder = std::thread::Builder::new().name(GUARDED.to_owned()).stack_size(STACK);
        let thread = builder.spawn_scoped(scope, work).map_err(|error| error.to_string())?;
        thread.join().unwrap_or_else(|_| Err("its contents contradict each other".to_owned()))
    })
}
