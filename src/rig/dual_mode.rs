//! Two harmonics of the motion at the shaker held at once, on a system that any builder made.

use std::f64::consts::TAU;

use super::chain::Chain;
use super::error::RigError;
use super::measured::{ContactSamples, Measured, NormalSamples};
use super::plan::Accelerometer;
use super::spoiler::Spoiler;
use super::tested::Tested;
use crate::data::Regime;
use crate::harmonic::{Assembly, CurveSettings, DualTone, HarmonicError, HeldTone, dual_tone_response};
use crate::numeric::fourier::{time_derivative, value};
use crate::system::{Element, System};

/// A dual-mode test: the force `F₁ sin ωt + F₃ sin 3ωt` holds both harmonics of the acceleration where it acts.
#[derive(Debug, Clone, PartialEq)]
pub struct DualMode {
    /// Amplitudes of the first and the third harmonic (m/s²), a pair for each record.
    pub amplitudes: Vec<[f64; 2]>,
    /// Frequency of the first (Hz).
    pub frequency: f64,
    /// Highest harmonic of the motion.
    pub harmonics: usize,
    /// Periods recorded.
    pub periods: usize,
    /// Samples of a period.
    pub samples_per_period: usize,
}

impl DualMode {
    /// Pairs of amplitudes (m/s²) at a frequency (Hz): 60 harmonics, as with 15 the normal direction of a pin rig is 2 % off; 8 periods of
    /// 256 samples.
    pub fn at(frequency: f64, amplitudes: Vec<[f64; 2]>) -> Self {
        Self { amplitudes, frequency, harmonics: 60, periods: 8, samples_per_period: 256 }
    }
}

/// The records of `test` on `system`, of which accelerometers are at `positions` (m), as `chain` shows them, and what its
/// contact truly did: the normal displacement of its record closes the contact where it is positive.
///
/// # Errors
/// [`RigError`]: numbers that make no test, a position without a sensor's port, amplitudes out of reach.
///
/// ```
/// use stickslip::rig::{Chain, DualMode, dual_mode_on};
/// # use std::sync::Arc;
/// # use stickslip::contact::{Jenkins, NormalDirection, NormalLaw, SlipSlap};
/// # use stickslip::system::{Beam, Damping, HangingString, ModalPinRig, Pin, PinRig, PointMass};
/// # let beam = Beam {
/// #     length: 0.6, width: 0.04, thickness: 0.005, density: 7850.0, youngs_modulus: 215e9, modes: 8,
/// #     static_correction: false, damping: Damping::Uniform(0.003),
/// #     point_masses: vec![PointMass { position: 0.55, mass: 0.025 }], offset: 0.006,
/// #     rotational_stiffness: 0.0, clamp_stiffness: None, excitation_position: 0.55, sensors: vec![],
/// #     contact_points: vec![],
/// # };
/// # let rig = PinRig {
/// #     pin: Pin::solid(0.006, beam.width, 7850.0),
/// #     string: HangingString { stiffness: 1e5, length: 0.3, mass: 7.0, inertia: 0.005 },
/// #     stuck_stiffness: [3.95e6, 2.37e7],
/// #     beam,
/// # };
/// # let normal = NormalDirection::new(NormalLaw::Hertz { exponent: 1.5 }, rig.preload(), 2.37e7, 30.0)?;
/// # let contact = Arc::new(SlipSlap::new(Arc::new(Jenkins::new(3.95e6, 0.6)?), normal));
/// // `rig` is a `PinRig`, `contact` what slips and slaps.
/// let system = ModalPinRig::new(&rig)?.system(Some(contact));
/// let test = DualMode { harmonics: 5, ..DualMode::at(52.0, vec![[1.0, 2.0]]) };
/// let tested = dual_mode_on(&system, &[0.55], &Chain::default(), &test)?;
/// let truth = tested[0].contact.as_ref().unwrap();
/// assert!(truth.channel("normal_load").unwrap().values.iter().all(|load| *load > 0.0));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn dual_mode_on(
    system: &System,
    positions: &[f64],
    chain: &Chain,
    test: &DualMode,
) -> Result<Vec<Tested>, RigError> {
    let samples = test.periods * test.samples_per_period;
    if test.amplitudes.is_empty() || samples < 2 {
        return Err(RigError::Input("a dual-mode test needs amplitudes and samples".into()));
    }
    let assembly = Assembly::new(read_at(system, positions)?);
    let sensors: Vec<Accelerometer> =
        positions.iter().map(|position| Accelerometer { position: *position, mass: 0.0 }).collect();
    chain.check(sensors.len())?;
    let spoiler = Spoiler::new(chain, &sensors);
    let width = test.amplitudes.len().to_string().len();
    let record = |(number, amplitudes): (usize, &[f64; 2])| {
        let name = format!("dual-mode-{:0width$}.csv", number + 1);
        let made = measured(&assembly, test, *amplitudes, spoiler.delays());
        let made = made.map_err(|error| error.of_record(&name))?;
        Ok(spoiler.tested(&name, Regime::Steady, None, made, number as u64))
    };
    test.amplitudes.iter().enumerate().map(record).collect()
}

