//! Time of a point of a response curve: the two masses with a Jenkins element, the beam with a frictional
//! support, and how it grows with harmonics, sliders and degrees of freedom.
//!
//! `cargo bench -p stickslip --bench harmonic` prints a table, with `-- --json` what
//! `benches/harmonic_balance.py` reads. Everything runs on one core. A curve is followed several times and
//! the fastest counts, since other load can only slow.

use std::f64::consts::{FRAC_PI_2, TAU};
use std::sync::Arc;
use std::time::{Duration, Instant};

use stickslip::contact::{ContactLaw, Iwan, IwanSpacing, Jenkins, Valanis};
use stickslip::harmonic::{Assembly, Control, CurveSettings, Ending, HarmonicError, frequency_response};
use stickslip::model::{Beam, Damping, Model, Structure};
use stickslip::system::{LinearStructure, ModalBeam, Output, Receptance};

const HARMONICS: usize = 21;

fn main() {
    let series = |sizes: &[usize], measure: &dyn Fn(usize) -> Measured| {
        let measured = |size: &usize| {
            eprint!(" {size}");
            (*size, measure(*size))
        };
        sizes.iter().map(measured).collect::<Vec<_>>()
    };
    let results = Results {
        two_masses: two_masses(jenkins(), HARMONICS),
        beam: beam(),
        by_harmonics: series(&[1, 3, 7, 15, 21, 41, 81, 161], &|harmonics| two_masses(jenkins(), harmonics)),
        by_sliders: series(&[1, 2, 4, 8, 16, 32, 64, 128, 256], &|sliders| {
            two_masses(parallel(sliders), HARMONICS)
        }),
        by_freedoms: series(&[2, 10, 30, 100, 300, 1000, 10_000], &rod),
    };
    if std::env::args().any(|argument| argument == "--json") { results.json() } else { results.table() }
}

/// What following a curve took.
struct Measured {
    points: usize,
    /// Of the whole curve.
    seconds: f64,
    /// Of what is prepared once for the structure.
    preparation: f64,
}

impl Measured {
    fn per_point(&self) -> f64 {
        self.seconds / self.points as f64
    }
}

/// Time (s) of the fastest of at least three runs in a second, fewer where they take longer than ten seconds.
fn fastest<T>(run: impl Fn() -> T) -> (T, f64) {
    let begun = Instant::now();
    let mut best = Duration::MAX;
    let mut runs = 0;
    loop {
        let start = Instant::now();
        let result = run();
        best = best.min(start.elapsed());
        runs += 1;
        let spent = begun.elapsed().as_secs_f64();
        if spent > 10.0 || runs >= 3 && spent > 1.0 {
            return (result, best.as_secs_f64());
        }
    }
}

fn follow(
    assembly: &Assembly,
    range: (f64, f64),
    control: &Control,
    settings: &CurveSettings,
) -> Result<Measured, HarmonicError> {
    let response = || frequency_response(assembly, range.0, range.1, control, settings, &mut |_| true);
    let (curve, seconds) = fastest(response);
    let curve = curve?;
    let reached = curve.points.last().map(|point| point.angular_frequency);
    assert_eq!(curve.ending, Ending::Complete, "the curve ends at {reached:?} rad/s");
    Ok(Measured { points: curve.points.len(), seconds, preparation: 0.0 })
}

const STIFFNESS: f64 = 0.2;
const FRICTION: f64 = 0.02;

fn jenkins() -> Jenkins {
    Jenkins::new(STIFFNESS, FRICTION).expect("a law")
}

/// Sliders that together are as stiff and as strong as the one.
fn parallel(count: usize) -> Iwan {
    Iwan::new(STIFFNESS, FRICTION, 0.0, 0.0, count, IwanSpacing::Equal).expect("a law")
}

/// The friction-vibration study from 0.2 to 2.0 rad/s under 0.4 N.
fn two_masses(law: impl ContactLaw + 'static, harmonics: usize) -> Measured {
    let structure = LinearStructure {
        size: 2,
        mass: vec![(0, 0, 1.0), (1, 1, 1.0)],
        damping: vec![(0, 0, 0.1), (1, 1, 0.1)],
        stiffness: vec![(0, 0, 1.5), (0, 1, -0.5), (1, 0, -0.5), (1, 1, 0.5)],
        contacts: vec![vec![(1, 1.0)]],
        excitation: vec![(0, 1.0)],
        outputs: vec![output("x", 0), output("y", 1)],
    };
    let assembly = Assembly::new(structure.system(vec![(Arc::new(law), 1.0)]));
    let settings = CurveSettings { harmonics, ..CurveSettings::default() };
    follow(&assembly, (0.2, 2.0), &Control::Level(0.4), &settings).expect("a curve")
}

fn output(name: &str, freedom: usize) -> Output {
    Output { name: name.into(), row: vec![(freedom, 1.0)] }
}

const BEAM_MODES: usize = 6;
const BEAM_HARMONICS: usize = 9;

