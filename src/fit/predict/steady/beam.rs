//! A beam excited as measured through whole periods of a steady state.

use super::balance::{At, SteadyRecord};
use super::linearised::LinearisedAtMeasurement;
use crate::data::{Channel, Record};
use crate::fit::least_squares::{Parameter, Scale};
use crate::fit::predict::channels::position;
use crate::fit::predict::observed_system::{ObservedBeam, observed_assembly};
use crate::fit::predict::simulation::{Direction, Seed, Simulation};
use crate::harmonic::Assembly;
use crate::harmonic::steady::Start;
use crate::model::{Model, Structure};
use crate::system::Core;

/// Farthest static offset of a contact, in elastic displacements at the limit (m): from there on it slips wherever it
/// was.
const MOST_OFFSET: f64 = 2.0;
/// The same displacement where a model has no contact to say it.
const NO_REACH: f64 = 1e-9;

/// Misfits to the measured motion that differ by less, as a fraction of them, are those of one response: by so little half
/// the sum of squares of a record of 10⁴ samples changes by a tenth, and what a balance leaves unsolved is less.
const SAME_RESPONSE: f64 = 1e-5;
/// Halvings after which nothing is left between the two ends of the static offsets that would matter: a thousandth of an
/// elastic displacement.
const HALVINGS: usize = 12;

/// Harmonics in place of one: the error falls to a third and less, while the cost of a solution rises with their cube.
const MOST_FINER: usize = 3;

/// The simulation of one steady record of a beam. A contact that sticks all through keeps the force that it was left
/// with: its static offset is the unknown of the record.
pub(in crate::fit::predict) struct SteadyBeam<'r> {
    record: &'r Record,
    channels: Vec<&'r Channel>,
    beam: ObservedBeam,
    /// The highest mode (rad/s).
    highest: f64,
    solver: Solver,
    /// Follows the solver's last solution where predictions in more harmonics are asked for.
    finer: Option<Box<SteadyRecord>>,
}

enum Solver {
    Balance(Box<SteadyRecord>),
    /// To first order about the measured motion.
    Linearised(Box<LinearisedAtMeasurement>),
}

impl<'r> SteadyBeam<'r> {
    /// Of `channels` of `record`, with a discretisation fine enough for models like `model`.
    /// `seed` is a solution of another simulation of the record.
    pub fn new(
        model: &Model,
        record: &'r Record,
        channels: Vec<&'r Channel>,
        seed: Option<&Seed>,
    ) -> Result<Self, String> {
        let positions: Vec<f64> =
            channels.iter().map(|channel| position(channel)).collect::<Result<_, _>>()?;
        let mut beam = ObservedBeam::new(positions);
        beam.reduce(model)?;
        let system = beam.system(model)?;
        let highest = match &system.core {
            Core::Modal { angular_frequency, .. } => angular_frequency.iter().copied().fold(0.0, f64::max),
            Core::Matrices { .. } => 0.0,
        };
        let mut steady = SteadyRecord::new(record, &channels, highest, 1)?;
        let solver = match seed {
            Some(Seed::LinearisedAtMeasurement) => {
                Solver::Linearised(Box::new(LinearisedAtMeasurement::new(steady)))
            }
            seed => {
                if let Some(Seed::Near(start)) = seed {
                    steady.start_from(start);
                }
                let assembly = observed_assembly(system, model, steady.measured.load.as_deref(), 0.0);
                // Without a start later predictions search on their own.
                let at = At { model, nuisances: &[0.0], assembly: &assembly };
                let _ = steady.linearise(&at, &[], &mut Vec::new(), &mut []);
                Solver::Balance(Box::new(steady))
            }
        };
        Ok(Self { record, channels, beam, highest, solver, finer: None })
    }

    /// The record in more harmonics than the solver has, `finer` times as many or [`MOST_FINER`], about its last solution.
    fn in_more_harmonics(&self, finer: usize) -> Option<SteadyRecord> {
        let Solver::Balance(steady) = &self.solver else { return None };
        let start = steady.start()?;
        let finer = finer.min(MOST_FINER);
        let mut more = SteadyRecord::new(self.record, &self.channels, self.highest, finer).ok()?;
        more.start_from_fewer(start);
        Some(more)
    }

