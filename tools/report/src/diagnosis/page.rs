//! The HTML page of a diagnosis.

use stickslip::diagnose::Diagnosis;

use super::Run;
use crate::Settings;

/// One self-contained HTML page.
pub fn diagnosis_html(diagnosis: &Diagnosis, _run: &Run, settings: &Settings) -> String {
    crate::html(&diagnosis.comparison, settings)
}
