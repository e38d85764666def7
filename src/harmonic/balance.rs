//! Harmonic balance of the beam's modal equations with the contact, without excitation.
//!
//! With `w_i(t) = c_i − Σ G_ij q_j(t)` the displacement of the contact, `u = c·q − ½ qᵀG q`, has
//! `∂u/∂q_i = w_i`, and the contact acts on mode `i` by `T w_i`. Displacements with harmonics `0..=H`
//! give `u` harmonics `0..=2H`, and Galerkin projection of `T w_i` on `0..=H` sees `T`'s harmonics
//! `0..=2H` only: the contact is therefore one map between signals of `4H + 1` coefficients, and
//! everything else here is exact algebra on coefficients.

use nalgebra::DMatrix;

use super::cycle::sampled::{SampledCycle, transposed};
use super::fourier::{coefficient_count, multiplication, work_per_cycle};
use super::{ContactOnBeam, HarmonicError, Settings};
use crate::structure::ModalBeam;

/// Workspace for one beam, contact and set of harmonics.
#[derive(Debug)]
pub(crate) struct Balance<'a> {
    pub beam: &'a ModalBeam,
    pub contact: Option<ContactOnBeam<'a>>,
    /// Coefficients per mode, `2H + 1`.
    pub count: usize,
    /// Coefficients of all modes.
    pub unknowns: usize,
    /// Residual of the equations without excitation (N/√kg), mode after mode.
    pub residual: Vec<f64>,
    /// Its derivative by the coefficients.
    pub jacobian: DMatrix<f64>,
    /// Its derivative by the angular frequency.
    pub by_frequency: Vec<f64>,
    /// Coefficients of `u` before the series spring (m), harmonics `0..=2H`.
    pub displacement: Vec<f64>,
    cycle: SampledCycle,
    harmonics: usize,
    wide: usize,
    /// Coefficients of w_i.
    shape: Vec<f64>,
    /// Multiplications by w_i side by side, `wide × unknowns`.
    product: DMatrix<f64>,
    by_coefficients: DMatrix<f64>,
    force_product: Vec<f64>,
}

impl<'a> Balance<'a> {
    pub fn new(
        beam: &'a ModalBeam,
        contact: Option<ContactOnBeam<'a>>,
        settings: &Settings,
    ) -> Result<Self, HarmonicError> {
        settings.check()?;
        check_beam(beam)?;
        if let Some(contact) = &contact
            && !contact.normal_load.is_finite()
        {
            return Err(HarmonicError::InvalidInput("the normal load is not finite"));
        }
        let harmonics = settings.harmonics;
        let (count, wide) = (coefficient_count(harmonics), coefficient_count(2 * harmonics));
        let unknowns = count * beam.angular_frequency.len();
        Ok(Self {
            beam,
            contact,
            count,
            unknowns,
            residual: vec![0.0; unknowns],
            jacobian: DMatrix::zeros(unknowns, unknowns),
            by_frequency: vec![0.0; unknowns],
            displacement: vec![0.0; wide],
            cycle: SampledCycle::new(2 * harmonics, settings.samples),
            harmonics,
            wide,
            shape: vec![0.0; unknowns],
            product: DMatrix::zeros(wide, unknowns),
            by_coefficients: DMatrix::zeros(wide, unknowns),
            force_product: vec![0.0; count * count],
        })
    }

    /// Number of modes.
    pub fn modes(&self) -> usize {
        self.beam.angular_frequency.len()
    }

    /// Coefficients of the contact force (N), harmonics `0..=2H`, of the last evaluation.
    pub fn force(&self) -> &[f64] {
        &self.cycle.force
    }

    /// Energy dissipated in the contact per cycle (J) at the last evaluation: the work of the force on
    /// the displacement before the series spring, which stores and returns its share.
    pub fn dissipated_energy(&self) -> f64 {
        if self.contact.is_some() { work_per_cycle(&self.cycle.force, &self.displacement) } else { 0.0 }
    }

    /// Forgets the contact's last periodic state.
    pub fn forget(&mut self) {
        self.cycle.forget();
    }

    /// The contact alone, driven by `u` given by its coefficients (harmonics `0..=2H`): coefficients of
    /// the force.
    pub fn contact_force(&mut self, angular_frequency: f64, u: &[f64]) -> Result<&[f64], HarmonicError> {
        if let Some(contact) = &self.contact {
            self.cycle.evaluate(contact, self.beam.axial_flexibility, angular_frequency, u)?;
        }
        Ok(&self.cycle.force)
    }

