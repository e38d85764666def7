//! Records of two harmonics held at once, on the rig that slips and slaps.

use stickslip::harmonic::fourier::from_samples;
use stickslip::rig::{Chain, ChannelFault, DualMode, dual_mode_on};

use crate::common::pin_rig::{model_b, observed};

#[test]
fn records_show_the_harmonics_held_through_their_gains_and_the_truth_beside_them() {
    let mut rig = model_b();
    rig.beam.modes = 10;
    let gains = [1.02, 0.97, 1.0];
    let faults = gains.map(|gain| ChannelFault { gain, ..ChannelFault::default() });
    let chain = Chain { accelerometers: faults.to_vec(), ..Chain::default() };
    let test = DualMode { harmonics: 7, ..DualMode::at(52.0, vec![[7.0, 17.0], [14.0, 34.0]]) };
    let tested = dual_mode_on(&observed(&rig), &[0.55, 0.3, 0.05], &chain, &test).unwrap();
    assert_eq!(tested[1].record.name, "dual-mode-2.csv");
    for (tested, amplitudes) in tested.iter().zip(&test.amplitudes) {
        let shown = &tested.record.channel("acceleration:x=0.55").unwrap().values;
        let coefficients = from_samples(shown, test.periods, 7);
        for (order, amplitude) in [1, 3].into_iter().zip(amplitudes) {
            let found = coefficients[2 * order - 1].hypot(coefficients[2 * order]);
            assert!((found / (gains[0] * amplitude) - 1.0).abs() < 1e-9, "{found} {amplitude}");
        }
        // The force has the two tones alone, both sines.
        let force = from_samples(&tested.record.channel("excitation").unwrap().values, test.periods, 7);
        for (place, coefficient) in force.iter().enumerate() {
            assert!([2, 6].contains(&place) == (coefficient.abs() > 1e-9), "{force:?}");
        }
        let truth = tested.contact.as_ref().unwrap();
        let mean = |name: &str| from_samples(&truth.channel(name).unwrap().values, test.periods, 0)[0];
        // The mean motion is small: the mean normal load is the preload, nearly.
        assert!((mean("normal_load") / rig.preload() - 1.0).abs() < 0.05);
        assert!(mean("displacement").abs() < 1e-5 && mean("normal_displacement").abs() < 1e-6);
    }
}
