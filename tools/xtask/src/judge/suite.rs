//! Calls that no importer makes, in C, over every FMU, and once more under valgrind where that is installed.

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use super::{Fmus, name, printed};
use crate::{root, run};

/// Random calls for each FMU, and resets that follow from them (see suite.c).
const CALLS: u32 = 1_000_000;
const RESETS: u32 = CALLS / 5;

/// What is particular to a version of FMI.
pub struct Suite {
    source: &'static str,
    /// What it does before the calls that both do.
    first: &'static str,
    /// Names of its figures.
    columns: &'static [&'static str],
    /// Of the model, in its description.
    token: &'static str,
    /// Where the library is.
    platform: &'static str,
    /// Before the path of the resources.
    scheme: &'static str,
}

const SUITE_2: Suite = Suite {
    source: "suite.c",
    first: "",
    columns: &["random calls", "refused", "corrupted states, all refused", "threads", "kB grown"],
    token: "guid=\"",
    platform: "linux64",
    scheme: "file://",
};

const SUITE_3: Suite = Suite {
    source: "suite3.c",
    first: "every function in every state, which succeeds where the standard allows it and is an error elsewhere; wrong arguments, all \
            refused; states that go on bit by bit, also in another instance and from their bytes; many instances at once, freed in any \
            state; ",
    columns: &[
        "functions in states, as the standard says",
        "wrong arguments",
        "random calls",
        "refused",
        "corrupted states, all refused",
        "instances at once",
        "threads",
        "kB grown",
    ],
    token: "instantiationToken=\"",
    platform: "x86_64-linux",
    scheme: "",
};

impl Suite {
    /// The suite for a version of FMI.
    pub fn of(fmi: u8) -> &'static Self {
        if fmi == 2 { &SUITE_2 } else { &SUITE_3 }
    }

    /// A section of the page with a row for each FMU, and how many runs failed.
    pub fn over(&self, fmus: &Fmus, python: &Path) -> Result<(String, usize), String> {
        let program = self.compiled(&fmus.folder, python)?;
        let locales = fmus.folder.join("locales");
        fs::create_dir_all(&locales).map_err(|error| format!("{}: {error}", locales.display()))?;
        let mut text = self.heading(fmus.fmi, with_comma(&locales));
        let mut broken = 0;
        for fmu in &fmus.files {
            let name = name(fmu);
            let unpacked = self.unpacked(&fmus.folder, fmu, python)?;
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
                    format!("{}: {}", output.status, String::from_utf8_lossy(&output.stderr))
                        .replace('\n', " ")
                }
            };
            broken += usize::from(!output.status.success());
            let done = if output.status.success() { "good" } else { "fails" };
            println!("FMI {}.0: {name}: {done}: {figures} | {checked}", fmus.fmi);
            let _ = writeln!(text, "| {name} | {done} | {figures} | {checked} |");
        }
        Ok((text, broken))
    }

    /// What is done, and the names of the columns.
    fn heading(&self, fmi: u8, comma: bool) -> String {
        format!(
            "\n## Calls that no importer makes: FMI {fmi}.0\n\n`tests/judges/{}`, for each FMU: {}random calls in any order with odd \
             arguments, states with changed bytes, threads with an instance each{}, memory over {RESETS} resets. Under valgrind \
             the same with a hundredth of the calls.\n\n| FMU | | {} | valgrind |\n|{}\n",
            self.source,
            self.first,
            if comma { " under a locale with a decimal comma" } else { "" },
            self.columns.join(" | "),
            "---|".repeat(self.columns.len() + 3),
        )
    }

    /// The suite, compiled with the headers that FMPy has.
    fn compiled(&self, folder: &Path, python: &Path) -> Result<PathBuf, String> {
        let program = folder.join("suite");
        let place = "import fmpy, pathlib; print(pathlib.Path(fmpy.__file__).parent / 'c-code')";
        let headers = printed(Command::new(python).args(["-c", place]))?;
        let mut compile = Command::new("cc");
        compile.args(["-std=c11", "-O1", "-g", "-Wall", "-Wextra", "-Werror", "-isystem", &headers, "-o"]);
        compile.arg(&program).arg(root().join("tests/judges").join(self.source));
        run(compile.args(["-ldl", "-lpthread", "-lm"]))?;
        Ok(program)
    }

    fn unpacked(&self, folder: &Path, fmu: &Path, python: &Path) -> Result<Unpacked, String> {
        let name = name(fmu);
        let unpacked = folder.join(&name);
        run(Command::new(python).args(["-m", "zipfile", "-e"]).arg(fmu).arg(&unpacked))?;
        let xml = fs::read_to_string(unpacked.join("modelDescription.xml"));
        let xml = xml.map_err(|error| format!("{name}: {error}"))?;
        let token = xml.split_once(self.token).and_then(|(_, rest)| rest.split_once('"'));
        Ok(Unpacked {
            library: unpacked.join(format!("binaries/{}/{name}.so", self.platform)),
            token: token.map(|(token, _)| token.to_owned()).unwrap_or_default(),
            resources: format!("{}{}/", self.scheme, unpacked.join("resources").display()),
        })
    }
}

/// Whether a locale with a decimal comma could be made.
fn with_comma(locales: &Path) -> bool {
    let made =
        Command::new("localedef").args(["-i", "de_DE", "-f", "UTF-8"]).arg(locales.join("comma")).status();
    made.is_ok_and(|status| status.success())
}

/// What the suite is told of an FMU.
struct Unpacked {
    library: PathBuf,
    token: String,
    resources: String,
}

impl Unpacked {
    fn command(&self, mut command: Command, calls: u32, locales: &Path) -> Command {
        command.arg(&self.library).args([&self.token, &self.resources, &calls.to_string()]);
        command.env("LOCPATH", locales);
        command
    }
}
