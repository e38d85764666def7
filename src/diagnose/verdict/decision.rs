//! The one rule that makes a verdict of probabilities, and what the test records say of it.

use super::confound;
use super::context::Context;
use super::shared::{Shared, shared};
use crate::diagnose::diagnosis::{Detectable, Group, Verdict};
use crate::diagnose::evidence::{self, Measured, Sensitivities, Weighed};

/// A verdict with what it rests on.
pub(in crate::diagnose) struct Decision {
    pub verdict: Verdict,
    pub probability: f64,
    /// Of what is named and nothing else, in any form.
    pub alone: f64,
    /// The likeliest set without a discrepancy; the empty one where what it names is taken back.
    pub best: usize,
    /// The same before anything is taken back.
    pub likeliest: usize,
    /// Probability that something outside the catalogue is missing.
    pub doubt: f64,
    /// Ids of what is certain in a verdict that leaves something open.
    pub certain: Vec<&'static str>,
    pub groups: Vec<Group>,
    /// Effects that may well be there and matter, although nothing is seen of them.
    pub open: Vec<Detectable>,
    /// Why a verdict is taken back.
    pub taken_back: Option<TakenBack>,
}

/// What is said against a verdict of the probabilities.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::diagnose) enum TakenBack {
    /// The effects make their prediction worse.
    Worse,
    /// Together with them the records show a discrepancy.
    Unexplained,
    /// The training records themselves: an effect's size has no interval, reaches none, or lies beyond any expectation.
    Undetermined,
    /// The noise is unknown, and more follows from its own past in the residual than the effects explain.
    Outweighed,
    /// Nothing is seen, and too little could have been: some effect may well be there and matter.
    Unseen,
}

impl Decision {
    /// Of the probabilities alone.
    pub fn of(context: &Context, weighed: &Weighed) -> Self {
        let sets = &weighed.sets;
        let best = weighed.likeliest(|_| true).unwrap_or(0);
        let doubt =
            (0..sets.len()).filter(|k| sets[*k].discrepancy.is_some()).map(|k| weighed.weights[k]).sum();
        let alone = weighed.alone(best);
        let mut decision = Self {
            verdict: Verdict::InsufficientData,
            probability: alone,
            alone,
            best,
            likeliest: best,
            doubt,
            certain: Vec::new(),
            groups: Vec::new(),
            open: Vec::new(),
            taken_back: None,
        };
        let some = weighed.sum(|ids| !ids.is_empty());
        let certainly = context.data.assumptions().certain;
        if doubt >= certainly {
            (decision.verdict, decision.probability) = (Verdict::Unexplained, doubt);
        } else if decision.probability >= certainly {
            decision.verdict = certain(context, weighed, best);
        } else if some >= certainly {
            decision.share(weighed, some, certainly);
        } else {
            decision.probability = 1.0 - doubt.max(decision.probability);
        }
        decision
    }

    /// What the sets of `weighed` say together that have a probability of `some`.
    fn share(&mut self, weighed: &Weighed, some: f64, certainly: f64) {
        self.probability = some;
        match shared(&weighed.explanations(), certainly) {
            Some(Shared::Found(ids, probability)) => {
                (self.verdict, self.probability) = (Verdict::EffectFound, probability);
                self.best = weighed.likeliest(|of| of == ids).unwrap_or(self.best);
                self.alone = weighed.alone(self.best);
            }
            Some(Shared::OneOf(certain, open, probability)) => {
                (self.verdict, self.certain) = (Verdict::NotDistinguishable, certain);
                self.groups = vec![confound::group(open, probability)];
            }
            None => {}
        }
    }

