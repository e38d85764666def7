//! The one list of a model's numbers: path, quantity and place of each, in the file's order.

use super::{Beam, Damping, Model, Oscillator, PinnedBeam, Structure};
use crate::effects::AppliedEffect;
use crate::vocabulary::{self as v, Quantity};

/// A parameter without its role in a fit.
pub(super) struct Value {
    pub(super) path: String,
    pub(super) quantity: &'static Quantity,
    pub(super) value: f64,
}

/// Path, quantity and place of a parameter.
pub(super) type Slot<'a> = (String, &'static Quantity, &'a mut f64);

impl Model {
    /// Every parameter with its value.
    pub(super) fn values(&self) -> Vec<Value> {
        // The one walk over the parameters lends them mutably; reading pays for a copy of the model.
        self.clone()
            .slots()
            .into_iter()
            .map(|(path, quantity, slot)| Value { path, quantity, value: *slot })
            .collect()
    }

    /// The one list of parameters: path, quantity and place.
    pub(super) fn slots(&mut self) -> Vec<Slot<'_>> {
        let mut slots = Vec::new();
        match &mut self.structure {
            Structure::Prescribed => {}
            Structure::Beam(beam) => {
                let Rest { offset, rotational, clamp, excitation } = beam_slots(beam, &mut slots);
                slots.push(("support.offset".to_owned(), &v::OFFSET, offset));
                slots.push(("support.rotational_stiffness".to_owned(), &v::ROTATIONAL_STIFFNESS, rotational));
                clamp_and_excitation(clamp, excitation, &mut slots);
            }
            Structure::PinRig(PinnedBeam { beam, pin, string, outside }) => {
                let Rest { offset, clamp, excitation, .. } = beam_slots(beam, &mut slots);
                PinnedBeam::slots(pin, string, outside, offset, &mut slots);
                clamp_and_excitation(clamp, excitation, &mut slots);
            }
            Structure::Oscillator(oscillator) => oscillator_slots(oscillator, &mut slots),
        }
        if let Some(contact) = &mut self.contact {
            let mut add = |quantity: &'static Quantity, slot| {
                slots.push((format!("contact.{}", quantity.name), quantity, slot));
            };
            add(&v::TANGENTIAL_STIFFNESS, &mut contact.tangential_stiffness);
            add(&v::FRICTION_COEFFICIENT, &mut contact.friction_coefficient);
            add(&v::NORMAL_LOAD, &mut contact.normal_load);
            for (parameter, value) in contact.law.kind.parameters.iter().zip(contact.law.values_mut()) {
                add(parameter.quantity, value);
            }
            if contact.normal_stiffness != 0.0 || contact.normal.is_some() {
                add(&v::NORMAL_STIFFNESS, &mut contact.normal_stiffness);
            }
            if let Some(normal) = &mut contact.normal {
                normal.slots(&mut slots);
            }
        }
        effect_slots(&mut self.effects, &mut slots);
        slots
    }
}

/// Places of a beam whose paths depend on the structure.
struct Rest<'a> {
    offset: &'a mut f64,
    rotational: &'a mut f64,
    clamp: Option<&'a mut f64>,
    excitation: &'a mut f64,
}

fn clamp_and_excitation<'a>(clamp: Option<&'a mut f64>, excitation: &'a mut f64, slots: &mut Vec<Slot<'a>>) {
    slots.extend(clamp.map(|clamp| ("support.clamp_stiffness".to_owned(), &v::CLAMP_STIFFNESS, clamp)));
    slots.push(("excitation.position".to_owned(), &v::POSITION, excitation));
}

/// Adds the parameters of the beam and its masses to `slots`; returns the others.
fn beam_slots<'a>(beam: &'a mut Beam, slots: &mut Vec<Slot<'a>>) -> Rest<'a> {
    let mut add = |table: &str, quantity: &'static Quantity, slot| {
        slots.push((format!("{table}.{}", quantity.name), quantity, slot));
    };
    add("beam", &v::LENGTH, &mut beam.length);
    add("beam", &v::WIDTH, &mut beam.width);
    add("beam", &v::THICKNESS, &mut beam.thickness);
    add("beam", &v::DENSITY, &mut beam.density);
    add("beam", &v::YOUNGS_MODULUS, &mut beam.youngs_modulus);
    let damping: Vec<Slot<'_>> = match &mut beam.damping {
        Damping::Uniform(ratio) => vec![(String::new(), &v::DAMPING_RATIO, ratio)],
        Damping::PerMode(ratios) => ratios
            .iter_mut()
            .enumerate()
            .map(|(index, ratio)| (format!(".{}", index + 1), &v::DAMPING_RATIO, ratio))
            .collect(),
        Damping::Proportional { mass, stiffness } => {
            vec![(String::new(), &v::MASS_DAMPING, mass), (String::new(), &v::STIFFNESS_DAMPING, stiffness)]
        }
    };
    for (suffix, quantity, slot) in damping {
        slots.push((format!("beam.{}{suffix}", quantity.name), quantity, slot));
    }
    let mut add = |table: &str, quantity: &'static Quantity, slot| {
        slots.push((format!("{table}.{}", quantity.name), quantity, slot));
    };
    for (index, mass) in beam.point_masses.iter_mut().enumerate() {
        let table = format!("beam.point_mass.{}", index + 1);
        add(&table, &v::POSITION, &mut mass.position);
        add(&table, &v::MASS, &mut mass.mass);
    }
    Rest {
        offset: &mut beam.offset,
        rotational: &mut beam.rotational_stiffness,
        clamp: beam.clamp_stiffness.as_mut(),
        excitation: &mut beam.excitation_position,
    }
}

/// Adds the oscillator's parameters to `slots`.
fn oscillator_slots<'a>(oscillator: &'a mut Oscillator, slots: &mut Vec<Slot<'a>>) {
    for (index, mass) in oscillator.masses.iter_mut().enumerate() {
        slots.push((format!("mass.{}.mass", index + 1), &v::MASS, &mut mass.mass));
    }
    for (index, spring) in oscillator.springs.iter_mut().enumerate() {
        let place = format!("spring.{}", index + 1);
        slots.push((format!("{place}.stiffness"), &v::STIFFNESS, &mut spring.stiffness));
        slots.push((format!("{place}.damping"), &v::DAMPING, &mut spring.damping));
    }
}

/// Adds the parameters of `effects` to `slots`.
fn effect_slots<'a>(effects: &'a mut [AppliedEffect], slots: &mut Vec<Slot<'a>>) {
    for (number, applied) in effects.iter_mut().enumerate() {
        let quantities: Vec<_> = (0..applied.values.len()).map(|index| applied.quantity(index)).collect();
        for (quantity, value) in quantities.into_iter().zip(&mut applied.values) {
            slots.push((format!("effect.{}.{}", number + 1, quantity.name), quantity, value));
        }
    }
}
