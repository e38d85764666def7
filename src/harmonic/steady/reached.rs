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
/// Change of the motion from one period to the next, as a fraction of it, that is near enough to a steady state.
const SETTLED: f64 = 1e-4;
/// Steps after which no more periods are begun and a motion that has not settled is taken as it is: a light damping takes
/// hundreds of periods.
const MOST_STEPS: usize = 300_000;
/// Error of a step as a fraction of the motion.
const TOLERANCE: f64 = 1e-5;

/// A period by its coefficients.
struct Period {
    /// Of every mode, mode after mode.
    modes: Vec<f64>,
    /// Of the force of the first contact (N).
    force: Vec<f64>,
}

impl SteadyProblem {
    /// Where to look for the response that `assembly` reaches from rest, and whether it has settled there; whatever its laws were
    /// left with is that of a first loading.
    ///
    /// # Errors
    /// [`HarmonicError`] for a system that cannot be stepped through a period, or cannot be balanced.
    pub(super) fn reached(&self, assembly: &Assembly) -> Result<(Start, bool), HarmonicError> {
        let no_period = HarmonicError::InvalidInput("the system cannot be stepped through a period");
        let (Period { modes, force }, settled) = self.settled(assembly).ok_or(no_period)?;
        let mut balance = self.balance(assembly, &Ports::of(&assembly.system), None)?;
        let unknowns = balance.unknowns_of(&modes, &force, self.angular_frequency);
        Ok((Start::of(&balance, &unknowns, &force, None), settled))
    }

    /// The last whole period, and whether the motion has settled in it: it may not repeat in time, or stop to be stepped.
    fn settled(&self, assembly: &Assembly) -> Option<(Period, bool)> {
        let instants = INSTANTS * self.contact_harmonics;
        let basis = Basis::new(self.contact_harmonics, instants);
        let step = TAU / self.angular_frequency / instants as f64;
        let mut integrator = Integrator::new(&assembly.system).ok()?;
        let inputs = self.inputs(assembly, &integrator, instants);
        let settings = Settings { tolerance: TOLERANCE, step_limit: MOST_STEPS / instants };
        let mut motion = integrator.rest(inputs.first()?).ok()?;
        let mut force = vec![0.0; instants];
        // Coordinates of what hangs at the contact come behind those of the modes.
        let mut modes = vec![vec![0.0; instants]; assembly.system.core.size()];
        let project = |samples: &[f64], harmonics: usize| {
            let mut coefficients = vec![0.0; coefficient_count(self.contact_harmonics)];
            basis.project(samples, &mut coefficients);
            coefficients.truncate(coefficient_count(harmonics));
            coefficients
        };
        let (mut last, mut steps): (Option<Period>, usize) = (None, 0);
        while steps < MOST_STEPS {
            for (instant, inputs) in inputs.iter().enumerate() {
                if motion.contacts() > 0 {
                    force[instant] = motion.contact(0).force;
                }
                let moved = modes.iter_mut().zip(motion.modal_displacement());
                moved.for_each(|(samples, now)| samples[instant] = *now);
                let Ok(count) = integrator.advance(&mut motion, step, inputs, &settings) else {
                    return last.map(|last| (last, false));
                };
                steps += count;
            }
            let now = Period {
                modes: modes.iter().flat_map(|samples| project(samples, self.harmonics)).collect(),
                force: project(&force, self.contact_harmonics),
            };
            let settled = last.as_ref().is_some_and(|last| apart(&now.modes, &last.modes) <= SETTLED);
            if settled {
                return Some((now, true));
            }
            last = Some(now);
        }
        last.map(|last| (last, false))
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
fn apart(now: &[f64], before: &[f64]) -> f64 {
    let size = |values: &mut dyn Iterator<Item = f64>| values.map(|x| x * x).sum::<f64>().sqrt();
    let apart = size(&mut now.iter().zip(before).map(|(a, b)| a - b));
    let whole = size(&mut now.iter().copied());
    if whole > 0.0 { apart / whole } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::super::Steady;
    use super::*;
    use crate::harmonic::response::start::directly;
    use crate::model::Model;

    fn assembly(contact: &str, effects: &str) -> Assembly {
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
            damping_ratio = 0.0032
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

    /// The response that a search from nothing finds, if it does.
    fn searched(problem: &SteadyProblem, assembly: &Assembly) -> Option<Vec<f64>> {
        let mut balance =
            problem.balance(assembly, &Ports::of(&assembly.system), None).expect("a balance of the system");
        let at = problem.operating();
        let unknowns = directly(&mut balance, at, &problem.settings()).expect("a legal system")?;
        Some(Steady { balance, unknowns, at }.sensors(problem))
    }

    /// The response near where stepping leads, and how far that was from it, as a fraction.
    fn followed(problem: &SteadyProblem, assembly: &Assembly) -> (Vec<f64>, f64) {
        let (start, settled) = problem.reached(assembly).expect("a period");
        assert!(settled);
        let mut found = problem.solve(assembly, &[], Some(&start)).expect("a response");
        (found.sensors(problem), apart(found.here().contact(), start.contact()))
    }

    #[test]
    fn stepping_leads_to_the_response_that_is_balanced() {
        let valanis = JENKINS.replace("jenkins\"", "valanis\", smoothness = 0.6");
        let stiffening = r#"{ id = "stiffening", cubic_stiffness = 1e15 }"#;
        for (name, contact, effects, coefficients, swing) in [
            ("slip", JENKINS, "", &[0.0, 12.0, 0.0][..], &[][..]),
            ("hanging mass, two harmonics", JENKINS, HANGING, &[0.0, 9.0, 4.0, 0.0, 3.0], &[]),
            ("stick", JENKINS, "", &[0.0, 0.02, 0.01], &[]),
            ("valanis", &valanis, "", &[0.0, 5.0, 0.0], &[]),
            ("stiffening", JENKINS, stiffening, &[0.0, 6.0, 0.0], &[]),
            ("a load that swings", JENKINS, "", &[0.0, 8.0, 0.0], &[30.0, 0.0, 0.0, 20.0]),
        ] {
            let (mut assembly, problem) = (assembly(contact, effects), problem(53.0, coefficients));
            if !swing.is_empty() {
                assembly.load_swings.push((0, swing.to_vec()));
            }
            let (followed, distance) = followed(&problem, &assembly);
            let apart = apart(&searched(&problem, &assembly).expect(name), &followed);
            assert!(apart < 1e-6 && distance < 2e-2, "{name}: {apart:e} {distance:e}");
        }
    }

    #[test]
    fn a_response_that_no_search_finds_is_stepped_to() {
        let (assembly, problem) = (assembly(JENKINS, HANGING), problem(50.0, &[0.0, 24.0, 0.0]));
        assert!(searched(&problem, &assembly).is_none());
        let (followed, distance) = followed(&problem, &assembly);
        let mut found = problem.solve(&assembly, &[], None).expect("a response");
        assert!(apart(&found.sensors(&problem), &followed) < 1e-6 && distance < 2e-2, "{distance:e}");
    }

    #[test]
    fn a_beam_without_a_contact_moves_as_its_modes_do() {
        let mut assembly = assembly(JENKINS, "");
        assembly.system.elements.clear();
        let problem = problem(53.0, &[0.0, 1.0, 0.0]);
        let distance = followed(&problem, &assembly).1;
        assert!(distance < 1e-2, "{distance:e}");
    }
}
