//! The cost along one axis, and the mean and the deviation of the likelihood that it stands for.

/// Places at which it is evaluated along an axis that is followed.
const PLACES: usize = 32;
/// Parts of a stretch between two places that its moments are summed by.
const PARTS: usize = 8;

/// Places along an axis in order, each with its cost; straight between them.
pub(super) struct Costs(Vec<[f64; 2]>);

impl Costs {
    pub fn at(place: [f64; 2]) -> Self {
        Self(vec![place])
    }

    /// Unless the place is there already.
    pub fn add(&mut self, place: f64, cost: f64) {
        let after = self.0.partition_point(|[known, _]| *known < place);
        if self.0.get(after).is_none_or(|[known, _]| *known != place) {
            self.0.insert(after, [place, cost]);
        }
    }

    /// Evaluates `cost` where most of the likelihood lies, until there are enough places.
    pub fn fill(&mut self, mut cost: impl FnMut(f64) -> f64) {
        for _ in self.0.len()..PLACES {
            let place = self.heaviest();
            self.add(place, cost(place));
        }
    }

    pub fn best(&self) -> [f64; 2] {
        self.0.iter().copied().min_by(|[_, a], [_, b]| a.total_cmp(b)).unwrap_or_default()
    }

    /// The side of the `ends` where the last place is both the end and the best one.
    pub fn rises_at(&self, ends: [f64; 2]) -> Option<usize> {
        (0..2).find(|side| self.best()[0] == ends[*side])
    }

    /// Parts of the stretch after place `k`: where each lies, and its likelihood over that of the best place.
    fn parts(&self, k: usize) -> impl Iterator<Item = [f64; 2]> {
        let least = self.best()[1];
        let ([from, cost], [to, other]) = (self.0[k], self.0[k + 1]);
        (0..PARTS).map(move |part| {
            let share = (part as f64 + 0.5) / PARTS as f64;
            let density = (least - (1.0 - share) * cost - share * other).exp();
            [from + share * (to - from), density * (to - from) / PARTS as f64]
        })
    }

    /// The middle of the stretch in which most of the likelihood lies, or may lie where one end has none.
    fn heaviest(&self) -> f64 {
        let weight = |k: usize| {
            let ([from, cost], [to, other]) = (self.0[k], self.0[k + 1]);
            if cost.is_infinite() != other.is_infinite() {
                (self.best()[1] - cost.min(other)).exp() * (to - from)
            } else {
                self.parts(k).map(|[_, weight]| weight).sum()
            }
        };
        let heaviest = (0..self.0.len().saturating_sub(1)).max_by(|a, b| weight(*a).total_cmp(&weight(*b)));
        heaviest.map_or(0.0, |k| 0.5 * (self.0[k][0] + self.0[k + 1][0]))
    }

    /// The mean and the deviation, if there is any stretch of likelihood.
    pub fn moments(&self) -> Option<[f64; 2]> {
        let parts = || (0..self.0.len() - 1).flat_map(|k| self.parts(k));
        let sum: f64 = parts().map(|[_, weight]| weight).sum();
        let mean = parts().map(|[place, weight]| place * weight).sum::<f64>() / sum;
        let square = parts().map(|[place, weight]| (place - mean).powi(2) * weight).sum::<f64>() / sum;
        (sum > 0.0 && square.is_finite()).then_some([mean, square.sqrt()])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Costs at the reaches, and at as many more places as are evaluated.
    fn evaluated(cost: impl Fn(f64) -> f64) -> Costs {
        let mut along = Costs(Vec::new());
        [-16.0, -8.0, -4.0, 0.0, 4.0, 8.0, 16.0].into_iter().for_each(|place| along.add(place, cost(place)));
        along.fill(cost);
        along
    }

    #[test]
    fn moments_are_those_of_the_likelihood_wherever_its_top_is() {
        for (top, deviation) in [(0.0, 1.0), (3.0, 2.0), (-9.0, 0.7)] {
            let along = evaluated(|place| 0.5 * ((place - top) / deviation).powi(2) + 3.0);
            let [mean, wide] = along.moments().unwrap();
            assert!((mean - top).abs() < 0.1 * deviation, "{top}: {mean}");
            assert!((wide / deviation - 1.0).abs() < 0.1, "{top}: {wide}");
        }
    }

    #[test]
    fn places_without_a_prediction_weigh_nothing_and_are_approached() {
        for (from, to) in [(-7.9, 7.9), (-3.9, 7.9), (-16.0, 1.0)] {
            let along = evaluated(|place| if (from..=to).contains(&place) { 1.0 } else { f64::INFINITY });
            let [mean, deviation] = along.moments().unwrap();
            assert!((mean - 0.5 * (from + to)).abs() < 0.3, "{from} {to}: {mean}");
            assert!(
                (deviation * 12.0_f64.sqrt() / (to - from) - 1.0).abs() < 0.1,
                "{from} {to}: {deviation}"
            );
        }
        assert_eq!(Costs(vec![[-1.0, f64::INFINITY], [0.0, 2.0], [1.0, f64::INFINITY]]).moments(), None);
    }

    #[test]
    fn an_end_that_is_the_best_place_is_seen_and_a_bound_is_none() {
        let along = evaluated(|place| -place);
        assert_eq!(along.rises_at([-16.0, 16.0]), Some(1));
        assert_eq!(along.rises_at([-16.0, 32.0]), None);
    }
}
