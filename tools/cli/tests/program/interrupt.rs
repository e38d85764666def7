//! Signals that ask the program to end, as a user or a system sends them.
#![cfg(target_os = "linux")]

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use tempfile::TempDir;

use crate::{external, unruly};

/// A simulation whose FMU does not come back from a step.
struct Hung {
    folder: TempDir,
    temporary: PathBuf,
    child: Child,
}

/// The tests themselves may have been started by `nohup`.
fn hangups_are_ignored() -> bool {
    let status = fs::read_to_string("/proc/self/status").unwrap();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:")).unwrap().trim();
    u64::from_str_radix(mask, 16).unwrap() & 1 != 0
}

impl Hung {
    fn new(more: &[&str]) -> Self {
        Self::started_by(Command::new(env!("CARGO_BIN_EXE_stickslip")), more)
    }

    fn started_by(mut program: Command, more: &[&str]) -> Self {
        let (folder, _) = unruly::file();
        let temporary = folder.path().join("temporary");
        fs::create_dir(&temporary).unwrap();
        let sign = folder.path().join("hangs");
        let child = program
            .current_dir(folder.path())
            .env("TMPDIR", &temporary)
            .env("UNRULY_SIGN", &sign)
            .args(["simulate", "Unruly.fmu", "--stop", "1", "--step", "0.1", "--set", "behaviour=10"])
            .args(["--out", "r.csv"])
            .args(more)
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        wait_for("the FMU to hang", || sign.exists());
        Self { folder, temporary, child }
    }

    fn send(&self, signal: &str) {
        let id = self.child.id().to_string();
        assert!(Command::new("kill").args([signal, &id]).status().unwrap().success());
    }

    /// The end of the program, after which nothing temporary and no process of it may be there.
    fn end(self) -> (TempDir, Output) {
        let Self { folder, temporary, child } = self;
        let output = child.wait_with_output().unwrap();
        assert_eq!(output.status.code(), Some(130), "{output:?}");
        assert_eq!(fs::read_dir(&temporary).unwrap().count(), 0, "temporary folders are left");
        wait_for("its processes to end", || !is_named_by_a_process(&temporary));
        (folder, output)
    }
}

fn files_in(folder: &Path) -> usize {
    fs::read_dir(folder).unwrap().count()
}

fn wait_for(what: &str, done: impl Fn() -> bool) {
    let begin = Instant::now();
    while !done() {
        assert!(begin.elapsed() < Duration::from_secs(60), "waited for {what}");
        std::thread::sleep(Duration::from_millis(10));
    }
}

/// Whether a process has the path in its command line.
fn is_named_by_a_process(path: &Path) -> bool {
    let path = path.to_str().unwrap();
    let processes = fs::read_dir("/proc").unwrap().flatten();
    processes
        .filter_map(|entry| fs::read(entry.path().join("cmdline")).ok())
        .any(|line| String::from_utf8_lossy(&line).contains(path))
}

/// One signal ends a run whose FMU hangs in its own process and keeps the results.
fn ends_in_order(signal: &str) {
    let hung = Hung::new(&["--isolate"]);
    let begin = Instant::now();
    hung.send(signal);
    let (folder, output) = hung.end();
    assert!(begin.elapsed() < Duration::from_secs(4), "{:?}", begin.elapsed());
    let table = String::from_utf8_lossy(&output.stdout);
    assert!(table.contains("its process was ended") && table.contains("Unruly.fmu"), "{table}");
    let csv = fs::read_to_string(folder.path().join("r.csv")).unwrap();
    assert_eq!(csv.lines().count(), 1 + 5, "{signal}: {csv}");
}

#[test]
fn one_signal_ends_a_run_whose_fmu_hangs_in_its_own_process_and_keeps_the_results() {
    ends_in_order("-INT");
    ends_in_order("-TERM");
}

#[test]
fn a_hangup_ends_a_run_whose_fmu_hangs_in_its_own_process_and_keeps_the_results() {
    if hangups_are_ignored() {
        return external::skip("hangups are ignored here, as `nohup` has it");
    }
    ends_in_order("-HUP");
}

#[test]
fn a_run_that_was_started_by_nohup_goes_on_when_the_terminal_is_closed() {
    let mut program = Command::new("sh");
    program.args(["-c", "trap '' HUP; exec \"$0\" \"$@\"", env!("CARGO_BIN_EXE_stickslip")]);
    let mut hung = Hung::started_by(program, &["--isolate"]);
    hung.send("-HUP");
    std::thread::sleep(Duration::from_secs(2));
    assert!(hung.child.try_wait().unwrap().is_none());
    hung.send("-TERM");
    hung.end();
}

#[test]
fn the_second_signal_ends_a_run_whose_fmu_hangs_in_this_process() {
    let hung = Hung::new(&["--no-isolate"]);
    hung.send("-TERM");
    std::thread::sleep(Duration::from_millis(100));
    hung.send("-TERM");
    hung.end();
}

#[test]
fn the_process_of_an_fmu_that_hangs_ends_with_a_master_that_is_killed_and_nothing_temporary_is_left() {
    for more in [&["--isolate"][..], &[], &["--no-isolate"]] {
        let mut hung = Hung::new(more);
        assert_ne!(files_in(&hung.temporary), 0);
        hung.child.kill().unwrap();
        hung.child.wait().unwrap();
        wait_for("its processes to end", || !is_named_by_a_process(&hung.temporary));
        wait_for("temporary folders to be removed", || files_in(&hung.temporary) == 0);
    }
}
