//! `[[stepped_sine]]`, `[[dual_mode]]`, `[[random]]`, `[[ring_down]]`.

use stickslip::document::{DocumentError, Table};
use stickslip::rig::{DualMode, Frequencies, RandomTest, Release, RingDown, SteppedSine, Test, TestKind};

use super::value::{count, not_negative, positive, positive_list, required_positive, whole};
use crate::dataset::USES;

/// Keys of the tables of tests.
pub(super) const KINDS: [&str; 4] = ["stepped_sine", "dual_mode", "random", "ring_down"];

/// The test of a table, the `number`-th of its kind where there are several.
pub(super) fn read(table: &Table<'_>, kind: &str, number: Option<usize>) -> Result<Test, DocumentError> {
    let own: &[&str] = match kind {
        "stepped_sine" => &[
            "amplitude",
            "frequency",
            "from",
            "to",
            "band",
            "count",
            "harmonics",
            "periods",
            "samples_per_period",
        ],
        "dual_mode" => &["first", "third", "frequency", "harmonics", "periods", "samples_per_period"],
        "random" => &["force", "band", "duration", "sampling", "lead", "seed"],
        _ => &["amplitude", "force", "duration", "sampling"],
    };
    table.allow(&[own, &["name", "use"]].concat())?;
    let kind_read = match kind {
        "stepped_sine" => TestKind::SteppedSine(stepped_sine(table)?),
        "dual_mode" => TestKind::DualMode(dual_mode(table)?),
        "random" => TestKind::Random(random(table, number.unwrap_or(1))?),
        _ => TestKind::RingDown(ring_down(table)?),
    };
    let use_for = table.choice("use", USES)?.map(|use_for| use_for.value);
    Ok(Test { name: name(table, kind, number)?, use_for, kind: kind_read })
}

/// What the test's files are called: its `name`, or its kind.
fn name(table: &Table<'_>, kind: &str, number: Option<usize>) -> Result<String, DocumentError> {
    let Some(name) = table.string("name")? else {
        let kind = kind.replace('_', "-");
        return Ok(number.map_or(kind.clone(), |number| format!("{kind}-{number}")));
    };
    let legal = |letter: char| letter.is_alphanumeric() || "-_.".contains(letter);
    if name.value.is_empty() || name.value.starts_with('.') || !name.value.chars().all(legal) {
        let help = "it names files: letters, digits, `-`, `_` and `.`";
        return Err(name.error(format!("\"{}\" is no name of a test", name.value)).with_help(help));
    }
    Ok(name.value.to_owned())
}

fn stepped_sine(table: &Table<'_>) -> Result<SteppedSine, DocumentError> {
    let missing =
        || table.missing("amplitude").with_help("acceleration held at the shaker [m/s^2]: one or a list");
    let amplitudes = positive_list(table, "amplitude")?.ok_or_else(missing)?;
    let standard = SteppedSine::at(amplitudes);
    Ok(SteppedSine {
        frequencies: frequencies(table)?,
        harmonics: whole(table, "harmonics", 1)?,
        periods: whole(table, "periods", 1)?.unwrap_or(standard.periods),
        samples_per_period: whole(table, "samples_per_period", 8)?.unwrap_or(standard.samples_per_period),
        ..standard
    })
}

/// Both harmonics of the acceleration held, as many of the first as of the third.
fn dual_mode(table: &Table<'_>) -> Result<DualMode, DocumentError> {
    let amplitudes = |key: &str, which: &str| {
        let help = format!("{which} harmonic of the acceleration held at the shaker [m/s^2]: one or a list");
        positive_list(table, key)?.ok_or_else(|| table.missing(key).with_help(help))
    };
    let (first, third) = (amplitudes("first", "first")?, amplitudes("third", "third")?);
    if first.len() != third.len() {
        let message = format!("{} of `third` for {} of `first`", third.len(), first.len());
        return Err(DocumentError::new(message, table.span_of("third"))
            .with_help("both are held at once: as many of one as of the other"));
    }
    let pairs = first.into_iter().zip(third).map(|(first, third)| [first, third]).collect();
    let standard = DualMode::at(required_positive(table, "frequency", "Hz")?, pairs);
    Ok(DualMode {
        harmonics: whole(table, "harmonics", 3)?.unwrap_or(standard.harmonics),
        periods: whole(table, "periods", 1)?.unwrap_or(standard.periods),
        samples_per_period: whole(table, "samples_per_period", 8)?.unwrap_or(standard.samples_per_period),
        ..standard
    })
}

