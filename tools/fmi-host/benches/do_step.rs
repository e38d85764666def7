//! Time of a step of a contact through the C interface of the shared library.
//!
//! `cargo bench -p stickslip-fmi-host`

use divan::Bencher;
use stickslip::fmi::Instance;
use stickslip_fmi_host::{Library, Slave};
use stickslip_fmu_package::{library, standard_models};
use tempfile::TempDir;

fn main() {
    divan::main();
}

/// Calls in one sample, to keep the clock out of the figure.
const CALLS: u32 = 1000;

/// The standard model number `index`, initialized; the folder must outlive it.
fn slave(index: usize) -> (TempDir, Slave) {
    let (name, model_toml) = standard_models()[index];
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join(format!("{name}.{}", library().extension));
    std::fs::write(&file, library().bytes).expect("written");
    std::fs::write(folder.path().join("model.toml"), model_toml).expect("written");
    let guid = Instance::new(model_toml).expect("a standard model").guid().to_string();
    let library = Library::load(&file).expect("a library");
    let mut slave = Slave::new(library, name, &guid, folder.path()).expect("a slave");
    slave.set_up(None, 0.0).expect("set up");
    slave.enter_initialization().expect("initialization");
    slave.exit_initialization().expect("initialization");
    (folder, slave)
}

/// Displacements of a cycle that sticks and slips.
fn displacement(index: u32) -> f64 {
    let fraction = f64::from(index % 64) / 32.0;
    30e-6 * if fraction < 1.0 { 2.0 * fraction - 1.0 } else { 3.0 - 2.0 * fraction }
}

#[divan::bench(args = ["JenkinsContact", "ValanisContact"])]
fn do_step_alone(bencher: Bencher, name: &str) {
    let (_folder, mut slave) = slave(usize::from(name == "ValanisContact"));
    let mut step = 0_u64;
    bencher.counter(divan::counter::ItemsCount::new(CALLS)).bench_local(|| {
        for _ in 0..CALLS {
            slave.do_step(step as f64 * 1e-3, 1e-3).expect("a step");
            step += 1;
        }
    });
}

#[divan::bench(args = ["JenkinsContact", "ValanisContact"])]
fn set_inputs_do_step_get_force(bencher: Bencher, name: &str) {
    let (_folder, mut slave) = slave(usize::from(name == "ValanisContact"));
    let mut step = 0_u64;
    bencher.counter(divan::counter::ItemsCount::new(CALLS)).bench_local(|| {
        let mut force = [0.0];
        for index in 0..CALLS {
            slave.set_real(&[0, 2], &[displacement(index), 147.15]).expect("inputs");
            slave.do_step(step as f64 * 1e-3, 1e-3).expect("a step");
            slave.get_real(&[3], &mut force).expect("force");
            step += 1;
        }
        force
    });
}
