//! What contacts answer to a disturbance at one phase.

use nalgebra::DMatrix;

use super::step::Step;

/// Forces and memory at the end of a step, linear in the disturbances `[y, ẏ, memory]`: displacements and velocities
/// of the channels there, memory before it.
#[derive(Debug)]
pub(super) struct Feedback {
    /// Forces (N), a row per channel.
    pub force: DMatrix<f64>,
    /// Memory, a row for each number.
    pub memory: DMatrix<f64>,
    channels: usize,
}

/// How a contact is attached to the structure.
pub(super) struct Attachment<'a> {
    /// Its displacement by those of the channels, and the rate of that.
    pub arm: &'a [f64],
    pub arm_rate: &'a [f64],
    /// First place of its memory.
    pub memory: usize,
    /// The spring in front of it.
    pub series: Series,
}

/// A spring in front of a contact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Series {
    Rigid,
    /// Compliance (m/N), where the contact answers to no velocity but that in front of it.
    Spring(f64),
    /// Compliance (m/N) and the step (s), over which the velocity is a difference: the contact's displacement is
    /// remembered behind the rest of its memory.
    Yielding(f64, f64),
}

impl Feedback {
    pub fn new(channels: usize, memory: usize) -> Self {
        let width = 2 * channels + memory;
        Self { force: DMatrix::zeros(channels, width), memory: DMatrix::zeros(memory, width), channels }
    }

    /// Adds a contact.
    pub fn attach(&mut self, step: &Step, attachment: &Attachment) {
        let (m, width) = (self.channels, self.force.ncols());
        let place = 2 * m + attachment.memory;
        let states = step.state.force_by_state.len();
        let mut moved = vec![0.0; width];
        moved[..m].copy_from_slice(attachment.arm);
        let mut remembered = vec![0.0; width];
        remembered[place..place + states].copy_from_slice(&step.state.force_by_state);
        let (stiffness, damping) = (step.by_displacement, step.by_velocity);
        let rate = || {
            let mut rate = vec![0.0; width];
            rate[..m].copy_from_slice(attachment.arm_rate);
            rate[m..2 * m].copy_from_slice(attachment.arm);
            rate
        };
        let (displacement, velocity, force);
        match attachment.series {
            Series::Rigid => {
                let rate = rate();
                force = sum([(stiffness, &moved), (damping, &rate), (1.0, &remembered)]);
                (displacement, velocity) = (moved, rate);
            }
            Series::Spring(compliance) => {
                let fraction = 1.0 / (1.0 + compliance * stiffness);
                let rate = rate();
                let own = sum([(damping, &rate), (1.0, &remembered)]);
                displacement = sum([(fraction, &moved), (-fraction * compliance, &own)]);
                force = sum([(stiffness, &displacement), (1.0, &own)]);
                velocity = rate;
            }
            Series::Yielding(compliance, duration) => {
                let mut before = vec![0.0; width];
                before[place + states] = 1.0;
                if duration > 0.0 {
                    let rate = damping / duration;
                    let fraction = 1.0 / (1.0 + compliance * (stiffness + rate));
                    let (held, drawn) = (fraction * compliance * rate, -fraction * compliance);
                    displacement = sum([(fraction, &moved), (held, &before), (drawn, &remembered)]);
                    velocity = sum([(1.0 / duration, &displacement), (-1.0 / duration, &before)]);
                } else {
                    (displacement, velocity) = (before, vec![0.0; width]);
                }
                force = sum([(1.0 / compliance, &moved), (-1.0 / compliance, &displacement)]);
            }
        }
        for (i, arm) in attachment.arm.iter().enumerate().filter(|(_, arm)| **arm != 0.0) {
            self.force.row_mut(i).iter_mut().zip(&force).for_each(|(into, f)| *into += arm * f);
        }
        let laws = step.state.next_by_displacement.iter().zip(&step.state.next_by_velocity);
        for (i, (by_displacement, by_velocity)) in laws.enumerate() {
            let mut row = sum([(*by_displacement, &displacement), (*by_velocity, &velocity)]);
            let states = step.state.next_by_state[i * states..(i + 1) * states].iter();
            row[place..].iter_mut().zip(states).for_each(|(into, by)| *into += by);
            self.memory
                .row_mut(attachment.memory + i)
                .iter_mut()
                .zip(row)
                .for_each(|(into, value)| *into = value);
        }
        if let Series::Yielding(..) = attachment.series {
            let row = self.memory.row_mut(attachment.memory + states);
            row.into_iter().zip(displacement).for_each(|(into, value)| *into = value);
        }
    }
}

fn sum<const N: usize>(terms: [(f64, &Vec<f64>); N]) -> Vec<f64> {
    let mut out = vec![0.0; terms[0].1.len()];
    for (factor, row) in terms.into_iter().filter(|(factor, _)| *factor != 0.0) {
        out.iter_mut().zip(row).for_each(|(out, value)| *out += factor * value);
    }
    out
}
