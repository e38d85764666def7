//! A balance whose system depends on a parameter: made anew for each value, differentiated by differences.

use nalgebra::DMatrix;

use super::assembly::Assembly;
use super::balance_of;
use crate::harmonic::newton::system::{Observation, Operating, PeriodicSystem, Scalar};
use crate::harmonic::stability::Undecided;
use crate::harmonic::{CurveSettings, HarmonicError, Point};
use crate::system::{Element, System};

/// Steps of a difference, as fractions of the parameter: the first, and the shortest.
const LONGEST: f64 = 1e-5;
const SHORTEST: f64 = 1e-9;
/// Second difference over first that is a kink's, and what rounding makes of the residual.
const KINK: f64 = 1e-3;
const ROUNDING: f64 = 1e-13;

/// The system at a value of a parameter.
pub type AssemblyAt<'a> = dyn Fn(f64) -> Result<Assembly, HarmonicError> + 'a;

/// The balance of the system that belongs to [`Scalar::Parameter`].
pub(crate) struct Varied<'a> {
    make: &'a AssemblyAt<'a>,
    settings: CurveSettings,
    /// Least size of the parameter, by which steps of it are measured.
    least: f64,
    here: Variant,
    /// At a step above and below, once derivatives were asked for.
    beside: Option<[Variant; 2]>,
    /// That step.
    step: f64,
    by: Vec<f64>,
}

/// The balance at one value.
struct Variant {
    value: f64,
    assembly: Assembly,
    balance: Box<dyn PeriodicSystem>,
}

impl Variant {
    fn new(make: &AssemblyAt, value: f64, settings: &CurveSettings) -> Result<Self, HarmonicError> {
        let assembly = make(value)?;
        let balance = balance_of(&assembly, settings)?;
        Ok(Self { value, assembly, balance })
    }

    /// Goes to another value. Where laws alone change, they are all that is made anew.
    fn go(&mut self, make: &AssemblyAt, value: f64, settings: &CurveSettings) -> Result<(), HarmonicError> {
        if self.value == value {
            return Ok(());
        }
        // After a failure halfway it belongs to no value.
        self.value = f64::NAN;
        let assembly = make(value)?;
        let same = assembly.waveform == self.assembly.waveform
            && assembly.load_swings == self.assembly.load_swings
            && assembly.static_offsets == self.assembly.static_offsets;
        if same && differ_in_laws(&assembly.system, &self.assembly.system) {
            self.balance.replace_laws(&assembly.system)?;
        } else {
            let harmonics = self.balance.harmonics();
            self.balance = balance_of(&assembly, settings)?;
            self.balance.set_harmonics(harmonics, &mut [])?;
        }
        (self.value, self.assembly) = (value, assembly);
        Ok(())
    }
}

/// Whether two systems are the same but for their laws and normal loads.
fn differ_in_laws(one: &System, other: &System) -> bool {
    let alike = |pair: (&Element, &Element)| match pair {
        (Element::Law { port, .. }, Element::Law { port: other, .. }) => port == other,
        (Element::Outside { port }, Element::Outside { port: other }) => port == other,
        (
            Element::Resonator { port, mass, angular_frequency, damping_ratio },
            Element::Resonator { port: at, mass: other, angular_frequency: natural, damping_ratio: ratio },
        ) => port == at && mass == other && angular_frequency == natural && damping_ratio == ratio,
        (
            Element::Springs { ports, stiffness },
            Element::Springs { ports: other_ports, stiffness: other },
        ) => ports == other_ports && stiffness == other,
        _ => false,
    };
    one.elements.len() == other.elements.len()
        && one.elements.iter().zip(&other.elements).all(alike)
        && one.core == other.core
        && one.shortening == other.shortening
        && one.ports == other.ports
        && one.driven == other.driven
        && one.sensors == other.sensors
}

impl<'a> Varied<'a> {
    /// The balance of what `make` makes, at first of `value`; differences take the parameter for no smaller than `least`.
    pub fn new(
        make: &'a AssemblyAt<'a>,
        value: f64,
        least: f64,
        settings: &CurveSettings,
    ) -> Result<Self, HarmonicError> {
        let here = Variant::new(make, value, settings)?;
        Ok(Self { make, settings: *settings, least, here, beside: None, step: 0.0, by: Vec::new() })
    }

    /// The system it is at.
    pub fn assembly(&self) -> &Assembly {
        &self.here.assembly
    }

    /// The change of the residual, of which the terms have the size `scale`, with the parameter.
    ///
    /// Forces have kinks where a contact begins to slip, which a response reaches just there. A difference across
    /// one is no derivative of either side, so the step shrinks until none is in sight.
    fn differentiate(&mut self, x: &[f64], at: &Operating, scale: f64) -> Result<(), HarmonicError> {
        let Self { make, settings, least, here, by, .. } = self;
        let size = at.parameter.abs().max(*least);
        let size = if size > 0.0 { size } else { 1.0 };
        let mut step = LONGEST * size;
        if self.beside.is_none() {
            let mut beside =
                [Variant::new(*make, at.parameter, settings)?, Variant::new(*make, at.parameter, settings)?];
            for variant in &mut beside {
                variant.balance.set_harmonics(here.balance.harmonics(), &mut [])?;
            }
            self.beside = Some(beside);
        }
        let Some([above, below]) = &mut self.beside else { return Ok(()) };
        loop {
            for (variant, value) in [(&mut *above, at.parameter + step), (&mut *below, at.parameter - step)] {
                variant.go(*make, value, settings)?;
                variant.balance.evaluate(x, &Operating { parameter: value, ..*at }, &[])?;
            }
            let (mut change, mut bend) = (0.0_f64, 0.0_f64);
            by.clear();
            let sides = above.balance.residual().iter().zip(below.balance.residual());
            for ((above, below), here) in sides.zip(here.balance.residual()) {
                change = change.max((above - below).abs());
                bend = bend.max((above - 2.0 * here + below).abs());
                by.push((above - below) / (2.0 * step));
            }
            if bend <= KINK * change + ROUNDING * scale || step <= SHORTEST * size {
                self.step = step;
                return Ok(());
            }
            step *= 0.1;
        }
    }

