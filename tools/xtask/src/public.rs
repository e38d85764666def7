//! Public items of the library, as far as a user of the crate can reach them, and whether their documentation has an
//! example.
//!
//! It reads lines, not syntax. An item counts where its module is public up to the crate, or where a public module
//! exports its name with `pub use`; a method counts where its type does.

use std::collections::HashSet;
use std::path::Path;

/// A public function, type, trait or method that a user can reach.
#[derive(Debug, PartialEq, Eq)]
pub struct Item<'a> {
    pub file: &'a Path,
    /// Of a method, with its type: `Model::parse`.
    pub name: String,
    /// Whether its documentation has an example.
    pub example: bool,
}

/// A file of the library: its module below the crate, and what it declares.
struct Module<'a> {
    file: &'a Path,
    path: Vec<String>,
    public: HashSet<String>,
    /// Modules and names of `pub use`.
    exports: Vec<(Vec<String>, String)>,
    declared: Vec<Declared>,
    /// Names of all its types, private ones included.
    types: HashSet<String>,
}

/// An item marked `pub`.
struct Declared {
    name: String,
    /// The type of the `impl` around it.
    of: Option<String>,
    example: bool,
}

/// The items of the library with these files below `src`, each with its lines of code.
pub fn items<'a>(files: &'a [(&Path, Vec<&str>)]) -> Vec<Item<'a>> {
    let modules: Vec<Module> = files.iter().map(|(file, lines)| Module::new(file, lines)).collect();
    let declared_public: HashSet<(&[String], &String)> =
        modules.iter().flat_map(|m| m.public.iter().map(|name| (&m.path[..], name))).collect();
    let is_public =
        |path: &[String]| (0..path.len()).all(|end| declared_public.contains(&(&path[..end], &path[end])));
    let exports: Vec<&(Vec<String>, String)> =
        modules.iter().filter(|m| is_public(&m.path)).flat_map(|m| &m.exports).collect();
    let is_reached = |module: &Module, name: &str| {
        is_public(&module.path)
            || exports.iter().any(|(from, exported)| exported == name && module.path.starts_with(from))
    };
    let types: HashSet<(Option<&String>, &str)> = modules
        .iter()
        .flat_map(|m| m.declared.iter().map(move |item| (m, item)))
        .filter(|(m, item)| item.of.is_none() && is_reached(m, &item.name))
        .map(|(m, item)| (m.path.first(), item.name.as_str()))
        .collect();
    // A type of the same file hides one of the same name elsewhere.
    let is_reached_type = |module: &Module, name: &String| match module.types.contains(name) {
        true => is_reached(module, name),
        false => types.contains(&(module.path.first(), name.as_str())),
    };
    let mut found = Vec::new();
    for module in &modules {
        for item in &module.declared {
            let name = match &item.of {
                Some(of) if is_reached_type(module, of) => format!("{of}::{}", item.name),
                None if is_reached(module, &item.name) => item.name.clone(),
                _ => continue,
            };
            found.push(Item { file: module.file, name, example: item.example });
        }
    }
    found
}

impl<'a> Module<'a> {
    fn new(file: &'a Path, lines: &[&str]) -> Self {
        let mut path: Vec<String> = file
            .with_extension("")
            .components()
            .skip(1)
            .map(|part| part.as_os_str().to_string_lossy().into_owned())
            .collect();
        path.pop_if(|last| last == "mod" || last == "lib");
        let public = lines.iter().filter_map(|line| line.strip_prefix("pub mod ")?.strip_suffix(';'));
        let public = public.map(str::to_owned).collect();
        let exports = exports(lines, &path);
        let types = lines.iter().filter_map(|line| type_name(line)).collect();
        Self { file, public, exports, declared: declared(lines), types, path }
    }
}

/// Modules and names that the `pub use` of the module `here` export.
fn exports(lines: &[&str], here: &[String]) -> Vec<(Vec<String>, String)> {
    let mut found = Vec::new();
    let mut rest = lines.iter();
    while let Some(line) = rest.next() {
        let Some(first) = line.strip_prefix("pub use ") else { continue };
        let mut statement = first.to_owned();
        while !statement.ends_with(';')
            && let Some(next) = rest.next()
        {
            statement += next.trim();
        }
        let statement = statement.trim_end_matches(';');
        let (start, path) = match statement.strip_prefix("crate::") {
            Some(path) => (Vec::new(), path),
            None => (here.to_vec(), statement),
        };
        expand(&start, path, &mut found);
    }
    found
}

