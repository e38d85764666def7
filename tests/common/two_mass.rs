//! Two masses in a row on springs, a contact on the second, the excitation on the first.

use stickslip::contact::{ContactLaw, Jenkins};
use stickslip::harmonic::{Assembly, Body, CurveSettings, LoadedContact};
use stickslip::system::{LinearStructure, Output};

/// The structure with its law.
pub struct TwoMass {
    pub structure: LinearStructure,
    pub law: Box<dyn ContactLaw>,
    pub normal_load: f64,
}

impl Default for TwoMass {
    fn default() -> Self {
        Self::with(Jenkins::new(0.2, 0.02).unwrap())
    }
}

impl TwoMass {
    pub fn with(law: impl ContactLaw + 'static) -> Self {
        Self { structure: structure(), law: Box::new(law), normal_load: 1.0 }
    }

    pub fn assembly(&self) -> Assembly<'_> {
        let contact = LoadedContact { law: self.law.as_ref(), normal_load: self.normal_load };
        Assembly::new(Body::Linear(&self.structure), vec![contact])
    }
}

/// k1 = 1, k2 = 0.5, c = 0.1 and m = 1 of both.
pub fn structure() -> LinearStructure {
    LinearStructure {
        size: 2,
        mass: vec![(0, 0, 1.0), (1, 1, 1.0)],
        damping: vec![(0, 0, 0.1), (1, 1, 0.1)],
        stiffness: vec![(0, 0, 1.5), (0, 1, -0.5), (1, 0, -0.5), (1, 1, 0.5)],
        contacts: vec![vec![(1, 1.0)]],
        excitation: vec![(0, 1.0)],
        outputs: vec![
            Output { name: "x".into(), row: vec![(0, 1.0)] },
            Output { name: "y".into(), row: vec![(1, 1.0)] },
        ],
    }
}

pub fn settings(harmonics: usize) -> CurveSettings {
    CurveSettings { harmonics, ..CurveSettings::default() }
}

/// Energy the dampers of both masses take per cycle (J).
pub fn viscous_energy(point: &stickslip::harmonic::Point) -> f64 {
    let mut sum = 0.0;
    for node in &point.nodes {
        for (k, pair) in node[1..].chunks_exact(2).enumerate() {
            sum += ((k + 1) * (k + 1)) as f64 * (pair[0] * pair[0] + pair[1] * pair[1]);
        }
    }
    std::f64::consts::PI * 0.1 * point.angular_frequency * sum
}
