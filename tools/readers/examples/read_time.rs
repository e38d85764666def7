//! Seconds that a file of measurements takes to be read: `cargo run --release -p stickslip-readers --example read_time FILE`

use std::time::Instant;

use stickslip_readers::{ImportOptions, import_file};

fn main() {
    let file = std::env::args_os().nth(1).expect("the file to read");
    let begin = Instant::now();
    match import_file(file.as_ref(), &ImportOptions::default()) {
        Ok(imported) => {
            let rows: usize = imported.records.iter().map(stickslip::data::Record::len).sum();
            println!("{rows} rows in {:.2} s", begin.elapsed().as_secs_f64());
        }
        Err(error) => println!("{error}"),
    }
}
