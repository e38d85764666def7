//! Harmonic balance of a system condensed to its ports, which are linear: its laws are the contacts of a linear structure.
//!
//! Unknowns are the Fourier coefficients of the contacts' displacements, contact after contact. In
//! compliance form every harmonic reads
//!
//! `u_h + Σ_j H_cj(hΩ) T_j,h(u_j) − level · H_ce(hΩ) f_h = 0`,
//!
//! all in metres, so that the stopping rule is a fraction of the largest displacement. The other points of the
//! structure follow from the solution, without iteration. No contact at all is a linear response.
//!
//! Where every law is odd and the excitation has odd harmonics alone, so may the response, and the set of
//! harmonics is the odd one: half the unknowns. Responses that break this symmetry are out of its sight.

mod guess;
mod outcome;

use nalgebra::DMatrix;

use super::assembly::{Assembly, CurveSettings};
use super::attached::Attached;
use super::transfer::{Of, Transfer, add_product};
use crate::harmonic::newton::system::{Observation, Operating, PeriodicSystem, Scalar};
use crate::harmonic::period::Cycle;
use crate::harmonic::period::map::ContactMap;
use crate::harmonic::stability::Undecided;
use crate::harmonic::{HarmonicError, Method, Point};
use crate::numeric::HarmonicSet;
use crate::numeric::extremum::Extremum;
use crate::system::{Element, LinearStructure, Output, Receptance, Rows, System};

/// The balance of one system.
pub(crate) struct Condensed {
    structure: LinearStructure,
    receptance: Receptance,
    contacts: Vec<Attached>,
    /// The same contacts on twice the harmonics, to see what the set leaves out.
    wider: Vec<Option<ContactMap>>,
    waveform: Vec<f64>,
    method: Method,
    /// Damper (N s/m) that the structure has taken over from every contact.
    damping_shift: f64,
    odd: bool,
    set: HarmonicSet,
    wide: HarmonicSet,
    /// Orders and places of the set.
    orders: Vec<(usize, usize)>,
    nodes: usize,
    at_contacts: Transfer,
    everywhere: Transfer,
    beyond: Transfer,
    one: Transfer,
    /// The excitation at level 1 on the set, and on the wide one.
    excitation: Vec<f64>,
    wide_excitation: Vec<f64>,
    residual: Vec<f64>,
    jacobian: DMatrix<f64>,
    by: [Vec<f64>; 4],
    at: Operating,
    extremum: Extremum,
    scratch: Scratch,
    /// Ω (rad/s) and the rounding of the balance about it.
    rounding: Option<(f64, f64)>,
}

/// Buffers of the estimate and of derivatives along a direction.
#[derive(Debug, Default)]
struct Scratch {
    /// Displacement, contact after contact, on the wide set.
    wide: Vec<f64>,
    /// Force on the wide set.
    force: Vec<f64>,
    /// On the set, contact after contact.
    along: Vec<f64>,
    kept: Vec<f64>,
    /// Per node the sum of the magnitudes.
    sums: Vec<f64>,
}

