//! What the master of a co-simulation costs beyond the FMUs: the same calls of `fmi2SetReal`, `fmi2DoStep` and
//! `fmi2GetReal` by function pointers alone and through the master, and a step by itself.
//!
//! `cargo bench -p stickslip-fmi-host --bench overhead`
//!
//! Others use the machine too. Both are therefore timed in turns of some ten microseconds each, within one run; the
//! shortest turn is one that nobody disturbed, and the median shows what is usual. Figures are per call.

use std::ffi::{CString, c_char, c_int, c_uint, c_void};
use std::hint::black_box;
use std::ops::ControlFlow;
use std::sync::Arc;
use std::time::Instant;

use stickslip::cosim::{
    self, Abilities, Algorithm, Causality, Kind, Master, Parallel, Settings, SlaveError, Stepped, System,
    Variable,
};
use stickslip::fmi::Instance;
use stickslip_fmi_host::Fmu;
use stickslip_fmu_package::{library, standard_models, write_fmu};
use tempfile::TempDir;

const STEP: f64 = 1e-4;
/// Turns that are timed of each.
const TURNS: usize = 4000;
/// Turns before: caches and the branch predictor learn.
const UNTIMED: usize = 200;
/// Steps in a turn, of all contacts together.
const STEPS_IN_A_TURN: usize = 400;

type Get = unsafe extern "C" fn(*mut c_void, *const c_uint, usize, *mut f64) -> c_int;
type Set = unsafe extern "C" fn(*mut c_void, *const c_uint, usize, *const f64) -> c_int;
type DoStep = unsafe extern "C" fn(*mut c_void, f64, f64, c_int) -> c_int;
type Instantiate = unsafe extern "C" fn(
    *const c_char,
    c_int,
    *const c_char,
    *const c_char,
    *const [usize; 5],
    c_int,
    c_int,
) -> *mut c_void;
type SetUp = unsafe extern "C" fn(*mut c_void, c_int, f64, f64, c_int, f64) -> c_int;
type Derivative = unsafe extern "C" fn(
    *mut c_void,
    *const c_uint,
    usize,
    *const c_uint,
    usize,
    *const f64,
    *mut f64,
) -> c_int;
type Plain = unsafe extern "C" fn(*mut c_void) -> c_int;

/// Components of one standard model, and nothing but the C functions.
struct Bare {
    components: Vec<*mut c_void>,
    get: Get,
    set: Set,
    do_step: DoStep,
    derivative: Derivative,
    displacement: c_uint,
    force: c_uint,
    _library: libloading::Library,
    _folder: TempDir,
}

impl Bare {
    fn new(name: &str, count: usize) -> Self {
        let model_toml = model(name);
        let folder = tempfile::tempdir().expect("a temporary folder");
        let file = folder.path().join(format!("{name}.{}", library().extension));
        std::fs::write(&file, library().bytes).expect("written");
        std::fs::write(folder.path().join("model.toml"), model_toml).expect("written");
        let description = Instance::new(model_toml).expect("a model");
        let text = |text: String| CString::new(text).expect("no zero byte");
        let guid = text(description.guid().to_string());
        let resources = text(format!("file://{}", folder.path().display()));
        let name = text(name.to_owned());
        // No logger, no memory functions.
        let callbacks = Box::leak(Box::new([0_usize; 5]));
        // SAFETY: signatures are those of the FMI 2.0 headers, pointers are alive, components are used while the
        // library is loaded and by one thread.
        unsafe {
            let library = libloading::Library::new(&file).expect("a library");
            let instantiate = *library.get::<Instantiate>(b"fmi2Instantiate").expect("a function");
            let set_up = *library.get::<SetUp>(b"fmi2SetupExperiment").expect("a function");
            let enter = *library.get::<Plain>(b"fmi2EnterInitializationMode").expect("a function");
            let exit = *library.get::<Plain>(b"fmi2ExitInitializationMode").expect("a function");
            let one = || {
                let (name, guid, resources) = (name.as_ptr(), guid.as_ptr(), resources.as_ptr());
                let component = instantiate(name, 1, guid, resources, callbacks, 0, 0);
                assert!(!component.is_null());
                let statuses = [set_up(component, 0, 0.0, 0.0, 0, 0.0), enter(component), exit(component)];
                assert_eq!(statuses, [0; 3]);
                component
            };
            Self {
                components: (0..count).map(|_| one()).collect(),
                get: *library.get::<Get>(b"fmi2GetReal").expect("a function"),
                set: *library.get::<Set>(b"fmi2SetReal").expect("a function"),
                do_step: *library.get::<DoStep>(b"fmi2DoStep").expect("a function"),
                derivative: *library.get::<Derivative>(b"fmi2GetDirectionalDerivative").expect("a function"),
                displacement: description.description().reference("displacement").expect("an input"),
                force: description.description().reference("force").expect("an output"),
                _library: library,
                _folder: folder,
            }
        }
    }

