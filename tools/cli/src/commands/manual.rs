//! `stickslip completions` and `stickslip man`

use clap::Command;
use clap_complete::{Shell, generate};
use clap_mangen::Man;

use crate::Failure;
use crate::output::say_always;

/// Arguments of `stickslip completions`.
#[derive(clap::Args)]
#[command(after_help = "\
Example:
  stickslip completions bash > ~/.local/share/bash-completion/completions/stickslip")]
pub struct Completions {
    /// The shell
    shell: Shell,
}

impl Completions {
    /// Prints what makes the shell complete this program's commands.
    pub fn run(self, mut program: Command) -> Result<(), Failure> {
        let mut text = Vec::new();
        generate(self.shell, &mut program, "stickslip", &mut text);
        say_always(&text)
    }
}

/// Arguments of `stickslip man`.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  stickslip man | man -l -
  stickslip man diagnose > stickslip-diagnose.1")]
pub struct Manual {
    /// The command; without one the page is that of the program
    command: Option<String>,
}

impl Manual {
    /// Prints a page of the manual, in the language of `man`.
    pub fn run(self, mut program: Command) -> Result<(), Failure> {
        // Commands then know their whole names.
        program.build();
        let mut text = Vec::new();
        let page = match &self.command {
            None => program,
            Some(name) => {
                let found = program.find_subcommand(name).filter(|one| !one.is_hide_set());
                let found = found.ok_or_else(|| Failure::input(format!("there is no command `{name}`")))?;
                found.clone()
            }
        };
        let failed = |error: std::io::Error| Failure::other(error.to_string());
        Man::new(page).render(&mut text).map_err(failed)?;
        say_always(&text)
    }
}
