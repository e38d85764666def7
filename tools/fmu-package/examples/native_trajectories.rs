//! Writes the standard FMUs to a folder, and beside each a CSV file of a run of the same model without
//! FMI: for `tests/fmi`, which runs the FMUs on the same inputs and demands the same outputs.
//!
//! `cargo run -p stickslip-fmu-package --example native_trajectories -- FOLDER`

use std::fmt::Write as _;
use std::path::Path;
use std::{env, fs};

mod native {
    //! The models by the library's own means, not through a slave.
    use stickslip::contact::{ContactLaw, Inputs, Jenkins, Valanis};
    use stickslip::model::{Law, Model};

    /// Column names and rows.
    pub type Table = (Vec<String>, Vec<Vec<f64>>);

    /// Start of a smooth cycle of displacement with growing amplitude.
    fn displacement(time: f64) -> (f64, f64) {
        let (amplitude, growth, rate) = (20e-6, 60e-6, 2.0 * std::f64::consts::PI * 7.0);
        let (sine, cosine) = (rate * time).sin_cos();
        let level = amplitude + growth * time;
        (level * sine, growth * sine + level * rate * cosine)
    }

    /// A contact under a prescribed displacement and a normal load that lifts off twice.
    pub fn contact(model: &Model) -> Table {
        let contact = model.contact.expect("a contact model");
        let (k, mu) = (contact.tangential_stiffness, contact.friction_coefficient);
        let law: Box<dyn ContactLaw> = match contact.law {
            Law::Jenkins => Box::new(Jenkins::new(k, mu).expect("legal")),
            Law::Valanis { smoothness, residual_stiffness } => {
                Box::new(Valanis::new(k, mu, smoothness, residual_stiffness).expect("legal"))
            }
        };
        let mut state = vec![0.0; law.state_len()];
        let mut next = state.clone();
        let names = ["displacement", "velocity", "normal_load", "force", "dissipated_energy", "slip_state"];
        let mut rows = Vec::new();
        let mut energy = 0.0;
        for row in 0..=1000 {
            let time = f64::from(row) * 1e-3;
            let (displacement, velocity) = displacement(time);
            let normal_load = contact.normal_load * (1.0 + 1.1 * (11.0 * time).sin());
            let inputs = Inputs { displacement, velocity, normal_load };
            if row == 0 {
                law.set_state(0.0, normal_load, 0.0, &mut state);
            }
            let response = law.step(&state, inputs, &mut next);
            std::mem::swap(&mut state, &mut next);
            energy += response.dissipated_energy;
            let slip = f64::from(response.slip_state as i32);
            rows.push(vec![time, displacement, velocity, normal_load, response.force, energy, slip]);
        }
        (names.map(String::from).to_vec(), rows)
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = env::args().nth(1).ok_or("which folder?")?;
    let folder = Path::new(&folder);
    fs::create_dir_all(folder)?;
    for (name, model_toml) in stickslip_fmu_package::standard_models() {
        let Ok(fmu) = stickslip_fmu_package::write_fmu(name, model_toml) else { continue };
        fs::write(folder.join(format!("{name}.fmu")), fmu)?;
        let model = stickslip::model::Model::parse(model_toml)?;
        let (names, rows) = native::contact(&model);
        let mut csv = format!("time,{}\n", names.join(","));
        for row in rows {
            let cells: Vec<String> = row.iter().map(f64::to_string).collect();
            writeln!(csv, "{}", cells.join(","))?;
        }
        fs::write(folder.join(format!("{name}.csv")), csv)?;
    }
    Ok(())
}