    /// The three calls of each contact, its displacement the structure's, its force in `forces`.
    fn step(&self, time: f64, displacement: f64, forces: &mut [f64]) {
        for (component, force) in self.components.iter().zip(forces) {
            // SAFETY: as in `new`.
            let statuses = unsafe {
                [
                    (self.set)(*component, &self.displacement, 1, &displacement),
                    (self.do_step)(*component, time, STEP, 1),
                    (self.get)(*component, &self.force, 1, force),
                ]
            };
            assert_eq!(statuses, [0; 3]);
        }
    }
}

fn model(name: &str) -> &'static str {
    standard_models().into_iter().find(|(other, _)| *other == name).expect("a standard model").1
}

/// A mass on a spring that takes any number of forces: next to no work.
#[derive(Debug)]
struct Structure {
    table: Vec<Variable>,
    forces: Vec<f64>,
    state: [f64; 2],
}

impl Structure {
    fn new(forces: usize) -> Self {
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
        Self { table, forces: vec![0.0; forces], state: [2e-5, 0.0] }
    }
}

impl cosim::Slave for Structure {
    fn name(&self) -> &str {
        "structure"
    }
    fn variables(&self) -> &[Variable] {
        &self.table
    }
    fn abilities(&self) -> Abilities {
        Abilities { variable_step: true, ..Abilities::default() }
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
        self.state[1] -= step * (1e5 * self.state[0] + 1e-3 * force / mass);
        self.state[0] += step * self.state[1];
        Ok(Stepped::Done)
    }
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// Nanoseconds per call of each turn: the same calls by `count` contacts and their structure, bare and through the
/// master.
fn beyond_the_fmus(name: &str, count: usize) -> [Vec<f64>; 2] {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join(format!("{name}.fmu"));
    std::fs::write(&file, write_fmu(name, model(name)).expect("an FMU")).expect("written");
    let fmu = Fmu::open(&file).expect("an FMU");
    let mut system = System::new();
    system.add(Box::new(Structure::new(count))).expect("a name");
    for index in 0..count {
        let contact = format!("contact{index}");
        system.add(Box::new(fmu.instantiate(&contact).expect("an instance"))).expect("a name");
        let force = format!("force{index}");
        system.connect(("structure", "displacement"), (&contact, "displacement"), 1.0, 0.0).expect("ports");
        system.connect((&contact, "force"), ("structure", &force), 1.0, 0.0).expect("ports");
    }
    system.observe("structure", "displacement").expect("a port");

    let steps = (STEPS_IN_A_TURN / count).max(4);
    let per_call = 1e9 / (steps * 3 * (count + 1)) as f64;
    let bare = Bare::new(name, count);
    let mut structure: Box<dyn cosim::Slave> = Box::new(Structure::new(count));
    let inputs: Vec<usize> = (0..count).collect();
    let (mut forces, mut given, mut moved) = (vec![0.0; count], vec![0.0; count], [0.0]);
    let (mut done, mut point_number) = (0_u64, 0);
    let (mut bare_times, mut times) = (Vec::with_capacity(TURNS), Vec::with_capacity(TURNS));

    let algorithm = Algorithm::Jacobi { extrapolation: 0 };
    let stop = STEP * ((TURNS + UNTIMED) * steps) as f64;
    let settings = Settings { parallel: Parallel::Never, ..Settings::new(algorithm, STEP, stop) };
    let master = Master::new(system, settings).expect("a system");
    let mut begin = Instant::now();
    let report = master.run(|point| {
        black_box(point.values);
        point_number += 1;
        if point_number == 1 {
            begin = Instant::now();
        } else if (point_number - 1) % steps == 0 {
            let through = begin.elapsed();
            let alone = Instant::now();
            for _ in 0..steps {
                let time = STEP * done as f64;
                done += 1;
                given.copy_from_slice(&forces);
                let displacement = moved[0];
                structure.set(&inputs, black_box(&given)).expect("inputs");
                structure.do_step(time, STEP).expect("a step");
                structure.get(black_box(&[count]), &mut moved).expect("an output");
                bare.step(time, displacement, &mut forces);
            }
            let alone = alone.elapsed();
            if (point_number - 1) / steps > UNTIMED {
                bare_times.push(alone.as_secs_f64() * per_call);
                times.push(through.as_secs_f64() * per_call);
            }
            begin = Instant::now();
        }
        ControlFlow::Continue(())
    });
    report.expect("a run");
    [bare_times, times]
}

/// `fmi2DoStep` with the inputs held; `fmi2SetReal` of a displacement that sticks and slips; both; and both with
/// `fmi2GetDirectionalDerivative` of the force by the displacement.
fn steps_alone(name: &str) -> [Vec<f64>; 4] {
    const CALLS: usize = 400;
    let bare = Bare::new(name, 1);
    let component = bare.components[0];
    let mut done = 0_u64;
    let mut time = || {
        done += 1;
        STEP * (done - 1) as f64
    };
    let value = |index: usize| {
        let fraction = (index % 64) as f64 / 32.0;
        30e-6 * if fraction < 1.0 { 2.0 * fraction - 1.0 } else { 3.0 - 2.0 * fraction }
    };
    let mut times = [const { Vec::new() }; 4];
    for turn in 0..TURNS + UNTIMED {
        for (which, times) in times.iter_mut().enumerate() {
            let (step, set) = [(true, false), (false, true), (true, true), (true, true)][which];
            let begin = Instant::now();
            for index in 0..CALLS {
                let value = value(index);
                // SAFETY: as in `Bare::new`.
                unsafe {
                    if set {
                        assert_eq!((bare.set)(component, &bare.displacement, 1, &value), 0);
                    }
                    if step {
                        assert_eq!((bare.do_step)(component, time(), STEP, 1), 0);
                    }
                    if which == 3 {
                        let (force, displacement) = (&bare.force, &bare.displacement);
                        let mut tangent = 0.0;
                        let status =
                            (bare.derivative)(component, force, 1, displacement, 1, &1.0, &mut tangent);
                        assert_eq!(status, 0);
                        black_box(tangent);
                    }
                }
            }
            if turn >= UNTIMED {
                times.push(begin.elapsed().as_secs_f64() * 1e9 / CALLS as f64);
            }
        }
    }
    times
}

fn shortest(times: &[f64]) -> f64 {
    times.iter().copied().fold(f64::INFINITY, f64::min)
}

/// Of the lines, those with the first argument in them.
fn main() {
    let wanted = std::env::args().nth(1).filter(|word| !word.starts_with('-')).unwrap_or_default();
    let models = ["JenkinsContact", "ValanisContact"];
    println!(
        "fmi2DoStep alone (ns)              held: shortest  median   moving: shortest  median   \
         derivative: shortest  median"
    );
    for name in models.into_iter().filter(|name| name.contains(&wanted)) {
        let [held, set, both, all] = steps_alone(name).map(|times| (shortest(&times), median(times)));
        let (moving, more) = ((both.0 - set.0, both.1 - set.1), (all.0 - both.0, all.1 - both.1));
        println!(
            "{name:<35}{:>14.1}{:>8.1}{:>18.1}{:>8.1}{:>22.1}{:>8.1}",
            held.0, held.1, moving.0, moving.1, more.0, more.1
        );
    }
    println!(
        "\nper call (ns)                      bare: shortest  median   master: shortest  median   beyond: shortest  median"
    );
    for (name, count) in models.into_iter().flat_map(|name| [1, 10, 100].map(|count| (name, count))) {
        let label = format!("{count} x {name}");
        if !label.contains(&wanted) {
            continue;
        }
        let [bare, through] = beyond_the_fmus(name, count);
        // Of the differences of turns that follow each other.
        let usual = median(bare.iter().zip(&through).map(|(bare, through)| through - bare).collect());
        let beyond = shortest(&through) - shortest(&bare);
        let [bare, through] = [bare, through].map(|times| (shortest(&times), median(times)));
        println!(
            "{label:<35}{:>14.1}{:>8.1}{:>18.1}{:>8.1}{beyond:>18.1}{usual:>8.1}",
            bare.0, bare.1, through.0, through.1
        );
    }
}
