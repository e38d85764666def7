//! What a solution means for the whole structure, and how far off it may be.

use super::{Attached, Condensed, compliance_derivative, full_place, method_on, pair, span};
use crate::harmonic::balance::transfer::{Of, add_product};
use crate::harmonic::newton::Contacting;
use crate::harmonic::newton::system::{Observation, Operating, Scalar};
use crate::harmonic::period::Cycle;
use crate::harmonic::period::map::ContactMap;
use crate::harmonic::stability::{Undecided, decide};
use crate::harmonic::{HarmonicError, Point};
use crate::numeric::HarmonicSet;
use crate::numeric::fourier::work_per_cycle;
use crate::time::LoadedContact;

impl Condensed {
    /// One harmonic of an output.
    pub(super) fn seen(&mut self, node: usize, order: usize) -> [f64; 2] {
        let Some(place) = self.set.place(order) else { return [0.0; 2] };
        if self.one.evaluate_one(&mut self.receptance, &self.at, order).is_err() {
            return [0.0; 2];
        }
        let span = span(order, place);
        let forces = self.contacts.iter().enumerate();
        let forces = forces.map(|(j, contact)| (j, pair(&contact.cycle.force()[span.clone()])));
        let excitation = (&self.excitation[span.clone()], self.at.level);
        Self::displace(&self.one, 0, self.contacts.len() + node, Of::Value, excitation, forces)
    }

    /// One harmonic of an output with all its derivatives.
    pub(super) fn look(&mut self, node: usize, order: usize, out: &mut Observation) {
        let (p, width, unknowns) = (self.contacts.len(), self.set.len(), self.residual.len());
        out.value = [0.0; 2];
        out.by_scalars = [[0.0; 4]; 2];
        for row in &mut out.by_unknowns {
            row.clear();
            row.resize(unknowns, 0.0);
        }
        let Some(place) = self.set.place(order) else { return };
        if self.one.evaluate_one(&mut self.receptance, &self.at, order).is_err() {
            // The contacts' rows of the same matrix have been computed: this one cannot be singular.
            return;
        }
        let (row, span) = (p + node, span(order, place));
        let excitation = (&self.excitation[span.clone()], self.at.level);
        let forces = |contacts: &[Attached]| -> Vec<(usize, [f64; 2])> {
            let parts = contacts.iter().enumerate();
            parts.map(|(j, contact)| (j, pair(&contact.cycle.force()[span.clone()]))).collect()
        };
        let forces = forces(&self.contacts);
        let moved =
            |of, excitation| Self::displace(&self.one, 0, row, of, excitation, forces.iter().copied());
        out.value = moved(Of::Value, excitation);
        for scalar in [Scalar::AngularFrequency, Scalar::SelfExcitation] {
            if let Some(of) = compliance_derivative(scalar) {
                let by = moved(of, excitation);
                (0..2).for_each(|part| out.by_scalars[part][scalar.index()] = by[part]);
            }
        }
        let mut by_level = [0.0; 2];
        add_product(self.one.get(0, Of::Value, row, p), excitation.0, 1.0, &mut by_level[..span.len()]);
        (0..2).for_each(|part| out.by_scalars[part][Scalar::Level.index()] = by_level[part]);
        for (j, contact) in self.contacts.iter().enumerate() {
            let compliance = self.one.get(0, Of::Value, row, j);
            let mut moved = [0.0; 2];
            let by_frequency = &contact.cycle.by_frequency()[span.clone()];
            add_product(compliance, by_frequency, -1.0, &mut moved[..span.len()]);
            let index = Scalar::AngularFrequency.index();
            (0..2).for_each(|part| out.by_scalars[part][index] += moved[part]);
            for (n, column) in contact.cycle.jacobian().as_slice().chunks_exact(width).enumerate() {
                let mut moved = [0.0; 2];
                add_product(compliance, &column[span.clone()], -1.0, &mut moved[..span.len()]);
                (0..2).for_each(|part| out.by_unknowns[part][j * width + n] = moved[part]);
            }
        }
    }

