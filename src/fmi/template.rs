//! What all instances of a model share: read and checked once.

use super::continuous::{Continuous, ContinuousForm};
use super::description::{Causality, Description};
use super::error::Error;
use super::further::Further;
use super::instance::Instance;
use super::kinds::{behaviour, describe};
use super::parameter::parameters;
use crate::contact::MEASURED;
use crate::model::Model;
use std::ops::Range;
use std::sync::Arc;
use uuid::Uuid;

/// A model that was read and checked, for as many instances as are wanted. A copy costs nothing: it is the same model.
///
/// ```
/// use stickslip::fmi::Template;
/// let template = Template::parse(
///     r#"
///     schema = "stickslip.model/1"
///     kind = "contact"
///     contact = { law = "jenkins", tangential_stiffness = 2e6, friction_coefficient = 0.5, normal_load = 100.0 }
///     "#,
/// )?;
/// let contacts: Vec<_> = (0..100).map(|_| template.instance()).collect::<Result<_, _>>()?;
/// assert_eq!(contacts[0].guid(), template.guid());
/// # Ok::<(), stickslip::fmi::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Template(Arc<Shared>);

/// The parts, for instances.
#[derive(Debug)]
pub(super) struct Shared {
    pub model: Model,
    pub description: Description,
    pub guid: Uuid,
    /// Where each parameter of the table stands in the model.
    pub paths: Vec<String>,
    /// Variables beyond the table.
    pub further: Vec<Further>,
    /// Numbers of inputs and of outputs.
    pub inputs: usize,
    pub outputs: usize,
    /// Whether there is a table that a contact can leave.
    pub may_warn: bool,
}

impl Shared {
    /// The rows of the parameters.
    pub fn parameters(&self) -> Range<usize> {
        let first = self.inputs + self.outputs;
        first..first + self.paths.len()
    }

    /// Values of all variables before anything was set.
    pub fn starts(&self) -> impl Iterator<Item = f64> + '_ {
        self.description.variables.iter().map(|variable| variable.start)
    }
}

impl Template {
    /// Reads `model_toml`, the text of a model file.
    ///
    /// # Errors
    /// A text that is no model, with the line.
    pub fn parse(model_toml: &str) -> Result<Self, Error> {
        let model = Model::parse(model_toml).map_err(|error| {
            let line = error.span.as_ref().and_then(|span| model_toml.get(..span.start));
            let line = line.map(|before| format!("line {}: ", before.matches('\n').count() + 1));
            Error::Model(format!("{}{}", line.unwrap_or_default(), error.message))
        })?;
        Self::new(model)
    }

    /// Checks `model`.
    ///
    /// # Errors
    /// Values that make no model.
    pub fn new(model: Model) -> Result<Self, Error> {
        model.check().map_err(|error| Error::Model(error.to_string()))?;
        let (paths, rows) = parameters(&model);
        let form = behaviour(&model).map_err(Error::Parameters)?;
        let form = ContinuousForm { modes: form.modes(), indicators: form.indicators() };
        let description = describe(&model, rows).map_err(Error::Model)?.with_continuous_form(form);
        let guid = description.guid();
        let count = |causality| description.references(causality).count();
        let (inputs, outputs) = (count(Causality::Input), count(Causality::Output));
        let further = description.further();
        let may_warn = model.contact.is_some_and(|contact| contact.law.kind == MEASURED);
        let shared = Shared { model, description, guid, paths, further, inputs, outputs, may_warn };
        Ok(Self(Arc::new(shared)))
    }

    /// An instance, at the beginning of a simulation.
    ///
    /// # Errors
    /// Parameters that make no model.
    pub fn instance(&self) -> Result<Instance, Error> {
        let behaviour = behaviour(&self.0.model).map_err(Error::Parameters)?;
        Ok(Instance::begin(Arc::clone(&self.0), behaviour))
    }

    /// An instance that its importer integrates, at the beginning of a simulation.
    ///
    /// ```
    /// use stickslip::fmi::Template;
    /// let template = Template::parse(
    ///     r#"
    ///     schema = "stickslip.model/1"
    ///     kind = "contact"
    ///     contact = { law = "jenkins", tangential_stiffness = 2e6, friction_coefficient = 0.5, normal_load = 100.0 }
    ///     "#,
    /// )?;
    /// let mut contact = template.continuous_instance()?;
    /// contact.enter_initialization()?;
    /// contact.exit_initialization()?;
    /// contact.enter_continuous_time()?;
    /// let row = |name| template.description().reference(name).unwrap();
    /// // A look leaves no trace until it is accepted.
    /// let mut force = [0.0];
    /// for (displacement, expected) in [(60e-6, 50.0), (20e-6, 40.0)] {
    ///     contact.set_real(&[row("displacement")], &[displacement])?;
    ///     contact.get_real(&[row("force")], &mut force)?;
    ///     assert!((force[0] - expected).abs() < 1e-9);
    /// }
    /// # Ok::<(), stickslip::fmi::Error>(())
    /// ```
    ///
    /// # Errors
    /// Parameters that make no model.
    pub fn continuous_instance(&self) -> Result<Instance, Error> {
        let mut instance = self.instance()?;
        instance.continuous = Some(Continuous::new(&self.0.description));
        Ok(instance)
    }

    /// The variable table.
    pub fn description(&self) -> &Description {
        &self.0.description
    }

    /// Identity of the model ([`Description::guid`]).
    pub fn guid(&self) -> Uuid {
        self.0.guid
    }
}