/// The system with sensors at `positions` (m) alone.
fn read_at(system: &System, positions: &[f64]) -> Result<System, RigError> {
    let place = |position: &f64| {
        let name = format!("x={position}");
        system.port(&name).ok_or_else(|| RigError::Input(format!("the system has no port `{name}`")))
    };
    let sensors = positions.iter().map(place).collect::<Result<_, _>>()?;
    Ok(System { sensors, ..system.clone() })
}

/// The steady state in which both harmonics of the acceleration have these amplitudes (m/s²).
pub(super) fn held(
    assembly: &Assembly,
    test: &DualMode,
    amplitudes: [f64; 2],
) -> Result<DualTone, HarmonicError> {
    let tones = [(1, amplitudes[0]), (3, amplitudes[1])];
    let tones = tones.map(|(order, amplitude)| HeldTone { order, amplitude, phase: 0.0 });
    let settings = CurveSettings { harmonics: test.harmonics, ..CurveSettings::default() };
    // After the sensors comes the port driven.
    let driven = assembly.system.sensors.len();
    dual_tone_response(assembly, TAU * test.frequency, driven, tones, &settings)
}

/// Coefficients of the force with tones of these amplitudes (N).
pub(super) fn tones([first, third]: [f64; 2]) -> [f64; 7] {
    [0.0, 0.0, first, 0.0, 0.0, 0.0, third]
}

/// The record of a test at one pair of amplitudes (m/s²).
pub(super) fn measured(
    assembly: &Assembly,
    test: &DualMode,
    amplitudes: [f64; 2],
    delays: &[f64],
) -> Result<Measured, RigError> {
    let sensors = assembly.system.sensors.len();
    let DualTone { point, force } = held(assembly, test, amplitudes)?;
    let speed = point.angular_frequency;
    let step = TAU / speed / test.samples_per_period as f64;
    let sampled = |coefficients: &[f64], delay: f64| -> Vec<f64> {
        let phase = |k: usize| TAU * k as f64 / test.samples_per_period as f64 - speed * delay;
        let period: Vec<f64> = (0..test.samples_per_period).map(|k| value(coefficients, phase(k))).collect();
        period.repeat(test.periods)
    };
    let accelerations = point.nodes.iter().take(sensors).zip(&delays[1..]);
    let accelerations = accelerations.map(|(u, delay)| sampled(&time_derivative(u, 2, speed), *delay));
    let preload = assembly.system.elements.iter().find_map(|element| match element {
        Element::SlipSlap { contact, .. } => Some(contact.normal().preload()),
        _ => None,
    });
    let negative = |list: &[f64]| list.iter().map(|x| -x).collect::<Vec<_>>();
    let contact = point.contacts.first().map(|tangential| ContactSamples {
        displacement: sampled(&tangential.displacement, 0.0),
        velocity: sampled(&time_derivative(&tangential.displacement, 1, speed), 0.0),
        force: sampled(&tangential.force, 0.0),
        normal: preload.zip(point.contacts.get(1)).map(|(preload, normal)| NormalSamples {
            displacement: sampled(&negative(&normal.displacement), 0.0),
            // Above zero, also where the series of the force rings.
            load: sampled(&normal.force, 0.0).into_iter().map(|force| (preload - force).max(0.0)).collect(),
        }),
    });
    Ok(Measured {
        time: (0..test.periods * test.samples_per_period).map(|k| k as f64 * step).collect(),
        excitation: Some(sampled(&tones(force), delays[0])),
        accelerations: accelerations.collect(),
        contact,
    })
}