impl Condensed {
    /// The balance of `assembly`, whose ports are linear; without a damper (N s/m) at every contact that is in the
    /// structure instead.
    ///
    /// Free vibrations are poles of the structure's compliance where the contacts carry little; with such a damper
    /// compliances are finite there.
    pub fn new(
        assembly: &Assembly,
        settings: &CurveSettings,
        damping_shift: f64,
    ) -> Result<Self, HarmonicError> {
        let odd = assembly.is_odd() && !settings.all_harmonics;
        let set = set_of(odd, settings.harmonics);
        let structure = assembly.system.linear_part();
        let mut seen = structure.clone();
        if damping_shift != 0.0 {
            seen.damping.extend(structure.along_contacts(structure.contacts.iter().map(|_| damping_shift)));
        }
        // The displacement where the excitation acts is one more output, for its work.
        seen.outputs.push(Output { name: String::new(), row: structure.excitation.clone() });
        let receptance = Receptance::new(&seen)?;
        let elements = assembly.system.elements.iter().enumerate();
        let attach = |(place, element): (usize, &Element)| match element {
            Element::Law { law, normal_load, .. } => {
                let cycle = ContactMap::new(set, settings.method, damping_shift);
                Some(Attached::new(assembly, place, (law, *normal_load), cycle))
            }
            Element::Springs { .. } | Element::Outside { .. } => None,
        };
        let contacts: Vec<Attached> = elements.filter_map(attach).collect();
        let none = || Transfer::new(&receptance, Rows::Contacts, std::iter::empty());
        let mut system = Self {
            wider: Vec::new(),
            contacts,
            waveform: assembly.waveform.clone(),
            method: settings.method,
            damping_shift,
            odd,
            set,
            wide: set,
            orders: Vec::new(),
            nodes: structure.outputs.len(),
            structure,
            at_contacts: none(),
            everywhere: none(),
            beyond: none(),
            one: Transfer::new(&receptance, Rows::All, std::iter::once(0)),
            receptance,
            excitation: Vec::new(),
            wide_excitation: Vec::new(),
            residual: Vec::new(),
            jacobian: DMatrix::zeros(0, 0),
            by: Default::default(),
            at: Operating::forced(0.0, 0.0),
            extremum: Extremum::default(),
            scratch: Scratch::default(),
            rounding: None,
        };
        system.reserve();
        Ok(system)
    }

    /// The harmonics of the unknowns.
    pub fn set(&self) -> HarmonicSet {
        self.set
    }

    /// Everything that depends on the set of harmonics.
    fn reserve(&mut self) {
        self.rounding = None;
        let set = self.set;
        self.wide = set_of(self.odd, 2 * set.highest() + 1);
        self.orders = set.orders().collect();
        let all = || set.orders().map(|(order, _)| order);
        let highest = set.highest();
        let above = self.wide.orders().map(|(order, _)| order).filter(|order| *order > highest);
        self.at_contacts = Transfer::new(&self.receptance, Rows::Contacts, all());
        self.everywhere = Transfer::new(&self.receptance, Rows::All, all());
        self.beyond = Transfer::new(&self.receptance, Rows::All, above);
        let full = HarmonicSet::full(self.waveform.len() / 2);
        // An even number of coefficients lacks a last sine.
        let mut waveform = self.waveform.clone();
        waveform.resize(full.len(), 0.0);
        self.excitation = vec![0.0; set.len()];
        full.convert(&waveform, set, &mut self.excitation);
        self.wide_excitation = vec![0.0; self.wide.len()];
        full.convert(&waveform, self.wide, &mut self.wide_excitation);
        let unknowns = set.len() * self.contacts.len();
        self.residual = vec![0.0; unknowns];
        self.jacobian = DMatrix::zeros(unknowns, unknowns);
        self.by = std::array::from_fn(|_| vec![0.0; unknowns]);
        self.wider.clear();
        self.wider.resize_with(self.contacts.len(), || None);
    }

    /// Rounding of the compliances at `at`, seen where the frequency changes by a few units in its last place.
    /// Measured anew where the frequency is another.
    fn rounding_about(&mut self, at: &Operating) -> f64 {
        const NEAR: f64 = 0.05;
        const PROBES: usize = 3;
        const SAFETY: f64 = 8.0;
        let speed = at.angular_frequency;
        if let Some((about, rounding)) = self.rounding
            && (speed - about).abs() <= NEAR * about
        {
            return rounding;
        }
        let mut probe = Transfer::new(&self.receptance, Rows::Contacts, self.orders.iter().map(|(h, _)| *h));
        let mut first: Vec<[f64; 2]> = Vec::new();
        let (mut change, mut largest) = (0.0_f64, 0.0_f64);
        for k in 0..=PROBES {
            let at = Operating { angular_frequency: speed * (1.0 + 2.0 * k as f64 * f64::EPSILON), ..*at };
            if probe.evaluate(&mut self.receptance, &at).is_err() {
                return 0.0;
            }
            let p = self.contacts.len();
            let places = (0..self.orders.len())
                .flat_map(|k| (0..p).flat_map(move |i| (0..=p).map(move |j| (k, i, j))));
            let values = places.map(|(k, i, j)| probe.get(k, Of::Value, i, j));
            if k == 0 {
                first = values.collect();
                largest = first.iter().fold(0.0, |m, [re, im]| m.max(re.hypot(*im)));
            } else {
                let moved = values.zip(&first).map(|(a, b)| (a[0] - b[0]).hypot(a[1] - b[1]));
                change = moved.fold(change, f64::max);
            }
        }
        let rounding = if largest > 0.0 { SAFETY * change / largest } else { 0.0 };
        self.rounding = Some((speed, rounding));
        rounding
    }

