//! A beam with a pin that slips and slaps on its support: forces in both directions while two harmonics of the
//! acceleration are held, and what natural frequencies tell of the contact.
//!
//! `cargo run --release -p stickslip --example slip_slap`

use std::error::Error;
use std::f64::consts::TAU;
use std::sync::Arc;

use stickslip::contact::{NormalDirection, NormalLaw, ParallelSliders, SlipSlap};
use stickslip::harmonic::fourier::value;
use stickslip::harmonic::{Assembly, CurveSettings, HeldTone, dual_tone_response};
use stickslip::identify::{MeasuredFrequencies, beam_frequencies, contact_stiffness};
use stickslip::system::{Beam, Damping, HangingString, ModalPinRig, Pin, PinRig, PointMass};

/// The published rig: 7 kg press the pin on its support. What the paper leaves open is assumed.
fn rig() -> PinRig {
    let mass = |position, mass| PointMass { position, mass };
    let beam = Beam {
        length: 0.6,
        width: 0.04,
        thickness: 0.005,
        density: 7850.0,
        youngs_modulus: 215e9,
        modes: 20, // fewer miss the normal direction: 12 make its force 20 % too large
        static_correction: false,
        damping: Damping::Uniform(0.003),
        point_masses: vec![mass(0.55, 0.025), mass(0.3, 0.005), mass(0.05, 0.005)],
        offset: 0.006,
        rotational_stiffness: 0.0,
        clamp_stiffness: None,
        excitation_position: 0.55,
        sensors: vec![],
        contact_points: vec![],
    };
    PinRig {
        pin: Pin::solid(0.006, beam.width, 7850.0),
        string: HangingString { stiffness: 1e5, length: 0.3, mass: 7.0, inertia: 0.005 },
        stuck_stiffness: [3.95e6, 2.37e7],
        beam,
    }
}

/// Ten sliders that yield one after the other, under Hertz' normal force with Hunt and Crossley's damping.
fn contact(rig: &PinRig) -> Result<SlipSlap, Box<dyn Error>> {
    let [tangential, normal] = rig.stuck_stiffness;
    let slider = |place: usize| (tangential / 10.0, 0.06 * (2.0 * place as f64 + 1.0) / 10.0);
    let sliders: Vec<(f64, f64)> = (0..10).map(slider).collect();
    let normal = NormalDirection::new(NormalLaw::Hertz { exponent: 1.5 }, rig.preload(), normal, 30.0)?;
    Ok(SlipSlap::new(Arc::new(ParallelSliders::new(&sliders)?), normal))
}

fn main() -> Result<(), Box<dyn Error>> {
    let rig = rig();
    let assembly = Assembly::new(ModalPinRig::new(&rig)?.system(Some(Arc::new(contact(&rig)?))));
    let driven = assembly.nodes().len() - 1;
    let settings = CurveSettings { harmonics: 15, ..CurveSettings::default() };
    println!("  a1     a3 (m/s²)    F1     F3 (N)      S (N)        least N_c (N)");
    for (first, third) in [(14.0, 34.0), (17.5, 42.5), (20.0, 50.0)] {
        let tone = |order, amplitude| HeldTone { order, amplitude, phase: 0.0 };
        let held =
            dual_tone_response(&assembly, TAU * 52.0, driven, [tone(1, first), tone(3, third)], &settings)?;
        let range = |coefficients: &[f64]| {
            let values = (0..1024).map(|k| value(coefficients, TAU * f64::from(k) / 1024.0));
            values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)))
        };
        let contacts = &held.point.contacts;
        let ((low, high), (_, lift)) = (range(&contacts[0].force), range(&contacts[1].force));
        let [f1, f3] = held.force;
        let least = rig.preload() - lift;
        println!("{first:5.1}  {third:5.1}        {f1:5.3}  {f3:5.3}   {low:6.1} … {high:4.1}   {least:6.1}");
    }
    // Frequencies to 0.05 % and Young's modulus to 0.5 %: k_t is known, k_n is not.
    let frequencies = beam_frequencies(&rig, 3)?;
    let measured = MeasuredFrequencies { frequencies, deviation: 5e-4, modulus_deviation: 5e-3 };
    let found = contact_stiffness(&rig, &measured)?;
    for (name, estimate) in [("k_t", found.tangential), ("k_n", found.normal)] {
        println!("{name} between {:.3e} and {:.3e} N/m", estimate.interval.low, estimate.interval.high);
    }
    Ok(())
}
