//! Noise, gains, delays.

use stickslip::data::Record;
use stickslip::identify::harmonics;
use stickslip::rig::{
    Chain, ChannelFault, DualMode, NoiseLevel, Plan, RandomTest, Release, RigError, RingDown, SteppedSine,
    TestKind, test_on,
};

use crate::{SENSORS, accelerations, published, rms, test};

const RANDOM: RandomTest =
    RandomTest { force: 1.0, band: [20.0, 400.0], duration: 2.0, sampling: 2000.0, lead: 0.0, seed: 1 };

/// A steady, a random and a free record through `chain`.
fn records(chain: Chain) -> Vec<Record> {
    let mut plan = Plan { chain, ..Plan::of_sensors(&SENSORS) };
    let ring_down = RingDown { from: vec![Release::Held(20.0)], duration: 0.5, sampling: 4000.0 };
    let kinds = [
        TestKind::SteppedSine(SteppedSine::at(vec![30.0])),
        TestKind::Random(RANDOM),
        TestKind::RingDown(ring_down),
    ];
    let named = ["steady", "random", "free"].into_iter().zip(kinds);
    plan.tests.extend(named.map(|(name, kind)| test(name, kind)));
    test_on(&published(4, |text| text), &plan, &mut |_| true).unwrap()
}

fn fault(gain: f64, delay: f64, noise: NoiseLevel) -> ChannelFault {
    ChannelFault { gain, delay, noise }
}

const NO_NOISE: NoiseLevel = NoiseLevel::Deviation(0.0);

/// Channels of `shown` that `clean` has too, in pairs, but for time.
fn pairs<'r>(shown: &'r Record, clean: &'r Record) -> impl Iterator<Item = (&'r [f64], &'r [f64])> {
    let channels = shown.channels.iter().zip(&clean.channels).skip(1);
    channels.map(|(shown, clean)| (shown.values.as_slice(), clean.values.as_slice()))
}

#[test]
fn noise_has_the_deviation_asked_for_and_is_told_only_if_asked() {
    let clean = records(Chain::default());
    for noise_told in [true, false] {
        let sensor = fault(1.0, 0.0, NoiseLevel::Fraction(0.03));
        let shown = records(Chain {
            excitation: fault(1.0, 0.0, NoiseLevel::Deviation(0.02)),
            accelerometers: vec![sensor; 3],
            noise_told,
            ..Chain::default()
        });
        for (shown, clean) in shown.iter().zip(&clean) {
            for (column, (noisy, quiet)) in pairs(shown, clean).enumerate() {
                let is_force = column == 0 && clean.channel("excitation").is_some();
                let asked = if is_force { 0.02 } else { 0.03 * rms(quiet.iter().copied()) };
                let off = rms(noisy.iter().zip(quiet).map(|(a, b)| a - b));
                // Of 2000 samples a deviation is known to 1/√4000.
                assert!((off / asked - 1.0).abs() < 0.06, "{}: {off} {asked}", shown.name);
                let told = shown.channels[1 + column].noise;
                assert_eq!(told.is_some(), noise_told);
                assert!(told.is_none_or(|told| (told / asked - 1.0).abs() < 1e-12));
            }
        }
        // Noise of one channel or record says nothing of another's.
        let of = |record: usize, column: usize| -> Vec<f64> {
            let (shown, clean) = (&shown[record].channels[column], &clean[record].channels[column]);
            shown.values.iter().zip(&clean.values).map(|(a, b)| a - b).collect()
        };
        let correlation = |a: &[f64], b: &[f64]| {
            let dot: f64 = a.iter().zip(b).map(|(a, b)| a * b).sum();
            dot / a.len().min(b.len()) as f64 / rms(a.iter().copied()) / rms(b.iter().copied())
        };
        assert!(correlation(&of(0, 2), &of(0, 3)).abs() < 0.1);
        assert!(correlation(&of(0, 2), &of(1, 2)).abs() < 0.1);
    }
}

#[test]
fn a_gain_multiplies_what_its_channel_shows_in_every_record() {
    let clean = records(Chain::default());
    let gains = [1.02, 0.97, 1.0, 1.01];
    let faults: Vec<ChannelFault> = gains.iter().map(|gain| fault(*gain, 0.0, NO_NOISE)).collect();
    let shown =
        records(Chain { excitation: faults[0], accelerometers: faults[1..].to_vec(), ..Chain::default() });
    for (shown, clean) in shown.iter().zip(&clean) {
        let gains = gains.iter().skip(usize::from(clean.channel("excitation").is_none()));
        for ((shown, clean), gain) in pairs(shown, clean).zip(gains) {
            assert!(shown.iter().zip(clean).all(|(a, b)| (a - gain * b).abs() <= 1e-12 * b.abs()));
        }
    }
}

