//! A root between two values of opposite sign.

/// A root between two values of opposite sign, by inverse quadratic interpolation where that is sure to help and
/// by halving elsewhere (Chandrupatla 1997).
pub(crate) struct Bracket {
    /// The value found last.
    pub latest: (f64, f64),
    /// The one of the other sign, and the one that was left.
    other: (f64, f64),
    left: Option<(f64, f64)>,
}

impl Bracket {
    /// Between `latest` and `other`, each a place and a value.
    pub fn new(latest: (f64, f64), other: (f64, f64)) -> Self {
        Self { latest, other, left: None }
    }

    /// Where to look next.
    pub fn next(&self) -> f64 {
        let ((a, fa), (b, fb)) = (self.latest, self.other);
        let fraction = match self.left {
            None => fa / (fa - fb),
            Some((c, fc)) => {
                let (xi, phi) = ((a - b) / (c - b), (fa - fb) / (fc - fb));
                if phi * phi < xi && (1.0 - phi) * (1.0 - phi) < 1.0 - xi {
                    fa / (fb - fa) * (fc / (fb - fc))
                        + (c - a) / (b - a) * (fa / (fc - fa)) * (fb / (fc - fb))
                } else {
                    0.5
                }
            }
        };
        a + fraction.clamp(0.0, 1.0) * (b - a)
    }

    /// Narrows the bracket by a place and the value there.
    pub fn take(&mut self, found: (f64, f64)) {
        if found.1 * self.latest.1 > 0.0 {
            self.left = Some(self.latest);
        } else {
            self.left = Some(self.other);
            self.other = self.latest;
        }
        self.latest = found;
    }
}
