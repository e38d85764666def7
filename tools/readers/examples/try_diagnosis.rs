#![allow(missing_docs)]
use std::time::Instant;
use stickslip::diagnose::*;
fn main() {
    let mut verbose = false;
    for dir in std::env::args().skip(1) {
        if dir == "-v" { verbose = true; continue; }
        let path = std::path::Path::new(&dir);
        let model = stickslip_readers::read_model(path.join("model.toml")).unwrap();
        let dataset = stickslip_readers::read_dataset(path.join("dataset.toml")).unwrap();
        let t = Instant::now();
        let d = match diagnose(&model, &dataset, &DiagnoseOptions::default(), DiagnoseWatch::default()) { Ok(d) => d, Err(e) => { println!("{dir}: ERROR {e}"); continue } };
        let seconds = t.elapsed().as_secs_f64();
        let groups: Vec<_> = d.groups.iter().map(|g| g.effects.join("|")).collect();
        println!("{} {:?} {:?} groups {:?} surr {:?} chi {:.3?} err {:.4} {:.4} {:.4} unt {:.4}->{:.4} floor {:.4?} refits {} sims {} {:.2}s",
            path.file_name().unwrap().to_string_lossy(), d.verdict, d.effects, groups, d.surrogates, d.chi_square, d.error.baseline, d.error.refitted, d.error.last, d.error.untouched_refitted, d.error.untouched, d.error.untouched_noise_floor, d.cost.refits, d.cost.simulations, seconds);
        if verbose {
            println!("  split {:?}", d.split);
            for s in &d.comparison.stages { println!("  stage {} {:.4} {:?}", s.name, s.error, s.parameters.iter().filter(|p| p.fitted_from.is_some()).map(|p| format!("{}={:.4e}", p.path, p.value)).collect::<Vec<_>>());
              println!("     records {:?}", s.records.iter().map(|r| format!("{:.4}", r.error)).collect::<Vec<_>>()); }
            for n in &d.noise { println!("  noise {} {} {:.4?} {:?}", n.record, n.channel, n.deviation, n.source); }
            for s in &d.steps { println!("  step {:?} z {:.1} share {:.3} err {:.4} dropped {}", s.added, s.gain_z, s.gain_share, s.error, s.dropped); }
            for round in std::iter::once(&d.candidates).chain(&d.rounds) { println!("  round");
              for c in round { println!("   {:?} {:?} z {:.1} share {:.4} err {:.4} ev {} {} {}", c.effects, c.location, c.gain_z, c.gain_share, c.error, c.evaluations, c.parameters.iter().map(|p| format!("{}={:.3e}[{:.2e},{:.2e}]", p.name, p.value, p.low.unwrap_or(f64::NAN), p.high.unwrap_or(f64::NAN))).collect::<Vec<_>>().join(" "), c.failure.clone().unwrap_or_default()); } }
            for u in &d.untried { println!("  untried {} {}", u.effect, u.reason); }
            for r in &d.reasons { println!("  reason {r}"); }
            for e in &d.evidence { println!("  evidence {e:?}"); }
            for x in &d.detectable { println!("  detectable {} {} {:.3?} {}", x.effect, x.parameter, x.value, x.unit); }
            for c in d.confounding.iter().filter(|c| c.correlation.abs() > 0.8) { println!("  alike {:?} {:.3}", c.effects, c.correlation); }
            println!("  next {:?}", d.next_experiment);
        }
    }
}
