//! A model as the sensors of a record see it, and under the normal load that was measured.

use crate::harmonic::Assembly;
use crate::model::{Model, Structure};
use crate::system::{Element, System};

/// The system of `model`, a beam with sensors at `positions` (m), whatever sensors it lists.
pub(super) fn observed_system(model: &Model, positions: &[f64]) -> Result<System, String> {
    let mut model = model.clone();
    if let Some(beam) = model.structure.beam_mut() {
        beam.sensors = positions.to_vec();
        // Nothing is known of forces at contact points, and models of measurements have none.
        beam.contact_points.clear();
    }
    model.system().map_err(|error| error.to_string())
}

/// The same in a steady state under what the contact, the first of the elements, follows of the measured normal load with
/// the coefficients `load` (N), if there is one. The contact that never moved has no force at the displacement `offset` (m).
pub(super) fn observed_assembly(
    model: &Model,
    positions: &[f64],
    load: Option<&[f64]>,
    offset: f64,
) -> Result<Assembly, String> {
    const CONTACT: usize = 0;
    let mut assembly = Assembly::new(observed_system(model, positions)?);
    // A contact in two directions makes its load itself.
    if let Structure::PinRig(_) = model.structure {
        return Ok(assembly);
    }
    let joint = model.changes().joint;
    if let Some(Element::Law { normal_load, .. }) =
        assembly.system.elements.first_mut().filter(|_| model.contact.is_some())
    {
        *normal_load = joint.normal_load(*normal_load, load.map(|load| load[0]));
    }
    let gain = joint.load_gain.filter(|gain| *gain != 0.0);
    if let (Some(gain), Some([_, swing @ ..])) = (gain, load)
        && swing.iter().any(|x| *x != 0.0)
    {
        assembly.load_swings.push((CONTACT, swing.iter().map(|x| gain * x).collect()));
    }
    if offset != 0.0 {
        assembly.static_offsets.push((CONTACT, offset));
    }
    Ok(assembly)
}
