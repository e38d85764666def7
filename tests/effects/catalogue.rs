//! The catalogue is the one place that knows an effect by its id.

use std::fs;
use std::path::{Path, PathBuf};

use stickslip::effects::CATALOGUE;

fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).expect("a folder of sources") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            sources(&path, found);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            found.push(path);
        }
    }
}

/// Lines of code outside of comments and tests.
fn code(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let end = text.find("#[cfg(test)]\nmod ").unwrap_or(text.len());
    text[..end].lines().enumerate().filter(|(_, line)| !line.trim_start().starts_with("//"))
}

#[test]
fn an_id_stands_in_no_file_but_the_effects_own() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut files = Vec::new();
    sources(&root, &mut files);
    assert!(files.len() > 100, "{} files", files.len());
    let mut strangers = Vec::new();
    for path in files {
        let name = path.file_name().and_then(|name| name.to_str()).expect("a name in UTF-8");
        // Some effects are called after their parameter, and the vocabulary has the names of parameters.
        if name == "vocabulary.rs" || name.ends_with("tests.rs") {
            continue;
        }
        let text = fs::read_to_string(&path).expect("text in UTF-8");
        for (number, line) in code(&text) {
            for effect in CATALOGUE {
                let own = path == root.join("effects").join(format!("{}.rs", effect.id));
                if !own && line.contains(&format!("\"{}\"", effect.id)) {
                    strangers.push(format!("{}:{}: {}", path.display(), number + 1, line.trim()));
                }
            }
        }
    }
    assert!(strangers.is_empty(), "ask for a property of the effect instead:\n{}", strangers.join("\n"));
}
