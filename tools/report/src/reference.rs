//! The page of all keys of model files.

use std::fmt::Write as _;

use stickslip::model::{ReferenceKey, ReferenceTable};
use stickslip::vocabulary::Quantity;

/// The reference of model files as Markdown, from the tables that the parser itself uses.
pub fn file_reference(tables: &[ReferenceTable]) -> String {
    let mut text = "# Keys of model files\n\nWritten by the program from the parser's own tables (`cargo test -p stickslip-cli --test program reference`). \
                    `stickslip new KIND` makes a file to begin with; [Your own data](own-data.md) tells what the tables are for.\n"
        .to_owned();
    for table in tables.iter().filter(|table| !table.keys.is_empty()) {
        let name = &table.name;
        let _ = writeln!(text, "\n## `[{name}]`\n\nModels of kind {}.\n", table.kinds.join(", "));
        text += "| key | unit | legal | left out | |\n|---|---|---|---|---|\n";
        for key in &table.keys {
            let _ = writeln!(text, "{}", row(key));
        }
    }
    text
}

fn row(key: &ReferenceKey) -> String {
    let left_out = key.default.map(|default| default.to_string()).unwrap_or_default();
    match key.quantity {
        None => format!("| `{}` | | | {left_out} | |", key.name),
        Some(quantity) => {
            let unit = if quantity.unit == "1" { "–" } else { quantity.unit };
            format!(
                "| `{}` | {unit} | {} | {left_out} | {} |",
                key.name,
                bounds(quantity),
                quantity.description
            )
        }
    }
}

fn bounds(quantity: &Quantity) -> String {
    let signs = if quantity.open { ["> ", "< "] } else { ["≥ ", "≤ "] };
    let ends = [quantity.min, quantity.max].into_iter().zip(signs);
    ends.filter_map(|(end, sign)| Some(format!("{sign}{}", end?))).collect::<Vec<_>>().join(", ")
}
