//! Every judge over every standard FMU of both versions of FMI, each in an environment of its own, and suites of calls in
//! C: written to `benches/judges.md`.
//!
//! - `candidate`: how a judge is had, and asked about one FMU.
//! - `suite`: the calls in C, for each version.

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::{cargo, python_environment, root, run, target};

mod candidate;
mod suite;

use candidate::{Judge, Kind};
use suite::Suite;

/// Packages, which are judges, how they are had, and the versions of FMI that they run.
const JUDGES: [(&str, Kind, &[u8]); 9] = [
    ("fmpy", Kind::Package("judge_fmpy.py"), &[2, 3]),
    ("fmuloader", Kind::Package("judge_fmuloader.py"), &[2, 3]),
    ("libcosimpy", Kind::Package("judge_libcosimpy.py"), &[2]),
    ("ecospy", Kind::Package("judge_ecospy.py"), &[2, 3]),
    ("cofmupy", Kind::Package("judge_cofmupy.py"), &[2, 3]),
    ("pathsim-fmi", Kind::Package("judge_pathsim.py"), &[2, 3]),
    ("fmu-manipulation-toolbox", Kind::Package("judge_fmutool.py"), &[2, 3]),
    ("fmu-runner", Kind::Library, &[2]),
    ("fmi-sim", Kind::Program { version: "0.7.0", script: "judge_fmi_sim.py" }, &[3]),
];

/// Why some of them have something to say, and who could not be asked.
const AT_FAULT: &str = include_str!("../../../../tests/judges/at-fault.md");

/// Exports the FMUs, asks all judges, and writes the page.
pub fn judge() -> Result<(), String> {
    cargo(&["build", "--locked", "--package", "stickslip-cli"], &[])?;
    let program = target().join("debug/stickslip").with_extension(std::env::consts::EXE_EXTENSION);
    let exported = [Fmus::export(&program, 2)?, Fmus::export(&program, 3)?];
    let mut page = String::from(
        "# What other programs say of the standard FMUs\n\nWritten by `cargo xtask judge`. Every judge runs in an environment of \
         its own (`tests/judges/requirements/`) and steps every FMU through the stimuli that the FMU carries; \"good\" means that it has no remark \
         and finds every output that the library finds without FMI, within 1e-9 of its largest value.\n\n\
         | judge | version | FMI | FMU | result | remark |\n|---|---|---|---|---|---|\n",
    );
    for (package, kind, versions) in JUDGES {
        let judge = Judge::prepare(package, kind)?;
        for fmus in exported.iter().filter(|fmus| versions.contains(&fmus.fmi)) {
            page.push_str(&fmus.asked(&judge));
        }
    }
    page.push_str(AT_FAULT);
    let python = python_environment()?;
    let mut broken = 0;
    for fmus in &exported {
        let (table, failed) = Suite::of(fmus.fmi).over(fmus, &python)?;
        page.push_str(&table);
        broken += failed;
    }
    let file = root().join("benches/judges.md");
    fs::write(&file, page).map_err(|error| format!("{}: {error}", file.display()))?;
    if broken == 0 { Ok(()) } else { Err(format!("the suites of calls found {broken} broken promises")) }
}

/// The standard FMUs of one version of FMI.
struct Fmus {
    fmi: u8,
    folder: PathBuf,
    files: Vec<PathBuf>,
}

impl Fmus {
    fn export(program: &Path, fmi: u8) -> Result<Self, String> {
        let folder = target().join(format!("fmus-to-judge/fmi{fmi}"));
        let _ = fs::remove_dir_all(&folder);
        let version = fmi.to_string();
        run(Command::new(program).args(["fmu", "--fmi", &version, "--out"]).arg(&folder))?;
        let entries = fs::read_dir(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
        let files = entries.flatten().map(|entry| entry.path());
        let mut files: Vec<PathBuf> =
            files.filter(|file| file.extension().is_some_and(|extension| extension == "fmu")).collect();
        files.sort();
        Ok(Self { fmi, folder, files })
    }

    /// What a judge says of them: rows of the table.
    fn asked(&self, judge: &Judge) -> String {
        let mut rows = String::new();
        for fmu in &self.files {
            let (result, remark) = judge.ask(fmu);
            let (package, version, fmi, name) = (judge.package, &judge.version, self.fmi, name(fmu));
            println!("{package} {version}: FMI {fmi}.0: {name}: {result}: {remark}");
            let remark = remark.replace('|', "\\|");
            let _ = writeln!(rows, "| {package} | {version} | {fmi}.0 | {name} | {result} | {remark} |");
        }
        rows
    }
}

/// The name of the model in an FMU.
fn name(fmu: &Path) -> String {
    fmu.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

/// What a command prints, without the end of the line.
fn printed(command: &mut Command) -> Result<String, String> {
    let output = command.output().map_err(|error| format!("{command:?}: {error}"))?;
    Ok(String::from_utf8_lossy(&output.stdout).trim().to_owned())
}