    /// Coefficients of `u` (m) for modal coefficients `q`.
    pub fn contact_displacement(&mut self, q: &[f64]) -> &[f64] {
        let (modes, count, wide) = (self.modes(), self.count, self.wide);
        for i in 0..modes {
            let shape = &mut self.shape[i * count..(i + 1) * count];
            shape.fill(0.0);
            shape[0] = self.beam.contact_shape[i];
            for j in 0..modes {
                let g = self.beam.shortening[i * modes + j];
                shape.iter_mut().zip(&q[j * count..(j + 1) * count]).for_each(|(s, q)| *s -= g * q);
            }
        }
        // u = ½ Σ (w_i + c_i) q_i.
        self.displacement.fill(0.0);
        for i in 0..modes {
            let block = &mut self.product.as_mut_slice()[i * count * wide..(i + 1) * count * wide];
            multiplication(&self.shape[i * count..(i + 1) * count], self.harmonics, wide, block);
            for (k, column) in block.chunks_exact(wide).enumerate() {
                let q = 0.5 * q[i * count + k];
                self.displacement.iter_mut().zip(column).for_each(|(u, w)| *u += w * q);
                self.displacement[k] += self.beam.contact_shape[i] * q;
            }
        }
        &self.displacement
    }

    /// Residual and Jacobian at the coefficients `q` and the fundamental `angular_frequency`.
    /// Returns the size of the largest force in the balance, to judge the residual by.
    pub fn evaluate(&mut self, q: &[f64], angular_frequency: f64) -> Result<f64, HarmonicError> {
        self.contact_displacement(q);
        self.jacobian.fill(0.0);
        self.by_frequency.fill(0.0);
        self.residual.fill(0.0);
        let mut scale = 0.0_f64;
        if let Some(contact) = &self.contact {
            let compliance = self.beam.axial_flexibility;
            self.cycle.evaluate(contact, compliance, angular_frequency, &self.displacement)?;
            self.add_contact();
            scale = self.residual.iter().fold(scale, |scale, r| scale.max(r.abs()));
        }
        Ok(self.add_linear(q, angular_frequency).max(scale))
    }

    /// Adds `T w_i` projected on the harmonics, and its derivatives.
    fn add_contact(&mut self) {
        let (modes, count, wide, unknowns) = (self.modes(), self.count, self.wide, self.unknowns);
        // Mean squares of the basis functions: 1 for the bias, ½ for the rest. Projection on b_k is
        // ⟨T w b_k⟩/⟨b_k²⟩, and ⟨T w b_k⟩ = Σ_m T_m ⟨b_m²⟩ W_mk.
        let mean_square = |m: usize| if m.is_multiple_of(count) { 1.0 } else { 0.5 };
        let weight = |m: usize| if m == 0 { 1.0 } else { 0.5 };
        for (k, column) in self.product.as_slice().chunks_exact(wide).enumerate() {
            let project = |signal: &[f64]| -> f64 {
                let sum: f64 = signal.iter().zip(column).skip(1).map(|(t, w)| t * w).sum();
                (signal[0] * column[0] + 0.5 * sum) / mean_square(k)
            };
            self.residual[k] = project(&self.cycle.force);
            self.by_frequency[k] = project(&self.cycle.by_frequency);
        }
        self.by_coefficients.gemm(1.0, &self.cycle.jacobian, &self.product, 0.0);
        for column in self.by_coefficients.as_mut_slice().chunks_exact_mut(wide) {
            column.iter_mut().enumerate().for_each(|(m, x)| *x *= weight(m));
        }
        let left = transposed(self.product.as_slice(), wide, unknowns, wide);
        self.jacobian.gemm(1.0, &left, &self.by_coefficients, 0.0);
        for column in self.jacobian.as_mut_slice().chunks_exact_mut(unknowns) {
            column.iter_mut().enumerate().for_each(|(k, x)| *x /= mean_square(k));
        }
        // ∂w_i/∂q_j = −G_ij.
        multiplication(&self.cycle.force, self.harmonics, count, &mut self.force_product);
        for j in 0..modes {
            for i in 0..modes {
                let g = self.beam.shortening[i * modes + j];
                if g == 0.0 {
                    continue;
                }
                for k in 0..count {
                    let source = &self.force_product[k * count..(k + 1) * count];
                    let start = (j * count + k) * unknowns + i * count;
                    let target = &mut self.jacobian.as_mut_slice()[start..start + count];
                    target.iter_mut().zip(source).for_each(|(t, s)| *t -= g * s);
                }
            }
        }
    }

