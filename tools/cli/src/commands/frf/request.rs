//! What the user asks for, checked.

use stickslip::document::suggestion;
use stickslip::harmonic::{Control, CurveSettings, Interrupt};
use stickslip_report::responses::FrequencyUnit;

use super::Frf;
use crate::{Failure, progress};

/// Curves of one command at most.
const LEVELS: usize = 1000;
/// Harmonics that can be asked for.
const HARMONICS: usize = 2000;

/// The curves to follow.
pub struct Request {
    pub unit: FrequencyUnit,
    /// Both ends (rad/s).
    pub range: (f64, f64),
    pub hold: Option<Hold>,
    /// Forces (N) or held amplitudes (SI), all positive.
    pub levels: Vec<f64>,
    pub nodes: Vec<String>,
    pub settings: CurveSettings,
}

/// What is held.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hold {
    /// Place of the node.
    pub node: usize,
    /// 0 displacement, 1 velocity, 2 acceleration.
    pub derivative: usize,
}

impl Request {
    /// Checks what can be checked before any work.
    pub fn new(command: &Frf, nodes: &[String]) -> Result<Self, Failure> {
        let unit: FrequencyUnit = command.unit.into();
        let (from, to) = (command.from.unwrap_or(f64::NAN), command.to.unwrap_or(f64::NAN));
        if !(from.is_finite() && to.is_finite() && from > 0.0) {
            return Err(Failure::input(format!(
                "--from {} --to {}: frequencies must be positive numbers",
                plain(from),
                plain(to)
            )));
        }
        if from >= to {
            return Err(Failure::input(format!("--from {} must be below --to {}", plain(from), plain(to))));
        }
        let (hold, levels) = levels(command, nodes)?;
        if let Some(level) = levels.iter().find(|level| !(level.is_finite() && **level > 0.0)) {
            return Err(Failure::input(format!(
                "a level of {level} is not possible; levels are positive numbers"
            )));
        }
        if levels.len() > LEVELS {
            return Err(Failure::input(format!("{} levels are too many; {LEVELS} at most", levels.len())));
        }
        let range = (unit.to_angular(from), unit.to_angular(to));
        Ok(Self { unit, range, hold, levels, nodes: nodes.to_vec(), settings: command.settings()? })
    }

    /// The settings for a single point, without stability.
    pub fn alone(&self) -> CurveSettings {
        CurveSettings { stability: false, ..self.settings }
    }

    /// What is kept along the curve of one level.
    pub fn control(&self, level: f64) -> Control {
        match self.hold {
            None => Control::Level(level),
            Some(Hold { node, derivative }) => Control::Held { node, order: 1, derivative, amplitude: level },
        }
    }
}

impl Frf {
    /// How responses are computed, as the options say.
    pub fn settings(&self) -> Result<CurveSettings, Failure> {
        if !(1..=HARMONICS).contains(&self.harmonics) {
            let given = self.harmonics;
            return Err(Failure::input(format!("--harmonics {given} must lie between 1 and {HARMONICS}")));
        }
        if let Some(tolerance) = self.tolerance.filter(|value| !(*value > 0.0 && *value < 1.0)) {
            return Err(Failure::input(format!("--tolerance {tolerance} must lie between 0 and 1")));
        }
        let defaults = CurveSettings::default();
        Ok(CurveSettings {
            harmonics: self.harmonics,
            truncation: self.tolerance,
            max_harmonics: defaults.max_harmonics.max(self.harmonics),
            stability: !self.no_stability,
            interrupt: Some(Interrupt(progress::interrupted)),
            ..defaults
        })
    }
}

/// A number as a user would write it: 1e300 rather than 301 digits.
fn plain(value: f64) -> String {
    if value.is_finite() && value.abs() >= 1e9 { format!("{value:e}") } else { value.to_string() }
}

