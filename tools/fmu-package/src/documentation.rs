//! `documentation/index.html` from the variable table and the model.

use std::fmt::Write as _;
use stickslip::fmi::{Causality, Description, Variable};
use stickslip::model::{Model, Structure};

use crate::FmiVersion;
use crate::extras::{Run, terminals};
use crate::figure::curve;
use crate::units::{display_unit, display_units};
use crate::xml::number;

/// A page about the model: its equations and loops, its variables in tables, its steps, its model file.
pub fn documentation_html(
    version: FmiVersion,
    model_identifier: &str,
    description: &Description,
    model_toml: &str,
) -> String {
    let model = Model::parse(model_toml).ok();
    let run = Run::new(model_toml).ok();
    page(version, model_identifier, description, model_toml, (model.as_ref(), run.as_ref()))
}

/// The same of what is known already: the model, and its run for the reference results.
pub(crate) fn page(
    version: FmiVersion,
    model_identifier: &str,
    description: &Description,
    model_toml: &str,
    (model, run): (Option<&Model>, Option<&Run>),
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
    if let Some(model) = model {
        page.push_str(&equations(model));
    }
    if let Some(run) = run {
        page.push_str(&loops(description, run));
    }
    page.push_str(&flanges(description));
    for (title, causality) in
        [("Inputs", Causality::Input), ("Outputs", Causality::Output), ("Parameters", Causality::Parameter)]
    {
        let _ = write!(
            page,
            "<h2>{title}</h2>\n<table>\n<tr><th>Name</th><th>Unit</th><th>Shown in</th><th>Meaning</th><th>Start</th></tr>\n"
        );
        for variable in description.variables.iter().filter(|variable| variable.causality == causality) {
            page.push_str(&row(variable));
        }
        page.push_str("</table>\n");
    }
    let _ = write!(page, "<h2>Model file</h2>\n<pre>{}</pre>\n</body>\n</html>\n", escape(model_toml));
    page
}

/// The contact's law and the structure's motion in formulas.
fn equations(model: &Model) -> String {
    let structure: &[&str] = match model.structure {
        Structure::Prescribed => &[],
        Structure::Beam(_) => &[
            "q̈r + 2 ζr ωr q̇r + ωr² qr = φr(xe) F − Σ φr(xc) T, r = 1 … modes, φr scaled to a mass of 1 kg",
            "w(x) = Σ φr(x) qr; at the contact the force bends the beam's end besides",
            "F: excitation at xe, T: restoring force at each contact xc, ωr and ζr: natural frequency and damping ratio",
        ],
        Structure::Oscillator(_) => &[
            "M ü + C u̇ + K u = F − Bᵀ T",
            "M, C, K: masses, dampers and springs of the model file; B: the places where contacts act; T: their restoring forces",
        ],
        Structure::PinRig(_) => &[
            "q̈r + 2 ζr ωr q̇r + ωr² qr = φr(xe) F − ψr T − χr O, r = 1 … modes, of beam, pin and hanging mass together",
            "F: excitation, T: friction at the pin, O: restoring normal force there; ψr and χr: motion of the pin along and across its support",
        ],
    };
    let mut text = String::from("<h2>Equations</h2>\n");
    text.push_str(&lines(structure));
    let Some(contact) = &model.contact else { return text };
    text.push_str(&lines(contact.law.kind.equations));
    if contact.normal.is_some() {
        text.push_str(&lines(&[
            "N = Nel(δ) (1 + λ δ̇), never below zero; δ = δ0 − opening, Nel(δ0) = normal_load",
            "Nel: k δ, k δ + k3 δ³, or Hertz' law with its exponent; λ: impact_damping, 0 without the effect",
        ]));
    }
    text.push_str(
        "<p>Where the normal load is zero or below, the contact is open: no force, no memory.</p>\n",
    );
    text
}

fn lines(lines: &[&str]) -> String {
    if lines.is_empty() {
        return String::new();
    }
    format!("<pre>{}</pre>\n", escape(&lines.join("\n")))
}

/// Forces over displacements of the reference run.
fn loops(description: &Description, run: &Run) -> String {
    let pairs = [("displacement", "force"), ("opening", "normal_force"), ("displacement", "contact_force")];
    let drawn = pairs.iter().filter_map(|(motion, force)| {
        let (x, y) = (run.course(description, motion)?, run.course(description, force)?);
        curve(&x, &y, [&format!("{motion} (m)"), &format!("{force} (N)")])
    });
    let drawn: String = drawn.collect();
    if drawn.is_empty() {
        return drawn;
    }
    format!(
        "<h2>Loops</h2>\n{drawn}<p>From the run whose numbers lie in <code>extra/org.fmi-standard.fmi-ls-ref</code>; \
         <a href=\"fmi-ls-ref.html\">how to repeat it</a>.</p>\n"
    )
}

/// The places where the model is joined to others.
fn flanges(description: &Description) -> String {
    let flanges = terminals::terminals(description);
    if flanges.is_empty() {
        return String::new();
    }
    let mut text = String::from(
        "<h2>Flanges</h2>\n<table>\n<tr><th>Name</th><th>Position</th><th>Velocity</th><th>Force</th></tr>\n",
    );
    for flange in flanges {
        let cells = [flange.position, flange.velocity.unwrap_or(""), flange.force].map(escape);
        let [position, velocity, force] = cells;
        let name = escape(&flange.name);
        let _ =
            writeln!(text, "<tr><td>{name}</td><td>{position}</td><td>{velocity}</td><td>{force}</td></tr>");
    }
    text.push_str("</table>\n");
    text
}

fn row(variable: &Variable) -> String {
    let start = variable.start().map(|start| start.to_string()).unwrap_or_default();
    let unit = variable.quantity.unit;
    let shown = display_unit(variable.quantity)
        .and_then(|shown| display_units(unit).iter().find(|(name, _)| *name == shown))
        .map(|(name, factor)| format!("{name} (× {})", number(*factor)));
    format!(
        "<tr><td><code>{}</code></td><td>{}</td><td>{}</td><td>{}</td><td>{start}</td></tr>\n",
        escape(&variable.name),
        escape(unit),
        escape(&shown.unwrap_or_default()),
        escape(&variable.description),
    )
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
