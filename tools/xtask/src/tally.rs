//! Runs test programs, passes on what they say, and counts it: libtest's results, lines `skipped: TEST: REASON` of tests
//! that lack what they need (`tests/common/external.rs`), and the last line of pytest.

use std::fmt;
use std::io::{BufRead, BufReader, Write as _, pipe};
use std::process::Command;

/// The sum over all programs.
#[derive(Debug, Default, PartialEq, Eq)]
pub struct Tally {
    passed: usize,
    failed: usize,
    skipped: usize,
    /// Tests that returned at once and said so: libtest takes them for passed.
    returned: usize,
    /// Programs that began and gave no result.
    open: usize,
}

impl Tally {
    /// What `work` runs is counted. Where it fails and no test of it did, it counts as one failure itself: a build that
    /// breaks, a program that crashes.
    pub fn count<T>(&mut self, work: impl FnOnce(&mut Self) -> Result<T, String>) -> Result<T, String> {
        let before = self.failed;
        let done = work(self);
        self.failed += std::mem::take(&mut self.open);
        if done.is_err() && self.failed == before {
            self.failed += 1;
        }
        done
    }

    /// Adds what `other` has counted.
    pub fn join(&mut self, other: &Self) {
        self.passed += other.passed;
        self.failed += other.failed;
        self.skipped += other.skipped;
        self.returned += other.returned;
    }

    /// Passes on both outputs of a program line by line, in the order in which they come.
    pub fn watch(&mut self, mut command: Command) -> Result<(), String> {
        let shown = format!("{command:?}");
        eprintln!("$ {shown}");
        let failed = |error: std::io::Error| format!("{shown} could not be run: {error}");
        let (reader, writer) = pipe().map_err(failed)?;
        command.stdout(writer.try_clone().map_err(failed)?).stderr(writer);
        let mut child = command.spawn().map_err(failed)?;
        drop(command); // It holds the pipe open.
        for line in BufReader::new(reader).split(b'\n') {
            let line = line.map_err(failed)?;
            println!("{}", String::from_utf8_lossy(&line));
            self.read(&String::from_utf8_lossy(&line));
        }
        let _ = std::io::stdout().flush();
        match child.wait().map_err(failed)? {
            status if status.success() => Ok(()),
            status => Err(format!("{shown} failed: {status}")),
        }
    }

    fn read(&mut self, line: &str) {
        if line.starts_with("running ") && (line.ends_with(" test") || line.ends_with(" tests")) {
            self.open += 1;
        } else if let Some(counts) = line.strip_prefix("test result: ") {
            self.open = self.open.saturating_sub(1);
            self.add(counts);
        } else if line.contains("skipped: ") {
            // Anywhere in the line, where libtest may have written the name of the test before.
            self.returned += 1;
        } else if let Some((counts, _)) = line.rsplit_once(" in ")
            && counts.split(", ").all(is_count)
        {
            self.add(counts);
        }
    }

    fn add(&mut self, counts: &str) {
        let words: Vec<&str> = counts.split([' ', ',', ';']).filter(|word| !word.is_empty()).collect();
        for pair in words.windows(2) {
            let Ok(number) = pair[0].parse::<usize>() else { continue };
            match pair[1] {
                "passed" | "xpassed" => self.passed += number,
                "failed" | "error" | "errors" => self.failed += number,
                "ignored" | "skipped" | "xfailed" => self.skipped += number,
                _ => {}
            }
        }
    }
}

/// A number and what it counts, as pytest has it: `2 skipped`.
fn is_count(text: &str) -> bool {
    text.split_once(' ').is_some_and(|(number, kind)| {
        number.parse::<usize>().is_ok() && kind.bytes().all(|byte| byte.is_ascii_lowercase())
    })
}

impl fmt::Display for Tally {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let passed = self.passed.saturating_sub(self.returned);
        write!(f, "{passed} passed, {} failed, {} skipped", self.failed, self.skipped + self.returned)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(lines: &str) -> String {
        let mut tally = Tally::default();
        let _ = tally.count(|tally| {
            lines.lines().for_each(|line| tally.read(line));
            Ok(())
        });
        tally.to_string()
    }

    #[test]
    fn programs_doc_tests_and_pytest_add_up_and_a_test_that_said_so_is_skipped() {
        let said = "\
running 3 tests
test needs_data ... skipped: needs_data: there is no data
test a ... ok
test result: ok. 3 passed; 0 failed; 1 ignored; 0 measured; 7 filtered out; finished in 0.01s
   Doc-tests stickslip
running 1 test
test result: FAILED. 4 passed; 2 failed; 0 ignored; 0 measured; 0 filtered out; finished in 0.01s
1 failed, 20 passed, 2 skipped, 3 warnings, 1 error in 61.25s (0:01:01)
compiled 5 things in 3 s";
        assert_eq!(read(said), "26 passed, 4 failed, 4 skipped");
    }

    #[test]
    fn a_program_that_ends_without_a_result_has_failed() {
        let said = "running 3 tests\nrunning 2 tests\n\
            test result: ok. 2 passed; 0 failed; 0 ignored; 0 measured; 0 filtered out; finished in 0.01s";
        assert_eq!(read(said), "2 passed, 1 failed, 0 skipped");
    }

    #[test]
    fn what_fails_without_a_test_that_failed_counts_as_one() {
        let mut tally = Tally::default();
        assert!(tally.count(|_| Err::<(), _>("the build broke".to_owned())).is_err());
        assert_eq!(tally.to_string(), "0 passed, 1 failed, 0 skipped");
    }

    #[test]
    fn two_that_counted_for_themselves_add_up() {
        let mut tally = Tally { passed: 5, failed: 1, skipped: 2, returned: 1, open: 0 };
        tally.join(&Tally { passed: 10, failed: 2, skipped: 3, returned: 2, open: 0 });
        assert_eq!(tally.to_string(), "12 passed, 3 failed, 8 skipped");
    }

    #[test]
    fn both_outputs_of_a_command_are_read() {
        let mut tally = Tally::default();
        let mut command = Command::new("sh");
        command.args(["-c", "echo 'test result: ok. 2 passed; 0 failed'; echo 'skipped: a: b' >&2; exit 3"]);
        let ended = tally.count(|tally| tally.watch(command));
        assert!(ended.unwrap_err().contains("exit status: 3"));
        assert_eq!(tally.to_string(), "1 passed, 1 failed, 1 skipped");
    }
}
