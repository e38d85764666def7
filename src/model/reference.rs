//! The keys of model files as the parser itself holds them, for pages of reference and for tests of templates.

use super::parse::{BEAM_KEYS, COMMON_CONTACT_KEYS, SUPPORT_KEYS, TABLES};
use super::{normal, oscillator, pin_rig};
use crate::contact::LAWS;
use crate::effects::CATALOGUE;
use crate::vocabulary::{self, Quantity};

/// A table of a model file.
///
/// ```
/// let beam = stickslip::model::reference().into_iter().find(|table| table.name == "beam").unwrap();
/// assert_eq!(beam.kinds, ["beam", "pin_rig"]);
/// let length = beam.keys.iter().find(|key| key.name == "length").unwrap();
/// assert_eq!(length.quantity.unwrap().unit, "m");
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct ReferenceTable {
    /// Its name in the file; of a law or an effect with that: `contact, law = "valanis"`.
    pub name: String,
    /// The kinds of models that have it.
    pub kinds: Vec<&'static str>,
    /// Its keys.
    pub keys: Vec<ReferenceKey>,
}

/// A key of a table.
#[derive(Debug, Clone, PartialEq)]
pub struct ReferenceKey {
    /// Its name in the file.
    pub name: &'static str,
    /// What it holds: unit, bounds and one line; `None` for names, lists and tables.
    pub quantity: Option<&'static Quantity>,
    /// What it is where nothing is written, if it may be left out.
    pub default: Option<f64>,
}

fn keys(names: &[&'static str]) -> Vec<ReferenceKey> {
    names.iter().map(|name| ReferenceKey { name, quantity: vocabulary::find(name), default: None }).collect()
}

/// All tables, in the order in which a file has them.
pub fn reference() -> Vec<ReferenceTable> {
    let kinds = |table: &str| -> Vec<&'static str> {
        let owners = TABLES.iter().find(|(name, _)| *name == table);
        owners.map_or(super::parse::KINDS.to_vec(), |(_, owners)| owners.to_vec())
    };
    let table = |name: &str, names: &[&'static str]| ReferenceTable {
        name: name.to_owned(),
        kinds: kinds(name),
        keys: keys(names),
    };
    let mut all = vec![
        table("beam", &BEAM_KEYS),
        ReferenceTable { name: "beam.point_mass".into(), ..table("beam", &["position", "mass"]) },
        table("pin", &pin_rig::PIN_KEYS),
        table("string", &pin_rig::STRING_KEYS),
        table("support", &SUPPORT_KEYS),
        table("mass", &oscillator::MASS_KEYS),
        table("spring", &oscillator::SPRING_KEYS),
        table("excitation", &["at", "position"]),
        table("sensor", &["position"]),
        table("contact_point", &["position"]),
        table("contact", &COMMON_CONTACT_KEYS),
        ReferenceTable {
            name: "contact in two directions".into(),
            kinds: vec!["contact", "pin_rig"],
            keys: keys(&normal::KEYS),
        },
    ];
    all.extend(LAWS.iter().map(|law| {
        ReferenceTable {
            name: format!("contact, law = \"{}\"", law.name),
            kinds: kinds("contact"),
            keys: law
                .parameters
                .iter()
                .map(|one| ReferenceKey {
                    name: one.quantity.name,
                    quantity: Some(one.quantity),
                    default: one.default,
                })
                .collect(),
        }
    }));
    all.extend(CATALOGUE.iter().map(|effect| {
        ReferenceTable {
            name: format!("effect, id = \"{}\"", effect.id),
            kinds: effect.kinds.iter().map(|kind| kind.name()).collect(),
            keys: effect
                .parameters
                .iter()
                .map(|one| ReferenceKey {
                    name: one.quantity.name,
                    quantity: Some(one.quantity),
                    default: None,
                })
                .collect(),
        }
    }));
    all.push(table("fit", &["free"]));
    all
}
