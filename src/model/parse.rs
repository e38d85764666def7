//! From the text of a `model.toml` to a [`Model`], every error with its bytes.

use super::{
    Beam, Contact, Damping, Law, Model, ModelError, PointMass, SCHEMA, Structure, effects, normal,
    oscillator, pin_rig,
};
use crate::contact::{LAWS, LawKind, LawParameter};
use crate::document::{Document, Numbers, Table, suggestion};
use crate::vocabulary as v;

pub(super) const KINDS: [&str; 4] = ["contact", "beam", "oscillator", "pin_rig"];
pub(super) const COMMON_CONTACT_KEYS: [&str; 5] =
    ["law", "tangential_stiffness", "friction_coefficient", "normal_load", "normal_stiffness"];
pub(super) const BEAM_KEYS: [&str; 11] = [
    "length",
    "width",
    "thickness",
    "density",
    "youngs_modulus",
    "modes",
    "static_correction",
    "damping_ratio",
    "mass_damping",
    "stiffness_damping",
    "point_mass",
];
pub(super) const SUPPORT_KEYS: [&str; 3] =
    [v::OFFSET.name, v::ROTATIONAL_STIFFNESS.name, v::CLAMP_STIFFNESS.name];

impl Model {
    /// Reads the text of a model file.
    ///
    /// # Errors
    /// The first thing wrong, with its bytes: text that is not TOML, another schema, a kind or law this
    /// version does not know, an unknown key, a missing one, a value of the wrong type, and everything
    /// [`Model::check`] refuses.
    ///
    /// ```
    /// use stickslip::model::Model;
    /// let text = r#"
    ///     schema = "stickslip.model/1"
    ///     kind = "contact"
    ///     contact = { law = "jenkins", tangential_stiffness = 2e3, friction_coefficient = 0.1, normal_load = 10.0 }
    /// "#;
    /// assert_eq!(Model::parse(text)?.get("contact.normal_load"), Some(10.0));
    /// let misspelt = text.replace("jenkins", "jenkyns");
    /// assert!(Model::parse(&misspelt).unwrap_err().to_string().contains("jenkyns"));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn parse(text: &str) -> Result<Model, ModelError> {
        let document = Document::parse(text)?;
        let root = document.root();
        check_schema(&root)?;
        let kind = root.required_string("kind").map_err(|error| with_list(error, "kinds", &KINDS))?;
        let structure = match kind.value {
            "contact" => {
                refuse_foreign_tables(&root, kind.value)?;
                root.allow(&["schema", "kind", "contact", "effect", "fit"])?;
                Structure::Prescribed
            }
            "beam" => {
                refuse_foreign_tables(&root, kind.value)?;
                let keys =
                    ["beam", "support", "excitation", "sensor", "contact_point", "contact", "effect", "fit"];
                root.allow(&[&["schema", "kind"][..], &keys[..]].concat())?;
                Structure::Beam(beam(&root, &BEAM_KEYS, &SUPPORT_KEYS)?)
            }
            "pin_rig" => {
                refuse_foreign_tables(&root, kind.value)?;
                let keys =
                    ["beam", "pin", "string", "support", "excitation", "sensor", "contact", "effect", "fit"];
                root.allow(&[&["schema", "kind"][..], &keys[..]].concat())?;
                let keys: Vec<&str> =
                    BEAM_KEYS.into_iter().filter(|key| *key != "static_correction").collect();
                let beam = beam(&root, &keys, &[v::CLAMP_STIFFNESS.name])?;
                Structure::PinRig(pin_rig::parse(&root, beam)?)
            }
            "oscillator" => {
                refuse_foreign_tables(&root, kind.value)?;
                root.allow(&["schema", "kind", "mass", "spring", "excitation", "contact", "effect", "fit"])?;
                Structure::Oscillator(oscillator::parse(&root)?)
            }
            other => {
                return Err(kind
                    .error(format!("unknown kind \"{other}\""))
                    .with_help(suggestion(other, &KINDS, "kinds")));
            }
        };
        let contact = root.table("contact")?.map(|table| contact(&table, &structure)).transpose()?;
        let free = match root.table("fit")? {
            None => None,
            Some(fit) => {
                fit.allow(&["free"])?;
                fit.strings("free")?
                    .map(|patterns| patterns.into_iter().map(|pattern| pattern.value.to_owned()).collect())
            }
        };
        let mut model = Model { structure, contact, effects: Vec::new(), free };
        model.effects = effects::parse(&root, model.kind())?;
        model.check().map_err(|error| ModelError {
            span: root.locate(&error.path),
            message: error.message,
            help: error.help,
        })?;
        Ok(model)
    }
}

