//! From the model's contact to its law.

use super::Model;
use super::{Contact, Law};
use crate::contact::JointChanges;
use crate::contact::{
    ContactLaw, Iwan, IwanSpacing, Jenkins, Joint, JointBase, LawError, MICRO_SLIDERS, Valanis,
};

/// How finely a model's Iwan element is cut: the shortest interval is about 1/7000 of the longest stretch.
const IWAN_INTERVALS: usize = 40;
const IWAN_GROWTH: f64 = 1.2;

impl Contact {
    /// The contact law with this contact's parameters. The normal load is not part of a law: it goes
    /// into every step. What the model's effects change is left out: see [`Model::law`].
    ///
    /// # Errors
    /// A parameter outside its bounds.
    pub fn law(&self) -> Result<Box<dyn ContactLaw>, LawError> {
        Ok(match self.base()? {
            JointBase::Jenkins(law) => Box::new(law),
            JointBase::Valanis(law) => Box::new(law),
            JointBase::Iwan(law) => Box::new(law),
        })
    }

    /// The contact law with `changes`: the plain law where they are none.
    ///
    /// # Errors
    /// A parameter outside its bounds, or a change that this law does not take.
    pub fn changed_law(&self, changes: &JointChanges) -> Result<Box<dyn ContactLaw>, LawError> {
        if changes.is_none() { self.law() } else { Ok(Box::new(Joint::new(self.base()?, *changes)?)) }
    }

    fn base(&self) -> Result<JointBase, LawError> {
        let (stiffness, friction) = (self.tangential_stiffness, self.friction_coefficient);
        Ok(match self.law {
            Law::Jenkins => JointBase::Jenkins(Jenkins::new(stiffness, friction)?),
            Law::Valanis { smoothness, residual_stiffness } => {
                JointBase::Valanis(Valanis::new(stiffness, friction, smoothness, residual_stiffness)?)
            }
            Law::Iwan { exponent, ratio } => {
                let spacing = IwanSpacing::Geometric { growth: IWAN_GROWTH };
                JointBase::Iwan(Iwan::new(stiffness, friction, exponent, ratio, IWAN_INTERVALS, spacing)?)
            }
        })
    }
}

impl Model {
    /// The law of the model's contact with all that its effects change, if it has a contact.
    ///
    /// # Errors
    /// As [`Contact::changed_law`].
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

    /// As [`Model::law`], with a state whose length does not hang on the values of the parameters.
    pub(crate) fn law_of_any_values(&self) -> Result<Option<Box<dyn ContactLaw>>, LawError> {
        let Some(contact) = &self.contact else { return Ok(None) };
        if self.effects.is_empty() {
            return contact.law().map(Some);
        }
        let spreads = self.effects.iter().any(|applied| applied.effect.splits_slider());
        let sliders = if spreads { MICRO_SLIDERS } else { 1 };
        Ok(Some(Box::new(Joint::with_sliders(contact.base()?, self.changes().joint, sliders)?)))
    }
}
