//! What is tested.

use std::f64::consts::TAU;

use super::chain::Chain;
use super::dual_mode::DualMode;
use super::error::RigError;
use crate::data::{Regime, Use};
use crate::model::{Model, PointMass, Structure};

/// Tests on a rig.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    /// Accelerometers on the beam.
    pub sensors: Vec<Accelerometer>,
    /// What lies between the motion and the record.
    pub chain: Chain,
    /// The tests, in order.
    pub tests: Vec<Test>,
}

/// An accelerometer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Accelerometer {
    /// Distance from the clamp (m).
    pub position: f64,
    /// Mass that the model's beam does not have and the rig's has (kg).
    pub mass: f64,
}

/// One test, of one or several records.
#[derive(Debug, Clone, PartialEq)]
pub struct Test {
    /// What the files of its records are called.
    pub name: String,
    /// What its records may be used for.
    pub use_for: Option<Use>,
    /// The test.
    pub kind: TestKind,
}

/// Kinds of tests.
#[derive(Debug, Clone, PartialEq)]
pub enum TestKind {
    /// Steady states under a sine.
    SteppedSine(SteppedSine),
    /// Steady states under two tones.
    DualMode(DualMode),
    /// A random force.
    Random(RandomTest),
    /// Free decay.
    RingDown(RingDown),
}

/// Steady states under a sinusoidal force that holds the first harmonic of the acceleration where it acts.
#[derive(Debug, Clone, PartialEq)]
pub struct SteppedSine {
    /// Acceleration amplitudes held (m/s²).
    pub amplitudes: Vec<f64>,
    /// Frequencies at every amplitude.
    pub frequencies: Frequencies,
    /// Harmonics of the beam's motion; as many as its modes need where `None`.
    pub harmonics: Option<usize>,
    /// Periods recorded.
    pub periods: usize,
    /// Samples of a period.
    pub samples_per_period: usize,
}

/// Frequencies of stepped sines.
#[derive(Debug, Clone, PartialEq)]
pub enum Frequencies {
    /// The phase resonance of the first mode at each amplitude.
    Resonance,
    /// So many, evenly spaced over a band (Hz) about that resonance.
    AroundResonance {
        /// Width of the band (Hz).
        band: f64,
        /// How many.
        count: usize,
    },
    /// These (Hz).
    List(Vec<f64>),
}

/// A random force of a flat spectrum in a band, Gaussian, that repeats after its duration.
#[derive(Debug, Clone, PartialEq)]
pub struct RandomTest {
    /// Root mean square of the force (N).
    pub force: f64,
    /// Lowest and highest frequency (Hz).
    pub band: [f64; 2],
    /// Duration of the record (s).
    pub duration: f64,
    /// Samples per second (Hz).
    pub sampling: f64,
    /// Time under the force before the record begins (s). At 0 the record begins at rest, else in an unknown state.
    pub lead: f64,
    /// Seed of the force.
    pub seed: u64,
}

/// Free decay with the shaker disconnected.
#[derive(Debug, Clone, PartialEq)]
pub struct RingDown {
    /// What it is released from, a record each.
    pub from: Vec<Release>,
    /// Duration of the record (s).
    pub duration: f64,
    /// Samples per second (Hz).
    pub sampling: f64,
}

/// What a beam is released from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Release {
    /// The phase resonance of the first mode at this acceleration amplitude (m/s²), when the force passes zero.
    Held(f64),
    /// A constant force (N) at the shaker.
    Force(f64),
}

impl SteppedSine {
    /// Amplitudes (m/s²) held at resonance, 8 periods of 256 samples.
    pub fn at(amplitudes: Vec<f64>) -> Self {
        Self {
            amplitudes,
            frequencies: Frequencies::Resonance,
            harmonics: None,
            periods: 8,
            samples_per_period: 256,
        }
    }
}

