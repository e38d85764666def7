//! Random numbers that are the same everywhere and for ever: a sealed case is its seed.

use std::f64::consts::TAU;

/// xoshiro256++ (Blackman & Vigna 2018), seeded by splitmix64.
pub struct Random {
    state: [u64; 4],
    /// Box and Muller's second number.
    spare: Option<f64>,
}

impl Random {
    /// The stream of a seed.
    pub fn new(seed: u64) -> Self {
        let mut mixed = seed;
        let state = std::array::from_fn(|_| {
            mixed = mixed.wrapping_add(0x9e37_79b9_7f4a_7c15);
            let first = (mixed ^ (mixed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            let second = (first ^ (first >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
            second ^ (second >> 31)
        });
        Self { state, spare: None }
    }

    /// A stream of its own, so that what one part draws does not move another's numbers.
    pub fn fork(&mut self) -> Self {
        Self::new(self.bits())
    }

    /// The next 64 bits.
    pub fn bits(&mut self) -> u64 {
        let s = &mut self.state;
        let result = s[0].wrapping_add(s[3]).rotate_left(23).wrapping_add(s[0]);
        let shifted = s[1] << 17;
        s[2] ^= s[0];
        s[3] ^= s[1];
        s[1] ^= s[2];
        s[0] ^= s[3];
        s[2] ^= shifted;
        s[3] = s[3].rotate_left(45);
        result
    }

    /// Uniform in [0, 1).
    pub fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 * (1.0 / (1_u64 << 53) as f64)
    }

    /// Uniform in [low, high).
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// Uniform in its logarithm.
    pub fn magnitude(&mut self, low: f64, high: f64) -> f64 {
        (self.between(low.ln(), high.ln())).exp()
    }

    /// 1 ± `half_width`.
    pub fn about_one(&mut self, half_width: f64) -> f64 {
        self.between(1.0 - half_width, 1.0 + half_width)
    }

    /// An angle (rad).
    pub fn phase(&mut self) -> f64 {
        self.between(0.0, TAU)
    }

    /// +1 or −1.
    pub fn sign(&mut self) -> f64 {
        if self.unit() < 0.5 { -1.0 } else { 1.0 }
    }

    /// One of several.
    pub fn pick<T: Copy>(&mut self, of: &[T]) -> T {
        of[((self.unit() * of.len() as f64) as usize).min(of.len() - 1)]
    }

    /// Standard normal.
    pub fn normal(&mut self) -> f64 {
        if let Some(spare) = self.spare.take() {
            return spare;
        }
        let radius = (-2.0 * (1.0 - self.unit()).ln()).sqrt();
        let angle = self.phase();
        self.spare = Some(radius * angle.sin());
        radius * angle.cos()
    }

    /// Adds noise of standard deviation `size` to `values`: white, or AR(1) with this correlation from one
    /// sample to the next.
    pub fn add_noise(&mut self, values: &mut [f64], size: f64, correlation: f64) {
        let innovation = (1.0 - correlation * correlation).sqrt();
        let mut noise = self.normal();
        for value in values {
            *value += size * noise;
            noise = correlation * noise + innovation * self.normal();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_has_the_size_and_the_correlation_asked_for() {
        for correlation in [0.0, 0.9] {
            let mut values = vec![0.0; 200_000];
            Random::new(5).add_noise(&mut values, 3.0, correlation);
            let count = values.len() as f64;
            let variance = values.iter().map(|v| v * v).sum::<f64>() / count;
            let lagged = values.windows(2).map(|v| v[0] * v[1]).sum::<f64>() / count;
            assert!((variance / 9.0 - 1.0).abs() < 0.05, "{variance}");
            assert!((lagged / variance - correlation).abs() < 0.02, "{lagged}");
        }
    }

    #[test]
    fn streams_differ_by_seed_and_repeat() {
        let draw = |seed| (0..4).map(|_| Random::new(seed).unit()).collect::<Vec<_>>();
        assert_eq!(draw(1), draw(1));
        assert_ne!(draw(1), draw(2));
        let mean = {
            let mut random = Random::new(9);
            (0..100_000).map(|_| random.unit()).sum::<f64>() / 1e5
        };
        assert!((mean - 0.5).abs() < 0.005, "{mean}");
    }
}
