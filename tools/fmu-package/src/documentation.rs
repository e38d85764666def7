//! `documentation/index.html` from the variable table.

use std::fmt::Write as _;
use stickslip::fmi::{Causality, Description, Variable};

use crate::FmiVersion;

/// A page about the model: its variables in tables, its steps, its model file.
pub fn documentation_html(
    version: FmiVersion,
    model_identifier: &str,
    description: &Description,
    model_toml: &str,
) -> String {
    let mut page = format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head><meta charset=\"utf-8\"><title>{name}</title>\n\
         <style>body{{font:16px/1.4 sans-serif;max-width:60em;margin:2em auto;padding:0 1em}}\
         table{{border-collapse:collapse}}td,th{{border:1px solid #999;padding:.2em .6em;text-align:left}}\
         pre{{background:#eee;padding:1em}}</style></head>\n<body>\n<h1>{name}</h1>\n<p>{summary}. FMI {version} \
         for co-simulation and model exchange.</p>\n<p>A force of a contact is restoring: positive when it resists positive \
         displacement, so that its work over a cycle is dissipated. All values are in SI units.</p>\n<p>The \
         inputs set before a step from t to t + h hold for the step and are those reached at t + h; the \
         outputs then belong to t + h. The step size may vary.</p>\n",
        name = escape(model_identifier),
        summary = escape(description.summary),
        version = version.number(),
    );
    for (title, causality) in
        [("Inputs", Causality::Input), ("Outputs", Causality::Output), ("Parameters", Causality::Parameter)]
    {
        let _ = write!(
            page,
            "<h2>{title}</h2>\n<table>\n<tr><th>Name</th><th>Unit</th><th>Meaning</th><th>Start</th></tr>\n"
        );
        for variable in description.variables.iter().filter(|variable| variable.causality == causality) {
            page.push_str(&row(variable));
        }
        page.push_str("</table>\n");
    }
    let _ = write!(page, "<h2>Model file</h2>\n<pre>{}</pre>\n</body>\n</html>\n", escape(model_toml));
    page
}

fn row(variable: &Variable) -> String {
    let start = variable.start().map(|start| start.to_string()).unwrap_or_default();
    format!(
        "<tr><td><code>{}</code></td><td>{}</td><td>{}</td><td>{start}</td></tr>\n",
        escape(&variable.name),
        escape(variable.quantity.unit),
        escape(&variable.description),
    )
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
