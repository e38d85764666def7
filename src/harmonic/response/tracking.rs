//! Resonances followed over the excitation's level or over a parameter of the contacts.

use super::start::at_level;
use super::stepwise::{LastSolutions, StepwiseContinuation};
use super::tracker::{Solution, Sought, Tracker, describe};
use crate::harmonic::balance::assembly::Assembly;
use crate::harmonic::balance::balance_of;
use crate::harmonic::balance::varied::{AssemblyAt, Varied};
use crate::harmonic::newton::Point;
use crate::harmonic::newton::system::{Operating, PeriodicSystem};
use crate::harmonic::{CurveSettings, HarmonicError};

/// What is followed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TrackedQuantity {
    /// The frequency at which the node's amplitude, its largest displacement over a period, is largest.
    Peak,
    /// The frequency at which the first harmonic of the node's displacement is a quarter period behind that
    /// of the excitation, or ahead of it (as it may be away from the excitation).
    Phase,
    /// A constant frequency.
    Frequency,
}

/// What is followed, of which node, and from where.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tracking {
    /// What is followed.
    pub followed: TrackedQuantity,
    /// Which node of the structure.
    pub node: usize,
    /// Ω (rad/s) near which it is at the first value: the peak is the next one uphill from there.
    pub angular_frequency: f64,
}

/// The response followed at one value of what is varied.
#[derive(Debug, Clone, PartialEq)]
pub struct Tracked {
    /// The value: a level, or of the parameter.
    pub value: f64,
    /// Amplitude of the node: its largest displacement over a period (m).
    pub amplitude: f64,
    /// Amplitude over level; for an excitation of unit amplitude the receptance (m/N).
    pub receptance: f64,
    /// The response with frequency, level and energies.
    pub point: Point,
}

/// A response followed over values of a level or a parameter.
#[derive(Debug, Clone, PartialEq)]
pub struct TrackedCurve {
    /// The responses at the values in their order, as far as they were reached.
    pub points: Vec<Tracked>,
    /// Why the rest is missing, if it is: no response was found, however small the step from the last one. A
    /// resonance may end there (the phase of a node may cease to pass a quarter period, and a peak may
    /// merge with its neighbour).
    pub lost: Option<HarmonicError>,
}

/// Follows a response over the excitation's levels, in the order given.
///
/// ```
/// use stickslip::harmonic::{Assembly, CurveSettings, TrackedQuantity, Tracking, track_levels};
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
/// let assembly = Assembly::new(model.system()?);
/// let tracking = Tracking { followed: TrackedQuantity::Peak, node: 0, angular_frequency: 1.1 };
/// let levels = [0.001, 1.0, 100.0];
/// let peaks = track_levels(&assembly, &tracking, &levels, &CurveSettings::default())?.points;
/// // From stuck, √1.44, to free.
/// assert!((peaks[0].point.angular_frequency - 1.2).abs() < 0.01);
/// assert!((peaks[2].point.angular_frequency - 1.0).abs() < 0.01);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`HarmonicError::InvalidInput`] for arguments that do not fit; the other kinds where there is no response
/// at the first value.
pub fn track_levels(
    assembly: &Assembly,
    tracking: &Tracking,
    levels: &[f64],
    settings: &CurveSettings,
) -> Result<TrackedCurve, HarmonicError> {
    if levels.iter().any(|level| !(level.is_finite() && *level != 0.0)) {
        return Err(HarmonicError::InvalidInput("a level is zero or not finite"));
    }
    let mut system = balance_of(assembly, settings)?;
    let set = |at: &mut Operating, value| at.level = value;
    Follower::new(assembly, tracking, settings, &mut *system, &set)?.over(levels)
}

/// Follows a response at a constant `level` over `values` of a parameter, in the order given. `at` makes the system at a
/// value.
///
/// ```
/// use stickslip::harmonic::{Assembly, CurveSettings, TrackedQuantity, Tracking, track_parameter};
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
/// let tracking = Tracking { followed: TrackedQuantity::Phase, node: 0, angular_frequency: 1.1 };
/// let settings = CurveSettings::default();
/// let resonances = track_parameter(&over_friction, 0.5, &tracking, &[0.1, 0.2, 0.3], &settings)?.points;
/// assert!(resonances[2].point.angular_frequency > resonances[0].point.angular_frequency);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// Those of [`track_levels`], and those of `at` at any value.
pub fn track_parameter(
    at: &AssemblyAt,
    level: f64,
    tracking: &Tracking,
    values: &[f64],
    settings: &CurveSettings,
) -> Result<TrackedCurve, HarmonicError> {
    if !(level.is_finite() && level != 0.0) {
        return Err(HarmonicError::InvalidInput("the level is zero or not finite"));
    }
    if values.iter().any(|value| !value.is_finite()) {
        return Err(HarmonicError::InvalidInput("a value of the parameter is not finite"));
    }
    let Some(first) = values.first() else { return Ok(TrackedCurve { points: Vec::new(), lost: None }) };
    let mut system = Varied::new(at, *first, 0.0, settings)?;
    let assembly = system.assembly().clone();
    let set = |at: &mut Operating, value| (at.level, at.parameter) = (level, value);
    Follower::new(&assembly, tracking, settings, &mut system, &set)?.over(values)
}

