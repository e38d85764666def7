//! Plans of tests on a virtual rig, and the datasets written of them.

use std::fs;
use std::path::Path;

use stickslip::data::{Dataset, Regime, Use};
use stickslip::rig::{Frequencies, NoiseLevel, Release, TestKind, test_on};
use stickslip_readers::{InputError, RigPlan, dataset_toml, read_dataset, read_plan, record_csv};
use tempfile::TempDir;

const HEAD: &str = "schema = \"stickslip.rig/1\"\nmodel = \"model.toml\"\n";
const RANDOM: &str = "[[random]]\nforce = 0.1\nband = [10, 200]\nduration = 1\nsampling = 1000\n";

fn folder(plan: &str) -> TempDir {
    let folder = TempDir::new().unwrap();
    let model = include_str!("../../../../examples/frictional-support/published.toml");
    fs::write(folder.path().join("model.toml"), model).unwrap();
    fs::write(folder.path().join("plan.toml"), plan).unwrap();
    folder
}

fn read(plan: &str) -> Result<RigPlan, InputError> {
    read_plan(folder(plan).path().join("plan.toml"))
}

/// The plan with `more` after its first two lines is refused at a line of `more`, with every one of `words`.
#[track_caller]
fn says(more: &str, line: usize, words: &[&str]) {
    let error = read(&format!("{HEAD}{more}")).expect_err("bad input");
    let text = error.render(false);
    assert_eq!(error.path.file_name().unwrap(), "plan.toml", "{text}");
    assert_eq!(error.line(), Some(2 + line), "{text}");
    for word in words {
        assert!(text.contains(word), "`{word}` is missing from\n{text}");
    }
}

#[test]
fn the_example_plans_are_read_and_have_the_levels_of_the_paper() {
    let examples = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/frictional-support");
    let plan = read_plan(examples.join("rig.toml")).unwrap_or_else(|error| panic!("{}", error.render(false)));
    let TestKind::SteppedSine(levels) = &plan.plan.tests[0].kind else { panic!("a stepped sine") };
    assert_eq!(levels.amplitudes, [20.0, 30.0, 40.0, 50.0, 60.0, 70.0]);
    assert_eq!(levels.frequencies, Frequencies::Resonance);
    let plan = read_plan(examples.join("ring-down.toml")).unwrap();
    let TestKind::RingDown(free) = &plan.plan.tests[0].kind else { panic!("a ring-down") };
    assert_eq!(free.from, [Release::Held(40.0)]);
}

/// Found by mutated plans: the list of so many frequencies was made before it was looked at, which ended the process.
#[test]
fn more_frequencies_than_have_room_are_refused() {
    let sine = "[[stepped_sine]]\namplitude = 20\nfrom = 50\nto = 52\n";
    says(&format!("{sine}count = 4294967296\n"), 5, &["count", "from 2 to 10000"]);
    says(&format!("{sine}count = 1\n"), 5, &["from 2 to 10000"]);
    let around = "[[stepped_sine]]\namplitude = 20\nfrequency = \"resonance\"\nband = 2\n";
    says(&format!("{around}count = 1e12\n"), 5, &["from 2 to 10000"]);
}

#[test]
fn tests_keep_their_order_and_sensors_their_channels() {
    let sensors = "[sensors]\npositions = [0.5, 0.2]\nmass = [0.01, 0.02]\nnoise = 0.02\nseed = 7\n\
                   gain = { \"acceleration:x=0.20\" = 1.1 }\ndelay = { excitation = 1e-4 }\nnoise_told = true\n";
    let sine =
        "[[stepped_sine]]\nname = \"held\"\namplitude = 20\nfrom = 50\nto = 52\ncount = 5\nuse = \"fit\"\n";
    let ring_down = "[[ring_down]]\nforce = 3\nduration = 1\nsampling = 1000\n";
    let plan = read(&format!("{HEAD}{sensors}{RANDOM}{sine}{ring_down}{RANDOM}")).unwrap().plan;
    let names: Vec<&str> = plan.tests.iter().map(|test| test.name.as_str()).collect();
    assert_eq!(names, ["random-1", "held", "ring-down", "random-2"]);
    assert_eq!(plan.tests[1].use_for, Some(Use::Fit));
    let TestKind::SteppedSine(held) = &plan.tests[1].kind else { panic!("a stepped sine") };
    assert_eq!(held.frequencies, Frequencies::List(vec![50.0, 50.5, 51.0, 51.5, 52.0]));
    let seeds = [0, 3].map(|index| match &plan.tests[index].kind {
        TestKind::Random(random) => random.seed,
        _ => panic!("a random force"),
    });
    assert_ne!(seeds[0], seeds[1]);
    let sensors: Vec<(f64, f64)> = plan.sensors.iter().map(|sensor| (sensor.position, sensor.mass)).collect();
    assert_eq!(sensors, [(0.5, 0.01), (0.2, 0.02)]);
    let chain = &plan.chain;
    assert_eq!((chain.excitation.delay, chain.excitation.gain), (1e-4, 1.0));
    assert_eq!((chain.accelerometers[1].gain, chain.accelerometers[0].gain), (1.1, 1.0));
    assert!(chain.accelerometers.iter().all(|fault| fault.noise == NoiseLevel::Fraction(0.02)));
    assert_eq!((chain.seed, chain.noise_told), (7, true));
}

