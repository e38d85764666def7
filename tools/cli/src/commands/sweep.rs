//! The hidden command that removes temporary folders when the program that made them is gone, whatever ended it: a crash
//! of an FMU in it, or a signal that no program can catch.

use std::io::{BufRead as _, Write as _};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::Mutex;

use stickslip_readers::archive;

use crate::Failure;

/// How it is called.
pub const NAME: &str = "sweep";

/// Arguments of `stickslip sweep`, which only this program itself gives.
#[derive(clap::Args)]
pub struct Sweep {}

impl Sweep {
    /// Reads names of folders until the other side goes away, and removes those that are still there.
    pub fn run(self) -> Result<(), Failure> {
        let lines = std::io::stdin().lock().lines();
        let lines = lines.map_while(Result::ok).map(PathBuf::from);
        let folders: Vec<PathBuf> = lines.filter(|folder| ours(folder)).collect();
        // An FMU in another process may still be writing there, until it notices.
        for _ in 0..ATTEMPTS {
            let left = folders.iter().filter(|folder| folder.exists());
            if left.filter(|folder| std::fs::remove_dir_all(folder).is_err()).count() == 0 {
                break;
            }
            std::thread::sleep(std::time::Duration::from_millis(200));
        }
        Ok(())
    }
}

/// How often a folder is tried.
const ATTEMPTS: u32 = 25;

fn ours(folder: &Path) -> bool {
    let name = folder.file_name().unwrap_or_default().to_string_lossy();
    folder.is_absolute() && name.starts_with(archive::PREFIX)
}

/// From here on, what is unpacked is removed with the end of this program, however it ends.
pub fn watch_temporary_folders() {
    let Ok(program) = std::env::current_exe() else { return };
    let mut command = Command::new(program);
    command.arg(NAME).stdin(Stdio::piped()).stdout(Stdio::null()).stderr(Stdio::null());
    // A signal to the whole group of the terminal is not for it.
    #[cfg(unix)]
    std::os::unix::process::CommandExt::process_group(&mut command, 0);
    let Some(to) = command.spawn().ok().and_then(|mut child| child.stdin.take()) else { return };
    let to = Mutex::new(to);
    archive::watch(move |folder: &Path| {
        if let (Ok(mut to), Ok(folder)) = (to.lock(), std::path::absolute(folder)) {
            let _ = writeln!(to, "{}", folder.display());
        }
    });
}
