//! Free decays without an excitation, cut into levels.
//!
//! Items to verify: frequency and damping of a linear decay come back, and their intervals cover them; a decay begins where
//! the excitation ends; of two modes and harmonics the strongest mode alone is cut; a contact is recovered from the decay of an
//! oscillator by another integrator and of a beam on the virtual rig; the effect that a decay shows is named; a record that does
//! not decay says so.

use std::f64::consts::TAU;

use stickslip::data::{Channel, Dataset, Record, Regime};
use stickslip::diagnose::{DiagnoseOptions, DiagnoseWatch, Verdict, Watch, diagnose, evaluate, refit};
use stickslip::fit::ring_down::levels;
use stickslip::fit::tabulated;
use stickslip::model::Model;
use stickslip::rig::{Chain, ChannelFault, NoiseLevel, Plan, Release, RingDown, Test, TestKind, test_on};

const RATE: f64 = 2000.0;

/// A record of `count` samples of `motion`, with white noise.
fn recorded(name: &str, count: usize, noise: f64, seed: u64, motion: impl Fn(f64) -> f64) -> Record {
    let mut random = fastrand::Rng::with_seed(seed);
    // Twelve even numbers make a normal one.
    let mut normal = || (0..12).map(|_| random.f64()).sum::<f64>() - 6.0;
    let time: Vec<f64> = (0..count).map(|k| k as f64 / RATE).collect();
    let values = time.iter().map(|t| motion(*t) + noise * normal()).collect();
    let channel = |name: &str, unit, values| Channel { name: name.into(), unit, values, noise: None };
    let channels = vec![channel("time", "s", time), channel(name, "m/s^2", values)];
    Record { name: "decay.csv".into(), regime: Regime::UnknownInitialState, use_for: None, channels }
}

#[test]
fn a_linear_decay_comes_back_and_its_intervals_cover_it() {
    let (speed, ratio) = (TAU * 49.3, 0.004);
    let (mut inside, mut all) = ([0; 2], 0);
    for seed in 0..60 {
        let decay = |t: f64| 30.0 * (-ratio * speed * t).exp() * (speed * t + 0.1 * seed as f64).cos();
        let found = levels(&recorded("acceleration:m1", 6000, 0.3, seed, decay)).unwrap();
        for level in &found.levels {
            let envelope = 30.0 * (-ratio * speed * level.time).exp();
            assert!((level.amplitude / envelope - 1.0).abs() < 0.1, "{level:?} {envelope}");
            inside[0] += i32::from((level.frequency - speed / TAU).abs() < level.frequency_interval);
            inside[1] += i32::from((level.damping_ratio - ratio).abs() < level.damping_interval);
            all += 1;
        }
        assert!(found.levels.len() >= 3, "{}", found.levels.len());
    }
    let coverage = inside.map(|inside| f64::from(inside) / f64::from(all));
    println!("{coverage:?} of {all}");
    assert!(coverage.iter().all(|inside| (0.90..0.99).contains(inside)), "{coverage:?}");
}

#[test]
fn a_decay_begins_where_the_excitation_ends() {
    // A shaker off resonance that is shut off after a second; a blow before which nothing moves.
    let (speed, ratio) = (TAU * 40.0, 0.01);
    let free = move |t: f64| 20.0 * (-ratio * speed * t).exp() * (speed * t).sin();
    let shaken = move |t: f64| if t < 1.0 { 20.0 * (TAU * 42.0 * (t - 1.0)).sin() } else { free(t - 1.0) };
    let struck = move |t: f64| if t < 0.7 { 0.0 } else { free(t - 0.7) };
    for motion in [&shaken as &dyn Fn(f64) -> f64, &struck] {
        let found = levels(&recorded("acceleration:m1", 6000, 0.02, 1, motion)).unwrap();
        assert!(found.levels[0].time > 0.7 && found.levels[0].amplitude > 8.0, "{:?}", found.levels[0]);
        for level in &found.levels {
            assert!((level.frequency - 40.0).abs() < 0.02 + 2.0 * level.frequency_interval, "{level:?}");
            assert!((level.damping_ratio - ratio).abs() < 5e-4 + 2.0 * level.damping_interval, "{level:?}");
        }
    }
}

#[test]
fn another_mode_and_harmonics_are_kept_out() {
    let (speed, ratio) = (TAU * 50.0, 0.003);
    let motion = |t: f64| {
        let first = 20.0 * (-ratio * speed * t).exp();
        let other = 4.0 * (-0.002 * TAU * 155.0 * t).exp() * (TAU * 155.0 * t).cos();
        first * (speed * t).cos() + 0.05 * first * (3.0 * speed * t).cos() + other + 2.0
    };
    let found = levels(&recorded("acceleration:m1", 8000, 0.01, 1, motion)).unwrap();
    for level in &found.levels {
        assert!((level.frequency / 50.0 - 1.0).abs() < 1e-4, "{level:?}");
        assert!((level.damping_ratio / ratio - 1.0).abs() < 0.02, "{level:?}");
    }
}

