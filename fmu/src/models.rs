//! The models that this library has read, so that many instances of one cost its parsing once.
//!
//! A model is known by the importer's GUID and resource location. The GUID is a hash of all that a model is: whoever
//! asks for it again is given the model that its description tells of, whatever stands in the file by now. Nothing of
//! an instance is kept here.

use crate::location;
use std::collections::VecDeque;
use std::ffi::CStr;
use std::sync::{Mutex, PoisonError};
use stickslip::fmi::Template;

/// Models that are kept: more than any system has of different ones that are instantiated in turn; some 10 kB each.
const KEPT: usize = 8;

struct Known {
    guid: Box<CStr>,
    location: Box<CStr>,
    template: Template,
}

static KNOWN: Mutex<VecDeque<Known>> = Mutex::new(VecDeque::new());

/// The model in the directory `location` (a URI or a path), which must have `guid`; messages call that `identity`.
///
/// # Errors
/// No such file, no model in it, or another one; in words.
pub fn template(guid: &CStr, location: &CStr, identity: &str) -> Result<Template, String> {
    if let Some(template) = known(guid, location) {
        return Ok(template);
    }
    let template = read(guid, location, identity)?;
    let new = Known { guid: guid.into(), location: location.into(), template: template.clone() };
    // What it pushes out is dropped after the lock is free.
    let mut models = KNOWN.lock().unwrap_or_else(PoisonError::into_inner);
    let old = if models.len() >= KEPT { models.pop_front() } else { None };
    models.push_back(new);
    drop(models);
    drop(old);
    Ok(template)
}

fn known(guid: &CStr, location: &CStr) -> Option<Template> {
    let models = KNOWN.lock().unwrap_or_else(PoisonError::into_inner);
    let model = models.iter().rev().find(|model| *model.guid == *guid && *model.location == *location)?;
    Some(model.template.clone())
}

fn read(guid: &CStr, location: &CStr, identity: &str) -> Result<Template, String> {
    let guid = guid.to_string_lossy();
    let file = location::directory(location.to_bytes())?.join("model.toml");
    let text = std::fs::read_to_string(&file)
        .map_err(|error| format!("{} cannot be read: {error}", file.display()))?;
    let template = Template::parse(&text).map_err(|error| format!("{}: {error}", file.display()))?;
    let expected = template.guid().to_string();
    let given = guid.strip_prefix('{').and_then(|rest| rest.strip_suffix('}')).unwrap_or(&guid);
    if !given.eq_ignore_ascii_case(&expected) {
        return Err(format!("the {identity} is {guid}, but {} has {{{expected}}}", file.display()));
    }
    Ok(template)
}
