//! Response curves for people and programs: page, terminal table, JSON.

mod figures;
mod json;
mod losses;
mod page;
mod terminal;
mod trust;

pub use json::responses_json;
pub use losses::Losses;
pub use page::responses_html;
pub use terminal::responses_table;

use stickslip::harmonic::{Curve, Ending, Peak, Point};

use crate::format;

/// Curves of one model, each at its own level.
#[derive(Debug, Clone, PartialEq)]
pub struct Responses {
    /// What responds.
    pub title: String,
    /// The unit that people read frequencies in.
    pub unit: FrequencyUnit,
    /// Beginning and end of the range asked for (rad/s).
    pub range: (f64, f64),
    /// What is held along a curve; `None` where the force is.
    pub held: Option<Held>,
    /// Harmonics at least.
    pub harmonics: usize,
    /// Error estimate asked for; `None` where the harmonics do not adapt to it.
    pub tolerance: Option<f64>,
    /// Whether stability was asked for.
    pub stability: bool,
    /// What of the model takes energy.
    pub losses: Losses,
    /// The curves.
    pub curves: Vec<ResponseCurve>,
    /// Time that all took (s).
    pub seconds: f64,
}

/// A response that is held along a curve: the first harmonic of a node.
#[derive(Debug, Clone, PartialEq)]
pub struct Held {
    /// Name of the node.
    pub node: String,
    /// 0 displacement, 1 velocity, 2 acceleration.
    pub derivative: usize,
}

impl Held {
    /// Its quantity.
    pub fn quantity(&self) -> &'static str {
        ["displacement", "velocity", "acceleration"][self.derivative.min(2)]
    }

    /// Its SI unit.
    pub fn unit(&self) -> &'static str {
        ["m", "m/s", "m/s^2"][self.derivative.min(2)]
    }

    /// As a user writes it: `acceleration:x=0.55`.
    pub fn name(&self) -> String {
        format!("{}:{}", self.quantity(), self.node)
    }
}

/// The curve at one level.
#[derive(Debug, Clone, PartialEq)]
pub struct ResponseCurve {
    /// The force (N), or the held amplitude (SI).
    pub level: f64,
    /// The points found.
    pub curve: Curve,
    /// Where a held displacement is a quarter period behind the force; empty where the force is held.
    pub phase_resonances: Vec<PhaseResonance>,
    /// Loops of the contacts at the peaks.
    pub loops: Vec<ContactLoop>,
    /// Why the curve ends before its end, where that is not an interruption.
    pub failure: Option<String>,
    /// Time it took (s).
    pub seconds: f64,
}

/// A response whose displacement is a quarter period behind the force.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PhaseResonance {
    /// Which node.
    pub node: usize,
    /// Ω (rad/s).
    pub angular_frequency: f64,
    /// Force (N).
    pub level: f64,
    /// Whether it was only interpolated between two points, rather than solved for.
    pub interpolated: bool,
}

/// One period of a contact.
#[derive(Debug, Clone, PartialEq)]
pub struct ContactLoop {
    /// Where on the curve, for the legend.
    pub name: String,
    /// Displacement of the contact (m), closed.
    pub displacement: Vec<f64>,
    /// Restoring force (N), as many.
    pub force: Vec<f64>,
    /// Whether it is the normal direction of a contact in two.
    pub is_normal: bool,
}

/// The unit of frequency at the user's side.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum FrequencyUnit {
    /// Hz.
    #[default]
    Hertz,
    /// rad/s.
    RadiansPerSecond,
}

impl FrequencyUnit {
    /// As it is written.
    pub fn name(self) -> &'static str {
        match self {
            FrequencyUnit::Hertz => "Hz",
            FrequencyUnit::RadiansPerSecond => "rad/s",
        }
    }

    /// An angular frequency (rad/s) in this unit.
    pub fn of(self, angular_frequency: f64) -> f64 {
        match self {
            FrequencyUnit::Hertz => angular_frequency / std::f64::consts::TAU,
            FrequencyUnit::RadiansPerSecond => angular_frequency,
        }
    }

    /// A value in this unit as angular frequency (rad/s).
    pub fn to_angular(self, value: f64) -> f64 {
        match self {
            FrequencyUnit::Hertz => value * std::f64::consts::TAU,
            FrequencyUnit::RadiansPerSecond => value,
        }
    }

    /// An angular frequency (rad/s) with the unit, to six digits.
    pub fn shown(self, angular_frequency: f64) -> String {
        format!("{}\u{a0}{}", format::significant(self.of(angular_frequency), 6), self.name())
    }
}

impl Responses {
    /// Whether every curve came to its end.
    pub fn complete(&self) -> bool {
        self.curves.iter().all(|one| one.failure.is_none() && one.curve.ending == Ending::Complete)
    }

    fn points(&self) -> impl Iterator<Item = &Point> {
        self.curves.iter().flat_map(|one| &one.curve.points)
    }

    fn point_count(&self) -> usize {
        self.points().count()
    }

    /// The level of a curve with its unit.
    fn level(&self, one: &ResponseCurve) -> String {
        format::engineering(one.level, self.held.as_ref().map_or("N", Held::unit))
    }

    /// Names of the nodes.
    fn nodes(&self) -> &[String] {
        self.curves.first().map_or(&[], |one| &one.curve.nodes)
    }

    /// Place of the held node.
    fn held_node(&self) -> Option<usize> {
        let held = self.held.as_ref()?;
        self.nodes().iter().position(|node| *node == held.node)
    }

