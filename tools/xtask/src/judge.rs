//! Every judge over every standard FMU, each in an environment of its own, and a suite of calls in C: written to
//! `benches/judges.md`.

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::{cargo, cargo_command, python_environment, root, run, target};

/// Packages, which are judges, and their scripts in `tests/judges/`. The environment of each is in
/// `tests/judges/requirements/`.
const JUDGES: [(&str, &str); 8] = [
    ("fmpy", "judge_fmpy.py"),
    ("fmuloader", "judge_fmuloader.py"),
    ("libcosimpy", "judge_libcosimpy.py"),
    ("ecospy", "judge_ecospy.py"),
    ("cofmupy", "judge_cofmupy.py"),
    ("pathsim-fmi", "judge_pathsim.py"),
    ("fmu-manipulation-toolbox", "judge_fmutool.py"),
    ("fmu-runner", RUST),
];

/// Of a judge that is a crate: `tests/judges/PACKAGE/` is a program with it.
const RUST: &str = "";

/// A judge in its environment.
struct Judge {
    package: &'static str,
    version: String,
    program: PathBuf,
    /// What a program has before the FMU on its command line.
    script: Option<PathBuf>,
}

/// Exports the FMUs, asks all judges, and writes the page.
pub fn judge() -> Result<(), String> {
    cargo(&["build", "--locked", "--package", "stickslip-cli"], &[])?;
    let program = target().join("debug/stickslip").with_extension(std::env::consts::EXE_EXTENSION);
    let folder = target().join("fmus-to-judge");
    let _ = fs::remove_dir_all(&folder);
    run(Command::new(program).args(["fmu", "--out"]).arg(&folder))?;
    let fmus = fmus(&folder)?;
    let mut page = String::from(
        "# What other programs say of the standard FMUs\n\nWritten by `cargo xtask judge`. Every judge runs in an environment of \
         its own (`tests/judges/requirements/`) and steps every FMU through the stimuli that the FMU carries; \"good\" means that it has no remark \
         and finds every output that the library finds without FMI, within 1e-9 of its largest value.\n\n\
         | judge | version | FMU | result | remark |\n|---|---|---|---|---|\n",
    );
    for (package, script) in JUDGES {
        let judge = Judge::prepare(package, script)?;
        for fmu in &fmus {
            let (result, remark) = judge.ask(fmu);
            let name = fmu.file_stem().unwrap_or_default().to_string_lossy();
            println!("{package} {}: {name}: {result}: {remark}", judge.version);
            let remark = remark.replace('|', "\\|");
            let _ = writeln!(page, "| {package} | {} | {name} | {result} | {remark} |", judge.version);
        }
    }
    page.push_str(AT_FAULT);
    let (calls, broken) = suite(&folder, &fmus)?;
    page.push_str(&calls);
    let file = root().join("benches/judges.md");
    fs::write(&file, page).map_err(|error| format!("{}: {error}", file.display()))?;
    if broken == 0 { Ok(()) } else { Err(format!("the suite of calls found {broken} broken promises")) }
}

/// Why some of them have something to say.
const AT_FAULT: &str = include_str!("../../../tests/judges/at-fault.md");

