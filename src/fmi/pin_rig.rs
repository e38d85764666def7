//! A beam whose pin slips and slaps on its support, driven by the force of its exciter.

use super::Behaviour;
use super::beam::sensor_positions;
use super::description::{DependencyKind, Description, Experiment, Variable};
use super::lines::{Derivatives, Lines, parts};
use super::slip::SlipFraction;
use crate::model::{Model, PinnedBeam};
use crate::system::Element;
use crate::time::{ClassicalSteps, Energies, Ramp, SteppedMotion};
use crate::vocabulary as v;

// Rows of the table.
const INPUTS: usize = 1;
/// Outputs, from here: those of the contact, then displacement, velocity and acceleration of every sensor.
const DISSIPATED_ENERGY: usize = 4;
const IMPACT_ENERGY: usize = 5;
const OF_CONTACT: usize = 12;

/// Tolerance that the longest step meets; the error falls with the square of the step.
const TOLERANCE_OF_LONGEST: f64 = 1e-6;
/// The longest step is divided by this at most.
const FINEST: f64 = 100.0;
/// Most steps within a communication step: more take seconds, in which nothing can be told to the master.
const MOST_STEPS: f64 = 2e5;
/// Change of the force over the load at rest, and part of the longest step, with which outputs are differenced.
const DIFFERENCE: f64 = 1e-4;
const AHEAD: f64 = 1e-3;

/// Inputs and outputs of a rig, followed by `parameters`.
pub(super) fn describe(model: &Model, rig: &PinnedBeam, parameters: Vec<Variable>) -> Description {
    let sensors = sensor_positions(&rig.beam);
    let first_parameter = INPUTS + OF_CONTACT + 3 * sensors.len();
    let of_parameters = || first_parameter..first_parameter + parameters.len();
    // The force runs to its value within the step, and whatever it moves moves everything.
    let on = || [(0, DependencyKind::Dependent)];
    let moved = |quantity| Variable::output(quantity).depends(on(), []);
    // At rest the normal force is that of the load.
    let loaded = |quantity| Variable::output(quantity).depends(on(), of_parameters());
    let mut variables = vec![
        Variable::input(&v::EXCITATION, 0.0),
        moved(&v::FORCE),
        loaded(&v::OPENING_FORCE),
        loaded(&v::NORMAL_FORCE),
        loaded(&v::SEPARATION),
        moved(&v::DISSIPATED_ENERGY),
        moved(&v::IMPACT_ENERGY),
        loaded(&v::SLIP_STATE).integer(),
        loaded(&v::SLIP_FRACTION).discrete(),
        moved(&v::DISPLACEMENT),
        moved(&v::VELOCITY),
        moved(&v::OPENING),
        moved(&v::OPENING_VELOCITY),
    ];
    for position in sensors {
        variables.extend([
            Variable::sensor(&v::DISPLACEMENT, "displacement", position).depends(on(), []),
            Variable::sensor(&v::VELOCITY, "velocity", position).depends(on(), []),
            Variable::sensor(&v::ACCELERATION, "acceleration", position)
                .depends(on(), [0].into_iter().chain(of_parameters())),
        ]);
    }
    variables.extend(parameters);
    Description {
        name: "SlipSlapBeam",
        summary: "Beam whose pin slips and slaps on its support under a mass on a string",
        experiment: Experiment { start: 0.0, stop: 0.2, tolerance: 1e-6, step: 1e-4 },
        variables,
        model: model.to_toml(),
    }
}

/// The scheme and work space.
///
/// The state is the motion now and before the last step, and the energies (J) dissipated in that step by friction and
/// impacts, and its lines.
#[derive(Debug)]
pub(super) struct PinRigBehaviour {
    steps: ClassicalSteps,
    slip: SlipFraction,
    /// Load at rest (N).
    load: f64,
    /// Ports of the contact, and how many sensors come first.
    ports: [usize; 2],
    sensors: usize,
    motion: SteppedMotion,
    lines: Lines,
    motions: Vec<(f64, f64)>,
    accelerations: Vec<f64>,
    /// The outputs as they stand in the table.
    row: Vec<f64>,
}

/// Energies that a state has.
const KEPT: usize = 2;

