//! From the model's contact to its law.

use super::{Contact, Law};
use crate::contact::{ContactLaw, Jenkins, LawError, Valanis};

impl Contact {
    /// The contact law with this contact's parameters. The normal load is not part of a law: it goes
    /// into every step.
    ///
    /// # Errors
    /// A parameter outside its bounds.
    pub fn law(&self) -> Result<Box<dyn ContactLaw>, LawError> {
        let Contact { tangential_stiffness, friction_coefficient, .. } = *self;
        Ok(match self.law {
            Law::Jenkins => Box::new(Jenkins::new(tangential_stiffness, friction_coefficient)?),
            Law::Valanis { smoothness, residual_stiffness } => Box::new(Valanis::new(
                tangential_stiffness,
                friction_coefficient,
                smoothness,
                residual_stiffness,
            )?),
        })
    }
}
