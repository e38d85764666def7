//! A beam whose pin slips and slaps on its support, driven by the force of its exciter; or without the contact, whose forces
//! then come from outside.

use super::beam::sensor_positions;
use super::count_steps;
use super::slip::SlipFraction;
use crate::fmi::continuous::{self, ContinuousForm, ContinuousTime, Instant};
use crate::fmi::description::{DependencyKind, Description, Experiment, Variable};
use crate::fmi::lines::{Lines, parts};
use crate::fmi::{Asked, Behaviour};
use crate::model::{Model, PinnedBeam};
use crate::system::Element;
use crate::time::{ClassicalSteps, Energies, Ramp, SteppedMotion};
use crate::vocabulary as v;

/// Inputs of a rig with a contact of its own: the force of its exciter; and of one without: those of the contact besides.
const INPUTS: [usize; 2] = [1, 3];
/// Outputs of a contact of its own come first, then the pin's motion, then that of every sensor.
const OF_CONTACT: usize = 8;
const OF_PIN: usize = 4;
const DISSIPATED_ENERGY: usize = 4;
const IMPACT_ENERGY: usize = 5;

/// Tolerance that the longest step meets; the error falls with the square of the step.
const TOLERANCE_OF_LONGEST: f64 = 1e-6;
/// The longest step is divided by this at most.
const FINEST: f64 = 100.0;
/// Change of the force over the load at rest, and part of the longest step, with which outputs are differenced.
const DIFFERENCE: f64 = 1e-4;
const AHEAD: f64 = 1e-3;

