//! From the model to what the solver wants.

use stickslip::contact::ContactLaw;
use stickslip::document::suggestion;
use stickslip::harmonic::{Assembly, AttachedContact, Body};
use stickslip::model::{Model, Structure};
use stickslip::structure::{LinearStructure, ModalBeam};

use crate::Failure;

/// Structure and contacts of a model, ready to respond.
pub struct Setup {
    body: OwnedBody,
    /// One per contact of the structure.
    contacts: Vec<(Box<dyn ContactLaw>, f64)>,
    nodes: Vec<String>,
}

enum OwnedBody {
    Linear(LinearStructure),
    Beam(Box<ModalBeam>),
}

impl Setup {
    /// Prepares `model`, excited where `excite` says, else where the model says.
    pub fn new(model: &Model, excite: Option<&str>) -> Result<Self, Failure> {
        let failed = |error: stickslip::structure::StructureError| Failure::input(error.to_string());
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
                let modal = ModalBeam::new(beam).map_err(failed)?;
                let nodes = modal.sensors.iter().map(|sensor| format!("x={}", sensor.position)).collect();
                let law = model.law().map_err(|error| Failure::input(error.to_string()))?;
                let contact = law.zip(model.contact.map(|contact| contact.normal_load));
                (OwnedBody::Beam(Box::new(modal)), contact.into_iter().collect(), nodes)
            }
        };
        Ok(Self { body, contacts, nodes })
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
            .map(|(law, normal_load)| AttachedContact { law: law.as_ref(), normal_load: *normal_load })
            .collect();
        Assembly { body, contacts, waveform: vec![0.0, 1.0, 0.0] }
    }

    /// Names of the nodes, in the order of the results.
    pub fn nodes(&self) -> &[String] {
        &self.nodes
    }
}
