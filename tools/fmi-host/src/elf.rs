//! Whether a shared library for Linux is whole, before the system maps it: one that is cut off would end this process
//! with SIGBUS at the first touch of what is missing. (Tool Interface Standard, Executable and Linking Format 1.2.)

use std::fs::File;
use std::io;
use std::os::unix::fs::FileExt as _;
use std::path::Path;

/// Why a file cannot be loaded as a library.
#[derive(Debug, thiserror::Error)]
pub enum ElfProblem {
    /// The system does not give it.
    #[error("the library cannot be read: {0}")]
    Unreadable(#[from] io::Error),
    /// Something else.
    #[error(
        "the library is damaged, or the file is not a library: {0}; get the FMU again, or build it again"
    )]
    Damaged(&'static str),
    /// The end of the file is missing.
    #[error("the library is cut off: it has {have} bytes of {needed}; get the FMU again, or build it again")]
    CutOff {
        /// Bytes that are there.
        have: u64,
        /// Bytes that its segments need.
        needed: u64,
    },
    /// For another kind of computer.
    #[error("the library is for {0}, this program for {here}; get an FMU for {here}", here = std::env::consts::ARCH)]
    Foreign(String),
}

/// Where numbers are in the header, in an entry of the table of segments, and in one of the dynamic section.
struct Layout {
    class: u8,
    /// Size of an address.
    word: usize,
    header: usize,
    table: usize,
    entry_size: usize,
    entries: usize,
    entry: usize,
    offset: usize,
    address: usize,
    file_size: usize,
}

const BITS_64: Layout = Layout {
    class: 2,
    word: 8,
    header: 64,
    table: 32,
    entry_size: 54,
    entries: 56,
    entry: 56,
    offset: 8,
    address: 16,
    file_size: 32,
};
const BITS_32: Layout = Layout {
    class: 1,
    word: 4,
    header: 52,
    table: 28,
    entry_size: 42,
    entries: 44,
    entry: 32,
    offset: 4,
    address: 8,
    file_size: 16,
};

const LITTLE_ENDIAN: u8 = 1;
const SHARED: u64 = 3;
// Kinds of segments.
const LOAD: u64 = 1;
const DYNAMIC: u64 = 2;
// Kinds of entries in the dynamic section without which nothing can be looked up.
const STRINGS: u64 = 5;
const SYMBOLS: u64 = 6;

/// What computers are called in the header.
const MACHINES: [(u64, &str); 5] =
    [(3, "x86"), (40, "arm"), (62, "x86_64"), (183, "aarch64"), (243, "riscv64")];

struct Segment {
    kind: u64,
    offset: u64,
    address: u64,
    size: u64,
}

/// Checks that the file at `path` is a library for this computer and that all of its segments are in the file.
pub fn check(path: &Path) -> Result<(), ElfProblem> {
    let layout = if cfg!(target_pointer_width = "64") { BITS_64 } else { BITS_32 };
    let file = File::open(path)?;
    let length = file.metadata()?.len();
    let mut header = vec![0; layout.header];
    if length < 20 || file.read_exact_at(&mut header[..20], 0).is_err() || !header.starts_with(b"\x7fELF") {
        return Err(ElfProblem::Damaged("it does not begin like a library"));
    }
    let machine = number(&header, 18, 2);
    let known = MACHINES.iter().find(|(number, _)| *number == machine);
    if known.is_some_and(|(_, name)| *name != std::env::consts::ARCH)
        || (header[4], header[5]) != (layout.class, LITTLE_ENDIAN)
    {
        let name =
            known.map_or_else(|| format!("a computer of the kind {machine}"), |(_, name)| (*name).into());
        return Err(ElfProblem::Foreign(name));
    }
    let segments = segments(&file, &layout, &mut header, length)?;
    if let Some(needed) = segments.iter().map(|one| one.offset.saturating_add(one.size)).max()
        && needed > length
    {
        return Err(ElfProblem::CutOff { have: length, needed });
    }
    check_dynamic(&file, &layout, &segments)
}

fn segments(
    file: &File,
    layout: &Layout,
    header: &mut [u8],
    length: u64,
) -> Result<Vec<Segment>, ElfProblem> {
    let cut_off = |needed: u64| ElfProblem::CutOff { have: length, needed };
    file.read_exact_at(header, 0).map_err(|_| cut_off(header.len() as u64))?;
    let entries = number(header, layout.entries, 2);
    if number(header, 16, 2) != SHARED {
        return Err(ElfProblem::Damaged("it is a program or an object file"));
    }
    if number(header, layout.entry_size, 2) != layout.entry as u64 || entries == 0 {
        return Err(ElfProblem::Damaged("its table of segments cannot be read"));
    }
    let start = number(header, layout.table, layout.word);
    let mut table = vec![0; layout.entry * entries as usize];
    file.read_exact_at(&mut table, start).map_err(|_| cut_off(start.saturating_add(table.len() as u64)))?;
    let segment = |entry: &[u8]| Segment {
        kind: number(entry, 0, 4),
        offset: number(entry, layout.offset, layout.word),
        address: number(entry, layout.address, layout.word),
        size: number(entry, layout.file_size, layout.word),
    };
    Ok(table.chunks_exact(layout.entry).map(segment).collect())
}

/// The loader takes what the dynamic section says for granted.
fn check_dynamic(file: &File, layout: &Layout, segments: &[Segment]) -> Result<(), ElfProblem> {
    let Some(dynamic) = segments.iter().find(|one| one.kind == DYNAMIC) else {
        return Err(ElfProblem::Damaged("it has no dynamic section"));
    };
    let mut entries = vec![0; usize::try_from(dynamic.size).unwrap_or(0)];
    file.read_exact_at(&mut entries, dynamic.offset)?;
    let loaded = |address: u64| {
        let mut loads = segments.iter().filter(|one| one.kind == LOAD);
        loads.any(|one| address >= one.address && address - one.address < one.size)
    };
    let found = |wanted: u64| {
        let pairs = entries.chunks_exact(2 * layout.word);
        let mut pairs =
            pairs.map(|pair| (number(pair, 0, layout.word), number(pair, layout.word, layout.word)));
        pairs
            .by_ref()
            .take_while(|(kind, _)| *kind != 0)
            .any(|(kind, address)| kind == wanted && loaded(address))
    };
    if found(STRINGS) && found(SYMBOLS) {
        Ok(())
    } else {
        Err(ElfProblem::Damaged("its table of symbols is missing"))
    }
}

/// A little-endian number of `size` bytes.
fn number(bytes: &[u8], at: usize, size: usize) -> u64 {
    bytes[at..at + size].iter().rev().fold(0, |number, byte| number << 8 | u64::from(*byte))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_libraries_of_this_system_are_whole() {
        let folders = [format!("/usr/lib/{}-linux-gnu", std::env::consts::ARCH), "/usr/lib64".to_owned()];
        let files = folders.iter().filter_map(|folder| std::fs::read_dir(folder).ok()).flatten().flatten();
        let libraries = files.map(|file| file.path()).filter(|path| {
            let name = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
            name.contains(".so") && std::fs::read(path).is_ok_and(|bytes| bytes.starts_with(b"\x7fELF"))
        });
        for library in libraries {
            assert!(check(&library).is_ok(), "{}: {:?}", library.display(), check(&library));
        }
    }
}
