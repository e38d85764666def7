//! A channel whose clock runs fast or slow.

use super::{
    ALL_KINDS, Confusion, Effect, EffectParameter, InTables, Needs, Part, PlaceKind, both_signs, experiments,
};
use crate::vocabulary as v;

pub(super) static EFFECT: Effect = Effect {
    id: "sensor_clock_drift",
    title: "Clock drift of a sensor",
    summary: "A channel is recorded by a clock of another rate: y(t (1 + ε))",
    explanation: "Two recorders without a common clock count time differently, by some parts in a hundred thousand, cheap \
          ones by far more. Their records agree at the beginning and run apart in proportion to time: the phase \
          between two channels drifts, and a loop opens that was a line. In a steady state of whole periods it has \
          no meaning.",
    confirmation: "Feed one signal to both recorders for as long as the test lasts: the phase between them grows in \
          proportion to time. Record on one clock.",
    confused_with: &[Confusion {
        with: &super::sensor_delay::EFFECT,
        why: "both make a channel late, and over a short record a mean lateness is all that shows",
        experiment: "compare the lateness at the beginning of a long record with that at its end: a delay stays, a \
              drift grows",
    }],
    next_experiment: experiments::SWAP_SENSORS,
    parameters: &[EffectParameter {
        quantity: &v::CLOCK_ERROR,
        neutral: Some(0.0),
        // A quarter of a period at the end of the record, whose travel is four strokes per period.
        range: |scales| both_signs((scales.displacement / scales.travel).min(0.05), 0.05),
    }],
    part: Part::Sensor,
    place: PlaceKind::Channel,
    kinds: ALL_KINDS,
    needs: Needs::Transient,
    in_tables: InTables::Columns(&[], "a table has no time in which two clocks could run apart"),
    apply: |values, channel, changes| changes.sensor(channel).clock_error = values[0],
    signature: |_| None,
};

#[cfg(test)]
mod tests {
    use super::super::{Changes, Location};

    #[test]
    fn a_drift_over_a_time_is_a_delay_that_grows_from_zero_to_its_product_with_that_time() {
        let channel = Location::Channel("force".to_owned());
        let (error, step) = (2e-3, 0.01);
        let mut drift = Changes::default();
        (super::EFFECT.apply)(&[error], Some(&channel), &mut drift);
        for index in [0, 1, 500, 20_000] {
            let mut late = Changes::default();
            late.sensor(Some(&channel)).delay = -error * f64::from(index) * step;
            let [drifted, late] =
                [&drift, &late].map(|changes| changes.sensors[0].place(index as usize, step));
            assert!((drifted - late).abs() <= 1e-12 * late, "{index}: {drifted} {late}");
        }
    }
}
