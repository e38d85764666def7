//! The section of what later cases ask.

use std::fmt::Write;

use crate::scoring::figures::{Figures, told};
use crate::scoring::run::Outcome;
use crate::scoring::truth::Class;

/// What a case asks, by its word.
const WORDS: [(&str, &str); 20] = [
    ("further", "null cases beside the first"),
    ("32-records", "32 records"),
    ("128-records", "128 records"),
    ("noise-untold", "noise not stated"),
    ("ramped", "noise visible in cycles inside ramped records alone"),
    ("long-delay", "sensor delay beyond 20 samples"),
    ("mass-off", "a mass of the model wrong by 5 %"),
    ("coarse", "physics four times as fast, sampled at 2 kHz"),
    ("dahl", "contact by Dahl: micro-slip"),
    ("bouc_wen", "contact by Bouc and Wen: micro-slip"),
    ("valanis", "contact by Valanis: micro-slip"),
    ("held-levels", "the first paper's beam at eight held levels, contact by Valanis"),
    ("stick_ageing", "limit that ages in stick: outside"),
    ("power_law_damping", "damping by a power law: outside"),
    ("lugre", "contact by LuGre: outside"),
    ("stiffness_drift", "stiffness that drifts: outside"),
    ("hum", "hum of the mains: outside"),
    ("clipping", "clipped channels: outside"),
    ("drop_outs", "lost samples: outside"),
    ("", "other"),
];

/// One row for each of them.
pub fn section(text: &mut String, outcomes: &[Outcome]) {
    let asked: Vec<&Outcome> = outcomes.iter().filter(|outcome| outcome.truth.question.is_some()).collect();
    if asked.is_empty() {
        return;
    }
    text.push_str(
        "\n## Later kinds of case\n\nRight: the effect named, nothing named where nothing is hidden, `unexplained` where what is \
         hidden is outside the\ncatalogue or the fault of the measurement named. Named falsely: of the cases in which nothing of \
         the catalogue is hidden.\n\n| | right | named falsely | law told | s median | s largest |\n|---|---|---|---|---:|---:|\n",
    );
    let known = |word: &str| WORDS.iter().any(|(name, _)| *name == word);
    for (word, meaning) in WORDS {
        let belongs = |outcome: &&&Outcome| {
            let question = outcome.truth.question.as_deref().unwrap_or_default();
            question == word || word.is_empty() && !known(question)
        };
        let figures = Figures { outcomes: asked.iter().filter(belongs).copied().collect() };
        if figures.outcomes.is_empty() {
            continue;
        }
        let points = figures.outcomes.iter().map(|outcome| outcome.score.right).sum();
        let [null, outside] = [Class::Null, Class::Outside].map(|class| figures.named_falsely(class));
        let seconds = figures.seconds();
        let (median, largest) = (seconds[seconds.len() / 2], seconds[seconds.len() - 1]);
        let _ = writeln!(
            text,
            "| {meaning} | {} | {} | {} | {median:.1} | {largest:.1} |",
            told((points, figures.outcomes.len())),
            told((null.0 + outside.0, null.1 + outside.1)),
            laws(&figures)
        );
    }
}

/// How often the law that describes what was found is told, and right.
fn laws(figures: &Figures<'_>) -> String {
    let laws = figures.outcomes.iter().filter_map(|outcome| {
        let laws = Some(&outcome.truth.laws).filter(|laws| !laws.is_empty())?;
        let told = outcome.diagnosis.law.as_ref();
        (outcome.score.right == 1.0).then(|| told.is_some_and(|law| laws.contains(law)))
    });
    let (right, count) = laws.fold((0, 0), |(right, count), one| (right + usize::from(one), count + 1));
    if count == 0 { "–".to_owned() } else { format!("{right} of {count}") }
}
