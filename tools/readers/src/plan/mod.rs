//! `PLAN.toml`: tests on a virtual rig, and the model they are made on.
//!
//! `sensors`: the chain of sensors. `tests`: one function per kind of test. `value`: numbers in bounds.

mod sensors;
mod tests;
mod value;

use std::path::{Path, PathBuf};

use stickslip::document::{Document, DocumentError, Table};
use stickslip::model::Model;
use stickslip::rig::{Plan, Test};

use crate::error::{InputError, Problem};
use crate::source::Source;

const SCHEMA: &str = "stickslip.rig/1";

/// A plan, ready to be carried out.
#[derive(Debug, Clone, PartialEq)]
pub struct RigPlan {
    /// `title` of the plan, if any.
    pub title: Option<String>,
    /// The model's file.
    pub model_file: PathBuf,
    /// The model.
    pub model: Model,
    /// Sensors and tests.
    pub plan: Plan,
    /// Whether the dataset is to say what the accelerometers weigh.
    pub masses_told: bool,
}

/// Reads a plan and the model file that it names, beside it.
///
/// # Errors
/// The first thing wrong with either file: a file that cannot be read or is not UTF-8, an unknown key, a value of the wrong
/// type or out of its bounds, a model that is no beam, a test that cannot be made.
///
/// ```
/// let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../examples/frictional-support/rig.toml");
/// let read = stickslip_readers::read_plan(path)?;
/// assert_eq!(read.plan.sensors.len(), 3);
/// # Ok::<(), stickslip_readers::InputError>(())
/// ```
pub fn read_plan(path: impl AsRef<Path>) -> Result<RigPlan, InputError> {
    let source = Source::read(path.as_ref())?;
    let at = |error| source.document_error(error);
    let document = Document::parse(source.text()).map_err(at)?;
    let root = document.root();
    check_top(&root).map_err(at)?;
    let title = root.string("title").map_err(at)?.map(|title| title.value.to_owned());
    let named = root.required_string("model").map_err(at)?;
    let model_file = path.as_ref().parent().unwrap_or(Path::new("")).join(named.value);
    let model = match std::fs::read(&model_file) {
        Ok(bytes) => {
            let model = Source::from_bytes(&model_file, bytes)?;
            Model::parse(model.text()).map_err(|error| model.document_error(error))?
        }
        Err(error) => {
            // The mistake is in the line that names the file.
            let what = format!("`{}`", named.value);
            return Err(source.error(named.span, Problem::Unreadable { what, reason: error.to_string() }));
        }
    };
    let Some(beam) = model.structure.beam() else {
        return Err(at(named
            .error("the model has no beam")
            .with_help("a rig tests a model of kind \"beam\" or \"pin_rig\"")));
    };
    let (mut plan, masses_told) = sensors::read(&root, beam).map_err(at)?;
    plan.tests = read_tests(&root, &model).map_err(at)?;
    Ok(RigPlan { title, model_file, model, plan, masses_told })
}

fn check_top(root: &Table<'_>) -> Result<(), DocumentError> {
    let first_line = || format!("a plan needs schema = \"{SCHEMA}\"");
    let schema = root.required_string("schema").map_err(|error| error.with_help(first_line()))?;
    if schema.value != SCHEMA {
        let message = format!("schema \"{}\" is not one this version reads", schema.value);
        return Err(schema.error(message).with_help(first_line()));
    }
    root.allow(&[&["schema", "title", "model", "sensors"][..], &tests::KINDS].concat())
}

/// All tests in the file's order, whatever their kinds.
fn read_tests(root: &Table<'_>, model: &Model) -> Result<Vec<Test>, DocumentError> {
    let mut found: Vec<(usize, Test)> = Vec::new();
    for kind in tests::KINDS {
        let tables = root.tables(kind)?.unwrap_or_default();
        for (index, table) in tables.iter().enumerate() {
            let number = (tables.len() > 1).then_some(index + 1);
            let test = tests::read(table, kind, number)?;
            let refused =
                |error: stickslip::rig::RigError| DocumentError::new(error.to_string(), table.span());
            test.check().and_then(|()| test.kind.check_on(model)).map_err(refused)?;
            if found.iter().any(|(_, other)| other.name == test.name) {
                let message = format!("two tests are called \"{}\"", test.name);
                return Err(DocumentError::new(message, table.span_of("name").or(table.span())));
            }
            found.push((table.span().map_or(0, |span| span.start), test));
        }
    }
    if found.is_empty() {
        let help = "add at least one [[stepped_sine]], [[dual_mode]], [[random]] or [[ring_down]]";
        return Err(DocumentError::new("the plan has no test", None).with_help(help));
    }
    found.sort_by_key(|(place, _)| *place);
    Ok(found.into_iter().map(|(_, test)| test).collect())
}