#[test]
fn what_does_not_decay_says_so() {
    let model = oscillator(6.0, 4e3, 3.0);
    for (motion, words) in [
        (&(|t: f64| (TAU * 50.0 * t).sin()) as &dyn Fn(f64) -> f64, "levels"),
        (&|_: f64| 0.0, "stands out of the noise"),
    ] {
        let dataset =
            Dataset { title: None, records: vec![recorded("acceleration:m1", 4000, 0.1, 5, motion)] };
        let (same, none) = tabulated(&model, &dataset);
        assert_eq!((&same, none.len()), (&dataset, 0));
        let failure = evaluate("", &model, &same).records[0].failure.clone().unwrap();
        assert!(failure.contains(words), "{failure}");
    }
}

/// 2 kg on 2e4 N/m with a damper (N s/m), and a contact (N/m) with a limit (N).
fn oscillator(damping: f64, contact: f64, limit: f64) -> Model {
    let text = format!(
        "schema = \"stickslip.model/1\"\nkind = \"oscillator\"\nmass = [{{ name = \"m1\", mass = 2.0 }}]\n\
         spring = [{{ between = [\"ground\", \"m1\"], stiffness = 2e4, damping = {damping} }}]\n\
         contact = {{ at = \"m1\", law = \"jenkins\", tangential_stiffness = {contact}, friction_coefficient = 0.1, normal_load = {} }}\n\
         fit = {{ free = [\"contact.friction_coefficient\", \"spring.1.damping\"] }}",
        10.0 * limit
    );
    Model::parse(&text).unwrap()
}

#[derive(Clone, Copy)]
struct Released {
    /// Displacement at first (m).
    start: f64,
    damping: f64,
    /// Stiffness (N/m) and limit (N) of the slider.
    contact: f64,
    limit: f64,
    /// Of the velocity's square (N s²/m²).
    drag: f64,
}

/// Its free decay by a classical Runge-Kutta scheme of small steps with the slider moved between them.
fn released(of: Released) -> Record {
    let Released { start, damping, contact, limit, drag } = of;
    let (mut x, mut v, mut slider) = (start, 0.0_f64, start - limit / contact);
    let finer = 40;
    let step = 1.0 / RATE / f64::from(finer);
    let mut samples = Vec::new();
    for _ in 0..12_000 {
        let friction = |x: f64, slider: f64| (contact * (x - slider)).clamp(-limit, limit);
        let acceleration = |x: f64, v: f64, slider: f64| {
            -(2e4 * x + damping * v + drag * v * v.abs() + friction(x, slider)) / 2.0
        };
        samples.push(acceleration(x, v, slider));
        for _ in 0..finer {
            let k1 = (v, acceleration(x, v, slider));
            let k2 =
                (v + 0.5 * step * k1.1, acceleration(x + 0.5 * step * k1.0, v + 0.5 * step * k1.1, slider));
            let k3 =
                (v + 0.5 * step * k2.1, acceleration(x + 0.5 * step * k2.0, v + 0.5 * step * k2.1, slider));
            let k4 = (v + step * k3.1, acceleration(x + step * k3.0, v + step * k3.1, slider));
            x += step / 6.0 * (k1.0 + 2.0 * k2.0 + 2.0 * k3.0 + k4.0);
            v += step / 6.0 * (k1.1 + 2.0 * k2.1 + 2.0 * k3.1 + k4.1);
            slider = slider.clamp(x - limit / contact, x + limit / contact);
        }
    }
    let at = |t: f64| samples[(t * RATE).round() as usize];
    recorded("acceleration:m1", samples.len(), 0.05, 9, at)
}