    /// After a look at the sizes of what was found, and one at the test records: both may take a verdict back, neither
    /// chooses one.
    pub fn confirmed(
        mut self,
        context: &Context,
        weighed: &Weighed,
        test: &Measured,
        all: &Measured,
    ) -> Self {
        self.likeliest = self.best;
        if self.verdict == Verdict::EffectFound && !weighed.is_determined(self.best, context.data) {
            (self.verdict, self.best) = (Verdict::InsufficientData, 0);
            self.taken_back = Some(TakenBack::Undetermined);
            return self;
        }
        if self.verdict == Verdict::EffectFound && is_outweighed(context, weighed, self.best) {
            (self.verdict, self.best) = (Verdict::InsufficientData, 0);
            self.taken_back = Some(TakenBack::Outweighed);
            return self;
        }
        if !self.verdict.stands() || test.records.is_empty() {
            return self;
        }
        let against = context.data.assumptions().certainty();
        let score = |k: usize| {
            let scored = context.bench.score(&weighed.sets[k].posterior.model, &test.records).ok()?;
            Some(test.log_score(&scored.into_iter().map(|one| one.predictions).collect::<Vec<_>>()))
        };
        let scores = (self.best != 0).then(|| score(self.best).zip(score(0))).flatten();
        let is_worse = scores.is_some_and(|(with, without)| with < without - against);
        if self.is_contradicted(context, weighed, test, all).unwrap_or(false) {
            self.verdict = Verdict::Unexplained;
            self.taken_back = Some(TakenBack::Unexplained);
        } else if is_worse {
            self.verdict = Verdict::InsufficientData;
            self.taken_back = Some(TakenBack::Worse);
        }
        if is_worse {
            self.best = 0;
        }
        self
    }

    /// Whether all records together show what is missing: something relevant that remains when the best set is fitted to
    /// them, or anything at all that remains where the test records were foretold relevantly wrong.
    fn is_contradicted(
        &self,
        context: &Context,
        weighed: &Weighed,
        test: &Measured,
        all: &Measured,
    ) -> Result<bool, String> {
        let against = context.data.assumptions().certainty();
        let best = &weighed.sets[self.best].posterior;
        let again = evidence::again(all, best);
        let doubt = again.as_ref().ok().and_then(|again| evidence::doubt(all, again).ok());
        if doubt.is_some_and(|doubt| doubt > against) {
            return Ok(true);
        }
        if !all.noise_is_known() {
            return Ok(false);
        }
        let foretold = context.bench.score(&best.model, &test.records).map_err(|error| error.to_string())?;
        let foretold: Vec<Vec<f64>> = foretold.into_iter().map(|one| one.predictions).collect();
        // Where nothing can be fitted to all of them, what was foretold is all there is.
        let left = match again {
            Ok(again) => evidence::beyond_noise(all, &again.predictions),
            Err(_) => evidence::beyond_noise(test, &foretold),
        };
        Ok(left > against && test.unexplained(&foretold) >= context.data.assumptions().relevant)
    }

    /// After a look at what could have been seen beside the best set, which may take back that nothing is missing.
    pub fn limited(mut self, context: &Context, seen: &Sensitivities) -> Self {
        if self.verdict != Verdict::NothingMissing {
            return self;
        }
        let assumed = context.data.assumptions();
        let open =
            seen.detectable.iter().filter(|one| one.relevant.is_some_and(|p| p > 1.0 - assumed.certain));
        self.open = open.cloned().collect();
        if !self.open.is_empty() {
            (self.verdict, self.taken_back) = (Verdict::InsufficientData, Some(TakenBack::Unseen));
            self.probability = f64::NAN;
        }
        self
    }
}

/// Whether nothing is known of the noise, and what `set` leaves shows more of a cause than its effects explain: noise may be
/// coloured, but then nobody can tell it from what else is missing.
fn is_outweighed(context: &Context, weighed: &Weighed, set: usize) -> bool {
    let [with, without] = [set, 0].map(|k| &weighed.sets[k].posterior.predictions);
    !context.data.noise_is_known() && context.data.foretold(with) > context.data.distance(with, without)
}

/// What a set says that is certain.
fn certain(context: &Context, weighed: &Weighed, set: usize) -> Verdict {
    let known = context.data.noise_is_known() || context.is_exact(weighed);
    if weighed.sets[set].members.is_empty() {
        // Without a known noise, a residual that nothing explains may be noise or not; few points never show that all
        // is there.
        return if known && !context.table { Verdict::NothingMissing } else { Verdict::InsufficientData };
    }
    // What lowers the frequencies of a structure without a contact stands for the slip that its model lacks, where nothing
    // tells of the losses.
    let tells = !context.table || context.model.contact.is_some() || !context.frequencies_alone();
    if tells { Verdict::EffectFound } else { Verdict::Unexplained }
}
