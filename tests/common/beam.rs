//! Beams the tests share.

use std::f64::consts::TAU;

use stickslip::harmonic::{Assembly, Control, CurveSettings, HarmonicError, Point, periodic_response};
use stickslip::model::{Beam, Damping, PointMass};
use stickslip::system::{ModalBeam, Sensor, System};

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

/// That beam without a spring at its pin, in modes.
pub fn published(modes: usize) -> ModalBeam {
    ModalBeam::new(&Beam { modes, ..frictional_support(0.0) }).unwrap()
}

/// Modes with these numbers, without shortening, flexibility and sensors.
pub fn modal(omega: &[f64], zeta: &[f64], contact: &[f64], excitation: &[f64]) -> ModalBeam {
    ModalBeam {
        angular_frequency: omega.to_vec(),
        damping_ratio: zeta.to_vec(),
        contact_shape: contact.to_vec(),
        excitation_shape: excitation.to_vec(),
        shortening: vec![0.0; omega.len() * omega.len()],
        axial_flexibility: 0.0,
        stretching_stiffness: 0.0,
        hung: Vec::new(),
        quadratic_damping: 0.0,
        sensors: Vec::new(),
        contact_points: Vec::new(),
    }
}

/// Response of `system` to the force with the Fourier coefficients `excitation` (N) and the period `period` (s).
pub fn forced_response(
    system: System,
    period: f64,
    excitation: &[f64],
    settings: &CurveSettings,
) -> Result<Point, HarmonicError> {
    let assembly = Assembly { waveform: excitation.to_vec(), ..Assembly::new(system) };
    periodic_response(&assembly, TAU / period, &Control::Level(1.0), settings, None)
}

/// A beam with one mode.
pub fn one_mode(omega: f64, zeta: f64, contact: f64, excitation: f64, flexibility: f64) -> ModalBeam {
    ModalBeam {
        axial_flexibility: flexibility,
        sensors: vec![Sensor { position: 0.0, shape: vec![1.0] }],
        ..modal(&[omega], &[zeta], &[contact], &[excitation])
    }
}

/// The analytic modes of a clamped–pinned steel beam, 600 × 40 × 5 mm, pin radius 6 mm.
pub fn steel_beam(modes: usize, zeta: f64) -> ModalBeam {
    let (length, area, radius) = (0.6, 0.04 * 0.005, 0.006);
    let (modulus, density) = (197e9, 7850.0);
    let inertia = 0.04 * 0.005_f64.powi(3) / 12.0;
    let shapes: Vec<Shape> = (1..=modes).map(|n| Shape::new(n, length, density * area)).collect();
    let sensor = |x: f64| Sensor { position: x, shape: shapes.iter().map(|s| s.at(x).0).collect() };
    let points = 4000;
    let slopes: Vec<Vec<f64>> = shapes
        .iter()
        .map(|s| (0..=points).map(|i| s.at(length * i as f64 / points as f64).1).collect())
        .collect();
    let simpson = |a: &[f64], b: &[f64]| -> f64 {
        let weight = |i: usize| if i == 0 || i == points { 1.0 } else { 2.0 + 2.0 * (i % 2) as f64 };
        (0..=points).map(|i| weight(i) * a[i] * b[i]).sum::<f64>() * length / (3 * points) as f64
    };
    let shortening = (0..modes * modes).map(|ij| simpson(&slopes[ij / modes], &slopes[ij % modes])).collect();
    let scale = (modulus * inertia / (density * area)).sqrt();
    let each = |value: &dyn Fn(&Shape) -> f64| -> Vec<f64> { shapes.iter().map(value).collect() };
    let omega = each(&|s| s.wave_number.powi(2) * scale);
    let (contact, excitation) = (each(&|s| radius * s.at(length).1), each(&|s| s.at(0.55).0));
    ModalBeam {
        shortening,
        axial_flexibility: length / (modulus * area),
        sensors: vec![sensor(0.55), sensor(0.3), sensor(0.1)],
        ..modal(&omega, &vec![zeta; modes], &contact, &excitation)
    }
}

/// A clamped–pinned mode, written so that nothing cancels for high modes.
struct Shape {
    wave_number: f64,
    /// 1 − σ
    rest: f64,
    scale: f64,
}

impl Shape {
    fn new(number: usize, length: f64, mass_per_length: f64) -> Self {
        // tan y = tanh y
        let mut y = (number as f64 + 0.25) * std::f64::consts::PI;
        for _ in 0..50 {
            y = (number as f64) * std::f64::consts::PI + y.tanh().atan();
        }
        let small = (-2.0 * y).exp();
        let rest = (-(-y).exp() + y.cos() * 2.0 * small / (1.0 + small)) / (y.sinh() - y.sin());
        Self { wave_number: y / length, rest, scale: 1.0 / (mass_per_length * length).sqrt() }
    }

    /// Value and slope.
    fn at(&self, position: f64) -> (f64, f64) {
        let x = self.wave_number * position;
        let (growing, falling) = (0.5 * self.rest * x.exp(), (1.0 - 0.5 * self.rest) * (-x).exp());
        let sigma = 1.0 - self.rest;
        let value = growing + falling - x.cos() + sigma * x.sin();
        let slope = growing - falling + x.sin() + sigma * x.cos();
        (self.scale * value, self.scale * self.wave_number * slope)
    }
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
