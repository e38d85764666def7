//! The steady state that a beam reaches from rest, stepped through time: near a response where no search leads to one.

use std::f64::consts::TAU;

use super::{Start, SteadyProblem};
use crate::harmonic::balance::modal::Ports;
use crate::harmonic::{Assembly, HarmonicError};
use crate::numeric::fourier::{Basis, coefficient_count, value};
use crate::system::Element;
use crate::time::{Integrator, Ramp, Settings};

/// Instants in a period, per harmonic of the contact.
const INSTANTS: usize = 4;
/// Change of the contact's motion from one period to the next, as a fraction of it, that is near enough to a steady state.
const SETTLED: f64 = 1e-4;
/// Steps after which a motion that has not settled is taken as it is: a light damping takes hundreds of periods.
const MOST_STEPS: usize = 300_000;
/// Error of a step as a fraction of the motion.
const TOLERANCE: f64 = 1e-5;

impl SteadyProblem {
    /// Where to look for the response that `assembly` reaches from rest.
    ///
    /// # Errors
    /// [`HarmonicError`] for a beam that cannot be stepped through time, has no contact, or cannot be balanced.
    pub(super) fn reached(&self, assembly: &Assembly) -> Result<Start, HarmonicError> {
        let (coefficients, force) =
            self.settled(assembly).ok_or(HarmonicError::InvalidInput("the beam reaches no steady state"))?;
        let mut balance = self.balance(assembly, &Ports::of(&assembly.system), None)?;
        let unknowns = balance.unknowns_of(&coefficients, &force);
        Ok(Start::of(&balance, &unknowns, None))
    }

    /// Coefficients of every mode, mode after mode, and of the force of the first contact (N), once the motion has settled.
    fn settled(&self, assembly: &Assembly) -> Option<(Vec<f64>, Vec<f64>)> {
        let instants = INSTANTS * self.contact_harmonics;
        let basis = Basis::new(self.contact_harmonics, instants);
        let step = TAU / self.angular_frequency / instants as f64;
        let mut integrator = Integrator::new(&assembly.system).ok()?;
        let inputs = self.inputs(assembly, &integrator, instants);
        let settings = Settings { tolerance: TOLERANCE, step_limit: MOST_STEPS / instants };
        let mut motion = integrator.rest(&inputs[0]).ok()?;
        let mut force = vec![0.0; instants];
        let mut modes = vec![vec![0.0; instants]; motion.modes()];
        let project = |samples: &[f64], harmonics: usize| {
            let mut coefficients = vec![0.0; coefficient_count(self.contact_harmonics)];
            basis.project(samples, &mut coefficients);
            coefficients.truncate(coefficient_count(harmonics));
            coefficients
        };
        let (mut before, mut steps) = (Vec::new(), 0);
        while steps < MOST_STEPS {
            for (instant, inputs) in inputs.iter().enumerate() {
                force[instant] = (motion.contacts() > 0).then(|| motion.contact(0).force)?;
                let moved = modes.iter_mut().zip(motion.modal_displacement());
                moved.for_each(|(samples, now)| samples[instant] = *now);
                steps += integrator.advance(&mut motion, step, inputs, &settings).ok()?;
            }
            let now: Vec<f64> = modes.iter().flat_map(|samples| project(samples, self.harmonics)).collect();
            let settled = change(&now, &before) <= SETTLED;
            before = now;
            if settled {
                break;
            }
        }
        Some((before, project(&force, self.contact_harmonics)))
    }

    /// What acts from each instant of a period to the next.
    fn inputs(&self, assembly: &Assembly, integrator: &Integrator, instants: usize) -> Vec<Vec<Ramp>> {
        let held = integrator.held_inputs();
        let driven = assembly.system.driven.len();
        let takes_one = |element: &Element| matches!(element, Element::Law { .. } | Element::Outside { .. });
        let place = |element: usize| {
            driven + assembly.system.elements[..element].iter().filter(|element| takes_one(element)).count()
        };
        let curve = |coefficients: &[f64], instant: usize| {
            let at = |half: f64| value(coefficients, TAU * (instant as f64 + half) / instants as f64);
            let (start, end) = (at(0.0), at(1.0));
            Ramp { bow: 4.0 * at(0.5) - 2.0 * (start + end), ..Ramp::line(start, end) }
        };
        let swings: Vec<(usize, Vec<f64>)> = assembly
            .load_swings
            .iter()
            .map(|(element, swing)| {
                let place = place(*element);
                (place, [&[held[place].start][..], swing].concat())
            })
            .collect();
        let at = |instant: usize| {
            let mut inputs = held.clone();
            inputs[..driven].fill(curve(&self.coefficients, instant));
            swings.iter().for_each(|(place, load)| inputs[*place] = curve(load, instant));
            inputs
        };
        (0..instants).map(at).collect()
    }
}

