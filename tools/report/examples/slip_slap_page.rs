//! The figures of "Identifying slip-slap forces in the contact interface using dual-mode excitation", from records of the virtual
//! rig, as a page: `cargo run --release -p stickslip-report --example slip_slap_page -- slip-slap.html [exact]`. The measuring
//! chain has gains 1 % off and noise of 0.1 %; with `exact` it has no fault, and the identification is told so.

use std::error::Error;

use stickslip::data::{Dataset, Record};
use stickslip::identify::{IdentifyOptions, ModeCount, identify_slip_slap};
use stickslip::rig::{
    Chain, ChannelFault, DualMode, NoiseLevel, RigError, dual_mode_on, separation_on, slap_in_time,
};
use stickslip::system::{ModalPinRig, PinRig, System};
use stickslip_report::Settings;
use stickslip_report::slip_slap::{SlipSlapReport, slip_slap_html, slip_slap_table};

#[path = "../../../tests/common/pin_rig.rs"]
#[allow(dead_code, reason = "the tests use more of it")]
mod pin_rig;
use pin_rig::{contact, model_b};

const SENSORS: [f64; 3] = [0.55, 0.3, 0.05];
const LEVELS: [[f64; 2]; 3] = [[14.0, 34.0], [17.5, 42.5], [20.0, 50.0]];
/// Modes of the identification; the simulation has 20.
const MODES: usize = 30;
/// The preload of the slap, as a part of that at which the pin begins to leave its support.
const BELOW: f64 = 0.8;

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let file = arguments.next().unwrap_or_else(|| "slip-slap.html".to_owned());
    let part = if arguments.next().as_deref() == Some("exact") { 0.0 } else { 0.01 };
    let rig = model_b();
    let test = DualMode::at(52.0, LEVELS.to_vec());
    let tested = dual_mode_on(&system(&rig)?, &SENSORS, &chain(part), &test)?;
    let records = tested.iter().map(|tested| tested.record.clone()).collect();
    let options = IdentifyOptions {
        excitation_gain: part,
        sensor_gain: part,
        modes: ModeCount::Fixed(MODES),
        ..IdentifyOptions::default()
    };
    let found = identify_slip_slap(&rig, &Dataset { title: None, records }, &options)?;
    let separation = separation_on(&under, rig.preload(), &test)?;
    let last = separation.last().ok_or("no level")?;
    let preload = BELOW * last.onset.ok_or("the pin does not part")?;
    let slap = slap_in_time(&under(preload)?, last.forces, &test, 10)?;
    let truth: Vec<Record> = tested.into_iter().filter_map(|tested| tested.contact).collect();
    let report = SlipSlapReport {
        notes: &[],
        title: "Slip and slap of a pin under dual-mode excitation, from the virtual rig".to_owned(),
        found: &found,
        truth: &truth,
        separation: &separation,
        slap: Some(&slap),
    };
    print!("{}", slip_slap_table(&report, 120, false));
    let settings = Settings {
        command: format!("cargo run --release -p stickslip-report --example slip_slap_page -- {file}"),
        version: env!("CARGO_PKG_VERSION").to_owned(),
        ..Settings::default()
    };
    std::fs::write(file, slip_slap_html(&report, &settings))?;
    Ok(())
}

/// A chain whose gains scatter by this part, with noise of a tenth of it.
fn chain(part: f64) -> Chain {
    let fault = ChannelFault { noise: NoiseLevel::Fraction(0.1 * part), ..ChannelFault::default() };
    Chain {
        excitation: fault,
        accelerometers: vec![fault; SENSORS.len()],
        gain_scatter: part,
        seed: 1,
        noise_told: true,
    }
}

fn system(rig: &PinRig) -> Result<System, RigError> {
    let modal = ModalPinRig::new(rig).map_err(|error| RigError::Input(error.to_string()))?;
    Ok(modal.system(Some(contact(rig))))
}

/// The rig under another preload: Hertz' law makes the contact softer where less presses on it.
fn under(preload: f64) -> Result<System, RigError> {
    let mut rig = model_b();
    let part = preload / rig.preload();
    rig.string.mass *= part;
    rig.stuck_stiffness[1] *= part.cbrt();
    system(&rig)
}
