//! A model as the sensors of a record see it, and under the normal load that was measured.

use crate::harmonic::Assembly;
use crate::model::{Beam, Model, Structure};
use crate::system::{Element, ModalBeam, StructureChanges, System};

/// The system of `model`, a beam with sensors at `positions` (m), whatever sensors it lists.
pub(super) fn observed_system(model: &Model, positions: &[f64]) -> Result<System, String> {
    let mut model = model.clone();
    if let Some(beam) = model.structure.beam_mut() {
        *beam = observed_beam(beam, positions);
    }
    model.system().map_err(|error| error.to_string())
}

fn observed_beam(beam: &Beam, positions: &[f64]) -> Beam {
    // Nothing is known of forces at contact points, and models of measurements have none.
    Beam { sensors: positions.to_vec(), contact_points: Vec::new(), ..beam.clone() }
}

/// A beam that sensors see, reduced to its modes.
pub(super) struct ObservedBeam {
    /// Of the sensors (m).
    positions: Vec<f64>,
    last: Option<Reduced>,
}

/// Modes, and what they were found of.
struct Reduced {
    beam: Beam,
    changes: StructureChanges,
    modal: ModalBeam,
}

impl ObservedBeam {
    pub fn new(positions: Vec<f64>) -> Self {
        Self { positions, last: None }
    }

    /// Finds the modes of `model`, and keeps them until those of another beam are asked for here.
    pub fn reduce(&mut self, model: &Model) -> Result<(), String> {
        if let Structure::Beam(beam) = &model.structure
            && self.known(model).is_none()
        {
            let changes = model.changes().structure;
            let modal = ModalBeam::with_changes(&observed_beam(beam, &self.positions), &changes);
            let modal = modal.map_err(|error| error.to_string())?;
            self.last = Some(Reduced { beam: beam.clone(), changes, modal });
        }
        Ok(())
    }

    /// As [`observed_system`]; by the modes that are kept where `model` differs in its contact alone.
    pub fn system(&self, model: &Model) -> Result<System, String> {
        match self.known(model) {
            Some(modal) => model.system_on(modal).map_err(|error| error.to_string()),
            None => observed_system(model, &self.positions),
        }
    }

    fn known(&self, model: &Model) -> Option<&ModalBeam> {
        let Structure::Beam(beam) = &model.structure else { return None };
        let last = self.last.as_ref()?;
        (last.beam == *beam && last.changes == model.changes().structure).then_some(&last.modal)
    }
}

/// `system`, that of `model`, in a steady state under what the contact, the first of the elements, follows of the measured
/// normal load with the coefficients `load` (N), if there is one. The contact that never moved has no force at the displacement `offset` (m).
pub(super) fn observed_assembly(
    system: System,
    model: &Model,
    load: Option<&[f64]>,
    offset: f64,
) -> Assembly {
    const CONTACT: usize = 0;
    let mut assembly = Assembly::new(system);
    // A contact in two directions makes its load itself.
    if let Structure::PinRig(_) = model.structure {
        return assembly;
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
    assembly
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fit::predict::steady::tests::model as beam;
    use crate::system::Core;

    /// Frequencies and damping ratios of the modes, and those of the ports' shapes.
    fn modes(system: &System) -> (Core, Vec<Vec<(usize, f64)>>) {
        (system.core.clone(), system.ports.iter().map(|port| port.row.clone()).collect())
    }

    #[test]
    fn kept_modes_serve_as_long_as_nothing_but_the_contact_changes() {
        let model = beam("");
        let mut kept = ObservedBeam::new(vec![0.3]);
        kept.reduce(&model).unwrap();
        let mut changed = vec![model.clone()];
        for path in [
            "contact.tangential_stiffness",
            "contact.normal_load",
            "beam.youngs_modulus",
            "beam.damping_ratio",
        ] {
            let mut there = model.clone();
            there.set(path, 1.1 * model.get(path).unwrap()).unwrap();
            changed.push(there);
        }
        for effect in
            ["id = \"backlash\", half_gap = 1e-6", "id = \"geometric_stiffening\", cubic_stiffness = 2e9"]
        {
            changed.push(beam(&format!("effect = [{{ {effect} }}]")));
        }
        let is_kept = changed.iter().map(|there| kept.known(there).is_some());
        assert_eq!(is_kept.collect::<Vec<_>>(), [true, true, true, false, false, true, false]);
        for there in &changed {
            let [here, anew] = [kept.system(there).unwrap(), observed_system(there, &[0.3]).unwrap()];
            assert_eq!(modes(&here), modes(&anew));
            assert_eq!(format!("{:?}", here.elements), format!("{:?}", anew.elements));
            assert_eq!(
                (here.shortening, here.driven, here.sensors),
                (anew.shortening, anew.driven, anew.sensors)
            );
        }
        // Another beam takes the place of the last.
        let stiffer = &changed[3];
        kept.reduce(stiffer).unwrap();
        assert!(kept.known(stiffer).is_some() && kept.known(&model).is_none());
        assert_eq!(modes(&kept.system(&model).unwrap()), modes(&observed_system(&model, &[0.3]).unwrap()));
    }
}
