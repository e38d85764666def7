//! From a model to the system that solvers take.

use std::sync::Arc;

use super::{Model, Oscillator, Structure};
use crate::contact::{ContactLaw, LawError};
#[cfg(feature = "analysis")]
use crate::harmonic::{Assembly, HarmonicError};
use crate::system::{Core, Element, ModalBeam, ModalPinRig, Port, Row, StructureError, System};

/// Why a model makes no system.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum AssemblyError {
    /// The structure cannot be what the numbers say.
    #[error(transparent)]
    Structure(#[from] StructureError),
    /// The law cannot have these parameters.
    #[error(transparent)]
    Law(#[from] LawError),
}

/// A law with the normal load (N) that it is under.
type Loaded = (Arc<dyn ContactLaw>, f64);

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
        match &self.structure {
            Structure::Prescribed => {
                let elements =
                    self.loaded_law()?.map(|(law, normal_load)| Element::Law { port: 0, law, normal_load });
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
                self.system_on(&ModalBeam::with_changes(beam, &self.changes().structure)?)
            }
            Structure::PinRig(pinned) => {
                let changes = self.changes().structure;
                let rig = pinned.rig(self.contact.as_ref(), &changes)?;
                let modal = ModalPinRig::new(&rig)?.with_hung(&changes.hanging_masses)?;
                Ok(match self.slip_slap()? {
                    Some(contact) => modal.system(Some(Arc::new(contact))),
                    None => modal.system_from_outside(),
                })
            }
            Structure::Oscillator(oscillator) => {
                let changes = self.changes().structure;
                let structure = oscillator.structure_with(&changes)?;
                let added = Oscillator::added_laws(&changes)?.into_iter().map(|law| (Arc::from(law), 0.0));
                Ok(structure.system(self.loaded_law()?.into_iter().chain(added).collect()))
            }
        }
    }

    /// The system with `modal` for the beam, which is this model's, its effects on the structure included: for models that
    /// differ in the contact alone, a beam is reduced only once.
    pub(crate) fn system_on(&self, modal: &ModalBeam) -> Result<System, AssemblyError> {
        Ok(modal.system(self.loaded_law()?)?)
    }

    fn loaded_law(&self) -> Result<Option<Loaded>, LawError> {
        let load = self.contact.as_ref().map_or(0.0, |contact| contact.normal_load);
        self.law().map(|law| law.map(|law| (Arc::from(law), load)))
    }

    /// The system over the parameter at `path`, such as `contact.friction_coefficient`, under cos Ωt: what
    /// [`parameter_response`](crate::harmonic::parameter_response) and
    /// [`track_parameter`](crate::harmonic::track_parameter) take.
    ///
    /// # Errors
    /// A path that the model does not have. Those of values that it cannot take come from the function returned.
    #[cfg(feature = "analysis")]
    pub fn assembly_over(
        &self,
        path: &str,
    ) -> Result<impl Fn(f64) -> Result<Assembly, HarmonicError>, super::ParameterError> {
        let known = self.get(path);
        self.clone().set(path, known.unwrap_or(f64::NAN))?;
        let (model, path) = (self.clone(), path.to_owned());
        Ok(move |value| {
            let mut there = model.clone();
            there.set(&path, value).map_err(|error| HarmonicError::Model(error.to_string()))?;
            let system = there.system().map_err(|error| HarmonicError::Model(error.to_string()))?;
            Ok(Assembly::new(system))
        })
    }
}