    /// The whole response.
    pub(super) fn point(&mut self, x: &[f64], at: &Operating) -> Result<Point, HarmonicError> {
        self.everywhere.evaluate(&mut self.receptance, at)?;
        let (p, set) = (self.contacts.len(), self.set);
        let full = HarmonicSet::full(set.highest());
        let nodes: Vec<Vec<f64>> = (0..self.nodes).map(|node| self.coefficients_of(p + node)).collect();
        let amplitude = nodes.iter().map(|node| self.extremum.of(node).1).collect();
        let driven = self.coefficients_of(p + self.nodes);
        let waveform = &self.waveform[..self.waveform.len().min(driven.len())];
        let work = at.level * work_per_cycle(waveform, &driven);
        let contacting = |(contact, u): (&mut Attached, &[f64])| {
            let summary = contact.cycle.summary();
            let mut displacement = vec![0.0; full.len()];
            set.convert(u, full, &mut displacement);
            let mut force = vec![0.0; full.len()];
            set.convert(&contact.cycle.own_force(), full, &mut force);
            Contacting {
                dissipated_energy: summary.dissipated_energy,
                equivalent_stiffness: summary.equivalent_stiffness,
                stick_fraction: summary.stick_fraction,
                displacement,
                force,
            }
        };
        Ok(Point {
            angular_frequency: at.angular_frequency,
            level: at.level,
            parameter: at.parameter,
            amplitude,
            nodes,
            contacts: self.contacts.iter_mut().zip(x.chunks_exact(set.len())).map(contacting).collect(),
            work,
            stable: None,
            undecided: None,
            error_estimate: 0.0,
            resolved: true,
            harmonics: set.highest(),
            iterations: 0,
        })
    }

    /// Whether the response lasts. A free vibration sustained by its artificial damping is no response.
    pub(super) fn lasts(&self, point: &Point) -> Result<bool, Undecided> {
        if self.damping_shift != 0.0 {
            return Err(Undecided::NoResponse);
        }
        let laws = self.contacts.iter();
        let contacts: Vec<LoadedContact> = laws
            .map(|attached| LoadedContact { law: attached.law.as_ref(), normal_load: attached.normal_load })
            .collect();
        let displacement: Vec<&[f64]> =
            point.contacts.iter().map(|contact| contact.displacement.as_slice()).collect();
        decide(&self.structure, &contacts, &displacement, point.angular_frequency)
    }

    /// Derivatives of the outputs' coefficients along a direction.
    pub(super) fn derivatives_along(&mut self, unknowns: &[f64], scalars: &[f64; 4], out: &mut [Vec<f64>]) {
        let (p, width, at) = (self.contacts.len(), self.set.len(), self.at);
        let full = 2 * self.set.highest() + 1;
        if self.everywhere.evaluate(&mut self.receptance, &at).is_err() {
            out.iter_mut().for_each(|node| node.clear());
            return;
        }
        let [by_frequency, by_level, by_self_excitation, _] = *scalars;
        let along = &mut self.scratch.along;
        along.clear();
        along.resize(p * width, 0.0);
        for (j, contact) in self.contacts.iter().enumerate() {
            let into = &mut along[j * width..(j + 1) * width];
            let direction = &unknowns[j * width..(j + 1) * width];
            for (column, step) in contact.cycle.jacobian().as_slice().chunks_exact(width).zip(direction) {
                into.iter_mut().zip(column).for_each(|(t, c)| *t += step * c);
            }
            let rates = contact.cycle.by_frequency();
            into.iter_mut().zip(rates).for_each(|(t, rate)| *t += by_frequency * rate);
        }
        for (node, coefficients) in out.iter_mut().enumerate() {
            coefficients.clear();
            coefficients.resize(full, 0.0);
            for (k, (order, place)) in self.orders.iter().enumerate() {
                let (span, start) = (span(*order, *place), full_place(*order));
                let excitation = &self.excitation[span.clone()];
                let signal = |j: usize| pair(&self.contacts[j].cycle.force()[span.clone()]);
                let changes = (0..p).map(|j| {
                    let place = j * width + span.start;
                    (j, pair(&self.scratch.along[place..place + span.len()]))
                });
                let row = p + node;
                let mut sum =
                    Self::displace(&self.everywhere, k, row, Of::Value, (excitation, by_level), changes);
                for (of, weight) in
                    [(Of::ByFrequency, by_frequency), (Of::BySelfExcitation, by_self_excitation)]
                {
                    if weight != 0.0 {
                        let held = (0..p).map(|j| (j, signal(j)));
                        let by =
                            Self::displace(&self.everywhere, k, row, of, (excitation, self.at.level), held);
                        (0..2).for_each(|part| sum[part] += weight * by[part]);
                    }
                }
                coefficients[start..start + span.len()].copy_from_slice(&sum[..span.len()]);
            }
        }
    }

