//! Leaves out of plotly.js what no page draws: maps, three dimensions and forty kinds of trace are three quarters of it.
//!
//! The library is one script in which every module is `var NAME=WRAP((exports,module)=>{…});`, evaluated when another
//! module first calls `NAME()`. So a module that no kept module names can go, as in the smaller bundles that plotly.js
//! itself is published in.

use std::collections::{BTreeMap, BTreeSet};

/// The kinds of trace that the pages draw; lines and markers (`scatter`) are part of the library's core.
const TRACES: [&str; 1] = ["bar"];

/// How the script begins a module, and how it begins what is evaluated at once: what follows the helper's name.
const MODULE: &str = "=(e,t)=>()=>(t||e((t={exports:{}}).exports,t),t.exports)";
const AT_ONCE: &str = "=(e,t)=>()=>(e&&(t=e(e=0)),t)";

/// `script` with [`TRACES`] alone registered, and without the modules that nothing names any more.
///
/// # Panics
/// When the script is not laid out as described above: another version of the library, for which this is to be read again.
pub fn cut(script: &str) -> String {
    let module = format!("={}(", name_before(script, MODULE));
    let at_once = format!("{}(", name_before(script, AT_ONCE));
    let script = &register(script, &module);
    let pieces = pieces(script, &module);
    let by_name: BTreeMap<&str, usize> =
        pieces.iter().enumerate().map(|(at, piece)| (piece.name, at)).collect();
    // What is no module is needed from the start: the head, the end, and pieces that hold something else besides.
    let pure = |piece: &Piece| {
        !piece.name.is_empty() && piece.text.ends_with("});") && !piece.text.contains(&at_once)
    };
    let mut kept: BTreeSet<usize> = (0..pieces.len()).filter(|&at| !pure(&pieces[at])).collect();
    let mut unread: Vec<usize> = kept.iter().copied().collect();
    while let Some(at) = unread.pop() {
        let named =
            pieces[at].text.split(|letter| !is_of_a_name(letter)).filter_map(|word| by_name.get(word));
        unread.extend(named.filter(|&&named| kept.insert(named)));
    }
    kept.into_iter().map(|at| pieces[at].text).collect()
}

/// A module and what follows it up to the next.
struct Piece<'a> {
    name: &'a str,
    text: &'a str,
}

fn pieces<'a>(script: &'a str, module: &str) -> Vec<Piece<'a>> {
    let mut starts = vec![("", 0)];
    for (at, _) in script.match_indices(module) {
        let name = last_name(&script[..at]);
        let start = at - name.len();
        if script[..start].ends_with(";var ")
            || script[..start].ends_with("}var ")
            || script[..start].ends_with("\nvar ")
        {
            starts.push((name, start - "var ".len()));
        }
    }
    let ends = starts.iter().skip(1).map(|&(_, start)| start).chain([script.len()]);
    starts.iter().zip(ends).map(|(&(name, start), end)| Piece { name, text: &script[start..end] }).collect()
}

/// `script` that registers only [`TRACES`].
fn register(script: &str, module: &str) -> String {
    const CALL: &str = ".register([";
    let (before, list) = script.split_once(CALL).expect("plotly.js registers its traces");
    let (list, after) = list.split_once("])").expect("a list has an end");
    let by_name: BTreeMap<&str, &str> =
        pieces(script, module).iter().map(|piece| (piece.name, piece.text)).collect();
    let of = |entry: &str| by_name.get(entry.trim_end_matches("()")).copied().unwrap_or_default();
    let is_drawn = |entry: &&str| {
        let text = of(entry);
        TRACES.iter().any(|name| {
            let declared = format!("moduleType:\"trace\",name:\"{name}\"");
            text.contains(&declared) || of(handed_on(text)).contains(&declared)
        })
    };
    let drawn: Vec<&str> = list.split(',').filter(is_drawn).collect();
    assert_eq!(drawn.len(), TRACES.len(), "of the registered traces {TRACES:?} were to be found");
    format!("{before}{CALL}{}]){after}", drawn.join(","))
}

/// The module whose exports the module `text` exports: an entry may be the trace itself, or hand it on.
fn handed_on(text: &str) -> &str {
    let (_, rest) = text.split_once(".exports=").unwrap_or_default();
    rest.split('(').next().unwrap_or_default()
}

fn name_before<'a>(script: &'a str, text: &str) -> &'a str {
    let at = script.find(text).unwrap_or_else(|| panic!("plotly.js is laid out in another way: no `{text}`"));
    last_name(&script[..at])
}

fn last_name(text: &str) -> &str {
    &text[text.trim_end_matches(is_of_a_name).len()..]
}

fn is_of_a_name(letter: char) -> bool {
    letter.is_ascii_alphanumeric() || letter == '_' || letter == '$'
}