fn with_list(error: ModelError, what: &str, names: &[&str]) -> ModelError {
    let list = names.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ");
    if error.help.is_some() { error } else { error.with_help(format!("legal {what}: {list}")) }
}

fn check_schema(root: &Table<'_>) -> Result<(), ModelError> {
    let first_line = || format!("a model file needs schema = \"{SCHEMA}\"");
    let schema = root.required_string("schema").map_err(|error| error.with_help(first_line()))?;
    if schema.value == SCHEMA {
        return Ok(());
    }
    let message = format!("schema \"{}\" is not one this version reads", schema.value);
    Err(schema.error(message).with_help(first_line()))
}

/// The tables that not every kind has, with the kinds that have them.
pub(super) const TABLES: [(&str, &[&str]); 9] = [
    ("beam", &["beam", "pin_rig"]),
    ("support", &["beam", "pin_rig"]),
    ("sensor", &["beam", "pin_rig"]),
    ("contact_point", &["beam"]),
    ("pin", &["pin_rig"]),
    ("string", &["pin_rig"]),
    ("excitation", &["beam", "oscillator", "pin_rig"]),
    ("mass", &["oscillator"]),
    ("spring", &["oscillator"]),
];

fn refuse_foreign_tables(root: &Table<'_>, kind: &str) -> Result<(), ModelError> {
    for key in root.keys() {
        let Some((_, owners)) = TABLES.iter().find(|(table, _)| *table == key.value) else { continue };
        if !owners.contains(&kind) {
            let message = format!("[{}] does not belong to a model of kind \"{kind}\"", key.value);
            let owners = owners.iter().map(|owner| format!("kind = \"{owner}\"")).collect::<Vec<_>>();
            return Err(key.error(message).with_help(format!("it belongs to {}", owners.join(" or "))));
        }
    }
    Ok(())
}

fn contact(table: &Table<'_>, structure: &Structure) -> Result<Contact, ModelError> {
    // An oscillator's contact says where it is.
    let mut keys = COMMON_CONTACT_KEYS.to_vec();
    match structure {
        Structure::Prescribed | Structure::PinRig(_) => keys.extend(normal::KEYS),
        Structure::Oscillator(_) => keys.push("at"),
        Structure::Beam(_) => {}
    }
    let names: Vec<&str> = LAWS.iter().map(|kind| kind.name).collect();
    let name = table.required_string("law").map_err(|error| with_list(error, "laws", &names))?;
    let kind = LawKind::find(name.value).ok_or_else(|| {
        let message = format!("unknown law \"{}\"", name.value);
        name.error(message).with_help(suggestion(name.value, &names, "laws"))
    })?;
    refuse_keys_of_other_laws(table, kind)?;
    keys.extend(kind.parameters.iter().map(|parameter| parameter.quantity.name));
    table.allow(&keys)?;
    let own = kind.parameters.iter().map(|LawParameter { quantity, default, .. }| match default {
        None => table.quantity(quantity),
        Some(default) => Ok(table.number(quantity.name)?.map_or(*default, |number| number.value)),
    });
    let own: Vec<f64> = own.collect::<Result<_, _>>()?;
    let law = Law::new(kind, &own).ok_or_else(|| name.error("a law of too many parameters"))?;
    Ok(Contact {
        law,
        tangential_stiffness: table.quantity(&v::TANGENTIAL_STIFFNESS)?,
        friction_coefficient: table.quantity(&v::FRICTION_COEFFICIENT)?,
        normal_load: match structure {
            // The rig knows what presses its pin on the support.
            Structure::PinRig(pinned) => {
                table.number(v::NORMAL_LOAD.name)?.map_or_else(|| pinned.weight(), |load| load.value)
            }
            _ => table.quantity(&v::NORMAL_LOAD)?,
        },
        normal_stiffness: match structure {
            // The pin rests on it.
            Structure::PinRig(_) => table.quantity(&v::NORMAL_STIFFNESS)?,
            _ => table.number(v::NORMAL_STIFFNESS.name)?.map_or(0.0, |stiffness| stiffness.value),
        },
        normal: normal::parse(table)?,
    })
}

/// Refuses a key of one law at another, with the name of its law.
fn refuse_keys_of_other_laws(table: &Table<'_>, law: &LawKind) -> Result<(), ModelError> {
    for key in table.keys().iter().filter(|key| law.parameter(key.value).is_none()) {
        let owners: Vec<String> = LAWS
            .iter()
            .filter(|kind| kind.parameter(key.value).is_some())
            .map(|kind| format!("law = \"{}\"", kind.name))
            .collect();
        if !owners.is_empty() {
            let message = format!("`{}` does not belong to law = \"{}\"", key.value, law.name);
            return Err(key.error(message).with_help(format!("it belongs to {}", owners.join(" or "))));
        }
    }
    Ok(())
}

