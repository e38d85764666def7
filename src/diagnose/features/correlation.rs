//! The correlation of two series, value by value.

/// Sums of a correlation.
#[derive(Default)]
pub(in crate::diagnose) struct Correlation {
    count: f64,
    x: f64,
    y: f64,
    xx: f64,
    xy: f64,
    yy: f64,
}

impl Correlation {
    pub(in crate::diagnose) fn add(&mut self, x: f64, y: f64) {
        self.count += 1.0;
        self.x += x;
        self.y += y;
        self.xx += x * x;
        self.xy += x * y;
        self.yy += y * y;
    }

    pub(in crate::diagnose) fn value(&self) -> Option<f64> {
        let centred = |product: f64, a: f64, b: f64| product - a * b / self.count;
        let size = (centred(self.xx, self.x, self.x) * centred(self.yy, self.y, self.y)).sqrt();
        (self.count > 2.0 && size > 1e-9 * (self.xx * self.yy).sqrt())
            .then(|| centred(self.xy, self.x, self.y) / size)
    }
}
