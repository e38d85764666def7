//! What an FMU has beside its description, its model and its libraries: terminals with icons (`terminals`), and
//! reference results (`reference`). From the variable table alone, for every version of FMI.

mod reference;
pub(crate) mod terminals;

pub use reference::Run;
pub use terminals::terminals_and_icons_xml;

use stickslip::fmi::Description;
use stickslip::model::{Model, Structure};

/// A drawing, which `icons/draw.py` makes.
struct Icon {
    svg: &'static [u8],
    png: &'static [u8],
}

macro_rules! icon {
    ($name:literal) => {
        Icon {
            svg: include_bytes!(concat!("../../icons/", $name, ".svg")),
            png: include_bytes!(concat!("../../icons/", $name, ".png")),
        }
    };
}

const CONTACT: Icon = icon!("contact");
const BEAM: Icon = icon!("beam");
const OSCILLATOR: Icon = icon!("oscillator");
const FLANGE: Icon = icon!("flange");

/// Files of an FMU by their places in it; `run` has the reference results, if the model can be run.
pub fn files(description: &Description, model: &Model, run: Option<&Run>) -> Vec<(String, Vec<u8>)> {
    let icon = match model.structure {
        Structure::Prescribed => CONTACT,
        Structure::Beam(_) | Structure::PinRig(_) => BEAM,
        Structure::Oscillator(_) => OSCILLATOR,
    };
    let mut files = vec![
        (
            "terminalsAndIcons/terminalsAndIcons.xml".to_owned(),
            terminals_and_icons_xml(description).into_bytes(),
        ),
        // Where FMI 2.0 itself looks for a picture.
        ("model.png".to_owned(), icon.png.to_vec()),
        ("terminalsAndIcons/icon.png".to_owned(), icon.png.to_vec()),
        ("terminalsAndIcons/icon.svg".to_owned(), icon.svg.to_vec()),
    ];
    if !terminals::terminals(description).is_empty() {
        files.push((format!("terminalsAndIcons/{}.png", terminals::ICON), FLANGE.png.to_vec()));
        files.push((format!("terminalsAndIcons/{}.svg", terminals::ICON), FLANGE.svg.to_vec()));
    }
    if let Some(run) = run {
        files.extend(run.files(description));
    }
    files
}
