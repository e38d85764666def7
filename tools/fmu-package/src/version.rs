//! The versions of FMI that FMUs are written for.

use std::borrow::Cow;
use stickslip::fmi::Description;

use crate::Stamp;
use crate::xml::stamped_xml;
use crate::xml3::stamped_xml3;

/// A version of FMI. Both are in every library; an FMU is of one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum FmiVersion {
    /// FMI 2.0.
    #[default]
    Two,
    /// FMI 3.0.
    Three,
}

impl FmiVersion {
    /// As the description has it.
    ///
    /// ```
    /// assert_eq!(stickslip_fmu_package::FmiVersion::Three.number(), "3.0");
    /// ```
    pub fn number(self) -> &'static str {
        match self {
            Self::Two => "2.0",
            Self::Three => "3.0",
        }
    }

    /// `modelDescription.xml`.
    pub(crate) fn model_description(
        self,
        model_identifier: &str,
        description: &Description,
        stamp: &Stamp,
    ) -> String {
        match self {
            Self::Two => stamped_xml(model_identifier, description, stamp),
            Self::Three => stamped_xml3(model_identifier, description, stamp),
        }
    }

    /// The folder in `binaries/` of a platform that FMI 2.0 calls `platform`.
    ///
    /// ```
    /// use stickslip_fmu_package::FmiVersion;
    /// assert_eq!(FmiVersion::Two.platform("win64"), "win64");
    /// assert_eq!(FmiVersion::Three.platform("win64"), "x86_64-windows");
    /// assert_eq!(FmiVersion::Three.platform("aarch64-linux"), "aarch64-linux");
    /// ```
    pub fn platform(self, platform: &str) -> Cow<'_, str> {
        let systems = [("linux", "linux"), ("win", "windows"), ("darwin", "darwin")];
        let of_two = systems.into_iter().find_map(|(short, system)| {
            let architecture = match platform.strip_prefix(short)? {
                "64" => "x86_64",
                "32" => "x86",
                _ => return None,
            };
            Some(format!("{architecture}-{system}"))
        });
        match (self, of_two) {
            (Self::Three, Some(platform)) => Cow::Owned(platform),
            _ => Cow::Borrowed(platform),
        }
    }
}
