//! What decides between explanations: each number is a statement about the world before the data are seen, and none is fitted to
//! cases.

/// What a diagnosis takes for granted. Another value of one of them is another question put to the same records.
///
/// ```
/// use stickslip::diagnose::Assumptions;
/// let cautious = Assumptions::default().with("odds", 0.25)?;
/// assert_eq!(cautious.odds, 0.25);
/// assert!(Assumptions::default().with("patience", 1.0).is_err());
/// # Ok::<(), stickslip::diagnose::NotAssumed>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Assumptions {
    /// Prior standard deviation of the logarithm of a parameter of a contact or of damping: an engineer's guess.
    pub parameter_guess: f64,
    /// The same of masses, stiffnesses and moduli of a structure, which drawings tell.
    pub structure_guess: f64,
    /// Prior standard deviation of an effect's first parameter: the value that moves the prediction by this fraction of
    /// its root mean square, or, of what saturates below that, from which more of it moves it hardly more. What moves it by
    /// more was seen before anybody measured.
    pub effect_size: f64,
    /// Prior standard deviation of the logarithm of what is known in its order of magnitude alone: an effect's other
    /// parameters, and a noise that a discrepancy may stand beside. A factor of e.
    pub magnitude: f64,
    /// Prior standard deviation of the logarithm of a noise that is stated; of one that is seen in repeats or carried over
    /// from other records its standard error comes on top.
    pub stated_noise: f64,
    /// The same of an unknown noise, and of any noise below what was told, which may be a bound.
    pub unknown_noise: f64,
    /// An unknown noise is thought to be about this fraction of the channel's root mean square.
    pub usual_noise: f64,
    /// Prior odds of one more effect.
    pub odds: f64,
    /// A change of the prediction, as a fraction of a channel's root mean square, below which in every record an effect is not
    /// worth its name; the smallest size of a discrepancy.
    pub relevant: f64,
    /// Probability from which something is told as certain.
    pub certain: f64,
}

impl Default for Assumptions {
    fn default() -> Self {
        Self {
            parameter_guess: 0.3,
            structure_guess: 0.05,
            effect_size: 0.3,
            magnitude: 1.0,
            stated_noise: 0.1,
            unknown_noise: 2.0,
            usual_noise: 0.02,
            odds: 0.5,
            relevant: 0.01,
            certain: 0.95,
        }
    }
}

/// A name that no assumption has, or a value that it cannot have.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("`{name} = {value}` is no assumption: there are {}, all positive, `certain` between 0.5 and 1", names().join(", "))]
pub struct NotAssumed {
    /// As given.
    pub name: String,
    /// As given.
    pub value: f64,
}

fn names() -> Vec<&'static str> {
    Assumptions::default().named().map(|(name, _)| name).to_vec()
}

impl Assumptions {
    /// All of them by name.
    #[must_use]
    pub fn named(mut self) -> [(&'static str, f64); 10] {
        self.places().map(|(name, place)| (name, *place))
    }

    /// The same with another value of one.
    ///
    /// # Errors
    /// [`NotAssumed`].
    pub fn with(mut self, name: &str, value: f64) -> Result<Self, NotAssumed> {
        let legal = value.is_finite() && value > 0.0 && (name != "certain" || (0.5..1.0).contains(&value));
        let place = self.places().into_iter().find(|(known, _)| *known == name).map(|(_, place)| place);
        match place.filter(|_| legal) {
            Some(place) => *place = value,
            None => return Err(NotAssumed { name: name.to_owned(), value }),
        }
        Ok(self)
    }

    fn places(&mut self) -> [(&'static str, &mut f64); 10] {
        [
            ("parameter_guess", &mut self.parameter_guess),
            ("structure_guess", &mut self.structure_guess),
            ("effect_size", &mut self.effect_size),
            ("magnitude", &mut self.magnitude),
            ("stated_noise", &mut self.stated_noise),
            ("unknown_noise", &mut self.unknown_noise),
            ("usual_noise", &mut self.usual_noise),
            ("odds", &mut self.odds),
            ("relevant", &mut self.relevant),
            ("certain", &mut self.certain),
        ]
    }

    /// Log odds from which something is told as certain.
    pub(in crate::diagnose) fn certainty(&self) -> f64 {
        (self.certain / (1.0 - self.certain)).ln()
    }

    /// The largest that an unknown noise is thought to be, as a fraction of the channel: a deviation of its prior above the usual.
    pub(in crate::diagnose) fn largest_noise(&self) -> f64 {
        self.usual_noise * self.unknown_noise.exp()
    }

    /// Sizes of a discrepancy that are tried, as fractions of the channel: from what is relevant to all of it.
    pub(in crate::diagnose) fn discrepancies(&self) -> impl Iterator<Item = f64> {
        let steps = (-2.0 * self.relevant.log10()).round().max(1.0);
        let relevant = self.relevant;
        (0..=steps as usize).map(move |k| relevant.powf(1.0 - k as f64 / steps))
    }
}