    /// One step of block elimination on the balance with twice the harmonics: those beyond the set respond
    /// to the contacts' forces there, the changed displacement changes the forces kept, and these
    /// move the unknowns. First order in the harmonics left out. What is beyond twice the harmonics is taken from how fast
    /// the forces fall ([`Self::tails`]).
    pub(super) fn left_out(
        &mut self,
        x: &[f64],
        at: &Operating,
        point: &Point,
        solve: &mut dyn FnMut(&mut [f64]),
    ) -> Result<f64, HarmonicError> {
        let (p, width) = (self.contacts.len(), self.set.len());
        self.beyond.evaluate(&mut self.receptance, at)?;
        self.everywhere.evaluate(&mut self.receptance, at)?;
        self.displace_beyond(x);
        self.change_kept(at)?;
        let (added, changed) = self.tails();
        self.scratch.sums.iter_mut().for_each(|sum| *sum *= added);
        self.scratch.kept.iter_mut().for_each(|kept| *kept *= changed);
        // Unknowns: the residual's change through the compliances, then through the factors.
        let mut change = std::mem::take(&mut self.scratch.along);
        change.clear();
        change.resize(p * width, 0.0);
        let kept = &self.scratch.kept;
        let spans = || self.orders.iter().map(|(order, place)| span(*order, *place)).enumerate();
        for i in 0..p {
            for (k, span) in spans() {
                for j in 0..p {
                    let into = &mut change[i * width + span.start..i * width + span.end];
                    let force = &kept[j * width + span.start..j * width + span.end];
                    add_product(self.at_contacts.get(k, Of::Value, i, j), force, -1.0, into);
                }
            }
        }
        solve(&mut change);
        self.scratch.along = change;
        for (j, contact) in self.contacts.iter().enumerate() {
            let into = &mut self.scratch.kept[j * width..(j + 1) * width];
            let moves = &self.scratch.along[j * width..(j + 1) * width];
            for (column, step) in contact.cycle.jacobian().as_slice().chunks_exact(width).zip(moves) {
                into.iter_mut().zip(column).for_each(|(t, c)| *t += step * c);
            }
        }
        // Every output: what is added beyond, and what changes below.
        let mut worst = 0.0_f64;
        for (node, amplitude) in point.amplitude.iter().enumerate() {
            let row = p + node;
            let mut sum = self.scratch.sums.get(node).copied().unwrap_or(0.0);
            for (k, span) in spans() {
                let changes = (0..p).map(|j| {
                    let place = j * width + span.start;
                    (j, pair(&self.scratch.kept[place..place + span.len()]))
                });
                let none = (&self.excitation[span.clone()], 0.0);
                let moved = Self::displace(&self.everywhere, k, row, Of::Value, none, changes);
                sum += (moved[0] * moved[0] + moved[1] * moved[1]).sqrt();
            }
            if *amplitude > 0.0 {
                worst = worst.max(sum / amplitude);
            }
        }
        Ok(worst)
    }

