//! Figures of the code: how much there is to read, what is too long, what lacks an example.
//!
//! It reads lines, not syntax. Of a file, tests are what follows `#[cfg(test)]`; files of tests are those in folders or
//! with names of tests.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use crate::public;

/// Longest function that fits a screen.
const SCREEN: usize = 60;

/// What a folder holds.
#[derive(Debug, Default, Clone, Copy, PartialEq, Eq)]
struct Folder {
    files: usize,
    /// Without tests.
    code: usize,
    tests: usize,
}

/// A function's or an item's place, and its name.
#[derive(Debug, PartialEq, Eq)]
struct Place {
    file: PathBuf,
    name: String,
    lines: usize,
}

/// Everything counted.
#[derive(Debug, Default)]
struct Figures {
    folders: BTreeMap<PathBuf, Folder>,
    long: Vec<Place>,
    public: usize,
    without_example: Vec<Place>,
}

/// The figures of `src` and `tools` below `root`; `build_seconds` is printed as given.
pub fn figures(root: &Path, build_seconds: Option<&str>) -> Result<String, String> {
    let mut found = Figures::default();
    let mut library = Vec::new();
    for top in ["src", "tools"] {
        for file in rust_files(&root.join(top))? {
            let text =
                std::fs::read_to_string(&file).map_err(|error| format!("{}: {error}", file.display()))?;
            let file = file.strip_prefix(root).unwrap_or(&file);
            found.count(file, &text);
            // Only the library is for others to use.
            if top == "src" && !is_test(file) {
                library.push((file.to_owned(), text));
            }
        }
    }
    found.count_public(&library);
    Ok(found.table(build_seconds))
}

fn rust_files(folder: &Path) -> Result<Vec<PathBuf>, String> {
    let failed = |error: std::io::Error| format!("{}: {error}", folder.display());
    let mut files = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(failed)? {
        let path = entry.map_err(failed)?.path();
        if path.is_dir() && !path.ends_with("target") {
            files.extend(rust_files(&path)?);
        } else if path.extension().is_some_and(|end| end == "rs") {
            files.push(path);
        }
    }
    files.sort();
    Ok(files)
}

impl Figures {
    fn count(&mut self, file: &Path, text: &str) {
        let lines: Vec<&str> = text.lines().collect();
        let code = if is_test(file) { 0 } else { code_lines(&lines) };
        // src/contact/joint/x.rs counts under src/contact, tools/cli/src/x.rs under tools/cli.
        let folder: PathBuf = file.parent().unwrap_or(file).components().take(2).collect();
        let folder = self.folders.entry(folder).or_default();
        folder.files += 1;
        folder.code += code;
        folder.tests += lines.len() - code;
        let place = |name: &str, lines: usize| Place { file: file.to_owned(), name: name.to_owned(), lines };
        for (name, length) in functions(&lines[..code]) {
            if length > SCREEN {
                self.long.push(place(&name, length));
            }
        }
    }

    /// Public items of the library's files.
    fn count_public(&mut self, library: &[(PathBuf, String)]) {
        let code = |text: &'_ str| -> usize { code_lines(&text.lines().collect::<Vec<_>>()) };
        let files: Vec<(&Path, Vec<&str>)> = library
            .iter()
            .map(|(file, text)| (file.as_path(), text.lines().take(code(text)).collect()))
            .collect();
        for item in public::items(&files) {
            self.public += 1;
            if !item.example {
                self.without_example.push(Place { file: item.file.to_owned(), name: item.name, lines: 0 });
            }
        }
    }

