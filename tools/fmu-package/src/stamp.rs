//! Who made an FMU, and when.

use crate::Error;

/// Author and date of an FMU. Without others the author is this program, and the date that of its version: the same
/// model gives the same bytes.
///
/// ```
/// use stickslip_fmu_package::Stamp;
/// assert!(Stamp::new(Some("A. Engineer"), Some("2026-12-01T10:30:00Z")).is_ok());
/// assert!(Stamp::new(None, Some("1 December")).is_err());
/// ```
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Stamp {
    pub(crate) author: String,
    pub(crate) date: String,
}

/// The date of this version, as CITATION.cff has it.
const DATE: &str = "2026-11-21T00:00:00Z";

impl Default for Stamp {
    fn default() -> Self {
        Self { author: "The stickslip authors".to_owned(), date: DATE.to_owned() }
    }
}

impl Stamp {
    /// With an author or a date, in UTC as `2026-12-01T10:30:00Z`, of one's own.
    ///
    /// # Errors
    /// [`Error::Date`] for a text that is no date, [`Error::Author`] for a name with characters that no line has.
    pub fn new(author: Option<&str>, date: Option<&str>) -> Result<Self, Error> {
        let default = Self::default();
        if let Some(author) =
            author.filter(|author| author.is_empty() || author.chars().any(char::is_control))
        {
            return Err(Error::Author(author.to_owned()));
        }
        if let Some(date) = date.filter(|date| !is_date(date)) {
            return Err(Error::Date(date.to_owned()));
        }
        let own = |text: Option<&str>, other| text.map_or(other, str::to_owned);
        Ok(Self { author: own(author, default.author), date: own(date, default.date) })
    }
}

fn is_date(text: &str) -> bool {
    let shape = "dddd-dd-ddTdd:dd:ddZ";
    let fits =
        |(found, wanted): (char, char)| if wanted == 'd' { found.is_ascii_digit() } else { found == wanted };
    if text.chars().count() != shape.len() || !text.chars().zip(shape.chars()).all(fits) {
        return false;
    }
    let number = |from: usize, to: usize| text[from..to].parse::<u32>().unwrap_or(u32::MAX);
    let (year, month, day) = (number(0, 4), number(5, 7), number(8, 10));
    let leap = year.is_multiple_of(4) && (!year.is_multiple_of(100) || year.is_multiple_of(400));
    let days = match month {
        2 => 28 + u32::from(leap),
        4 | 6 | 9 | 11 => 30,
        1..=12 => 31,
        _ => 0,
    };
    year > 0 && (1..=days).contains(&day) && number(11, 13) < 24 && number(14, 16) < 60 && number(17, 19) < 60
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dates_are_those_of_the_calendar_in_utc() {
        for date in ["2026-12-01T10:30:00Z", "2028-02-29T23:59:59Z", DATE] {
            assert!(is_date(date), "{date}");
        }
        for text in [
            "2026-12-01",
            "2027-02-29T00:00:00Z",
            "2026-13-01T00:00:00Z",
            "2026-12-01T24:00:00Z",
            "2026-12-01T10:30:00+01:00",
            "２026-12-01T10:30:00Z",
            "",
        ] {
            assert!(!is_date(text), "{text}");
        }
    }

    #[test]
    fn the_date_is_that_of_the_version() {
        let citation = include_str!("../../../CITATION.cff");
        assert!(citation.contains(&format!("date-released: {}", &DATE[..10])));
    }
}