    fn carry(&mut self, x: &[f64], at: &Operating) -> Result<(), HarmonicError> {
        let mut parts = self.contacts.iter_mut().zip(x.chunks_exact(self.set.len()));
        parts.try_for_each(|(contact, u)| contact.evaluate(at.angular_frequency, u))
    }

    /// Residual; returns the size of its terms.
    fn balance(&mut self, x: &[f64], at: &Operating) -> f64 {
        let (p, width) = (self.contacts.len(), self.set.len());
        self.residual.copy_from_slice(x);
        let mut scale = x.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        for i in 0..p {
            for (k, (order, place)) in self.orders.iter().enumerate() {
                let span = *place..place + if *order == 0 { 1 } else { 2 };
                let mut sum = [0.0; 2];
                let sum = &mut sum[..span.len()];
                let compliance = self.at_contacts.get(k, Of::Value, i, p);
                add_product(compliance, &self.excitation[span.clone()], -at.level, sum);
                scale = sum.iter().fold(scale, |m, x| m.max(x.abs()));
                for (j, contact) in self.contacts.iter().enumerate() {
                    let compliance = self.at_contacts.get(k, Of::Value, i, j);
                    add_product(compliance, &contact.cycle.force()[span.clone()], 1.0, sum);
                }
                let target = &mut self.residual[i * width + span.start..i * width + span.end];
                target.iter_mut().zip(sum.iter()).for_each(|(r, s)| *r += s);
            }
        }
        scale
    }

    fn differentiate(&mut self) {
        let (p, width) = (self.contacts.len(), self.set.len());
        let unknowns = p * width;
        for (j, contact) in self.contacts.iter().enumerate() {
            let columns = contact.cycle.jacobian().as_slice().chunks_exact(width);
            for (n, source) in columns.enumerate() {
                let column = j * width + n;
                let target = &mut self.jacobian.as_mut_slice()[column * unknowns..(column + 1) * unknowns];
                target.fill(0.0);
                for i in 0..p {
                    for (k, (order, place)) in self.orders.iter().enumerate() {
                        let end = place + if *order == 0 { 1 } else { 2 };
                        let compliance = self.at_contacts.get(k, Of::Value, i, j);
                        let into = &mut target[i * width + place..i * width + end];
                        add_product(compliance, &source[*place..end], 1.0, into);
                    }
                }
                target[column] += 1.0;
            }
        }
    }

    fn differentiate_by(&mut self, scalar: Scalar, at: &Operating) {
        let (p, width) = (self.contacts.len(), self.set.len());
        let target = &mut self.by[scalar.index()];
        target.fill(0.0);
        for i in 0..p {
            for (k, (order, place)) in self.orders.iter().enumerate() {
                let span = *place..place + if *order == 0 { 1 } else { 2 };
                let into = &mut target[i * width + span.start..i * width + span.end];
                if scalar == Scalar::Level {
                    let compliance = self.at_contacts.get(k, Of::Value, i, p);
                    add_product(compliance, &self.excitation[span], -1.0, into);
                    continue;
                }
                let contacts = self.contacts.iter().filter(|_| scalar == Scalar::AngularFrequency);
                for (j, contact) in contacts.enumerate() {
                    let compliance = self.at_contacts.get(k, Of::Value, i, j);
                    add_product(compliance, &contact.cycle.by_frequency()[span.clone()], 1.0, into);
                }
                let Some(of) = compliance_derivative(scalar) else { continue };
                let compliance = self.at_contacts.get(k, of, i, p);
                add_product(compliance, &self.excitation[span.clone()], -at.level, into);
                for (j, contact) in self.contacts.iter().enumerate() {
                    let compliance = self.at_contacts.get(k, of, i, j);
                    add_product(compliance, &contact.cycle.force()[span.clone()], 1.0, into);
                }
            }
        }
    }

