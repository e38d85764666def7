//! From the model to what the solver wants.

use stickslip::document::suggestion;
use stickslip::effects::{Location, Needs};
use stickslip::harmonic::Assembly;
use stickslip::model::{Model, Structure};
use stickslip::system::Core;
use stickslip_report::responses::Losses;

use crate::Failure;

/// A model, ready to respond.
pub struct Setup {
    assembly: Assembly,
    nodes: Vec<String>,
    /// How many of the first contacts are the model's, or its directions; the others are nonlinearities of the structure
    /// itself.
    contacts: usize,
}

impl Setup {
    /// Prepares `model`, excited where `excite` says, else where the model says.
    pub fn new(model: &Model, excite: Option<&str>) -> Result<Self, Failure> {
        check_effects(model)?;
        let model = match (&model.structure, excite) {
            (Structure::Prescribed, _) => {
                return Err(Failure::input(
                    "a contact whose displacement is prescribed has no frequency response; the model's kind must be \
                     \"oscillator\", \"beam\" or \"pin_rig\"",
                ));
            }
            (Structure::Beam(_) | Structure::PinRig(_), Some(_)) => {
                return Err(Failure::input(
                    "--excite names a mass of an oscillator; a beam is excited at its [excitation] position",
                ));
            }
            (Structure::Oscillator(oscillator), Some(wanted)) => {
                let names: Vec<&str> = oscillator.masses.iter().map(|mass| mass.name.as_str()).collect();
                let mut oscillator = oscillator.clone();
                oscillator.excitation = names.iter().position(|name| *name == wanted).ok_or_else(|| {
                    let help = suggestion(wanted, &names, "masses");
                    Failure::input(format!("--excite: the model has no mass `{wanted}`; {help}"))
                })?;
                &Model { structure: Structure::Oscillator(oscillator), ..model.clone() }
            }
            (_, None) => model,
        };
        let assembly = Assembly::new(model.system().map_err(|error| Failure::input(error.to_string()))?);
        let directions = if matches!(model.structure, Structure::PinRig(_)) { 2 } else { 1 };
        let contacts = if model.contact.is_some() { directions } else { 0 };
        Ok(Self { nodes: assembly.nodes(), assembly, contacts })
    }

    /// What takes energy.
    pub fn losses(&self) -> Losses {
        let system = &self.assembly.system;
        let damping = system.linear_part().damping;
        // Behind the contact there may be drag.
        let own = system.laws().count() > self.contacts;
        let undamped = damping.iter().all(|entry| entry.2 == 0.0) && !own;
        let dampers = matches!(system.core, Core::Matrices { .. }).then_some(damping);
        Losses { contact: self.contacts, dampers, undamped }
    }

    /// The system under a cosine of unit amplitude.
    pub fn assembly(&self) -> &Assembly {
        &self.assembly
    }

    /// Names of the nodes, in the order of the results.
    pub fn nodes(&self) -> &[String] {
        &self.nodes
    }
}

/// Refuses effects that have no steady state, and says which do not act on it.
fn check_effects(model: &Model) -> Result<(), Failure> {
    for applied in &model.effects {
        let id = applied.effect.id;
        if let Some(Location::Channel(channel)) = &applied.location {
            tell!(
                "note: the effect \"{id}\" is of the measurement of {channel}: the response is the structure’s, without it"
            );
            continue;
        }
        if applied.effect.needs == Needs::Transient {
            return Err(Failure::input(format!(
                "the effect \"{id}\" has no steady state, and so no frequency response: what it adds grows from \
                 period to period; take it out of the model, or simulate from rest"
            )));
        }
    }
    Ok(())
}
