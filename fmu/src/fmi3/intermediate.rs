//! What the importer tells within a step: inputs at times between its communication points.
//!
//! Before a step from t to t + h is computed, the importer is asked for the inputs that it has listed at t + h/3, t + 2h/3
//! and t + h. With the value at t, which it has set, they make the cubic that the input follows over the step; where it
//! tells less, a parabola or a straight line. After the step it may read at t + h. An input that it does not tell does as
//! in steps without such updates.
//!
//! While the importer's function runs, it calls functions of this library: nothing here may hold a reference to the
//! component meanwhile.

use crate::ffi::IntermediateUpdate;
use crate::guard::Failure;
use std::ffi::c_void;
use stickslip::fmi::{Causality, Instance, Template, Variability};

/// At how many times in a step the importer is asked.
pub const ASKED: usize = 3;

/// What the importer is about to tell, or to read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Moment {
    /// Inputs at this part of the step.
    Asks(usize),
    /// Outputs at its end.
    Finished,
}

/// The importer's function, and what it has told.
pub struct Intermediate {
    callback: IntermediateUpdate,
    environment: *mut c_void,
    /// Value references that it may use.
    required: Box<[u32]>,
    /// Of each input, what was told in the step under way.
    told: Vec<[Option<f64>; ASKED]>,
    now: Option<Moment>,
}

/// A call of the importer's function.
#[derive(Clone, Copy)]
pub struct Update {
    callback: IntermediateUpdate,
    environment: *mut c_void,
    pub moment: Moment,
}

impl Intermediate {
    /// For the variables `required`; `None` where the importer has no function, or wants nothing.
    ///
    /// # Errors
    /// A variable that is neither an input nor an output.
    pub fn new(
        template: &Template,
        required: &[u32],
        callback: Option<IntermediateUpdate>,
        environment: *mut c_void,
    ) -> Result<Option<Box<Self>>, String> {
        let description = template.description();
        let further = description.further();
        for reference in required {
            let known = match description.variables.get(*reference as usize) {
                Some(row) => {
                    row.variability() == Variability::Continuous
                        && matches!(row.causality, Causality::Input | Causality::Output)
                }
                None => {
                    (*reference as usize - description.variables.len() < further.len())
                        && !further[*reference as usize - description.variables.len()].rows().is_empty()
                }
            };
            if !known {
                return Err(format!(
                    "the variable with value reference {reference} has no intermediateUpdate"
                ));
            }
        }
        let inputs = description.references(Causality::Input).map(|row| row + 1).max().unwrap_or(0);
        Ok(callback.filter(|_| !required.is_empty()).map(|callback| {
            let told = vec![[None; ASKED]; inputs as usize];
            Box::new(Self { callback, environment, required: required.into(), told, now: None })
        }))
    }

    /// Whether the importer's function is running.
    pub fn is_under_way(&self) -> bool {
        self.now.is_some()
    }

    /// Whether it is asked for inputs at all.
    pub fn asks(&self) -> bool {
        self.required.iter().any(|reference| (*reference as usize) < self.told.len())
    }

    /// What is to be called at `moment`.
    pub fn begin(&mut self, moment: Moment) -> Update {
        if moment == Moment::Asks(0) {
            self.told.fill([None; ASKED]);
        }
        self.now = Some(moment);
        Update { callback: self.callback, environment: self.environment, moment }
    }

    /// The importer's function has returned.
    pub fn end(&mut self) {
        self.now = None;
    }

    fn check_required(&self, references: &[u32]) -> Result<(), Failure> {
        match references.iter().find(|reference| !self.required.contains(reference)) {
            None => Ok(()),
            Some(other) => Err(Failure::error(format!(
                "value reference {other} is not among the requiredIntermediateVariables"
            ))),
        }
    }

    /// Whether outputs may be read now.
    ///
    /// # Errors
    /// Not while inputs are asked for, and of the required variables only.
    pub fn check_get(&self, references: &[u32]) -> Result<(), Failure> {
        if self.now != Some(Moment::Finished) {
            return Err(Failure::error("nothing can be read here: intermediateVariableGetAllowed is false"));
        }
        self.check_required(references)
    }

