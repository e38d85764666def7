//! What a segment says of its channels: how many values of which kind a block of it holds, and properties.

use std::collections::BTreeMap;

use super::number::{Kind, Order};

/// What a channel is told to be, beside its numbers.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Property {
    Number(f64),
    Words(String),
}

/// What a block of a segment holds of an object.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Index {
    pub kind: Kind,
    pub count: u64,
    /// All its bytes.
    pub bytes: u64,
}

/// How an object of a segment is stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Stored {
    Nothing,
    AsBefore,
    By(Index),
}

/// An object of a segment.
#[derive(Debug, Clone)]
pub(super) struct Object {
    pub path: String,
    pub stored: Stored,
    pub properties: BTreeMap<String, Property>,
}

/// Marks of an index.
const NO_DATA: u32 = u32::MAX;
const AS_BEFORE: u32 = 0;
const OF_DAQMX: [u32; 2] = [0x1269, 0x126A];

/// The objects that the `bytes` of a segment's metadata tell of.
pub(super) fn objects(bytes: &[u8], order: Order) -> Result<Vec<Object>, String> {
    let mut at = Cursor { bytes, order };
    let count = at.whole(4)?;
    let mut objects = Vec::new();
    for _ in 0..count {
        let path = at.words()?;
        let stored = match at.whole(4)? as u32 {
            NO_DATA => Stored::Nothing,
            AS_BEFORE => Stored::AsBefore,
            mark if OF_DAQMX.contains(&mark) => return Err("it holds raw DAQmx data".to_owned()),
            _ => Stored::By(at.index()?),
        };
        let mut properties = BTreeMap::new();
        for _ in 0..at.whole(4)? {
            let name = at.words()?;
            if let Some(value) = at.property()? {
                properties.insert(name, value);
            }
        }
        objects.push(Object { path, stored, properties });
    }
    Ok(objects)
}

/// The group and the channel of a path such as `/'loop'/'force'`, in which a quotation mark is doubled.
pub(super) fn names(path: &str) -> Option<(String, String)> {
    let (mut names, mut quoted) = (Vec::new(), false);
    let mut letters = path.chars().peekable();
    while let Some(letter) = letters.next() {
        match (letter, quoted) {
            ('/', false) => names.push(String::new()),
            ('\'', true) if letters.peek() == Some(&'\'') => {
                letters.next();
                names.last_mut()?.push('\'');
            }
            ('\'', _) => quoted = !quoted,
            (letter, _) => names.last_mut()?.push(letter),
        }
    }
    let [group, channel] = <[String; 2]>::try_from(names).ok()?;
    Some((group, channel))
}

/// A place in the metadata.
struct Cursor<'b> {
    bytes: &'b [u8],
    order: Order,
}

impl<'b> Cursor<'b> {
    fn take(&mut self, count: u64) -> Result<&'b [u8], String> {
        let count = usize::try_from(count).ok().filter(|count| *count <= self.bytes.len());
        let (taken, rest) = self.bytes.split_at(count.ok_or("what it says of its channels is cut off")?);
        self.bytes = rest;
        Ok(taken)
    }

    /// A whole number of so many bytes.
    fn whole(&mut self, size: u64) -> Result<u64, String> {
        let taken = self.take(size)?;
        let shifted = |sum: u64, byte: &u8| sum << 8 | u64::from(*byte);
        Ok(match self.order {
            Order::Little => taken.iter().rev().fold(0, shifted),
            Order::Big => taken.iter().fold(0, shifted),
        })
    }

    fn words(&mut self) -> Result<String, String> {
        let length = self.whole(4)?;
        Ok(String::from_utf8_lossy(self.take(length)?).into_owned())
    }

    fn kind(&mut self) -> Result<Kind, String> {
        Kind::new(self.whole(4)? as u32)
    }

    /// The kind of the values, their dimension, which is always 1, how many, and of words the bytes of all.
    fn index(&mut self) -> Result<Index, String> {
        let kind = self.kind()?;
        if self.whole(4)? != 1 {
            return Err("it holds values of more than one dimension".to_owned());
        }
        let count = self.whole(8)?;
        let bytes = match kind {
            Kind::Text => Some(self.whole(8)?),
            _ => count.checked_mul(kind.size() as u64),
        };
        let bytes = bytes.ok_or("its channels claim more values than it holds")?;
        Ok(Index { kind, count, bytes })
    }

    /// The value of a property; `None` for what is neither number nor words.
    fn property(&mut self) -> Result<Option<Property>, String> {
        let kind = self.kind()?;
        if kind == Kind::Text {
            return Ok(Some(Property::Words(self.words()?)));
        }
        let value = self.take(kind.size() as u64)?;
        let number = kind.is_number() && kind != Kind::Stamp;
        Ok(number.then(|| Property::Number(kind.number(value, self.order))))
    }
}

#[cfg(test)]
mod tests {
    use super::names;

    #[test]
    fn a_path_names_group_and_channel() {
        let both = |group: &str, channel: &str| Some((group.to_owned(), channel.to_owned()));
        assert_eq!(names("/'loop'/'force'"), both("loop", "force"));
        assert_eq!(names("/'it''s a/b'/'u [mm]'"), both("it's a/b", "u [mm]"));
        assert_eq!([names("/"), names("/'loop'"), names("force")], [None, None, None]);
    }
}
