//! What a master that looks ahead asks of an instance: derivatives of inputs and outputs with respect to time, and of
//! outputs with respect to inputs.

use super::description::{Causality, VariableType};
use super::error::Error;
use super::instance::Instance;
use super::stage::Stage;
use super::values::{LARGEST_INPUT, check_value, same_length};
use crate::time::Ramp;

/// Highest order of the derivatives of outputs with respect to time.
pub const DERIVATIVE_ORDER: u32 = 1;
/// Highest order of the derivatives of inputs with respect to time.
pub const INPUT_DERIVATIVE_ORDER: u32 = 3;

fn within_bounds(value: f64) -> bool {
    value.is_finite() && value.abs() <= LARGEST_INPUT
}

impl Instance {
    /// Sets derivatives with respect to time (per second, per second² ...) of inputs for the next step, which then begins
    /// at the values set and runs along `value + d₁ t + d₂ t²/2 + d₃ t³/6`, t from the step's beginning; what is not given
    /// is zero. See the [module](crate::fmi) for what inputs do without. Sets all or none; `orders` must be from 1 to 3.
    ///
    /// A derivative may be set before or after the value, and holds for one step.
    ///
    /// ```
    /// # use stickslip::fmi::Instance;
    /// # let model = "schema = \"stickslip.model/1\"\nkind = \"contact\"\n[contact]\nlaw = \"jenkins\"\n\
    /// #     tangential_stiffness = 2e6\nfriction_coefficient = 0.5\nnormal_load = 100.0\n";
    /// let mut contact = Instance::new(model)?;
    /// contact.enter_initialization()?;
    /// contact.exit_initialization()?;
    /// let displacement = contact.description().reference("displacement").unwrap();
    /// let force = contact.description().reference("force").unwrap();
    /// contact.set_input_derivatives(&[displacement], &[1], &[0.01])?;
    /// contact.do_step(0.0, 1e-3)?;
    /// let (mut value, mut rate, mut slope) = ([0.0], [0.0], [0.0]);
    /// contact.get_real(&[force], &mut value)?;
    /// contact.output_derivatives(&[force], &[1], &mut rate)?;
    /// contact.directional_derivative(&[force], &[displacement], &[1.0], &mut slope)?;
    /// // Stuck: 10 µm at 2 N/µm.
    /// assert!((value[0] - 20.0).abs() < 1e-9);
    /// assert!((rate[0] - 2e4).abs() < 1e-6);
    /// assert!((slope[0] - 2e6).abs() < 1e-6);
    /// # Ok::<(), stickslip::fmi::Error>(())
    /// ```
    ///
    /// # Errors
    /// An unknown, Integer or not settable variable, one that is no input, another order, a derivative that is not
    /// finite.
    pub fn set_input_derivatives(
        &mut self,
        references: &[u32],
        orders: &[i32],
        derivatives: &[f64],
    ) -> Result<(), Error> {
        same_length(references.len(), derivatives.len())?;
        self.check_orders(references, orders, INPUT_DERIVATIVE_ORDER)?;
        for (reference, derivative) in references.iter().zip(derivatives) {
            let variable = &self.shared.description.variables[*reference as usize];
            let name = || variable.name.to_string();
            if variable.causality == Causality::Parameter {
                return Err(Error::NoDerivative { name: name(), reason: "it is a parameter" });
            }
            self.check_settable(variable)?;
            if !within_bounds(*derivative) {
                return Err(Error::DerivativeValue { name: name(), value: *derivative, most: LARGEST_INPUT });
            }
        }
        for ((reference, order), derivative) in references.iter().zip(orders).zip(derivatives) {
            self.asked.slopes.resize(self.shared.inputs, None);
            self.asked.slopes[*reference as usize].get_or_insert_default()[*order as usize - 1] = *derivative;
        }
        Ok(())
    }

    /// Reads the first derivatives with respect to time (per second) of outputs at the end of the last step; `orders`
    /// must all be 1. Where an output has a kink there, the derivative is the one before it. Before the first step
    /// the inputs count as held.
    ///
    /// # Errors
    /// Before the end of the initialization; an unknown or Integer variable, one that is no output, an order other
    /// than 1.
    pub fn output_derivatives(
        &mut self,
        references: &[u32],
        orders: &[i32],
        derivatives: &mut [f64],
    ) -> Result<(), Error> {
        if matches!(self.stage, Stage::Instantiated | Stage::Initialization) {
            return Err(Error::Stage(self.stage));
        }
        same_length(references.len(), derivatives.len())?;
        self.check_orders(references, orders, DERIVATIVE_ORDER)?;
        self.check_outputs(references)?;
        self.rates.resize(self.shared.outputs, 0.0);
        let rates = self.behaviour.output_rates(&self.state, &mut self.rates);
        rates.map_err(Error::Derivative)?;
        self.read_outputs(references, derivatives)
    }