impl PinRigBehaviour {
    pub(super) fn new(model: &Model, rig: &PinnedBeam) -> Result<Self, String> {
        let mut model = model.clone();
        // Effects may add masses, but no sensors.
        let beam = crate::system::Beam { sensors: sensor_positions(&rig.beam), ..rig.beam.clone() };
        model.structure = crate::model::Structure::PinRig(PinnedBeam { beam, ..rig.clone() });
        let system = model.system().map_err(|error| error.to_string())?;
        let found = system.elements.iter().find_map(|element| match element {
            Element::SlipSlap { ports, contact } => Some((*ports, contact)),
            _ => None,
        });
        let (ports, contact) = found.ok_or("the pin rests on nothing: the model has no contact")?;
        let load = contact.normal().preload();
        let slip = SlipFraction::new(&**contact.law(), load);
        let mut steps = ClassicalSteps::new(&system).map_err(|error| error.to_string())?;
        Ok(Self {
            motion: steps.rest(),
            steps,
            slip,
            load,
            ports,
            sensors: system.sensors.len(),
            lines: Lines::new(INPUTS, true),
            motions: Vec::new(),
            accelerations: Vec::new(),
            row: Vec::new(),
        })
    }

    /// How many steps make one of the lines' length.
    fn count(&self, tolerance: f64) -> Result<usize, String> {
        let finer = (TOLERANCE_OF_LONGEST / tolerance).sqrt().clamp(1.0, FINEST);
        let step = self.lines.step;
        let count = (step * finer / self.steps.longest_step()).ceil().max(1.0);
        if count > MOST_STEPS {
            return Err(format!("a communication step of {step:?} s is too long for a motion this fast"));
        }
        Ok(count as usize)
    }

    /// Takes the motion in `count` steps along `force` over the length of the lines.
    fn go(&mut self, force: &Ramp, count: usize) {
        let step = self.lines.step / count as f64;
        for k in 0..count {
            let at = |part: f64| force.at((k as f64 + part) / count as f64);
            self.steps.advance(&mut self.motion, step, [at(0.0), at(0.5), at(1.0)]);
        }
    }

    /// Outputs of the motion under `force` (N); its energies are those since it was read.
    fn observe(&mut self, force: f64) -> Result<(), String> {
        self.steps.motions_of_ports(&self.motion, &mut self.motions);
        self.steps.accelerations_of_ports(&self.motion, force, &mut self.accelerations);
        let contact = self.motion.contacts.first().ok_or("the motion has no contact")?;
        let Energies { friction, impact, .. } = self.motion.energies;
        let [tangential, normal] = self.ports.map(|port| self.motions[port]);
        self.row.clear();
        self.row.extend([
            contact.force[0],
            contact.force[1],
            contact.normal_force,
            contact.separation,
            friction,
            impact,
            f64::from(contact.slip_state as i32),
            self.slip.of(contact.tangent, contact.slip_state),
            tangential.0,
            tangential.1,
            normal.0,
            normal.1,
        ]);
        let sensors = self.motions.iter().zip(&self.accelerations).take(self.sensors);
        self.row.extend(
            sensors.flat_map(|((displacement, velocity), acceleration)| {
                [*displacement, *velocity, *acceleration]
            }),
        );
        if self.row.iter().all(|value| value.is_finite()) {
            Ok(())
        } else {
            Err("an output is not a finite number".to_owned())
        }
    }

    /// Outputs at the end of the lines, from the motion in `state` along `force`.
    fn repeat(&mut self, state: &[f64], force: &Ramp, count: usize) -> Result<(), String> {
        if self.lines.step > 0.0 {
            self.motion.read_state(&state[self.motion.state_len()..]);
            self.go(force, count);
        } else {
            self.motion = self.steps.rest();
        }
        self.observe(force.end)
    }
}

impl Behaviour for PinRigBehaviour {
    fn state_len(&self) -> usize {
        2 * self.motion.state_len() + KEPT + self.lines.state_len()
    }

