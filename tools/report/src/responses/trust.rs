//! What is known of the points' errors and stability, in words.

use stickslip::harmonic::stability::Undecided;
use stickslip::harmonic::{Peak, Point, UNRESOLVED};

use super::{ResponseCurve, Responses};
use crate::document::scientific;
use crate::format;

/// What is known of a truncation error.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Error {
    /// It meets the limit.
    Resolved,
    /// It does not.
    Unresolved,
    /// It cannot be determined.
    Unknown,
}

/// What is known of the error at a point.
pub fn error(point: &Point) -> Error {
    match (point.error_estimate.is_nan(), point.resolved) {
        (true, _) => Error::Unknown,
        (false, true) => Error::Resolved,
        (false, false) => Error::Unresolved,
    }
}

/// Points above the limit, and points whose error is unknown.
pub fn count<'a>(points: impl Iterator<Item = &'a Point>) -> (usize, usize) {
    points.map(error).fold((0, 0), |(unresolved, unknown), error| match error {
        Error::Resolved => (unresolved, unknown),
        Error::Unresolved => (unresolved + 1, unknown),
        Error::Unknown => (unresolved, unknown + 1),
    })
}

/// The largest error estimate; NaN where none is known.
pub fn worst<'a>(points: impl Iterator<Item = &'a Point>) -> f64 {
    points.map(|point| point.error_estimate).fold(f64::NAN, f64::max)
}

/// An error estimate as it is printed.
pub fn shown(estimate: f64) -> String {
    match estimate {
        estimate if estimate.is_nan() => "unknown".to_owned(),
        estimate if estimate.is_infinite() => "∞".to_owned(),
        estimate => scientific(estimate),
    }
}

/// The points above the limit, or that it is unknown, for a cell of a table.
pub fn unresolved(points: &[Point]) -> String {
    match count(points.iter()) {
        (0, unknown) if unknown > 0 && unknown == points.len() => "?".to_owned(),
        (unresolved, 0) => unresolved.to_string(),
        (unresolved, unknown) => format!("{unresolved} ({unknown} ?)"),
    }
}

/// The unstable points, or that it is unknown, for a cell of a table.
pub fn unstable(points: &[Point]) -> String {
    let unstable = points.iter().filter(|point| point.stable == Some(false)).count();
    match points.iter().filter(|point| point.stable.is_none()).count() {
        unknown if unknown > 0 && unknown == points.len() => "?".to_owned(),
        0 => unstable.to_string(),
        unknown => format!("{unstable} ({unknown} ?)"),
    }
}

/// Why stability cannot be determined.
pub fn reason(undecided: Undecided) -> &'static str {
    match undecided {
        Undecided::TooLarge => {
            "more than 60 degrees of freedom, and contacts other than sliders without play"
        }
        Undecided::TooLong => {
            "it would take too long: the highest natural frequency is high, and the period long"
        }
        Undecided::NotSettled => "the multipliers do not converge",
        Undecided::TwoDirections => {
            "a contact slips and slaps at once: disturbances are not followed through it"
        }
        _ => "there is no response to judge",
    }
}

/// The point of the curve that a peak lies at.
pub fn nearest<'a>(one: &'a ResponseCurve, peak: &Peak) -> Option<&'a Point> {
    let off = |found: f64, sought: f64| ((found - sought) / sought).abs();
    let distance = |point: &Point| {
        let amplitude = point.amplitude.get(peak.node).map_or(0.0, |found| off(*found, peak.amplitude));
        off(point.angular_frequency, peak.angular_frequency) + amplitude + off(point.level, peak.level)
    };
    one.curve.points.iter().min_by(|a, b| distance(a).total_cmp(&distance(b)))
}

/// Whether a peak lies on an unresolved point.
pub fn is_unresolved(one: &ResponseCurve, peak: &Peak) -> bool {
    nearest(one, peak).is_some_and(|point| error(point) == Error::Unresolved)
}

