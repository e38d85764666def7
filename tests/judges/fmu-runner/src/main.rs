//! The crate fmu-runner as a judge: steps an FMU through its stimuli and compares its outputs with the reference results.
//! Prints one line, as the judges in Python do (`../case.py`).

use std::collections::HashMap;
use std::error::Error;
use std::path::Path;

use fmu_runner::{Fmu, FmuInstance, fmi2Type};

const FOLDER: &str = "extra/org.fmi-standard.fmi-ls-ref";
/// Of the largest value of the output.
const TOLERANCE: f64 = 1e-9;

struct Table {
    names: Vec<String>,
    rows: Vec<Vec<f64>>,
}

impl Table {
    fn read(file: &Path) -> Result<Self, Box<dyn Error>> {
        let text = std::fs::read_to_string(file)?;
        let mut lines = text.lines();
        let names = lines.next().unwrap_or_default().split(',').map(|name| name.trim_matches('"').to_owned());
        let names = names.collect();
        let row = |line: &str| line.split(',').map(str::parse).collect::<Result<Vec<f64>, _>>();
        Ok(Self { names, rows: lines.map(row).collect::<Result<_, _>>()? })
    }
}

fn judge(file: &Path, folder: &Path) -> Result<String, Box<dyn Error>> {
    let library = Fmu::unpack_to(file, folder)?.load(fmi2Type::fmi2CoSimulation)?;
    let [stimuli, reference] =
        ["stimuli.csv", "reference.csv"].map(|name| Table::read(&folder.join(FOLDER).join(name)));
    let (stimuli, reference) = (stimuli?, reference?);
    let fmu = FmuInstance::instantiate(&library, false)?;
    let signals = library.variables();
    let stop = reference.rows.last().map(|row| row[0]);
    fmu.setup_experiment(0.0, stop, Some(1e-6))?;
    fmu.enter_initialization_mode()?;
    let set = |row: &[f64]| {
        let inputs = stimuli.names.iter().zip(row).skip(1);
        fmu.set_reals(&inputs.map(|(name, value)| (&signals[name], *value)).collect::<HashMap<_, _>>())
    };
    set(&stimuli.rows[0])?;
    fmu.exit_initialization_mode()?;
    // The one output that is a whole number is no Real.
    let outputs: Vec<usize> =
        (1..reference.names.len()).filter(|column| reference.names[*column] != "slip_state").collect();
    let mut worst: f64 = 0.0;
    for (begin, end) in reference.rows.iter().zip(&reference.rows[1..]) {
        set(&stimuli.rows[(begin[0] / reference.rows[1][0]).round() as usize])?;
        fmu.do_step(begin[0], end[0] - begin[0], true)?;
        for column in &outputs {
            let signal = &signals[&reference.names[*column]];
            let found = fmu.get_reals(&[signal])?[signal];
            let scale = reference.rows.iter().map(|row| row[*column].abs()).fold(f64::MIN_POSITIVE, f64::max);
            worst = worst.max((found - end[*column]).abs() / scale);
        }
    }
    if worst > TOLERANCE {
        return Ok(format!("remarks an output differs by {worst:.1e} of its largest value"));
    }
    let distance = if worst == 0.0 { "bit by bit".to_owned() } else { format!("within {worst:.0e}") };
    Ok(format!("good {} outputs {distance}", outputs.len()))
}

fn main() {
    let file = std::env::args_os().nth(1).expect("an FMU");
    let folder = std::env::temp_dir().join(format!("judge-fmu-runner-{}", std::process::id()));
    match judge(Path::new(&file), &folder) {
        Ok(said) => println!("JUDGED {said}"),
        Err(error) => println!("JUDGED fails {error}"),
    }
    let _ = std::fs::remove_dir_all(folder);
}