/// What is held, if anything, and the levels.
fn levels(command: &Frf, nodes: &[String]) -> Result<(Option<Hold>, Vec<f64>), Failure> {
    let Some(text) = &command.hold else {
        let levels = if command.levels.is_empty() {
            vec![command.force.unwrap_or(1.0)]
        } else {
            command.levels.clone()
        };
        return Ok((None, levels));
    };
    let (hold, amplitude) = hold(text, nodes)?;
    match (amplitude, command.levels.is_empty()) {
        (Some(amplitude), true) => Ok((Some(hold), vec![amplitude])),
        (None, false) => Ok((Some(hold), command.levels.clone())),
        (None, true) => Err(Failure::input(format!(
            "--hold {text} says no amplitude: --hold {text}=VALUE, or --levels for several"
        ))),
        (Some(_), false) => Err(Failure::input(format!(
            "--hold {text} has an amplitude and --levels has others; give one of them"
        ))),
    }
}

/// `acceleration:x=0.55=70`: a quantity, a node (whose name may hold `=`) and perhaps an amplitude.
fn hold(text: &str, nodes: &[String]) -> Result<(Hold, Option<f64>), Failure> {
    const QUANTITIES: [&str; 3] = ["displacement", "velocity", "acceleration"];
    let Some((quantity, rest)) = text.split_once(':') else {
        return Err(Failure::input(format!(
            "--hold {text}: write it as acceleration:x=0.55=70 or displacement:m1=1e-3"
        )));
    };
    let derivative = QUANTITIES.iter().position(|known| *known == quantity).ok_or_else(|| {
        let help = suggestion(quantity, &QUANTITIES, "quantities");
        Failure::input(format!("--hold {text}: there is no quantity `{quantity}`; {help}"))
    })?;
    if let Some(node) = place(rest, nodes) {
        return Ok((Hold { node, derivative }, None));
    }
    let (name, amplitude) = match rest.rsplit_once('=') {
        // `x=0.54` is a misspelt node rather than the amplitude 0.54 of the node `x`.
        Some((name, amplitude)) if !(name == "x" && nodes.iter().any(|node| node.starts_with("x="))) => {
            (name, Some(amplitude))
        }
        _ => (rest, None),
    };
    let node = node(name, nodes).map_err(|error| Failure::input(format!("--hold {text}: {error}")))?;
    let amplitude = amplitude
        .map(|text_of| {
            text_of.parse::<f64>().map_err(|_| {
                Failure::input(format!("--hold {text}: the amplitude `{text_of}` is not a number"))
            })
        })
        .transpose()?;
    Ok((Hold { node, derivative }, amplitude))
}

/// The node of that name; the error names the nearest.
pub fn node(name: &str, nodes: &[String]) -> Result<usize, String> {
    place(name, nodes).ok_or_else(|| {
        let known: Vec<&str> = nodes.iter().map(String::as_str).collect();
        format!("the model has no node `{name}`; {}", suggestion(name, &known, "nodes"))
    })
}

/// The node of that name; positions are compared as numbers, so that `x=0.550` is found too.
fn place(name: &str, nodes: &[String]) -> Option<usize> {
    let position = |text: &str| text.strip_prefix("x=").and_then(|value| value.parse::<f64>().ok());
    nodes.iter().position(|node| node == name).or_else(|| {
        nodes.iter().position(|node| position(node).is_some() && position(node) == position(name))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn beam() -> Vec<String> {
        ["x=0.55", "x=0.3"].map(str::to_owned).to_vec()
    }

    #[test]
    fn a_node_may_hold_an_equals_sign() {
        let (what, amplitude) = hold("acceleration:x=0.55=70", &beam()).unwrap();
        assert_eq!((what, amplitude), (Hold { node: 0, derivative: 2 }, Some(70.0)));
        let (what, amplitude) = hold("velocity:x=0.30", &beam()).unwrap();
        assert_eq!((what, amplitude), (Hold { node: 1, derivative: 1 }, None));
        let nodes = ["m1".to_owned()];
        assert_eq!(hold("displacement:m1=1e-3", &nodes).unwrap().1, Some(1e-3));
    }

    #[test]
    fn what_cannot_be_held_is_named() {
        let message = |text: &str| hold(text, &beam()).unwrap_err().message;
        assert!(message("accelaration:x=0.55=70").contains("did you mean `acceleration`"));
        assert!(message("acceleration:x=0.54=70").contains("did you mean `x=0.55`"));
        assert!(message("acceleration:x=0.5").contains("no node `x=0.5`"));
        assert!(message("acceleration:x=0.55=seventy").contains("`seventy` is not a number"));
        assert!(message("x=0.55=70").contains("write it as"));
    }
}