#[test]
fn gains_are_drawn_once_about_those_given() {
    let chain = Chain { gain_scatter: 0.01, seed: 5, ..Chain::default() };
    let gains: Vec<f64> = chain.faults(3).iter().map(|fault| fault.gain).collect();
    assert!(gains.windows(2).all(|pair| pair[0] != pair[1]) && gains.iter().all(|g| (g - 1.0).abs() < 0.05));
    let (clean, shown) = (records(Chain::default()), records(chain));
    for (shown, clean) in shown.iter().zip(&clean) {
        for ((shown, clean), gain) in accelerations(shown).iter().zip(accelerations(clean)).zip(&gains[1..]) {
            assert!(shown.iter().zip(clean).all(|(a, b)| (a - gain * b).abs() <= 1e-12 * b.abs()));
        }
    }
    let spread: Vec<f64> = (0..500)
        .flat_map(|seed| Chain { gain_scatter: 0.01, seed, ..Chain::default() }.faults(3))
        .map(|fault| fault.gain - 1.0)
        .collect();
    assert!((rms(spread.into_iter()) / 0.01 - 1.0).abs() < 0.05);
}

/// One sensor lags by three samples of the random record, one by two and a half.
#[test]
fn a_delayed_channel_shows_earlier_motion() {
    let clean = records(Chain::default());
    let delays = [1.5e-3, 1.25e-3, 0.0];
    let shown = records(Chain {
        excitation: fault(1.0, 1e-3, NO_NOISE),
        accelerometers: delays.iter().map(|delay| fault(1.0, *delay, NO_NOISE)).collect(),
        ..Chain::default()
    });
    let close = |a: &[f64], b: &[f64], bound: f64| {
        let off = rms(a.iter().zip(b).map(|(a, b)| a - b)) / rms(b.iter().copied());
        assert!(off < bound, "{off:e}");
    };
    // Whole samples: in time, of motion from rest.
    let (late, prompt) = (&shown[1], &clean[1]);
    close(&accelerations(late)[0][3..], &accelerations(prompt)[0][..3997], 1e-4);
    assert_eq!(accelerations(late)[0][..3], [0.0; 3]);
    let force = |record: &Record| record.channel("excitation").unwrap().values.clone();
    close(&force(late)[2..], &force(prompt)[..3998], 1e-9);
    // Half samples, through a force at every motion that was there: the sum of two neighbours lies in the middle.
    let doubled = test_on(&published(4, |text| text), &finer(), &mut |_| true).unwrap();
    let fine: Vec<f64> = accelerations(&doubled[0])[1].iter().copied().step_by(1).collect();
    let expected: Vec<f64> = (3..4000).map(|k| fine[2 * k - 5]).collect();
    close(&accelerations(late)[1][3..], &expected, 1e-4);
    // Free decay: before the release the held motion is shown.
    let (late, prompt) = (accelerations(&shown[2])[0], accelerations(&clean[2])[0]);
    close(&late[6..], &prompt[..1994], 1e-3);
    assert!(late[..6].iter().all(|a| *a < -15.0));
    // Steady: a phase of every harmonic.
    let frequency = 8.0 / (clean[0].sample_step().unwrap() * clean[0].len() as f64);
    let first = |record: &Record| {
        harmonics(record.time().unwrap(), accelerations(record)[1], frequency, 30).unwrap().coefficients
    };
    let (late, prompt) = (first(&shown[0]), first(&clean[0]));
    for harmonic in 1..6 {
        let phase = |of: &[f64]| of[2 * harmonic].atan2(of[2 * harmonic - 1]);
        let lag = std::f64::consts::TAU * frequency * harmonic as f64 * delays[1];
        let apart = phase(&late) - phase(&prompt) - lag;
        assert!((apart / 2.0).sin().abs() < 1e-6, "{harmonic}: {apart}");
    }
}