/// Inputs and outputs of a rig, followed by `parameters`.
pub(super) fn describe(model: &Model, rig: &PinnedBeam, parameters: Vec<Variable>) -> Description {
    let sensors = sensor_positions(&rig.beam);
    let own = model.contact.is_some();
    let inputs = INPUTS[usize::from(!own)];
    let of_contact = if own { OF_CONTACT } else { 0 };
    let first_parameter = inputs + of_contact + OF_PIN + 3 * sensors.len();
    let of_parameters = || first_parameter..first_parameter + parameters.len();
    // Forces run to their values within the step, and whatever they move moves everything.
    let on = || (0..inputs).map(|input| (input, DependencyKind::Dependent));
    let moved = |quantity| Variable::output(quantity).depends(on(), []);
    // At rest the normal force is that of the load.
    let loaded = |quantity| Variable::output(quantity).depends(on(), of_parameters());
    let mut variables = vec![Variable::input(&v::EXCITATION, 0.0)];
    if own {
        variables.extend([
            moved(&v::FORCE),
            loaded(&v::OPENING_FORCE),
            loaded(&v::NORMAL_FORCE),
            loaded(&v::SEPARATION),
            moved(&v::DISSIPATED_ENERGY),
            moved(&v::IMPACT_ENERGY),
            loaded(&v::SLIP_STATE).integer(),
            loaded(&v::SLIP_FRACTION).discrete(),
        ]);
    } else {
        let given = [&v::CONTACT_FORCE, &v::OPENING_FORCE];
        variables.extend(given.map(|force| Variable::input(force, 0.0)));
    }
    variables.extend([&v::DISPLACEMENT, &v::VELOCITY, &v::OPENING, &v::OPENING_VELOCITY].map(moved));
    for position in sensors {
        // What is given at the start pushes at once.
        let initially = if own { 0..1 } else { 0..inputs };
        variables.extend([
            Variable::sensor(&v::DISPLACEMENT, "displacement", position).depends(on(), []),
            Variable::sensor(&v::VELOCITY, "velocity", position).depends(on(), []),
            Variable::sensor(&v::ACCELERATION, "acceleration", position)
                .depends(on(), initially.chain(of_parameters())),
        ]);
    }
    variables.extend(parameters);
    let (name, summary) = if own {
        ("SlipSlapBeam", "Beam whose pin slips and slaps on its support under a mass on a string")
    } else {
        (
            "PinnedBeam",
            "Beam with a pin and a mass on a string, loaded by both forces of a contact from outside",
        )
    };
    // The pin follows a contact from outside as fast as the stiffness of its support makes it.
    let step = if own { 1e-4 } else { 1e-5 };
    Description {
        name,
        summary,
        experiment: Experiment { start: 0.0, stop: 0.2, tolerance: 1e-6, step },
        variables,
        continuous: ContinuousForm::default(),
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
    /// Of a contact of its own.
    slip: Option<SlipFraction>,
    /// Force (N) that is small against those in the contact, to difference with.
    small: f64,
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
        let port = |name: &str| system.port(name).ok_or_else(|| format!("the rig has no port `{name}`"));
        let ports = [port("contact")?, port("contact.normal")?];
        let slip = system.elements.iter().find_map(|element| match element {
            Element::SlipSlap { contact, .. } => {
                Some(SlipFraction::new(&**contact.law(), contact.normal().preload()))
            }
            _ => None,
        });
        let load = model.contact.map_or_else(|| rig.weight(), |contact| contact.normal_load);
        let inputs = INPUTS[usize::from(slip.is_none())];
        let mut steps = ClassicalSteps::new(&system).map_err(|error| error.to_string())?;
        Ok(Self {
            motion: steps.rest(),
            steps,
            slip,
            small: DIFFERENCE * if load > 0.0 { load } else { 1.0 },
            ports,
            sensors: system.sensors.len(),
            lines: Lines::new(inputs, true),
            motions: Vec::new(),
            accelerations: Vec::new(),
            row: Vec::new(),
        })
    }

    /// How many steps make one of the lines' length.
    fn count(&self, tolerance: f64) -> Result<usize, String> {
        let finer = (TOLERANCE_OF_LONGEST / tolerance).sqrt().clamp(1.0, FINEST);
        count_steps(self.lines.step, self.steps.longest_step() / finer)
    }

    fn inputs(&self) -> usize {
        self.lines.all.len()
    }

    /// Takes the motion in `count` steps along `lines`, over their length.
    fn go(&mut self, lines: &[Ramp], count: usize) {
        let step = self.lines.step / count as f64;
        for k in 0..count {
            let at = |line: &Ramp| [0.0, 0.5, 1.0].map(|part| line.at((k as f64 + part) / count as f64));
            let mut outside = [[0.0; 3]; 2];
            outside.iter_mut().zip(&lines[1..]).for_each(|(to, line)| *to = at(line));
            let given = &outside[..lines.len() - 1];
            self.steps.advance_under(&mut self.motion, step, at(&lines[0]), given);
        }
    }

    /// Outputs of the motion under `forces` (N); its energies are those since it was read.
    fn observe(&mut self, forces: &[f64]) -> Result<(), String> {
        self.steps.motions_of_ports(&self.motion, &mut self.motions);
        let (force, outside) = forces.split_first().ok_or("the rig has no input")?;
        self.steps.accelerations_of_ports(&self.motion, *force, outside, &mut self.accelerations);
        self.row.clear();
        if let Some(slip) = &self.slip {
            let contact = self.motion.contacts.first().ok_or("the motion has no contact")?;
            let Energies { friction, impact, .. } = self.motion.energies;
            self.row.extend([
                contact.force[0],
                contact.force[1],
                contact.normal_force,
                contact.separation,
                friction,
                impact,
                f64::from(contact.slip_state as i32),
                slip.of(contact.tangent, contact.slip_state),
            ]);
        }
        for port in self.ports {
            self.row.extend([self.motions[port].0, self.motions[port].1]);
        }
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

    /// Outputs at the end of `lines`, from the motion in `state`.
    fn repeat(&mut self, state: &[f64], lines: &[Ramp], count: usize) -> Result<(), String> {
        if self.lines.step > 0.0 {
            self.motion.read_state(&state[self.motion.state_len()..]);
            self.go(lines, count);
        } else {
            self.motion = self.steps.rest();
        }
        self.observe(&ends(lines))
    }

    /// The energies that have been lost, of a contact of its own.
    fn lost(&self) -> [f64; KEPT] {
        if self.slip.is_none() {
            return [0.0; KEPT];
        }
        [self.row[DISSIPATED_ENERGY], self.row[IMPACT_ENERGY]]
    }

    /// Sets the rates or changes that no output of a contact of its own has: its state, and the part that slips.
    fn clear_states(&self, values: &mut [f64]) {
        if self.slip.is_some() {
            values[IMPACT_ENERGY + 1..OF_CONTACT].fill(0.0);
        }
    }
}

impl ContinuousTime for PinRigBehaviour {
    fn modes(&self) -> usize {
        self.motion.displacement.len()
    }

    fn indicators(&self) -> usize {
        if self.slip.is_some() { continuous::OF_CONTACT } else { 0 }
    }

    fn read(&mut self, state: &[f64], continuous: &mut [f64]) -> Result<(), String> {
        // A motion's state begins with its modes.
        continuous.copy_from_slice(&state[..continuous.len()]);
        Ok(())
    }

    fn look(
        &mut self,
        state: &[f64],
        accepted: &[f64],
        values: &mut [f64],
        at: Instant<'_>,
    ) -> Result<(), String> {
        let inputs = self.inputs();
        self.motion.read_state(&state[..self.motion.state_len()]);
        self.steps.move_to(&mut self.motion, at.continuous);
        self.observe(&values[..inputs])?;
        at.accelerations.copy_from_slice(self.steps.modal_accelerations());
        if self.slip.is_some() {
            for row in [DISSIPATED_ENERGY, IMPACT_ENERGY] {
                self.row[row] += accepted[inputs + row];
            }
        }
        values[inputs..][..self.row.len()].copy_from_slice(&self.row);
        let Some(contact) = self.motion.contacts.first().filter(|_| self.slip.is_some()) else {
            return Ok(());
        };
        let modes = values.len()..values.len() + at.continuous.len();
        let slip_state = inputs + IMPACT_ENERGY + 1;
        continuous::keep_slip(accepted.get(modes) != Some(at.continuous), slip_state, values, accepted);
        let pressed = continuous::pressed(contact.normal_force, contact.separation);
        let velocity = self.motions[self.ports[0]].1;
        continuous::indicators(velocity, values[slip_state], pressed, at.indicators);
        Ok(())
    }

    fn accept(&mut self, state: &mut [f64], values: &[f64], continuous: &[f64]) -> Result<(), String> {
        self.lines.hold(&values[..self.lines.all.len()]);
        let (now, before, last) = parts(state, self.motion.state_len());
        self.motion.read_state(now);
        self.steps.move_to(&mut self.motion, continuous);
        self.motion.write_state(now);
        before.copy_from_slice(now);
        last[..KEPT].fill(0.0);
        self.lines.write(&mut last[KEPT..]);
        Ok(())
    }
}

impl Behaviour for PinRigBehaviour {
    fn state_len(&self) -> usize {
        2 * self.motion.state_len() + KEPT + self.lines.state_len()
    }

    fn start(&mut self, state: &mut [f64], values: &mut [f64]) -> Result<(), String> {
        let inputs = self.inputs();
        self.lines.hold(&values[..inputs]);
        self.motion = self.steps.rest();
        self.observe(&values[..inputs])?;
        values[inputs..][..self.row.len()].copy_from_slice(&self.row);
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
        asked: &Asked,
        step: f64,
    ) -> Result<(), Box<str>> {
        let (now, before, last) = parts(state, self.motion.state_len());
        self.motion.read_state(now);
        let inputs = self.inputs();
        self.lines.go_on(&last[KEPT..], &values[..inputs], &asked.slopes, step);
        let (lines, count) = (self.lines.all.clone(), self.count(asked.tolerance)?);
        self.go(&lines, count);
        self.observe(&ends(&lines))?;
        let lost = self.lost();
        if self.slip.is_some() {
            for (row, lost) in [DISSIPATED_ENERGY, IMPACT_ENERGY].into_iter().zip(lost) {
                self.row[row] = values[inputs + row] + lost;
            }
        }
        values[..inputs].copy_from_slice(&ends(&lines));
        values[inputs..][..self.row.len()].copy_from_slice(&self.row);
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
        let lines: Vec<Ramp> = (0..self.inputs()).map(|input| self.lines.beyond(input)).collect();
        // From where the contact stands still, or it would be taken to have come from elsewhere.
        self.motion.read_state(motion);
        let ahead = AHEAD * self.steps.longest_step();
        let part = if step > 0.0 { ahead / step } else { 0.0 };
        let forces: Vec<[f64; 3]> = lines
            .iter()
            .map(|line| [0.0, 0.5, 1.0].map(|place| line.start + (line.end - line.start) * part * place))
            .collect();
        let at = |place: usize| forces.iter().map(|force| force[place]).collect::<Vec<_>>();
        let mut from = self.motion.clone();
        let still: Vec<[f64; 3]> = forces.iter().map(|force| [force[0]; 3]).collect();
        self.steps.advance_under(&mut from, 0.0, still[0], &still[1..]);
        std::mem::swap(&mut self.motion, &mut from);
        self.observe(&at(0))?;
        rates.iter_mut().zip(&self.row).for_each(|(rate, value)| *rate = -value);
        self.steps.advance_under(&mut self.motion, ahead, forces[0], &forces[1..]);
        self.observe(&at(2))?;
        rates.iter_mut().zip(&self.row).for_each(|(rate, value)| *rate = (*rate + value) / ahead);
        if self.slip.is_some() {
            let lasting = if step > 0.0 { step } else { f64::INFINITY };
            rates[DISSIPATED_ENERGY] = last[0] / lasting;
            rates[IMPACT_ENERGY] = last[1] / lasting;
        }
        self.clear_states(rates);
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
        let by: Vec<Ramp> =
            direction.iter().enumerate().map(|(input, way)| self.lines.change(input, way)).collect();
        let sizes = by.iter().flat_map(|by| [by.start, by.end, by.bow, by.skew]);
        let size = sizes.fold(0.0, |most: f64, x| most.max(x.abs()));
        if size == 0.0 {
            return Ok(());
        }
        let (lines, count) = (self.lines.all.clone(), self.count(tolerance)?);
        let span = self.small / size;
        for part in [span, -span] {
            let moved = lines.iter().zip(&by).map(|(line, by)| Ramp {
                start: line.start + part * by.start,
                end: line.end + part * by.end,
                bow: line.bow + part * by.bow,
                skew: line.skew + part * by.skew,
            });
            let moved: Vec<Ramp> = moved.collect();
            self.repeat(state, &moved, count)?;
            change.iter_mut().zip(&self.row).for_each(|(sum, value)| *sum += value / (2.0 * part));
        }
        self.clear_states(change);
        Ok(())
    }
}

/// Where lines end.
fn ends(lines: &[Ramp]) -> Vec<f64> {
    lines.iter().map(|line| line.end).collect()
}
