//! What the two processes say to each other: frames of a length (4 bytes) and so many bytes, numbers little-endian.
//!
//! A request begins with its [`Call`]; an answer with the new messages of the FMU, then 0 and the result, or 1 and
//! what failed.

use std::io::{self, Read, Write};

use stickslip::cosim::{Setup, Severity};

use crate::binding::Status;
use crate::log::Message;

/// Bytes of a frame at most: a state of an FMU may be large.
const LARGEST: usize = 1 << 30;

/// Bytes for which there is room before they come: what only claims to be long takes no memory.
const PIECE: usize = 1 << 20;

/// What is asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Call {
    SetUp,
    EnterInitialization,
    ExitInitialization,
    Set,
    Get,
    SetInputDerivatives,
    OutputDerivatives,
    DirectionalDerivative,
    DoStep,
    Save,
    Restore,
    Terminate,
    SetText,
}

impl Call {
    const ALL: [Call; 13] = [
        Call::SetUp,
        Call::EnterInitialization,
        Call::ExitInitialization,
        Call::Set,
        Call::Get,
        Call::SetInputDerivatives,
        Call::OutputDerivatives,
        Call::DirectionalDerivative,
        Call::DoStep,
        Call::Save,
        Call::Restore,
        Call::Terminate,
        Call::SetText,
    ];

    pub fn from_number(number: u8) -> Option<Self> {
        Self::ALL.get(usize::from(number)).copied()
    }
}

/// A frame being written.
#[derive(Debug, Default)]
pub struct Frame(Vec<u8>);

impl Frame {
    pub fn clear(&mut self) {
        self.0.clear();
    }

    pub fn byte(&mut self, byte: u8) {
        self.0.push(byte);
    }

    pub fn count(&mut self, count: usize) {
        self.0.extend((count as u32).to_le_bytes());
    }

    pub fn number(&mut self, number: f64) {
        self.0.extend(number.to_le_bytes());
    }

    pub fn optional(&mut self, number: Option<f64>) {
        self.byte(u8::from(number.is_some()));
        self.number(number.unwrap_or(0.0));
    }

    pub fn numbers(&mut self, numbers: &[f64]) {
        self.count(numbers.len());
        numbers.iter().for_each(|number| self.number(*number));
    }

    pub fn positions(&mut self, positions: &[usize]) {
        self.count(positions.len());
        positions.iter().for_each(|position| self.count(*position));
    }

    pub fn text(&mut self, text: &str) {
        self.count(text.len());
        self.0.extend(text.as_bytes());
    }

    pub fn setup(&mut self, setup: Setup) {
        self.optional(setup.tolerance);
        self.number(setup.start);
        self.optional(setup.stop);
    }

    pub fn messages(&mut self, messages: &[Message]) {
        self.count(messages.len());
        for message in messages {
            self.byte(status_number(message.status));
            self.text(&message.category);
            self.text(&message.text);
            self.count(usize::try_from(message.times).unwrap_or(usize::MAX));
        }
    }

    pub fn write(&self, to: &mut impl Write) -> io::Result<()> {
        let length = u32::try_from(self.0.len()).map_err(|_| io::Error::other("a frame is too long"))?;
        to.write_all(&length.to_le_bytes())?;
        to.write_all(&self.0)?;
        to.flush()
    }

    /// Reads the next frame into `self`.
    pub fn read(&mut self, from: &mut impl Read) -> io::Result<()> {
        let mut length = [0; 4];
        from.read_exact(&mut length)?;
        let length = u32::from_le_bytes(length) as usize;
        if length > LARGEST {
            return Err(io::Error::other("a frame is too long"));
        }
        self.0.clear();
        while self.0.len() < length {
            let read = self.0.len();
            self.0.resize(length.min(read + PIECE), 0);
            from.read_exact(&mut self.0[read..])?;
        }
        Ok(())
    }

    pub fn reader(&self) -> Reader<'_> {
        Reader(&self.0)
    }
}

/// The unread rest of a frame.
#[derive(Debug)]
pub struct Reader<'a>(&'a [u8]);

/// A frame that ends too early or says what it cannot.
#[derive(Debug)]
pub struct Garbled;

