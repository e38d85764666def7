//! What is hidden in a case, read from `truth.json` (or from a sealed case, which is written the same way).

use std::collections::BTreeMap;

use serde_json::Value;

use crate::rigs::effect::UNKNOWN;

/// What a case hides.
#[derive(Debug, Clone, PartialEq)]
pub struct Truth {
    /// `contact`, `oscillator`, `beam`.
    pub kind: String,
    /// Names of the effects, sorted; nothing in a null case. One outside the catalogue begins with `unknown:`.
    pub effects: Vec<String>,
    /// Share of a channel's root mean square.
    pub noise: f64,
    /// Whether the noise is coloured.
    pub coloured: bool,
    /// `full`, `half`, `quarter`.
    pub strength: String,
    /// Whether its records are not stationary.
    pub moving: bool,
    /// Where effects sit that sit somewhere.
    pub places: BTreeMap<String, String>,
    /// What it asks that the first cases did not, in a word.
    pub question: Option<String>,
    /// The contact laws that describe what is hidden exactly, its own name the first, where it is one.
    pub laws: Vec<String>,
    /// Names that a fault of the measurement outside the catalogue may be told by.
    pub faults: Vec<String>,
    /// Parameters of each effect, SI.
    pub parameters: BTreeMap<String, BTreeMap<String, f64>>,
}

impl Truth {
    /// Reads an entry of `truth.json`: `family`, `effect` (`none`, a name, `unknown:name`, or several joined by
    /// `+`) or a list `effects`, `noise`; the rest may be missing.
    ///
    /// # Errors
    /// An entry without a family or without an effect.
    pub fn read(entry: &Value) -> Result<Truth, String> {
        let word = |key: &str| entry.get(key).and_then(Value::as_str).map(str::to_owned);
        let kind = word("family").or_else(|| word("kind")).ok_or("no `family`")?;
        let mut effects: Vec<String> = match (entry.get("effects").and_then(Value::as_array), word("effect"))
        {
            (Some(list), _) => list.iter().filter_map(|name| name.as_str().map(str::to_owned)).collect(),
            (None, Some(names)) => names.split(['+', ',']).map(|name| name.trim().to_owned()).collect(),
            (None, None) => entry
                .get("effect")
                .and_then(Value::as_array)
                .ok_or("no `effect`")?
                .iter()
                .filter_map(|name| name.as_str().map(str::to_owned))
                .collect(),
        };
        effects.retain(|name| name != "none" && !name.is_empty());
        effects.sort();
        let places = entry.get("places").and_then(Value::as_object).into_iter().flatten();
        let words = |key: &str| -> Vec<String> {
            let list = entry.get(key).and_then(Value::as_array).into_iter().flatten();
            list.filter_map(|word| word.as_str().map(str::to_owned)).collect()
        };
        let parameters = entry.get("parameters").and_then(Value::as_object).into_iter().flatten();
        Ok(Truth {
            kind,
            effects,
            noise: entry.get("noise").and_then(Value::as_f64).unwrap_or(f64::NAN),
            coloured: entry.get("coloured").and_then(Value::as_bool).unwrap_or(false),
            moving: entry.get("moving").and_then(Value::as_bool).unwrap_or(false),
            strength: word("strength").unwrap_or_else(|| "full".to_owned()),
            question: word("question"),
            laws: word("law").into_iter().chain(words("described_by")).collect(),
            faults: words("faults"),
            places: places
                .filter_map(|(effect, place)| Some((effect.clone(), place.as_str()?.to_owned())))
                .collect(),
            parameters: parameters.map(|(effect, values)| (effect.clone(), numbers(values))).collect(),
        })
    }

    /// What kind of question the case asks.
    pub fn class(&self) -> Class {
        if self.effects.iter().any(|name| name.starts_with(UNKNOWN)) {
            return Class::Outside;
        }
        match self.effects.len() {
            0 => Class::Null,
            1 => Class::Single,
            _ => Class::Pair,
        }
    }

    /// How it stands in the confusion matrix.
    pub fn label(&self) -> String {
        if self.effects.is_empty() { "none".to_owned() } else { self.effects.join(" + ") }
    }
}

fn numbers(values: &Value) -> BTreeMap<String, f64> {
    let values = values.as_object().into_iter().flatten();
    values.filter_map(|(name, value)| Some((name.clone(), value.as_f64()?))).collect()
}

/// What is asked of a diagnosis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Class {
    /// Nothing is hidden.
    Null,
    /// One effect of the catalogue.
    Single,
    /// Two or more.
    Pair,
    /// Something outside the catalogue.
    Outside,
}
