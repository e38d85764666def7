//! Runs the program on cases, several side by side, and keeps what each run said.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};
use serde_json::{Value, json};

use crate::scoring::score::{Diagnosis, Score, score};
use crate::scoring::truth::Truth;

/// A case to run: its files may have to be made first.
pub struct Task {
    /// Name of the case.
    pub name: String,
    /// What it hides.
    pub truth: Truth,
    /// Makes the files unless they are there; the folder.
    pub folder: Box<dyn Fn() -> Result<PathBuf, String> + Send + Sync>,
}

/// A case that was run.
#[derive(Debug, Clone)]
pub struct Outcome {
    /// Name of the case.
    pub name: String,
    /// What it hides.
    pub truth: Truth,
    /// The program's exit code, where there was one.
    pub exit: Option<i32>,
    /// What the program said.
    pub diagnosis: Diagnosis,
    /// How right that is.
    pub score: Score,
}

/// How to run.
#[derive(Clone)]
pub struct Plan {
    /// The program `stickslip`.
    pub program: PathBuf,
    /// Where each run's answer is kept.
    pub results: PathBuf,
    /// Runs side by side.
    pub jobs: usize,
    /// Forget the answers that are there.
    pub fresh: bool,
    /// Take answers that another build of the program gave.
    pub resume: bool,
    /// `NAME=VALUE` that the program is to take for granted instead of what it does.
    pub assume: Option<String>,
    /// How many effects the program may add, where that is not what it does by itself.
    pub max_effects: Option<usize>,
    /// A run that takes longer has failed.
    pub longest: Duration,
}

/// Runs all tasks; what is finished is kept, so that an interrupted run goes on where it was.
///
/// # Errors
/// A program that is not there, a folder that cannot be written, a case that cannot be made.
pub fn run(plan: &Plan, tasks: &[Task]) -> Result<Vec<Outcome>, String> {
    fs::create_dir_all(&plan.results).map_err(|error| format!("{}: {error}", plan.results.display()))?;
    let build = build_of(&plan.program)?;
    let bar = ProgressBar::new(tasks.len() as u64);
    let style = ProgressStyle::with_template("{wide_bar} {pos}/{len} {elapsed} {msg}");
    bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    let next = AtomicUsize::new(0);
    let done = Mutex::new(Vec::new());
    let work = || -> Result<(), String> {
        while let Some(task) = tasks.get(next.fetch_add(1, Ordering::Relaxed)) {
            let kept = if plan.fresh { None } else { kept(plan, task, &build) };
            let (exit, diagnosis) = match kept {
                Some(answer) => answer,
                None => diagnose(plan, task, &build)?,
            };
            let outcome = Outcome {
                name: task.name.clone(),
                truth: task.truth.clone(),
                score: score(&task.truth, &diagnosis),
                exit,
                diagnosis,
            };
            bar.println(format!("{} {:<60} {}", mark(&outcome), outcome.name, outcome.diagnosis.label()));
            let mut done = done.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
            done.push(outcome);
            let right: f64 = done.iter().map(|outcome: &Outcome| outcome.score.right).sum();
            bar.set_message(format!("{right} right"));
            bar.inc(1);
        }
        Ok(())
    };
    thread::scope(|scope| {
        let workers: Vec<_> = (0..plan.jobs.max(1)).map(|_| scope.spawn(work)).collect();
        workers
            .into_iter()
            .try_for_each(|worker| worker.join().unwrap_or_else(|_| Err("a run broke down".into())))
    })?;
    bar.finish_and_clear();
    let mut outcomes = done.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner);
    // In the order of the tasks, whichever finished first.
    outcomes.sort_by_key(|outcome| tasks.iter().position(|task| task.name == outcome.name));
    Ok(outcomes)
}

fn mark(outcome: &Outcome) -> char {
    match outcome.score.right {
        1.0 => '✓',
        0.5 => '½',
        _ => '✗',
    }
}

