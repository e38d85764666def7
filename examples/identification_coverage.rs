//! How often the truth lies in the 95 % intervals of an identification: records of the virtual rig, all noise and all gains drawn
//! anew for every seed. Writes a line per seed to `target/identification-coverage-….csv`, goes on where it was stopped, and
//! writes the table of all that is there to `benches/identification-coverage.md`. One core.
//!
//! `cargo run --release -p stickslip --example identification_coverage [SEEDS [CASE]]`, the case `gains` or `gains-and-masses` alone.

use std::collections::BTreeMap;
use std::error::Error;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use stickslip::data::{Dataset, Record};
use stickslip::identify::{ContactPeriod, IdentifyOptions, harmonics, identify};
use stickslip::model::Model;
use stickslip::rig::{
    Chain, ChannelFault, Frequencies, NoiseLevel, Plan, SteppedSine, Test, TestKind, Tested,
    test_with_truth_on,
};

const SENSORS: [f64; 3] = [0.55, 0.3, 0.1];
const LEVELS: [f64; 3] = [25.0, 45.0, 70.0];
const NOISE: f64 = 0.01;
const GAINS: f64 = 0.01;
/// Standard errors of a 95 % interval.
const WIDE: f64 = 1.96;

/// What is wrong with the rig: name, standard deviation of masses that the model does not know (kg).
const CASES: [(&str, f64); 2] = [("gains", 0.0), ("gains and masses", 0.001)];

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let seeds: u64 = arguments.next().map_or(Ok(200), |count| count.parse())?;
    let only = arguments.next();
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let model = Model::parse(&fs::read_to_string(root.join("examples/frictional-support/published.toml"))?)?;
    let mut page = String::from(
        "# Coverage of the 95 % intervals of `identify`\n\nWritten by `cargo run --release -p stickslip --example \
         identification_coverage [SEEDS [CASE]]`. Datasets of the virtual rig, three levels each, noise of 1 % of every channel (told), gains \
         drawn with a standard deviation of 1 %; in the second column masses at the sensors, too, of 1 g. Counted is how often the \
         truth lies inside; the goal is 90 to 99 %. `normal` are 1.96 standard errors of every coefficient of a contact's period but \
         the mean.\n\n| quantity |",
    );
    let mut columns = Vec::new();
    for (name, masses) in CASES {
        let called = name.replace(' ', "-");
        let file = root.join(format!("target/identification-coverage-{called}.csv"));
        let mut text = fs::read_to_string(&file).unwrap_or_default();
        let asked = only.as_ref().is_none_or(|only| *only == called);
        for seed in 0..if asked { seeds } else { 0 } {
            if !text.lines().any(|line| line.starts_with(&format!("{seed};"))) {
                let counted = of_seed(&model, seed, masses)?;
                let cells: Vec<String> =
                    counted.iter().map(|(name, [inside, of])| format!("{name}={inside}/{of}")).collect();
                writeln!(text, "{seed};{}", cells.join(";"))?;
                fs::create_dir_all(root.join("target"))?;
                fs::write(&file, &text)?;
                eprintln!("{name}, seed {seed}: {}", cells.join(" "));
            }
        }
        write!(page, " {name}, {} datasets |", text.lines().count())?;
        columns.push(summed(&text)?);
    }
    page += "\n|---|---|---|\n";
    for name in columns[0].keys() {
        let cell = |column: &BTreeMap<String, [usize; 2]>| match column.get(name) {
            Some([inside, of]) => format!("{:.1} % of {of}", 100.0 * *inside as f64 / *of as f64),
            None => "–".to_owned(),
        };
        writeln!(page, "| {name} | {} |", columns.iter().map(cell).collect::<Vec<_>>().join(" | "))?;
    }
    print!("{page}");
    fs::write(root.join("benches/identification-coverage.md"), page)?;
    Ok(())
}

type Counted = BTreeMap<String, [usize; 2]>;

fn summed(text: &str) -> Result<Counted, Box<dyn Error>> {
    let mut all = Counted::new();
    for line in text.lines() {
        let mut cells = line.split(';');
        cells.next().ok_or("an empty line")?;
        for cell in cells {
            let (name, counts) = cell.split_once('=').ok_or("no count")?;
            let (inside, of) = counts.split_once('/').ok_or("no total")?;
            let one = all.entry(name.to_owned()).or_default();
            (one[0], one[1]) = (one[0] + inside.parse::<usize>()?, one[1] + of.parse::<usize>()?);
        }
    }
    Ok(all)
}

