//! What happens on a stretch of time.

use super::polynomial::{self, Series};

/// What a motion did on a stretch of time.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Passage {
    /// Smallest and largest displacement of every output (m), at the exact turning points.
    pub output_range: Vec<(f64, f64)>,
    /// Smallest and largest displacement of every contact (m).
    pub contact_range: Vec<(f64, f64)>,
    /// Energy taken by every contact (J).
    pub dissipated_energy: Vec<f64>,
    /// Time in which a slider of the contact slips, for every contact (s).
    pub slip_time: Vec<f64>,
    /// Whether each slider slipped, contact after contact.
    pub slipped: Vec<bool>,
    /// Energy taken by the dampers (J).
    pub viscous_energy: f64,
    /// Work of the excitation (J).
    pub work: f64,
    /// Changes of branch.
    pub events: usize,
    /// Steps made.
    pub steps: usize,
}

impl Passage {
    pub(super) fn new(outputs: usize, contacts: usize, sliders: usize) -> Self {
        let nothing = (f64::INFINITY, f64::NEG_INFINITY);
        Self {
            output_range: vec![nothing; outputs],
            contact_range: vec![nothing; contacts],
            dissipated_energy: vec![0.0; contacts],
            slip_time: vec![0.0; contacts],
            slipped: vec![false; sliders],
            ..Self::default()
        }
    }

    /// Largest magnitude of the displacement of output `k` (m); NaN where there is no such output.
    pub fn amplitude(&self, k: usize) -> f64 {
        self.output_range.get(k).map_or(f64::NAN, |(low, high)| high.max(-low))
    }

    /// Energy taken by all contacts (J).
    pub fn total_dissipated_energy(&self) -> f64 {
        self.dissipated_energy.iter().sum()
    }
}

/// Widens `range` to the values of `c` on `[0, end]`.
pub(super) fn widen(range: &mut (f64, f64), c: &Series, end: f64) {
    let mut take = |value: f64| *range = (range.0.min(value), range.1.max(value));
    take(c[0]);
    take(polynomial::value(c, end));
    let spread: f64 = c[1..].iter().map(|c| c.abs()).sum();
    if c[0] + spread <= range.1 && c[0] - spread >= range.0 {
        return;
    }
    let mut take = |value: f64| *range = (range.0.min(value), range.1.max(value));
    polynomial::sign_changes(&polynomial::derivative(c), &mut |x, _| {
        if x < end {
            take(polynomial::value(c, x));
        }
        x < end
    });
}

/// Gauss–Legendre nodes and weights on [0, 1], eight points: exact to rounding for products of motions
/// over a step.
pub(super) const RULE: [(f64, f64); 8] = [
    (0.019_855_071_751_231_88, 0.050_614_268_145_188_13),
    (0.101_666_761_293_186_63, 0.111_190_517_226_687_24),
    (0.237_233_795_041_835_5, 0.156_853_322_938_943_64),
    (0.408_282_678_752_175_1, 0.181_341_891_689_181),
    (0.591_717_321_247_825, 0.181_341_891_689_181),
    (0.762_766_204_958_164_5, 0.156_853_322_938_943_64),
    (0.898_333_238_706_813_4, 0.111_190_517_226_687_24),
    (0.980_144_928_248_768_1, 0.050_614_268_145_188_13),
];
