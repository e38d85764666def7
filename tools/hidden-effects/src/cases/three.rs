//! Cases that hide three effects: a diagnosis looks for so many only where it is asked to.

use super::case::{Case, Kind, Strength};
use super::sealed::{PLAN_OF_PAIRS, case};

/// All of them: each pair of the sealed cases with another of the kind's effects, one after the other.
pub fn three() -> Vec<Case> {
    Kind::ALL.into_iter().flat_map(of_kind).collect()
}

fn of_kind(kind: Kind) -> impl Iterator<Item = Case> {
    let effects = kind.effects();
    kind.pairs().iter().enumerate().map(move |(index, pair)| {
        let third = effects.iter().cycle().skip(index * 5).find(|id| !pair.contains(id));
        let all: Vec<&'static str> = pair.iter().chain(third).copied().collect();
        case(kind, &all, Strength::Full, PLAN_OF_PAIRS[index % 3], 1)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_hides_three_effects_that_its_experiment_knows() {
        for case in three() {
            let mut effects = case.effects.clone();
            effects.sort_unstable();
            effects.dedup();
            assert_eq!(effects.len(), 3, "{}", case.name());
            assert!(case.draw().is_ok(), "{}", case.name());
        }
    }
}
