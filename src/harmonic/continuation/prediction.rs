//! Where the next point is looked for.

use super::Path;

impl Path<'_> {
    /// The plane through the present point at a right angle to the curve.
    pub(super) fn set_plane(&mut self) {
        let unit = self.unit;
        self.arc.unknowns.clear();
        self.arc.unknowns.extend(self.present.unknowns.iter().map(|d| d * unit.unknowns * unit.unknowns));
        self.arc.scalars =
            std::array::from_fn(|k| self.present.scalars[k] * unit.scalars[k] * unit.scalars[k]);
    }

    /// Puts `next` ahead by `step`: along the tangent; where the curve is `bent`, on the cubic through the last
    /// two points and tangents.
    pub(super) fn predict(&mut self, step: f64, bent: bool) {
        let (here, before) = (&self.present, &self.previous);
        // With s the step over the last one: x + s h d + s² (…) + s³ (…), Hermite's cubic beyond its end.
        // The chord measured in the present unit, and the arc above it.
        let chord = self.unit.distance(here, &before.x, &before.at);
        let turned = 1.0 - self.unit.product(here, before).clamp(-1.0, 1.0);
        let last = chord * (1.0 + turned / 12.0);
        let s = if bent { step / last } else { 0.0 };
        let (square, cube) = (s * s * (2.0 * s + 3.0), s * s * (s + 1.0));
        let ahead = |x: f64, d: f64, y: f64, b: f64| {
            if bent {
                x + step * d + square * (y - x) + last * (cube * b + (cube + s * s) * d)
            } else {
                x + step * d
            }
        };
        self.next.x.clear();
        let ends = here.x.iter().zip(&here.unknowns).zip(before.x.iter().zip(&before.unknowns));
        self.next.x.extend(ends.map(|((x, d), (y, b))| ahead(*x, *d, *y, *b)));
        self.next.at = here.at;
        for scalar in &self.free {
            let k = scalar.index();
            let (x, y) = (here.at.get(*scalar), before.at.get(*scalar));
            self.next.at.set(*scalar, ahead(x, here.scalars[k], y, before.scalars[k]));
        }
        self.arc.target = self.arc.at(&here.x, &here.at) + step;
    }
}
