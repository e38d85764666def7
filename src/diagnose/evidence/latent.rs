//! What a discrepancy adds to the predictions.

/// A flexible additional signal: constant columns, each belonging to one of `count` shared weights of deviation one; and
/// the noise, which may be larger than known.
#[derive(Debug, Clone, Default)]
pub(super) struct Latent {
    pub count: usize,
    /// Per record: which weight, and its column over all samples.
    pub columns: Vec<Vec<(usize, Vec<f64>)>>,
}

impl Latent {
    /// What every unknown changes of record `k`, each with its place: `parameters` shared ones, the weights, and from `offset`
    /// the record's own.
    pub fn columns_with<'c>(
        &'c self,
        k: usize,
        derivatives: &'c [Vec<f64>],
        parameters: usize,
        offset: usize,
    ) -> impl Iterator<Item = (usize, &'c Vec<f64>)> {
        let place = move |a: usize| if a < parameters { a } else { offset + a - parameters };
        let own = derivatives.iter().enumerate().map(move |(a, column)| (place(a), column));
        let more = self.columns.get(k).into_iter().flatten();
        own.chain(more.map(move |(w, column)| (parameters + w, column)))
    }

    pub fn add(&self, k: usize, weights: &[f64], predictions: &mut [f64]) {
        for (w, column) in self.columns.get(k).into_iter().flatten() {
            predictions.iter_mut().zip(column).for_each(|(p, c)| *p += weights[*w] * c);
        }
    }
}
