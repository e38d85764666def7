//! Steady records of oscillators, lightly damped ones among them, against the exact flow.
//!
//! Items to verify: the prediction is the periodic motion that shooting on the exact flow finds, from damping 1e-4 to
//! 1e-2; it costs a small fraction of marching to the steady state; of several responses the measured one is predicted.

use std::f64::consts::TAU;
use std::time::Instant;

use stickslip::contact::Jenkins;
use stickslip::data::{Channel, ChannelName, Dataset, Record, Regime};
use stickslip::diagnose::evaluate;
use stickslip::model::{Model, Structure};
use stickslip::time::{Excitation, LoadedContact, OscillatorFlow, ShootingSettings, shoot};

const SAMPLES: usize = 128;
const PERIODS: usize = 3;

/// A chain of masses between ground and a free end, with a contact, and a cosine on one mass near a resonance.
struct Case {
    model: Model,
    damping: f64,
    angular_frequency: f64,
    force: f64,
    excited: usize,
}

fn case(random: &mut fastrand::Rng) -> Case {
    let mut between = |low: f64, high: f64| low + (high - low) * random.f64();
    let damping = 1e-4 * 100_f64.powf(between(0.0, 1.0));
    let masses = 1 + between(0.0, 3.0) as usize;
    let (excited, touched) = (between(0.0, masses as f64) as usize, between(0.0, masses as f64) as usize);
    let mut text = String::from("schema = \"stickslip.model/1\"\nkind = \"oscillator\"\n");
    // Dampers in proportion to the springs: the first mode, at about 100 rad/s times a number of order one.
    for mass in 0..masses {
        let below = if mass == 0 { "ground".to_owned() } else { format!("m{mass}") };
        let (stiffness, mass) = (1e4 * between(0.5, 2.0), mass + 1);
        text += &format!("[[mass]]\nname = \"m{mass}\"\nmass = {}\n", between(0.5, 2.0));
        text += &format!("[[spring]]\nbetween = [\"{below}\", \"m{mass}\"]\nstiffness = {stiffness}\n");
        text += &format!("damping = {}\n", 2.0 * damping * stiffness / 100.0);
    }
    text += &format!(
        "[contact]\nat = \"m{}\"\nlaw = \"jenkins\"\ntangential_stiffness = {}\nfriction_coefficient = 0.3\nnormal_load = {}\n",
        touched + 1,
        1e4 * between(0.05, 0.6),
        between(5.0, 60.0)
    );
    let model = Model::parse(&text).unwrap();
    let modes = model.system().unwrap().linear_part().natural_modes().unwrap().angular_frequency;
    let mode = modes[between(0.0, modes.len() as f64) as usize];
    Case { angular_frequency: mode * between(0.95, 1.15), force: between(2.0, 40.0), model, damping, excited }
}

/// What the exact flow shows in its periodic motion; `None` where shooting finds none that is stable.
fn measured(case: &Case) -> Option<Record> {
    let contact = case.model.contact.unwrap();
    let law = Jenkins::new(contact.tangential_stiffness, contact.friction_coefficient).unwrap();
    let contacts = [LoadedContact { law: &law, normal_load: contact.normal_load }];
    let mut flow = OscillatorFlow::new(&structure(case), &contacts).unwrap();
    let excitation = Excitation::cosine(case.angular_frequency, case.force);
    let found = shoot(&mut flow, &excitation, None, &ShootingSettings::default())
        .ok()
        .filter(|found| found.stable)?;
    let Structure::Oscillator(oscillator) = &case.model.structure else { panic!() };
    let masses = oscillator.masses.len();
    let step = TAU / case.angular_frequency / SAMPLES as f64;
    let mut motion = found.start;
    let mut columns: Vec<Vec<f64>> = vec![Vec::new(); 2 + 2 * masses];
    for index in 0..SAMPLES {
        columns[0].push(index as f64 * step);
        columns[1].push(excitation.value(motion.time()));
        let x = flow.displacement(&motion).to_vec();
        let v = flow.velocity(&motion).to_vec();
        for mass in 0..masses {
            columns[2 + 2 * mass].push(x[mass]);
            columns[3 + 2 * mass].push(v[mass]);
        }
        flow.advance(&mut motion, step, &excitation).unwrap();
    }
    let names = (1..=masses).flat_map(|mass| [format!("displacement:m{mass}"), format!("velocity:m{mass}")]);
    let names = ["time".to_owned(), format!("excitation:m{}", case.excited + 1)].into_iter().chain(names);
    let channel = |(name, values): (String, Vec<f64>)| {
        let unit = ChannelName::parse(&name).unwrap().quantity.unit;
        let mut values = values.repeat(PERIODS);
        if name == "time" {
            values = (0..values.len()).map(|index| index as f64 * step).collect();
        }
        Channel { name, unit, values, noise: None }
    };
    let channels = names.zip(columns).map(channel).collect();
    Some(Record { name: "steady".into(), regime: Regime::Steady, use_for: None, channels })
}

/// The linear part with the excitation where the case has it.
fn structure(case: &Case) -> stickslip::system::LinearStructure {
    let mut structure = case.model.system().unwrap().linear_part();
    structure.excitation = vec![(case.excited, 1.0)];
    structure
}

