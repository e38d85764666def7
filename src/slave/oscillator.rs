//! Masses and springs with a frictional contact, or without.

use super::Behaviour;
use super::description::{DependencyKind, Description, Experiment, Variable};
use crate::integrate::{Drive, MOST_STEPPED, SampledIntegrator};
use crate::model::{Contact, Model, Oscillator};
use crate::vocabulary::{self as v, Quantity};

use std::borrow::Cow;

/// Tolerance that the integrator's longest step meets; the error falls with the square of the step.
const TOLERANCE_OF_LONGEST: f64 = 3e-4;
/// The longest step is divided by this at most.
const FINEST: f64 = 1000.0;
/// Most steps within a communication step.
const MOST_STEPS: f64 = 1e7;
/// Contacts and numbers of their memory that effects may add to a structure: a cubic spring and drag. Room is kept for
/// them, so that a parameter may go through zero.
const ADDED: (usize, usize) = (2, 2);

/// Outputs of the contact: force, dissipated energy, slip state.
const OF_CONTACT: usize = 3;

/// Inputs and outputs of an oscillator, followed by `parameters`.
pub(super) fn describe(
    model: &Model,
    oscillator: &Oscillator,
    contact: Option<&Contact>,
    parameters: Vec<Variable>,
) -> Description {
    let masses = &oscillator.masses;
    let inputs = masses.len() + usize::from(contact.is_some());
    let outputs = 3 * masses.len() + if contact.is_some() { OF_CONTACT } else { 0 };
    let first_parameter = inputs + outputs;
    // All inputs run to their values within the step, and whatever they move moves everything.
    let on = || (0..inputs).map(|index| (index, DependencyKind::Dependent));
    let at = |quantity: &Quantity, name: &str| -> Cow<'static, str> {
        Cow::Owned(format!("{}:{name}", quantity.name))
    };
    let mut variables: Vec<Variable> = masses
        .iter()
        .map(|mass| Variable {
            name: at(&v::EXCITATION, &mass.name),
            description: Cow::Owned(format!("Force of the exciter on mass {}", mass.name)),
            ..Variable::input(&v::EXCITATION, 0.0)
        })
        .collect();
    if let Some(contact) = contact {
        let load = masses.len();
        variables.extend([
            Variable::input(&v::NORMAL_LOAD, contact.normal_load),
            Variable::output(&v::FORCE).depends(on(), []),
            Variable::output(&v::DISSIPATED_ENERGY).depends(on(), []),
            Variable::output(&v::SLIP_STATE).integer().depends(on(), [load]),
        ]);
    }
    for mass in masses {
        let motions = [
            (&v::DISPLACEMENT, "Displacement"),
            (&v::VELOCITY, "Velocity"),
            (&v::ACCELERATION, "Acceleration"),
        ];
        for (order, (quantity, noun)) in motions.into_iter().enumerate() {
            // At rest the excitation accelerates, and nothing has moved yet.
            let accelerated = (0..masses.len()).chain(first_parameter..first_parameter + parameters.len());
            let initially = accelerated.filter(|_| order == 2);
            let row = Variable {
                name: at(quantity, &mass.name),
                description: Cow::Owned(format!("{noun} of mass {}", mass.name)),
                ..Variable::output(quantity)
            };
            variables.push(row.depends(on(), initially));
        }
    }
    variables.extend(parameters);
    let (name, summary) = match contact {
        Some(_) => ("FrictionOscillator", "Masses and springs with a friction contact"),
        None => ("Oscillator", "Masses and springs"),
    };
    let experiment = Experiment { start: 0.0, stop: 1.0, tolerance: 1e-6, step: 1e-3 };
    Description { name, summary, experiment, variables, model: model.to_toml() }
}

/// The physics of an oscillator.
pub(super) fn behaviour(model: &Model, oscillator: &Oscillator) -> Result<Box<dyn Behaviour>, String> {
    let masses = oscillator.masses.len();
    if masses > MOST_STEPPED {
        return Err(format!("{masses} masses are too many for an FMU; {MOST_STEPPED} is the limit"));
    }
    let assembled = model.assembled().map_err(|error| error.to_string())?;
    let (structure, normal_load) = (assembled.structure.clone(), assembled.normal_load);
    let own = usize::from(assembled.law.is_some());
    let joint = model.changes().joint;
    let mut stiffness = vec![0.0; structure.contacts.len()];
    let laws: Vec<_> = assembled.into_loaded().into_iter().map(|(law, _)| law).collect();
    let memory: usize = laws.iter().take(own).map(|law| law.state_len()).sum();
    if let Some(contact) = &model.contact {
        stiffness[0] = contact.tangential_stiffness + joint.residual_stiffness.max(0.0);
    }
    let longest =
        SampledIntegrator::longest_step(&structure, &stiffness).map_err(|error| error.to_string())?;
    let drives: Vec<_> = (0..masses).map(|mass| vec![(mass, 1.0)]).collect();
    let integrator =
        SampledIntegrator::new(&structure, laws, &drives, longest).map_err(|error| error.to_string())?;
    let inputs = masses + own;
    Ok(Box::new(OscillatorBehaviour {
        longest,
        inputs,
        masses,
        has_contact: own == 1,
        state_len: 2 * structure.size + 2 * (own + ADDED.0) + memory + ADDED.1 + inputs,
        load: (normal_load, joint.load_gain.unwrap_or(1.0)),
        drives: vec![Drive::default(); masses],
        loads: vec![0.0; structure.contacts.len()],
        accelerations: vec![0.0; structure.size],
        trial: Vec::new(),
        row: Vec::new(),
        integrator,
    }))
}