    /// Takes over inputs.
    ///
    /// # Errors
    /// Where none are asked for, and of the required inputs only.
    pub fn tell(&mut self, references: &[u32], values: &[f64]) -> Result<(), Failure> {
        let Some(Moment::Asks(part)) = self.now else {
            return Err(Failure::error("no input is asked for: intermediateVariableSetRequested is false"));
        };
        self.check_required(references)?;
        for (reference, value) in references.iter().zip(values) {
            self.told[*reference as usize][part] = Some(*value);
        }
        Ok(())
    }

    /// Sets the derivatives of the inputs that were told for a step of `step` (s).
    ///
    /// # Errors
    /// Values that are refused.
    pub fn set_derivatives(&self, instance: &mut Instance, step: f64) -> Result<(), stickslip::fmi::Error> {
        for (reference, told) in self.told.iter().enumerate() {
            if told.iter().all(Option::is_none) {
                continue;
            }
            let mut start = [0.0];
            instance.get_real(&[reference as u32], &mut start)?;
            let [first, second, third] = derivatives(start[0], told);
            let values = [first / step, second / step.powi(2), third / step.powi(3)];
            instance.set_input_derivatives(&[reference as u32; 3], &[1, 2, 3], &values)?;
        }
        Ok(())
    }
}

impl Update {
    /// Calls the importer's function for a step from `time` of `step` (s).
    ///
    /// # Safety
    /// The function is callable, and no reference to the component is alive.
    pub unsafe fn call(self, time: f64, step: f64) {
        let (at, asks) = match self.moment {
            Moment::Asks(part) => (time + step * (part + 1) as f64 / ASKED as f64, true),
            Moment::Finished => (time + step, false),
        };
        let (mut early_return_requested, mut early_return_time) = (0, at);
        // SAFETY: the caller's promise. It cannot return early, so that the last two are not looked at.
        unsafe {
            (self.callback)(
                self.environment,
                at,
                asks.into(),
                (!asks).into(),
                (!asks).into(),
                0,
                &mut early_return_requested,
                &mut early_return_time,
            );
        }
    }
}

/// Derivatives, with the step as the unit of time, at the start of the polynomial through `start` and what was told at
/// thirds of the step.
fn derivatives(start: f64, told: &[Option<f64>; ASKED]) -> [f64; 3] {
    let place = |part: usize| (part + 1) as f64 / ASKED as f64;
    let told = told.iter().enumerate().filter_map(|(part, value)| value.map(|value| (place(part), value)));
    let mut nodes = [(0.0, start); ASKED + 1];
    let mut count = 1;
    for node in told {
        nodes[count] = node;
        count += 1;
    }
    // Newton's divided differences, then by powers of the time.
    let mut differences = nodes.map(|(_, value)| value);
    for order in 1..count {
        for k in (order..count).rev() {
            differences[k] = (differences[k] - differences[k - 1]) / (nodes[k].0 - nodes[k - order].0);
        }
    }
    let mut powers = [0.0; ASKED + 1];
    for k in (0..count).rev() {
        // powers · (t − t_k) + difference
        for power in (1..powers.len()).rev() {
            powers[power] = powers[power - 1] - nodes[k].0 * powers[power];
        }
        powers[0] = differences[k] - nodes[k].0 * powers[0];
    }
    [powers[1], 2.0 * powers[2], 6.0 * powers[3]]
}

#[cfg(test)]
mod tests {
    use super::derivatives;

    #[test]
    fn a_cubic_a_parabola_and_a_line_are_found_from_what_was_told() {
        let near = |found: [f64; 3], expected: [f64; 3]| {
            for (found, expected) in found.into_iter().zip(expected) {
                assert!((found - expected).abs() < 1e-12, "{found} {expected}");
            }
        };
        let cubic = |t: f64| 2.0 - t + 3.0 * t * t - 0.5 * t * t * t;
        near(derivatives(2.0, &[1.0, 2.0, 3.0].map(|k| Some(cubic(k / 3.0)))), [-1.0, 6.0, -3.0]);
        let parabola = |t: f64| 1.0 + t - 2.0 * t * t;
        near(derivatives(1.0, &[None, Some(parabola(2.0 / 3.0)), Some(parabola(1.0))]), [1.0, -4.0, 0.0]);
        near(derivatives(5.0, &[None, None, Some(7.0)]), [2.0, 0.0, 0.0]);
        near(derivatives(5.0, &[Some(5.5), None, None]), [1.5, 0.0, 0.0]);
    }
}
