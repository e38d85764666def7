//! Parameters by path, with the bounds and the scale for a fit.
//!
//! Paths follow the file: `contact.smoothness`, `beam.damping_ratio` (one for all modes) or
//! `beam.damping_ratio.3` (the third mode's), `beam.point_mass.1.mass`, `support.offset`, `mass.1.mass`,
//! `spring.2.stiffness`, `effect.1.half_gap`. Elements are counted from 1. Positions of sensors and contact points are no parameters.

use super::error::ParameterError;
use super::slots::Value;
use super::{Beam, Model};
use crate::document::suggestion;
use crate::vocabulary::{self as v, Quantity, Scale};

/// One number of a model that may be read, set, or fitted.
#[derive(Debug, Clone, PartialEq)]
pub struct ModelParameter {
    /// Path in the model file: `contact.tangential_stiffness`.
    pub path: String,
    /// Name, unit and meaning.
    pub quantity: &'static Quantity,
    /// Value in the quantity's unit.
    pub value: f64,
    /// Smallest value a fit should try, at or below `value`.
    pub lower: f64,
    /// Largest value a fit should try, at or above `value`.
    pub upper: f64,
    /// How a fit should step.
    pub scale: Scale,
    /// Whether a fit may change it.
    pub free: bool,
}

impl Model {
    /// Every parameter, in the file's order.
    ///
    /// Free without `[fit] free` are the contact's parameters, those of the effects, the damping, a beam's Young's
    /// modulus, and the support's rotational stiffness and clamp stiffness where the model has them, and the springs
    /// and dampers of an oscillator that are not zero; geometry, density and masses are not. The normal load is
    /// never free unless `[fit] free` names it literally
    /// (`contact.normal_load`): as long as the load is constant only its product with the coefficient
    /// of friction acts, and a fit of both has no unique answer.
    ///
    /// Bounds are physical (a smoothness up to 0.98, a residual stiffness up to 0.9 of the tangential
    /// one), widened to include the present value. Each bound alone is a legal value; where two
    /// parameters are joined (residual and tangential stiffness), a fit of both can still ask for a
    /// pair that [`Model::set_all`] refuses.
    ///
    /// ```
    /// use stickslip::model::Model;
    /// # let text = "schema = \"stickslip.model/1\"\nkind = \"contact\"\n[contact]\nlaw = \"jenkins\"\n\
    /// #     tangential_stiffness = 2e3\nfriction_coefficient = 0.1\nnormal_load = 10.0";
    /// let model = Model::parse(text)?;
    /// let free: Vec<String> = model.parameters().into_iter().filter(|one| one.free).map(|one| one.path).collect();
    /// assert_eq!(free, ["contact.tangential_stiffness", "contact.friction_coefficient"]);
    /// # Ok::<(), stickslip::model::ModelError>(())
    /// ```
    pub fn parameters(&self) -> Vec<ModelParameter> {
        self.values()
            .into_iter()
            .map(|Value { path, quantity, value }| {
                let of_effect = path.starts_with("effect.");
                let (lower, upper, scale) = if of_effect {
                    super::effects::fit_range(quantity, value)
                } else {
                    self.fit_range(quantity, value)
                };
                let (lower, upper) = (lower.min(value), upper.max(value));
                let free = super::free::is_free(self, &path, value);
                ModelParameter { path, quantity, value, lower, upper, scale, free }
            })
            .collect()
    }

    /// The value at `path`, in SI; `None` when the model has no such parameter.
    pub fn get(&self, path: &str) -> Option<f64> {
        self.values().into_iter().find(|parameter| parameter.path == path).map(|parameter| parameter.value)
    }