    fn table(&self, build_seconds: Option<&str>) -> String {
        let mut text = String::from("folder                      files    code   tests\n");
        let mut sum = Folder::default();
        for (name, folder) in &self.folders {
            let name = name.display().to_string();
            let Folder { files, code, tests } = *folder;
            let _ = writeln!(text, "{name:26} {files:6} {code:7} {tests:7}");
            sum = Folder { files: sum.files + files, code: sum.code + code, tests: sum.tests + tests };
        }
        let _ = writeln!(text, "{:26} {:6} {:7} {:7}", "all", sum.files, sum.code, sum.tests);
        let _ = writeln!(text, "\nfunctions over {SCREEN} lines: {}", self.long.len());
        for Place { file, name, lines } in &self.long {
            let _ = writeln!(text, "  {lines:4}  {name}  {}", file.display());
        }
        let without = self.without_example.len();
        let public = self.public;
        let _ = writeln!(
            text,
            "\npublic items of the library that a user can reach: {public}; without an example of their own: {without}"
        );
        let mut by_file: BTreeMap<&Path, Vec<&str>> = BTreeMap::new();
        for Place { file, name, .. } in &self.without_example {
            by_file.entry(file).or_default().push(name);
        }
        for (file, names) in by_file {
            let _ = writeln!(text, "  {}: {}", file.display(), names.join(", "));
        }
        if let Some(seconds) = build_seconds {
            let _ = writeln!(text, "\nlast timed build: {seconds} s");
        }
        text
    }
}

fn is_test(file: &Path) -> bool {
    let stem = file.file_stem().unwrap_or_default().to_string_lossy();
    stem == "tests" || stem.ends_with("_tests") || file.components().any(|part| part.as_os_str() == "tests")
}

/// Number of lines before the tests inside a file.
fn code_lines(lines: &[&str]) -> usize {
    // `#[cfg(test)] mod tests;` is one line of code; what opens a block is the rest of the file.
    let opens = |at: usize| lines.get(at + 1).is_some_and(|next| next.ends_with('{'));
    (0..lines.len()).find(|&at| lines[at] == "#[cfg(test)]" && opens(at)).unwrap_or(lines.len())
}

/// Names and lengths of the functions, by the indentation that rustfmt gives their ends.
fn functions(lines: &[&str]) -> Vec<(String, usize)> {
    let mut found = Vec::new();
    for (start, line) in lines.iter().enumerate() {
        let Some(name) = function_name(line.trim_start()) else { continue };
        let indent = line.len() - line.trim_start().len();
        let end = format!("{}}}", " ".repeat(indent));
        let last = lines[start..]
            .iter()
            .position(|line| *line == end || (line.ends_with(';') && is_head(line, indent)));
        if let Some(last) = last {
            found.push((name, last + 1));
        }
    }
    found
}

/// A declaration without a body ends at its own indentation.
fn is_head(line: &str, indent: usize) -> bool {
    line.len() - line.trim_start().len() == indent
}

fn function_name(line: &str) -> Option<String> {
    let mut rest = line;
    for word in ["pub(crate) ", "pub(super) ", "pub ", "const ", "unsafe ", "extern \"C\" "] {
        rest = rest.strip_prefix(word).unwrap_or(rest);
    }
    let name = rest.strip_prefix("fn ")?;
    let end = name.find(|c: char| !c.is_alphanumeric() && c != '_')?;
    Some(name[..end].to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "\
/// Adds.
///
/// ```
/// assert_eq!(add(1), 2);
/// ```
#[inline]
pub fn add(a: i32) -> i32 {
    a + 1
}

/// A number.
pub struct Number {
    value: i32,
}

fn private() {}

#[cfg(test)]
mod tests {
    fn helper() {
    }
}
";

    #[test]
    fn tests_inside_a_file_are_no_code() {
        let mut found = Figures::default();
        found.count(Path::new("src/contact/joint/one.rs"), TEXT);
        let folder = found.folders[Path::new("src/contact")];
        assert_eq!(folder, Folder { files: 1, code: 17, tests: 5 });
    }

    #[test]
    fn a_function_is_as_long_as_from_its_name_to_its_brace() {
        let lines: Vec<&str> = TEXT.lines().collect();
        assert_eq!(functions(&lines)[0], ("add".to_owned(), 3));
        let body = "    x();\n".repeat(60);
        let mut found = Figures::default();
        found.count(Path::new("tools/a/src/b.rs"), &format!("fn long() {{\n{body}}}\n"));
        assert_eq!((found.long.len(), found.long[0].lines), (1, 62));
    }
}
