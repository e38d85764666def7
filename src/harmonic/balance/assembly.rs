//! A structure with its contacts and its excitation, and how its periodic responses are to be computed.

use crate::contact::LoadedContact;
use crate::harmonic::{HarmonicError, Method};
use crate::system::{LinearStructure, ModalBeam};

/// What the contacts are attached to.
#[derive(Debug, Clone, Copy)]
pub enum Body<'a> {
    /// A linear structure, condensed to its contacts.
    Linear(&'a LinearStructure),
    /// A modal beam whose end moves inwards as it bends; one contact at most.
    Beam(&'a ModalBeam),
}

/// A structure with contacts under a periodic excitation.
#[derive(Debug, Clone)]
pub struct Assembly<'a> {
    /// The structure.
    pub body: Body<'a>,
    /// One per contact of a linear structure, in its order.
    pub contacts: Vec<LoadedContact<'a>>,
    /// Coefficients `[a0, c1, s1, …]` of the excitation at level 1: `[0, 1, 0]` is cos Ωt.
    pub waveform: Vec<f64>,
}

impl<'a> Assembly<'a> {
    /// Under the excitation cos Ωt.
    pub fn new(body: Body<'a>, contacts: Vec<LoadedContact<'a>>) -> Self {
        Self { body, contacts, waveform: vec![0.0, 1.0, 0.0] }
    }

    /// Whether responses of odd harmonics alone are a closed family: every law odd, the excitation without
    /// bias and even harmonics.
    pub(crate) fn is_odd(&self) -> bool {
        let even = |k: &usize| k.div_ceil(2).is_multiple_of(2);
        matches!(self.body, Body::Linear(_))
            && self.contacts.iter().all(|contact| contact.law.is_odd())
            && (0..self.waveform.len()).filter(even).all(|k| self.waveform[k] == 0.0)
    }

    /// Refuses an excitation that a response with the harmonics of `settings` could not follow: what is left out
    /// of it would be missing from the response and from the estimate of its error.
    pub(crate) fn check_excitation(&self, settings: &CurveSettings) -> Result<(), HarmonicError> {
        let highest = self.waveform.iter().rposition(|f| *f != 0.0).map_or(0, |place| place.div_ceil(2));
        if highest > settings.harmonics {
            return Err(HarmonicError::InvalidInput(
                "the excitation has more harmonics than the response may have",
            ));
        }
        Ok(())
    }

    pub(crate) fn check(&self) -> Result<(), HarmonicError> {
        if self.waveform.iter().any(|f| !f.is_finite()) {
            return Err(HarmonicError::InvalidInput("the excitation is not finite"));
        }
        if self.contacts.iter().any(|contact| !contact.normal_load.is_finite()) {
            return Err(HarmonicError::InvalidInput("a normal load is not finite"));
        }
        match self.body {
            Body::Linear(structure) if structure.contacts.len() != self.contacts.len() => {
                Err(HarmonicError::InvalidInput("not one law per contact of the structure"))
            }
            Body::Beam(_) if self.contacts.len() > 1 => {
                Err(HarmonicError::InvalidInput("a beam has one contact at most"))
            }
            _ => Ok(()),
        }
    }
}

/// Largest estimated truncation error of a point that counts as resolved where [`CurveSettings::truncation`]
/// asks for none: 1 % of the amplitude.
pub const UNRESOLVED: f64 = 0.01;

/// Discretisation, stopping rule and step control of response curves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CurveSettings {
    /// Highest harmonic of the displacements, to start with where they adapt.
    pub harmonics: usize,
    /// Truncation error of the displacements accepted (share of the amplitude). With it the harmonics adapt
    /// between [`CurveSettings::harmonics`] and [`CurveSettings::max_harmonics`]; without it they stay.
    pub truncation: Option<f64>,
    /// Most harmonics an adapted point may have.
    pub max_harmonics: usize,
    /// How contacts are carried over a period.
    pub method: Method,
    /// Largest residual accepted, as share of the largest displacement.
    pub tolerance: f64,
    /// Newton steps before a start is given up.
    pub max_iterations: usize,
    /// Whether the stability of every point is determined.
    pub stability: bool,
    /// Even harmonics and bias too where symmetry allows odd harmonics alone. By default the set is odd where
    /// all laws are odd and so is the excitation; such a set cannot see responses that break the symmetry
    /// (even harmonics born in a pitchfork bifurcation, as of the Duffing oscillator), only that
    /// the symmetric response has become unstable.
    pub all_harmonics: bool,
    /// Longest step, as share of the range.
    pub max_step: f64,
    /// Points before a curve is given up.
    pub max_points: usize,
}

impl Default for CurveSettings {
    fn default() -> Self {
        Self {
            harmonics: 21,
            truncation: None,
            max_harmonics: 101,
            method: Method::Exact,
            tolerance: 1e-10,
            max_iterations: 40,
            stability: false,
            all_harmonics: false,
            max_step: 0.02,
            max_points: 20_000,
        }
    }
}

impl CurveSettings {
    pub(crate) fn check(&self) -> Result<(), HarmonicError> {
        let positive = |x: f64| x > 0.0 && x.is_finite();
        if self.harmonics == 0 || self.max_iterations == 0 || self.max_points == 0 {
            return Err(HarmonicError::InvalidInput("harmonics, iterations and points must be at least 1"));
        }
        if !positive(self.tolerance) || !positive(self.max_step) {
            return Err(HarmonicError::InvalidInput("the tolerance and the longest step must be positive"));
        }
        if let Some(truncation) = self.truncation
            && (!positive(truncation) || self.max_harmonics < self.harmonics)
        {
            return Err(HarmonicError::InvalidInput(
                "the truncation error must be positive, and the most harmonics no fewer than the first",
            ));
        }
        if let Method::Sampled { samples } = self.method
            && samples < 8 * self.harmonics
        {
            return Err(HarmonicError::InvalidInput("fewer than 8 samples per harmonic"));
        }
        Ok(())
    }
}

/// What holds the response at a point of a curve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Control {
    /// The excitation's level.
    Level(f64),
    /// Amplitude of a harmonic of a node, as a controlled shaker holds it; the level follows.
    Held {
        /// Which node.
        node: usize,
        /// Which harmonic, at least 1.
        order: usize,
        /// Of its displacement (0), velocity (1) or acceleration (2).
        derivative: usize,
        /// Amplitude (m, m/s or m/s²).
        amplitude: f64,
    },
}