    /// Sets the value at `path`, in SI. Setting `support.clamp_stiffness` on a rigidly clamped beam
    /// puts the rotational spring there.
    ///
    /// # Errors
    /// A path the model does not have, or a value that breaks a rule ([`Model::check`]); the model is
    /// then unchanged.
    ///
    /// ```
    /// use stickslip::model::Model;
    /// # let text = "schema = \"stickslip.model/1\"\nkind = \"contact\"\n[contact]\nlaw = \"jenkins\"\n\
    /// #     tangential_stiffness = 2e3\nfriction_coefficient = 0.1\nnormal_load = 10.0";
    /// let mut model = Model::parse(text)?;
    /// model.set("contact.normal_load", 20.0)?;
    /// assert_eq!(model.get("contact.normal_load"), Some(20.0));
    /// // What breaks a rule is refused, and the model stays as it was.
    /// assert!(model.set("contact.tangential_stiffness", -1.0).is_err());
    /// assert_eq!(model.get("contact.tangential_stiffness"), Some(2e3));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn set(&mut self, path: &str, value: f64) -> Result<(), ParameterError> {
        self.set_all(&[(path, value)])
    }

    /// Sets several values at once; rules that join parameters (residual stiffness below tangential
    /// stiffness) are checked after all of them.
    ///
    /// # Errors
    /// As [`Model::set`]; the model is then unchanged.
    pub fn set_all<P: AsRef<str>>(&mut self, values: &[(P, f64)]) -> Result<(), ParameterError> {
        let mut changed = self.clone();
        for (path, value) in values {
            changed.assign(path.as_ref(), *value)?;
        }
        changed.check_values()?;
        *self = changed;
        Ok(())
    }

    fn assign(&mut self, path: &str, value: f64) -> Result<(), ParameterError> {
        if let ("support.clamp_stiffness", Some(beam)) = (path, self.structure.beam_mut()) {
            beam.clamp_stiffness = Some(value);
            return Ok(());
        }
        if let Some((_, _, slot)) = self.slots().into_iter().find(|(name, _, _)| name == path) {
            *slot = value;
            return Ok(());
        }
        let paths: Vec<String> = self.values().into_iter().map(|parameter| parameter.path).collect();
        let paths: Vec<&str> = paths.iter().map(String::as_str).collect();
        Err(ParameterError::new(path, "the model has no such parameter").with_help(suggestion(
            path,
            &paths,
            "parameters",
        )))
    }

    /// Bounds and scale for a fit of `quantity`, starting at `value`.
    fn fit_range(&self, quantity: &Quantity, value: f64) -> (f64, f64, Scale) {
        use Scale::{Linear, Logarithmic};
        let tangential = self.contact.map_or(0.0, |contact| contact.tangential_stiffness);
        let residual = self.contact.map_or(0.0, |contact| contact.law.residual_stiffness());
        let beam = self.structure.beam();
        let (length, farthest) = beam.map_or((0.0, 0.0), |beam| (beam.length, beam.farthest_position()));
        if let Some(parameter) = self.contact.and_then(|contact| contact.law.kind.parameter(quantity.name)) {
            return (parameter.range)(tangential);
        }
        let (lower, upper, scale) = match quantity.name {
            "tangential_stiffness" => (f64::max(1.0, residual / 0.9), 1e12, Logarithmic),
            // Far beyond any coefficient: with an unknown load it stands for the whole friction limit.
            "friction_coefficient" => (1e-4, 1e4, Logarithmic),
            "damping_ratio" => (1e-6, 0.5, Logarithmic),
            "mass_damping" => (1e-6, 1e4, Logarithmic),
            "stiffness_damping" => (1e-12, 1.0, Logarithmic),
            "rotational_stiffness" => (1e-3, 1e9, Logarithmic),
            "clamp_stiffness" => (1e-1, 1e12, Logarithmic),
            "normal_load" => (value / 1e3, value * 1e3, Logarithmic),
            "stiffness" if value > 0.0 => (value / 1e3, value * 1e3, Logarithmic),
            "stiffness" => (0.0, 1e6, Linear),
            "damping" if value > 0.0 => (value / 1e3, value * 1e3, Logarithmic),
            "damping" => (0.0, 1e3, Linear),
            "mass" => (value / 10.0, value * 10.0, Logarithmic),
            "position" => (0.0, length, Linear),
            "length" if *quantity != v::STRING_LENGTH => {
                (farthest.max(value / 2.0), value * 2.0, Logarithmic)
            }
            "offset" | "tangential_lever" | "normal_lever" => {
                (-10.0 * value.abs(), 10.0 * value.abs(), Linear)
            }
            "normal_stiffness" if value > 0.0 => (value / 1e2, value * 1e2, Logarithmic),
            "normal_exponent" => (1.0, 2.0, Linear),
            name if name == v::IMPACT_DAMPING.name => (0.0, f64::max(1e3, 10.0 * value), Linear),
            "inertia" if value > 0.0 => (value / 10.0, value * 10.0, Logarithmic),
            "inertia" => (0.0, 1.0, Linear),
            // Geometry and material are known to better than a factor of two.
            _ => (value / 2.0, value * 2.0, Logarithmic),
        };
        // Where zero is legal and the value is there, a logarithm has no start.
        let (lower, scale) =
            if scale == Logarithmic && value <= 0.0 { (0.0, Linear) } else { (lower, scale) };
        (lower.min(value), upper.max(value), scale)
    }
}

impl Beam {
    /// The largest distance from the clamp at which anything sits: the beam cannot be shorter.
    fn farthest_position(&self) -> f64 {
        let masses = self.point_masses.iter().map(|mass| mass.position);
        let sensors = self.sensors.iter().chain(&self.contact_points).copied();
        masses.chain(sensors).fold(self.excitation_position, f64::max)
    }
}