/// The beam of a structure whose `[beam]` and `[support]` have these keys.
fn beam(root: &Table<'_>, keys: &[&str], support_keys: &[&str]) -> Result<Beam, ModelError> {
    let table = root.table("beam")?.ok_or_else(|| root.missing("beam"))?;
    table.allow(keys)?;
    let point_masses = table.tables("point_mass")?.unwrap_or_default();
    let point_masses = point_masses.iter().map(point_mass).collect::<Result<Vec<_>, _>>()?;
    let sensors = match root.tables("sensor")? {
        None => point_masses.iter().map(|mass| mass.position).collect(),
        Some(sensors) => sensors.iter().map(position).collect::<Result<_, _>>()?,
    };
    let contact_points = root.tables("contact_point")?.unwrap_or_default();
    let excitation = root.table("excitation")?.ok_or_else(|| root.missing("excitation"))?;
    let support = root.table("support")?;
    if let Some(support) = &support {
        support.allow(support_keys)?;
    }
    let spring = |name: &str| match &support {
        Some(support) => Ok(support.number(name)?.map(|stiffness| stiffness.value)),
        None => Ok(None),
    };
    Ok(Beam {
        length: table.quantity(&v::LENGTH)?,
        width: table.quantity(&v::WIDTH)?,
        thickness: table.quantity(&v::THICKNESS)?,
        density: table.quantity(&v::DENSITY)?,
        youngs_modulus: table.quantity(&v::YOUNGS_MODULUS)?,
        modes: modes(&table)?,
        static_correction: table.boolean("static_correction")?.is_some_and(|flag| flag.value),
        damping: damping(&table)?,
        point_masses,
        offset: match support_keys.contains(&v::OFFSET.name) {
            true => offset(root, support.as_ref())?,
            false => 0.0,
        },
        rotational_stiffness: spring(v::ROTATIONAL_STIFFNESS.name)?.unwrap_or(0.0),
        clamp_stiffness: spring(v::CLAMP_STIFFNESS.name)?,
        excitation_position: position(&excitation)?,
        sensors,
        contact_points: contact_points.iter().map(position).collect::<Result<_, _>>()?,
    })
}

/// The contact acts through the offset: without a contact it may be left out.
fn offset(root: &Table<'_>, support: Option<&Table<'_>>) -> Result<f64, ModelError> {
    let has_contact = root.span_of("contact").is_some();
    match support {
        Some(support) if has_contact => support.quantity(&v::OFFSET),
        Some(support) => Ok(support.number(v::OFFSET.name)?.map_or(0.0, |offset| offset.value)),
        None if has_contact => {
            Err(root.missing("support").with_help("the contact acts through [support] offset"))
        }
        None => Ok(0.0),
    }
}

fn modes(table: &Table<'_>) -> Result<usize, ModelError> {
    let modes = table.required_number("modes")?;
    if modes.value.fract() != 0.0 || modes.value < 0.0 {
        return Err(modes.error(format!("`modes` must be a whole number, not {}", modes.value)));
    }
    // A number beyond the range saturates and is refused with the bounds.
    Ok(modes.value as usize)
}

fn damping(table: &Table<'_>) -> Result<Damping, ModelError> {
    let mass = table.number(v::MASS_DAMPING.name)?;
    let stiffness = table.number(v::STIFFNESS_DAMPING.name)?;
    let ratio = table.number_or_numbers(v::DAMPING_RATIO.name)?;
    match (ratio, mass, stiffness) {
        (Some(Numbers::One(ratio)), None, None) => Ok(Damping::Uniform(ratio)),
        (Some(Numbers::Many(ratios)), None, None) => Ok(Damping::PerMode(ratios)),
        (Some(_), _, _) => {
            let span = table.span_of(v::DAMPING_RATIO.name);
            Err(ModelError::new("`damping_ratio` excludes `mass_damping` and `stiffness_damping`", span)
                .with_help("give the damping in one form only"))
        }
        (None, None, None) => Err(table
            .missing(v::DAMPING_RATIO.name)
            .with_help("give `damping_ratio`, or `mass_damping` [1/s] and `stiffness_damping` [s]")),
        (None, mass, stiffness) => Ok(Damping::Proportional {
            mass: mass.map_or(0.0, |mass| mass.value),
            stiffness: stiffness.map_or(0.0, |stiffness| stiffness.value),
        }),
    }
}

fn point_mass(table: &Table<'_>) -> Result<PointMass, ModelError> {
    table.allow(&["position", "mass"])?;
    Ok(PointMass { position: table.quantity(&v::POSITION)?, mass: table.quantity(&v::MASS)? })
}

fn position(table: &Table<'_>) -> Result<f64, ModelError> {
    table.allow(&["position"])?;
    table.quantity(&v::POSITION)
}