#[test]
fn lightly_damped_records_are_those_of_the_exact_flow() {
    let mut random = fastrand::Rng::with_seed(21);
    let (mut seen, mut worst, mut slipping) = (0, 0.0_f64, 0);
    for index in 0..60 {
        let case = case(&mut random);
        let Some(record) = measured(&case) else { continue };
        let dataset = Dataset { title: None, records: vec![record] };
        let before = Instant::now();
        let stage = evaluate("", &case.model, &dataset);
        let seconds = before.elapsed().as_secs_f64();
        assert_eq!(stage.records[0].failure, None, "{index}");
        let mut stuck = case.model.clone();
        stuck.set("contact.friction_coefficient", 1e3).unwrap();
        slipping += usize::from(evaluate("", &stuck, &dataset).error > 1e-3);
        let largest = stage.records[0].channels.iter().map(|channel| channel.error).fold(0.0, f64::max);
        println!("{index}: damping {:.1e}, error {largest:.1e}, {:.1} ms", case.damping, 1e3 * seconds);
        assert!(largest < 1e-3, "{index}: damping {:e}, error {largest:e}", case.damping);
        worst = worst.max(largest);
        seen += 1;
    }
    println!("{seen} records, {slipping} of them slip; the worst error is {worst:.1e}");
    assert!(seen >= 50 && slipping >= 25, "{seen} {slipping}");
}

#[test]
fn a_prediction_costs_a_small_fraction_of_marching() {
    let mut random = fastrand::Rng::with_seed(21);
    let mut cases = (0..).map(|_| case(&mut random)).filter(|case| case.damping < 2e-4);
    let (case, record) = cases.find_map(|case| measured(&case).map(|record| (case, record))).unwrap();
    let dataset = Dataset { title: None, records: vec![record] };
    let before = Instant::now();
    assert!(evaluate("", &case.model, &dataset).error < 1e-3);
    let balance = before.elapsed().as_secs_f64();
    let contact = case.model.contact.unwrap();
    let law = Jenkins::new(contact.tangential_stiffness, contact.friction_coefficient).unwrap();
    let contacts = [LoadedContact { law: &law, normal_load: contact.normal_load }];
    let mut flow = OscillatorFlow::new(&structure(&case), &contacts).unwrap();
    let excitation = Excitation::cosine(case.angular_frequency, case.force);
    // Until the start has decayed to a hundred-thousandth by the structure's own damping.
    let periods = (1e5_f64.ln() / (TAU * case.damping)) as usize;
    let (mut motion, before) = (flow.rest(), Instant::now());
    for _ in 0..periods {
        flow.advance(&mut motion, TAU / case.angular_frequency, &excitation).unwrap();
    }
    let marching = before.elapsed().as_secs_f64();
    println!(
        "{:.1} ms by balance, {:.0} ms by {periods} periods: {:.0} times",
        1e3 * balance,
        1e3 * marching,
        marching / balance
    );
    assert!(marching > 5.0 * balance);
}

/// Above its resonance an oscillator with a cubic spring has a large and a small response: the one that was measured is
/// predicted. Their first harmonics are those of the closed form.
#[test]
fn of_several_responses_the_measured_one_is_predicted() {
    let (cubic, damping, force, speed) = (1e8, 2.0, 5.0, 115.0);
    let text = format!(
        "schema = \"stickslip.model/1\"\nkind = \"oscillator\"\nmass = [{{ name = \"m1\", mass = 1.0 }}]\n\
         spring = [{{ between = [\"ground\", \"m1\"], stiffness = 1e4, damping = {damping} }}]\n\
         effect = [{{ id = \"geometric_stiffening\", cubic_stiffness = {cubic} }}]"
    );
    let model = Model::parse(&text).unwrap();
    // Force over amplitude, squared, by the first harmonic alone.
    let needed = |a: f64| {
        let stiffness = 1e4 - speed * speed + 0.75 * cubic * a * a;
        a * stiffness.hypot(damping * speed)
    };
    let grid: Vec<f64> = (1..400_000).map(|k| 1e-7 * f64::from(k)).collect();
    let crossed = grid.windows(2).filter(|pair| (needed(pair[0]) < force) != (needed(pair[1]) < force));
    let amplitudes: Vec<f64> = crossed.map(|pair| pair[0]).collect();
    let [small, _, large] = amplitudes[..] else { panic!("{amplitudes:?}") };
    for amplitude in [small, large] {
        let stiffness = 1e4 - speed * speed + 0.75 * cubic * amplitude * amplitude;
        let lag = (damping * speed).atan2(stiffness);
        let wave = |size: f64, lag: f64| {
            (0..256).map(|k| size * (TAU * f64::from(k) / 64.0 - lag).cos()).collect::<Vec<f64>>()
        };
        let channel = |name: &str, unit, values| Channel { name: name.into(), unit, values, noise: None };
        let channels = vec![
            channel("time", "s", (0..256).map(|k| f64::from(k) * TAU / speed / 64.0).collect()),
            channel("excitation:m1", "N", wave(force, 0.0)),
            channel("displacement:m1", "m", wave(amplitude, lag)),
        ];
        let record = Record { name: "duffing".into(), regime: Regime::Steady, use_for: None, channels };
        let error = evaluate("", &model, &Dataset { title: None, records: vec![record] }).error;
        println!("{amplitude}: {error}");
        // What the closed form leaves out is the third harmonic.
        assert!(error < 0.05, "{amplitude}: {error}");
    }
}