impl Frequencies {
    /// How many there are at each amplitude.
    pub(super) fn count(&self) -> usize {
        match self {
            Self::Resonance => 1,
            Self::AroundResonance { count, .. } => *count,
            Self::List(list) => list.len(),
        }
    }

    /// The one at `index` (Hz), from the resonance (Hz) if it takes that.
    pub(super) fn at(&self, index: usize, resonance: f64) -> f64 {
        match self {
            Self::Resonance => resonance,
            Self::AroundResonance { band, count } => {
                let fraction = if *count > 1 { index as f64 / (count - 1) as f64 } else { 0.5 };
                resonance + band * (fraction - 0.5)
            }
            Self::List(list) => list[index],
        }
    }
}

/// Samples that a record may have at most, and values of a random force: more fill the memory, and a transform of so many
/// takes a second.
const MOST_SAMPLES: f64 = 5e6;
const MOST_VALUES: f64 = 1e7;

/// Most harmonics of a motion: far beyond what any contact excites, and its equations still fit in memory.
const MOST_HARMONICS: usize = 200;

/// Radians of the highest frequency over which a parabola follows a random force: within 2e-4 of it.
const SMOOTH: f64 = 0.3;

impl Plan {
    /// No test yet, perfect accelerometers at `positions` (m).
    pub fn of_sensors(positions: &[f64]) -> Self {
        let sensors = positions.iter().map(|position| Accelerometer { position: *position, mass: 0.0 });
        Self { sensors: sensors.collect(), chain: Chain::default(), tests: Vec::new() }
    }

    /// The beam of `model`, or of a pin rig, with the masses of the accelerometers on it.
    ///
    /// # Errors
    /// A model without a beam.
    pub fn beam_under_test(&self, model: &Model) -> Result<Model, RigError> {
        let mut tested = model.clone();
        let beam = tested.structure.beam_mut().ok_or_else(no_beam)?;
        // Without a list of its own the beam's sensors are its point masses, old and new.
        for &Accelerometer { position, mass } in &self.sensors {
            beam.add_mass(PointMass { position, mass });
        }
        Ok(tested)
    }

    /// Names of the records of every test: the test's own, numbered where there are several.
    pub fn record_names(&self) -> Vec<Vec<String>> {
        let names = |test: &Test| match test.kind.records() {
            1 => vec![format!("{}.csv", test.name)],
            count => {
                let width = count.to_string().len();
                (1..=count).map(|number| format!("{}-{number:0width$}.csv", test.name)).collect()
            }
        };
        self.tests.iter().map(names).collect()
    }

    /// Refuses numbers that make no test.
    pub(super) fn check(&self) -> Result<(), RigError> {
        let refuse = |message: &str| Err(RigError::Input(message.to_owned()));
        if self.sensors.is_empty() {
            return refuse("the rig has no accelerometer");
        }
        let mut names: Vec<String> = self.record_names().concat();
        names.sort();
        if let Some(twice) = names.windows(2).find(|pair| pair[0] == pair[1]) {
            return refuse(&format!("two records would be called {}: give the tests other names", twice[0]));
        }
        self.chain.check(self.sensors.len())?;
        for test in &self.tests {
            test.check()?;
        }
        Ok(())
    }
}

impl Test {
    /// Refuses numbers that make no test.
    ///
    /// # Errors
    /// [`RigError::Input`].
    pub fn check(&self) -> Result<(), RigError> {
        self.kind.check().map_err(|message| RigError::Input(format!("{}: {message}", self.name)))
    }
}

impl RandomTest {
    /// Values of the force from one sample to the next; even, so that the middle of a parabola is one.
    pub(super) fn values_per_sample(&self) -> f64 {
        2.0 * (TAU * self.band[1] / self.sampling / SMOOTH).ceil()
    }
}

/// Why a model is not tested.
pub(super) fn no_beam() -> RigError {
    RigError::Input("a rig tests a model of kind \"beam\" or \"pin_rig\"".into())
}