#[test]
fn the_contact_of_an_oscillator_is_recovered_from_its_decay() {
    let dataset = Dataset {
        title: None,
        records: vec![released(Released { start: 0.02, damping: 2.0, contact: 4e3, limit: 6.0, drag: 0.0 })],
    };
    let (tables, found) = tabulated(&oscillator(2.0, 4e3, 6.0), &dataset);
    // The slider begins to stick within a window: the model's own decay is cut as the measured one was.
    let off = deviations(&oscillator(2.0, 4e3, 6.0), &tables, &found[0]);
    assert!(off[..5].iter().flatten().all(|off| off.abs() < 0.2), "{off:?}");
    let start = oscillator(3.0, 4e3, 4.0);
    let fitted = refit("", &start, &tables, Watch::default()).unwrap();
    let (limit, damping) = (
        60.0 * fitted.model.get("contact.friction_coefficient").unwrap() * 4.0 / 6.0,
        fitted.model.get("spring.1.damping").unwrap(),
    );
    println!("{limit} N, {damping} N s/m, error {}", fitted.stage.error);
    assert!((limit / 6.0 - 1.0).abs() < 0.001 && (damping / 2.0 - 1.0).abs() < 0.002, "{limit} {damping}");
    assert!(fitted.stage.error < 0.01, "{}", fitted.stage.error);
}

#[test]
fn decays_on_soft_and_stiff_sliders_are_predicted_at_every_level() {
    // A window of many cycles in stick follows one in which the slider slips; the frequency of stick is up to twice that of slip.
    for (contact, limit) in
        [(4e3, 1.5), (1e4, 1.5), (1e4, 6.0), (2e4, 3.0), (2.5e4, 6.0), (3e4, 1.5), (6e4, 1.5), (6e4, 6.0)]
    {
        for damping in [0.3, 2.0] {
            let decay = released(Released { start: 0.02, damping, contact, limit, drag: 0.0 });
            let model = oscillator(damping, contact, limit);
            let (tables, found) = tabulated(&model, &Dataset { title: None, records: vec![decay] });
            println!("{contact} N/m, {limit} N, {damping} N s/m");
            let off = deviations(&model, &tables, &found[0]);
            assert!(off.iter().flatten().all(|off| off.abs() < 2.5), "{contact} {limit} {damping}: {off:?}");
            let levels = found[0].levels.iter();
            let wide =
                |level: &&stickslip::fit::ring_down::Level| level.frequency_interval > 0.05 * level.frequency;
            assert!(levels.filter(wide).count() < 2, "{:?}", found[0].levels);
        }
    }
}

#[test]
fn a_model_far_from_a_decay_is_led_to_it() {
    let record = released(Released { start: 0.02, damping: 2.0, contact: 4e3, limit: 6.0, drag: 0.0 });
    for damping in [0.2, 40.0, 500.0] {
        let start = oscillator(damping, 4e3, 9.0);
        let (tables, _) = tabulated(&start, &Dataset { title: None, records: vec![record.clone()] });
        let fitted = refit("", &start, &tables, Watch::default()).unwrap();
        let found = fitted.model.get("spring.1.damping").unwrap();
        let limit = 90.0 * fitted.model.get("contact.friction_coefficient").unwrap();
        println!("{damping}: {found} N s/m, {limit} N, error {}", fitted.stage.error);
        assert!(
            (found / 2.0 - 1.0).abs() < 0.01 && (limit / 6.0 - 1.0).abs() < 0.01,
            "{damping}: {found} {limit}"
        );
    }
}

/// The decays of a beam on the virtual rig, from held amplitudes (m/s²) with noise of 0.05 m/s².
fn of_the_rig(model: &Model, amplitudes: &[f64], seed: u64) -> Dataset {
    let mut plan = Plan::of_sensors(&[0.55, 0.3, 0.1]);
    let noisy = ChannelFault { noise: NoiseLevel::Deviation(0.05), ..ChannelFault::default() };
    plan.chain = Chain { accelerometers: vec![noisy; 3], seed, ..Chain::default() };
    for amplitude in amplitudes {
        let decay = RingDown { from: vec![Release::Held(*amplitude)], duration: 4.0, sampling: 2048.0 };
        plan.tests.push(Test {
            name: format!("from-{amplitude}"),
            use_for: None,
            kind: TestKind::RingDown(decay),
        });
    }
    Dataset { title: None, records: test_on(model, &plan, &mut |_| true).unwrap() }
}

/// What the model that made a decay predicts less what was cut, over half of the 95 % interval.
fn deviations(truth: &Model, tables: &Dataset, found: &stickslip::fit::ring_down::RingDown) -> Vec<[f64; 2]> {
    let stage = evaluate("", truth, tables);
    println!("{}: at the truth {}", found.channel, stage.error);
    let [frequency, ratio] = &stage.records[0].channels[..] else { panic!("{:?}", stage.records[0].failure) };
    let one = |(index, level): (usize, &stickslip::fit::ring_down::Level)| {
        let off = [
            (frequency.predicted[index] - level.frequency) / level.frequency_interval,
            (ratio.predicted[index] - level.damping_ratio) / level.damping_interval,
        ];
        println!(
            "{:.3} s {:.3} m/s² {:.4} Hz {:.5}: {off:.1?}",
            level.time, level.amplitude, level.frequency, level.damping_ratio
        );
        off
    };
    found.levels.iter().enumerate().map(one).collect()
}