    /// The displacements with what the harmonics beyond the set add, on the wide set; and the sizes of
    /// what they add to the outputs.
    fn displace_beyond(&mut self, x: &[f64]) {
        let (p, wide) = (self.contacts.len(), self.wide);
        let width = wide.len();
        let highest = self.set.highest();
        self.scratch.wide.resize(p * width, 0.0);
        self.scratch.force.resize(p * width, 0.0);
        let forces = self.scratch.force.chunks_exact_mut(width);
        for (contact, force) in self.contacts.iter_mut().zip(forces) {
            contact.cycle.force_on(wide, force);
        }
        let inputs = x.chunks_exact(self.set.len());
        for (into, u) in self.scratch.wide.chunks_exact_mut(width).zip(inputs) {
            self.set.convert(u, wide, into);
        }
        self.scratch.sums.clear();
        self.scratch.sums.resize(self.nodes, 0.0);
        let above = wide.orders().filter(|(order, _)| *order > highest);
        for (k, (order, place)) in above.enumerate() {
            let span = span(order, place);
            let excitation = (&self.wide_excitation[span.clone()], self.at.level);
            let force = &self.scratch.force;
            let forces = || (0..p).map(|j| (j, pair(&force[j * width + span.start..j * width + span.end])));
            let moved = |row| Self::displace(&self.beyond, k, row, Of::Value, excitation, forces());
            for i in 0..p {
                let into = &mut self.scratch.wide[i * width + span.start..i * width + span.end];
                into.copy_from_slice(&moved(i)[..span.len()]);
            }
            for (node, sum) in self.scratch.sums.iter_mut().enumerate() {
                let [c, s] = moved(p + node);
                *sum += (c * c + s * s).sqrt();
            }
        }
    }

    /// By how much the sums over the wide set fall short of those over all harmonics: of the displacements added, and of
    /// what changes the forces kept, to which they add up as velocities, since these tell when friction turns round.
    ///
    /// Forces fall as a power of the order, −1 where they jump and −2 where they have kinks, and the velocities beyond with
    /// one more. So over an octave their sum falls as the forces' mean square falls over half of one, and that of the
    /// displacements by the octave more. Forces that fall slower than where they jump do so for some orders only.
    fn tails(&self) -> (f64, f64) {
        // From the middle of two orders to the middle of two.
        let step = if self.set.is_odd() { 1.0 } else { 0.5 };
        let (from, to) = (self.set.highest() as f64 + step, self.wide.highest() as f64 + step);
        let mut halves = [(0.0, 0.0); 2];
        for (order, place) in self.wide.orders().filter(|(order, _)| *order > self.set.highest()) {
            let forces = self.scratch.force.chunks_exact(self.wide.len());
            let squares = forces.map(|force| force[place].powi(2) + force[place + 1].powi(2)).sum::<f64>();
            let (count, sum) = &mut halves[usize::from((order * order) as f64 > from * to)];
            (*count, *sum) = (*count + 1.0, *sum + squares);
        }
        let [near, far] = halves.map(|(count, sum)| sum / count);
        let (jump, fall) = (from / to, far / near);
        // Also where there are too few orders to tell.
        let fall = if fall < jump { fall } else { jump };
        (1.0 / (1.0 - fall * jump), 1.0 / (1.0 - fall))
    }

    /// How the forces kept change under the displacement on the wide set.
    fn change_kept(&mut self, at: &Operating) -> Result<(), HarmonicError> {
        let (p, width, wide) = (self.contacts.len(), self.set.len(), self.wide.len());
        self.scratch.kept.resize(p * width, 0.0);
        let (method, damping_shift) = (method_on(self.method, self.wide), self.damping_shift);
        for (j, (contact, wider)) in self.contacts.iter_mut().zip(&mut self.wider).enumerate() {
            let wider = wider.get_or_insert_with(|| ContactMap::new(self.wide, method, damping_shift));
            let u = &self.scratch.wide[j * wide..(j + 1) * wide];
            let into = &mut self.scratch.kept[j * width..(j + 1) * width];
            contact.force_alone(wider, at.angular_frequency, u, self.set, into)?;
            into.iter_mut().zip(contact.cycle.force()).for_each(|(t, force)| *t -= force);
        }
        Ok(())
    }
}
