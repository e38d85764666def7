//! Carries the FMU library and writes FMUs.
//!
//! An FMU is a model file, the generic library, and what the model's variable table says in XML and
//! HTML. Writing one needs no compiler: the library is embedded in this crate.
//!
//! ```
//! let (name, model_toml) = stickslip_fmu_package::standard_models()[0];
//! let fmu = stickslip_fmu_package::write_fmu(name, model_toml)?;
//! assert!(fmu.starts_with(b"PK"));
//! # Ok::<(), stickslip_fmu_package::Error>(())
//! ```

mod documentation;
mod extras;
mod figure;
mod stamp;
mod systems;
mod units;
mod version;
mod xml;
mod xml3;

pub use documentation::documentation_html;
pub use extras::terminals_and_icons_xml;
pub use stamp::Stamp;
pub use systems::{standard_systems, write_system, write_system_of};
pub use version::FmiVersion;
pub use xml::model_description_xml;
pub use xml3::model_description_xml3;

use std::io::{Cursor, Read, Write};
use stickslip::fmi::Instance;
use stickslip::model::Model;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipArchive, ZipWriter};

/// Why an FMU cannot be written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// Not a C identifier of up to 64 characters: importers make file and function names of it.
    #[error("{0:?} cannot be a model identifier: letters, digits and _ only, no digit first, at most 64")]
    Identifier(String),
    /// No line of text.
    #[error("{0:?} cannot be an author: one line of text")]
    Author(String),
    /// No date that FMI knows.
    #[error("{0:?} is no date: as 2026-12-01T10:30:00Z, in UTC")]
    Date(String),
    /// No standard system of this name.
    #[error("there is no standard system `{0}`")]
    UnknownSystem(String),
    /// The model file.
    #[error(transparent)]
    Model(#[from] stickslip::fmi::Error),
    /// Bytes that are no whole FMU with a model in it.
    #[error("not a whole FMU written by stickslip: {0}")]
    Unreadable(String),
    /// The archive; only memory can run out.
    #[error("the archive cannot be written: {0}")]
    Archive(#[from] zip::result::ZipError),
    /// As `Archive`.
    #[error("the archive cannot be written: {0}")]
    Write(#[from] std::io::Error),
}

/// The generic shared library for one platform.
#[derive(Debug, Clone, Copy)]
pub struct Library {
    /// Its folder in `binaries/`: `linux64`, `win64`, `darwin64`, `aarch64-linux` ...
    pub platform: &'static str,
    /// Its file extension, without the dot.
    pub extension: &'static str,
    /// The file.
    pub bytes: &'static [u8],
}

/// What an FMU carries: the library for the platform this crate was built for, which stands first, and all others that
/// `cargo xtask dist` builds.
static LIBRARIES: &[Library] = &include!(concat!(env!("OUT_DIR"), "/libraries.rs"));

/// The libraries that every FMU carries, one for each platform.
///
/// ```
/// use stickslip_fmu_package::{libraries, library};
/// assert!(libraries().iter().any(|other| other.platform == library().platform));
/// ```
pub fn libraries() -> &'static [Library] {
    LIBRARIES
}

/// The library for the platform this crate was built for.
pub fn library() -> Library {
    LIBRARIES[0]
}

/// Names (which are model identifiers) and model files of the standard models.
pub fn standard_models() -> [(&'static str, &'static str); 8] {
    [
        ("JenkinsContact", include_str!("../../../modelDescription/JenkinsContact.toml")),
        ("ValanisContact", include_str!("../../../modelDescription/ValanisContact.toml")),
        ("SlipSlapContact", include_str!("../../../modelDescription/SlipSlapContact.toml")),
        ("ModalBeam", include_str!("../../../modelDescription/ModalBeam.toml")),
        ("ModalBeamTwoContacts", include_str!("../../../modelDescription/ModalBeamTwoContacts.toml")),
        ("FrictionalBeam", include_str!("../../../modelDescription/FrictionalBeam.toml")),
        ("PinnedBeam", include_str!("../../../modelDescription/PinnedBeam.toml")),
        ("SlipSlapBeam", include_str!("../../../modelDescription/SlipSlapBeam.toml")),
    ]
}

/// The bytes of an FMU of FMI 2.0 of the model in `model_toml`. The same arguments give the same bytes.
///
/// # Errors
/// A name that is no C identifier, or a text that is no model.
pub fn write_fmu(model_identifier: &str, model_toml: &str) -> Result<Vec<u8>, Error> {
    write_fmu_of(FmiVersion::Two, model_identifier, model_toml)
}

/// As [`write_fmu`], of either version of FMI: the same libraries, in other folders, under another description.
///
/// ```
/// use stickslip_fmu_package::{FmiVersion, standard_models, write_fmu_of};
/// let (name, model_toml) = standard_models()[0];
/// let fmu = write_fmu_of(FmiVersion::Three, name, model_toml)?;
/// assert!(fmu.starts_with(b"PK"));
/// # Ok::<(), stickslip_fmu_package::Error>(())
/// ```
///
/// # Errors
/// As [`write_fmu`].
pub fn write_fmu_of(version: FmiVersion, model_identifier: &str, model_toml: &str) -> Result<Vec<u8>, Error> {
    write_stamped_fmu(version, model_identifier, model_toml, &Stamp::default())
}

/// As [`write_fmu_of`], with an author and a date of one's own.
///
/// # Errors
/// As [`write_fmu`].
pub fn write_stamped_fmu(
    version: FmiVersion,
    model_identifier: &str,
    model_toml: &str,
    stamp: &Stamp,
) -> Result<Vec<u8>, Error> {
    check_identifier(model_identifier)?;
    let instance = Instance::new(model_toml)?;
    let description = instance.description();
    let model = Model::parse(model_toml).map_err(|error| stickslip::fmi::Error::Model(error.message))?;
    // A model that cannot be run over its default experiment has no reference results; everything else it has.
    let run = extras::Run::new(model_toml).ok();
    let mut entries: Vec<(String, Vec<u8>, u32)> = vec![
        (
            "modelDescription.xml".into(),
            version.model_description(model_identifier, description, stamp).into(),
            0o644,
        ),
        (MODEL_FILE.into(), model_toml.into(), 0o644),
        (
            "documentation/index.html".into(),
            documentation::page(
                version,
                model_identifier,
                description,
                model_toml,
                (Some(&model), run.as_ref()),
            )
            .into(),
            0o644,
        ),
        (
            "documentation/licenses/LICENSE-MIT.txt".into(),
            include_bytes!("../../../LICENSE-MIT").into(),
            0o644,
        ),
        (
            "documentation/licenses/LICENSE-APACHE.txt".into(),
            include_bytes!("../../../LICENSE-APACHE").into(),
            0o644,
        ),
    ];
    let extras = extras::files(description, &model, run.as_ref());
    entries.extend(extras.into_iter().map(|(name, content)| (name, content, 0o644)));
    for Library { platform, extension, bytes } in libraries() {
        let platform = version.platform(platform);
        entries.push((format!("binaries/{platform}/{model_identifier}.{extension}"), bytes.to_vec(), 0o755));
    }
    entries.sort_by(|left, right| left.0.cmp(&right.0));
    let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
    for (name, content, mode) in entries {
        // The default time is 1980-01-01: an FMU does not contain the time of its creation.
        let options = SimpleFileOptions::default()
            .compression_method(CompressionMethod::Deflated)
            .compression_level(Some(9))
            .last_modified_time(zip::DateTime::default())
            .unix_permissions(mode);
        archive.start_file(name, options)?;
        archive.write_all(&content)?;
    }
    Ok(archive.finish()?.into_inner())
}

/// The model file inside an FMU that this program exported.
///
/// # Errors
/// [`Error::Unreadable`] for bytes that are no whole FMU of ours.
///
/// ```
/// let (name, model_toml) = stickslip_fmu_package::standard_models()[0];
/// let fmu = stickslip_fmu_package::write_fmu(name, model_toml)?;
/// assert_eq!(stickslip_fmu_package::read_model_toml(&fmu)?, model_toml);
/// assert!(stickslip_fmu_package::read_model_toml(&fmu[..fmu.len() / 2]).is_err());
/// # Ok::<(), stickslip_fmu_package::Error>(())
/// ```
pub fn read_model_toml(fmu: &[u8]) -> Result<String, Error> {
    let mut archive =
        ZipArchive::new(Cursor::new(fmu)).map_err(|error| Error::Unreadable(error.to_string()))?;
    let mut text = String::new();
    let file =
        archive.by_name(MODEL_FILE).map_err(|error| Error::Unreadable(format!("{MODEL_FILE}: {error}")))?;
    // A model file has some kilobytes; an archive that unpacks to more than this is not ours.
    let length = file
        .take(LARGEST_MODEL + 1)
        .read_to_string(&mut text)
        .map_err(|error| Error::Unreadable(format!("{MODEL_FILE}: {error}")))?;
    if length as u64 > LARGEST_MODEL {
        return Err(Error::Unreadable(format!("{MODEL_FILE} has more than {LARGEST_MODEL} bytes")));
    }
    Ok(text)
}

/// Where an FMU carries its model.
const MODEL_FILE: &str = "resources/model.toml";
/// Bytes of a model file read from an FMU at most.
const LARGEST_MODEL: u64 = 1 << 20;

fn check_identifier(name: &str) -> Result<(), Error> {
    let legal = |character: char| character.is_ascii_alphanumeric() || character == '_';
    let first_is_digit = name.starts_with(|character: char| character.is_ascii_digit());
    if name.is_empty() || name.len() > 64 || first_is_digit || !name.chars().all(legal) {
        return Err(Error::Identifier(name.to_owned()));
    }
    Ok(())
}