/// The published beam from 45 to 56 Hz with 40 m/s² held at the exciter.
fn beam() -> Option<Measured> {
    let model = Model::parse(include_str!("../examples/frictional-support/published.toml")).expect("a model");
    let Structure::Beam(beam) = model.structure else { panic!("the example is a beam") };
    let beam = Beam { modes: BEAM_MODES, damping: Damping::Uniform(0.003), ..beam };
    let beam = ModalBeam::new(&beam).expect("a beam");
    let law = Valanis::from_lambda(7.9e6, 0.0, 0.3, 8.7e4, 147.15).expect("a law");
    let assembly = Assembly::new(beam.system(Some((Arc::new(law), 147.15))).expect("a system"));
    let settings = CurveSettings { harmonics: BEAM_HARMONICS, ..CurveSettings::default() };
    let held = Control::Held { node: 0, order: 1, derivative: 2, amplitude: 40.0 };
    let measured = follow(&assembly, (45.0 * TAU, 56.0 * TAU), &held, &settings);
    measured.inspect_err(|error| eprintln!("the beam is left out: {error}")).ok()
}

/// A fixed–free rod of 1 kg and 1 N/m, cut into `size` masses, with the element at its free end and the force
/// at the middle, about its first resonance.
fn rod(size: usize) -> Measured {
    let pieces = size as f64;
    let band = |factor: f64| {
        let mut entries = vec![];
        for i in 0..size {
            for j in i.saturating_sub(1)..(i + 2).min(size) {
                let diagonal = if i + 1 == size { factor } else { 2.0 * factor };
                entries.push((i, j, if i == j { diagonal } else { -factor }));
            }
        }
        entries
    };
    let structure = LinearStructure {
        size,
        mass: (0..size).map(|i| (i, i, 1.0 / pieces)).collect(),
        damping: band(0.02 * pieces),
        stiffness: band(pieces),
        contacts: vec![vec![(size - 1, 1.0)]],
        excitation: vec![(size / 2, 1.0)],
        outputs: vec![output("middle", size / 2), output("end", size - 1)],
    };
    let (_, preparation) = fastest(|| Receptance::new(&structure).expect("a receptance"));
    let assembly = Assembly::new(structure.system(vec![(Arc::new(jenkins()), 1.0)]));
    // The dynamic stiffness of a rod cut ever finer is ever nearer to singular, as size², and rounding in
    // its factors is what the balance can be met to: up to a thousand masses the default is.
    let strict = CurveSettings::default().tolerance;
    let tolerance = if size > 1000 { strict * (pieces / 300.0).powi(2) } else { strict };
    let settings =
        CurveSettings { harmonics: HARMONICS, tolerance, max_step: 0.05, ..CurveSettings::default() };
    let range = (0.8 * FRAC_PI_2, 1.3 * FRAC_PI_2);
    let curve = follow(&assembly, range, &Control::Level(0.05), &settings).expect("a curve");
    // Following the curve prepares the structure as well.
    Measured { preparation, seconds: (curve.seconds - preparation).max(0.0), ..curve }
}

/// Everything that is measured; the series by size.
struct Results {
    two_masses: Measured,
    /// `None` where the library cannot follow the beam.
    beam: Option<Measured>,
    by_harmonics: Vec<(usize, Measured)>,
    by_sliders: Vec<(usize, Measured)>,
    by_freedoms: Vec<(usize, Measured)>,
}

impl Results {
    fn json(&self) {
        let series = |key: &str, values: &[(usize, Measured)]| {
            let entry = |(size, measured): &(usize, Measured)| {
                let preparation = if measured.preparation > 0.0 {
                    format!(r#""preparation_seconds": {:e}, "#, measured.preparation)
                } else {
                    String::new()
                };
                let per_point = measured.per_point();
                format!(r#"{{"{key}": {size}, {preparation}"seconds_per_point": {per_point:e}}}"#)
            };
            values.iter().map(entry).collect::<Vec<_>>().join(", ")
        };
        let (points, per_point) = (self.two_masses.points, self.two_masses.per_point());
        println!(
            r#"{{"seed3": {{"points": {points}, "seconds_per_point": {per_point:e}, "harmonics": {HARMONICS}}},"#
        );
        if let Some(beam) = &self.beam {
            let per_point = beam.per_point();
            println!(
                r#" "beam": {{"harmonics": {BEAM_HARMONICS}, "modes": {BEAM_MODES}, "seconds_per_point": {per_point:e}}},"#
            );
        }
        println!(r#" "by_harmonics": [{}],"#, series("harmonics", &self.by_harmonics));
        println!(r#" "by_sliders": [{}],"#, series("sliders", &self.by_sliders));
        println!(r#" "by_degrees_of_freedom": [{}]}}"#, series("degrees_of_freedom", &self.by_freedoms));
    }

    fn table(&self) {
        let line = |what: &str, measured: &Measured| {
            let (points, per_point) = (measured.points, 1e6 * measured.per_point());
            let preparation = 1e6 * measured.preparation;
            println!(
                "{what:<36} {points:>6} points {per_point:>12.2} µs a point {preparation:>12.1} µs before"
            );
        };
        line(&format!("two masses, {HARMONICS} harmonics"), &self.two_masses);
        if let Some(beam) = &self.beam {
            line(&format!("beam, {BEAM_MODES} modes, {BEAM_HARMONICS} harmonics"), beam);
        }
        for (size, measured) in &self.by_harmonics {
            line(&format!("two masses, {size} harmonics"), measured);
        }
        for (size, measured) in &self.by_sliders {
            line(&format!("two masses, {size} sliders"), measured);
        }
        for (size, measured) in &self.by_freedoms {
            line(&format!("rod of {size} degrees of freedom"), measured);
        }
    }
}
