//! What the records do not tell, and why.

use super::Identification;
use crate::identify::WIDE;

/// Ends of an interval farther apart than this, as a ratio, tell an order of magnitude alone.
const VAGUE: f64 = 4.0;

/// Something that the records do not tell.
#[derive(Debug, Clone, PartialEq)]
pub struct Unidentified {
    /// Its name: a parameter of the best law, `mean_force`, `normal_stiffness`, `force_harmonics`.
    pub name: &'static str,
    /// Why.
    pub reason: String,
}

pub(super) fn unidentified(found: &Identification) -> Vec<Unidentified> {
    let mut out = vec![Unidentified {
        name: "normal_stiffness",
        reason: "bending moves the contact along the beam alone: nothing measured depends on it".to_owned(),
    }];
    let periods = found.inversion.iter().flat_map(|inversion| &inversion.periods);
    let (mut means, mut within, mut widest) = (0, 0, 0.0_f64);
    for period in periods {
        let wide = WIDE * period.covariance[(0, 0)].sqrt();
        means += usize::from(period.force[0].abs() < wide);
        widest = widest.max(wide);
        let outside = |h: &usize| {
            let of = |value: &dyn Fn(usize) -> f64| value(2 * h - 1) + value(2 * h);
            of(&|k| period.force[k].powi(2)) > 2.0 * WIDE * of(&|k| period.covariance[(k, k)])
        };
        let last = (1..=period.force.len() / 2).rfind(outside).unwrap_or(0);
        within = within.max(last);
    }
    if means > 0 {
        out.push(Unidentified {
            name: "mean_force",
            reason: format!(
                "accelerometers show no mean, and what it does to the bending leaves zero in its interval in {means} of {} \
                 records (± {widest:.1} N at most)",
                found.records.len()
            ),
        });
    }
    let asked = found.inversion.as_ref().map_or(0, |inversion| inversion.periods[0].force.len() / 2);
    if within < asked {
        out.push(Unidentified {
            name: "force_harmonics",
            reason: format!("those of the force above {within} lie within their intervals in every record"),
        });
    }
    let parameters = found.best.map(|best| found.laws[best].parameters.as_slice()).unwrap_or_default();
    for parameter in parameters {
        let [low, high] = parameter.interval;
        if low.is_nan() || high.is_nan() {
            let reason = "no interval: the fitted records do not depend on it".to_owned();
            out.push(Unidentified { name: parameter.name, reason });
        } else if low <= 0.0 || high > VAGUE * low {
            let told = |end: f64| if end == 0.0 { "0".to_owned() } else { format!("{end:.3e}") };
            let reason = format!("its 95 % interval is {} to {} {}", told(low), told(high), parameter.unit);
            out.push(Unidentified { name: parameter.name, reason });
        }
    }
    out
}