/// The estimate at a peak as it is printed.
pub fn at_peak(one: &ResponseCurve, peak: &Peak) -> String {
    nearest(one, peak).map_or_else(|| shown(f64::NAN), |point| shown(point.error_estimate))
}

impl Responses {
    /// The largest error estimate of a resolved point.
    pub(super) fn limit(&self) -> f64 {
        self.tolerance.unwrap_or(UNRESOLVED)
    }

    /// How many points and peaks are above the limit; nothing where none is.
    pub(super) fn unresolved_warning(&self) -> Option<String> {
        let (unresolved, _) = count(self.points());
        if unresolved == 0 {
            return None;
        }
        let all = self.curves.iter().flat_map(|one| one.curve.peaks.iter().map(move |peak| (one, peak)));
        let peaks = all.clone().filter(|(one, peak)| is_unresolved(one, peak)).count();
        let (limit, points) = (scientific(self.limit()), format::count(unresolved, "point"));
        let of = self.point_count();
        let mut text = match self.tolerance {
            Some(_) => format!("{points} of {of}: the error estimate does not meet the tolerance {limit}."),
            None => format!("{points} of {of}: the error estimate is above {limit} of the amplitude."),
        };
        if peaks > 0 {
            text.push_str(&format!(" Among them {} of {}.", format::count(peaks, "peak"), all.count()));
        }
        let them = if unresolved == 1 { "it" } else { "them" };
        text.push_str(&match self.tolerance {
            Some(_) => format!(
                " With --tolerance there are 101 harmonics at most: more (--harmonics above that), or a larger \
                 tolerance, may resolve {them}."
            ),
            None => format!(
                " More harmonics (--harmonics, or --tolerance, which adds them where they are needed) may \
                 resolve {them}."
            ),
        });
        Some(text)
    }

    /// The largest error estimate, in a sentence; nothing where there are no points.
    pub(super) fn error_sentence(&self) -> String {
        let (_, unknown) = count(self.points());
        match (self.point_count(), unknown) {
            (0, _) => String::new(),
            (all, unknown) if all == unknown => " The truncation error is unknown.".to_owned(),
            (_, unknown) => {
                let rest = if unknown > 0 { format!("; of {unknown} it is unknown") } else { String::new() };
                format!(" Largest estimate of the truncation error: {}{rest}.", shown(worst(self.points())))
            }
        }
    }

    /// Whether stability was requested and could be determined at no point.
    fn stability_is_unknown(&self) -> bool {
        self.stability && self.points().all(|point| point.stable.is_none())
    }

    /// Why stability cannot be determined where it cannot; nothing where no reason is known.
    fn reasons(&self) -> String {
        let mut all: Vec<&str> = self.points().filter_map(|point| point.undecided).map(reason).collect();
        all.sort_unstable();
        all.dedup();
        if all.is_empty() { String::new() } else { format!(" ({})", all.join("; ")) }
    }

    /// What is known of the stability, in a sentence; nothing where there are no points.
    pub(super) fn stability_sentence(&self) -> String {
        if !self.stability {
            return " Stability was not requested.".to_owned();
        }
        if self.point_count() == 0 {
            return String::new();
        }
        if self.stability_is_unknown() {
            return format!(" For this kind of structure stability cannot be determined{}.", self.reasons());
        }
        let unstable = self.points().filter(|point| point.stable == Some(false)).count();
        let unknown = self.points().filter(|point| point.stable.is_none()).count();
        match (unstable, unknown) {
            (0, 0) => " All points are stable.".to_owned(),
            (0, unknown) => {
                let why = self.reasons();
                format!(
                    " No point is known to be unstable; at {unknown} the stability cannot be determined{why}."
                )
            }
            (1, 0) => " 1 point is unstable.".to_owned(),
            (many, 0) => format!(" {many} points are unstable."),
            (many, unknown) => {
                format!(
                    " {many} unstable; at {unknown} the stability cannot be determined{}.",
                    self.reasons()
                )
            }
        }
    }
}