#[test]
fn without_a_list_the_sensors_are_those_of_the_model() {
    let plan = read(&format!("{HEAD}{RANDOM}")).unwrap().plan;
    let positions: Vec<f64> = plan.sensors.iter().map(|sensor| sensor.position).collect();
    assert_eq!(positions, [0.55, 0.3, 0.1]);
}

#[test]
fn what_is_wrong_is_said_at_its_line() {
    let sine = "[[stepped_sine]]\n";
    says(&format!("[sensors]\nnois = 1\n{RANDOM}"), 2, &["unknown key `nois`", "did you mean `noise`"]);
    says(&format!("[sensor]\n{RANDOM}"), 1, &["unknown key `sensor`", "`sensors`"]);
    says(&format!("[sensors]\ngain = {{ acceleration = 1 }}\n{RANDOM}"), 2, &["no channel", "x=0.55"]);
    says(&format!("[sensors]\ndelay = 2\n{RANDOM}"), 2, &["delay", "0.1 s"]);
    says(&format!("[sensors]\npositions = [0.3, 0.7]\n{RANDOM}"), 2, &["0.7", "0 to 0.6"]);
    says(&format!("[sensors]\npositions = [0.3, 0.3]\n{RANDOM}"), 2, &["two sensors"]);
    says(&format!("[sensors]\nmass = [0.1]\n{RANDOM}"), 2, &["3 sensors"]);
    says(&format!("[sensors]\nnoise = 0.1\nnoise_deviation = 0.1\n{RANDOM}"), 3, &["both"]);
    says(&RANDOM.replace("sampling = 1000", "sampling = -1"), 5, &["above 0", "-1"]);
    says(&RANDOM.replace("200]", "600]"), 1, &["half the sampling"]);
    says(&RANDOM.replace("[10, 200]", "[200, 10]"), 3, &["begin below"]);
    says(&RANDOM.replace("force = 0.1", ""), 1, &["`force` is missing"]);
    says(sine, 1, &["`amplitude` is missing", "m/s^2"]);
    says(&format!("{sine}amplitude = 20\nfrequency = \"resonanse\"\n"), 3, &["did you mean `resonance`"]);
    says(&format!("{sine}amplitude = 20\n"), 1, &["`frequency` is missing", "from"]);
    says(&format!("{sine}amplitude = 20\nfrequency = 50\nfrom = 20\n"), 4, &["`frequency` needs none of"]);
    says(&format!("{sine}amplitude = [20, 0]\nfrequency = 50\n"), 2, &["above 0"]);
    says(&format!("{sine}amplitude = 20\nfrequency = 50\nperiods = 2.5\n"), 4, &["whole number"]);
    says(&format!("{RANDOM}name = \"../x\"\n"), 6, &["no name of a test"]);
    says(&format!("{RANDOM}name = \"a\"\n{RANDOM}name = \"a\"\n"), 12, &["two tests are called \"a\""]);
    says("[[ring_down]]\namplitude = 2\nforce = 3\nduration = 1\nsampling = 1000\n", 3, &["not from both"]);
    let error = read(HEAD).unwrap_err().render(false);
    assert!(error.contains("no test") && error.contains("[[random]]"), "{error}");
}

/// A pin rig in place of the beam.
fn on_a_rig(more: &str) -> TempDir {
    let folder = folder(&format!("{HEAD}{more}"));
    let rig = include_str!("../../../../examples/slip-slap/model.toml");
    fs::write(folder.path().join("model.toml"), rig).unwrap();
    folder
}

