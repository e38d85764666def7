//! Beams the tests share.

use stickslip::model::{Beam, Damping, PointMass};

/// A steel strip of 600 × 40 × 5 mm, clamped and pinned, without masses.
pub fn bare() -> Beam {
    Beam {
        length: 0.6,
        width: 0.04,
        thickness: 0.005,
        density: 7850.0,
        youngs_modulus: 197e9,
        modes: 6,
        static_correction: false,
        damping: Damping::Uniform(0.003),
        point_masses: Vec::new(),
        offset: 0.006,
        rotational_stiffness: 0.0,
        clamp_stiffness: None,
        excitation_position: 0.55,
        sensors: vec![0.55, 0.3, 0.1],
        contact_points: vec![],
    }
}

/// The strip with two unequal masses.
pub fn steel() -> Beam {
    let point_masses =
        vec![PointMass { position: 0.2, mass: 0.05 }, PointMass { position: 0.47, mass: 0.12 }];
    Beam { point_masses, ..bare() }
}

/// The beam of "Nonlinear model identification of a frictional contact support" (MSSP, received 2009):
/// accelerometers at 550, 300 and 100 mm and a force transducer at 550 mm. The paper gives neither the
/// masses nor E; these are assumed.
pub fn frictional_support(rotational_stiffness: f64) -> Beam {
    let point_masses = vec![
        PointMass { position: 0.55, mass: 0.02515 },
        PointMass { position: 0.3, mass: 0.005 },
        PointMass { position: 0.1, mass: 0.005 },
    ];
    Beam { youngs_modulus: 197.1e9, point_masses, rotational_stiffness, ..bare() }
}

/// EI (N m²).
pub fn bending_stiffness(beam: &Beam) -> f64 {
    beam.youngs_modulus * beam.width * beam.thickness.powi(3) / 12.0
}

/// ρAL (kg).
pub fn mass_of(beam: &Beam) -> f64 {
    beam.density * beam.width * beam.thickness * beam.length
}

/// √(EI/ρA)/L² (rad/s).
pub fn frequency_scale(beam: &Beam) -> f64 {
    (bending_stiffness(beam) / (mass_of(beam) * beam.length.powi(3))).sqrt()
}

/// Root of a function with one sign change, by halving.
pub fn bisect(function: impl Fn(f64) -> f64, mut low: f64, mut high: f64) -> f64 {
    assert!(function(low) * function(high) < 0.0, "no sign change in [{low}, {high}]");
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        if function(low) * function(middle) <= 0.0 { high = middle } else { low = middle }
    }
    0.5 * (low + high)
}
