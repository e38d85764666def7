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

mod equations;
mod guess;
mod outcome;
mod periodic;

use nalgebra::DMatrix;

use super::assembly::Assembly;
use super::attached::Attached;
use super::transfer::{Of, Transfer, add_product};
use crate::harmonic::newton::system::{Operating, Scalar};
use crate::harmonic::period::Cycle;
use crate::harmonic::period::map::ContactMap;
use crate::harmonic::{CurveSettings, HarmonicError, Method};
use crate::numeric::HarmonicSet;
use crate::numeric::extremum::Extremum;
use crate::system::{Element, LinearStructure, Output, Receptance, Rows};

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
            _ => None,
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
