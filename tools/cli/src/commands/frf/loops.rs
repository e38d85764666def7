//! Loops of the contacts at the peaks of a curve.

use stickslip::harmonic::{Assembly, Control, Curve, Peak, Point, periodic_response};
use stickslip_report::contact_loop;
use stickslip_report::responses::ContactLoop;

use super::Request;

/// Peaks nearer to each other than this fraction of their frequency are one resonance.
const SAME: f64 = 0.03;

/// The loops of the model's contact, the first, at the peaks of a curve, one for each resonance.
pub fn at_peaks(
    assembly: &Assembly,
    request: &Request,
    control: &Control,
    level: f64,
    curve: &Curve,
) -> Vec<ContactLoop> {
    let unit = request.hold.map_or("N", |hold| ["m", "m/s", "m/s²"][hold.derivative.min(2)]);
    let mut loops = Vec::new();
    for peak in resonances(curve) {
        let Some(near) = nearest(curve, &peak) else { continue };
        let exact =
            periodic_response(assembly, peak.angular_frequency, control, &request.alone(), Some(near));
        let point = exact.as_ref().unwrap_or(near);
        let (Some((_, law, normal_load)), Some(at)) = (assembly.system.laws().next(), point.contacts.first())
        else {
            continue;
        };
        let name = format!("{level} {unit}, {}", request.unit.shown(point.angular_frequency));
        loops.extend(
            contact_loop(law.as_ref(), normal_load, point.angular_frequency, &at.displacement)
                .map(|(displacement, force)| ContactLoop { name, displacement, force }),
        );
    }
    loops
}

/// Of peaks of several nodes close together the first.
fn resonances(curve: &Curve) -> Vec<Peak> {
    let mut peaks = curve.peaks.clone();
    peaks.sort_by(|a, b| a.angular_frequency.total_cmp(&b.angular_frequency));
    peaks.dedup_by(|later, first| {
        later.angular_frequency - first.angular_frequency < SAME * first.angular_frequency
    });
    peaks
}

fn nearest<'a>(curve: &'a Curve, peak: &Peak) -> Option<&'a Point> {
    let distance = |point: &Point| (point.angular_frequency - peak.angular_frequency).abs();
    curve.points.iter().min_by(|a, b| distance(a).total_cmp(&distance(b)))
}
