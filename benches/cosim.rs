//! What the master of a co-simulation costs: time per slave call beyond the slave's own, contacts on one structure one
//! by one and at the same time, and the allocations of a run (the same for any number of steps).
//!
//! Items are slave calls (set, step, get); where the master repeats steps, communication steps.

use divan::counter::ItemsCount;
use divan::{AllocProfiler, Bencher, black_box};
use std::ops::ControlFlow;
use std::sync::Arc;
use stickslip::cosim::{
    Abilities, Algorithm, Causality, Kind, Master, NativeSlave, Parallel, Settings, Slave, SlaveError,
    Stepped, Strong, System, Variable,
};
use stickslip::model::Model;

#[global_allocator]
static ALLOC: AllocProfiler = AllocProfiler::system();

const CONTACTS: [usize; 4] = [1, 10, 100, 1000];
const VALANIS: &str = include_str!("../modelDescription/ValanisContact.toml");
const JACOBI: Algorithm = Algorithm::Jacobi { extrapolation: 0 };

fn main() {
    divan::main();
}

/// A mass on a spring that takes any number of forces: next to no work.
#[derive(Debug)]
struct Structure {
    name: String,
    table: Vec<Variable>,
    forces: Vec<f64>,
    state: [f64; 2],
    saved: [[f64; 2]; 2],
}

impl Structure {
    fn new(name: &str, forces: usize) -> Self {
        let row = |name: String, causality, unit: &str| Variable {
            name: name.into(),
            reference: 0,
            kind: Kind::Real,
            causality,
            unit: Some(unit.into()),
            start: None,
            depends_on: (causality == Causality::Output).then(Arc::default),
        };
        let mut table: Vec<Variable> =
            (0..forces).map(|index| row(format!("force{index}"), Causality::Input, "N")).collect();
        table.push(row("displacement".to_owned(), Causality::Output, "m"));
        let (name, state) = (name.to_owned(), [2e-5, 0.0]);
        Self { name, table, forces: vec![0.0; forces], state, saved: [[0.0; 2]; 2] }
    }
}

impl Slave for Structure {
    fn name(&self) -> &str {
        &self.name
    }
    fn variables(&self) -> &[Variable] {
        &self.table
    }
    fn abilities(&self) -> Abilities {
        Abilities { saves_state: true, variable_step: true, ..Abilities::default() }
    }
    fn set(&mut self, variables: &[usize], values: &[f64]) -> Result<(), SlaveError> {
        variables.iter().zip(values).for_each(|(variable, value)| self.forces[*variable] = *value);
        Ok(())
    }
    fn get(&mut self, _: &[usize], values: &mut [f64]) -> Result<(), SlaveError> {
        values.fill(self.state[0]);
        Ok(())
    }
    fn do_step(&mut self, _: f64, step: f64) -> Result<Stepped, SlaveError> {
        let mass = self.forces.len().max(1) as f64;
        let force: f64 = self.forces.iter().sum();
        self.state[1] -= step * (1e5 * self.state[0] + force / mass);
        self.state[0] += step * self.state[1];
        Ok(Stepped::Done)
    }
    fn save(&mut self, slot: usize) -> Result<(), SlaveError> {
        self.saved[slot] = self.state;
        Ok(())
    }
    fn restore(&mut self, slot: usize) -> Result<(), SlaveError> {
        self.state = self.saved[slot];
        Ok(())
    }
}

/// One structure and `count` slaves that take its displacement and give it forces.
fn system(count: usize, contact: impl Fn(&str) -> Box<dyn Slave>, [input, output]: [&str; 2]) -> System {
    let mut system = System::new();
    system.add(Box::new(Structure::new("structure", count))).expect("a name");
    for index in 0..count {
        let name = format!("contact{index}");
        system.add(contact(&name)).expect("a name");
        system.connect(("structure", "displacement"), (&name, input), 1.0, 0.0).expect("ports");
        system.connect((&name, output), ("structure", &format!("force{index}")), 1e-3, 0.0).expect("ports");
    }
    system.observe("structure", "displacement").expect("a port");
    system
}

fn trivial(name: &str) -> Box<dyn Slave> {
    Box::new(Structure::new(name, 1))
}

fn run(master: Master) -> u64 {
    let report = master.run(|point| {
        black_box(point.values);
        ControlFlow::Continue(())
    });
    report.expect("a run").steps
}