    /// A static offset (m), of those up to `reach` in either direction, from which the one that fits best is found by descent.
    ///
    /// Left beyond some offset the contact slips until it is at that one, which differs between the two directions where it
    /// sticks in the end: the misfit has a plateau on either side, where no derivative leads anywhere, and the best may be
    /// between them. `None` where an offset has no response, and where none matters: a contact that slips both ways in every
    /// period forgets, and there is one plateau. Faults of sensors are left to the descent.
    fn remembered_offset(&mut self, model: &Model, reach: f64) -> Option<f64> {
        let same = |a: f64, b: f64| (a - b).abs() <= SAME_RESPONSE * a;
        let (mut low, mut high) = (-reach, reach);
        let [below, above] = [self.misfit(model, low)?, self.misfit(model, high)?];
        if same(below, above) {
            return None;
        }
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            let here = self.misfit(model, middle)?;
            if same(here, below) {
                low = middle;
            } else if same(here, above) {
                high = middle;
            } else {
                return Some(middle);
            }
        }
        Some(if below < above { low } else { high })
    }

    /// How far what is predicted with a static offset (m) is from what was measured; `None` without a response.
    fn misfit(&mut self, model: &Model, offset: f64) -> Option<f64> {
        let assembly = self.assembly(model, &[offset]).ok()?;
        let Solver::Balance(steady) = &mut self.solver else { return None };
        let (at, mut predictions) = (At { model, nuisances: &[offset], assembly: &assembly }, Vec::new());
        steady.predict(&at, &mut predictions).ok()?;
        Some(steady.measured.distance(&predictions))
    }

    fn assembly(&self, model: &Model, nuisances: &[f64]) -> Result<Assembly, String> {
        let load = match &self.solver {
            Solver::Balance(steady) => steady.measured.load.as_deref(),
            Solver::Linearised(about) => about.load(),
        };
        let offset = nuisances.first().copied().unwrap_or(0.0);
        Ok(observed_assembly(self.beam.system(model)?, model, load, offset))
    }
}

impl Simulation for SteadyBeam<'_> {
    fn channels(&self) -> &[&Channel] {
        &self.channels
    }

    fn solution(&self) -> Option<&Start> {
        match &self.solver {
            Solver::Balance(steady) => steady.start(),
            Solver::Linearised(_) => None,
        }
    }

    fn nuisances(&mut self, model: &Model) -> Result<Vec<Parameter>, String> {
        // The static force of a contact in two directions is that of a first loading.
        if let Structure::PinRig(_) = model.structure {
            return Ok(Vec::new());
        }
        let elastic = model
            .contact
            .map(|contact| contact.friction_coefficient * contact.normal_load / contact.tangential_stiffness);
        let reach = elastic.filter(|reach| reach.is_finite() && *reach > 0.0).unwrap_or(NO_REACH);
        let (lower, upper) = (-MOST_OFFSET * reach, MOST_OFFSET * reach);
        self.beam.reduce(model)?;
        let start = self.remembered_offset(model, upper).unwrap_or(0.0);
        Ok(vec![Parameter { start, lower, upper, scale: Scale::Linear }])
    }

    fn is_rough(&self) -> bool {
        matches!(self.solver, Solver::Linearised(_))
    }

    fn refine(&mut self, finer: usize) {
        let more = (finer > 1).then(|| self.in_more_harmonics(finer));
        self.finer = more.flatten().map(Box::new);
    }

    fn predict(&mut self, model: &Model, nuisances: &[f64], out: &mut Vec<f64>) -> Result<(), String> {
        self.beam.reduce(model)?;
        let assembly = self.assembly(model, nuisances)?;
        let at = At { model, nuisances, assembly: &assembly };
        match (&mut self.finer, &mut self.solver) {
            (Some(finer), _) => finer.follow(&at, out),
            (None, Solver::Balance(steady)) => steady.predict(&at, out),
            (None, Solver::Linearised(about)) => about.predict(&at, out),
        }
    }

    fn linearise(
        &mut self,
        model: &Model,
        nuisances: &[f64],
        directions: &[Direction],
        predictions: &mut Vec<f64>,
        derivatives: &mut Vec<Vec<f64>>,
    ) -> Result<(), String> {
        self.beam.reduce(model)?;
        let assembly = self.assembly(model, nuisances)?;
        let neighbours = directions.iter().map(|there| self.assembly(&there.model, &there.nuisances));
        let neighbours: Vec<Assembly> = neighbours.collect::<Result<_, _>>()?;
        derivatives.resize_with(directions.len(), Vec::new);
        let at = At { model, nuisances, assembly: &assembly };
        match &mut self.solver {
            Solver::Balance(steady) => steady.linearise(&at, &neighbours, predictions, derivatives)?,
            Solver::Linearised(about) => about.linearise(&at, &neighbours, predictions, derivatives)?,
        }
        for (direction, derivative) in directions.iter().zip(derivatives) {
            derivative.iter_mut().for_each(|change| *change /= direction.step);
        }
        Ok(())
    }
}
