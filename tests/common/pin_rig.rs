//! The rig of the paper on slip and slap, with what the paper leaves open as the reference values have it.

use stickslip::system::{Beam, Damping, HangingString, Pin, PinRig, PointMass};

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