#[test]
fn a_pin_rig_is_tested_in_dual_mode_alone() {
    let examples = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/slip-slap");
    let plan = read_plan(examples.join("rig.toml")).unwrap_or_else(|error| panic!("{}", error.render(false)));
    let TestKind::DualMode(held) = &plan.plan.tests[0].kind else { panic!("dual mode") };
    assert_eq!(held.amplitudes, [[14.0, 34.0], [17.5, 42.5], [20.0, 50.0]]);
    assert_eq!((held.frequency, held.periods), (52.0, 8));
    // Both harmonics of a list each, and on a beam, too.
    let dual = "[[dual_mode]]\nfirst = 7\nthird = 17\nfrequency = 52\n";
    assert!(read(&format!("{HEAD}{dual}")).is_ok());
    says(&dual.replace("= 17", "= [17, 18]"), 3, &["2 of `third` for 1 of `first`"]);
    says(&dual.replace("frequency", "frequencies"), 4, &["did you mean `frequency`"]);
    says(&dual.replace("first = 7\n", ""), 1, &["`first` is missing", "m/s^2"]);
    says(&format!("{dual}harmonics = 2\n"), 5, &["from 3"]);
    let error = read_plan(on_a_rig(&format!("{dual}{RANDOM}")).path().join("plan.toml")).unwrap_err();
    assert!(
        error.line() == Some(7) && error.render(false).contains("[[dual_mode]]"),
        "{}",
        error.render(false)
    );
}

#[test]
fn a_list_of_releases_makes_a_record_each() {
    let decays = "[[ring_down]]\namplitude = [20, 40]\nduration = 0.1\nsampling = 1000\n";
    let plan = read(&format!("{HEAD}{decays}")).unwrap().plan;
    let TestKind::RingDown(free) = &plan.tests[0].kind else { panic!("a ring-down") };
    assert_eq!(free.from, [Release::Held(20.0), Release::Held(40.0)]);
    assert_eq!(plan.record_names(), [["ring-down-1.csv", "ring-down-2.csv"]]);
    let pulled = read(&format!("{HEAD}{}", decays.replace("amplitude", "force"))).unwrap();
    let records = test_on(&pulled.model, &pulled.plan, &mut |_| true).unwrap();
    let largest = |record: usize| {
        let values = records[record].channels_of("acceleration").flat_map(|channel| &channel.values);
        values.fold(0.0_f64, |most, value| most.max(value.abs()))
    };
    assert!(largest(1) > 1.5 * largest(0), "{} and {}", largest(0), largest(1));
    says(&decays.replace("40", "0"), 2, &["above 0"]);
    says(&decays.replace("[20, 40]", "[]"), 2, &["one or several"]);
}

#[test]
fn a_model_that_is_missing_or_no_beam_is_said_where_it_is_named() {
    let error = read(&HEAD.replace("model.toml", "none.toml")).unwrap_err();
    assert_eq!(error.line(), Some(2), "{}", error.render(false));
    let folder = folder(&format!("{HEAD}{RANDOM}"));
    let oscillator = include_str!("../../../../examples/friction-vibration/model.toml");
    fs::write(folder.path().join("model.toml"), oscillator).unwrap();
    let error = read_plan(folder.path().join("plan.toml")).unwrap_err();
    assert!(error.line() == Some(2) && error.render(false).contains("\"beam\""), "{}", error.render(false));
}

#[test]
fn a_dataset_reads_back_as_it_was_written() {
    let sensors = "[sensors]\nnoise = 0.02\nnoise_told = true\n";
    let ring_down = "[[ring_down]]\nforce = 3\nduration = 0.1\nsampling = 1000\nuse = \"confirm\"\n";
    let plan = read(&format!("{HEAD}{sensors}{RANDOM}{ring_down}")).unwrap();
    let records = test_on(&plan.model, &plan.plan, &mut |_| true).unwrap();
    let dataset = Dataset { title: Some("A \"title\"\twith signs".into()), records };
    let folder = TempDir::new().unwrap();
    let text = dataset_toml(&dataset);
    fs::write(folder.path().join("dataset.toml"), text).unwrap();
    for record in &dataset.records {
        fs::write(folder.path().join(&record.name), record_csv(record)).unwrap();
    }
    let again = read_dataset(folder.path()).unwrap_or_else(|error| panic!("{}", error.render(false)));
    assert_eq!(again.title, dataset.title);
    assert_eq!(again.records[1].regime, Regime::UnknownInitialState);
    for (again, written) in again.records.iter().zip(&dataset.records) {
        assert_eq!(
            (&again.name, again.regime, again.use_for),
            (&written.name, written.regime, written.use_for)
        );
        assert_eq!(again.time(), written.time());
        for (again, written) in again.channels.iter().zip(&written.channels) {
            assert_eq!((&again.name, again.unit), (&written.name, written.unit));
            let close = |a: f64, b: f64| (a - b).abs() <= 1e-9 * b.abs();
            assert!(again.values.iter().zip(&written.values).all(|(a, b)| close(*a, *b)));
            assert!(again.noise.zip(written.noise).is_none_or(|(a, b)| close(a, b)));
            assert_eq!(again.noise.is_some(), written.noise.is_some());
        }
    }
}