fn fmus(folder: &Path) -> Result<Vec<PathBuf>, String> {
    let entries = fs::read_dir(folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    let files = entries.flatten().map(|entry| entry.path());
    let mut fmus: Vec<PathBuf> =
        files.filter(|file| file.extension().is_some_and(|extension| extension == "fmu")).collect();
    fmus.sort();
    Ok(fmus)
}

impl Judge {
    /// The judge, ready to be asked.
    fn prepare(package: &'static str, script: &str) -> Result<Self, String> {
        if script == RUST { Self::built(package) } else { Self::installed(package, script) }
    }

    /// A crate with its program.
    fn built(package: &'static str) -> Result<Self, String> {
        let manifest = root().join("tests/judges").join(package).join("Cargo.toml");
        let text =
            fs::read_to_string(&manifest).map_err(|error| format!("{}: {error}", manifest.display()))?;
        let version = text.split_once(&format!("{package} = \"=")).and_then(|(_, rest)| rest.split_once('"'));
        let (version, _) = version.ok_or_else(|| format!("{} does not pin {package}", manifest.display()))?;
        let folder = target().join("judges").join(package);
        let mut build = cargo_command(&["build", "--quiet", "--locked", "--manifest-path"]);
        run(build.arg(&manifest).arg("--target-dir").arg(&folder))?;
        let program = folder.join("debug").join(format!("judge-{package}"));
        Ok(Self { package, version: version.to_owned(), program, script: None })
    }

    /// A package in its environment, which is made anew where its requirements have changed.
    fn installed(package: &'static str, script: &str) -> Result<Self, String> {
        let folder = root().join("tests/judges");
        let requirements = folder.join(format!("requirements/{package}.txt"));
        let wanted = fs::read_to_string(&requirements)
            .map_err(|error| format!("{}: {error}", requirements.display()))?;
        let same = |line: &&str| {
            line.split_once("==")
                .is_some_and(|(name, _)| name.replace('_', "-").eq_ignore_ascii_case(package))
        };
        let version = wanted.lines().find(same).and_then(|line| line.split_once("=="));
        let (_, version) = version.ok_or_else(|| format!("{} has no {package}", requirements.display()))?;
        let environment = target().join("judges").join(package);
        let python = environment.join(if cfg!(windows) { "Scripts/python.exe" } else { "bin/python" });
        let stamp = environment.join("requirements-installed.txt");
        if !fs::read_to_string(&stamp).is_ok_and(|installed| installed == wanted) {
            let _ = fs::remove_dir_all(&environment);
            run(Command::new("python3").args(["-m", "venv"]).arg(&environment))?;
            let mut install = Command::new(&python);
            install.args(["-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--no-deps"]);
            run(install.arg("--requirement").arg(&requirements))?;
            fs::write(&stamp, &wanted).map_err(|error| format!("{}: {error}", stamp.display()))?;
        }
        let script = Some(folder.join(script));
        Ok(Self { package, version: version.trim().to_owned(), program: python, script })
    }

    /// Result and remark, in a process of its own: one that ends by a signal has failed.
    fn ask(&self, fmu: &Path) -> (String, String) {
        let mut command = Command::new(&self.program);
        command.args(&self.script).arg(fmu).env("PYTHONDONTWRITEBYTECODE", "1");
        // The library of one needs that of another package, which is beside the interpreter.
        let beside = self.program.ancestors().nth(2).map(|environment| environment.join("lib"));
        command.env("LD_LIBRARY_PATH", beside.unwrap_or_default());
        let output = match command.output() {
            Ok(output) => output,
            Err(error) => {
                return ("fails".to_owned(), format!("{} cannot be started: {error}", self.package));
            }
        };
        let text = String::from_utf8_lossy(&output.stdout);
        let said = text.lines().filter_map(|line| line.strip_prefix("JUDGED ")).next_back();
        match said.and_then(|said| said.split_once(' ')) {
            Some((result, remark)) if output.status.success() => (result.to_owned(), remark.to_owned()),
            _ => ("fails".to_owned(), format!("ended with {}", output.status)),
        }
    }
}

/// The suite of calls over every FMU, in C, and once more under valgrind where that is installed: a table, and how many
/// runs of it failed.
fn suite(folder: &Path, fmus: &[PathBuf]) -> Result<(String, usize), String> {
    let python = python_environment()?;
    let program = compiled_suite(folder, &python)?;
    let locales = folder.join("locales");
    fs::create_dir_all(&locales).map_err(|error| format!("{}: {error}", locales.display()))?;
    let comma =
        Command::new("localedef").args(["-i", "de_DE", "-f", "UTF-8"]).arg(locales.join("comma")).status();
    let mut text = format!(
        "\n## Calls that no importer makes\n\n`tests/judges/suite.c`, for each FMU: random calls in any order with odd arguments, states \
         with changed bytes, threads with an instance each{}, memory over {RESETS} resets. Under valgrind the same with \
         a hundredth of the calls.\n\n| FMU | | random calls | refused | corrupted states, all refused | threads | kB \
         grown | valgrind |\n|---|---|---|---|---|---|---|---|\n",
        if comma.is_ok_and(|status| status.success()) { " under a locale with a decimal comma" } else { "" },
    );
    let mut broken = 0;
    for fmu in fmus {
        let name = fmu.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let unpacked = Unpacked::new(folder, fmu, &name, &python)?;
        let output = unpacked.command(Command::new(&program), CALLS, &locales).output();
        let output = output.map_err(|error| format!("{}: {error}", program.display()))?;
        let figures = String::from_utf8_lossy(&output.stdout).trim().to_owned();
        let mut valgrind = Command::new("valgrind");
        valgrind.args(["--quiet", "--error-exitcode=9", "--leak-check=full"]).arg(&program);
        let checked = match unpacked.command(valgrind, CALLS / 100, &locales).output() {
            Err(_) => "not installed".to_owned(),
            Ok(output) if output.status.success() => "no error, no leak".to_owned(),
            Ok(output) => {
                broken += 1;
                format!("{}: {}", output.status, String::from_utf8_lossy(&output.stderr)).replace('\n', " ")
            }
        };
        broken += usize::from(!output.status.success());
        let done = if output.status.success() { "good" } else { "fails" };
        println!("{name}: {done}: {figures} | {checked}");
        let _ = writeln!(text, "| {name} | {done} | {figures} | {checked} |");
    }
    Ok((text, broken))
}

/// Random calls for each FMU, and resets that follow from them (see suite.c).
const CALLS: u32 = 1_000_000;
const RESETS: u32 = CALLS / 5;

/// The suite, compiled with the headers that FMPy has.
fn compiled_suite(folder: &Path, python: &Path) -> Result<PathBuf, String> {
    let program = folder.join("suite");
    let mut headers = Command::new(python);
    headers
        .args(["-c", "import fmpy, pathlib; print(pathlib.Path(fmpy.__file__).parent / 'c-code', end='')"]);
    let headers = headers.output().map_err(|error| format!("{}: {error}", python.display()))?;
    let headers = String::from_utf8_lossy(&headers.stdout).into_owned();
    let mut compile = Command::new("cc");
    compile.args(["-std=c11", "-O1", "-g", "-Wall", "-Wextra", "-Werror", "-isystem", &headers, "-o"]);
    compile.arg(&program).arg(root().join("tests/judges/suite.c")).args(["-ldl", "-lpthread", "-lm"]);
    run(&mut compile)?;
    Ok(program)
}

/// What the suite is told of an FMU.
struct Unpacked {
    library: PathBuf,
    guid: String,
    resources: String,
}

impl Unpacked {
    fn new(folder: &Path, fmu: &Path, name: &str, python: &Path) -> Result<Self, String> {
        let unpacked = folder.join(name);
        run(Command::new(python).args(["-m", "zipfile", "-e"]).arg(fmu).arg(&unpacked))?;
        let xml = fs::read_to_string(unpacked.join("modelDescription.xml"));
        let xml = xml.map_err(|error| format!("{name}: {error}"))?;
        let guid = xml.split_once("guid=\"").and_then(|(_, rest)| rest.split_once('"'));
        Ok(Self {
            library: unpacked.join(format!("binaries/linux64/{name}.so")),
            guid: guid.map(|(guid, _)| guid.to_owned()).unwrap_or_default(),
            resources: format!("file://{}", unpacked.join("resources").display()),
        })
    }

    fn command(&self, mut command: Command, calls: u32, locales: &Path) -> Command {
        command.arg(&self.library).args([&self.guid, &self.resources, &calls.to_string()]);
        command.env("LOCPATH", locales);
        command
    }
}