    /// Displacement harmonic of an output row from signals of excitation and forces.
    fn displace(
        transfer: &Transfer,
        k: usize,
        row: usize,
        of: Of,
        excitation: (&[f64], f64),
        forces: impl Iterator<Item = (usize, [f64; 2])>,
    ) -> [f64; 2] {
        let width = excitation.0.len();
        let mut sum = [0.0; 2];
        let columns = transfer.columns();
        add_product(transfer.get(k, of, row, columns - 1), excitation.0, excitation.1, &mut sum[..width]);
        for (j, force) in forces {
            add_product(transfer.get(k, of, row, j), &force[..width], -1.0, &mut sum[..width]);
        }
        sum
    }

    /// Coefficients `[a0, c1, s1, …]` of an output row (contacts first) at the last evaluation.
    fn coefficients_of(&self, row: usize) -> Vec<f64> {
        let mut out = vec![0.0; 2 * self.set.highest() + 1];
        for (k, (order, place)) in self.orders.iter().enumerate() {
            let span = span(*order, *place);
            let forces = self.contacts.iter().enumerate();
            let forces = forces.map(|(j, contact)| (j, pair(&contact.cycle.force()[span.clone()])));
            let excitation = (&self.excitation[span.clone()], self.at.level);
            let value = Self::displace(&self.everywhere, k, row, Of::Value, excitation, forces);
            let start = full_place(*order);
            out[start..start + span.len()].copy_from_slice(&value[..span.len()]);
        }
        out
    }
}

impl PeriodicSystem for Condensed {
    fn unknowns(&self) -> usize {
        self.residual.len()
    }

    fn evaluate(&mut self, x: &[f64], at: &Operating, scalars: &[Scalar]) -> Result<f64, HarmonicError> {
        self.at = *at;
        self.at_contacts.evaluate(&mut self.receptance, at)?;
        self.carry(x, at)?;
        let scale = self.balance(x, at);
        self.differentiate();
        scalars.iter().for_each(|scalar| self.differentiate_by(*scalar, at));
        Ok(scale)
    }

    fn residual(&self) -> &[f64] {
        &self.residual
    }

    fn jacobian(&mut self) -> &DMatrix<f64> {
        &self.jacobian
    }

    fn by(&self, scalar: Scalar) -> &[f64] {
        &self.by[scalar.index()]
    }

    fn output(&mut self, node: usize, order: usize) -> [f64; 2] {
        self.seen(node, order)
    }

    fn observe(&mut self, node: usize, order: usize, out: &mut Observation) {
        self.look(node, order, out);
    }

    fn forget(&mut self) {
        self.contacts.iter_mut().for_each(|contact| contact.cycle.forget());
    }

    fn nodes(&self) -> usize {
        self.nodes
    }

    fn harmonics(&self) -> usize {
        self.set.highest()
    }

    fn guess(&mut self, at: &Operating, x: &mut [f64]) -> Result<(), HarmonicError> {
        self.linearised(at, x)
    }

    fn rounding(&mut self, at: &Operating) -> f64 {
        self.rounding_about(at)
    }

