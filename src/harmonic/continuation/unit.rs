//! The measure of arc length: unknowns and scalars relative to their sizes.

use super::Location;
use crate::harmonic::newton::system::Operating;

/// Inverse sizes that make arc length dimensionless.
#[derive(Debug, Clone, Copy)]
pub(super) struct Unit {
    pub unknowns: f64,
    pub scalars: [f64; 4],
    pub largest: f64,
}

impl Unit {
    pub fn product(&self, a: &Location, b: &Location) -> f64 {
        let unknowns: f64 = a.unknowns.iter().zip(&b.unknowns).map(|(a, b)| a * b).sum();
        let scalars: f64 = (0..4).map(|k| a.scalars[k] * b.scalars[k] * self.scalars[k].powi(2)).sum();
        unknowns * self.unknowns * self.unknowns + scalars
    }

    pub fn normalise(&self, location: &mut Location) {
        let size = self.product(location, location).sqrt();
        if size > 0.0 {
            location.unknowns.iter_mut().for_each(|d| *d /= size);
            location.scalars.iter_mut().for_each(|d| *d /= size);
        }
    }

    pub fn distance(&self, location: &Location, x: &[f64], at: &Operating) -> f64 {
        let unknowns: f64 = location.x.iter().zip(x).map(|(a, b)| (a - b).powi(2)).sum();
        let (a, b) = (location.at.scalars(), at.scalars());
        let scalars: f64 = (0..4).map(|k| ((a[k] - b[k]) * self.scalars[k]).powi(2)).sum();
        (unknowns * self.unknowns * self.unknowns + scalars).sqrt()
    }
}