fn beam(change: impl Fn(String) -> String) -> Model {
    let text = include_str!("../../examples/frictional-support/published.toml");
    Model::parse(&change(text.to_owned())).unwrap()
}

#[test]
fn a_beam_on_a_single_slider_is_predicted_at_every_level_of_its_decays() {
    // From stick to slip at once, and the second mode near three times the first: the steady vibration folds.
    let truth = Model::parse(include_str!("../../examples/frictional-support/jenkins.toml")).unwrap();
    let (tables, found) = tabulated(&truth, &of_the_rig(&truth, &[20.0, 40.0, 60.0, 70.0], 1));
    for (record, found) in tables.records.iter().zip(&found) {
        let one = Dataset { title: None, records: vec![record.clone()] };
        let stage = evaluate("", &truth, &one);
        let [frequency, ratio] = &stage.records[0].channels[..] else {
            panic!("{:?}", stage.records[0].failure)
        };
        for (index, level) in found.levels.iter().enumerate() {
            let off =
                [frequency.predicted[index] - level.frequency, ratio.predicted[index] - level.damping_ratio];
            println!(
                "{:.3} m/s² {:.4} Hz {:.5}: {off:.4?}",
                level.amplitude, level.frequency, level.damping_ratio
            );
            assert!(off[0].abs() < 0.25 && off[1].abs() < 0.01, "{off:?}");
        }
    }
}

#[test]
fn the_contact_of_a_beam_is_recovered_from_its_decay() {
    let free = |text: String| {
        text.replace("free = []", "free = [\"contact.friction_coefficient\", \"beam.damping_ratio\"]")
    };
    let truth = beam(free);
    let paths = ["contact.friction_coefficient", "beam.damping_ratio"];
    let values = paths.map(|path| truth.get(path).unwrap());
    for seed in [4, 6, 7] {
        let (tables, found) = tabulated(&truth, &of_the_rig(&truth, &[40.0], seed));
        // Friction takes energy from what the reversal's amplitude holds, not from what the mode's frequency says.
        let off = deviations(&truth, &tables, &found[0]);
        assert!(off.iter().flatten().all(|off| off.abs() < 2.0), "{off:?}");
        let mut start = truth.clone();
        start.set(paths[0], 0.8 * values[0]).unwrap();
        start.set(paths[1], 1.5 * values[1]).unwrap();
        let fitted = refit("", &start, &tables, Watch::default()).unwrap();
        let ratios = [0, 1].map(|k| fitted.model.get(paths[k]).unwrap() / values[k]);
        println!("{ratios:?}, error {}", fitted.stage.error);
        // The levels at which friction takes next to nothing tell the beam's own damping, a tenth of all.
        assert!((ratios[0] - 1.0).abs() < 0.03 && (ratios[1] - 1.0).abs() < 0.06, "{ratios:?}");
    }
}

#[test]
fn drag_is_named_from_decays() {
    let base = Model::parse(
        "schema = \"stickslip.model/1\"\nkind = \"oscillator\"\nmass = [{ name = \"m1\", mass = 2.0 }]\n\
         spring = [{ between = [\"ground\", \"m1\"], stiffness = 2e4, damping = 2.0 }]",
    )
    .unwrap();
    let records = [0.02, 0.03, 0.012, 0.025].map(|start| Record {
        name: format!("from-{start}.csv"),
        ..released(Released { start, damping: 2.0, contact: 4e3, limit: 0.0, drag: 3.0 })
    });
    let (tables, found) = tabulated(&base, &Dataset { title: None, records: records.into() });
    let mut hidden = base.clone();
    hidden.effects = Model::parse(&format!(
        "{}\n[[effect]]\nid = \"quadratic_damping\"\nquadratic_damping = 3.0\n",
        base.to_toml()
    ))
    .unwrap()
    .effects;
    for (record, found) in tables.records.iter().zip(&found) {
        deviations(&hidden, &Dataset { title: None, records: vec![record.clone()] }, found);
    }
    let told = diagnose(&base, &tables, &DiagnoseOptions::default(), DiagnoseWatch::default()).unwrap();
    println!("{:?} {:?} {:?}", told.verdict, told.effects, told.reasons);
    assert_eq!((told.verdict, &told.effects[..]), (Verdict::EffectFound, &["quadratic_damping"][..]));
    let drag = told.model.get("effect.1.quadratic_damping").unwrap();
    assert!((drag / 3.0 - 1.0).abs() < 0.05, "{drag}");
}
