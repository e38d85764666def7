//! A judge in its environment: installed where that is needed, and asked about one FMU at a time.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use super::printed;
use crate::{cargo_command, root, run, target};

/// How a judge is had.
#[derive(Clone, Copy)]
pub enum Kind {
    /// A package of Python, with the environment of `tests/judges/requirements/` and a script of `tests/judges/`.
    Package(&'static str),
    /// A crate that is a library: `tests/judges/PACKAGE/` is a program with it.
    Library,
    /// A crate that is a program, and the script of `tests/judges/` that runs it; its environment has what it is built with.
    Program { version: &'static str, script: &'static str },
}

/// A judge in its environment.
pub struct Judge {
    pub package: &'static str,
    pub version: String,
    program: PathBuf,
    /// What a program has before the FMU on its command line.
    arguments: Vec<PathBuf>,
}

impl Judge {
    /// The judge, ready to be asked.
    pub fn prepare(package: &'static str, kind: Kind) -> Result<Self, String> {
        match kind {
            Kind::Package(script) => Self::in_python(package, script),
            Kind::Library => Self::built(package),
            Kind::Program { version, script } => Self::installed(package, version, script),
        }
    }

    /// A crate with its program.
    fn built(package: &'static str) -> Result<Self, String> {
        let manifest = folder().join(package).join("Cargo.toml");
        let text =
            fs::read_to_string(&manifest).map_err(|error| format!("{}: {error}", manifest.display()))?;
        let version = text.split_once(&format!("{package} = \"=")).and_then(|(_, rest)| rest.split_once('"'));
        let (version, _) = version.ok_or_else(|| format!("{} does not pin {package}", manifest.display()))?;
        let folder = environment(package);
        let mut build = cargo_command(&["build", "--quiet", "--locked", "--manifest-path"]);
        run(build.arg(&manifest).arg("--target-dir").arg(&folder))?;
        let program = folder.join("debug").join(format!("judge-{package}"));
        Ok(Self { package, version: version.to_owned(), program, arguments: Vec::new() })
    }

    /// A program from its crate, with the versions of other crates that it was published with. They read C headers by a
    /// library of Clang, which knows no standard headers, so that those of the compiler here are told.
    fn installed(package: &'static str, version: &str, script: &str) -> Result<Self, String> {
        let (python, _) = with_requirements(package)?;
        let place = "import clang.native, pathlib; print(pathlib.Path(clang.native.__file__).parent)";
        let clang = printed(Command::new(&python).args(["-c", place]))?;
        let headers = printed(Command::new("cc").arg("-print-file-name=include"))?;
        let environment = environment(package);
        let mut install = cargo_command(&["install", "--quiet", "--debug", "--locked", "--root"]);
        install.arg(&environment).arg("--version").arg(format!("={version}")).arg(package);
        install.env("LIBCLANG_PATH", clang).env("BINDGEN_EXTRA_CLANG_ARGS", format!("-isystem {headers}"));
        run(&mut install)?;
        let program = environment.join("bin").join(package).with_extension(std::env::consts::EXE_EXTENSION);
        let arguments = vec![folder().join(script), program];
        Ok(Self { package, version: version.to_owned(), program: python, arguments })
    }

    /// A package in its environment.
    fn in_python(package: &'static str, script: &str) -> Result<Self, String> {
        let (python, installed) = with_requirements(package)?;
        let same = |line: &&str| {
            line.split_once("==")
                .is_some_and(|(name, _)| name.replace('_', "-").eq_ignore_ascii_case(package))
        };
        let version = installed.lines().find(same).and_then(|line| line.split_once("=="));
        let (_, version) = version.ok_or_else(|| format!("the requirements of {package} do not pin it"))?;
        let arguments = vec![folder().join(script)];
        Ok(Self { package, version: version.trim().to_owned(), program: python, arguments })
    }

    /// Result and remark, in a process of its own: one that ends by a signal has failed.
    pub fn ask(&self, fmu: &Path) -> (String, String) {
        let mut command = Command::new(&self.program);
        command.args(&self.arguments).arg(fmu).env("PYTHONDONTWRITEBYTECODE", "1");
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

/// The interpreter of an environment, which is made anew where its requirements have changed, and these.
fn with_requirements(package: &str) -> Result<(PathBuf, String), String> {
    let requirements = folder().join(format!("requirements/{package}.txt"));
    let wanted =
        fs::read_to_string(&requirements).map_err(|error| format!("{}: {error}", requirements.display()))?;
    let environment = environment(package);
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
    Ok((python, wanted))
}

/// Where the scripts are.
fn folder() -> PathBuf {
    root().join("tests/judges")
}

/// Where a judge is installed.
fn environment(package: &str) -> PathBuf {
    target().join("judges").join(package)
}
