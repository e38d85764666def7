//! Where a response curve may turn sharply: the resonances of the linear structure, its contacts free and at rest.

use crate::contact::{ContactLaw, Inputs};
use crate::harmonic::balance::assembly::Assembly;
use crate::harmonic::balance::modal::Ports;
use crate::harmonic::continuation::LinearResonance;
use crate::system::{Element, LinearStructure, System};

/// Structures beyond this size have no linear_resonances: their modes take longer than the curve.
const LARGEST: usize = 200;
/// Damping ratios below this are rounding: an undamped resonance itself has no response to look at.
const SHARPEST: f64 = 1e-9;
/// Entries of the waveform below this fraction of the largest excite nothing.
const SILENT: f64 = 1e-12;

/// The linear_resonances of `assembly`, ascending: one resonance that is nowhere near a point of a curve leaves no trace in
/// its neighbours, however sharp. None for structures too large, or without natural modes.
pub(crate) fn linear_resonances(assembly: &Assembly) -> Vec<LinearResonance> {
    let mut structure = with_contacts(assembly);
    if structure.size > LARGEST {
        return Vec::new();
    }
    let mut found = resonances(&structure);
    if !structure.contacts.is_empty() {
        structure.stiffness.extend(structure.along_contacts(at_rest(&assembly.system)));
        found.extend(resonances(&structure));
    }
    let mut all: Vec<LinearResonance> =
        excited(&assembly.waveform).flat_map(|order| found.iter().map(move |one| one.over(order))).collect();
    all.sort_by(|a, b| a.angular_frequency.total_cmp(&b.angular_frequency));
    all.dedup_by(|next, kept| next.angular_frequency - kept.angular_frequency < 0.1 * kept.half_width);
    all
}

/// The linear part, with the places of its contacts as [`at_rest`] counts them; without any, that of the first port.
pub(crate) fn with_contacts(assembly: &Assembly) -> LinearStructure {
    let system = &assembly.system;
    let mut structure = system.linear_part();
    for element in &system.elements {
        if let Element::SlipSlap { ports, .. } = element {
            structure.contacts.extend(ports.map(|port| system.ports[port].row.clone()));
        }
    }
    if !assembly.is_condensed() && structure.contacts.is_empty() {
        structure.contacts.push(Ports::of(system).contact().row.clone());
    }
    structure
}

/// Orders of the harmonics that excite.
fn excited(waveform: &[f64]) -> impl Iterator<Item = f64> + '_ {
    let largest = waveform.iter().fold(0.0_f64, |most, f| most.max(f.abs()));
    let pairs = waveform.get(1..).unwrap_or(&[]).chunks(2).enumerate();
    pairs
        .filter(move |(_, pair)| pair.iter().any(|f| f.abs() > SILENT * largest))
        .map(|(place, _)| (place + 1) as f64)
}

fn resonances(structure: &LinearStructure) -> Vec<LinearResonance> {
    let Ok(modes) = structure.natural_modes() else { return Vec::new() };
    let with_shapes = modes.angular_frequency.iter().zip(modes.shapes.column_iter());
    let resonance = with_shapes.map(|(frequency, shape)| {
        let rate: f64 = structure.damping.iter().map(|(i, j, c)| shape[*i] * c * shape[*j]).sum();
        LinearResonance { angular_frequency: *frequency, half_width: 0.5 * rate }
    });
    resonance.filter(|one| one.half_width > SHARPEST * one.angular_frequency).collect()
}

/// Slopes (N/m) of the laws' forces at rest, each behind the flexibility of its port; then those of contacts in two directions, along
/// and across.
pub(crate) fn at_rest(system: &System) -> impl Iterator<Item = f64> {
    let system = system.expanded();
    let slip_slaps = system.elements.iter().flat_map(|element| match element {
        Element::SlipSlap { contact, .. } => {
            let normal = contact.normal();
            vec![tangent_stiffness(contact.law().as_ref(), normal.preload()), normal.stiffness()]
        }
        _ => Vec::new(),
    });
    let laws = system.laws().map(|(port, law, normal_load)| {
        let stiffness = tangent_stiffness(law.as_ref(), normal_load);
        stiffness / (1.0 + system.ports[port].flexibility * stiffness)
    });
    laws.chain(slip_slaps).collect::<Vec<f64>>().into_iter()
}

/// Slope (N/m) of the force of a contact at rest that remembers nothing.
fn tangent_stiffness(law: &dyn ContactLaw, normal_load: f64) -> f64 {
    let (mut state, mut next) = (vec![0.0; law.state_len()], vec![0.0; law.state_len()]);
    law.set_state(0.0, normal_load, 0.0, &mut state);
    let inputs = Inputs { displacement: 0.0, velocity: 0.0, normal_load };
    law.step(&state, inputs, &mut next).tangents.displacement
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::Model;
    use std::f64::consts::TAU;

    #[test]
    fn contacts_in_two_directions_are_among_the_linear_resonances_at_rest() {
        let model =
            Model::parse(include_str!("../../../examples/slip-slap/model.toml")).expect("the example");
        let found = linear_resonances(&Assembly::new(model.system().expect("a pin rig")));
        // Frequencies (Hz) of the exact determinant of this rig, its pin bonded.
        for reference in [52.7873, 164.4231, 335.8551] {
            let apart = |one: &LinearResonance| (one.angular_frequency / TAU / reference - 1.0).abs();
            let nearest = found.iter().map(apart).fold(f64::INFINITY, f64::min);
            assert!(nearest < 1e-3, "none within {nearest} of {reference} Hz");
        }
    }
}
