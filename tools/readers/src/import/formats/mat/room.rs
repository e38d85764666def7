//! How much memory the variables of a MAT file of version 5 take, known before any of them is read.

use std::io::Read as _;

use flate2::read::ZlibDecoder;

use super::{BROKEN, HEAD};
use crate::import::formats::Room;

/// Kinds of elements.
const MATRIX: u32 = 14;
const COMPRESSED: u32 = 15;
/// The head of an element: kind and length.
const TAG: usize = 8;
/// What each matrix takes beside its numbers (bytes).
const EACH: u64 = 256;
/// Structs and cells nest no deeper.
const DEEPEST: usize = 64;

/// Refuses a file whose variables have no room, or are cut off.
pub(super) fn check(bytes: &[u8]) -> Result<(), String> {
    let Some((head, mut rest)) = bytes.split_at_checked(HEAD) else { return Err(BROKEN.to_owned()) };
    let big_endian = head.ends_with(b"MI");
    let mut room = Room::default();
    while let Some((tag, after)) = rest.split_first_chunk::<TAG>() {
        let [kind, length] = words(*tag, big_endian);
        let Some((contents, next)) = after.split_at_checked(length as usize) else {
            return Err(BROKEN.to_owned());
        };
        rest = next;
        match kind {
            COMPRESSED => {
                let variable = unpacked(contents, &room, big_endian)?;
                room.take(held(variable.get(TAG..).unwrap_or_default(), big_endian, 0)?)?;
            }
            MATRIX => room.take(held(contents, big_endian, 0)?)?,
            _ => {}
        }
    }
    Ok(())
}

/// A variable without its compression, unless there is no room for its bytes.
fn unpacked(packed: &[u8], room: &Room, big_endian: bool) -> Result<Vec<u8>, String> {
    let broken = |_| BROKEN.to_owned();
    let mut stream = ZlibDecoder::new(packed);
    let mut tag = [0; TAG];
    stream.read_exact(&mut tag).map_err(broken)?;
    let [_, length] = words(tag, big_endian);
    room.has(u64::from(length))?;
    let mut variable = tag.to_vec();
    stream.take(room.left() + 1).read_to_end(&mut variable).map_err(broken)?;
    room.has((variable.len() - TAG) as u64)?;
    Ok(variable)
}

/// Bytes that the contents of a matrix take once they are read: eight for a number, however short it is stored.
fn held(mut contents: &[u8], big_endian: bool, depth: usize) -> Result<u64, String> {
    if depth > DEEPEST {
        return Err("its structs or cells nest too deeply".to_owned());
    }
    let mut sum = EACH;
    while let Some((kind, inner)) = next(&mut contents, big_endian) {
        sum += match kind {
            MATRIX => held(inner, big_endian, depth + 1)?,
            COMPRESSED => return Err(BROKEN.to_owned()),
            kind => inner.len() as u64 / width(kind) * 8,
        };
    }
    Ok(sum)
}

/// The next element of `contents`, its kind and what it holds; short ones hold it in their head.
fn next<'b>(contents: &mut &'b [u8], big_endian: bool) -> Option<(u32, &'b [u8])> {
    let (tag, after) = contents.split_first_chunk::<TAG>()?;
    let [kind, length] = words(*tag, big_endian);
    if kind >> 16 != 0 {
        let inner = &contents[4..TAG];
        *contents = after;
        return Some((kind & 0xFFFF, &inner[..inner.len().min((kind >> 16) as usize)]));
    }
    let inner = &after[..after.len().min(length as usize)];
    *contents = &after[after.len().min(inner.len().next_multiple_of(TAG))..];
    Some((kind, inner))
}

/// Bytes of a number of this kind.
fn width(kind: u32) -> u64 {
    match kind {
        3 | 4 | 17 => 2,
        5..=7 | 18 => 4,
        9 | 12 | 13 => 8,
        _ => 1,
    }
}

fn words(tag: [u8; TAG], big_endian: bool) -> [u32; 2] {
    let [a, b, c, d, e, f, g, h] = tag;
    [[a, b, c, d], [e, f, g, h]]
        .map(|word| if big_endian { u32::from_be_bytes(word) } else { u32::from_le_bytes(word) })
}
