//! Contacts that depend on a parameter, and responses at a constant frequency over it.

use super::start::at_level;
use super::tracker::{Solution, describe, more_harmonics};
use crate::contact::{ContactLaw, LawError};
use crate::harmonic::balance::assembly::{Assembly, Body, CurveSettings};
use crate::harmonic::balance::beam::Balance;
use crate::harmonic::balance::condensed::Condensed;
use crate::harmonic::balance::variation::Rebuild;
use crate::harmonic::continuation::Ending;
use crate::harmonic::continuation::{Advance, Path, Route, Verdict};
use crate::harmonic::newton::Point;
use crate::harmonic::newton::system::{Operating, PeriodicSystem, Scalar};
use crate::harmonic::{HarmonicError, LoadedContact};

/// A contact law that belongs to its holder, under its constant normal load.
#[derive(Debug)]
pub struct OwnedContact {
    /// The law.
    pub law: Box<dyn ContactLaw>,
    /// Normal load (N).
    pub normal_load: f64,
}

impl OwnedContact {
    /// A law under `normal_load` (N).
    pub fn new(law: impl ContactLaw + 'static, normal_load: f64) -> Self {
        Self { law: Box::new(law), normal_load }
    }
}

/// A contact, by its number, at a value of a parameter: of friction, normal load, stiffness, or whatever it
/// depends on.
pub type ContactAt<'a> = dyn Fn(usize, f64) -> Result<OwnedContact, LawError> + 'a;

/// The response at one value of a parameter.
#[derive(Debug, Clone, PartialEq)]
pub struct Varied {
    /// Value of the parameter.
    pub value: f64,
    /// The response.
    pub point: Point,
}

/// Responses over a parameter, in the order they were followed.
#[derive(Debug, Clone, PartialEq)]
pub struct VariedCurve {
    /// The responses; around turning points the parameter runs back and forth.
    pub points: Vec<Varied>,
    /// How it ended.
    pub ending: Ending,
}

/// Responses at `angular_frequency` (rad/s) and `level` where a parameter of the contacts runs through `range`,
/// followed by arc length: turning points are passed. The contacts of `assembly` are replaced by those
/// that `contact` makes; they must change smoothly with the parameter, within the range and a hundred-thousandth
/// beyond.
///
/// A curve that cannot be followed to its end is returned as far as it came, with [`Ending`] saying so.
///
/// ```
/// use stickslip::contact::Jenkins;
/// use stickslip::harmonic::{
///     Assembly, LoadedContact, Body, CurveSettings, Ending, OwnedContact, parameter_response,
/// };
/// use stickslip::model::{Anchor, Mass, Oscillator, Spring};
/// let structure = Oscillator {
///     masses: vec![Mass { name: "m1".into(), mass: 1.0 }],
///     springs: vec![Spring { between: [Anchor::Ground, Anchor::Mass(0)], stiffness: 1.0, damping: 0.1 }],
///     contact: Some(0),
///     excitation: 0,
/// }
/// .structure()?;
/// let law = Jenkins::new(0.44, 0.1)?;
/// let contacts = vec![LoadedContact { law: &law, normal_load: 1.0 }];
/// let assembly = Assembly::new(Body::Linear(&structure), contacts);
/// let contact = |_, friction: f64| Ok(OwnedContact::new(Jenkins::new(0.44, friction)?, 1.0));
/// let settings = CurveSettings::default();
/// let curve = parameter_response(&assembly, &contact, 1.0, 0.5, [0.01, 0.2], &settings)?;
/// assert_eq!(curve.ending, Ending::Complete);
/// let lost: Vec<f64> = curve.points.iter().map(|varied| varied.point.dissipated_energy()).collect();
/// // As long as the contact slips freely, more friction takes more energy.
/// assert!(lost.last() > lost.first());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`HarmonicError::InvalidInput`] for arguments that do not fit, [`HarmonicError::Law`] where `contact` fails
/// at the start; the other kinds when there is no first response.
pub fn parameter_response(
    assembly: &Assembly,
    contact: &ContactAt,
    angular_frequency: f64,
    level: f64,
    range: [f64; 2],
    settings: &CurveSettings,
) -> Result<VariedCurve, HarmonicError> {
    let [from, to] = range;
    let positive = angular_frequency > 0.0 && angular_frequency.is_finite();
    if !(positive && level.is_finite() && from.is_finite() && to.is_finite() && from != to) {
        return Err(HarmonicError::InvalidInput(
            "the angular frequency must be positive, level and parameter finite, the range not empty",
        ));
    }
    let owned = made(assembly, contact, from)?;
    let attached = attached(assembly, &owned);
    // Across zero the parameter's own size is no measure of what a small change of it is.
    let least = if from * to > 0.0 { 0.0 } else { 1e-3 * from.abs().max(to.abs()) };
    let mut system = varied_balance(&attached, contact, least, settings)?;
    let at = Operating { parameter: from, ..Operating::forced(angular_frequency, level) };
    let (x, at) = at_level(&mut *system, at, settings)?;
    let route = Route {
        along: Scalar::Parameter,
        from,
        to,
        stopping: settings.stopping(),
        max_step: settings.max_step,
    };
    let mut path = Path::new(&mut *system, route, &[], Vec::new(), x, at)?;
    let mut curve = VariedCurve { points: Vec::new(), ending: Ending::Stuck };
    let mut point = path.judged(settings)?;
    while let Some(harmonics) = more_harmonics(&point, settings) {
        path.restart(harmonics)?;
        point = path.judged(settings)?;
    }
    curve.points.push(Varied { value: from, point });
    while curve.points.len() < settings.max_points {
        let mut found = None;
        let advance = path.advance(&mut |system, _, location, _| {
            let solution = Solution { x: location.x.clone(), at: location.at };
            let mut point = describe(system, &solution, settings)?;
            if let Some(harmonics) = more_harmonics(&point, settings) {
                return Ok(Verdict::Harmonics(harmonics));
            }
            point.iterations = location.iterations;
            found = Some(Varied { value: location.at.parameter, point });
            Ok(Verdict::Keep(0.0))
        })?;
        if advance == Advance::Stuck {
            break;
        }
        curve.points.extend(found);
        if let Advance::Arrived(ending) = advance {
            curve.ending = ending;
            break;
        }
    }
    Ok(curve)
}

