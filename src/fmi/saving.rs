//! The whole of an instance into a snapshot, and back.

use super::error::Error;
use super::instance::Instance;
use super::snapshot::{Snapshot, SnapshotError};
use super::stage::Stage;

/// Numbers in a snapshot besides values and state: time, tolerance, stop, and whether time is known.
const CLOCK: usize = 4;
/// Numbers for the derivatives of an input: whether it has any, and three.
const PER_SLOPE: usize = 4;

impl Instance {
    /// Saves everything that [`Instance::restore`] needs.
    pub fn snapshot(&self) -> Snapshot {
        let mut snapshot = Snapshot { guid: self.shared.guid, stage: self.stage, numbers: Vec::new() };
        self.save(&mut snapshot);
        snapshot
    }

    /// Saves into an existing snapshot, without allocating if it is of the same model.
    pub fn save(&self, snapshot: &mut Snapshot) {
        snapshot.guid = self.shared.guid;
        snapshot.stage = self.stage;
        let numbers = &mut snapshot.numbers;
        numbers.clear();
        numbers.reserve_exact(self.numbers());
        numbers.extend_from_slice(&self.values);
        numbers.extend_from_slice(&self.state);
        let slopes = (0..self.shared.inputs).map(|input| self.asked.slopes.get(input).copied().flatten());
        numbers.extend(slopes.flat_map(|slope| {
            let [first, second, third] = slope.unwrap_or_default();
            [f64::from(u8::from(slope.is_some())), first, second, third]
        }));
        let known = f64::from(u8::from(self.time.is_some()));
        numbers.extend_from_slice(&[self.time.unwrap_or(0.0), known, self.asked.tolerance, self.stop]);
        numbers.extend(self.continuous.iter().flat_map(|continuous| &continuous.accepted));
    }

    /// Numbers in a snapshot.
    fn numbers(&self) -> usize {
        let accepted = self.continuous.as_ref().map_or(0, |continuous| continuous.accepted.len());
        self.values.len() + self.state.len() + PER_SLOPE * self.shared.inputs + CLOCK + accepted
    }

    /// Makes the instance continue where `snapshot` was saved, bit by bit.
    ///
    /// # Errors
    /// A snapshot of another model, or with numbers that no instance has; the instance is as before.
    ///
    /// ```
    /// use stickslip::fmi::{Instance, Setup};
    /// # let text = r#"
    /// #     schema = "stickslip.model/1"
    /// #     kind = "contact"
    /// #     contact = { law = "jenkins", tangential_stiffness = 2e6, friction_coefficient = 0.5, normal_load = 100.0 }
    /// # "#;
    /// let mut contact = Instance::new(text)?;
    /// let displacement = contact.description().reference("displacement").unwrap();
    /// contact.set_up(Setup::default())?;
    /// contact.enter_initialization()?;
    /// contact.exit_initialization()?;
    /// let saved = contact.snapshot();
    /// contact.set_real(&[displacement], &[40e-6])?;
    /// contact.do_step(0.0, 1e-3)?;
    /// contact.restore(&saved)?;
    /// assert_eq!((contact.time(), contact.snapshot()), (0.0, saved));
    /// # Ok::<(), stickslip::fmi::Error>(())
    /// ```
    pub fn restore(&mut self, snapshot: &Snapshot) -> Result<(), Error> {
        if snapshot.guid != self.shared.guid {
            return Err(SnapshotError::OtherModel { found: snapshot.guid, expected: self.shared.guid }.into());
        }
        let (values_len, state_len) = (self.values.len(), self.state.len());
        let expected = self.numbers();
        if snapshot.numbers.len() != expected {
            return Err(SnapshotError::Corrupt.into());
        }
        let (values, rest) = snapshot.numbers.split_at(values_len);
        let (state, rest) = rest.split_at(state_len);
        let (slopes, rest) = rest.split_at(PER_SLOPE * self.shared.inputs);
        let (clock, accepted) = rest.split_at(CLOCK);
        // Bytes may come from anywhere. Only the stop time may be infinite.
        let [_, _, tolerance, stop] = *clock else { return Err(SnapshotError::Corrupt.into()) };
        let stop_at = expected - accepted.len() - 1;
        let mut others = snapshot.numbers[..stop_at].iter().chain(accepted);
        let finite = others.all(|number| number.is_finite());
        let of_this_kind = match snapshot.stage {
            Stage::Event | Stage::ContinuousTime => self.is_continuous(),
            Stage::StepComplete | Stage::StepFailed => !self.is_continuous(),
            Stage::Instantiated | Stage::Initialization | Stage::Terminated => true,
        };
        if !finite || !of_this_kind || tolerance <= 0.0 || stop.is_nan() {
            return Err(SnapshotError::Corrupt.into());
        }
        // In the first two stages the parameters are still open and need not make a model.
        let stale = matches!(snapshot.stage, Stage::Instantiated | Stage::Initialization);
        if !stale {
            self.build(&values[self.shared.parameters()])?;
        }
        self.values.copy_from_slice(values);
        self.state.copy_from_slice(state);
        self.asked.slopes.clear();
        let slopes = slopes.as_chunks::<PER_SLOPE>().0;
        if slopes.iter().any(|[known, ..]| *known != 0.0) {
            let slope = |[known, given @ ..]: &[f64; PER_SLOPE]| (*known != 0.0).then_some(*given);
            self.asked.slopes.extend(slopes.iter().map(slope));
        }
        self.stage = snapshot.stage;
        self.stale = stale || matches!(snapshot.stage, Stage::Event | Stage::ContinuousTime);
        if let Some(continuous) = &mut self.continuous {
            continuous.accepted.copy_from_slice(accepted);
        }
        self.time = (clock[1] != 0.0).then_some(clock[0]);
        self.asked.tolerance = tolerance;
        self.stop = stop;
        Ok(())
    }
}
