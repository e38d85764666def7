//! A text file in memory, and lines of it for messages.

use std::ops::Range;
use std::path::{Path, PathBuf};

use encoding_rs::{Encoding, UTF_8, UTF_16BE, UTF_16LE};
use stickslip::document::DocumentError;

use crate::bounded;
use crate::error::{Excerpt, InputError, Problem};

/// The text of a file, without its byte order mark.
#[derive(Debug)]
pub(crate) struct Source {
    path: PathBuf,
    text: String,
}

impl Source {
    pub(crate) fn read(path: &Path) -> Result<Self, InputError> {
        Source::from_bytes(path, bounded::read(path)?)
    }

    /// An XML file, in the encoding that it shows or declares.
    pub(crate) fn read_xml(path: &Path) -> Result<Self, InputError> {
        Source::from_xml_bytes(path, bounded::read(path)?)
    }

    /// As [`Source::read_xml`], of its bytes.
    pub(crate) fn from_xml_bytes(path: &Path, bytes: Vec<u8>) -> Result<Self, InputError> {
        let encoding = match encoding(&bytes[..bytes.len().min(HEAD)]) {
            Ok(encoding) if encoding == UTF_8 => return Source::from_bytes(path, bytes),
            Ok(encoding) => encoding,
            Err(name) => {
                let excerpt = Some(excerpt(&String::from_utf8_lossy(&bytes), 0..0));
                let problem = Box::new(Problem::Encoding(name));
                return Err(InputError { path: path.to_owned(), excerpt, problem });
            }
        };
        match encoding.decode_with_bom_removal(&bytes) {
            (text, false) => Ok(Source { path: path.to_owned(), text: text.into_owned() }),
            (_, true) => Source::from_bytes(path, bytes),
        }
    }

    pub(crate) fn from_bytes(path: &Path, bytes: Vec<u8>) -> Result<Self, InputError> {
        let mut text = String::from_utf8(bytes).map_err(|error| {
            let wrong = error.utf8_error().valid_up_to();
            not_utf8(path, error.as_bytes(), wrong)
        })?;
        if text.starts_with('\u{feff}') {
            text.drain(..'\u{feff}'.len_utf8());
        }
        Ok(Source { path: path.to_owned(), text })
    }

    pub(crate) fn text(&self) -> &str {
        &self.text
    }

    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// Number of the line, from 1, of a byte of the text.
    pub(crate) fn line(&self, byte: usize) -> usize {
        excerpt(&self.text, byte..byte).line
    }

    /// An error about the bytes `span` of the text.
    pub(crate) fn error(&self, span: Range<usize>, problem: Problem) -> InputError {
        let excerpt = Some(excerpt(&self.text, span));
        InputError { path: self.path.clone(), excerpt, problem: Box::new(problem) }
    }

    /// An error about the first line.
    pub(crate) fn error_at_start(&self, problem: Problem) -> InputError {
        self.error(0..0, problem)
    }

    pub(crate) fn document_error(&self, error: DocumentError) -> InputError {
        self.error(error.span.clone().unwrap_or(0..0), Problem::Document(error))
    }
}

/// Bytes in which the declaration of an XML file ends.
pub(crate) const HEAD: usize = 256;

/// The encoding of the XML file that begins with `head`: by its byte order mark, its first letter or its declaration.
///
/// # Errors
/// The name of an encoding that is not known.
pub(crate) fn encoding(head: &[u8]) -> Result<&'static Encoding, String> {
    let declared = match head {
        [0xff, 0xfe, ..] | [b'<', 0, ..] => return Ok(UTF_16LE),
        [0xfe, 0xff, ..] | [0, b'<', ..] => return Ok(UTF_16BE),
        // Not what begins with the byte order mark of UTF-8.
        [b'<', ..] => declared(head),
        _ => None,
    };
    let Some(name) = declared else { return Ok(UTF_8) };
    match Encoding::for_label_no_replacement(name) {
        // Its declaration could not be read if it were.
        Some(encoding) if [UTF_16LE, UTF_16BE].contains(&encoding) => Ok(UTF_8),
        Some(encoding) => Ok(encoding),
        None => Err(String::from_utf8_lossy(name).into_owned()),
    }
}

