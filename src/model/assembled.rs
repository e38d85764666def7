//! From a model to what the solvers of linear structures with contacts take.

use super::{Model, Structure};
use crate::contact::{ContactLaw, LawError};
use crate::structure::{LinearStructure, ModalBeam, StructureError};

/// A linear structure with the law of its contact.
#[derive(Debug)]
pub struct Assembled {
    /// The structure; with one contact, or none where the model has none.
    pub structure: LinearStructure,
    /// The contact's law.
    pub law: Option<Box<dyn ContactLaw>>,
    /// Constant normal load (N); 0 without a contact.
    pub normal_load: f64,
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
    /// The structure as matrices, with the contact's law and normal load.
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
        let mut structure = match &self.structure {
            Structure::Prescribed => return Err(AssemblyError::NoStructure),
            Structure::Beam(beam) => {
                LinearStructure::from_beam(&ModalBeam::with_changes(beam, &self.changes().structure)?)
            }
            Structure::Oscillator(oscillator) => oscillator.structure()?,
        };
        if self.contact.is_none() {
            structure.contacts.clear();
        }
        let law = self.law()?;
        Ok(Assembled { structure, law, normal_load: self.contact.map_or(0.0, |contact| contact.normal_load) })
    }
}
