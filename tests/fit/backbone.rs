//! A contact law recovered from a backbone that the harmonic balance itself made.

use std::f64::consts::TAU;

use stickslip::contact::Valanis;
use stickslip::fit::{Options, Parameter, Scale, fit};
use stickslip::harmonic::{CurveSettings, HarmonicError, Method, backbone};
use stickslip::system::ModalBeam;

use crate::common::beam::modal;
use crate::common::contact::loaded;

const LOAD: f64 = 100.0;

#[test]
fn valanis_parameters_are_recovered_from_exact_frequencies() {
    let beam = ModalBeam {
        shortening: vec![32.0],
        axial_flexibility: 1.5e-8,
        ..modal(&[TAU * 49.0], &[0.003], &[0.06], &[0.4])
    };
    let settings =
        CurveSettings { harmonics: 3, method: Method::Sampled { samples: 64 }, ..CurveSettings::default() };
    let amplitudes = [1.0, 12.0, 30.0, 70.0];
    let frequencies = |p: &[f64]| -> Result<Vec<f64>, HarmonicError> {
        let law = Valanis::new(p[0], p[1] / LOAD, p[2], 0.0)
            .map_err(|_| HarmonicError::InvalidInput("the law refuses the parameters"))?;
        let contact = loaded(law, LOAD);
        let found = backbone(&beam.system(contact.clone()).unwrap(), &amplitudes, &settings, &[])?;
        Ok(found.iter().map(|r| r.angular_frequency / TAU).collect())
    };
    let truth = [6.0e6, 95.0, 0.4];
    let measured = frequencies(&truth).unwrap();
    assert!(
        measured.windows(2).all(|pair| pair[1] < pair[0] - 0.05),
        "the backbone must soften: {measured:?}"
    );
    let residual = |p: &[f64], out: &mut [f64]| -> Result<(), HarmonicError> {
        out.iter_mut().zip(frequencies(p)?).zip(&measured).for_each(|((r, f), m)| *r = f - m);
        Ok(())
    };
    let parameters = [
        Parameter { start: 9e6, lower: 1e5, upper: 1e8, scale: Scale::Logarithmic },
        Parameter { start: 60.0, lower: 1.0, upper: 1e4, scale: Scale::Logarithmic },
        Parameter { start: 0.1, lower: 0.0, upper: 0.98, scale: Scale::Linear },
    ];
    let fit = fit(residual, amplitudes.len(), &parameters, &Options::default()).unwrap();
    for (found, truth) in fit.parameters.iter().zip(truth) {
        assert!((found / truth - 1.0).abs() < 1e-4, "{:?}", fit.parameters);
    }
    assert!(fit.root_mean_square < 1e-6);
}
