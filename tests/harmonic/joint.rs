//! A contact with effects in harmonic balance: carried over a period exactly and by samples, with its derivative.

use stickslip::contact::{ContactLaw, Jenkins, Joint, JointChanges, Valanis};
use stickslip::harmonic::{ContactMapping, HarmonicSet, Method};

use crate::common::contact::LOAD;
use crate::common::cycle::{differences, evaluated, motions};

/// Motions are of the size of one; so is the yield displacement here.
fn joints() -> Vec<(&'static str, Joint)> {
    let none = JointChanges::default();
    let (stiffness, friction) = (1.0, 0.4 / LOAD);
    let weakening = Some((0.3, 200.0));
    let springs = JointChanges { residual_stiffness: 0.1, cubic_stiffness: 0.05, ..none };
    let list = [
        ("spread", JointChanges { spread: 0.7, ..none }),
        ("asymmetry", JointChanges { asymmetry: 0.3, ..none }),
        ("residual stiffness", JointChanges { residual_stiffness: 0.2, ..none }),
        ("backlash", JointChanges { half_gap: 0.2, ..none }),
        ("damping", JointChanges { damping: 5e-4, ..none }),
        ("springs", springs),
        ("weakening", JointChanges { weakening, ..none }),
        ("springs behind a play", JointChanges { half_gap: 0.2, ..springs }),
        ("damper behind a play", JointChanges { half_gap: 0.2, damping: 5e-4, ..none }),
        (
            "weakening and damper behind a play",
            JointChanges { half_gap: 0.2, damping: 5e-4, weakening, ..none },
        ),
        ("damper that feeds, behind a play", JointChanges { half_gap: 0.2, damping: -2e-4, ..none }),
        ("springs and damper behind a play", JointChanges { half_gap: 0.2, damping: 5e-4, ..springs }),
        (
            "all",
            JointChanges { spread: 0.6, weakening, asymmetry: 0.2, half_gap: 0.1, damping: 2e-4, ..springs },
        ),
    ];
    let mut all: Vec<(&str, Joint)> = list
        .into_iter()
        .map(|(name, changes)| {
            let base = Jenkins::new(stiffness, friction).unwrap();
            (name, Joint::new(base, changes).unwrap())
        })
        .collect();
    let base = Valanis::new(stiffness, friction, 0.3, 0.0).unwrap();
    let changes = JointChanges { asymmetry: 0.3, cubic_stiffness: 0.05, ..none };
    all.push(("valanis", Joint::new(base, changes).unwrap()));
    let changes = JointChanges { half_gap: 0.2, damping: 5e-4, ..none };
    all.push(("valanis and damper behind a play", Joint::new(base, changes).unwrap()));
    all
}

#[test]
fn the_exact_cycle_is_the_limit_of_the_sampled_one() {
    let set = HarmonicSet::full(5);
    let mut failures = Vec::new();
    for (name, law) in joints() {
        for (motion, u) in motions() {
            let exact = evaluated(&law, 0.0, set, &u);
            let mut sampled = ContactMapping::new(set, Method::Sampled { samples: 4096 });
            sampled.evaluate(&law, LOAD, 0.0, 300.0, &u).unwrap();
            let difference =
                exact.force().iter().zip(sampled.force()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            // Where the limit moves both are sampled, one more finely than the other.
            // Samples meet a jump of the force to the first order of the step only.
            let jumps = law.changes().half_gap > 0.0 && law.changes().damping != 0.0;
            if difference >= if law.limit_moves() || jumps { 1e-3 } else { 2e-4 } {
                failures.push(format!("{name}, {motion}: {difference:e}"));
            }
        }
    }
    assert!(failures.is_empty(), "{failures:#?}");
}

#[test]
fn the_jacobian_is_the_derivative_of_the_force() {
    let set = HarmonicSet::full(5);
    let mut failures = Vec::new();
    for (name, law) in joints() {
        for (motion, u) in motions() {
            // Samples of a moving limit leave small jumps, which short differences would magnify.
            let (step, tolerance) = if law.limit_moves() { (3e-3, 0.15) } else { (1e-5, 4e-3) };
            for compliance in if law.limit_moves() { vec![0.0] } else { vec![0.0, 0.3] } {
                let map = evaluated(&law, compliance, set, &u);
                let expected = differences(&law, compliance, set, &u, step);
                let error = (map.jacobian() - &expected).abs().max();
                if error >= tolerance {
                    failures.push(format!("{name}, {motion}, {compliance}: {error:e}"));
                }
            }
        }
    }
    assert!(failures.is_empty(), "{failures:#?}");
}
