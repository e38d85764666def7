//! The force alone is the force of a whole evaluation, whatever the scheme by which a contact is carried over a period.

use super::map::ContactMap;
use super::reference::ReferenceCycle;
use super::{Cycle, PeriodicContact};
use crate::contact::JointChanges;
use crate::contact::{ContactLaw, Jenkins, Joint, Valanis};
use crate::harmonic::Method;
use crate::numeric::HarmonicSet;

const OMEGA: f64 = 300.0;
/// Slips in both directions, with harmonics that make no reversal more.
const SLIPPING: [f64; 7] = [0.1, 1.0, 0.2, 0.05, -0.1, 0.03, 0.04];
/// As small as the slope of Valanis' law fades slowly, and turned so that no sample is a turning point's.
const SMALL: [f64; 7] = [0.02, -0.2, 0.3, 0.02, 0.03, -0.01, 0.02];
const WIDER: usize = 7;

fn joint(changes: JointChanges) -> Box<dyn ContactLaw> {
    Box::new(Joint::new(Jenkins::new(1.0, 0.4).unwrap(), changes).unwrap())
}

/// Laws for each of the schemes, of states of different lengths.
fn laws() -> Vec<Box<dyn ContactLaw>> {
    let none = JointChanges::default();
    vec![
        joint(none),
        joint(JointChanges { damping: 2e-3, ..none }),
        joint(JointChanges { spread: 0.8, ..none }),
        joint(JointChanges { half_gap: 0.05, damping: 2e-3, ..none }),
        joint(JointChanges { spread: 0.8, half_gap: 0.05, residual_stiffness: 0.1, ..none }),
        joint(JointChanges { spread: 0.8, normal_cubic_stiffness: 0.2, asymmetry: 0.1, ..none }),
        joint(JointChanges { weakening: Some((0.5, 100.0)), ..none }),
        Box::new(Valanis::new(1.0, 0.4, 0.3, 0.05).unwrap()),
    ]
}

fn loaded<'a>(law: &'a dyn ContactLaw, load_swing: &'a [f64]) -> PeriodicContact<'a> {
    PeriodicContact { law, normal_load: 1.0, load_swing, compliance: 0.0 }
}

#[test]
fn the_force_alone_is_that_with_derivatives_on_any_harmonics() {
    // One workspace goes through all laws, as one balance lends it to the next.
    let mut lean = ContactMap::new(HarmonicSet::full(3), Method::Exact, 0.0);
    let motions = [SLIPPING, SMALL];
    for law in laws() {
        for (swing, u) in
            [&[][..], &[0.3, 0.1, 0.0, 0.2]].into_iter().flat_map(|swing| motions.map(|u| (swing, u)))
        {
            let contact = loaded(law.as_ref(), swing);
            let mut whole = ContactMap::new(HarmonicSet::full(3), Method::Exact, 0.0);
            whole.evaluate(&contact, OMEGA, &u).unwrap();
            let wider = HarmonicSet::full(WIDER);
            let size = whole.force().iter().fold(0.0, |most: f64, force| most.max(force.abs()));
            let (mut expected, mut found) = (vec![0.0; wider.len()], vec![0.0; wider.len()]);
            whole.force_on(wider, &mut expected);
            lean.forget();
            lean.force_alone(&contact, OMEGA, &u, wider, &mut found).unwrap();
            let mut own = vec![0.0; u.len()];
            lean.force_on(HarmonicSet::full(3), &mut own);
            let pairs = expected.iter().zip(&found).chain(whole.force().iter().zip(&own));
            for (expected, found) in pairs {
                assert!(
                    (expected - found).abs() < 1e-10 * size,
                    "{expected} {found} {law:?} {swing:?} {u:?}"
                );
            }
            // What the force alone left behind does no harm to what follows.
            lean.evaluate(&contact, OMEGA, &u).unwrap();
            assert!((lean.jacobian() - whole.jacobian()).amax() < 1e-8 * whole.jacobian().amax());
        }
    }
}

#[test]
fn derivatives_of_the_sampled_force_can_be_made_later() {
    let law = joint(JointChanges { damping: 2e-3, ..JointChanges::default() });
    let contact = loaded(law.as_ref(), &[0.3, 0.1, 0.0, 0.4]);
    let mut whole = ReferenceCycle::new(HarmonicSet::full(3), 256);
    whole.evaluate(&contact, OMEGA, &SLIPPING).unwrap();
    let mut parts = ReferenceCycle::new(HarmonicSet::full(3), 256);
    parts.evaluate_force(&contact, OMEGA, &SLIPPING).unwrap();
    assert_eq!(parts.jacobian().amax(), 0.0, "not made yet");
    for (alone, force) in parts.force().iter().zip(whole.force()) {
        assert!((alone - force).abs() < 1e-12, "{alone} {force}");
    }
    parts.complete(&contact, OMEGA, &SLIPPING).unwrap();
    assert!((parts.jacobian() - whole.jacobian()).amax() < 1e-10);
}