fn bench(
    bencher: Bencher,
    steps: u64,
    items: usize,
    settings: impl Fn(Settings) -> Settings,
    system: impl Fn() -> System,
) {
    let settings = settings(Settings::new(JACOBI, 1e-4, 1e-4 * steps as f64));
    bencher
        .counter(ItemsCount::new(steps as usize * items))
        .with_inputs(|| Master::new(system(), settings.clone()).expect("a system"))
        .bench_local_values(run);
}

/// Many enough for the beginning of a run not to count.
fn steps(contacts: usize) -> usize {
    (200_000 / contacts).max(4_000)
}

/// Slaves of next to no work under the master.
#[divan::bench(args = CONTACTS, sample_count = 20, sample_size = 1)]
fn overhead_under_the_master(bencher: Bencher, contacts: usize) {
    let steps = steps(contacts) as u64;
    let serial = |settings| Settings { parallel: Parallel::Never, ..settings };
    bench(bencher, steps, 3 * (contacts + 1), serial, || {
        system(contacts, trivial, ["force0", "displacement"])
    });
}

/// The same calls without a master: what to subtract.
#[divan::bench(args = CONTACTS, sample_count = 20, sample_size = 1)]
fn overhead_of_the_calls_alone(bencher: Bencher, contacts: usize) {
    let steps = steps(contacts);
    bencher
        .counter(ItemsCount::new(steps * 3 * (contacts + 1)))
        .with_inputs(|| {
            let mut slaves: Vec<Box<dyn Slave>> = vec![Box::new(Structure::new("structure", contacts))];
            slaves.extend((0..contacts).map(|_| trivial("contact")));
            let inputs: Vec<usize> = (0..contacts).collect();
            (slaves, inputs, vec![0.0; contacts])
        })
        .bench_local_values(|(mut slaves, inputs, values)| {
            let mut output = [0.0];
            for step in 0..steps {
                for (index, slave) in slaves.iter_mut().enumerate() {
                    let count = if index == 0 { contacts } else { 1 };
                    slave.set(&inputs[..count], black_box(&values[..count])).expect("inputs");
                    slave.do_step(1e-4 * step as f64, 1e-4).expect("a step");
                    slave.get(black_box(&[count]), &mut output).expect("an output");
                }
            }
            black_box(output)
        });
}

/// The same number of allocations for ten times the steps: none in a step.
#[divan::bench(args = [100_u64, 1_000, 10_000], sample_count = 5, sample_size = 1)]
fn allocations_of_strong_coupling(bencher: Bencher, steps: u64) {
    let strong = |settings| Settings {
        algorithm: Algorithm::Strong(Strong::default()),
        parallel: Parallel::Never,
        ..settings
    };
    let valanis = Model::parse(VALANIS).expect("a model");
    let contact = |name: &str| Box::new(NativeSlave::new(name, &valanis).expect("a slave")) as Box<dyn Slave>;
    bench(bencher, steps, 1, strong, || system(3, contact, ["displacement", "force"]));
}

fn contacts(bencher: Bencher, contacts: usize, algorithm: Algorithm, parallel: Parallel) {
    let valanis = Model::parse(VALANIS).expect("a model");
    let contact = |name: &str| Box::new(NativeSlave::new(name, &valanis).expect("a slave")) as Box<dyn Slave>;
    let settings = |settings| Settings { algorithm: algorithm.clone(), parallel, ..settings };
    let steps = (20_000 / contacts as u64).max(400);
    bench(bencher, steps, 1, settings, || system(contacts, contact, ["displacement", "force"]));
}

#[divan::bench(args = CONTACTS, sample_count = 5, sample_size = 1)]
fn jacobi_one_by_one(bencher: Bencher, count: usize) {
    contacts(bencher, count, JACOBI, Parallel::Never);
}

#[divan::bench(args = CONTACTS, sample_count = 5, sample_size = 1)]
fn jacobi_at_the_same_time(bencher: Bencher, count: usize) {
    contacts(bencher, count, JACOBI, Parallel::Always);
}

#[divan::bench(args = CONTACTS, sample_count = 5, sample_size = 1)]
fn strong_one_by_one(bencher: Bencher, count: usize) {
    contacts(bencher, count, Algorithm::Strong(Strong::default()), Parallel::Never);
}

#[divan::bench(args = CONTACTS, sample_count = 5, sample_size = 1)]
fn strong_automatic(bencher: Bencher, count: usize) {
    contacts(bencher, count, Algorithm::Strong(Strong::default()), Parallel::Auto);
}
