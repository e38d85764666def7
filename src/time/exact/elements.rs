//! The sliders of all contacts and the branch each one is on.

use super::OscillatorError;
use crate::contact::{LoadedContact, Slider};

/// Linear piece of a slider's law.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Branch {
    /// Within the play: no force.
    Play,
    /// The spring acts beyond the upper end of the play; the only elastic branch without play.
    Above,
    /// The spring acts beyond the lower end of the play.
    Below,
    /// The slider follows under the upper limit.
    SlipUp,
    /// The slider follows under the lower limit.
    SlipDown,
}

/// A slider of a contact.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Element {
    pub contact: usize,
    pub slider: Slider,
}

/// Memory of an element: slider position, branch, and the displacements that end the branch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Memory {
    pub position: f64,
    pub branch: Branch,
    /// Displacement above which the branch ends.
    pub upper_edge: f64,
    /// Displacement below which the branch ends.
    pub lower_edge: f64,
}

impl Element {
    /// Whether there is no play, so that one elastic branch reaches from limit to limit.
    fn single(&self) -> bool {
        self.slider.play_below == self.slider.play_above
    }

    /// Stretch at which the upper limit is reached (m).
    fn upper_reach(&self) -> f64 {
        self.slider.play_above + self.slider.upper_limit / self.slider.stiffness
    }

    fn lower_reach(&self) -> f64 {
        self.slider.play_below - self.slider.lower_limit / self.slider.stiffness
    }

    /// Slider position at displacement `u` of a memory that may be slipping.
    pub fn position(&self, memory: &Memory, u: f64) -> f64 {
        match memory.branch {
            Branch::SlipUp => u - self.upper_reach(),
            Branch::SlipDown => u - self.lower_reach(),
            _ => memory.position,
        }
    }

    /// Stiffness (N/m) and constant (N) of the force `k u + c` on a branch.
    pub fn force(&self, memory: &Memory) -> (f64, f64) {
        let k = self.slider.stiffness;
        match memory.branch {
            Branch::Play => (0.0, 0.0),
            Branch::Above => (k, -k * (memory.position + self.slider.play_above)),
            Branch::Below => (k, -k * (memory.position + self.slider.play_below)),
            Branch::SlipUp => (0.0, self.slider.upper_limit),
            Branch::SlipDown => (0.0, -self.slider.lower_limit),
        }
    }

    /// Energy stored in the spring (J).
    pub fn energy(&self, memory: &Memory, u: f64) -> f64 {
        let (stiffness, constant) = self.force(memory);
        0.5 * (stiffness * u + constant).powi(2) / self.slider.stiffness
    }

    fn enter(&self, memory: &mut Memory, branch: Branch) {
        memory.branch = branch;
        let z = memory.position;
        let slider = &self.slider;
        (memory.lower_edge, memory.upper_edge) = match branch {
            Branch::Play => (z + slider.play_below, z + slider.play_above),
            Branch::Above if self.single() => (z + self.lower_reach(), z + self.upper_reach()),
            Branch::Above => (z + slider.play_above, z + self.upper_reach()),
            Branch::Below => (z + self.lower_reach(), z + slider.play_below),
            Branch::SlipUp | Branch::SlipDown => (f64::NEG_INFINITY, f64::INFINITY),
        };
    }

    /// Memory of the slider at `position` when the contact stands at `u` and moves at `velocity`. A
    /// position beyond the limits follows.
    pub fn start(&self, position: f64, u: f64, velocity: f64) -> Memory {
        let (_, position) = self.slider.step(position, u);
        let mut memory = Memory { position, branch: Branch::Play, upper_edge: 0.0, lower_edge: 0.0 };
        let stretch = u - position;
        let branch = if stretch >= self.upper_reach() && velocity > 0.0 {
            Branch::SlipUp
        } else if stretch <= self.lower_reach() && velocity < 0.0 {
            Branch::SlipDown
        } else if self.single() || stretch > self.slider.play_above {
            Branch::Above
        } else if stretch < self.slider.play_below {
            Branch::Below
        } else {
            Branch::Play
        };
        self.enter(&mut memory, branch);
        memory
    }

    /// The displacement has risen to the upper edge, at `u`.
    pub fn rise(&self, memory: &mut Memory, u: f64) {
        let next = match memory.branch {
            Branch::Below => Branch::Play,
            Branch::Play => Branch::Above,
            _ => Branch::SlipUp,
        };
        self.enter(memory, next);
        // The edge just crossed is where the motion stands, to the last digit.
        if !matches!(next, Branch::SlipUp) {
            memory.lower_edge = u;
        }
    }

    /// The displacement has fallen to the lower edge, at `u`.
    pub fn fall(&self, memory: &mut Memory, u: f64) {
        let next = match memory.branch {
            Branch::Above if !self.single() => Branch::Play,
            Branch::Play => Branch::Below,
            _ => Branch::SlipDown,
        };
        self.enter(memory, next);
        if !matches!(next, Branch::SlipDown) {
            memory.upper_edge = u;
        }
    }

    /// The displacement has turned round at `u`: slip ends.
    pub fn turn(&self, memory: &mut Memory, u: f64) {
        memory.position = self.position(memory, u);
        match memory.branch {
            Branch::SlipUp => {
                self.enter(memory, Branch::Above);
                memory.upper_edge = u;
            }
            Branch::SlipDown => {
                self.enter(memory, if self.single() { Branch::Above } else { Branch::Below });
                memory.lower_edge = u;
            }
            _ => {}
        }
    }
}

impl Memory {
    /// +1 in slip under the upper limit, −1 under the lower, else 0.
    pub fn slip(&self) -> f64 {
        match self.branch {
            Branch::SlipUp => 1.0,
            Branch::SlipDown => -1.0,
            _ => 0.0,
        }
    }
}

/// All sliders of `contacts`, contact after contact. Sliders whose limits are both zero carry no force
/// and are left out.
pub(crate) fn elements(contacts: &[LoadedContact]) -> Result<Vec<Element>, OscillatorError> {
    let mut all = Vec::new();
    let mut sliders = Vec::new();
    for (contact, loaded) in contacts.iter().enumerate() {
        if !loaded.normal_load.is_finite() {
            return Err(OscillatorError::Input { name: "normal load", value: loaded.normal_load });
        }
        sliders.clear();
        if !loaded.law.sliders(loaded.normal_load, &mut sliders) {
            return Err(OscillatorError::NotPiecewiseLinear { contact });
        }
        let acts = |slider: &&Slider| slider.upper_limit > 0.0 || slider.lower_limit > 0.0;
        all.extend(sliders.iter().filter(acts).map(|&slider| Element { contact, slider }));
    }
    Ok(all)
}
