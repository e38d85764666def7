//! The rig of the paper on slip and slap, with what the paper leaves open as the reference values have it.

use std::sync::Arc;

use stickslip::contact::{NormalDirection, NormalLaw, ParallelSliders, SlipSlap};
use stickslip::system::{Beam, Damping, HangingString, ModalPinRig, Pin, PinRig, PointMass, Port, System};

/// E = 200 GPa, three accelerometers of 5 g and a transducer of 20 g, a steel pin of r = 6 mm, 7 kg on a stiff string
/// whose mass is a point.
pub fn rig() -> PinRig {
    let mass = |position, mass| PointMass { position, mass };
    let beam = Beam {
        length: 0.6,
        width: 0.04,
        thickness: 0.005,
        density: 7850.0,
        youngs_modulus: 200e9,
        modes: 20,
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
        string: HangingString { stiffness: 1e6, length: 0.3, mass: 7.0, inertia: 0.0 },
        stuck_stiffness: [3.95e6, 2.37e7],
        beam,
    }
}

/// With a softer string and a hanging mass that turns.
pub fn soft_string() -> PinRig {
    let mut rig = rig();
    rig.string.stiffness = 1e5;
    rig.string.inertia = 0.005;
    rig
}

/// As [`soft_string`], E = 215 GPa: model B of the reference values.
pub fn model_b() -> PinRig {
    let mut rig = soft_string();
    rig.beam.youngs_modulus = 215e9;
    rig
}

/// A contact of ten sliders of the rig's tangential stiffness that yield evenly one after the other, μ = 0.6, on Hertz'
/// law with p = 1.5 under the rig's preload, λ = 30 s/m.
pub fn contact(rig: &PinRig) -> Arc<SlipSlap> {
    let [tangential, normal] = rig.stuck_stiffness;
    let slider = |place: usize| (tangential / 10.0, 0.06 * (2.0 * place as f64 + 1.0) / 10.0);
    let sliders: Vec<(f64, f64)> = (0..10).map(slider).collect();
    let normal =
        NormalDirection::new(NormalLaw::Hertz { exponent: 1.5 }, rig.preload(), normal, 30.0).unwrap();
    Arc::new(SlipSlap::new(Arc::new(ParallelSliders::new(&sliders).unwrap()), normal))
}

/// `rig` with its contact, its modes read by sensors of their own after those of the rig.
pub fn observed(rig: &PinRig) -> System {
    let mut system = ModalPinRig::new(rig).unwrap().system(Some(contact(rig)));
    for mode in 0..rig.beam.modes {
        system.sensors.push(system.ports.len());
        system.ports.push(Port::linear(&format!("mode {}", mode + 1), vec![(mode, 1.0)]));
    }
    system
}
