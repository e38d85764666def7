//! The pages in a browser: every figure is drawn, nothing is wider than the screen, nothing is reported as an
//! error.

use std::path::Path;
use std::process::Command;

use serde_json::Value;
use stickslip_report::diagnosis::diagnosis_html;

use crate::external;
use crate::synthetic::diagnosis::{found, insufficient, run, unexplained};
use crate::synthetic::{backbone, beam_with_failure, contact, hostile, settings};

const BROWSERS: [&str; 3] = ["chromium", "chromium-browser", "google-chrome"];

/// Collects what goes wrong, from the first line of the page on.
const WATCH: &str = "<script>window.wrong = [];
addEventListener('error', (event) => wrong.push(String(event.message)));
for (const kind of ['error', 'warn']) console[kind] = (...all) => wrong.push(all.join(' '));
</script>";

/// Puts what was found in the place of the page.
const TELL: &str = "<script>addEventListener('load', () => setTimeout(() => {
const plots = Array.from(document.querySelectorAll('.plot')).filter((plot) => !plot.closest('details:not([open])'));
// What scrolls for itself may be wider inside.
const shown = Array.from(document.body.querySelectorAll('*')).filter((one) => !one.parentElement.closest('.scroll, .plot'));
const reach = Math.max(...shown.map((one) => one.getBoundingClientRect().right));
// What a hover says of a trace names the units of both axes.
const unit = (layout, axis) => (/ \\(([^()]*)\\)$/.exec((layout[axis].title || {}).text || '') || ['', ''])[1];
const mute = (plot) => (plot.data || []).filter((trace) => !trace.hoverinfo && !['x', 'y'].every((axis) =>
  (trace.hovertemplate || '').includes(unit(plot.layout, (trace[axis + 'axis'] || axis).replace(axis, axis + 'axis')))
  && (trace.hovertemplate || '').includes('%{' + axis)));
const silent = plots.flatMap((plot) => mute(plot).map((trace) => plot.getAttribute('aria-label') + ': ' + trace.name));
const found = { reach, silent, plots: plots.length,
  bare: plots.filter((plot) => !plot.querySelector('.main-svg')).map((plot) => plot.getAttribute('aria-label')), wrong };
document.documentElement.innerHTML = '<body><pre></pre></body>';
document.querySelector('pre').textContent = 'FOUND' + JSON.stringify(found) + 'END';
}, 1000));</script>";

/// The page as the browser has it in a window that is `width` pixels wide.
fn seen(browser: &str, folder: &Path, page: &str, width: usize) -> Value {
    // The browser makes no window narrower than 500 pixels; the page can be.
    let narrow =
        if width < 500 { format!("<style>html {{ width: {width}px }}</style>") } else { String::new() };
    let page = page.replacen("</head>", &format!("{narrow}</head>"), 1);
    let page = page.replacen("<head>", &format!("<head>{WATCH}"), 1).replacen(
        "</body>",
        &format!("{TELL}</body>"),
        1,
    );
    let file = folder.join("page.html");
    std::fs::write(&file, page).unwrap();
    let output = Command::new(browser)
        .args([
            "--headless=new",
            "--no-sandbox",
            "--disable-gpu",
            "--dump-dom",
            "--virtual-time-budget=20000",
        ])
        .arg(format!("--user-data-dir={}", folder.join("profile").display()))
        .arg(format!("--window-size={width},900"))
        .arg(format!("file://{}", file.display()))
        .output()
        .unwrap();
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let start = text.find("FOUND").unwrap_or_else(|| panic!("{}", String::from_utf8_lossy(&output.stderr)));
    let found = &text[start + 5..start + text[start..].find("END").unwrap()];
    serde_json::from_str(&found.replace("&lt;", "<").replace("&gt;", ">").replace("&amp;", "&")).unwrap()
}

#[test]
fn every_figure_is_drawn_on_wide_and_narrow_screens() {
    let there = |browser: &&&str| Command::new(browser).arg("--version").output().is_ok();
    let Some(browser) = BROWSERS.iter().find(there) else {
        external::skip("there is no Chromium to draw the pages in");
        return;
    };
    let folder = std::env::temp_dir().join(format!("stickslip-browser-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let compared = |comparison| stickslip_report::html(&comparison, &[], &settings());
    let diagnosed = |diagnosis| diagnosis_html(&diagnosis, &run(), &settings());
    let pages = [
        (compared(contact(600)), 9),
        (compared(hostile()), 6),
        (compared(backbone()), 2),
        (compared(beam_with_failure()), 8),
        (diagnosed(found()), 11),
        (diagnosed(unexplained()), 15),
        (diagnosed(insufficient()), 6),
    ];
    for (index, (page, least)) in pages.iter().enumerate() {
        for width in [1280, 400] {
            let seen = seen(browser, &folder, page, width);
            assert_eq!(seen["wrong"], serde_json::json!([]), "page {index} at {width}");
            assert_eq!(seen["silent"], serde_json::json!([]), "page {index} at {width}: hover without units");
            assert_eq!(seen["bare"], serde_json::json!([]), "page {index} at {width}: not drawn");
            assert!(seen["plots"].as_u64() >= Some(*least), "page {index}: {seen}");
            assert!(seen["reach"].as_f64() <= Some(width as f64 + 0.5), "page {index} at {width}: {seen}");
        }
    }
    std::fs::remove_dir_all(&folder).unwrap();
}
