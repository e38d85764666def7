//! What is unlike the usual experiment.

/// What is unlike the usual experiment; all else of it is as usual.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Setting {
    /// Nothing.
    Usual,
    /// One more of the usual ones, so that false alarms are counted on enough.
    Further,
    /// Four times as many records, with numbers of their own.
    Records32,
    /// Sixteen times as many.
    Records128,
    /// The dataset does not tell the noise.
    NoiseUntold,
    /// Sensors are late by more than twenty samples of the fastest records.
    LongDelay,
    /// A mass in the given model is wrong by 5 %.
    MassOff,
    /// The physics is four times as fast, and the samples are as far apart as usual.
    Coarse,
    /// The first paper's beam, its acceleration held at one level in each record.
    HeldLevels,
}

impl Setting {
    /// What a case's name ends with, and what a table says. The usual is not told: most names are older than the word.
    pub fn word(self) -> &'static str {
        match self {
            Setting::Usual => "",
            Setting::Further => "further",
            Setting::Records32 => "32-records",
            Setting::Records128 => "128-records",
            Setting::NoiseUntold => "noise-untold",
            Setting::LongDelay => "long-delay",
            Setting::MassOff => "mass-off",
            Setting::Coarse => "coarse",
            Setting::HeldLevels => "held-levels",
        }
    }

    /// How often the plan of eight records is gone through.
    pub fn rounds(self) -> usize {
        match self {
            Setting::Records32 => 4,
            Setting::Records128 => 16,
            _ => 1,
        }
    }
}