/// `a::{B, c::D}` below `start`: `B` of `a`, `D` of `a::c`.
fn expand(start: &[String], path: &str, out: &mut Vec<(Vec<String>, String)>) {
    let mut modules = start.to_vec();
    let (before, list) = match path.split_once('{') {
        Some((before, list)) => (before, Some(list.trim_end_matches('}'))),
        None => (path, None),
    };
    let mut names: Vec<&str> = before.split("::").map(str::trim).filter(|name| !name.is_empty()).collect();
    let last = if list.is_none() { names.pop() } else { None };
    modules.extend(names.into_iter().map(str::to_owned));
    match (last, list) {
        (Some(name), _) => out.push((modules, name.to_owned())),
        (None, Some(list)) => {
            list.split(',').filter(|one| !one.trim().is_empty()).for_each(|one| expand(&modules, one, out));
        }
        (None, None) => {}
    }
}

/// What the lines declare as `pub`.
fn declared(lines: &[&str]) -> Vec<Declared> {
    let mut found = Vec::new();
    let (mut example, mut of) = (false, None);
    for line in lines {
        if line.starts_with('}') {
            of = None;
        } else if line.starts_with("impl") {
            of = implemented(line);
        }
        let line = line.trim_start();
        if let Some(comment) = line.strip_prefix("///") {
            example |= comment.trim_start().starts_with("```");
            continue;
        }
        if line.starts_with("#[") {
            continue;
        }
        if let Some(name) = item_name(line) {
            found.push(Declared { name, of: of.clone(), example });
        }
        example = false;
    }
    found
}

/// `Name` of `impl<'a> Name<'a> {`.
fn implemented(line: &str) -> Option<String> {
    let mut rest = line.strip_prefix("impl")?;
    if rest.starts_with('<') {
        let mut depth = 0;
        let end = rest.find(|c: char| {
            depth += i32::from(c == '<') - i32::from(c == '>');
            depth == 0
        })?;
        rest = &rest[end + 1..];
    }
    Some(word(rest.trim_start())).filter(|name| !name.is_empty())
}

fn item_name(line: &str) -> Option<String> {
    let item = line.strip_prefix("pub ")?;
    let item = item.strip_prefix("const fn ").map_or_else(|| item.to_owned(), |rest| format!("fn {rest}"));
    ["fn ", "struct ", "enum ", "trait "].iter().find_map(|kind| item.strip_prefix(kind)).map(word)
}

/// The name of a struct or an enum of any visibility, declared at the top of a file.
fn type_name(line: &str) -> Option<String> {
    let item = ["pub(crate) ", "pub(super) ", "pub "]
        .iter()
        .find_map(|kind| line.strip_prefix(kind))
        .unwrap_or(line);
    ["struct ", "enum "].iter().find_map(|kind| item.strip_prefix(kind)).map(word)
}

fn word(text: &str) -> String {
    text.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIB: &str =
        "pub mod open;\nmod inner;\npub(crate) mod numeric;\npub use inner::deep::{Shown, show};\n";
    const OPEN: &str =
        "/// Adds.\n///\n/// ```\n/// assert_eq!(add(1), 2);\n/// ```\n#[inline]\npub fn add() {\n}\n";
    const DEEP: &str = "pub struct Shown;\n\nimpl Shown {\n    pub const fn of() {\n    }\n    pub(crate) fn own() {\n    }\n}\n\
                        pub struct Hidden;\n\nimpl<'a, T: A<B>> Hidden<'a, T> {\n    pub fn not() {\n    }\n}\n";

    #[test]
    fn an_item_counts_where_a_user_can_reach_it() {
        let files: Vec<(&Path, Vec<&str>)> = [
            ("src/lib.rs", LIB),
            ("src/open.rs", OPEN),
            ("src/inner/deep.rs", DEEP),
            ("src/numeric/mod.rs", "pub fn solve() {\n}\n"),
        ]
        .map(|(file, text)| (Path::new(file), text.lines().collect()))
        .to_vec();
        let found: Vec<(String, bool)> =
            items(&files).into_iter().map(|item| (item.name, item.example)).collect();
        let expected = [("add", true), ("Shown", false), ("Shown::of", false)];
        assert_eq!(found, expected.map(|(name, example)| (name.to_owned(), example)));
    }
}
