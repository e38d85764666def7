//! The rules a model keeps, whether it was read from a file, built in code or changed by a fit.

use super::error::ParameterError;
use super::slots::Value;
use super::{Beam, Contact, Damping, Model, Structure};
use crate::contact::LawRule;
use crate::vocabulary::{self, Quantity};

/// Magnitudes outside this range are refused: no physical parameter in SI units has them, and
/// products of a few of them would overflow.
pub const SMALLEST_AND_LARGEST: (f64, f64) = (1e-30, 1e30);

impl Model {
    /// Checks every rule: bounds, counts, positions on the beam, names and references of masses, and that each free path means something.
    ///
    /// # Errors
    /// The first rule that is broken.
    pub fn check(&self) -> Result<(), ParameterError> {
        self.check_values()?;
        super::free::check_patterns(self)
    }

    /// The rules that a change of a parameter's value can break.
    pub(super) fn check_values(&self) -> Result<(), ParameterError> {
        // Before the bounds: a law's own message about its parameters is clearer.
        self.contact.as_ref().map_or(Ok(()), check_law)?;
        let law = self.contact.map(|contact| contact.law.kind);
        self.check_normal()?;
        for Value { path, quantity, value } in self.values() {
            let of_law = law.and_then(|law| law.parameter(quantity.name));
            let includes_min = of_law.is_some_and(|parameter| parameter.includes_min);
            check_value(&path, quantity, includes_min, value)?;
        }
        match (&self.structure, &self.contact) {
            (Structure::Prescribed, None) => {
                return Err(ParameterError::new("contact", "a model of kind \"contact\" needs [contact]"));
            }
            (Structure::Beam(beam), _) => check_beam(beam)?,
            (Structure::PinRig(pinned), _) => check_beam(&pinned.beam).and_then(|()| pinned.check(self))?,
            (Structure::Oscillator(oscillator), contact) => oscillator.check(contact.is_some())?,
            (Structure::Prescribed, Some(_)) => {}
        }
        super::effects::check(self)
    }
}

/// Checks `value` against the bounds of `quantity`, of which open ones may include the smallest value, and of sense.
fn check_value(
    path: &str,
    quantity: &Quantity,
    includes_min: bool,
    value: f64,
) -> Result<(), ParameterError> {
    let (smallest, largest) = SMALLEST_AND_LARGEST;
    let name = quantity.name;
    if !value.is_finite() {
        return Err(ParameterError::new(path, format!("`{name}` must be a finite number")));
    }
    // A contact that is never loaded is no contact.
    let open_below = quantity.open && !includes_min;
    let (min, open_below) =
        if *quantity == vocabulary::NORMAL_LOAD { (Some(0.0), true) } else { (quantity.min, open_below) };
    let above = min.is_none_or(|min| if open_below { value > min } else { value >= min });
    let below = quantity.max.is_none_or(|max| if quantity.open { value < max } else { value <= max });
    if !(above && below) {
        let message = format!("`{name}` must be {}, not {value}", allowed(quantity, min, open_below));
        return Err(ParameterError::new(path, message).with_help(quantity.description));
    }
    if value.abs() > largest || (open_below && value.abs() < smallest) {
        let message = format!("`{name}` = {value:e} is beyond any physical magnitude");
        return Err(ParameterError::new(path, message).with_help(format!("the unit is {}", quantity.unit)));
    }
    Ok(())
}

fn allowed(quantity: &Quantity, min: Option<f64>, open_below: bool) -> String {
    let lower = min.map(|min| format!("{} {min}", if open_below { "above" } else { "at least" }));
    let upper = quantity.max.map(|max| format!("{} {max}", if quantity.open { "below" } else { "at most" }));
    [lower, upper].into_iter().flatten().collect::<Vec<_>>().join(" and ")
}

/// The law's own rules, for finite numbers.
fn check_law(contact: &Contact) -> Result<(), ParameterError> {
    let stiffness = contact.tangential_stiffness;
    if !(stiffness > 0.0 && contact.law.values().iter().all(|value| value.is_finite())) {
        return Ok(());
    }
    match contact.law.refuses(stiffness, contact.friction_coefficient) {
        Some(LawRule { parameter, message, help }) => {
            Err(ParameterError::new(format!("contact.{parameter}"), message).with_help(help))
        }
        None => Ok(()),
    }
}

fn check_beam(beam: &Beam) -> Result<(), ParameterError> {
    let (fewest, most) = (1, 40);
    if !(fewest..=most).contains(&beam.modes) {
        let message = format!("`modes` must be at least {fewest} and at most {most}, not {}", beam.modes);
        return Err(ParameterError::new("beam.modes", message));
    }
    if let Damping::PerMode(ratios) = &beam.damping
        && ratios.len() != beam.modes
    {
        let message = format!("{} damping ratios for {} modes", ratios.len(), beam.modes);
        return Err(ParameterError::new("beam.damping_ratio", message)
            .with_help("give one number for all modes, or as many as `modes` says"));
    }
    let on_beam = |path: String, position: f64| {
        if (0.0..=beam.length).contains(&position) {
            return Ok(());
        }
        let message =
            format!("position {position} m is not on the beam, which runs from 0 to {} m", beam.length);
        Err(ParameterError::new(path, message))
    };
    for (index, mass) in beam.point_masses.iter().enumerate() {
        on_beam(format!("beam.point_mass.{}.position", index + 1), mass.position)?;
    }
    for (index, position) in beam.sensors.iter().enumerate() {
        on_beam(format!("sensor.{}.position", index + 1), *position)?;
    }
    for (index, position) in beam.contact_points.iter().enumerate() {
        let path = format!("contact_point.{}.position", index + 1);
        on_beam(path.clone(), *position)?;
        if [0.0, beam.length].contains(position) {
            let message = format!("a contact at {position} m does nothing: the beam does not move there");
            return Err(ParameterError::new(path, message)
                .with_help("the pin at the end has its contact already: leave it out of the list"));
        }
        if beam.contact_points[..index].contains(position) {
            return Err(ParameterError::new(path, format!("position {position} m is listed twice"))
                .with_help("variables are named after positions"));
        }
    }
    on_beam("excitation.position".to_owned(), beam.excitation_position)
}