/// The same force, sampled twice as often.
fn finer() -> Plan {
    let mut plan = Plan::of_sensors(&SENSORS);
    plan.tests.push(test("random", TestKind::Random(RandomTest { sampling: 4000.0, ..RANDOM })));
    plan
}

#[test]
fn the_same_plan_gives_the_same_records_whatever_follows() {
    let chain = Chain {
        accelerometers: vec![fault(1.0, 1e-4, NoiseLevel::Fraction(0.01)); 3],
        gain_scatter: 0.01,
        ..Chain::default()
    };
    let once = records(chain.clone());
    assert_eq!(once, records(chain.clone()));
    let mut plan = Plan { chain: chain.clone(), ..Plan::of_sensors(&SENSORS) };
    plan.tests.push(test("steady", TestKind::SteppedSine(SteppedSine::at(vec![30.0]))));
    let alone = test_on(&published(4, |text| text), &plan, &mut |_| true).unwrap();
    assert_eq!(alone[0], once[0]);
    let other = records(Chain { seed: 1, ..chain });
    assert_ne!(once[0].channels[2], other[0].channels[2]);
}

#[test]
fn a_watch_ends_every_test_soon() {
    for (index, kind) in [
        TestKind::SteppedSine(SteppedSine::at(vec![30.0; 50])),
        TestKind::Random(RandomTest { duration: 500.0, ..RANDOM }),
        TestKind::Random(RandomTest { lead: 1000.0, ..RANDOM }),
        TestKind::RingDown(RingDown { from: vec![Release::Force(1.0)], duration: 1000.0, sampling: 1000.0 }),
    ]
    .into_iter()
    .enumerate()
    {
        let mut plan = Plan::of_sensors(&SENSORS);
        plan.tests.push(test("long", kind));
        let begin = std::time::Instant::now();
        let mut looks = 0;
        let ended = test_on(&published(4, |text| text), &plan, &mut |_| {
            looks += 1;
            looks < 5
        });
        assert_eq!(ended, Err(RigError::Interrupted));
        assert!(begin.elapsed().as_secs_f64() < 10.0, "{index}");
    }
}

#[test]
fn what_cannot_be_tested_is_refused_with_its_reason() {
    let refused = |change: &dyn Fn(&mut Plan), hint: &str| {
        let mut plan = Plan::of_sensors(&SENSORS);
        plan.tests.push(test("one", TestKind::Random(RANDOM)));
        change(&mut plan);
        let told = test_on(&published(4, |text| text), &plan, &mut |_| true).unwrap_err().to_string();
        assert!(told.contains(hint), "{told}");
    };
    refused(&|plan| plan.sensors.clear(), "no accelerometer");
    refused(&|plan| plan.sensors[0].position = 0.7, "0.7");
    refused(&|plan| plan.tests.push(plan.tests[0].clone()), "one.csv");
    refused(&|plan| plan.chain.excitation.delay = -1.0, "delays");
    let band = |band: [f64; 2]| {
        move |plan: &mut Plan| {
            plan.tests[0].kind = TestKind::Random(RandomTest { band, ..RANDOM });
        }
    };
    refused(&band([20.0, 1500.0]), "half the sampling");
    refused(&band([20.1, 20.2]), "narrower");
    refused(&band([-1.0, 20.0]), "positive");
    let forever = RandomTest { duration: 1e4, ..RANDOM };
    refused(&|plan| plan.tests[0].kind = TestKind::Random(forever.clone()), "too long");
    let mut plan = Plan::of_sensors(&SENSORS);
    plan.tests.push(test("held", TestKind::SteppedSine(SteppedSine::at(vec![30.0]))));
    let worn = published(4, |text| format!("{text}\n[[effect]]\nid = \"wear\"\nrate = 1.0\n"));
    let told = test_on(&worn, &plan, &mut |_| true).unwrap_err().to_string();
    assert!(told.contains("wear") && told.contains("steady state"), "{told}");
}

#[test]
fn harmonics_that_no_memory_holds_are_refused() {
    let stepped = SteppedSine { harmonics: Some(100_000), ..SteppedSine::at(vec![30.0]) };
    let dual = DualMode { harmonics: 100_000, ..DualMode::at(52.0, vec![[7.0, 17.0]]) };
    for kind in [TestKind::SteppedSine(stepped), TestKind::DualMode(dual)] {
        let told = test("many", kind).check().unwrap_err().to_string();
        assert!(told.contains("many: it has more than 200 harmonics"), "{told}");
    }
}
