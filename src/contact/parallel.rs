//! Jenkins' elements side by side.

use super::element::{Element, Start};
use super::error::{Bounds, LawError, checked, checked_pair};
use super::{ContactLaw, Inputs, Response, Slider, SlipState, StateTangents, Tangents, cut_to};

/// Jenkins' elements side by side: they share displacement and normal load, and their forces add up.
///
/// ```text
///         T ▲        ____────── Σ μᵢ N
///           │    _╱─╱       ╱
///           │  ╱          ╱
///           │ ╱ Σ kᵢ     ╱
///   ────────┼╱──────────╱──────► u
/// ```
///
/// # Law
/// `T = Σ kᵢ (u − zᵢ)` with `|kᵢ (u − zᵢ)| ≤ μᵢ N`: each element as [`super::Jenkins`], exact within a step in
/// which displacement and normal load run linearly, lift-off and re-contact included. The loading curve
/// falls in slope by `kᵢ` where element i yields, at `u = μᵢ N/kᵢ`. Under a constant load the law obeys
/// Masing's rules: branches after a reversal are the loading curve at twice its size, and minor loops close.
///
/// # State
/// `[u, N, z₁ … zₙ]`: displacement (m) and normal load (N) at the end of the last step, slider positions (m).
///
/// # Parameters
/// For each element its stiffness kᵢ (N/m) and coefficient of friction μᵢ (1), both above zero.
///
/// # Limits of validity
/// A step must not contain a reversal. All elements see the same normal load.
///
/// # Reference
/// Iwan (1966), *A distributed-element model for hysteresis and its steady-state dynamic response*, J. Appl.
/// Mech. 33, 893–900, in its parallel–series form.
///
/// ```
/// use stickslip::contact::{ContactLaw, Inputs, ParallelSliders};
/// let law = ParallelSliders::new(&[(2e6, 0.1), (1e6, 0.4)])?;
/// let (mut state, mut next) = ([0.0; 4], [0.0; 4]);
/// law.set_state(0.0, 100.0, 0.0, &mut state);
/// let inputs = Inputs { displacement: 20e-6, velocity: 0.0, normal_load: 100.0 };
/// // The first element slips at 5 µm, the second would at 40 µm.
/// assert!((law.step(&state, inputs, &mut next).force - (10.0 + 20.0)).abs() < 1e-12);
/// # Ok::<(), stickslip::contact::LawError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct ParallelSliders {
    elements: Vec<Element>,
    /// Σ μᵢ (1).
    friction: f64,
}

/// What comes before the slider positions in the state.
const SHARED: usize = 2;

impl ParallelSliders {
    /// Elements of stiffness (N/m) and coefficient of friction (1), in this order in the state.
    ///
    /// # Errors
    /// [`LawError::OutOfBounds`] unless there is at least one element and every number is finite and
    /// above zero.
    pub fn new(elements: &[(f64, f64)]) -> Result<Self, LawError> {
        let at_least_one = Bounds { lower: std::ops::Bound::Included(1.0), ..Bounds::POSITIVE };
        checked("number of sliders", "1", elements.len() as f64, at_least_one)?;
        let element = |&(stiffness, friction): &(f64, f64)| {
            checked_pair(stiffness, friction).map(|(k, mu)| Element::new(k, mu, 0.0))
        };
        let elements = elements.iter().map(element).collect::<Result<Vec<_>, _>>()?;
        let friction = elements.iter().map(|element| element.friction).sum();
        Ok(Self { elements, friction })
    }

    /// Stiffness while all elements stick, Σ kᵢ (N/m).
    pub fn tangential_stiffness(&self) -> f64 {
        self.elements.iter().map(|element| element.stiffness).sum()
    }

    /// Coefficient of friction when all elements slip, Σ μᵢ (1).
    pub fn friction_coefficient(&self) -> f64 {
        self.friction
    }

    /// Stiffness (N/m) and coefficient of friction (1) of each element.
    pub fn elements(&self) -> impl ExactSizeIterator<Item = (f64, f64)> + '_ {
        self.elements.iter().map(|element| (element.stiffness, element.friction))
    }

    /// Energy (J) kept in the springs in `state`.
    pub fn stored_energy(&self, state: &[f64]) -> f64 {
        self.stored_energy_at(state[0], &state[SHARED..])
    }

    /// Energy (J) kept in the springs at `displacement` (m) with their ends at `sliders` (m).
    pub(super) fn stored_energy_at(&self, displacement: f64, sliders: &[f64]) -> f64 {
        let springs = self.elements.iter().zip(sliders);
        springs.map(|(element, slider)| element.stored_energy(*slider, displacement)).sum()
    }

    /// Displacement (m) at which the loading curve of a contact without history reaches `force` (N, within ±limit):
    /// Newton's method, which on a concave curve of straight pieces comes from below and ends after as
    /// many steps as there are pieces.
    fn loading_displacement(&self, normal_load: f64, force: f64) -> f64 {
        let mut displacement = 0.0;
        for _ in 0..=self.elements.len() {
            let (mut missing, mut slope) = (force.abs(), 0.0);
            for element in &self.elements {
                let (stuck, limit) = (element.stiffness * displacement, element.limit(normal_load));
                if stuck < limit {
                    slope += element.stiffness;
                }
                missing -= stuck.min(limit);
            }
            if slope == 0.0 || missing <= 0.0 {
                break;
            }
            displacement += missing / slope;
        }
        displacement.copysign(force)
    }

    fn start(&self, state: &[f64], index: usize) -> Start {
        Start { slider: state[SHARED + index], displacement: state[0], normal_load: state[1] }
    }
}