/// `frequency = "resonance"`, with `band` and `count` or without; `frequency` as a list; or `from`, `to`, `count`.
fn frequencies(table: &Table<'_>) -> Result<Frequencies, DocumentError> {
    const CHOICES: &[(&str, ())] = &[("resonance", ())];
    let refuse_others = |keys: &[&str], beside: &str| match keys.iter().find_map(|key| table.span_of(key)) {
        Some(span) => {
            let message = format!("{beside} needs none of {}", keys.join(", "));
            Err(DocumentError::new(message, Some(span)))
        }
        None => Ok(()),
    };
    if table.span_of("frequency").is_none() {
        refuse_others(&["band"], "a range without `frequency = \"resonance\"`")?;
        let help =
            "`frequency = \"resonance\"`, a list of frequencies [Hz], or `from`, `to` [Hz] and `count`";
        let Some(from) = positive(table, "from")? else {
            return Err(table.missing("frequency").with_help(help));
        };
        let to = required_positive(table, "to", "Hz")?;
        let count = count(table, "count")?.ok_or_else(|| table.missing("count").with_help(help))?;
        let step = (to - from) / (count - 1) as f64;
        return Ok(Frequencies::List((0..count).map(|k| from + step * k as f64).collect()));
    }
    refuse_others(&["from", "to"], "`frequency`")?;
    if table.number_or_numbers("frequency").is_ok() {
        refuse_others(&["band", "count"], "a list of frequencies")?;
        return positive_list(table, "frequency").map(|list| Frequencies::List(list.unwrap_or_default()));
    }
    table.choice("frequency", CHOICES)?;
    match positive(table, "band")? {
        None => refuse_others(&["count"], "the resonance without `band`").map(|()| Frequencies::Resonance),
        Some(band) => {
            let count = count(table, "count")?.ok_or_else(|| table.missing("count"))?;
            Ok(Frequencies::AroundResonance { band, count })
        }
    }
}

fn random(table: &Table<'_>, number: usize) -> Result<RandomTest, DocumentError> {
    let missing = || table.missing("band").with_help("lowest and highest frequency [Hz]: band = [10, 400]");
    let band = positive_list(table, "band")?.ok_or_else(missing)?;
    let Ok(band) = <[f64; 2]>::try_from(band) else {
        let message = "`band` must be two frequencies [Hz], the lowest and the highest";
        return Err(DocumentError::new(message, table.span_of("band")));
    };
    if band[0] >= band[1] {
        return Err(DocumentError::new("`band` must begin below its end", table.span_of("band")));
    }
    Ok(RandomTest {
        force: required_positive(table, "force", "N, root mean square")?,
        band,
        duration: required_positive(table, "duration", "s")?,
        sampling: required_positive(table, "sampling", "Hz")?,
        lead: not_negative(table, "lead")?.unwrap_or(0.0),
        seed: whole(table, "seed", 0)?.unwrap_or(number) as u64,
    })
}

fn ring_down(table: &Table<'_>) -> Result<RingDown, DocumentError> {
    let each = |sizes: Vec<f64>, release: fn(f64) -> Release| sizes.into_iter().map(release).collect();
    let from = match (positive_list(table, "amplitude")?, positive_list(table, "force")?) {
        (Some(amplitudes), None) => each(amplitudes, Release::Held),
        (None, Some(forces)) => each(forces, Release::Force),
        (Some(_), Some(_)) => {
            let message = "a release is from an `amplitude` or from a `force`, not from both";
            return Err(DocumentError::new(message, table.span_of("force")));
        }
        (None, None) => {
            let help = "released from the resonance at this `amplitude` [m/s^2], or from a constant `force` [N]: one or a list";
            return Err(table.missing("amplitude").with_help(help));
        }
    };
    Ok(RingDown {
        from,
        duration: required_positive(table, "duration", "s")?,
        sampling: required_positive(table, "sampling", "Hz")?,
    })
}