    fn start(&mut self, state: &mut [f64], values: &mut [f64]) -> Result<(), String> {
        self.lines.hold(&values[..INPUTS]);
        self.motion = self.steps.rest();
        self.observe(values[0])?;
        values[INPUTS..][..self.row.len()].copy_from_slice(&self.row);
        let (now, before, last) = parts(state, self.motion.state_len());
        self.motion.write_state(now);
        before.copy_from_slice(now);
        last[..KEPT].fill(0.0);
        self.lines.write(&mut last[KEPT..]);
        Ok(())
    }

    fn step(
        &mut self,
        state: &mut [f64],
        values: &mut [f64],
        slopes: &[Option<Derivatives>],
        step: f64,
        tolerance: f64,
    ) -> Result<(), String> {
        let (now, before, last) = parts(state, self.motion.state_len());
        self.motion.read_state(now);
        self.lines.go_on(&last[KEPT..], &values[..INPUTS], slopes, step);
        let (force, count) = (self.lines.all[0], self.count(tolerance)?);
        self.go(&force, count);
        self.observe(force.end)?;
        let lost = [self.row[DISSIPATED_ENERGY], self.row[IMPACT_ENERGY]];
        for (row, lost) in [DISSIPATED_ENERGY, IMPACT_ENERGY].into_iter().zip(lost) {
            self.row[row] = values[INPUTS + row] + lost;
        }
        values[0] = force.end;
        values[INPUTS..][..self.row.len()].copy_from_slice(&self.row);
        before.copy_from_slice(now);
        self.motion.write_state(now);
        last[..KEPT].copy_from_slice(&lost);
        self.lines.write(&mut last[KEPT..]);
        Ok(())
    }

    fn output_rates(&mut self, state: &[f64], rates: &mut [f64]) -> Result<(), String> {
        let (motion, last) = state.split_at(2 * self.motion.state_len());
        self.lines.read(&last[KEPT..]);
        rates.fill(0.0);
        let step = self.lines.step;
        let beyond = self.lines.beyond(0);
        let slope = if step > 0.0 { (beyond.end - beyond.start) / step } else { 0.0 };
        // From where the contact stands still, or it would be taken to have come from elsewhere.
        self.motion.read_state(motion);
        let ahead = AHEAD * self.steps.longest_step();
        let force = [0.0, 0.5, 1.0].map(|part| beyond.start + slope * part * ahead);
        let mut from = self.motion.clone();
        self.steps.advance(&mut from, 0.0, [beyond.start; 3]);
        std::mem::swap(&mut self.motion, &mut from);
        self.observe(beyond.start)?;
        rates.iter_mut().zip(&self.row).for_each(|(rate, value)| *rate = -value);
        self.steps.advance(&mut self.motion, ahead, force);
        self.observe(force[2])?;
        rates.iter_mut().zip(&self.row).for_each(|(rate, value)| *rate = (*rate + value) / ahead);
        let lasting = if step > 0.0 { step } else { f64::INFINITY };
        rates[DISSIPATED_ENERGY] = last[0] / lasting;
        rates[IMPACT_ENERGY] = last[1] / lasting;
        rates[IMPACT_ENERGY + 1..][..2].fill(0.0);
        Ok(())
    }

    fn sensitivity(
        &mut self,
        state: &[f64],
        _unknowns: &[u32],
        direction: &[Ramp],
        tolerance: f64,
        change: &mut [f64],
    ) -> Result<(), String> {
        self.lines.read(&state[2 * self.motion.state_len() + KEPT..]);
        change.fill(0.0);
        let by = self.lines.change(0, &direction[0]);
        let size = [by.start, by.end, by.bow, by.skew].iter().fold(0.0, |most: f64, x| most.max(x.abs()));
        if size == 0.0 {
            return Ok(());
        }
        let (line, count) = (self.lines.all[0], self.count(tolerance)?);
        let load = if self.load > 0.0 { self.load } else { 1.0 };
        let span = DIFFERENCE * load / size;
        for part in [span, -span] {
            let moved = Ramp {
                start: line.start + part * by.start,
                end: line.end + part * by.end,
                bow: line.bow + part * by.bow,
                skew: line.skew + part * by.skew,
            };
            self.repeat(state, &moved, count)?;
            change.iter_mut().zip(&self.row).for_each(|(sum, value)| *sum += value / (2.0 * part));
        }
        change[IMPACT_ENERGY + 1..][..2].fill(0.0);
        Ok(())
    }
}
