//! Resonances followed over the excitation's level or over a parameter of the contacts.

use super::start::at_level;
use super::tracker::{Solution, Sought, Tracker, describe, more_harmonics};
use crate::harmonic::balance::assembly::Assembly;
use crate::harmonic::balance::balance_of;
use crate::harmonic::balance::varied::{AssemblyAt, Varied};
use crate::harmonic::newton::Point;
use crate::harmonic::newton::system::{Operating, PeriodicSystem};
use crate::harmonic::{CurveSettings, HarmonicError};

/// Fraction of the way from one value to the next below which it is given up.
pub(crate) const LEAST_FRACTION: f64 = 1e-5;
/// Change of the frequency in a step, relative, beyond which another resonance may have been taken for this.
pub(crate) const LARGEST_CHANGE: f64 = 0.03;

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
    let mut follower = Follower::new(assembly, tracking, settings, &mut *system)?;
    follower.over(levels, |at, value| at.level = value)
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
    let mut follower = Follower::new(&assembly, tracking, settings, &mut system)?;
    follower.over(values, |at, value| (at.level, at.parameter) = (level, value))
}

/// Carries the response from value to value.
struct Follower<'s> {
    system: &'s mut (dyn PeriodicSystem + 's),
    settings: CurveSettings,
    tracker: Tracker,
    sought: Sought,
    node: usize,
    angular_frequency: f64,
    /// The last two values with their responses, the later one first.
    reached: Vec<(f64, Solution)>,
}

impl<'s> Follower<'s> {
    fn new(
        assembly: &Assembly,
        tracking: &Tracking,
        settings: &CurveSettings,
        system: &'s mut (dyn PeriodicSystem + 's),
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
            reached: Vec::new(),
        })
    }

    /// The responses at all values; `set` makes them known to the balance.
    fn over(
        &mut self,
        values: &[f64],
        set: impl Fn(&mut Operating, f64),
    ) -> Result<TrackedCurve, HarmonicError> {
        let mut points = Vec::with_capacity(values.len());
        for value in values {
            match self.reach(*value, &set) {
                Ok(point) => points.push(point),
                Err(error) if !points.is_empty() && error.is_of_the_step() => {
                    return Ok(TrackedCurve { points, lost: Some(error) });
                }
                Err(error) => return Err(error),
            }
        }
        Ok(TrackedCurve { points, lost: None })
    }

    /// The response at a value, on smaller and smaller steps from the last one.
    fn reach(&mut self, value: f64, set: &impl Fn(&mut Operating, f64)) -> Result<Tracked, HarmonicError> {
        let mut fraction = 1.0;
        loop {
            let next = self.reached.first().map_or(value, |(from, _)| between(*from, value, fraction));
            match self.step(next, set) {
                Ok(point) if next == value => {
                    let amplitude = point.amplitude[self.node];
                    return Ok(Tracked {
                        value,
                        amplitude,
                        receptance: amplitude / point.level.abs(),
                        point,
                    });
                }
                Ok(_) => fraction = f64::min(2.0 * fraction, 1.0),
                Err(error) => {
                    fraction *= 0.5;
                    if self.reached.is_empty() || fraction < LEAST_FRACTION || !error.is_of_the_step() {
                        return Err(error);
                    }
                    self.system.forget();
                }
            }
        }
    }

    /// One step to a value.
    fn step(&mut self, value: f64, set: &impl Fn(&mut Operating, f64)) -> Result<Point, HarmonicError> {
        let start = match self.predicted(value, set) {
            Some(start) => start,
            None => {
                let mut at = Operating::forced(self.angular_frequency, 0.0);
                set(&mut at, value);
                let (x, at) = at_level(self.system, at, &self.settings)?;
                Solution { x, at }
            }
        };
        let mut solution = self.tracker.locate(self.system, self.sought, start)?;
        let mut point = describe(self.system, &solution, &self.settings)?;
        while let Some(harmonics) = more_harmonics(&point, &self.settings) {
            let mut vectors: Vec<&mut Vec<f64>> = vec![&mut solution.x];
            vectors.extend(self.reached.iter_mut().map(|(_, reached)| &mut reached.x));
            if !self.system.set_harmonics(harmonics, &mut vectors)? {
                break;
            }
            solution = self.tracker.locate(self.system, self.sought, solution)?;
            point = describe(self.system, &solution, &self.settings)?;
        }
        point.iterations = self.tracker.take_iterations();
        if let Some((_, last)) = self.reached.first() {
            let change = solution.at.angular_frequency / last.at.angular_frequency - 1.0;
            if change.abs() > LARGEST_CHANGE {
                return Err(HarmonicError::NotConverged {
                    residual: change.abs(),
                    iterations: point.iterations,
                });
            }
        }
        self.reached.insert(0, (value, solution));
        self.reached.truncate(2);
        Ok(point)
    }

    /// The response at a value, on the straight line through the last two.
    fn predicted(&self, value: f64, set: &impl Fn(&mut Operating, f64)) -> Option<Solution> {
        let (last_value, last) = self.reached.first()?;
        let mut start = last.clone();
        set(&mut start.at, value);
        match self.reached.get(1) {
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

/// A fraction of the way from one value to another, by ratio where both have the same sign.
pub(crate) fn between(from: f64, to: f64, fraction: f64) -> f64 {
    if fraction >= 1.0 || from == to {
        to
    } else if from * to > 0.0 {
        from * (to / from).powf(fraction)
    } else {
        from + fraction * (to - from)
    }
}
