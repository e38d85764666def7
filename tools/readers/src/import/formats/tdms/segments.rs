//! From segment to segment: which channels a segment holds, in one block or in many, one after the other or in turn.

use std::collections::{BTreeMap, HashMap};

use super::metadata::{Index, Property, Stored, names, objects};
use super::number::{Kind, Order};

/// The lead of a segment: mark, contents, version, length, offset of the data.
const LEAD: usize = 28;
const METADATA: u32 = 1 << 1;
const NEW_LIST: u32 = 1 << 2;
const DATA: u32 = 1 << 3;
const INTERLEAVED: u32 = 1 << 5;
const BIG_ENDIAN: u32 = 1 << 6;
const DAQMX: u32 = 1 << 7;

/// More numbers than this do not fit into the memory that reading may take.
const MOST_NUMBERS: usize = 100_000_000;

/// A channel of the file, with all its values.
#[derive(Debug, Clone)]
pub(super) struct Channel {
    pub group: String,
    pub name: String,
    /// Empty unless they are numbers.
    pub values: Vec<f64>,
    pub has_numbers: bool,
    /// Whether the numbers are those of a clock (s).
    pub is_clock: bool,
    pub properties: BTreeMap<String, Property>,
}

/// The channels of the file, in the order of their first appearance.
pub(super) fn channels(bytes: &[u8]) -> Result<Vec<Channel>, String> {
    let (mut at, mut file) = (0usize, File::default());
    while let Some(lead) = bytes.get(at..at + LEAD) {
        let segment = Segment::new(lead)?;
        let next = at.checked_add(LEAD).and_then(|start| start.checked_add(segment.length));
        let next = next.filter(|next| *next <= bytes.len()).ok_or("the file is cut off")?;
        let (metadata, data) = bytes[at + LEAD..next].split_at(segment.data);
        file.tell(&segment, metadata)?;
        file.take(&segment, data)?;
        at = next;
    }
    Ok(file.channels)
}

/// What the lead of a segment says.
struct Segment {
    contents: u32,
    order: Order,
    /// Bytes of the segment after its lead, and where among them its data begin.
    length: usize,
    data: usize,
}

impl Segment {
    fn new(lead: &[u8]) -> Result<Self, String> {
        if !lead.starts_with(b"TDSm") {
            return Err("a segment does not begin where the one before it ends".to_owned());
        }
        let word = |from: usize| *lead[from..].first_chunk::<8>().unwrap_or(&[0; 8]);
        // The contents come first, and say how to read what follows.
        let contents = u64::from_le_bytes(word(4)) as u32;
        let big = contents & BIG_ENDIAN != 0;
        let whole =
            |from: usize| if big { u64::from_be_bytes(word(from)) } else { u64::from_le_bytes(word(from)) };
        if contents & DAQMX != 0 {
            return Err("it holds raw DAQmx data".to_owned());
        }
        let (length, data) = (whole(12), whole(20));
        if length == u64::MAX || data > length {
            return Err("the recording was not closed".to_owned());
        }
        let length = usize::try_from(length).map_err(|_| "the file is cut off")?;
        let order = if big { Order::Big } else { Order::Little };
        Ok(Self { contents, order, length, data: data as usize })
    }

    fn has(&self, flag: u32) -> bool {
        self.contents & flag != 0
    }
}

/// What is known of the file so far.
#[derive(Default)]
struct File {
    channels: Vec<Channel>,
    /// Place of a path among the channels; none for the file and its groups.
    places: HashMap<String, Option<usize>>,
    /// How each path was stored last.
    last: HashMap<String, Index>,
    /// What a block of the present segment holds, in this order.
    list: Vec<(String, Option<Index>)>,
    /// Numbers so far, at most.
    numbers: usize,
}

