//! What several sets of effects say together when none of them is certain.

/// Effects, sorted, with the probability that these and no others are missing.
pub(super) type Explanation = (Vec<&'static str>, f64);

/// What is certain although no set is.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Shared {
    /// These effects are missing, with this probability; whether others are is open.
    Found(Vec<&'static str>, f64),
    /// The first are missing, and with this probability some of the others, which none of them is alone.
    OneOf(Vec<&'static str>, Vec<&'static str>, f64),
}

/// What is in every one of the likely `explanations` is found; what is in some of them is a group where one of it is `certainly`
/// there, or where nothing is found without it.
pub(super) fn shared(explanations: &[Explanation], certainly: f64) -> Option<Shared> {
    let mut likely: Vec<&Explanation> = explanations.iter().filter(|(_, p)| *p > 1.0 - certainly).collect();
    likely.sort_by(|a, b| b.1.total_cmp(&a.1));
    let (mut found, mut open): (Vec<&'static str>, Vec<&'static str>) = Default::default();
    for id in likely.iter().flat_map(|(ids, _)| ids) {
        let everywhere = likely.iter().all(|(ids, _)| ids.contains(id));
        let list = if everywhere { &mut found } else { &mut open };
        if !list.contains(id) {
            list.push(id);
        }
    }
    let sum = |wanted: &dyn Fn(&[&'static str]) -> bool| -> f64 {
        explanations.iter().filter(|(ids, _)| wanted(ids)).map(|(_, p)| p).sum()
    };
    let one_of = sum(&|ids| open.iter().any(|id| ids.contains(id)));
    let all = sum(&|ids| found.iter().all(|id| ids.contains(id)));
    let stands_alone = !found.is_empty() && likely.iter().any(|(ids, _)| *ids == found);
    if stands_alone && all >= certainly && one_of < certainly {
        Some(Shared::Found(found, all))
    } else if open.len() > 1 {
        Some(Shared::OneOf(found, open, one_of))
    } else {
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(explanations: &[(&[&'static str], f64)]) -> Option<Shared> {
        let all: Vec<Explanation> = explanations.iter().map(|(ids, p)| (ids.to_vec(), *p)).collect();
        shared(&all, 0.95)
    }

    /// What is found with a probability, or what is in a group with one.
    fn told(shared: Option<Shared>) -> (Vec<&'static str>, Vec<&'static str>, f64) {
        match shared {
            Some(Shared::Found(found, p)) => (found, Vec::new(), (p * 1e6).round() / 1e6),
            Some(Shared::OneOf(found, open, p)) => (found, open, (p * 1e6).round() / 1e6),
            None => Default::default(),
        }
    }

    #[test]
    fn what_is_in_every_likely_set_is_found_and_the_rest_is_open() {
        assert_eq!(told(of(&[(&["a"], 0.6), (&["a", "b"], 0.4)])), (vec!["a"], vec![], 1.0));
        // One of b and c is there with a probability of a half: no group.
        let half = of(&[(&["a"], 0.5), (&["a", "b"], 0.25), (&["a", "c"], 0.25)]);
        assert_eq!(told(half), (vec!["a"], vec![], 1.0));
        // Many that are hardly likely leave what is in all of them as certain as it is.
        let mut many: Vec<(&[&'static str], f64)> = vec![(&["a"], 0.9), (&[], 0.02)];
        let names: [&[&'static str]; 8] = [
            &["a", "b"],
            &["a", "c"],
            &["a", "d"],
            &["a", "e"],
            &["a", "f"],
            &["a", "g"],
            &["a", "h"],
            &["a", "i"],
        ];
        many.extend(names.map(|ids| (ids, 0.01)));
        assert_eq!(told(of(&many)), (vec!["a"], vec![], 0.98));
    }

    #[test]
    fn a_group_has_the_probability_that_one_of_it_is_there() {
        assert_eq!(told(of(&[(&["b"], 0.5), (&["c"], 0.48)])), (vec![], vec!["b", "c"], 0.98));
        let beside = of(&[(&["a"], 0.02), (&["a", "b"], 0.5), (&["a", "c"], 0.48)]);
        assert_eq!(told(beside), (vec!["a"], vec!["b", "c"], 0.98));
    }

    #[test]
    fn what_nobody_shares_is_nothing() {
        assert_eq!(of(&[(&["b"], 0.94), (&[], 0.06)]), None);
    }
}
