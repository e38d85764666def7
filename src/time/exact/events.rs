//! What ends a step of the exact flow: a contact's element changes its branch.

use super::elements::{Element, Memory};
use super::polynomial::{self, Series};

/// What ends a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Event {
    Rise,
    Fall,
    Turn,
}

/// Displacements of the contact between which no element changes its branch.
pub(super) fn edges(contact: usize, memory: &[Memory], elements: &[Element]) -> (f64, f64) {
    let mut edges = (f64::NEG_INFINITY, f64::INFINITY);
    for (memory, _) in memory.iter().zip(elements).filter(|(_, element)| element.contact == contact) {
        edges = (edges.0.max(memory.lower_edge), edges.1.min(memory.upper_edge));
    }
    edges
}

/// First event of a contact whose displacement is `u` over the step, and which is `turning` at its start.
pub(super) fn first_event(
    u: &Series,
    contact: usize,
    turning: bool,
    (memory, elements): (&[Memory], &[Element]),
) -> Option<(f64, Event)> {
    let (lower, upper) = edges(contact, memory, elements);
    let mut path = *u;
    if turning {
        path[1] = 0.0;
    }
    let mut first: Option<(f64, Event)> = None;
    let mut consider = |root: Option<f64>, event| {
        if let Some(root) = root
            && first.is_none_or(|(earlier, _)| root < earlier)
        {
            first = Some((root, event));
        }
    };
    let mut guard = path;
    guard[0] -= upper;
    consider(polynomial::first_rise(&mut guard), Event::Rise);
    guard = path.map(|c| -c);
    guard[0] += lower;
    consider(polynomial::first_rise(&mut guard), Event::Fall);
    let slip =
        |(memory, element): (&Memory, &Element)| if element.contact == contact { memory.slip() } else { 0.0 };
    if let Some(sign) = memory.iter().zip(elements).map(slip).find(|sign| *sign != 0.0) {
        guard = polynomial::derivative(u).map(|c| -sign * c);
        consider(polynomial::first_rise(&mut guard), Event::Turn);
    }
    first
}
