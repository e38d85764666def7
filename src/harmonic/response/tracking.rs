//! Resonances tracked over the excitation's level or over a parameter.

use super::curve::Curve;
use super::start::at_level;
use super::stepwise::{LastSolutions, StepwiseContinuation};
use super::tracker::{Solution, Sought, Tracker, describe};
use crate::harmonic::balance::assembly::Assembly;
use crate::harmonic::balance::balance_of;
use crate::harmonic::balance::varied::{AssemblyAt, Varied};
use crate::harmonic::continuation::Ending;
use crate::harmonic::newton::Point;
use crate::harmonic::newton::system::{Operating, PeriodicSystem};
use crate::harmonic::{CurveSettings, HarmonicError};

/// What is tracked.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TrackedQuantity {
    /// The frequency at which the node's amplitude, its largest displacement over a period, is largest.
    Peak,
    /// The frequency at which the first harmonic of the node's displacement is a quarter period behind that
    /// of the excitation, or ahead of it (as it may be away from the excitation).
    Phase,
}

/// What is tracked, of which node, and from where.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tracking {
    /// What is tracked.
    pub quantity: TrackedQuantity,
    /// Which node of the structure.
    pub node: usize,
    /// Ω (rad/s) near which it is at the first value: the peak is the next one uphill from there.
    pub angular_frequency: f64,
}

/// The resonance at each of the excitation's `levels`, in the order given. `watch` sees every point and says whether to go
/// on. A curve that ends early is returned as far as it came: a resonance may end (the phase of a node may cease to pass a
/// quarter period, and a peak may merge with its neighbour).
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
/// let tracking = Tracking { quantity: TrackedQuantity::Peak, node: 0, angular_frequency: 1.1 };
/// let levels = [0.001, 1.0, 100.0];
/// let peaks = track_levels(&assembly, &tracking, &levels, &CurveSettings::default(), &mut |_| true)?.points;
/// // From stuck, √1.44, to free.
/// assert!((peaks[0].angular_frequency - 1.2).abs() < 0.01);
/// assert!((peaks[2].angular_frequency - 1.0).abs() < 0.01);
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
    watch: &mut dyn FnMut(&Point) -> bool,
) -> Result<Curve, HarmonicError> {
    if levels.is_empty() || levels.iter().any(|level| !(level.is_finite() && *level != 0.0)) {
        return Err(HarmonicError::InvalidInput("there is no level, or one is zero or not finite"));
    }
    let mut system = balance_of(assembly, settings)?;
    let set = |at: &mut Operating, value| at.level = value;
    Follower::new(assembly, tracking, settings, &mut *system, &set)?.over(assembly, levels, watch)
}

/// The resonance at a constant `level` at each of the `values` of a parameter, as [`track_levels`] has it over the level. `at`
/// makes the system at a value.
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
/// let tracking = Tracking { quantity: TrackedQuantity::Phase, node: 0, angular_frequency: 1.1 };
/// let settings = CurveSettings::default();
/// let curve = track_parameter(&over_friction, 0.5, &tracking, &[0.1, 0.2, 0.3], &settings, &mut |_| true)?;
/// assert!(curve.points[2].angular_frequency > curve.points[0].angular_frequency);
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
    watch: &mut dyn FnMut(&Point) -> bool,
) -> Result<Curve, HarmonicError> {
    if !(level.is_finite() && level != 0.0) {
        return Err(HarmonicError::InvalidInput("the level is zero or not finite"));
    }
    if values.iter().any(|value| !value.is_finite()) {
        return Err(HarmonicError::InvalidInput("a value of the parameter is not finite"));
    }
    let first = values.first().ok_or(HarmonicError::InvalidInput("there is no value of the parameter"))?;
    let mut system = Varied::new(at, *first, 0.0, settings)?;
    let assembly = system.assembly().clone();
    let set = |at: &mut Operating, value| (at.level, at.parameter) = (level, value);
    Follower::new(&assembly, tracking, settings, &mut system, &set)?.over(&assembly, values, watch)
}

/// The response carried from value to value.
struct Follower<'s, 'v> {
    system: &'s mut (dyn PeriodicSystem + 's),
    settings: CurveSettings,
    tracker: Tracker,
    sought: Sought,
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
        let sought = match tracking.quantity {
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
            angular_frequency: tracking.angular_frequency,
            set,
        })
    }

    /// The responses at all values.
    fn over(
        &mut self,
        assembly: &Assembly,
        values: &[f64],
        watch: &mut dyn FnMut(&Point) -> bool,
    ) -> Result<Curve, HarmonicError> {
        let mut curve = Curve::empty(assembly.nodes());
        let mut reached = LastSolutions::new();
        for value in values {
            match self.reach(*value, &mut reached) {
                Ok(point) => curve.points.push(point),
                Err(error) if !curve.points.is_empty() && error.is_of_the_step() => {
                    curve.ending = Ending::Stuck;
                    break;
                }
                Err(HarmonicError::Interrupted) if !curve.points.is_empty() => {
                    curve.ending = Ending::Interrupted;
                    break;
                }
                Err(error) => return Err(error),
            }
            if !curve.points.last().is_none_or(&mut *watch) {
                curve.ending = Ending::Interrupted;
                break;
            }
        }
        Ok(curve)
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
