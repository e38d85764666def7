//! What was meant by a word that is not known.

/// "did you mean ...?" where one of `legal` is close to `word`, and the list of `legal` in any case.
pub fn suggestion(word: &str, legal: &[&str], what: &str) -> String {
    let list = legal.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ");
    match nearest(word, legal) {
        Some(name) => format!("did you mean `{name}`? legal {what}: {list}"),
        None => format!("legal {what}: {list}"),
    }
}

/// The one of `candidates` that a typing error could have turned into `word`.
///
/// ```
/// use stickslip::document::nearest;
/// assert_eq!(nearest("jenkin", &["jenkins", "valanis"]), Some("jenkins"));
/// assert_eq!(nearest("coulomb", &["jenkins", "valanis"]), None);
/// ```
pub fn nearest<'c>(word: &str, candidates: &[&'c str]) -> Option<&'c str> {
    // A word of absurd length is no typing error, and the distance costs length × length.
    if word.len() > 64 {
        return None;
    }
    let (distance, candidate) = candidates
        .iter()
        .map(|candidate| (edit_distance(&word.to_lowercase(), candidate), *candidate))
        .min_by_key(|(distance, _)| *distance)?;
    (distance <= (candidate.chars().count() / 3).max(1)).then_some(candidate)
}

/// Levenshtein's distance in characters.
fn edit_distance(left: &str, right: &str) -> usize {
    let right: Vec<char> = right.chars().collect();
    let mut row: Vec<usize> = (0..=right.len()).collect();
    for (i, a) in left.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, b) in right.iter().enumerate() {
            let substitution = diagonal + usize::from(a != *b);
            diagonal = row[j + 1];
            row[j + 1] = substitution.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[right.len()]
}
