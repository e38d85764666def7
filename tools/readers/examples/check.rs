//! What is wrong with measurements, or with a model's units, before anything is fitted.
//!
//! `cargo run --release -p stickslip-readers --example check -- model.toml data/ [model.toml data/ ...]`

use std::error::Error;
use std::path::Path;

use stickslip::fit::checks::check;
use stickslip::model::Model;
use stickslip_readers::read_dataset;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    for pair in arguments.chunks(2) {
        let [model, data] = pair else { return Err("a model and a dataset are expected".into()) };
        let found = check(&Model::parse(&std::fs::read_to_string(model)?)?, &read_dataset(Path::new(data))?);
        println!("{data}: {} findings", found.len());
        found.iter().for_each(|one| println!("  {}: {one}", one.fault.id()));
    }
    Ok(())
}
