//! What happens to a value on its way from an output to an input.

use crate::units::{Linear, Unit, UnitMismatch};

/// The way of a value through one or several connections.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Route {
    /// The unit that the first connector declares.
    pub(super) first: Option<Unit>,
    /// One connection after the other.
    pub(super) hops: Vec<Hop>,
}

/// One connection.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Hop {
    /// Whether units are converted.
    pub(super) converts: bool,
    /// After the conversion.
    pub(super) transformation: Linear,
    /// The transformation is one of truths.
    pub(super) booleans: bool,
    /// The unit that the connector at its end declares.
    pub(super) unit: Option<Unit>,
}

impl Route {
    /// Whether a mapping of truths is on the way, which has no meaning for other values.
    pub fn maps_booleans(&self) -> bool {
        self.hops.iter().any(|hop| hop.booleans)
    }

    /// The unit at its end, as far as connectors declare one.
    pub fn unit(&self) -> Option<&Unit> {
        self.hops.iter().rev().find_map(|hop| hop.unit.as_ref()).or(self.first.as_ref())
    }

    /// A value of the output, whose variable has the unit `from`, as a value of the input, whose variable has the
    /// unit `to`; absent where an FMU declares none.
    ///
    /// Units are converted first, and linear transformations applied to what comes out, as SSP says. Connectors
    /// without a unit take what comes. A connector that declares another unit than its variable is converted, too.
    ///
    /// # Errors
    /// Units that cannot be converted.
    pub fn linear(&self, from: Option<&Unit>, to: Option<&Unit>) -> Result<Linear, UnitMismatch> {
        let mut whole = Linear::IDENTITY;
        let mut unit = from.cloned();
        converted(&mut whole, &mut unit, self.first.as_ref())?;
        let last = self.hops.len().saturating_sub(1);
        for (index, hop) in self.hops.iter().enumerate() {
            // At the last connector, its variable's unit counts where it declares none itself.
            let own = hop.unit.as_ref().or(if index == last { to } else { None });
            if hop.converts {
                converted(&mut whole, &mut unit, own)?;
            } else if own.is_some() {
                unit = own.cloned();
            }
            whole = whole.then(hop.transformation);
        }
        converted(&mut whole, &mut unit, to)?;
        Ok(whole)
    }
}

/// Goes on in the unit `to`, if that is known.
fn converted(whole: &mut Linear, unit: &mut Option<Unit>, to: Option<&Unit>) -> Result<(), UnitMismatch> {
    if let Some(to) = to {
        if let Some(from) = unit {
            *whole = whole.then(from.conversion(to)?);
        }
        *unit = Some(to.clone());
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn length(name: &str, factor: f64) -> Unit {
        Unit { name: name.to_owned(), exponents: Some([0, 1, 0, 0, 0, 0, 0, 0]), factor, offset: 0.0 }
    }

    fn hop(converts: bool, factor: f64, offset: f64, unit: Option<Unit>) -> Hop {
        Hop { converts, transformation: Linear { factor, offset }, booleans: false, unit }
    }

    #[test]
    fn units_are_converted_before_the_linear_transformation() {
        let route = Route { first: None, hops: vec![hop(true, 2.0, 1.0, None)] };
        let whole = route.linear(Some(&length("m", 1.0)), Some(&length("mm", 1e-3))).unwrap();
        // 0.003 m are 3 mm; twice that and 1 mm more.
        assert!((whole.apply(0.003) - 7.0).abs() < 1e-12);
    }

    #[test]
    fn without_conversion_the_numbers_stay() {
        let route = Route { first: None, hops: vec![hop(false, 1.0, 0.0, None)] };
        let whole = route.linear(Some(&length("m", 1.0)), Some(&length("mm", 1e-3))).unwrap();
        assert_eq!(whole, Linear::IDENTITY);
    }

    #[test]
    fn a_chain_converts_as_its_ends_do() {
        let (metre, millimetre, micrometre) = (length("m", 1.0), length("mm", 1e-3), length("um", 1e-6));
        let through = Route {
            first: Some(metre.clone()),
            hops: vec![
                hop(true, 1.0, 0.0, Some(micrometre)),
                hop(true, 1.0, 0.0, None),
                hop(true, 1.0, 0.0, None),
            ],
        };
        let whole = through.linear(Some(&metre), Some(&millimetre)).unwrap();
        assert!((whole.apply(0.5) - 500.0).abs() < 1e-9);
    }
}
