//! The numbers that are told, and their intervals: what is done after all sets were compared, of the base and of the decided
//! one alone.
//!
//! `agreement` looks for a better minimum from elsewhere, then all samples take the place of those that the search saw. `profile` follows the likelihood over the whole of an interval
//! where its curvature at the top does not tell how far it reaches (`costs`: along one axis), and from a bound inwards.
//! `refined`, which also tells how fine steps in time must be, takes off their error and that of harmonics that are left
//! out. `driven` allows for what the noise of the inputs did.

mod agreement;
mod costs;
mod driven;
mod profile;
mod refined;

pub(in crate::diagnose) use agreement::freed;
pub(in crate::diagnose) use refined::steps_needed;

use super::again;
use super::measured::Measured;
use super::posterior::Posterior;
use crate::diagnose::diagnosis::Agreement;

/// Makes sure of the parameters of `posterior`, by all samples of the records where the `whole` of them are more than `data`; what
/// other starts say of them, and why their intervals are none that hold, if they are not.
pub(super) fn assure(
    data: &Measured,
    whole: Option<&Measured>,
    posterior: &mut Posterior,
) -> (Agreement, Option<String>) {
    let (found, agreement) = agreement::agreement(data, posterior);
    *posterior = found;
    let (data, not_refitted) = match whole.map(|whole| (whole, refit(whole, posterior))) {
        Some((whole, Ok(()))) => (whole, None),
        Some((_, Err(reason))) => {
            (data, Some(format!("the numbers are those of the samples that the search saw alone: {reason}")))
        }
        None => (data, None),
    };
    let (followed, told) = profile::follow(data, posterior);
    if let Ok(refined) = refined::refined(data, posterior, followed) {
        *posterior = refined;
    }
    let not_allowed = driven::allow_for_inputs(data, posterior).err();
    (agreement, reason(data, [not_refitted, told, not_allowed]))
}

/// Moves the numbers of `posterior` to where they fit other samples than before best; all sets stay compared by those.
fn refit(data: &Measured, posterior: &mut Posterior) -> Result<(), String> {
    let Posterior { model, y, deviations, correlations, .. } = again(data, posterior)?;
    *posterior = Posterior { model, y, deviations, correlations, ..posterior.clone() };
    Ok(())
}

/// Moves the numbers of `posterior` to the middle of the likelihood and makes their intervals as wide as that is, with the noise
/// of the inputs in them; why that is not so, but for an interrupt.
pub(in crate::diagnose) fn intervals(data: &Measured, posterior: &mut Posterior) -> Option<String> {
    let (_, told) = profile::follow(data, posterior);
    reason(data, [told, driven::allow_for_inputs(data, posterior).err()])
}

/// Has them allow for the noise of the inputs alone, as those of a model that lacks something: its likelihood says little.
pub(super) fn allow_for_inputs(data: &Measured, posterior: &mut Posterior) -> Option<String> {
    reason(data, [driven::allow_for_inputs(data, posterior).err()])
}

fn reason<const N: usize>(data: &Measured, of: [Option<String>; N]) -> Option<String> {
    let told: Vec<String> = of.into_iter().flatten().collect();
    (!told.is_empty() && !data.bench.interrupted()).then(|| told.join("; "))
}
