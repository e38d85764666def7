//! The least of Apache Parquet that holds a table of numbers: one row group of required Double columns, plainly
//! encoded, not compressed.
//!
//! A file is the pages of one column after the other between two marks, and at the end a description of them, with its
//! length. Descriptions are written in Thrift's compact protocol (Apache Parquet Format 2.x, `parquet.thrift`).

const MARK: &[u8] = b"PAR1";
/// Values in a page at most; the length of a page is a number of 32 bits.
const PAGE: usize = 1 << 20;

// Enumerations of the format.
const DOUBLE: i64 = 5;
const REQUIRED: i64 = 0;
const PLAIN: i64 = 0;
const RUN_LENGTHS: i64 = 3;
const UNCOMPRESSED: i64 = 0;
const DATA_PAGE: i64 = 0;

/// Where the pages of a column are.
struct Chunk<'n> {
    name: &'n str,
    start: usize,
    length: usize,
}

/// The bytes of a file with these columns, all of the same length; `notes` are names and values about the whole.
pub(super) fn parquet(columns: &[(String, &[f64])], notes: &[(&str, &str)]) -> Vec<u8> {
    let rows = columns.first().map_or(0, |(_, values)| values.len());
    let mut bytes = MARK.to_vec();
    let mut chunks = Vec::new();
    for (name, values) in columns {
        let start = bytes.len();
        for page in values.chunks(PAGE) {
            let header = page_header(page.len());
            bytes.extend(header);
            page.iter().for_each(|value| bytes.extend(value.to_le_bytes()));
        }
        chunks.push(Chunk { name, start, length: bytes.len() - start });
    }
    let footer = description(&chunks, rows, notes);
    bytes.extend(&footer);
    bytes.extend((footer.len() as u32).to_le_bytes());
    bytes.extend(MARK);
    bytes
}

/// `PageHeader` of `count` values.
fn page_header(count: usize) -> Vec<u8> {
    let (count, length) = (count as i64, 8 * count as i64);
    let mut header = Compact::default();
    header.int(1, DATA_PAGE);
    header.int(2, length);
    header.int(3, length);
    header.open(5);
    header.int(1, count);
    header.int(2, PLAIN);
    header.int(3, RUN_LENGTHS);
    header.int(4, RUN_LENGTHS);
    header.close();
    header.finish()
}

/// `FileMetaData`.
fn description(chunks: &[Chunk<'_>], rows: usize, notes: &[(&str, &str)]) -> Vec<u8> {
    let mut file = Compact::default();
    file.int(1, 1);
    file.list(2, STRUCT, chunks.len() + 1);
    file.item();
    file.text(4, "simulation");
    file.int(5, chunks.len() as i64);
    file.close();
    for chunk in chunks {
        file.item();
        file.int(1, DOUBLE);
        file.int(3, REQUIRED);
        file.text(4, chunk.name);
        file.close();
    }
    file.long(3, rows);
    file.list(4, STRUCT, 1);
    file.item();
    file.list(1, STRUCT, chunks.len());
    for chunk in chunks {
        column(&mut file, chunk, rows);
    }
    file.long(2, chunks.iter().map(|chunk| chunk.length).sum());
    file.long(3, rows);
    file.close();
    file.list(5, STRUCT, notes.len());
    for (name, value) in notes {
        file.item();
        file.text(1, name);
        file.text(2, value);
        file.close();
    }
    file.text(6, concat!("stickslip version ", env!("CARGO_PKG_VERSION")));
    file.finish()
}

/// `ColumnChunk` with its `ColumnMetaData`.
fn column(file: &mut Compact, chunk: &Chunk<'_>, rows: usize) {
    file.item();
    file.long(2, chunk.start);
    file.open(3);
    file.int(1, DOUBLE);
    file.list(2, INT, 1);
    file.bare_int(PLAIN);
    file.list(3, BINARY, 1);
    file.bare_text(chunk.name);
    file.int(4, UNCOMPRESSED);
    file.long(5, rows);
    file.long(6, chunk.length);
    file.long(7, chunk.length);
    file.long(9, chunk.start);
    file.close();
    file.close();
}

// Types of the compact protocol.
const INT: u8 = 5;
const LONG: u8 = 6;
const BINARY: u8 = 8;
const LIST: u8 = 9;
const STRUCT: u8 = 12;

/// A structure being written in Thrift's compact protocol.
#[derive(Default)]
struct Compact {
    bytes: Vec<u8>,
    /// The last field of each open structure, the innermost last; that of the outermost is in `last`.
    outer: Vec<u8>,
    last: u8,
}

impl Compact {
    /// The fields that are written here are less than 15 apart.
    fn field(&mut self, number: u8, kind: u8) {
        self.bytes.push((number - self.last) << 4 | kind);
        self.last = number;
    }

    fn unsigned(&mut self, mut value: u64) {
        while value >= 0x80 {
            self.bytes.push(value as u8 | 0x80);
            value >>= 7;
        }
        self.bytes.push(value as u8);
    }

    /// Zigzag: small numbers of either sign are short.
    fn bare_int(&mut self, value: i64) {
        self.unsigned(((value << 1) ^ (value >> 63)).cast_unsigned());
    }

    fn bare_text(&mut self, text: &str) {
        self.unsigned(text.len() as u64);
        self.bytes.extend(text.as_bytes());
    }

    fn int(&mut self, number: u8, value: i64) {
        self.field(number, INT);
        self.bare_int(value);
    }

    fn long(&mut self, number: u8, value: usize) {
        self.field(number, LONG);
        self.bare_int(value as i64);
    }

    fn text(&mut self, number: u8, text: &str) {
        self.field(number, BINARY);
        self.bare_text(text);
    }

    fn list(&mut self, number: u8, kind: u8, count: usize) {
        self.field(number, LIST);
        if count < 15 {
            self.bytes.push((count as u8) << 4 | kind);
        } else {
            self.bytes.push(0xf0 | kind);
            self.unsigned(count as u64);
        }
    }

    /// Begins a structure in a list.
    fn item(&mut self) {
        self.outer.push(self.last);
        self.last = 0;
    }

    /// Begins a structure in a field.
    fn open(&mut self, number: u8) {
        self.field(number, STRUCT);
        self.item();
    }

    fn close(&mut self) {
        self.bytes.push(0);
        self.last = self.outer.pop().unwrap_or(0);
    }

    fn finish(mut self) -> Vec<u8> {
        self.bytes.push(0);
        self.bytes
    }
}