/// Size of the difference from `before`, as a fraction of what is there now.
fn change(now: &[f64], before: &[f64]) -> f64 {
    if before.is_empty() {
        return f64::INFINITY;
    }
    let size = |values: &mut dyn Iterator<Item = f64>| values.map(|x| x * x).sum::<f64>().sqrt();
    let apart = size(&mut now.iter().zip(before).map(|(a, b)| a - b));
    let whole = size(&mut now.iter().copied());
    if whole > 0.0 { apart / whole } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::harmonic::response::start::directly;
    use crate::model::Model;

    fn assembly(damping_ratio: f64, contact: &str, effects: &str) -> Assembly {
        let text = format!(
            r#"
            schema = "stickslip.model/1"
            kind = "beam"
            support = {{ offset = 0.006 }}
            excitation = {{ position = 0.55 }}
            sensor = [{{ position = 0.55 }}, {{ position = 0.3 }}]
            contact = {{ {contact} }}
            effect = [{effects}]
            [beam]
            length = 0.6
            width = 0.04
            thickness = 0.005
            density = 7850.0
            youngs_modulus = 2.09e11
            modes = 6
            damping_ratio = {damping_ratio}
            point_mass = [{{ position = 0.55, mass = 0.025 }}]
            "#
        );
        Assembly::new(Model::parse(&text).expect("a legal model").system().expect("a system"))
    }

    fn problem(frequency: f64, coefficients: &[f64]) -> SteadyProblem {
        SteadyProblem {
            angular_frequency: TAU * frequency,
            coefficients: coefficients.to_vec(),
            harmonics: 36,
            contact_harmonics: 40,
            sensed_harmonics: 108,
            tolerance: 1e-8,
        }
    }

    const JENKINS: &str =
        "law = \"jenkins\", tangential_stiffness = 4.37e6, friction_coefficient = 0.64, normal_load = 132.6";
    const HANGING: &str = r#"{ id = "hanging_mass", mass = 7.67, hanging_frequency = 72.5 }"#;

    /// The response near where stepping leads, and how far that was from it, as a fraction.
    fn followed(problem: &SteadyProblem, assembly: &Assembly) -> (Vec<f64>, f64) {
        let start = problem.reached(assembly).expect("a steady state");
        let mut found = problem.solve(assembly, &[], Some(&start)).expect("a response");
        (found.sensors(problem), change(found.here().contact(), start.contact()))
    }

    #[test]
    fn stepping_leads_to_the_response_that_is_balanced() {
        let valanis = &JENKINS.replace("jenkins\"", "valanis\", smoothness = 0.6") as &str;
        for (name, contact, effects, coefficients) in [
            ("slip", JENKINS, "", &[0.0, 12.0, 0.0][..]),
            ("hanging mass, two harmonics", JENKINS, HANGING, &[0.0, 9.0, 4.0, 0.0, 3.0]),
            ("stick", JENKINS, "", &[0.0, 0.02, 0.01]),
            ("valanis", valanis, "", &[0.0, 5.0, 0.0]),
            ("stiffening", JENKINS, r#"{ id = "stiffening", cubic_stiffness = 1e15 }"#, &[0.0, 6.0, 0.0]),
        ] {
            let (assembly, problem) = (assembly(0.0032, contact, effects), problem(53.0, coefficients));
            let (followed, distance) = followed(&problem, &assembly);
            let mut from_nothing = problem.solve(&assembly, &[], None).expect("a response");
            let apart = change(&from_nothing.sensors(&problem), &followed);
            assert!(apart < 1e-6 && distance < 2e-2, "{name}: {apart:e} {distance:e}");
        }
    }

    #[test]
    fn a_load_that_swings_is_stepped_as_it_is_balanced() {
        let (mut assembly, problem) = (assembly(0.0032, JENKINS, ""), problem(53.0, &[0.0, 8.0, 0.0]));
        assembly.load_swings.push((0, vec![30.0, 0.0, 0.0, 20.0]));
        let (followed, distance) = followed(&problem, &assembly);
        let mut from_nothing = problem.solve(&assembly, &[], None).expect("a response");
        let apart = change(&from_nothing.sensors(&problem), &followed);
        assert!(apart < 1e-6 && distance < 2e-2, "{apart:e} {distance:e}");
    }

    #[test]
    fn a_response_that_no_search_finds_is_stepped_to() {
        let (assembly, problem) = (assembly(0.0032, JENKINS, HANGING), problem(50.0, &[0.0, 24.0, 0.0]));
        let mut balance = problem.balance(&assembly, &Ports::of(&assembly.system), None).expect("a balance");
        let nothing =
            directly(&mut balance, problem.operating(), &problem.settings()).expect("a legal system");
        assert!(nothing.is_none());
        let mut found = problem.solve(&assembly, &[], None).expect("a response");
        let apart = change(&found.sensors(&problem), &followed(&problem, &assembly).0);
        assert!(apart < 1e-6, "{apart:e}");
    }

    #[test]
    fn a_beam_without_a_contact_is_not_stepped() {
        let mut assembly = assembly(0.0032, JENKINS, "");
        assembly.system.elements.clear();
        assert!(problem(53.0, &[0.0, 1.0, 0.0]).reached(&assembly).is_err());
    }
}
