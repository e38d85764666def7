//! The whole state of an instance as numbers, and as bytes that another process may read.

use super::stage::Stage;
use uuid::Uuid;

const MAGIC: &[u8; 16] = b"stickslip state\0";
const VERSION: u32 = 3;
/// Magic, version, stage, GUID, number of numbers.
const HEADER: usize = 16 + 4 + 4 + 16 + 8;
const CHECKSUM: usize = 8;

/// The whole state of an instance: setting it makes an instance continue bit by bit as the saved one.
#[derive(Debug, Clone, PartialEq)]
pub struct Snapshot {
    pub(super) guid: Uuid,
    pub(super) stage: Stage,
    /// Values of all variables, then the behaviour's state, derivatives pending for the inputs, time, tolerance and
    /// limits; where the importer integrates, the values at the last accepted instant.
    pub(super) numbers: Vec<f64>,
}

/// Why bytes are no snapshot of a model.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum SnapshotError {
    /// Fewer or more bytes than the header announces.
    #[error("{found} bytes, where the saved state has {expected}")]
    Length {
        /// Bytes given.
        found: usize,
        /// Bytes announced.
        expected: usize,
    },
    /// They do not begin as a snapshot does.
    #[error("these bytes are not a saved state")]
    Foreign,
    /// Written by an unknown version.
    #[error("saved in format {0}; this library reads format {VERSION}")]
    Version(u32),
    /// The checksum does not fit, or numbers that no instance has: some byte was changed.
    #[error("the saved state is corrupt")]
    Corrupt,
    /// Saved by another model.
    #[error("saved by another model (GUID {found}; this is {expected})")]
    OtherModel {
        /// GUID in the snapshot.
        found: Uuid,
        /// GUID of the instance.
        expected: Uuid,
    },
}

impl Snapshot {
    /// Length of [`Snapshot::to_bytes`].
    pub fn byte_len(&self) -> usize {
        HEADER + 8 * self.numbers.len() + CHECKSUM
    }

    /// GUID of the model that was saved.
    pub fn guid(&self) -> Uuid {
        self.guid
    }

    /// Versioned header, little-endian numbers, checksum: the same bytes on every platform.
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut bytes = Vec::with_capacity(self.byte_len());
        bytes.extend_from_slice(MAGIC);
        bytes.extend_from_slice(&VERSION.to_le_bytes());
        bytes.extend_from_slice(&(self.stage as u32).to_le_bytes());
        bytes.extend_from_slice(self.guid.as_bytes());
        bytes.extend_from_slice(&(self.numbers.len() as u64).to_le_bytes());
        for number in &self.numbers {
            bytes.extend_from_slice(&number.to_le_bytes());
        }
        bytes.extend_from_slice(&fnv1a(&bytes).to_le_bytes());
        bytes
    }

    /// Reads what [`Snapshot::to_bytes`] wrote.
    ///
    /// # Errors
    /// Bytes of another origin or version, too few or too many, or changed ones.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, SnapshotError> {
        if !bytes.starts_with(MAGIC) {
            return Err(SnapshotError::Foreign);
        }
        let found = bytes.len();
        if found < HEADER + CHECKSUM {
            return Err(SnapshotError::Length { found, expected: HEADER + CHECKSUM });
        }
        let version = u32::from_le_bytes(array(bytes, 16));
        if version != VERSION {
            return Err(SnapshotError::Version(version));
        }
        let count = u64::from_le_bytes(array(bytes, 40));
        let expected = usize::try_from(count)
            .ok()
            .and_then(|count| count.checked_mul(8)?.checked_add(HEADER + CHECKSUM))
            .unwrap_or(usize::MAX);
        if found != expected {
            return Err(SnapshotError::Length { found, expected });
        }
        let body = found - CHECKSUM;
        if u64::from_le_bytes(array(bytes, body)) != fnv1a(&bytes[..body]) {
            return Err(SnapshotError::Corrupt);
        }
        let stage = Stage::from_number(u32::from_le_bytes(array(bytes, 20))).ok_or(SnapshotError::Corrupt)?;
        let numbers = bytes[HEADER..body].chunks_exact(8).map(|chunk| f64::from_le_bytes(array(chunk, 0)));
        Ok(Self { guid: Uuid::from_bytes(array(bytes, 24)), stage, numbers: numbers.collect() })
    }
}

/// `N` bytes from `at`; the caller has checked the length.
fn array<const N: usize>(bytes: &[u8], at: usize) -> [u8; N] {
    std::array::from_fn(|index| bytes[at + index])
}

/// The 64-bit FNV-1a hash (Fowler, Noll, Vo): finds any single changed byte.
fn fnv1a(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
        (hash ^ u64::from(*byte)).wrapping_mul(0x0000_0100_0000_01b3)
    })
}
