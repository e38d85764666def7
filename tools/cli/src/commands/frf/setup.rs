//! From the model to what the solver wants.

use stickslip::contact::ContactLaw;
use stickslip::document::suggestion;
use stickslip::effects::{Location, Needs};
use stickslip::harmonic::{Assembly, Body, LoadedContact};
use stickslip::model::{Model, Structure};
use stickslip::system::{LinearStructure, ModalBeam};
use stickslip_report::responses::Losses;

use crate::Failure;

/// Structure and contacts of a model, ready to respond.
pub struct Setup {
    body: OwnedBody,
    /// One per contact of the structure.
    contacts: Vec<(Box<dyn ContactLaw>, f64)>,
    nodes: Vec<String>,
    /// Whether the first contact is the model's; the others are nonlinearities of the structure itself.
    has_contact: bool,
}

enum OwnedBody {
    Linear(LinearStructure),
    Beam(Box<ModalBeam>),
}

impl Setup {
    /// Prepares `model`, excited where `excite` says, else where the model says.
    pub fn new(model: &Model, excite: Option<&str>) -> Result<Self, Failure> {
        check_effects(model)?;
        let failed = |error: stickslip::system::StructureError| Failure::input(error.to_string());
        let (body, contacts, nodes) = match &model.structure {
            Structure::Prescribed => {
                return Err(Failure::input(
                    "a contact whose displacement is prescribed has no frequency response; the model's kind must be \
                     \"oscillator\" or \"beam\"",
                ));
            }
            Structure::Oscillator(oscillator) => {
                let names: Vec<&str> = oscillator.masses.iter().map(|mass| mass.name.as_str()).collect();
                let mut oscillator = oscillator.clone();
                if let Some(wanted) = excite {
                    oscillator.excitation =
                        names.iter().position(|name| *name == wanted).ok_or_else(|| {
                            let help = suggestion(wanted, &names, "masses");
                            Failure::input(format!("--excite: the model has no mass `{wanted}`; {help}"))
                        })?;
                }
                let nodes = names.iter().map(|name| (*name).to_owned()).collect();
                let model = Model { structure: Structure::Oscillator(oscillator), ..model.clone() };
                let assembled = model.assembled().map_err(|error| Failure::input(error.to_string()))?;
                let structure = assembled.structure.clone();
                (OwnedBody::Linear(structure), assembled.into_loaded(), nodes)
            }
            Structure::Beam(beam) => {
                if excite.is_some() {
                    return Err(Failure::input(
                        "--excite names a mass of an oscillator; a beam is excited at its [excitation] position",
                    ));
                }
                let modal = ModalBeam::with_changes(beam, &model.changes().structure).map_err(failed)?;
                let sensors = modal.sensors.iter().map(|sensor| format!("x={}", sensor.position));
                let nodes = sensors.chain(["excitation".to_owned()]).collect();
                let law = model.law().map_err(|error| Failure::input(error.to_string()))?;
                let contact = law.zip(model.contact.map(|contact| contact.normal_load));
                (OwnedBody::Beam(Box::new(modal)), contact.into_iter().collect(), nodes)
            }
        };
        Ok(Self { body, contacts, nodes, has_contact: model.contact.is_some() })
    }

    /// What takes energy.
    pub fn losses(&self) -> Losses {
        let contact = self.has_contact;
        match &self.body {
            OwnedBody::Linear(structure) => {
                let undamped = structure.damping.iter().all(|entry| entry.2 == 0.0);
                // Behind the contact there may be drag.
                let own = self.contacts.len() > usize::from(contact);
                let dampers = Some(structure.damping.clone());
                Losses { contact, drag: 0.0, dampers, undamped: undamped && !own }
            }
            OwnedBody::Beam(beam) => {
                let drag = beam.quadratic_damping;
                let undamped = drag == 0.0 && beam.damping_ratio.iter().all(|ratio| *ratio == 0.0);
                Losses { contact, drag, dampers: None, undamped }
            }
        }
    }

    /// The system under a cosine of unit amplitude.
    pub fn assembly(&self) -> Assembly<'_> {
        let body = match &self.body {
            OwnedBody::Linear(structure) => Body::Linear(structure),
            OwnedBody::Beam(beam) => Body::Beam(beam),
        };
        let contacts = self
            .contacts
            .iter()
            .map(|(law, normal_load)| LoadedContact { law: law.as_ref(), normal_load: *normal_load })
            .collect();
        Assembly { body, contacts, waveform: vec![0.0, 1.0, 0.0] }
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
        if applied.effect.needs == Needs::Transient {
            return Err(Failure::input(format!(
                "the effect \"{id}\" has no steady state, and so no frequency response: what it adds grows from \
                 period to period; take it out of the model, or simulate from rest"
            )));
        }
        if let Some(Location::Channel(channel)) = &applied.location {
            tell!(
                "note: the effect \"{id}\" is of the measurement of {channel}: the response is the structure’s, without it"
            );
        }
    }
    Ok(())
}
