//! Which effect does a model lack? Files in, verdict out, without the program.
//!
//! `cargo run --release -p stickslip-readers --example diagnose -- MODEL.toml DATASET`

use stickslip::prelude::*;
use stickslip_readers::{check_columns, read_dataset, read_model};

fn main() {
    let paths: Vec<String> = std::env::args().skip(1).collect();
    let [model, dataset] = paths.as_slice() else {
        eprintln!("usage: diagnose MODEL.toml DATASET");
        std::process::exit(2);
    };
    if let Err(message) = run(model, dataset) {
        eprintln!("{message}");
        std::process::exit(2);
    }
}

fn run(model: &str, dataset: &str) -> Result<(), String> {
    let shown = |error: stickslip_readers::InputError| error.render(false); // points at the line
    let model = read_model(model).map_err(shown)?;
    let dataset = read_dataset(dataset).map_err(shown)?;
    check_columns(&dataset, &model).map_err(shown)?;

    let found = diagnose(&model, &dataset, &DiagnoseOptions::default(), DiagnoseWatch::default())
        .map_err(|error| error.to_string())?;
    println!("{:?}: {}", found.verdict, found.effects.join(", "));
    found.reasons.iter().for_each(|reason| println!("- {reason}"));
    for parameter in &found.parameters {
        println!("{} = {} {}", parameter.name, parameter.value, parameter.unit);
    }
    Ok(())
}
