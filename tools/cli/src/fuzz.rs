//! Mutated inputs for the commands, in this process: no panic, no undocumented exit code, no run over 20 s.
//!
//! `python tests/formats/laboratory_files.py FOLDER` writes files to change, then
//! `FUZZ_FILES=FOLDER FUZZ_SECONDS=900 cargo test --release -p stickslip-cli --bin stickslip fuzz -- --ignored --nocapture > fuzz.txt`
//! spends a tenth of the time on each command and tells the counts on standard error. `FUZZ_RUNS` in place of `FUZZ_SECONDS` makes so many runs
//! of each, `FUZZ_SEED` begins elsewhere, `FUZZ_COMMAND` runs one command alone.

use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::time::{Duration, Instant};

use clap::Parser as _;
use stickslip_fuzz::{Rng, mutate, number};

use crate::{Cli, terminal};

const LONGEST: Duration = Duration::from_secs(20);
/// `lone` is `compare` with a file of measurements alone; `diagnose` has too few records for an answer, `decide` has enough.
const COMMANDS: [&str; 10] =
    ["import", "lone", "check", "modes", "frf", "export", "compare", "add", "diagnose", "decide"];
const CONTACT: &str = r#"schema = "stickslip.model/1"
kind = "contact"
[contact]
law = "jenkins"
tangential_stiffness = 2.0e6
friction_coefficient = 0.5
normal_load = 100.0
residual_stiffness = 1e4
[[effect]]
id = "backlash"
half_gap = 1e-6
[fit]
free = ["contact.*"]
"#;
const OSCILLATOR: &str = r#"schema = "stickslip.model/1"
kind = "oscillator"
mass = [{ name = "m1", mass = 1.0 }, { name = "m2", mass = 0.5 }]
spring = [{ between = ["ground", "m1"], stiffness = 2e5, damping = 5.0 }, { between = ["m1", "m2"], stiffness = 1e5, damping = 3.0 }]
excitation = { at = "m1" }
[contact]
at = "m2"
law = "jenkins"
tangential_stiffness = 1e5
friction_coefficient = 0.5
normal_load = 20.0
"#;
const DATASET: &str = r#"schema = "stickslip.dataset/1"
title = "Loops"
[columns]
"Kraft" = { name = "force", unit = "kN", sign = -1, delay = 1e-4 }
[[record]]
file = "loop.csv"
regime = "unknown-initial-state"
noise = { "force" = 0.001 }
[[record]]
file = "loop-2.csv"
regime = "unknown-initial-state"
use = "confirm"
"#;
/// A third record and a fourth, for a diagnosis that comes to an answer.
const MORE_RECORDS: &str = r#"[[record]]
file = "loop-3.csv"
regime = "unknown-initial-state"
[[record]]
file = "loop-4.csv"
regime = "unknown-initial-state"
"#;
/// Where the last panic was.
static PANIC: Mutex<String> = Mutex::new(String::new());

/// A slider's loop, as a table of a laboratory.
fn table(shift: f64) -> String {
    let (mut text, mut slider) = ("time [s];displacement [mm];Kraft (kN)\n".to_owned(), 0.0);
    for row in 0..48 {
        let moved = 0.05 * (0.2 * f64::from(row) + shift).sin();
        let force = (3000.0 * (moved - slider)).clamp(-60.0, 60.0);
        slider = moved - force / 3000.0;
        text += &format!("{:.4};{moved:.6};{:.6}\n", f64::from(row) * 1e-3, -force * 1e-3);
    }
    text
}

/// The command line of `command`, and the file that is changed for it.
fn words(command: &str, lone: &str, chance: &mut Rng) -> (Vec<String>, String) {
    let model = |chance: &mut Rng| ["model.toml", "curved.toml", "oscillator.toml"][chance.usize(..3)];
    // A curved law costs several times as much as a slider, and its file is read by the same lines.
    let contact = if chance.u8(0..8) == 0 { "curved.toml" } else { "model.toml" };
    let measured = [contact, "data/dataset.toml", "data/loop.csv", "data/loop-2.csv"];
    let changed = measured[chance.usize(..measured.len())];
    let (line, changed) = match command {
        "import" => (format!("import {lone} -o imported"), lone),
        "lone" => (format!("compare {contact} {lone} --no-fit"), lone),
        "check" => match chance.bool() {
            true => (format!("check {contact} data --json out.json"), changed),
            false => {
                let model = model(chance);
                (format!("check {model} --json out.json"), model)
            }
        },
        "modes" => ("modes oscillator.toml --from 1e-5 --to 1e-3 --points 5".to_owned(), "oscillator.toml"),
        "frf" => {
            ("frf oscillator.toml --from 20 --to 200 --force 5 --json out.json".to_owned(), "oscillator.toml")
        }
        "export" => {
            let model = model(chance);
            (format!("export {model} -o X.fmu"), model)
        }
        "decide" => {
            let changed =
                [contact, "four/dataset.toml", "four/loop.csv", "four/loop-3.csv"][chance.usize(..4)];
            (
                format!("diagnose {contact} four --effects backlash,wear --json out.json --report out.html"),
                changed,
            )
        }
        "compare" => (format!("compare {contact} data --json out.json --report out.html --csv out"), changed),
        "add" => {
            let effect = ["backlash", "wear", "contact_damping"][chance.usize(..3)];
            (format!("add {contact} {effect} --fit data -o new.toml"), changed)
        }
        _ => (
            format!("diagnose {contact} data --effects backlash,wear --max-effects 1 --json out.json"),
            changed,
        ),
    };
    (line.split_whitespace().map(str::to_owned).collect(), changed.to_owned())
}

