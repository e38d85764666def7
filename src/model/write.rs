//! From a [`Model`] to the text of a `model.toml`.

use super::text::{line, quoted, write_quantity};
use super::{Beam, Contact, Damping, Model, SCHEMA, Structure, effects};
use crate::vocabulary as v;

impl Model {
    /// The text of the model's file. [`Model::parse`] reads the same model from it, to the last bit of
    /// every number.
    ///
    /// ```
    /// use stickslip::model::Model;
    /// let mut model = Model::parse(
    ///     r#"
    ///     schema = "stickslip.model/1"
    ///     kind = "contact"
    ///     contact = { law = "jenkins", tangential_stiffness = 2e3, friction_coefficient = 0.1, normal_load = 10.0 }
    ///     "#,
    /// )?;
    /// model.set("contact.friction_coefficient", 1.0 / 3.0)?;
    /// assert_eq!(Model::parse(&model.to_toml())?, model);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn to_toml(&self) -> String {
        let mut text = String::new();
        line(&mut text, format_args!("schema = \"{SCHEMA}\""));
        match &self.structure {
            Structure::Prescribed => line(&mut text, format_args!("kind = \"contact\"")),
            Structure::Beam(beam) => {
                line(&mut text, format_args!("kind = \"beam\""));
                write_beam(&mut text, beam);
                line(&mut text, format_args!("\n[support]"));
                write_quantity(&mut text, &v::OFFSET, beam.offset);
                if beam.rotational_stiffness != 0.0 {
                    write_quantity(&mut text, &v::ROTATIONAL_STIFFNESS, beam.rotational_stiffness);
                }
                if let Some(stiffness) = beam.clamp_stiffness {
                    write_quantity(&mut text, &v::CLAMP_STIFFNESS, stiffness);
                }
                write_places(&mut text, beam);
            }
            Structure::PinRig(pinned) => {
                line(&mut text, format_args!("kind = \"pin_rig\""));
                write_beam(&mut text, &pinned.beam);
                pinned.write(&mut text);
                if let Some(stiffness) = pinned.beam.clamp_stiffness {
                    line(&mut text, format_args!("\n[support]"));
                    write_quantity(&mut text, &v::CLAMP_STIFFNESS, stiffness);
                }
                write_places(&mut text, &pinned.beam);
            }
            Structure::Oscillator(oscillator) => {
                line(&mut text, format_args!("kind = \"oscillator\""));
                oscillator.write(&mut text);
            }
        }
        if let Some(contact) = &self.contact {
            let at = match &self.structure {
                Structure::Oscillator(oscillator) => oscillator.contact_name(),
                Structure::Prescribed | Structure::Beam(_) | Structure::PinRig(_) => None,
            };
            write_contact(&mut text, contact, at);
        }
        effects::write(&mut text, &self.effects);
        if let Some(free) = &self.free {
            let patterns: Vec<_> = free.iter().map(|pattern| quoted(pattern)).collect();
            line(&mut text, format_args!("\n[fit]\nfree = [{}]", patterns.join(", ")));
        }
        text
    }
}

fn write_contact(text: &mut String, contact: &Contact, at: Option<&str>) {
    line(text, format_args!("\n[contact]"));
    if let Some(mass) = at {
        line(text, format_args!("at = {}", quoted(mass)));
    }
    line(text, format_args!("law = \"{}\"", contact.law.kind.name));
    write_quantity(text, &v::TANGENTIAL_STIFFNESS, contact.tangential_stiffness);
    write_quantity(text, &v::FRICTION_COEFFICIENT, contact.friction_coefficient);
    write_quantity(text, &v::NORMAL_LOAD, contact.normal_load);
    for (parameter, value) in contact.law.parameters() {
        write_quantity(text, parameter.quantity, value);
    }
    if contact.normal_stiffness != 0.0 {
        write_quantity(text, &v::NORMAL_STIFFNESS, contact.normal_stiffness);
    }
    if let Some(normal) = &contact.normal {
        normal.write(text);
    }
}

/// Whether its sensors are where its masses are.
fn sensors_as_masses(beam: &Beam) -> bool {
    beam.sensors.iter().eq(beam.point_masses.iter().map(|mass| &mass.position))
}

fn write_beam(text: &mut String, beam: &Beam) {
    if beam.sensors.is_empty() && !sensors_as_masses(beam) {
        // Without this line the sensors would be where the masses are.
        line(text, format_args!("sensor = []"));
    }
    line(text, format_args!("\n[beam]"));
    write_quantity(text, &v::LENGTH, beam.length);
    write_quantity(text, &v::WIDTH, beam.width);
    write_quantity(text, &v::THICKNESS, beam.thickness);
    write_quantity(text, &v::DENSITY, beam.density);
    write_quantity(text, &v::YOUNGS_MODULUS, beam.youngs_modulus);
    line(text, format_args!("modes = {}", beam.modes));
    if beam.static_correction {
        line(text, format_args!("static_correction = true"));
    }
    match &beam.damping {
        Damping::Uniform(ratio) => write_quantity(text, &v::DAMPING_RATIO, *ratio),
        Damping::PerMode(ratios) => line(text, format_args!("damping_ratio = {ratios:?}")),
        Damping::Proportional { mass, stiffness } => {
            write_quantity(text, &v::MASS_DAMPING, *mass);
            write_quantity(text, &v::STIFFNESS_DAMPING, *stiffness);
        }
    }
    for mass in &beam.point_masses {
        line(text, format_args!("\n[[beam.point_mass]]"));
        write_quantity(text, &v::POSITION, mass.position);
        write_quantity(text, &v::MASS, mass.mass);
    }
}

/// Where it is excited, measured and pushed.
fn write_places(text: &mut String, beam: &Beam) {
    line(text, format_args!("\n[excitation]"));
    write_quantity(text, &v::POSITION, beam.excitation_position);
    if !sensors_as_masses(beam) {
        for position in &beam.sensors {
            line(text, format_args!("\n[[sensor]]"));
            write_quantity(text, &v::POSITION, *position);
        }
    }
    for position in &beam.contact_points {
        line(text, format_args!("\n[[contact_point]]"));
        write_quantity(text, &v::POSITION, *position);
    }
}
