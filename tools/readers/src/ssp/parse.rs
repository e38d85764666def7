//! From the XML of a description to a [`SystemStructure`].

use std::path::{Component as Part, Path, PathBuf};

use super::flatten::Flat;
use super::known::check_known;
use super::{SspProblem, SystemStructure, parameters};
use crate::archive::Unpacked;
use crate::error::InputError;
use crate::units::{Linear, read_units};
use crate::xml::{Element, XmlFile};

/// Where the files are that a description names.
pub(super) struct Files {
    /// The description's folder.
    pub folder: PathBuf,
    /// The description as the user knows it.
    pub named: PathBuf,
    /// Whether all must be inside the folder.
    pub closed: bool,
}

/// Reads the description in `file`.
pub(super) fn structure(
    file: &XmlFile,
    files: &Files,
    folder: Option<Unpacked>,
) -> Result<SystemStructure, InputError> {
    let root = file.root("SystemStructureDescription")?;
    check_version(file, root)?;
    let mut remarks = Vec::new();
    check_known(file, root, &mut remarks)?;
    let units = read_units(file, root.list("Units", "Unit"))?;
    let system = file.required_child(root, "System")?;
    let flat = Flat::new(file, files, system, &units)?;
    let mut parameters = Vec::new();
    parameters::bindings(&flat, root, system, &mut parameters, &mut remarks)?;
    let experiment = root.child("DefaultExperiment");
    let time = |name: &str| experiment.map_or(Ok(None), |element| file.number(element, name));
    let (start, stop) = (time("startTime")?, time("stopTime")?);
    let (inputs, outputs) = (flat.inputs()?, flat.outputs(&mut remarks)?);
    Ok(SystemStructure {
        name: file.required(root, "name")?.to_owned(),
        connections: flat.connections(&mut remarks)?,
        inputs,
        outputs,
        parameters,
        start,
        stop,
        components: flat.components,
        remarks,
        _folder: folder,
    })
}

/// Versions 1.x are the same as 1.0 with additions.
pub(super) fn check_version(file: &XmlFile, root: &Element) -> Result<(), InputError> {
    let version = file.required(root, "version")?;
    if version.starts_with("1.") {
        return Ok(());
    }
    Err(file.error(root, SspProblem::Version(version.to_owned())))
}

/// The transformation in `element`, a connection or an entry of a mapping; whether it is one of truths.
pub(super) fn transformation(file: &XmlFile, element: &Element) -> Result<(Linear, bool), InputError> {
    for child in element.children() {
        match child.name() {
            "LinearTransformation" => {
                let factor = file.number(child, "factor")?.unwrap_or(1.0);
                let offset = file.number(child, "offset")?.unwrap_or(0.0);
                return Ok((Linear { factor, offset }, false));
            }
            "BooleanMappingTransformation" => return Ok((boolean_mapping(file, child)?, true)),
            "IntegerMappingTransformation" | "EnumerationMappingTransformation" => {
                let what = format!("elements {child}");
                return Err(file.error(child, SspProblem::Unsupported(what)));
            }
            _ => {}
        }
    }
    Ok((Linear::IDENTITY, false))
}

/// On 0 and 1, any mapping is linear.
fn boolean_mapping(file: &XmlFile, element: &Element) -> Result<Linear, InputError> {
    let mut of = [0.0, 1.0];
    for entry in element.all("MapEntry") {
        let source = file.boolean(entry, "source")?;
        let target = file.boolean(entry, "target")?;
        match (source, target) {
            (Some(source), Some(target)) => of[usize::from(source)] = f64::from(u8::from(target)),
            (None, _) => {
                return Err(file.required(entry, "source").err().unwrap_or_else(|| unreadable(file, entry)));
            }
            _ => return Err(file.required(entry, "target").err().unwrap_or_else(|| unreadable(file, entry))),
        }
    }
    Ok(Linear { factor: of[1] - of[0], offset: of[0] })
}

fn unreadable(file: &XmlFile, entry: &Element) -> InputError {
    file.value_error(entry, "source", "true or false")
}

/// The file that `uri` names.
pub(super) fn resolve(
    files: &Files,
    file: &XmlFile,
    element: &Element,
    uri: &str,
) -> Result<PathBuf, InputError> {
    let failed = |reason: &str| {
        let problem = SspProblem::Source { source_uri: uri.to_owned(), reason: reason.to_owned() };
        file.error(element, problem)
    };
    if element.attribute("sourceBase") == Some("component") {
        return Err(file.error(element, SspProblem::Unsupported("sources inside of components".to_owned())));
    }
    let bare = match uri.split_once(':') {
        Some(("file", rest)) => rest.strip_prefix("//").unwrap_or(rest),
        // One letter is a drive of Windows.
        Some((scheme, _)) if scheme.len() > 1 && !scheme.contains('/') => {
            return Err(failed("only files are read, no network"));
        }
        _ => uri,
    };
    let path = PathBuf::from(decoded(bare));
    if files.closed && escapes(&path) {
        return Err(failed("it is outside of the package"));
    }
    let whole = files.folder.join(path);
    if whole.is_file() { Ok(whole) } else { Err(failed("there is no such file")) }
}

fn escapes(path: &Path) -> bool {
    let mut depth = 0_usize;
    for part in path.components() {
        match part {
            Part::Normal(_) => depth += 1,
            Part::CurDir => {}
            Part::ParentDir if depth > 0 => depth -= 1,
            _ => return true,
        }
    }
    false
}

/// A URI with its escapes resolved.
fn decoded(uri: &str) -> String {
    let mut bytes = Vec::with_capacity(uri.len());
    let mut rest = uri.as_bytes();
    while let Some((&first, after)) = rest.split_first() {
        let code = after.get(..2).and_then(|code| std::str::from_utf8(code).ok());
        match code.and_then(|code| u8::from_str_radix(code, 16).ok()) {
            Some(byte) if first == b'%' => {
                bytes.push(byte);
                rest = &after[2..];
            }
            _ => {
                bytes.push(first);
                rest = after;
            }
        }
    }
    String::from_utf8(bytes).unwrap_or_else(|_| uri.to_owned())
}
