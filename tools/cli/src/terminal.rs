//! What the terminal shows: how much, where, and whether in colours.

use std::io::IsTerminal as _;
use std::sync::atomic::{AtomicBool, Ordering};

/// Whether only errors are shown.
static QUIET: AtomicBool = AtomicBool::new(false);
/// Whether standard output is a file that was asked for (`--json -`).
static DATA: AtomicBool = AtomicBool::new(false);

/// From here on only errors are shown.
pub fn be_quiet() {
    QUIET.store(true, Ordering::Relaxed);
}

/// Whether notes, tables and progress are left out.
pub fn is_quiet() -> bool {
    QUIET.load(Ordering::Relaxed)
}

/// From here on standard output holds one result and nothing else.
pub fn keep_for_data() {
    DATA.store(true, Ordering::Relaxed);
}

/// Whether standard output is for people.
pub fn is_for_people() -> bool {
    !is_quiet() && !DATA.load(Ordering::Relaxed)
}

/// Whether standard output shows colours.
pub fn colored() -> bool {
    std::io::stdout().is_terminal() && wants_colors()
}

/// Whether standard error does.
pub fn errors_are_colored() -> bool {
    std::io::stderr().is_terminal() && wants_colors()
}

/// Whether standard error is a terminal on which a line can be written over.
pub fn moves_its_cursor() -> bool {
    std::io::stderr().is_terminal() && !is_dumb()
}

/// NO_COLOR, set to anything but nothing, asks for none (no-color.org).
fn wants_colors() -> bool {
    std::env::var_os("NO_COLOR").is_none_or(|value| value.is_empty()) && !is_dumb()
}

fn is_dumb() -> bool {
    std::env::var_os("TERM").is_some_and(|kind| kind == "dumb")
}

/// `word` as a shell takes it as one.
pub fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_alphanumeric() || "-_./=:,@%+".contains(c);
    if !word.is_empty() && word.chars().all(plain) {
        return word.to_owned();
    }
    format!("'{}'", word.replace('\'', "'\\''"))
}