impl ContactLaw for ParallelSliders {
    fn state_len(&self) -> usize {
        SHARED + self.elements.len()
    }

    /// Divides `force` among the elements as the initial loading of the contact does.
    fn set_state(&self, displacement: f64, normal_load: f64, force: f64, state: &mut [f64]) {
        state[0] = displacement;
        state[1] = normal_load;
        let loaded = self.loading_displacement(normal_load, cut_to(force, self.limit(normal_load)));
        for (element, slider) in self.elements.iter().zip(&mut state[SHARED..]) {
            let part = cut_to(element.stiffness * loaded, element.limit(normal_load));
            *slider = element.slider_carrying(displacement, part);
        }
    }

    fn step(&self, state: &[f64], inputs: Inputs, next: &mut [f64]) -> Response {
        let (mut force, mut dissipated_energy) = (0.0, 0.0);
        let (mut by_displacement, mut by_load) = (0.0, 0.0);
        let mut slip_state = if inputs.normal_load > 0.0 { SlipState::Stick } else { SlipState::Separated };
        for (index, element) in self.elements.iter().enumerate() {
            let start = self.start(state, index);
            let step = element.evaluate(start, inputs);
            next[SHARED + index] = element.slider(&step, start, inputs);
            force += step.force;
            dissipated_energy += step.dissipated_energy;
            let (tangents, does) = element.tangents(&step, start, inputs);
            by_displacement += tangents.displacement;
            by_load += tangents.normal_load;
            if does == SlipState::Slip {
                slip_state = does;
            }
        }
        next[0] = inputs.displacement;
        next[1] = inputs.normal_load;
        let tangents = Tangents { displacement: by_displacement, velocity: 0.0, normal_load: by_load };
        // Of the sum only round-off can lie beyond the limit.
        let force = cut_to(force, self.limit(inputs.normal_load));
        Response { force, tangents, dissipated_energy, slip_state }
    }

    fn state_tangents(&self, state: &[f64], inputs: Inputs, out: &mut StateTangents) {
        let n = self.state_len();
        out.reset(n);
        for (index, element) in self.elements.iter().enumerate() {
            let partials = element.partials(self.start(state, index), inputs);
            let row = SHARED + index;
            out.force_by_state[0] += partials.force_by_start;
            out.force_by_state[1] += partials.force_by_start_load;
            out.force_by_state[row] = partials.force_by_slider;
            out.next_by_state[row * n] = partials.slider_by_start;
            out.next_by_state[row * n + 1] = partials.slider_by_start_load;
            out.next_by_state[row * n + row] = partials.slider_by_slider;
            out.next_by_displacement[row] = partials.slider_by_displacement;
            out.next_by_normal_load[row] = partials.slider_by_normal_load;
        }
        out.next_by_displacement[0] = 1.0;
        out.next_by_normal_load[1] = 1.0;
    }

    fn limit(&self, normal_load: f64) -> f64 {
        if normal_load <= 0.0 { 0.0 } else { self.friction * normal_load }
    }

    fn sliders(&self, normal_load: f64, out: &mut Vec<Slider>) -> bool {
        out.clear();
        if normal_load > 0.0 {
            let slider = |element: &Element| Slider::jenkins(element.stiffness, element.limit(normal_load));
            out.extend(self.elements.iter().map(slider));
        }
        true
    }
}

/// A law that is sliders side by side, by another name.
pub(super) trait Sliders {
    /// The sliders.
    fn parallel(&self) -> &ParallelSliders;
}

impl<L: Sliders + std::fmt::Debug + Send + Sync> ContactLaw for L {
    fn state_len(&self) -> usize {
        self.parallel().state_len()
    }

    fn set_state(&self, displacement: f64, normal_load: f64, force: f64, state: &mut [f64]) {
        self.parallel().set_state(displacement, normal_load, force, state);
    }

    fn step(&self, state: &[f64], inputs: Inputs, next: &mut [f64]) -> Response {
        self.parallel().step(state, inputs, next)
    }

    fn state_tangents(&self, state: &[f64], inputs: Inputs, out: &mut StateTangents) {
        self.parallel().state_tangents(state, inputs, out);
    }

    fn limit(&self, normal_load: f64) -> f64 {
        self.parallel().limit(normal_load)
    }

    fn sliders(&self, normal_load: f64, out: &mut Vec<Slider>) -> bool {
        self.parallel().sliders(normal_load, out)
    }
}