    /// The result in a sentence.
    fn lead(&self) -> String {
        let peak = |one: &ResponseCurve| {
            let of_node = |peak: &&Peak| self.held_node().is_none_or(|node| peak.node == node);
            let size = |peak: &Peak| if self.held.is_some() { -peak.level } else { peak.amplitude };
            let peaks = one.curve.peaks.iter().filter(of_node);
            peaks.max_by(|a, b| size(a).total_cmp(&size(b))).copied()
        };
        let found: Vec<(&ResponseCurve, Peak)> =
            self.curves.iter().filter_map(|one| peak(one).map(|peak| (one, peak))).collect();
        let at = |(one, peak): &(&ResponseCurve, Peak)| {
            format!("{} at {}", self.unit.shown(peak.angular_frequency), self.level(one))
        };
        match &found[..] {
            [] if self.point_count() == 0 => "No point of the curves was found.".to_owned(),
            [] => self.no_peak(),
            [only] if self.held.is_some() => {
                let force = format::engineering(only.1.level, "N");
                format!("The least force, {force}, holds {} at {}.", self.held_name(), at(only))
            }
            [only] => format!(
                "The largest peak is that of {}: {} at {} under {}.",
                self.nodes().get(only.1.node).map_or("", String::as_str),
                format::engineering(only.1.amplitude, "m"),
                self.unit.shown(only.1.angular_frequency),
                self.level(only.0)
            ),
            [first, .., last] => {
                let what = if self.held.is_some() { "resonance" } else { "largest peak" };
                format!("The {what} goes from {} to {}.", at(first), at(last))
            }
        }
    }

    /// That there is no peak, and up to which frequency.
    fn no_peak(&self) -> String {
        let whole = |one: &ResponseCurve| one.failure.is_none() && one.curve.ending == Ending::Complete;
        let reached = |one: &ResponseCurve| {
            one.curve.points.iter().map(|point| point.angular_frequency).fold(f64::NAN, f64::max)
        };
        let ended = self.curves.iter().filter(|one| !whole(one)).map(reached).fold(f64::NAN, f64::min);
        if ended.is_nan() {
            return "There is no peak between the ends of the range.".to_owned();
        }
        let curve = if self.curves.len() == 1 { "the curve" } else { "a curve" };
        format!("There is no peak up to {}, where {curve} ended.", self.unit.shown(ended))
    }

    /// What a peak of a held response is, and where its phase resonance lies.
    fn held_note(&self) -> Option<String> {
        self.held.as_ref()?;
        let mut text = "A peak is where the least force holds the response. Where damping is heavy, phase \
                        resonance, with the displacement a quarter period behind the force, is at another frequency"
            .to_owned();
        let mut found = Vec::new();
        for one in &self.curves {
            for at in &one.phase_resonances {
                let how = if at.interpolated { " (interpolated)" } else { "" };
                let force = format::engineering(at.level, "N");
                let place = self.unit.shown(at.angular_frequency);
                found.push(format!("{place} with {force} at {}{how}", self.level(one)));
            }
        }
        const MOST: usize = 10;
        let more = found.len().saturating_sub(MOST);
        found.truncate(MOST);
        if found.is_empty() {
            text.push_str("; the curves found have none.");
        } else {
            text.push_str(&format!(": {}", found.join("; ")));
            text.push_str(&if more > 0 { format!("; and {more} more.") } else { ".".to_owned() });
        }
        Some(text)
    }

    fn held_name(&self) -> String {
        self.held.as_ref().map_or_else(String::new, Held::name)
    }

    /// What must not be overlooked.
    fn warnings(&self) -> Vec<String> {
        let mut warnings = Vec::new();
        for one in &self.curves {
            let reached = one.curve.points.last().map_or_else(
                || "before its first point".to_owned(),
                |point| format!("at {}", self.unit.shown(point.angular_frequency)),
            );
            let (level, end) = (self.level(one), self.unit.shown(self.range.1));
            match (&one.failure, one.curve.ending) {
                (Some(reason), _) => warnings.push(format!(
                    "The curve at {level} ends {reached}, short of {end}: {reason}. Another --from, farther from \
                     a resonance, another level, or fewer --harmonics may help."
                )),
                (None, Ending::Stuck) => warnings.push(format!(
                    "The curve at {level} ends {reached}, short of {end}: its steps became too small or too many.{}",
                    self.unbounded_hint()
                )),
                (None, Ending::Returned) => warnings.push(format!(
                    "The curve at {level} turned back and left the range at {}, where it began: it does not reach \
                     {end}.",
                    self.unit.shown(self.range.0)
                )),
                (None, Ending::Interrupted) => {
                    warnings.push(format!("Interrupted: the curve at {level} ends {reached}, short of {end}."));
                }
                (None, Ending::Complete) => {}
            }
        }
        warnings.extend(self.unresolved_warning());
        warnings
    }

    /// What was computed and how well; how long it took is for the terminal, since the same input gives the same page.
    fn scope(&self) -> String {
        let kind = self.held.as_ref().map_or_else(
            || format!("{} of force", format::count(self.curves.len(), "level")),
            |held| format!("{} of held {}", format::count(self.curves.len(), "level"), held.name()),
        );
        format!(
            "{kind}, {} to {}: {}.{}{}",
            format::significant(self.unit.of(self.range.0), 6),
            self.unit.shown(self.range.1),
            format::count(self.point_count(), "point"),
            self.error_sentence(),
            self.stability_sentence(),
        )
    }
}

/// How a curve ended, in a word.
fn ending(one: &ResponseCurve) -> &'static str {
    match (one.failure.is_some(), one.curve.ending) {
        (true, _) | (_, Ending::Stuck) => "stuck",
        (_, Ending::Returned) => "returned",
        (_, Ending::Interrupted) => "interrupted",
        (_, Ending::Complete) => "complete",
    }
}
