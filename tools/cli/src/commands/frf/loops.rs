//! Loops of the contacts at the peaks of a curve.

use stickslip::harmonic::{Assembly, Control, Curve, Peak, Point, periodic_response};
use stickslip::system::Element;
use stickslip_report::responses::ContactLoop;
use stickslip_report::{contact_loop, slip_slap_loops};

use super::Request;

/// Peaks nearer to each other than this fraction of their frequency are one resonance.
const SAME: f64 = 0.03;

/// The loops of the model's contact at the peaks of a curve, one for each resonance, of both directions where it has two.
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
        let name = format!("{level} {unit}, {}", request.unit.shown(point.angular_frequency));
        loops.extend(of_contact(assembly, point).into_iter().enumerate().map(
            |(direction, (displacement, force))| ContactLoop {
                name: name.clone(),
                displacement,
                force,
                is_normal: direction == 1,
            },
        ));
    }
    loops
}

/// Displacement (m) and force (N) of the model's contact over a period, and those of its normal direction if it has one.
fn of_contact(assembly: &Assembly, point: &Point) -> Vec<(Vec<f64>, Vec<f64>)> {
    let speed = point.angular_frequency;
    let in_two = assembly.system.elements.iter().find_map(|element| match element {
        Element::SlipSlap { contact, .. } => Some(contact),
        _ => None,
    });
    match (in_two, assembly.system.laws().next(), point.contacts.as_slice()) {
        (Some(contact), _, [along, across, ..]) => {
            let both = [along.displacement.as_slice(), across.displacement.as_slice()];
            slip_slap_loops(contact, speed, both).map(Vec::from).unwrap_or_default()
        }
        (None, Some((_, law, normal_load)), [at, ..]) => {
            contact_loop(law.as_ref(), normal_load, speed, &at.displacement).into_iter().collect()
        }
        _ => Vec::new(),
    }
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