    /// Adds inertia, damping and stiffness of the modes; returns the largest elastic force.
    fn add_linear(&mut self, q: &[f64], angular_frequency: f64) -> f64 {
        let mut scale = 0.0_f64;
        for i in 0..self.modes() {
            let (natural, ratio) = (self.beam.angular_frequency[i], self.beam.damping_ratio[i]);
            let (stiffness, start) = (natural * natural, i * self.count);
            self.residual[start] += stiffness * q[start];
            self.jacobian[(start, start)] += stiffness;
            scale = scale.max((stiffness * q[start]).abs());
            for h in 1..=self.harmonics {
                let (c, s) = (start + 2 * h - 1, start + 2 * h);
                let order = h as f64;
                let dynamic = stiffness - (order * angular_frequency).powi(2);
                let damping_rate = 2.0 * ratio * natural * order;
                let damping = damping_rate * angular_frequency;
                self.residual[c] += dynamic * q[c] + damping * q[s];
                self.residual[s] += dynamic * q[s] - damping * q[c];
                self.jacobian[(c, c)] += dynamic;
                self.jacobian[(s, s)] += dynamic;
                self.jacobian[(c, s)] += damping;
                self.jacobian[(s, c)] -= damping;
                let inertia_rate = -2.0 * order * order * angular_frequency;
                self.by_frequency[c] += inertia_rate * q[c] + damping_rate * q[s];
                self.by_frequency[s] += inertia_rate * q[s] - damping_rate * q[c];
                scale = scale.max((stiffness * q[c]).abs()).max((stiffness * q[s]).abs());
            }
        }
        scale
    }

    /// Energy the modal damping takes per cycle (J).
    pub fn viscous_energy(&self, q: &[f64], angular_frequency: f64) -> f64 {
        let mut sum = 0.0;
        for i in 0..self.modes() {
            let damping = 2.0 * self.beam.damping_ratio[i] * self.beam.angular_frequency[i];
            for h in 1..=self.harmonics {
                let (c, s) = (q[i * self.count + 2 * h - 1], q[i * self.count + 2 * h]);
                sum += damping * angular_frequency * (h * h) as f64 * (c * c + s * s);
            }
        }
        std::f64::consts::PI * sum
    }
}