fn is_documented(command: &str, code: u8) -> bool {
    matches!(code, 0..=2) || matches!(command, "diagnose" | "decide") && matches!(code, 10..=14)
}

/// What is wrong with one run, if anything.
fn wrong(command: &str, words: &[String]) -> Option<String> {
    let begin = Instant::now();
    PANIC.lock().unwrap().clear();
    let parsed = Cli::try_parse_from(std::iter::once("stickslip").chain(words.iter().map(String::as_str)));
    let chosen = parsed.expect("legal words").command?;
    let done = catch_unwind(AssertUnwindSafe(|| crate::run(chosen)));
    let panicked = PANIC.lock().unwrap().clone();
    let (code, message) = match done {
        _ if !panicked.is_empty() => return Some(format!("panicked: {panicked}")),
        Err(_) => return Some("panicked".to_owned()),
        Ok(Ok(code)) => (code, "said".to_owned()),
        Ok(Err(failure)) => (failure.code, failure.message),
    };
    if !is_documented(command, code) || message.trim().is_empty() {
        return Some(format!("exit code {code}: {message}"));
    }
    (begin.elapsed() > LONGEST).then(|| format!("took {:.1} s", begin.elapsed().as_secs_f64()))
}

/// A fresh folder with all inputs, of which `changed` is mutated.
fn prepare(folder: &Path, texts: &BTreeMap<String, Vec<u8>>, changed: &str, chance: &mut Rng) {
    let _ = std::fs::remove_dir_all(folder);
    for name in ["data", "four", "files"] {
        std::fs::create_dir_all(folder.join(name)).unwrap();
    }
    for (name, text) in texts {
        if name == changed {
            std::fs::write(folder.join(name), mutate(text.clone(), chance)).unwrap();
        } else if !name.starts_with("files/") {
            std::fs::write(folder.join(name), text).unwrap();
        }
    }
}

fn inputs() -> BTreeMap<String, Vec<u8>> {
    let mut texts: BTreeMap<String, Vec<u8>> = [
        ("model.toml", CONTACT.to_owned()),
        ("curved.toml", CONTACT.replace("\"jenkins\"", "\"valanis\"\nsmoothness = 0.3")),
        ("oscillator.toml", OSCILLATOR.to_owned()),
        ("data/dataset.toml", DATASET.to_owned()),
        ("data/loop.csv", table(0.0)),
        ("data/loop-2.csv", table(0.7)),
        ("four/dataset.toml", DATASET.replace("use = \"confirm\"\n", "") + MORE_RECORDS),
        ("four/loop.csv", table(0.0)),
        ("four/loop-2.csv", table(0.7)),
        ("four/loop-3.csv", table(1.4)),
        ("four/loop-4.csv", table(2.1)),
        ("files/loop.csv", table(0.0).replace("Kraft", "force")),
    ]
    .map(|(name, text)| (name.to_owned(), text.into_bytes()))
    .into();
    if let Some(folder) = std::env::var_os("FUZZ_FILES") {
        for entry in std::fs::read_dir(folder).unwrap().flatten().filter(|entry| entry.path().is_file()) {
            let name = format!("files/{}", entry.file_name().to_string_lossy().replace(' ', "_"));
            texts.insert(name, std::fs::read(entry.path()).unwrap());
        }
    }
    texts
}

#[test]
#[ignore = "a script, run by the command above: it takes as long as it is told to, and changes the folder of its process"]
fn fuzz() {
    let other = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |panic| {
        if std::thread::current().name() != Some(stickslip_readers::GUARDED) {
            *PANIC.lock().unwrap() = panic.to_string();
            other(panic);
        }
    }));
    terminal::be_quiet();
    let texts = inputs();
    let lone: Vec<&String> = texts.keys().filter(|name| name.starts_with("files/")).collect();
    let only = std::env::var("FUZZ_COMMAND").ok();
    let asked: Vec<&str> =
        COMMANDS.into_iter().filter(|command| only.as_deref().is_none_or(|only| only == *command)).collect();
    let most = number("FUZZ_RUNS", u64::MAX);
    let seconds = number("FUZZ_SECONDS", if most == u64::MAX { 10 } else { u64::from(u32::MAX) });
    let share = Duration::from_secs(seconds) / asked.len() as u32;
    let place = tempfile::tempdir().unwrap();
    let folder: PathBuf = place.path().join("run");
    std::fs::create_dir(&folder).unwrap();
    let (mut all, mut faults) = (0_u64, 0);
    for command in asked {
        let (begin, mut runs, mut slowest) = (Instant::now(), 0_u64, Duration::ZERO);
        let first = number("FUZZ_SEED", 0);
        while runs < most && begin.elapsed() < share {
            let seed = first + runs;
            let mut chance = Rng::with_seed(seed);
            let file = lone[chance.usize(..lone.len())];
            let (words, changed) = words(command, file, &mut chance);
            prepare(&folder, &texts, &changed, &mut chance);
            std::env::set_current_dir(&folder).unwrap();
            let one = Instant::now();
            if let Some(reason) = wrong(command, &words) {
                faults += 1;
                eprintln!("{command}, FUZZ_SEED={seed}: {} ({changed} changed): {reason}", words.join(" "));
            }
            slowest = slowest.max(one.elapsed());
            std::env::set_current_dir(place.path()).unwrap();
            runs += 1;
        }
        all += runs;
        eprintln!("{command}: {runs} runs, longest {:.1} s", slowest.as_secs_f64());
    }
    eprintln!("{all} runs, {faults} wrong");
    assert_eq!(faults, 0);
}