/// Integrator and work space. The state is that of the integrator, room for what effects may add to it, and the
/// inputs at the last communication point.
#[derive(Debug)]
struct OscillatorBehaviour {
    integrator: SampledIntegrator,
    longest: f64,
    inputs: usize,
    masses: usize,
    has_contact: bool,
    state_len: usize,
    /// Constant normal load (N), and the share of the input's difference from it that reaches the contact.
    load: (f64, f64),
    drives: Vec<Drive>,
    loads: Vec<f64>,
    accelerations: Vec<f64>,
    trial: Vec<f64>,
    row: Vec<f64>,
}

/// Without the last digits, in which the lengths of equal communication steps differ from each other: the operators of
/// a step need not be computed again for those.
fn rounded(step: f64) -> f64 {
    const DIGITS: u64 = 0xfff;
    f64::from_bits((step.to_bits() + DIGITS / 2) & !DIGITS)
}

impl OscillatorBehaviour {
    fn set_load(&mut self, input: f64) {
        let (constant, gain) = self.load;
        if let Some(load) = self.loads.first_mut().filter(|_| self.has_contact) {
            *load = constant + gain * (input - constant);
        }
    }

    /// Writes the outputs of the state in `self.trial` under the inputs in `values`.
    fn write_outputs(&mut self, values: &mut [f64], dissipated: f64) -> Result<(), String> {
        let state = &self.trial[..self.integrator.state_len()];
        self.integrator.acceleration(state, &values[..self.masses], &mut self.accelerations);
        self.row.clear();
        if self.has_contact {
            let slip_state = self.integrator.responses()[0].slip_state;
            let force = self.integrator.contact_forces(state)[0];
            self.row.extend([force, dissipated, f64::from(slip_state as i32)]);
        }
        for mass in 0..self.masses {
            let (x, v) = (self.integrator.displacement(state)[mass], self.integrator.velocity(state)[mass]);
            self.row.extend([x, v, self.accelerations[mass]]);
        }
        if !self.row.iter().all(|value| value.is_finite()) {
            return Err("an output is beyond all bounds".to_owned());
        }
        values[self.inputs..self.inputs + self.row.len()].copy_from_slice(&self.row);
        Ok(())
    }
}

impl Behaviour for OscillatorBehaviour {
    fn state_len(&self) -> usize {
        self.state_len
    }

    fn start(&mut self, state: &mut [f64], values: &mut [f64]) -> Result<(), String> {
        self.trial.clear();
        self.trial.resize(self.state_len, 0.0);
        self.set_load(values[self.inputs - 1]);
        let length = self.integrator.state_len();
        self.integrator.rest(&self.loads, &mut self.trial[..length]);
        self.integrator.settle(&mut self.trial[..length], &self.loads);
        self.trial[self.state_len - self.inputs..].copy_from_slice(&values[..self.inputs]);
        self.write_outputs(values, 0.0)?;
        state.copy_from_slice(&self.trial);
        Ok(())
    }

    fn step(
        &mut self,
        state: &mut [f64],
        values: &mut [f64],
        step: f64,
        tolerance: f64,
    ) -> Result<(), String> {
        self.trial.clear();
        self.trial.extend_from_slice(state);
        let finer = (TOLERANCE_OF_LONGEST / tolerance).sqrt().clamp(1.0, FINEST);
        let count = (step * finer / self.longest).ceil().max(1.0);
        if count > MOST_STEPS {
            return Err(format!("a communication step of {step} s is too long for a motion this fast"));
        }
        self.integrator.set_step(rounded(step / count)).map_err(|error| error.to_string())?;
        let (length, first) = (self.integrator.state_len(), self.state_len - self.inputs);
        let mut dissipated = if self.has_contact { values[self.inputs + 1] } else { 0.0 };
        for k in 0..count as usize {
            let (from, to) = (k as f64 / count, (k + 1) as f64 / count);
            let at = |input: usize, share: f64| state[first + input] * (1.0 - share) + values[input] * share;
            for (input, drive) in self.drives.iter_mut().enumerate() {
                *drive = Drive::line(at(input, from), at(input, to));
            }
            let load = at(self.inputs - 1, to);
            self.set_load(load);
            if !self.integrator.step(&mut self.trial[..length], &self.drives, &self.loads) {
                return Err("the motion cannot be followed: it grows without bound".to_owned());
            }
            if self.has_contact {
                dissipated += self.integrator.responses()[0].dissipated_energy;
            }
        }
        self.trial[first..].copy_from_slice(&values[..self.inputs]);
        self.write_outputs(values, dissipated)?;
        state.copy_from_slice(&self.trial);
        Ok(())
    }
}
