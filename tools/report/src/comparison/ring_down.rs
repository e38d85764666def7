//! The levels of a free decay as a table.

use maud::{Markup, html};
use stickslip::fit::ring_down::RingDown;

use crate::comparison::stages::name;
use crate::format::{self, Scale};

/// Heading, names of the columns and rows.
pub fn table(ring_down: &RingDown) -> (String, [String; 4], Vec<[String; 4]>) {
    let of = |value: fn(&stickslip::fit::ring_down::Level) -> f64| ring_down.levels.iter().map(value);
    let frequency = Scale { decimals: 3, ..Scale::of(of(|level| level.frequency), "Hz") };
    let damping = Scale { factor: 100.0, unit: "%".to_owned(), decimals: 3 };
    let with =
        |scale: &Scale, value: f64, half: f64| format!("{} ± {}", scale.number(value), scale.number(half));
    let row = |level: &stickslip::fit::ring_down::Level| {
        [
            format::fixed(level.time, 3),
            format::significant(level.amplitude, 3),
            with(&frequency, level.frequency, level.frequency_interval),
            with(&damping, level.damping_ratio, level.damping_interval),
        ]
    };
    let heading = format!(
        "{}: free decay cut into {} by {}, with 95 % intervals",
        ring_down.record,
        format::count(ring_down.levels.len(), "level"),
        ring_down.channel
    );
    let header = [
        "time (s)".to_owned(),
        "amplitude (m/s²)".to_owned(),
        frequency.label("frequency"),
        damping.label("damping ratio"),
    ];
    (heading, header, ring_down.levels.iter().map(row).collect())
}

/// The same for the page.
pub fn section(ring_down: &RingDown) -> Markup {
    let (heading, header, rows) = table(ring_down);
    html! {
        section {
            h2 { (name(&heading)) }
            div.scroll tabindex="0" role="region" aria-label="Levels of a free decay" {
                table.levels {
                    thead { tr { @for title in &header { th.number { (name(title)) } } } }
                    tbody { @for row in &rows { tr { @for cell in row { td.number { (name(cell)) } } } } }
                }
            }
        }
    }
}
