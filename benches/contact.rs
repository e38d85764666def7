//! Time and allocations of a contact law's step: `cargo bench --bench contact`.
//!
//! Each figure is for 256 steps; the item rate gives steps per second. Allocations are printed below
//! the figures of what allocates, which only the last bench may, whose workspace is new every time.

use divan::counter::ItemsCount;
use divan::{AllocProfiler, Bencher, black_box};
use stickslip::contact::{ContactLaw, Inputs, Jenkins, Period, PeriodicSolver, StateTangents, Valanis};

#[global_allocator]
static ALLOCATOR: AllocProfiler = AllocProfiler::system();

const LOAD: f64 = 147.15;
const STEPS: usize = 256;

fn main() {
    divan::main();
}

/// Displacements (m) of a history.
#[derive(Debug, Clone, Copy)]
enum History {
    /// Within the limit of Jenkins' element.
    Stick,
    /// One way, far beyond it.
    Slip,
    /// A harmonic that sticks and slips.
    Mixed,
}

fn displacements(history: History) -> [f64; STEPS] {
    std::array::from_fn(|i| {
        let fraction = i as f64 / STEPS as f64;
        let sine = (std::f64::consts::TAU * fraction).sin();
        match history {
            History::Stick => 5e-6 * sine,
            History::Slip => 50e-6 + 100e-6 * fraction,
            History::Mixed => 40e-6 * sine,
        }
    })
}

fn jenkins() -> Jenkins {
    Jenkins::new(7.9e6, 0.617).unwrap()
}

fn valanis() -> Valanis {
    Valanis::from_lambda(7.9e6, 0.0, 0.3, 8.7e4, LOAD).unwrap()
}

fn march<L: ContactLaw, const N: usize>(bencher: Bencher, law: &L, history: History) {
    let samples = displacements(history);
    let mut state = [0.0; N];
    law.set_state(samples[0], LOAD, 0.0, &mut state);
    bencher.counter(ItemsCount::new(STEPS)).bench_local(|| {
        let (mut state, mut next) = (black_box(state), [0.0; N]);
        let mut sum = 0.0;
        for displacement in black_box(&samples) {
            let inputs = Inputs { displacement: *displacement, velocity: 0.0, normal_load: LOAD };
            let response = law.step(&state, inputs, &mut next);
            sum += response.force + response.dissipated_energy + response.tangents.displacement;
            state = next;
        }
        sum
    });
}

#[divan::bench(args = [History::Stick, History::Slip, History::Mixed])]
fn jenkins_256_steps(bencher: Bencher, history: History) {
    march::<_, 3>(bencher, &jenkins(), history);
}

#[divan::bench(args = [History::Stick, History::Slip, History::Mixed])]
fn valanis_256_steps(bencher: Bencher, history: History) {
    march::<_, 4>(bencher, &valanis(), history);
}

#[divan::bench]
fn valanis_256_state_tangents(bencher: Bencher) {
    let (law, samples) = (valanis(), displacements(History::Mixed));
    let mut tangents = StateTangents::default();
    tangents.reset(4);
    let state = [10.0, 0.0, LOAD, 0.0];
    bencher.counter(ItemsCount::new(STEPS)).bench_local(|| {
        let mut sum = 0.0;
        for displacement in black_box(&samples) {
            let inputs = Inputs { displacement: *displacement, velocity: 0.0, normal_load: LOAD };
            law.state_tangents(black_box(&state), inputs, &mut tangents);
            sum += tangents.next_by_state[0];
        }
        sum
    });
}

#[divan::bench]
fn valanis_periodic_state_of_256_samples(bencher: Bencher) {
    let (law, samples) = (valanis(), displacements(History::Stick));
    let period = Period { displacement: &samples, velocity: &[], normal_load: &[LOAD] };
    let mut solver = PeriodicSolver::new();
    let mut solve = || {
        let mut state = [0.0, 0.0, LOAD, 0.0];
        solver.solve(black_box(&law), &period, &mut state).map(|info| info.iterations)
    };
    solve().expect("the loop has a periodic state");
    bencher.bench_local(solve);
}

#[divan::bench]
fn with_new_workspace_valanis_periodic_state_of_256_samples(bencher: Bencher) {
    let (law, samples) = (valanis(), displacements(History::Stick));
    let period = Period { displacement: &samples, velocity: &[], normal_load: &[LOAD] };
    bencher.bench_local(|| {
        let mut state = [0.0, 0.0, LOAD, 0.0];
        PeriodicSolver::new().solve(black_box(&law), &period, &mut state).map(|info| info.iterations)
    });
}
