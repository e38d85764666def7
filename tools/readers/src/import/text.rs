//! Text from bytes; other formats by their first bytes.

use encoding_rs::{Encoding, UTF_8, UTF_16BE, UTF_16LE, WINDOWS_1252};

use super::{Refusal, refuse};

/// First bytes of formats that are no text, and what to do with them.
const FORMATS: &[(&[u8], &str, &str)] = &[
    (b"PK\x03\x04", "a workbook or another zip archive", "save the sheet as CSV (UTF-8)"),
    (b"\xd0\xcf\x11\xe0", "an old Excel workbook", "save the sheet as CSV (UTF-8)"),
    (
        b"\x93NUMPY",
        "a NumPy array",
        "in Python: `numpy.savetxt('loop.csv', array, delimiter=',', header='time [s],…', comments='')`",
    ),
    (b"\x1f\x8b", "a gzip archive", "unpack it with `gunzip` first"),
    (b"RIFF", "a sound file (WAV)", "convert it to CSV with a column `time [s]`"),
];

pub(super) fn decode(bytes: Vec<u8>, notes: &mut Vec<String>) -> Result<String, Refusal> {
    if let Some((_, what, help)) = FORMATS.iter().find(|(start, ..)| bytes.starts_with(start)) {
        return Err(refuse(
            format!("this is {what}, which is not read here"),
            format!("export a text table; {help}"),
        ));
    }
    if bytes.iter().all(|byte| byte.is_ascii_whitespace()) {
        return Err(refuse("the file is empty", "export the measurement again, as CSV"));
    }
    let (encoding, start) = match Encoding::for_bom(&bytes) {
        Some(known) => known,
        None => (without_mark(&bytes)?, 0),
    };
    let (text, malformed) = encoding.decode_without_bom_handling(&bytes[start..]);
    if malformed {
        let message = format!("the text begins as {} but does not go on as it", encoding.name());
        return Err(refuse(message, "save the file as UTF-8"));
    }
    if encoding != UTF_8 {
        notes.push(format!("the text was read as {}", encoding.name()));
    }
    Ok(text.into_owned())
}

/// The encoding of text that has no mark: two bytes per letter show by their zeros.
fn without_mark(bytes: &[u8]) -> Result<&'static Encoding, Refusal> {
    let seen = &bytes[..bytes.len().min(4096) & !1];
    let zeros = |odd: usize| seen.iter().skip(odd).step_by(2).filter(|byte| **byte == 0).count();
    let many = seen.len() / 2 * 9 / 10;
    match (zeros(0), zeros(1)) {
        (0, 0) if !bytes.contains(&0) && std::str::from_utf8(bytes).is_ok() => Ok(UTF_8),
        (0, 0) if !bytes.contains(&0) => Ok(WINDOWS_1252),
        (0, high) if high > many => Ok(UTF_16LE),
        (high, 0) if high > many => Ok(UTF_16BE),
        _ => Err(refuse("this is a binary file of an unknown format", "export the measurement as CSV")),
    }
}
