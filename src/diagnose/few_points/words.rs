//! The verdict on a table of few points, in sentences.

use super::super::diagnosis::{Evidence, Verdict};
use super::leave_out;
use super::{FEWEST_FREE, PASSING_FRACTION, Rounds, Standing};
use crate::model::Model;

/// A table without a degree of freedom to spare.
pub(super) fn too_few(values: usize, parameters: usize) -> String {
    format!(
        "{values} measured value{} for {parameters} free parameter{}: with one more parameter fewer than \
         {FEWEST_FREE} degrees of freedom remain, too few to judge an effect; measure more levels",
        plural(values),
        plural(parameters)
    )
}

/// Why the members of a group cannot be distinguished.
pub(super) fn tied(ids: &[&str]) -> String {
    format!(
        "with each of them the points left out are predicted equally well, to within one standard error ({})",
        ids.join(", ")
    )
}

/// The experiment that would decide.
pub(super) fn next_experiment() -> String {
    "Measure the table again, so that its scatter is known, with levels between those where the frequency changes \
     most and with the damping ratio at each level; or record the acceleration in time at three levels or more"
        .to_owned()
}

fn plural(count: usize) -> &'static str {
    if count == 1 { "" } else { "s" }
}

impl Rounds<'_, '_> {
    /// The first channel's name and unit, and its root-mean-square error of fit and of points left out.
    fn sizes(&self, standing: &Standing) -> (String, [f64; 2]) {
        let bench = self.search.bench;
        let lane = &bench.lanes[0];
        let Some((name, range)) = lane.channels.first() else { return (String::new(), [f64::NAN; 2]) };
        let unit = lane.record.channel(name).map_or("", |channel| channel.unit);
        let fitted = standing.state.scored.first().map_or(&[][..], |one| &one.residuals[range.clone()]);
        let rows = leave_out::rows(bench);
        let mut place = 0;
        let mut unseen = Vec::new();
        for row in &rows {
            if row.record == 0 {
                unseen.push(standing.unseen.residuals[place]);
            }
            place += row.values.len();
        }
        let size = |residuals: &[f64]| {
            let weights = &lane.weights[range.clone()];
            let sum: f64 = residuals.iter().zip(weights).map(|(r, w)| (r / w).powi(2)).sum();
            (sum / residuals.len().max(1) as f64).sqrt()
        };
        (unit.to_owned(), [size(fitted), size(&unseen)])
    }

    /// Why this verdict, and how little it rests on.
    pub(super) fn reasons(&self, model: &Model, verdict: Verdict) -> Vec<String> {
        let mut reasons = vec![self.carried()];
        if model.contact.is_none() {
            reasons.push(
                "The model has no contact: a frequency that falls with the level may well be slip, and slip is another \
                 model ([contact] with law = \"jenkins\"), not an effect to add to this one"
                    .to_owned(),
            );
        }
        if self.exact() {
            reasons.push(
                "The error that remains is the error of the computation; no effect can lower it. The model may be \
                 right, or it may have too many parameters for these points: without their noise this is unknown"
                    .to_owned(),
            );
        } else if self.kept.is_empty() || verdict != Verdict::NotDistinguishable {
            reasons.extend(self.rejected());
        }
        for group in self.groups() {
            reasons.push(format!("Not distinguishable: {}", group.reason));
        }
        reasons
    }

    /// Points, parameters, degrees of freedom.
    fn carried(&self) -> String {
        let values = self.base.unseen.residuals.len();
        let count = |standing: &Standing| self.search.unknowns(&standing.state.fitted.model).len();
        let (first, last) = (count(&self.base), count(self.last()));
        let (unit, [fitted, unseen]) = self.sizes(&self.base);
        let steps = if last > first {
            format!(", the last {last}: {} degree{} of freedom remain", values - last, plural(values - last))
        } else {
            format!(": {} degree{} of freedom remain", values - first, plural(values - first))
        };
        format!(
            "{values} measured values are little evidence. The model as given fits {first} parameter{} to them{steps}. \
             Its error is {fitted:.3} {unit} as fitted and {unseen:.3} {unit} at points left out of the fit one by one; \
             the scatter of the values is not known, so \"nothing is missing\" is not a possible answer",
            plural(first)
        )
    }

    /// A step's gain and its standard error.
    fn step(&self, index: usize) -> String {
        let before = if index == 0 { &self.base } else { &self.kept[index - 1].standing };
        let kept = &self.kept[index];
        let (unit, [old_fitted, old_unseen]) = self.sizes(before);
        let (_, [fitted, unseen]) = self.sizes(&kept.standing);
        let squares = before.unseen.squares.iter().zip(&kept.standing.unseen.squares);
        let better = squares.filter(|(old, new)| new < old).count();
        format!(
            "the error at points left out falls from {old_unseen:.3} to {unseen:.3} {unit} ({:.0} % of its square, \
             {:.1} standard errors; {better} of {} points are predicted better), that of the fit from \
             {old_fitted:.3} to {fitted:.3} {unit}. {}",
            100.0 * kept.gain.fraction,
            kept.gain.z,
            before.unseen.squares.len(),
            self.nested(index).words()
        )
    }

    /// The best of what was tried last and not kept.
    fn rejected(&self) -> Option<String> {
        if self.rounds.len() <= self.kept.len() {
            return None;
        }
        let best = self.rounds.last()?.iter().find(|tried| tried.standing.is_some())?;
        let more = if self.kept.is_empty() { "No effect" } else { "No further effect" };
        let gain = best.trial.gain;
        let does = match gain.fraction {
            fraction if fraction < 0.005 => "does not lower it".to_owned(),
            fraction => {
                format!("lowers it by {:.0} %, which is {:.1} standard errors", 100.0 * fraction, gain.z)
            }
        };
        Some(format!(
            "{more} lowers the error at points left out by more than its standard error and by {:.0} % of its square; \
             the best, {}, {does}",
            100.0 * PASSING_FRACTION,
            best.trial.ids().join(" + "),
        ))
    }

    /// The steps once more, by effect.
    pub(super) fn evidence(&self) -> Vec<Evidence> {
        let of = |index: usize| {
            let kept = &self.kept[index];
            let others: Vec<&str> = kept.tied.iter().map(|other| other.effect.title).collect();
            Evidence {
                effect: kept.candidate.effect.id,
                seen: self.step(index),
                otherwise: (!others.is_empty()).then(|| others.join(", ")),
            }
        };
        (0..self.kept.len()).map(of).collect()
    }
}
