//! First-harmonic frequency responses: of a comparison's records come responses over what drives them, measured and
//! predicted, in magnitude and phase, and the damping of each of their peaks.
//!
//! `curves` takes them from stepped-sine tables, steady records and records of a slow sine sweep (`swept`), `peaks` finds
//! resonances and their damping, `section` makes plots and tables of them.

mod curves;
mod peaks;
mod section;
mod swept;

pub use section::section;

/// The first harmonic of a channel over that of what drives it.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Response {
    /// Ratio of the amplitudes, in SI.
    size: f64,
    /// How far the channel is ahead (rad); `None` where only the amplitude is known.
    phase: Option<f64>,
}

/// A response at a frequency.
#[derive(Debug, Clone, PartialEq)]
struct Point {
    /// Frequency (Hz).
    frequency: f64,
    /// Amplitude of what drives, in its SI unit.
    level: f64,
    measured: Response,
    /// By stage; `None` where a stage has no prediction.
    predicted: Vec<Option<Response>>,
}

/// Where the points of a curve come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Source {
    /// Rows of a stepped-sine table.
    Table,
    /// Stretches of a record in which the frequency changes slowly.
    Sweep,
    /// Steady records, a point each.
    Steady,
}

/// Points of one channel.
#[derive(Debug, Clone, PartialEq)]
struct Curve {
    /// Name of the channel, and of what drives it with its unit.
    channel: String,
    drive: (String, &'static str),
    /// Unit of the response.
    unit: &'static str,
    /// How often the displacement is differentiated in the channel; `None` where a structure's motion is not what it shows.
    order: Option<i32>,
    /// Name of the record; empty of several.
    record: String,
    source: Source,
    points: Vec<Point>,
}
