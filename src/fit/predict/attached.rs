//! A model's beam with its contact, as steady states, backbones and integrations take it.

use std::sync::Arc;

use crate::contact::ContactLaw;
use crate::harmonic::Assembly;
use crate::model::{Beam, Model, Structure};
use crate::system::{ModalBeam, StructureError, System};

/// A model's beam, reduced to its modes, with its contact.
#[derive(Debug)]
pub(in crate::fit::predict) struct Attached {
    pub beam: ModalBeam,
    law: Option<Arc<dyn ContactLaw>>,
    /// The load (N) where none is measured, else the mean of what the contact follows of the measured one.
    pub normal_load: f64,
    /// Coefficients `[c1, s1, …]` (N) of what it follows of a measured load's swing.
    load_swing: Vec<f64>,
    /// Static contact offset (m): the displacement at which the contact that never moved has no force.
    offset: f64,
}

impl Attached {
    /// The model with all its effects, and sensors at `sensors` (m), whatever sensors it lists.
    ///
    /// `load` are the coefficients of the normal load (N) that was measured in a steady state.
    pub fn new(model: &Model, sensors: &[f64], load: Option<&[f64]>) -> Result<Self, String> {
        let Structure::Beam(beam) = &model.structure else {
            return Err("the model is not a beam".into());
        };
        // Nothing is known of forces at contact points, and models of measurements have none.
        let beam = Beam { sensors: sensors.to_vec(), contact_points: Vec::new(), ..beam.clone() };
        let beam =
            ModalBeam::with_changes(&beam, &model.changes().structure).map_err(|error| error.to_string())?;
        let law = model.law().map_err(|error| error.to_string())?;
        let constant = model.contact.map_or(0.0, |contact| contact.normal_load);
        let joint = model.changes().joint;
        let normal_load = joint.normal_load(constant, load.map(|load| load[0]));
        let gain = joint.load_gain.filter(|gain| *gain != 0.0);
        let load_swing = match (gain, load) {
            (Some(gain), Some([_, swing @ ..])) if swing.iter().any(|x| *x != 0.0) => {
                swing.iter().map(|x| gain * x).collect()
            }
            _ => Vec::new(),
        };
        Ok(Self { beam, law: law.map(Arc::from), normal_load, load_swing, offset: 0.0 })
    }

    /// The same with a static contact offset (m).
    pub fn with_offset(self, offset: f64) -> Self {
        Self { offset, ..self }
    }

    /// The beam with its contact as a system.
    pub fn system(&self) -> Result<System, StructureError> {
        self.beam.system(self.law.clone().map(|law| (law, self.normal_load)))
    }

    /// The same under the load as it swings, and from the offset. The contact is the first of the beam's elements.
    pub fn assembly(&self) -> Result<Assembly, StructureError> {
        const CONTACT: usize = 0;
        let mut assembly = Assembly::new(self.system()?);
        assembly.load_swings.push((CONTACT, self.load_swing.clone()));
        assembly.static_offsets.push((CONTACT, self.offset));
        Ok(assembly)
    }
}
