//! What is stepped through a record from sample to sample: one model under the record's inputs, a contact alone or a
//! system.

pub(super) mod contact;
pub(super) mod excitation;
pub(super) mod system;

/// One model under the inputs of one record, at one of its samples.
pub(super) trait Stepper {
    /// Goes to the first sample, at rest there: nothing moves, and nothing is remembered.
    fn rest(&mut self);

    /// Writes what each channel shows at sample `index`, where the motion now is.
    fn observe(&mut self, index: usize, out: &mut [f64]) -> Result<(), String>;

    /// Steps from sample `index` to the next.
    fn advance(&mut self, index: usize) -> Result<(), String>;
}

/// Steps through the first `samples` and writes what `channels` channels show, one channel after the other.
pub(super) fn march(
    stepper: &mut dyn Stepper,
    channels: usize,
    samples: usize,
    out: &mut Vec<f64>,
) -> Result<(), String> {
    out.clear();
    out.resize(channels * samples, 0.0);
    let mut now = vec![0.0; channels];
    for index in 0..samples {
        if index > 0 {
            stepper.advance(index - 1)?;
        }
        stepper.observe(index, &mut now)?;
        for (channel, value) in now.iter().enumerate() {
            out[channel * samples + index] = *value;
        }
    }
    Ok(())
}