    fn compliance_homotopy(&mut self, compliances: f64) -> bool {
        let p = self.contacts.len();
        for (i, contact) in self.contacts.iter_mut().enumerate() {
            // The largest at the harmonics of the last evaluation.
            let own = (0..self.orders.len()).map(|k| {
                let [re, im] = self.at_contacts.get(k, Of::Value, i, i);
                re.hypot(im)
            });
            contact.compliance = compliances * own.fold(0.0, f64::max);
        }
        p > 0
    }

    fn describe(&mut self, x: &[f64], at: &Operating) -> Result<Point, HarmonicError> {
        self.point(x, at)
    }

    fn nodes_along(&mut self, unknowns: &[f64], scalars: &[f64; 4], out: &mut [Vec<f64>]) {
        self.derivatives_along(unknowns, scalars, out);
    }

    fn truncation_error(
        &mut self,
        x: &[f64],
        at: &Operating,
        point: &Point,
        solve: &mut dyn FnMut(&mut [f64]),
    ) -> Result<f64, HarmonicError> {
        self.left_out(x, at, point, solve)
    }

    fn stable(&mut self, point: &Point) -> Result<bool, Undecided> {
        self.lasts(point)
    }

    fn resume(&self, point: &Point, x: &mut [f64]) -> bool {
        if point.contacts.len() != self.contacts.len() {
            return false;
        }
        for (contact, u) in point.contacts.iter().zip(x.chunks_exact_mut(self.set.len())) {
            let known = &contact.displacement;
            if known.len().is_multiple_of(2) {
                return false;
            }
            HarmonicSet::full(known.len() / 2).convert(known, self.set, u);
        }
        true
    }

    fn replace_laws(&mut self, system: &System) -> Result<(), HarmonicError> {
        for (contact, (_, law, normal_load)) in self.contacts.iter_mut().zip(system.laws()) {
            if self.odd && !law.is_odd() {
                return Err(HarmonicError::InvalidInput(
                    "the contact loses its symmetry with the parameter: all harmonics are needed",
                ));
            }
            contact.replace(law, normal_load);
        }
        Ok(())
    }

    fn set_harmonics(
        &mut self,
        harmonics: usize,
        vectors: &mut [&mut Vec<f64>],
    ) -> Result<bool, HarmonicError> {
        let (old, new) = (self.set, set_of(self.odd, harmonics));
        for vector in vectors {
            let mut carried = vec![0.0; new.len() * self.contacts.len()];
            let parts = carried.chunks_exact_mut(new.len()).zip(vector.chunks_exact(old.len()));
            parts.for_each(|(into, from)| old.convert(from, new, into));
            **vector = carried;
        }
        self.set = new;
        let method = method_on(self.method, new);
        for contact in &mut self.contacts {
            contact.cycle = ContactMap::new(new, method, self.damping_shift);
        }
        self.reserve();
        Ok(true)
    }
}

fn set_of(odd: bool, harmonics: usize) -> HarmonicSet {
    if odd { HarmonicSet::odd(harmonics) } else { HarmonicSet::full(harmonics) }
}

/// The method, with no fewer samples than `set` takes.
fn method_on(method: Method, set: HarmonicSet) -> Method {
    match method {
        Method::Exact => method,
        Method::Sampled { samples } => Method::Sampled { samples: samples.max(8 * set.highest()) },
    }
}

fn span(order: usize, place: usize) -> std::ops::Range<usize> {
    place..place + if order == 0 { 1 } else { 2 }
}

/// Place of a harmonic among `[a0, c1, s1, …]`.
fn full_place(order: usize) -> usize {
    if order == 0 { 0 } else { 2 * order - 1 }
}

fn pair(signal: &[f64]) -> [f64; 2] {
    [signal[0], signal.get(1).copied().unwrap_or(0.0)]
}

fn compliance_derivative(scalar: Scalar) -> Option<Of> {
    match scalar {
        Scalar::AngularFrequency => Some(Of::ByFrequency),
        Scalar::SelfExcitation => Some(Of::BySelfExcitation),
        Scalar::Level | Scalar::Parameter => None,
    }
}

#[cfg(test)]
mod tests;
