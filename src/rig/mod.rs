//! A test rig that is a model: records of tests as a laboratory would take them, from the beam and contact of a model file.
//!
//! A model and a [`Plan`] come in, [`Record`]s go out, as if measured. `plan`: what is tested, and the chain of sensors.
//! `bench`: the beam with its sensors as a system. `stepped_sine`: the motion at the shaker held, by harmonic balance.
//! `dual_mode`: two harmonics held at once, on a system that any builder made; `separation`: the preload below which the pin leaves
//! its support then. `random` and `ring_down`: in time, by `march`. `chain`: gains, delays and noise, and `spoiler` what they make of what was
//! `measured`.

mod bench;
mod chain;
mod dual_mode;
mod error;
mod march;
mod measured;
mod plan;
mod random;
mod ring_down;
mod separation;
mod spoiler;
mod stepped_sine;
mod tested;

pub use chain::{Chain, ChannelFault, NoiseLevel};
pub use dual_mode::{DualMode, dual_mode_on};
pub use error::RigError;
pub use plan::{
    Accelerometer, Frequencies, Plan, RandomTest, Release, RingDown, SteppedSine, Test, TestKind,
};
pub use separation::{Separation, Slap, separation_of, separation_on, slap_in_time};
pub use tested::Tested;

use crate::data::Record;
use crate::model::Model;
use bench::Bench;
use spoiler::Spoiler;

/// How far the tests have come.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RigProgress<'p> {
    /// The record that is being made.
    pub record: &'p str,
    /// Records that are done, with the fraction of the present one.
    pub done: f64,
    /// Records in all.
    pub of: usize,
}

/// The records of all tests of `plan` on the beam of `model`, in the plan's order. `watch` sees how far they have come and
/// says whether to go on.
///
/// # Errors
/// [`RigError`]: a model that is no beam, a test that cannot be made, a solver that fails, `watch` that ends it.
///
/// ```
/// use stickslip::model::Model;
/// use stickslip::rig::{Frequencies, Plan, SteppedSine, Test, TestKind, test_on};
/// let model = Model::parse(include_str!("../../examples/frictional-support/published.toml"))?;
/// let mut plan = Plan::of_sensors(&[0.55, 0.3, 0.1]);
/// let held = SteppedSine { frequencies: Frequencies::Resonance, ..SteppedSine::at(vec![40.0]) };
/// plan.tests.push(Test { name: "held".into(), use_for: None, kind: TestKind::SteppedSine(held) });
/// let records = test_on(&model, &plan, &mut |_| true)?;
/// let shown = &records[0].channel("acceleration:x=0.55").unwrap().values;
/// let largest = shown.iter().fold(0.0_f64, |most, a| most.max(a.abs()));
/// // The contact excites more than the first harmonic, which is held.
/// assert!(largest > 40.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn test_on(
    model: &Model,
    plan: &Plan,
    watch: &mut dyn FnMut(&RigProgress) -> bool,
) -> Result<Vec<Record>, RigError> {
    let tested = test_with_truth_on(model, plan, watch)?;
    Ok(tested.into_iter().map(|tested| tested.record).collect())
}

/// As [`test_on`], with what the contact truly did.
///
/// # Errors
/// As [`test_on`].
pub fn test_with_truth_on(
    model: &Model,
    plan: &Plan,
    watch: &mut dyn FnMut(&RigProgress) -> bool,
) -> Result<Vec<Tested>, RigError> {
    plan.check()?;
    plan.tests.iter().try_for_each(|test| test.kind.check_on(model))?;
    let bench = Bench::new(&plan.beam_under_test(model)?, &plan.sensors)?;
    let spoiler = Spoiler::new(&plan.chain, &plan.sensors);
    let names = plan.record_names();
    let of = names.iter().map(Vec::len).sum();
    let mut records = Vec::with_capacity(of);
    for (test, names) in plan.tests.iter().zip(&names) {
        for (index, name) in names.iter().enumerate() {
            let before = records.len();
            let mut part =
                |fraction: f64| watch(&RigProgress { record: name, done: before as f64 + fraction, of });
            if !part(0.0) {
                return Err(RigError::Interrupted);
            }
            let delays = spoiler.delays();
            let made = match &test.kind {
                TestKind::SteppedSine(test) => stepped_sine::measured(&bench, test, index, delays),
                TestKind::DualMode(test) => bench.steady().and_then(|()| {
                    dual_mode::measured(&bench.assembly, test, test.amplitudes[index], delays)
                }),
                TestKind::Random(test) => random::measured(&bench, test, delays, &mut part),
                TestKind::RingDown(test) => ring_down::measured(&bench, test, index, delays, &mut part),
            };
            let made = made.map_err(|error| error.of_record(name))?;
            let seed = records.len() as u64;
            records.push(spoiler.tested(name, test.kind.regime(), test.use_for, made, seed));
        }
    }
    Ok(records)
}