fn check_beam(beam: &ModalBeam) -> Result<(), HarmonicError> {
    let modes = beam.angular_frequency.len();
    if modes == 0 {
        return Err(HarmonicError::InvalidInput("the beam has no modes"));
    }
    let same_length = [&beam.damping_ratio, &beam.contact_shape, &beam.excitation_shape];
    if same_length.iter().any(|v| v.len() != modes) || beam.shortening.len() != modes * modes {
        return Err(HarmonicError::InvalidInput("the beam's arrays do not have one entry per mode"));
    }
    let all =
        same_length.iter().flat_map(|v| v.iter()).chain(&beam.angular_frequency).chain(&beam.shortening);
    if all.chain([&beam.axial_flexibility]).any(|x| !x.is_finite()) {
        return Err(HarmonicError::InvalidInput("the beam has a value that is not finite"));
    }
    if beam.angular_frequency.iter().any(|w| *w <= 0.0) || beam.axial_flexibility < 0.0 {
        return Err(HarmonicError::InvalidInput(
            "a natural frequency or the axial flexibility is not positive",
        ));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::{
        ContactLaw, Inputs, Jenkins, Response, SlipState, StateTangents, Tangents, Valanis,
    };

    fn beam() -> ModalBeam {
        ModalBeam {
            angular_frequency: vec![300.0, 900.0],
            damping_ratio: vec![0.01, 0.02],
            contact_shape: vec![-0.06, 0.115],
            excitation_shape: vec![0.35, -0.7],
            shortening: vec![32.0, -4.0, -4.0, 110.0],
            axial_flexibility: 2e-8,
            sensors: Vec::new(),
        }
    }

    /// A rate-dependent law without memory: a spring and a damper.
    #[derive(Debug)]
    struct Damper(f64, f64);

    impl ContactLaw for Damper {
        fn state_len(&self) -> usize {
            0
        }

        fn set_state(&self, _: f64, _: f64, _: f64, _: &mut [f64]) {}

        fn step(&self, _: &[f64], inputs: Inputs, _: &mut [f64]) -> Response {
            let tangents = Tangents { displacement: self.0, velocity: self.1, normal_load: 0.0 };
            Response {
                force: self.0 * inputs.displacement + self.1 * inputs.velocity,
                tangents,
                dissipated_energy: 0.0,
                slip_state: SlipState::Stick,
            }
        }

        fn state_tangents(&self, _: &[f64], _: Inputs, out: &mut StateTangents) {
            out.reset(0);
        }

        fn limit(&self, _: f64) -> f64 {
            f64::INFINITY
        }
    }

    /// Largest difference between Jacobian and central differences, as share of the largest entry of
    /// each column; the last column is the frequency's.
    fn jacobian_error(law: &dyn ContactLaw, size: f64) -> f64 {
        let beam = beam();
        let settings = Settings { harmonics: 3, samples: 64, ..Settings::default() };
        let contact = ContactOnBeam { law, normal_load: 100.0 };
        let mut balance = Balance::new(&beam, Some(contact), &settings).unwrap();
        let n = balance.unknowns;
        let mut x: Vec<f64> = (0..n).map(|k| size * [0.1, 0.4, 1.0, -0.2, 0.1, 0.15, -0.05][k % 7]).collect();
        x.push(310.0);
        balance.evaluate(&x[..n], x[n]).unwrap();
        // A second evaluation nearby starts from the first: its derivative must be just as good.
        x[2] *= 1.001;
        balance.evaluate(&x[..n], x[n]).unwrap();
        let (jacobian, by_frequency) = (balance.jacobian.clone(), balance.by_frequency.clone());
        let mut worst = 0.0_f64;
        for j in 0..=n {
            let step = 1e-6 * if j == n { x[n] } else { size };
            let mut side = |sign: f64| {
                let mut moved = x.clone();
                moved[j] += sign * step;
                balance.forget();
                balance.evaluate(&moved[..n], moved[n]).unwrap();
                balance.residual.clone()
            };
            let (up, down) = (side(1.0), side(-1.0));
            let exact = |i: usize| if j == n { by_frequency[i] } else { jacobian[(i, j)] };
            let largest = (0..n).fold(0.0_f64, |m, i| m.max(exact(i).abs()));
            for i in 0..n {
                let difference = (up[i] - down[i]) / (2.0 * step);
                worst = worst.max((exact(i) - difference).abs() / largest);
            }
        }
        worst
    }

    #[test]
    fn jacobian_equals_central_differences() {
        let cases: [(&dyn ContactLaw, f64); 6] = [
            (&Valanis::new(5e6, 0.9, 0.3, 0.0).unwrap(), 3e-5),
            (&Valanis::new(5e6, 0.9, 0.3, 0.0).unwrap(), 5e-4),
            (&Valanis::new(5e6, 0.9, 0.7, 4e5).unwrap(), 5e-4),
            (&Jenkins::new(5e6, 0.9).unwrap(), 1e-5),
            (&Jenkins::new(5e6, 0.9).unwrap(), 5e-4),
            (&Damper(3e6, 2e3), 3e-4),
        ];
        for (law, size) in cases {
            let error = jacobian_error(law, size);
            assert!(error < 3e-6, "{law:?} at {size}: {error}");
        }
    }

    /// Dissipation of the contact alone under `u = U sin θ`.
    fn loop_of(law: &dyn ContactLaw, load: f64, amplitude: f64, samples: usize) -> f64 {
        let mut beam = beam();
        beam.axial_flexibility = 0.0;
        let settings = Settings { harmonics: 2, samples, ..Settings::default() };
        let contact = ContactOnBeam { law, normal_load: load };
        let mut balance = Balance::new(&beam, Some(contact), &settings).unwrap();
        balance.displacement[2] = amplitude;
        let u = balance.displacement.clone();
        balance.contact_force(300.0, &u).unwrap();
        balance.dissipated_energy()
    }

    #[test]
    fn jenkins_loop_area_equals_4_limit_times_slip() {
        let law = Jenkins::new(5e6, 0.9).unwrap();
        let exact = 4.0 * 90.0 * (6e-5 - 90.0 / 5e6);
        let error = |samples: usize| (loop_of(&law, 100.0, 6e-5, samples) / exact - 1.0).abs();
        assert!(error(128) < 2e-3 && error(1024) < 3e-5, "{} {}", error(128), error(1024));
        assert!(loop_of(&law, 100.0, 1e-5, 128).abs() < 1e-18, "a stuck contact dissipates nothing");
    }

    #[test]
    fn valanis_periodic_loops_have_the_reference_areas() {
        // Published parameters; areas from an independent solution. At 1 µm marching alone would need
        // twenty cycles.
        let law = Valanis::from_lambda(7.9e6, 0.0, 0.3, 8.7e4, 147.15).unwrap();
        for (amplitude, area) in [(1e-6, 6.40993067e-7), (1e-5, 5.82422872e-4), (5e-5, 1.39860743e-2)] {
            let found = loop_of(&law, 147.15, amplitude, 1024);
            assert!((found / area - 1.0).abs() < 2e-4, "{amplitude}: {found}");
        }
    }
}
