//! From a model to what the solvers of linear structures with contacts take.

use super::{Model, Oscillator, Structure};
use std::sync::Arc;

use crate::contact::{ContactLaw, LawError};
use crate::system::{Core, Element, LinearStructure, ModalBeam, Port, Row, StructureError, System};

/// A linear structure with the law of its contact.
#[derive(Debug)]
pub struct Assembled {
    /// The structure. Its contacts are the model's own, if it has one, and those of [`Assembled::added`].
    pub structure: LinearStructure,
    /// The contact's law.
    pub law: Option<Box<dyn ContactLaw>>,
    /// Constant normal load (N); 0 without a contact.
    pub normal_load: f64,
    /// Laws of the structure's own nonlinearities, which know no normal load: what effects add to an oscillator.
    pub added: Vec<Box<dyn ContactLaw>>,
}

impl Assembled {
    /// The laws in the order of the structure's contacts, each under its normal load (N).
    pub fn laws(&self) -> impl Iterator<Item = (&dyn ContactLaw, f64)> {
        let own = self.law.iter().map(|law| (law.as_ref(), self.normal_load));
        own.chain(self.added.iter().map(|law| (law.as_ref(), 0.0)))
    }

    /// The laws in the order of the structure's contacts, each with its normal load (N), for a holder of its own.
    pub fn into_loaded(self) -> Vec<(Box<dyn ContactLaw>, f64)> {
        let normal_load = self.normal_load;
        let own = self.law.into_iter().map(|law| (law, normal_load));
        own.chain(self.added.into_iter().map(|law| (law, 0.0))).collect()
    }
}

/// Why a model is no structure with a contact.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum AssemblyError {
    /// `kind = "contact"`: the displacement is prescribed.
    #[error("a model of kind \"contact\" has no structure")]
    NoStructure,
    /// The structure cannot be what the numbers say.
    #[error(transparent)]
    Structure(#[from] StructureError),
    /// The law cannot have these parameters.
    #[error(transparent)]
    Law(#[from] LawError),
}

impl Model {
    /// The model as a mechanical system, its effects included: a linear core, named ports and the elements at them. A
    /// contact of prescribed motion is an element alone, at the port `contact` of a system without coordinates. Faults of
    /// sensors are not part of it, and a load that varies is up to the solver.
    ///
    /// # Errors
    /// [`AssemblyError`].
    ///
    /// ```
    /// use stickslip::model::Model;
    /// let model = Model::parse(
    ///     r#"
    ///     schema = "stickslip.model/1"
    ///     kind = "oscillator"
    ///     mass = [{ name = "m1", mass = 1.0 }]
    ///     spring = [{ between = ["ground", "m1"], stiffness = 9.0, damping = 0.1 }]
    ///     contact = { at = "m1", law = "jenkins", tangential_stiffness = 7.0, friction_coefficient = 0.5, normal_load = 2.0 }
    ///     "#,
    /// )?;
    /// let system = model.system()?;
    /// let names: Vec<&str> = system.ports.iter().map(|port| port.name.as_str()).collect();
    /// assert_eq!(names, ["m1", "excitation", "contact"]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn system(&self) -> Result<System, AssemblyError> {
        let law = || {
            let load = self.contact.as_ref().map_or(0.0, |contact| contact.normal_load);
            let shared = |law| (Arc::<dyn ContactLaw>::from(law), load);
            self.law().map(|law| law.map(shared))
        };
        match &self.structure {
            Structure::Prescribed => {
                let elements = law()?.map(|(law, normal_load)| Element::Law { port: 0, law, normal_load });
                Ok(System {
                    core: Core::Modal { angular_frequency: Vec::new(), damping_ratio: Vec::new() },
                    shortening: Vec::new(),
                    ports: vec![Port::linear("contact", Row::new())],
                    elements: elements.into_iter().collect(),
                    driven: Vec::new(),
                    sensors: vec![0],
                })
            }
            Structure::Beam(beam) => {
                Ok(ModalBeam::with_changes(beam, &self.changes().structure)?.system(law()?)?)
            }
            Structure::Oscillator(_) => {
                let assembled = self.assembled()?;
                let structure = assembled.structure.clone();
                let loaded = assembled.into_loaded().into_iter();
                Ok(structure.system(loaded.map(|(law, load)| (Arc::from(law), load)).collect()))
            }
        }
    }

    /// The structure as matrices, with the contact's law and normal load, the model's effects included. Faults of
    /// sensors are not part of it, and a load that varies is up to the solver.
    ///
    /// Of a beam this is the linear part alone; see [`LinearStructure::from_beam`] for what is left out.
    ///
    /// # Errors
    /// [`AssemblyError`].
    ///
    /// ```
    /// use stickslip::model::Model;
    /// let model = Model::parse(
    ///     r#"
    ///     schema = "stickslip.model/1"
    ///     kind = "oscillator"
    ///     mass = [{ name = "m1", mass = 1.0 }]
    ///     spring = [{ between = ["ground", "m1"], stiffness = 9.0, damping = 0.1 }]
    ///     contact = { at = "m1", law = "jenkins", tangential_stiffness = 7.0, friction_coefficient = 0.5, normal_load = 2.0 }
    ///     "#,
    /// )?;
    /// let assembled = model.assembled()?;
    /// assert_eq!(assembled.structure.stiffness, [(0, 0, 9.0)]);
    /// assert_eq!(assembled.law.unwrap().limit(assembled.normal_load), 1.0);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn assembled(&self) -> Result<Assembled, AssemblyError> {
        let changes = self.changes().structure;
        let (structure, added) = match &self.structure {
            Structure::Prescribed => return Err(AssemblyError::NoStructure),
            Structure::Beam(beam) => {
                let mut structure = LinearStructure::from_beam(&ModalBeam::with_changes(beam, &changes)?);
                if self.contact.is_none() {
                    structure.contacts.clear();
                }
                (structure, Vec::new())
            }
            Structure::Oscillator(oscillator) => {
                (oscillator.structure_with(&changes)?, Oscillator::added_laws(&changes)?)
            }
        };
        let law = self.law()?;
        let normal_load = self.contact.as_ref().map_or(0.0, |contact| contact.normal_load);
        Ok(Assembled { structure, law, normal_load, added })
    }
}
