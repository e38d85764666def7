//! Responses at a constant frequency over a parameter.

use super::start::at_level;
use super::tracker::{Solution, describe, more_harmonics};
use crate::harmonic::balance::varied::{self, AssemblyAt};
use crate::harmonic::continuation::Ending;
use crate::harmonic::continuation::{Advance, Path, Route, Verdict};
use crate::harmonic::newton::Point;
use crate::harmonic::newton::system::{Operating, Scalar};
use crate::harmonic::{CurveSettings, HarmonicError};

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

/// Responses at `angular_frequency` (rad/s) and `level` where a parameter runs through `range`, followed by arc length:
/// turning points are passed. `at` makes the system at a value; it must change smoothly with the parameter, within the
/// range and a hundred-thousandth beyond, and keep its ports.
///
/// `on_point` sees every response, and ends the curve there by `false`.
/// A curve that cannot be followed to its end is returned as far as it came, with [`Ending`] saying so.
///
/// ```
/// use stickslip::harmonic::{CurveSettings, Ending, parameter_response};
/// use stickslip::model::Model;
/// let model = Model::parse(
///     r#"
///     schema = "stickslip.model/1"
///     kind = "oscillator"
///     mass = [{ name = "m1", mass = 1.0 }]
///     spring = [{ between = ["ground", "m1"], stiffness = 1.0, damping = 0.1 }]
///     contact = { at = "m1", law = "jenkins", tangential_stiffness = 0.44, friction_coefficient = 0.1, normal_load = 1.0 }
///     "#,
/// )?;
/// let over_friction = model.assembly_over("contact.friction_coefficient")?;
/// let curve = parameter_response(&over_friction, 1.0, 0.5, [0.01, 0.2], &CurveSettings::default(), &mut |_| true)?;
/// assert_eq!(curve.ending, Ending::Complete);
/// let lost: Vec<f64> = curve.points.iter().map(|varied| varied.point.dissipated_energy()).collect();
/// // As long as the contact slips freely, more friction takes more energy.
/// assert!(lost.last() > lost.first());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`HarmonicError::InvalidInput`] for arguments that do not fit, what `at` fails with at the start; the other kinds when
/// there is no first response.
pub fn parameter_response(
    at: &AssemblyAt,
    angular_frequency: f64,
    level: f64,
    range: [f64; 2],
    settings: &CurveSettings,
    on_point: &mut dyn FnMut(&Varied) -> bool,
) -> Result<VariedCurve, HarmonicError> {
    let [from, to] = range;
    let positive = angular_frequency > 0.0 && angular_frequency.is_finite();
    if !(positive && level.is_finite() && from.is_finite() && to.is_finite() && from != to) {
        return Err(HarmonicError::InvalidInput(
            "the angular frequency must be positive, level and parameter finite, the range not empty",
        ));
    }
    // Across zero the parameter's own size is no measure of what a small change of it is.
    let least = if from * to > 0.0 { 0.0 } else { 1e-3 * from.abs().max(to.abs()) };
    let mut system = varied::Varied::new(at, from, least, settings)?;
    let at = Operating { parameter: from, ..Operating::forced(angular_frequency, level) };
    let (x, at) = at_level(&mut system, at, settings)?;
    let route = Route {
        along: Scalar::Parameter,
        from,
        to,
        stopping: settings.stopping(),
        max_step: settings.max_step,
    };
    let mut path = Path::new(&mut system, route, &[], Vec::new(), x, at)?;
    let mut curve = VariedCurve { points: Vec::new(), ending: Ending::Stuck };
    let mut point = path.judged(settings)?;
    while let Some(harmonics) = more_harmonics(&point, settings) {
        path.restart(harmonics)?;
        point = path.judged(settings)?;
    }
    curve.points.push(Varied { value: from, point });
    if !on_point(&curve.points[0]) {
        return Ok(VariedCurve { ending: Ending::Interrupted, ..curve });
    }
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
        let goes_on = found.as_ref().is_none_or(&mut *on_point);
        curve.points.extend(found);
        if !goes_on {
            curve.ending = Ending::Interrupted;
            break;
        }
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