impl Reader<'_> {
    fn take<const N: usize>(&mut self) -> Result<[u8; N], Garbled> {
        let (first, rest) = self.0.split_first_chunk::<N>().ok_or(Garbled)?;
        self.0 = rest;
        Ok(*first)
    }

    pub fn byte(&mut self) -> Result<u8, Garbled> {
        Ok(self.take::<1>()?[0])
    }

    pub fn count(&mut self) -> Result<usize, Garbled> {
        Ok(u32::from_le_bytes(self.take()?) as usize)
    }

    pub fn number(&mut self) -> Result<f64, Garbled> {
        Ok(f64::from_le_bytes(self.take()?))
    }

    pub fn optional(&mut self) -> Result<Option<f64>, Garbled> {
        let there = self.byte()? != 0;
        let number = self.number()?;
        Ok(there.then_some(number))
    }

    /// So many items as follow, and no more than there are bytes for.
    fn items(&mut self, size: usize) -> Result<usize, Garbled> {
        let count = self.count()?;
        if count <= self.0.len() / size { Ok(count) } else { Err(Garbled) }
    }

    pub fn numbers(&mut self, into: &mut Vec<f64>) -> Result<(), Garbled> {
        into.clear();
        for _ in 0..self.items(8)? {
            into.push(self.number()?);
        }
        Ok(())
    }

    /// Numbers into all of `values`.
    pub fn fill(&mut self, values: &mut [f64]) -> Result<(), Garbled> {
        if self.count()? != values.len() {
            return Err(Garbled);
        }
        for value in values {
            *value = self.number()?;
        }
        Ok(())
    }

    pub fn positions(&mut self, into: &mut Vec<usize>) -> Result<(), Garbled> {
        into.clear();
        for _ in 0..self.items(4)? {
            into.push(self.count()?);
        }
        Ok(())
    }

    pub fn text(&mut self) -> Result<String, Garbled> {
        let length = self.items(1)?;
        let (text, rest) = self.0.split_at(length);
        self.0 = rest;
        Ok(String::from_utf8_lossy(text).into_owned())
    }

    pub fn setup(&mut self) -> Result<Setup, Garbled> {
        Ok(Setup { tolerance: self.optional()?, start: self.number()?, stop: self.optional()? })
    }

    pub fn messages(&mut self) -> Result<Vec<Message>, Garbled> {
        let count = self.items(13)?;
        let message = |reader: &mut Self| {
            Ok(Message {
                status: Status::from_number(i32::from(reader.byte()?)),
                category: reader.text()?,
                text: reader.text()?,
                times: reader.count()? as u64,
            })
        };
        (0..count).map(|_| message(self)).collect()
    }
}

fn status_number(status: Status) -> u8 {
    match status {
        Status::Ok => 0,
        Status::Warning => 1,
        Status::Discard => 2,
        Status::Error => 3,
        Status::Fatal => 4,
        Status::Pending => 5,
        Status::Unknown(_) => 255,
    }
}

pub fn severity_number(severity: Severity) -> u8 {
    match severity {
        Severity::Call => 0,
        Severity::Slave => 1,
        Severity::Fatal => 2,
    }
}

pub fn severity(number: u8) -> Severity {
    match number {
        0 => Severity::Call,
        1 => Severity::Slave,
        _ => Severity::Fatal,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_come_back_as_they_went() {
        let mut frame = Frame::default();
        frame.numbers(&[1.0, f64::MIN_POSITIVE, -0.0]);
        frame.positions(&[3, 0, 7]);
        frame.text("µ");
        frame.optional(None);
        let mut bytes = Vec::new();
        frame.write(&mut bytes).unwrap();
        let mut other = Frame::default();
        other.read(&mut bytes.as_slice()).unwrap();
        let (mut numbers, mut positions) = (Vec::new(), Vec::new());
        let mut reader = other.reader();
        reader.numbers(&mut numbers).unwrap();
        reader.positions(&mut positions).unwrap();
        assert_eq!(
            (numbers.as_slice(), positions.as_slice()),
            (&[1.0, f64::MIN_POSITIVE, -0.0][..], &[3, 0, 7][..])
        );
        assert_eq!(reader.text().unwrap(), "µ");
        assert_eq!(reader.optional().unwrap(), None);
        assert!(reader.byte().is_err());
    }

    #[test]
    fn a_frame_that_promises_more_than_it_has_is_refused() {
        let mut frame = Frame::default();
        frame.count(u32::MAX as usize);
        assert!(frame.reader().numbers(&mut Vec::new()).is_err());
        assert!(frame.reader().text().is_err());
        assert!(frame.reader().messages().is_err());
        assert!(Frame::default().read(&mut [255_u8; 8].as_slice()).is_err());
        assert!(frame.read(&mut (LARGEST as u32).to_le_bytes().as_slice()).is_err());
        assert!(frame.0.capacity() < LARGEST / 100, "{} bytes for nothing", frame.0.capacity());
        for (number, call) in Call::ALL.iter().enumerate() {
            assert_eq!(*call as usize, number);
        }
    }

    /// Frames as the process of an FMU writes them, or as one that is out of its mind does.
    #[test]
    fn fuzz_frames_of_the_process_of_an_fmu() {
        let mut good = Frame::default();
        good.messages(&[Message {
            status: Status::Warning,
            category: "logStatusWarning".to_owned(),
            text: "a warning".to_owned(),
            times: 2,
        }]);
        good.byte(0);
        good.numbers(&[1.0, 2.0]);
        good.positions(&[1, 2]);
        let mut bytes = Vec::new();
        good.write(&mut bytes).unwrap();
        let mut frame = Frame::default();
        let (mut numbers, mut positions) = (Vec::new(), Vec::new());
        stickslip_fuzz::fuzz("frames of an FMU's process", |chance| {
            let changed = stickslip_fuzz::mutate(bytes.clone(), chance);
            if frame.read(&mut changed.as_slice()).is_err() {
                return Ok(1);
            }
            numbers.clear();
            positions.clear();
            let mut reader = frame.reader();
            // In the order of an answer, then whatever there is.
            let _ = reader.messages();
            for _ in 0..8 {
                let _ = match chance.u8(0..6) {
                    0 => reader.byte().map(drop),
                    1 => reader.numbers(&mut numbers),
                    2 => reader.positions(&mut positions),
                    3 => reader.text().map(drop),
                    4 => reader.setup().map(drop),
                    _ => reader.fill(&mut [0.0; 2]),
                };
            }
            let room = changed.len();
            if numbers.len() * 8 > room || positions.len() * 4 > room {
                return Err(format!("more than the {room} bytes hold"));
            }
            Ok(1)
        });
    }
}