fn of_seed(model: &Model, seed: u64, masses: f64) -> Result<Counted, Box<dyn Error>> {
    let mut random = fastrand::Rng::with_seed(seed ^ 0x5eed);
    let mut normal = || (0..12).map(|_| random.f64()).sum::<f64>() - 6.0;
    let mut plan = Plan::of_sensors(&SENSORS);
    plan.sensors.iter_mut().for_each(|sensor| sensor.mass = masses * normal());
    let fault = ChannelFault { noise: NoiseLevel::Fraction(NOISE), ..ChannelFault::default() };
    plan.chain = Chain {
        excitation: fault,
        accelerometers: vec![fault; SENSORS.len()],
        gain_scatter: GAINS,
        seed,
        noise_told: true,
    };
    let held = SteppedSine { frequencies: Frequencies::Resonance, ..SteppedSine::at(LEVELS.to_vec()) };
    plan.tests.push(Test { name: "level".into(), use_for: None, kind: TestKind::SteppedSine(held) });
    let tested = test_with_truth_on(model, &plan, &mut |_| true)?;
    let gains: Vec<f64> = plan.chain.faults(SENSORS.len()).iter().map(|fault| fault.gain).collect();
    scored(model, &tested, &gains, masses)
}

/// How often each truth lies in its interval.
fn scored(model: &Model, tested: &[Tested], gains: &[f64], masses: f64) -> Result<Counted, Box<dyn Error>> {
    let dataset =
        Dataset { title: None, records: tested.iter().map(|tested| tested.record.clone()).collect() };
    let options = IdentifyOptions {
        excitation_gain: GAINS,
        sensor_gain: GAINS,
        sensor_mass: masses,
        ..IdentifyOptions::default()
    };
    let found = identify(model, &dataset, &options)?;
    let mut counted = Counted::new();
    let mut count = |name: &str, inside: bool| {
        let one = counted.entry(name.to_owned()).or_default();
        (one[0], one[1]) = (one[0] + usize::from(inside), one[1] + 1);
    };
    let inversion = found.inversion.ok_or("nothing was inverted")?;
    for (tested, period) in tested.iter().zip(&inversion.periods) {
        let truth = tested.contact.as_ref().ok_or("no contact")?;
        let [force, displacement] = ["force", "displacement"].map(|name| truth_of(truth, name, period));
        let (force, displacement) = (force?, displacement?);
        let within = |off: f64, variance: f64| off.abs() < WIDE * variance.sqrt();
        count("mean force", within(period.force[0] - force[0], period.covariance[(0, 0)]));
        for k in 1..period.force.len() {
            count("force, normal", within(period.force[k] - force[k], period.covariance[(k, k)]));
            let variance = period.displacement_covariance[(k, k)];
            count("displacement, normal", within(period.displacement[k] - displacement[k], variance));
        }
    }
    let told = std::iter::once(inversion.excitation_gain).chain({
        // Sensors are identified in the order of their positions.
        let mut order: Vec<usize> = (0..SENSORS.len()).collect();
        order.sort_by(|a, b| SENSORS[*a].total_cmp(&SENSORS[*b]));
        let mut gains = vec![[0.0; 2]; SENSORS.len()];
        order.iter().zip(&inversion.sensor_gains).for_each(|(place, gain)| gains[*place] = *gain);
        gains
    });
    for ([log, deviation], gain) in told.zip(gains) {
        count("gain", (log - gain.ln()).abs() < WIDE * deviation);
    }
    let law = found.laws.iter().find(|law| law.model.contact.is_some_and(|c| c.law.kind.name == "valanis"));
    for parameter in &law.ok_or("no Valanis law")?.parameters {
        let truth = model.get(&format!("contact.{}", parameter.name)).ok_or("no such parameter")?;
        let [low, high] = parameter.interval;
        // Without an interval nothing is claimed.
        if low.is_finite() && high.is_finite() {
            count(parameter.name, low <= truth && truth <= high);
        }
    }
    Ok(counted)
}

fn truth_of(truth: &Record, name: &str, period: &ContactPeriod) -> Result<Vec<f64>, Box<dyn Error>> {
    let values = &truth.channel(name).ok_or("no such channel")?.values;
    let times = truth.time().ok_or("no time")?;
    let frequency = period.angular_frequency / std::f64::consts::TAU;
    Ok(harmonics(times, values, frequency, period.force.len() / 2)?.coefficients)
}
