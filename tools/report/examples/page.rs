//! Writes an example report: `cargo run -p stickslip-report --example page -- out.html [backbone |
//! contact | failure | hostile | found | group | unexplained | nothing | insufficient | large]`, and prints the same
//! as a table.

#[path = "../tests/synthetic/mod.rs"]
mod synthetic;

fn main() -> std::io::Result<()> {
    let mut arguments = std::env::args().skip(1);
    let file = arguments.next().unwrap_or_else(|| "report.html".to_owned());
    let kind = arguments.next();
    if let Some((diagnosis, run)) = kind.as_deref().and_then(synthetic::diagnosis::called) {
        print!("{}", stickslip_report::diagnosis::diagnosis_table(&diagnosis, &run, 80, false));
        let page = stickslip_report::diagnosis::diagnosis_html(&diagnosis, &run, &synthetic::settings());
        return std::fs::write(file, page);
    }
    let comparison = match kind.as_deref() {
        Some("contact") => synthetic::contact(15_000),
        Some("failure") => synthetic::beam_with_failure(),
        Some("hostile") => synthetic::hostile(),
        _ => synthetic::backbone(),
    };
    print!("{}", stickslip_report::terminal_table(&comparison, &[], 80, false));
    std::fs::write(file, stickslip_report::html(&comparison, &[], &synthetic::settings()))
}