    /// The change of an output's harmonic with the parameter.
    fn output_by_parameter(&mut self, node: usize, order: usize) -> [f64; 2] {
        let Some([above, below]) = &mut self.beside else { return [0.0; 2] };
        let (above, below) = (above.balance.output(node, order), below.balance.output(node, order));
        std::array::from_fn(|part| (above[part] - below[part]) / (2.0 * self.step))
    }

    fn all(&mut self) -> impl Iterator<Item = &mut Variant> {
        std::iter::once(&mut self.here).chain(self.beside.iter_mut().flatten())
    }
}

impl PeriodicSystem for Varied<'_> {
    fn unknowns(&self) -> usize {
        self.here.balance.unknowns()
    }

    fn evaluate(&mut self, x: &[f64], at: &Operating, scalars: &[Scalar]) -> Result<f64, HarmonicError> {
        self.here.go(self.make, at.parameter, &self.settings)?;
        let scale = self.here.balance.evaluate(x, at, scalars)?;
        if scalars.contains(&Scalar::Parameter) {
            self.differentiate(x, at, scale)?;
        }
        Ok(scale)
    }

    fn residual(&self) -> &[f64] {
        self.here.balance.residual()
    }

    fn jacobian(&mut self) -> &DMatrix<f64> {
        self.here.balance.jacobian()
    }

    fn by(&self, scalar: Scalar) -> &[f64] {
        if scalar == Scalar::Parameter { &self.by } else { self.here.balance.by(scalar) }
    }

    fn output(&mut self, node: usize, order: usize) -> [f64; 2] {
        self.here.balance.output(node, order)
    }

    fn observe(&mut self, node: usize, order: usize, out: &mut Observation) {
        self.here.balance.observe(node, order, out);
        let by = self.output_by_parameter(node, order);
        (0..2).for_each(|part| out.by_scalars[part][Scalar::Parameter.index()] = by[part]);
    }

    fn forget(&mut self) {
        self.all().for_each(|variant| variant.balance.forget());
    }

    fn nodes(&self) -> usize {
        self.here.balance.nodes()
    }

    fn harmonics(&self) -> usize {
        self.here.balance.harmonics()
    }

    fn guess(&mut self, at: &Operating, x: &mut [f64]) -> Result<(), HarmonicError> {
        self.here.go(self.make, at.parameter, &self.settings)?;
        self.here.balance.guess(at, x)
    }

    fn rounding(&mut self, at: &Operating) -> f64 {
        self.here.balance.rounding(at)
    }

    fn compliance_homotopy(&mut self, compliances: f64) -> bool {
        self.here.balance.compliance_homotopy(compliances)
    }

    fn describe(&mut self, x: &[f64], at: &Operating) -> Result<Point, HarmonicError> {
        self.here.balance.describe(x, at)
    }

    fn nodes_along(&mut self, unknowns: &[f64], scalars: &[f64; 4], out: &mut [Vec<f64>]) {
        self.here.balance.nodes_along(unknowns, scalars, out);
        let along = scalars[Scalar::Parameter.index()];
        if along == 0.0 {
            return;
        }
        for (node, coefficients) in out.iter_mut().enumerate() {
            for order in 0..=coefficients.len() / 2 {
                let by = self.output_by_parameter(node, order);
                let places = (2 * order).saturating_sub(1)..=2 * order;
                coefficients[places].iter_mut().zip(by).for_each(|(value, by)| *value += along * by);
            }
        }
    }

    fn truncation_error(
        &mut self,
        x: &[f64],
        at: &Operating,
        point: &Point,
        solve: &mut dyn FnMut(&mut [f64]),
    ) -> Result<f64, HarmonicError> {
        self.here.balance.truncation_error(x, at, point, solve)
    }

    fn set_harmonics(
        &mut self,
        harmonics: usize,
        vectors: &mut [&mut Vec<f64>],
    ) -> Result<bool, HarmonicError> {
        for variant in self.beside.iter_mut().flatten() {
            variant.balance.set_harmonics(harmonics, &mut [])?;
        }
        self.here.balance.set_harmonics(harmonics, vectors)
    }

    fn replace_laws(&mut self, system: &System) -> Result<(), HarmonicError> {
        self.here.balance.replace_laws(system)
    }

    fn resume(&self, point: &Point, x: &mut [f64]) -> bool {
        self.here.balance.resume(point, x)
    }

    fn stable(&mut self, point: &Point) -> Result<bool, Undecided> {
        self.here.balance.stable(point)
    }
}
