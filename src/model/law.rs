//! From the model's contact to its law.

use super::{Contact, Model};
use crate::contact::{AnyLaw, ContactLaw, Joint, JointBase, JointChanges, LawError, MICRO_SLIDERS};

impl Contact {
    /// The contact law with this contact's parameters. The normal load is not part of a law: it goes
    /// into every step. What the model's effects change is left out: see [`Model::law`].
    ///
    /// # Errors
    /// A parameter outside its bounds.
    pub fn law(&self) -> Result<Box<dyn ContactLaw>, LawError> {
        Ok(self.base()?.into_law())
    }

    /// The contact law with `changes`: the plain law where they are none.
    ///
    /// # Errors
    /// A parameter outside its bounds, or a change that this law does not take.
    fn changed_law(&self, changes: &JointChanges) -> Result<Box<dyn ContactLaw>, LawError> {
        if changes.is_none() { self.law() } else { Ok(Box::new(Joint::new(self.base()?, *changes)?)) }
    }

    fn base(&self) -> Result<JointBase, LawError> {
        self.law.base(self.tangential_stiffness, self.friction_coefficient)
    }
}

impl Model {
    /// The law of the model's contact with all that its effects change, if it has a contact.
    ///
    /// # Errors
    /// A parameter outside its bounds, or a change that this law does not take.
    ///
    /// ```
    /// use stickslip::model::Model;
    /// let model = Model::parse(
    ///     r#"
    ///     schema = "stickslip.model/1"
    ///     kind = "contact"
    ///     contact = { law = "jenkins", tangential_stiffness = 2e6, friction_coefficient = 0.5, normal_load = 100.0 }
    ///     effect = [{ id = "asymmetry", asymmetry = 0.1 }]
    ///     "#,
    /// )?;
    /// let law = model.law()?.unwrap();
    /// assert!(!law.is_odd());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn law(&self) -> Result<Option<Box<dyn ContactLaw>>, LawError> {
        let joint = self.changes().joint;
        self.contact.map(|contact| contact.changed_law(&joint)).transpose()
    }

    /// As [`Model::law`], with a state whose length does not depend on the values of the parameters.
    pub(crate) fn law_of_any_values(&self) -> Result<Option<AnyLaw>, LawError> {
        let Some(contact) = &self.contact else { return Ok(None) };
        if self.effects.is_empty() {
            return Ok(Some(contact.base()?.into()));
        }
        let spreads = self.effects.iter().any(|applied| applied.effect.splits_slider());
        let sliders = if spreads { MICRO_SLIDERS } else { 1 };
        let joint = Joint::with_sliders(contact.base()?, self.changes().joint, sliders)?;
        Ok(Some(AnyLaw::Other(Box::new(joint))))
    }
}