impl Path<'_> {
    /// The response at the point the path starts from.
    fn judged(&mut self, settings: &CurveSettings) -> Result<Point, HarmonicError> {
        let solution = Solution { x: self.present.x.clone(), at: self.present.at };
        describe(self.system, &solution, settings)
    }
}

/// The contacts at a value of the parameter.
pub(super) fn made(
    assembly: &Assembly,
    contact: &ContactAt,
    value: f64,
) -> Result<Vec<OwnedContact>, LawError> {
    (0..assembly.contacts.len()).map(|number| contact(number, value)).collect()
}

/// The assembly with other contacts.
pub(super) fn attached<'a>(assembly: &Assembly<'a>, contacts: &'a [OwnedContact]) -> Assembly<'a> {
    let attach =
        |contact: &'a OwnedContact| LoadedContact { law: &*contact.law, normal_load: contact.normal_load };
    Assembly { contacts: contacts.iter().map(attach).collect(), ..assembly.clone() }
}

/// The balance of an assembly whose contacts depend on the parameter; differences take it for no smaller than
/// `least`.
pub(super) fn varied_balance<'a>(
    assembly: &Assembly<'a>,
    contact: &'a ContactAt,
    least: f64,
    settings: &CurveSettings,
) -> Result<Box<dyn PeriodicSystem + 'a>, HarmonicError> {
    assembly.check()?;
    assembly.check_excitation(settings)?;
    let rebuild = |number: usize| -> Rebuild<'a> {
        Box::new(move |value| {
            let OwnedContact { law, normal_load } = contact(number, value)?;
            Ok((law, normal_load))
        })
    };
    match assembly.body {
        Body::Linear(_) => {
            let mut system = Condensed::new(assembly, settings)?;
            (0..assembly.contacts.len()).for_each(|number| system.vary(number, least, rebuild(number)));
            Ok(Box::new(system))
        }
        Body::Beam(beam) => {
            let contact = assembly.contacts.first().copied();
            let mut system =
                Balance::new(beam, contact, &assembly.waveform, settings.harmonics, settings.method)?;
            if contact.is_some() {
                system.vary(least, rebuild(0));
            }
            Ok(Box::new(system))
        }
    }
}