/// The response carried from value to value.
struct Follower<'s, 'v> {
    system: &'s mut (dyn PeriodicSystem + 's),
    settings: CurveSettings,
    tracker: Tracker,
    sought: Sought,
    node: usize,
    angular_frequency: f64,
    /// Makes a value known to the balance.
    set: &'v dyn Fn(&mut Operating, f64),
}

impl<'s, 'v> Follower<'s, 'v> {
    fn new(
        assembly: &Assembly,
        tracking: &Tracking,
        settings: &CurveSettings,
        system: &'s mut (dyn PeriodicSystem + 's),
        set: &'v dyn Fn(&mut Operating, f64),
    ) -> Result<Self, HarmonicError> {
        if tracking.node >= system.nodes() {
            return Err(HarmonicError::InvalidInput("the structure has no such node"));
        }
        if !(tracking.angular_frequency > 0.0 && tracking.angular_frequency.is_finite()) {
            return Err(HarmonicError::InvalidInput("the frequency to start from must be positive"));
        }
        let sought = match tracking.followed {
            TrackedQuantity::Frequency => Sought::Frequency,
            TrackedQuantity::Peak => Sought::Peak(tracking.node),
            TrackedQuantity::Phase => {
                let part = |place: usize| assembly.waveform.get(place).copied().unwrap_or(0.0);
                let excitation = [part(1), part(2)];
                if excitation == [0.0; 2] {
                    return Err(HarmonicError::InvalidInput("the excitation has no first harmonic"));
                }
                Sought::Phase(tracking.node, excitation)
            }
        };
        Ok(Self {
            system,
            settings: *settings,
            tracker: Tracker::new(settings.stopping()),
            sought,
            node: tracking.node,
            angular_frequency: tracking.angular_frequency,
            set,
        })
    }

    /// The responses at all values.
    fn over(&mut self, values: &[f64]) -> Result<TrackedCurve, HarmonicError> {
        let (mut points, mut reached) = (Vec::with_capacity(values.len()), LastSolutions::new());
        for value in values {
            match self.reach(*value, &mut reached) {
                Ok(point) => {
                    let amplitude = point.amplitude[self.node];
                    let receptance = amplitude / point.level.abs();
                    points.push(Tracked { value: *value, amplitude, receptance, point });
                }
                Err(error) if !points.is_empty() && error.is_of_the_step() => {
                    return Ok(TrackedCurve { points, lost: Some(error) });
                }
                Err(error) => return Err(error),
            }
        }
        Ok(TrackedCurve { points, lost: None })
    }

    /// The response at a value, on the straight line through the last two.
    fn predicted(&self, value: f64, reached: &LastSolutions) -> Option<Solution> {
        let (last_value, last) = reached.first()?;
        let mut start = last.clone();
        (self.set)(&mut start.at, value);
        match reached.get(1) {
            Some((before_value, before)) if before_value != last_value => {
                let ahead = (value - last_value) / (last_value - before_value);
                // Far beyond the two a straight line is no better than the last.
                let ahead = ahead.clamp(-1.0, 2.0);
                start.x.iter_mut().zip(&before.x).for_each(|(x, b)| *x += ahead * (*x - b));
                let change = last.at.angular_frequency - before.at.angular_frequency;
                let most = 0.1 * last.at.angular_frequency;
                start.at.angular_frequency += (ahead * change).clamp(-most, most);
            }
            // A new level, at first: as if all were linear.
            _ => {
                let ratio = start.at.level / last.at.level;
                start.x.iter_mut().for_each(|x| *x *= ratio);
            }
        }
        Some(start)
    }
}

impl StepwiseContinuation for Follower<'_, '_> {
    fn parts(&mut self) -> (&mut dyn PeriodicSystem, &CurveSettings) {
        (&mut *self.system, &self.settings)
    }

    fn start(&mut self, value: f64, reached: &LastSolutions) -> Result<Solution, HarmonicError> {
        self.tracker.count_anew();
        if let Some(start) = self.predicted(value, reached) {
            return Ok(start);
        }
        let mut at = Operating::forced(self.angular_frequency, 0.0);
        (self.set)(&mut at, value);
        let (x, at) = at_level(self.system, at, &self.settings)?;
        Ok(Solution { x, at })
    }

    fn solve(&mut self, _: f64, solution: &mut Solution) -> Result<Point, HarmonicError> {
        *solution = self.tracker.locate(self.system, self.sought, solution.clone())?;
        let mut point = describe(self.system, solution, &self.settings)?;
        point.iterations = self.tracker.iterations();
        Ok(point)
    }
}