impl TestKind {
    /// Refuses a test that cannot be made on `model`.
    ///
    /// # Errors
    /// [`RigError::Input`].
    pub fn check_on(&self, model: &Model) -> Result<(), RigError> {
        match (self, &model.structure) {
            (Self::DualMode(_), _) | (_, Structure::Beam(_)) => Ok(()),
            (_, Structure::PinRig(_)) => {
                Err(RigError::Input("a pin rig is tested in dual mode alone: [[dual_mode]]".into()))
            }
            _ => Err(no_beam()),
        }
    }

    /// What is known of the motion before a record.
    pub(super) fn regime(&self) -> Regime {
        match self {
            Self::SteppedSine(_) | Self::DualMode(_) => Regime::Steady,
            Self::Random(test) if test.lead == 0.0 => Regime::FromRest,
            Self::Random(_) | Self::RingDown(_) => Regime::UnknownInitialState,
        }
    }

    /// Steady records one per amplitude and frequency, free decays one per release; one under a random force.
    fn records(&self) -> usize {
        match self {
            Self::SteppedSine(test) => test.amplitudes.len() * test.frequencies.count(),
            Self::DualMode(test) => test.amplitudes.len(),
            Self::RingDown(test) => test.from.len(),
            Self::Random(_) => 1,
        }
    }

    /// Harmonics of the motion, where they are balanced.
    fn harmonics(&self) -> Option<usize> {
        match self {
            Self::SteppedSine(test) => test.harmonics,
            Self::DualMode(test) => Some(test.harmonics),
            Self::Random(_) | Self::RingDown(_) => None,
        }
    }

    fn check(&self) -> Result<(), &'static str> {
        let positive = |value: f64| value > 0.0 && value.is_finite();
        if self.harmonics().is_some_and(|count| count > MOST_HARMONICS) {
            return Err("it has more than 200 harmonics, far beyond what a contact excites");
        }
        let legal = match self {
            Self::SteppedSine(test) => {
                let listed = match &test.frequencies {
                    Frequencies::Resonance => true,
                    Frequencies::AroundResonance { band, .. } => positive(*band),
                    Frequencies::List(list) => list.iter().all(|frequency| positive(*frequency)),
                };
                let samples = test.periods as f64 * test.samples_per_period as f64;
                listed
                    && self.records() > 0
                    && test.amplitudes.iter().all(|amplitude| positive(*amplitude))
                    && test.harmonics != Some(0)
                    && (1.0..MOST_SAMPLES).contains(&samples)
            }
            Self::DualMode(test) => {
                let samples = test.periods as f64 * test.samples_per_period as f64;
                self.records() > 0
                    && test.amplitudes.iter().flatten().all(|amplitude| positive(*amplitude))
                    && positive(test.frequency)
                    // Both tones are among them.
                    && test.harmonics >= 3
                    && (2.0..MOST_SAMPLES).contains(&samples)
            }
            Self::Random(test) => {
                let [low, high] = test.band;
                if high > 0.5 * test.sampling {
                    return Err("the band goes beyond half the sampling frequency");
                }
                if (low * test.duration).ceil() > (high * test.duration).floor() {
                    return Err("the band is narrower than one over the duration");
                }
                if test.duration * test.sampling * test.values_per_sample() > MOST_VALUES {
                    return Err(
                        "the record is too long: shorten its duration, or lower the sampling or the band",
                    );
                }
                positive(test.force)
                    && positive(low)
                    && (0.0..1e6).contains(&test.lead)
                    && (2.0..MOST_SAMPLES).contains(&(test.duration * test.sampling))
            }
            Self::RingDown(test) => {
                let size = |(Release::Held(size) | Release::Force(size)): &Release| *size;
                self.records() > 0
                    && test.from.iter().all(|from| positive(size(from)))
                    && positive(test.sampling)
                    && (2.0..MOST_SAMPLES).contains(&(test.duration * test.sampling))
            }
        };
        if legal { Ok(()) } else { Err("its numbers must be positive, and a record have 2 to 5e6 samples") }
    }
}