/// Tells builds of the program apart (FNV-1a of the file).
fn build_of(program: &Path) -> Result<String, String> {
    let bytes = fs::read(program).map_err(|error| {
        format!("{}: {error}; build it with cargo build --release -p stickslip-cli", program.display())
    })?;
    let hash = bytes.iter().fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| {
        (hash ^ u64::from(*byte)).wrapping_mul(0x100_0000_01b3)
    });
    Ok(format!("{hash:016x}"))
}

fn kept(plan: &Plan, task: &Task, build: &str) -> Option<(Option<i32>, Diagnosis)> {
    let text = fs::read_to_string(plan.results.join(format!("{}.json", task.name))).ok()?;
    let kept: Value = serde_json::from_str(&text).ok()?;
    let same_build = kept.get("build").and_then(Value::as_str) == Some(build);
    if !same_build && !plan.resume {
        return None;
    }
    let exit = kept.get("exit").and_then(Value::as_i64).and_then(|code| i32::try_from(code).ok());
    Some((exit, Diagnosis::read(kept.get("diagnosis")?).ok()?))
}

fn diagnose(plan: &Plan, task: &Task, build: &str) -> Result<(Option<i32>, Diagnosis), String> {
    let folder = (task.folder)()?;
    let answer = plan.results.join(format!(".{}.answer.json", task.name));
    let noise = plan.results.join(format!(".{}.errors.txt", task.name));
    let fail = |path: &Path, error: std::io::Error| format!("{}: {error}", path.display());
    let errors = fs::File::create(&noise).map_err(|error| fail(&noise, error))?;
    let mut command = Command::new(&plan.program);
    command.arg("diagnose").arg(folder.join("model.toml")).arg(folder.join("dataset.toml"));
    command.arg("--json").arg(&answer).stdin(Stdio::null()).stdout(Stdio::null()).stderr(errors);
    if let Some(most) = plan.max_effects {
        command.args(["--max-effects", &most.to_string()]);
    }
    command.args(plan.assume.iter().flat_map(|word| ["--assume", word]));
    if plan.jobs > 1 {
        let cores = thread::available_parallelism().map_or(1, usize::from);
        command.env("RAYON_NUM_THREADS", (cores / plan.jobs).max(1).to_string());
    }
    let started = Instant::now();
    let code = wait(&mut command, plan.longest).map_err(|error| fail(&plan.program, error))?;
    let seconds = started.elapsed().as_secs_f64();
    let said = match code {
        // A verdict has a code of its own from ten on.
        Some(0 | 10..=29) => fs::read_to_string(&answer).ok(),
        _ => None,
    };
    let json: Option<Value> = said.and_then(|text| serde_json::from_str(&text).ok());
    let diagnosis = json.as_ref().and_then(|json| Diagnosis::read(json).ok());
    let result = json!({
        "build": build,
        "exit": code,
        "wall_seconds": seconds,
        "diagnosis": json,
        "errors": fs::read_to_string(&noise).unwrap_or_default(),
    });
    let path = plan.results.join(format!("{}.json", task.name));
    let unfinished = plan.results.join(format!(".{}.json", task.name));
    fs::write(&unfinished, format!("{result:#}\n")).map_err(|error| fail(&unfinished, error))?;
    fs::rename(&unfinished, &path).map_err(|error| fail(&path, error))?;
    let _ = fs::remove_file(&answer);
    let _ = fs::remove_file(&noise);
    let mut diagnosis = diagnosis.unwrap_or_else(|| Diagnosis::failed(seconds));
    if !diagnosis.seconds.is_finite() {
        diagnosis.seconds = seconds;
    }
    Ok((code, diagnosis))
}

/// The exit code; `None` when it took too long or was killed.
fn wait(command: &mut Command, longest: Duration) -> std::io::Result<Option<i32>> {
    let mut child = command.spawn()?;
    let started = Instant::now();
    loop {
        if let Some(status) = child.try_wait()? {
            return Ok(status.code());
        }
        if started.elapsed() > longest {
            child.kill()?;
            child.wait()?;
            return Ok(None);
        }
        thread::sleep(Duration::from_millis(20));
    }
}