impl File {
    /// Takes what a segment says of its channels.
    fn tell(&mut self, segment: &Segment, metadata: &[u8]) -> Result<(), String> {
        if !segment.has(METADATA) {
            return Ok(());
        }
        if segment.has(NEW_LIST) {
            self.list.clear();
        }
        let mut listed: HashMap<String, usize> =
            self.list.iter().enumerate().map(|(place, (path, _))| (path.clone(), place)).collect();
        for object in objects(metadata, segment.order)? {
            let index = match object.stored {
                Stored::Nothing => None,
                Stored::By(index) => Some(index),
                Stored::AsBefore => Some(
                    *self
                        .last
                        .get(&object.path)
                        .ok_or("a channel is stored as before, but there is no before")?,
                ),
            };
            if let Some(index) = index {
                self.last.insert(object.path.clone(), index);
            }
            if let Some(place) = self.place(&object.path) {
                self.channels[place].properties.extend(object.properties);
            }
            match listed.get(&object.path) {
                Some(place) => self.list[*place].1 = index,
                None => {
                    listed.insert(object.path.clone(), self.list.len());
                    self.list.push((object.path, index));
                }
            }
        }
        Ok(())
    }

    /// The place of a channel; `None` for what is no channel.
    fn place(&mut self, path: &str) -> Option<usize> {
        if let Some(place) = self.places.get(path) {
            return *place;
        }
        let place = names(path).map(|(group, name)| {
            let (values, properties) = (Vec::new(), BTreeMap::new());
            self.channels.push(Channel {
                group,
                name,
                values,
                has_numbers: true,
                is_clock: false,
                properties,
            });
            self.channels.len() - 1
        });
        self.places.insert(path.to_owned(), place);
        place
    }

    /// Takes the data of a segment.
    fn take(&mut self, segment: &Segment, data: &[u8]) -> Result<(), String> {
        if !segment.has(DATA) || data.is_empty() {
            return Ok(());
        }
        let held: Vec<(String, Index)> =
            self.list.iter().filter_map(|(path, index)| Some((path.clone(), (*index)?))).collect();
        let mut parts = Vec::with_capacity(held.len());
        for (path, index) in held {
            let place = self.place(&path).ok_or("data belong to no channel")?;
            let channel = &mut self.channels[place];
            channel.has_numbers &= index.kind.is_number();
            channel.is_clock |= index.kind == Kind::Stamp;
            parts.push((place, index));
        }
        self.numbers +=
            data.len() / parts.iter().map(|(_, index)| index.kind.size().max(1)).min().unwrap_or(1);
        if self.numbers > MOST_NUMBERS {
            return Err(format!(
                "it holds more than {MOST_NUMBERS} numbers: export fewer channels, or a shorter time"
            ));
        }
        if segment.has(INTERLEAVED) {
            self.in_turn(segment, &parts, data)
        } else {
            self.in_blocks(segment, &parts, data)
        }
    }

    /// Blocks, in each of which one channel follows the other.
    fn in_blocks(&mut self, segment: &Segment, parts: &[(usize, Index)], data: &[u8]) -> Result<(), String> {
        let block = parts.iter().try_fold(0u64, |sum, (_, index)| sum.checked_add(index.bytes));
        let block = block.and_then(|block| usize::try_from(block).ok()).unwrap_or(usize::MAX);
        if block == 0 || !data.len().is_multiple_of(block) {
            let held = data.len();
            return Err(format!(
                "a segment holds {held} bytes of data, which are not whole blocks of its channels"
            ));
        }
        for mut rest in data.chunks_exact(block) {
            for (place, index) in parts {
                let (own, others) = rest.split_at(index.bytes as usize);
                rest = others;
                if index.kind.is_number() {
                    let values = own.chunks_exact(index.kind.size());
                    self.channels[*place]
                        .values
                        .extend(values.map(|value| index.kind.number(value, segment.order)));
                }
            }
        }
        Ok(())
    }

    /// One value of each channel after the other.
    fn in_turn(&mut self, segment: &Segment, parts: &[(usize, Index)], data: &[u8]) -> Result<(), String> {
        let row: usize = parts.iter().map(|(_, index)| index.kind.size()).sum();
        let same = parts.windows(2).all(|two| two[0].1.count == two[1].1.count);
        if row == 0 || !same || parts.iter().any(|(_, index)| index.kind.size() == 0) {
            return Err("channels whose samples come in turn have different numbers of them".to_owned());
        }
        if !data.len().is_multiple_of(row) {
            return Err(format!(
                "a segment holds {} bytes of data, which are not whole rows of its channels",
                data.len()
            ));
        }
        for mut rest in data.chunks_exact(row) {
            for (place, index) in parts {
                let (own, others) = rest.split_at(index.kind.size());
                rest = others;
                if index.kind.is_number() {
                    self.channels[*place].values.push(index.kind.number(own, segment.order));
                }
            }
        }
        Ok(())
    }
}