/// The encoding that an XML declaration names.
fn declared(head: &[u8]) -> Option<&[u8]> {
    const NAME: &[u8] = b"encoding";
    let declaration = head.strip_prefix(b"<?xml")?;
    let end = declaration.windows(2).position(|pair| pair == b"?>")?;
    let at = declaration[..end].windows(NAME.len()).position(|word| word == NAME)?;
    let value = declaration[at + NAME.len()..end].trim_ascii_start().strip_prefix(b"=")?.trim_ascii_start();
    let (quote, rest) = value.split_first()?;
    rest.split(|byte| byte == quote).next()
}

fn not_utf8(path: &Path, bytes: &[u8], wrong: usize) -> InputError {
    let guess = match bytes {
        [0xff, 0xfe, ..] | [0xfe, 0xff, ..] => "UTF-16",
        // Bytes that stand for nothing in Latin-1 and seldom occur in text.
        _ if bytes.contains(&0) => "a binary file",
        _ => "Latin-1 (Windows-1252)",
    };
    // Up to the wrong byte the text is valid; from there on it is shown as well as it can be.
    let start = bytes[..wrong].iter().rposition(|byte| is_line_end(*byte)).map_or(0, |end| end + 1);
    let end =
        bytes[wrong..].iter().position(|byte| is_line_end(*byte)).map_or(bytes.len(), |end| wrong + end);
    let before = String::from_utf8_lossy(&bytes[..start]);
    let shown = format!("{before}{}", String::from_utf8_lossy(&bytes[start..end]));
    let width = char::REPLACEMENT_CHARACTER.len_utf8();
    InputError {
        path: path.to_owned(),
        excerpt: Some(excerpt(&shown, wrong..wrong + width)),
        problem: Box::new(Problem::NotUtf8 { guess }),
    }
}

fn is_line_end(byte: u8) -> bool {
    byte == b'\n' || byte == b'\r'
}

/// Binary files have lines of megabytes: a line is shown this many bytes beyond the start of what is wrong
/// with it, and not at all if that start lies further into the line.
const SHOWN: usize = 500;

/// The line at the start of `span`; of the span, what lies on that line.
pub(crate) fn excerpt(text: &str, span: Range<usize>) -> Excerpt {
    let start = floor_boundary(text, span.start);
    let line_start = text[..start].rfind(['\n', '\r']).map_or(0, |end| end + 1);
    let line_end = text[start..].find(['\n', '\r']).map_or(text.len(), |end| start + end);
    let line_end = floor_boundary(text, line_end.min(start + SHOWN));
    let end = floor_boundary(text, span.end.clamp(start, line_end));
    let line = 1 + line_ends(&text[..line_start]);
    let column = 1 + text[line_start..start].chars().count();
    if start - line_start > SHOWN {
        return Excerpt { line, column, text: String::new(), span: 0..0 };
    }
    let span = start - line_start..end - line_start;
    Excerpt { line, column, text: text[line_start..line_end].to_owned(), span }
}

/// CR-LF is one end of a line; so are a bare LF and a bare CR.
fn line_ends(text: &str) -> usize {
    let feeds = text.matches('\n').count();
    let returns = text.matches('\r').count();
    feeds + returns - text.matches("\r\n").count()
}

fn floor_boundary(text: &str, index: usize) -> usize {
    let index = index.min(text.len());
    (0..=index).rev().find(|index| text.is_char_boundary(*index)).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_count_the_same_with_every_line_end() {
        for end in ["\n", "\r\n", "\r"] {
            let text = ["one", "two", "", "µfour"].join(end);
            let place = text.find("four").unwrap();
            let excerpt = excerpt(&text, place..place + 4);
            assert_eq!((excerpt.line, excerpt.text.as_str(), excerpt.column), (4, "µfour", 2));
            assert_eq!(&excerpt.text[excerpt.span], "four");
        }
    }

    #[test]
    fn spans_beyond_the_line_or_the_text_are_cut() {
        let found = excerpt("one\ntwo", 2..6);
        assert_eq!((found.line, &found.text[found.span.clone()]), (1, "e"));
        for span in [7..7, 9..20, 3..3] {
            let found = excerpt("one\ntwo", span);
            assert!(found.span.end <= found.text.len());
        }
        assert_eq!(excerpt("", 0..0).line, 1);
    }

    #[test]
    fn long_lines_are_cut_and_places_far_into_them_are_only_numbered() {
        let text = format!("one\n{}", "µ".repeat(10_000));
        let found = excerpt(&text, 4..20_000);
        assert!((found.line, found.column) == (2, 1) && found.text.len() <= SHOWN && !found.text.is_empty());
        let found = excerpt(&text, 10_004..10_006);
        assert_eq!((found.line, found.column, found.text.as_str()), (2, 5001, ""));
    }
}