    /// Change of the outputs `unknowns` at the end of the last step when the inputs `knowns` of that step change by
    /// `direction`, to first order: `change = (∂unknowns/∂knowns) direction`. In the initialization, and before the
    /// first step, the change of the initial outputs. See the [module](crate::fmi).
    ///
    /// # Errors
    /// Before the initialization; an unknown or Integer variable, one of the `unknowns` that is no output or of the
    /// `knowns` that is no input, a direction that is not finite; during the initialization also parameters that make
    /// no model.
    pub fn directional_derivative(
        &mut self,
        unknowns: &[u32],
        knowns: &[u32],
        direction: &[f64],
        change: &mut [f64],
    ) -> Result<(), Error> {
        self.sensitivity(unknowns, knowns, direction.iter().copied().map(Ramp::held), change)
    }

    /// As [`Instance::directional_derivative`], with the inputs' lines over the last step in place of their values:
    /// an input that ran from a to b then runs from `a + start` to `b + end`. What a master needs that seeks inputs
    /// running linearly to unknown ends: their ends alone change. The start has no effect on an input of a contact or
    /// an oscillator that was set without a derivative, for which the start was fixed before.
    ///
    /// # Errors
    /// As [`Instance::directional_derivative`].
    pub fn line_derivative(
        &mut self,
        unknowns: &[u32],
        knowns: &[u32],
        direction: &[Ramp],
        change: &mut [f64],
    ) -> Result<(), Error> {
        self.sensitivity(unknowns, knowns, direction.iter().copied(), change)
    }

    fn sensitivity(
        &mut self,
        unknowns: &[u32],
        knowns: &[u32],
        direction: impl ExactSizeIterator<Item = Ramp>,
        change: &mut [f64],
    ) -> Result<(), Error> {
        if self.stage == Stage::Instantiated {
            return Err(Error::Stage(self.stage));
        }
        same_length(unknowns.len(), change.len())?;
        same_length(knowns.len(), direction.len())?;
        self.check_rows(unknowns, VariableType::Real)?;
        self.check_rows(knowns, VariableType::Real)?;
        self.check_outputs(unknowns)?;
        self.direction.clear();
        self.direction.resize(self.shared.inputs, Ramp::held(0.0));
        for (reference, line) in knowns.iter().zip(direction) {
            let variable = &self.shared.description.variables[*reference as usize];
            let name = || variable.name.to_string();
            let Some(sum) = self.direction.get_mut(*reference as usize) else {
                let reason = "outputs are differentiated by inputs, and it is none";
                return Err(Error::NoDerivative { name: name(), reason });
            };
            *sum = Ramp::line(sum.start + line.start, sum.end + line.end);
            for value in [line.start, line.end] {
                if !within_bounds(value) {
                    return Err(Error::DerivativeValue { name: name(), value, most: LARGEST_INPUT });
                }
            }
        }
        self.refresh()?;
        self.rates.resize(self.shared.outputs, 0.0);
        let (state, direction) = (&self.state, &self.direction);
        let tolerance = self.asked.tolerance;
        let changes = self.behaviour.sensitivity(state, unknowns, direction, tolerance, &mut self.rates);
        changes.map_err(Error::Derivative)?;
        self.read_outputs(unknowns, change)
    }

    /// Copies what `self.rates` has for outputs.
    fn read_outputs(&self, references: &[u32], out: &mut [f64]) -> Result<(), Error> {
        let first = self.shared.inputs;
        let found = references.iter().map(|reference| self.rates[*reference as usize - first]);
        if !found.clone().all(f64::is_finite) {
            return Err(Error::Derivative("it is not a finite number".to_owned()));
        }
        out.iter_mut().zip(found).for_each(|(out, value)| *out = value);
        Ok(())
    }

    fn check_outputs(&self, references: &[u32]) -> Result<(), Error> {
        for reference in references {
            let variable = &self.shared.description.variables[*reference as usize];
            if variable.causality != Causality::Output {
                let reason = "it is no output";
                return Err(Error::NoDerivative { name: variable.name.to_string(), reason });
            }
        }
        Ok(())
    }

    fn check_orders(&self, references: &[u32], orders: &[i32], highest: u32) -> Result<(), Error> {
        same_length(references.len(), orders.len())?;
        self.check_rows(references, VariableType::Real)?;
        for (reference, order) in references.iter().zip(orders) {
            if !(1..=highest.cast_signed()).contains(order) {
                let name = self.shared.description.variables[*reference as usize].name.to_string();
                return Err(Error::DerivativeOrder { name, order: *order, highest });
            }
        }
        Ok(())
    }

    /// Whether the inputs stay within their bounds up to the end of a step of `step` (s).
    #[inline(never)]
    pub(super) fn check_reached(&self, step: f64) -> Result<(), Error> {
        for (row, slope) in self.asked.slopes.iter().enumerate() {
            if let Some(slopes) = slope {
                let reached = Ramp::with_derivatives(self.values[row], *slopes, step).end;
                check_value(&self.shared.description.variables[row], reached)?;
            }
        }
        Ok(())
    }
}
