//! Changed bytes.

use std::ops::Range;

use fastrand::Rng;

/// What takes the place of numbers in texts: the ends of what is allowed, and what is none.
const NUMBERS: [&str; 15] = [
    "0",
    "-1",
    "1e308",
    "-1e-308",
    "nan",
    "inf",
    "1e400",
    "1e-9",
    "1e9",
    "",
    "0x10",
    "1_000",
    "99999999999999999999",
    "4294967296",
    "[1, 2]",
];

/// Bytes of a text whose numbers are looked for: long tables are changed at their heads.
const HEAD: usize = 20_000;

/// `data` with some bytes, words or numbers changed, moved, doubled or cut.
pub fn mutate(mut data: Vec<u8>, chance: &mut Rng) -> Vec<u8> {
    for _ in 0..*chance.choice([1, 1, 2, 4].iter()).unwrap_or(&1) {
        if data.is_empty() {
            return vec![0];
        }
        let at = chance.usize(..data.len());
        match chance.u8(0..6) {
            0 => data[at] = chance.u8(..),
            1 => data.truncate(at),
            2 => {
                let piece = data[at..data.len().min(at + chance.usize(1..200))].to_vec();
                let piece = piece.repeat(if chance.bool() { 1 } else { 3 });
                data.splice(at..at, piece);
            }
            3 => drop(data.drain(at..data.len().min(at + chance.usize(1..60)))),
            _ => {
                let numbers = numbers(&data[..data.len().min(HEAD)]);
                if let Some(place) = chance.choice(numbers.iter()) {
                    let other = chance.choice(NUMBERS.iter()).unwrap_or(&"0");
                    data.splice(place.clone(), other.bytes());
                }
            }
        }
    }
    data
}

/// As [`mutate`], or with whole lines and quoted words changed, so that a text often stays well-formed and the change is met
/// deeper inside.
pub fn mutate_text(mut data: Vec<u8>, chance: &mut Rng) -> Vec<u8> {
    if chance.u8(0..3) == 0 {
        return mutate(data, chance);
    }
    for _ in 0..chance.usize(1..4) {
        let change = match chance.u8(0..6) {
            0 | 1 => swapped(&data, &lines(&data), chance),
            2 | 3 => swapped(&data, &quoted(&data), chance),
            4 => number(&data, chance),
            _ => line(&data, chance),
        };
        if let Some((place, new)) = change {
            data.splice(place, new);
        }
    }
    data
}

/// A change: what is replaced, and by what.
type Change = (Range<usize>, Vec<u8>);

/// One of `pieces` becomes another one.
fn swapped(data: &[u8], pieces: &[Range<usize>], chance: &mut Rng) -> Option<Change> {
    let (to, from) = (chance.choice(pieces.iter())?, chance.choice(pieces.iter())?);
    Some((to.clone(), data[from.clone()].to_vec()))
}

/// A number becomes one of [`NUMBERS`].
fn number(data: &[u8], chance: &mut Rng) -> Option<Change> {
    let numbers = numbers(&data[..data.len().min(HEAD)]);
    let place = chance.choice(numbers.iter())?;
    Some((place.clone(), chance.choice(NUMBERS.iter())?.as_bytes().to_vec()))
}

/// A line goes, or comes again elsewhere.
fn line(data: &[u8], chance: &mut Rng) -> Option<Change> {
    let lines = lines(data);
    let (one, other) = (chance.choice(lines.iter())?, chance.choice(lines.iter())?);
    Some(if chance.bool() {
        (one.clone(), Vec::new())
    } else {
        (other.start..other.start, data[one.clone()].to_vec())
    })
}

/// The lines with their ends.
fn lines(data: &[u8]) -> Vec<Range<usize>> {
    let mut start = 0;
    let pieces = data.split_inclusive(|byte| *byte == b'\n').map(|piece| {
        start += piece.len();
        start - piece.len()..start
    });
    pieces.collect()
}

/// What stands in quotation marks.
fn quoted(data: &[u8]) -> Vec<Range<usize>> {
    let marks: Vec<usize> = (0..data.len()).filter(|place| data[*place] == b'"').collect();
    marks.chunks_exact(2).map(|pair| pair[0] + 1..pair[1]).collect()
}

/// Where numbers stand in a text.
fn numbers(data: &[u8]) -> Vec<Range<usize>> {
    let (mut found, mut at) = (Vec::new(), 0);
    while at < data.len() {
        let start = at;
        at += 1;
        if data[start].is_ascii_digit() {
            at +=
                data[at..].iter().take_while(|byte| byte.is_ascii_digit() || b".eE+-".contains(byte)).count();
            found.push(start..at);
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_same_chance_changes_alike_and_most_chances_change_something() {
        let text = b"a = 1.5e-3\nb = [2, 30]\n";
        let changed = |seed| mutate(text.to_vec(), &mut Rng::with_seed(seed));
        assert!((0..100).all(|seed| changed(seed) == changed(seed)));
        assert!((0..100).filter(|seed| changed(*seed) != text).count() > 90);
        assert_eq!(numbers(text), [4..10, 16..17, 19..21]);
    }

    #[test]
    fn lines_and_quoted_words_change_places() {
        let text = b"a = \"b\"\nc = \"d\"\n";
        assert_eq!((lines(text), quoted(text)), (vec![0..8, 8..16], vec![5..6, 13..14]));
        let changed = |seed| mutate_text(text.to_vec(), &mut Rng::with_seed(seed));
        let found = |wanted: &[u8]| (0..200).any(|seed| changed(seed) == wanted);
        assert!(found(b"a = \"d\"\nc = \"d\"\n") && found(b"c = \"d\"\n"));
    }
}
