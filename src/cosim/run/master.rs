//! The run of a system from start to stop.

use super::adaptive::StepControl;
use super::initialize::initialize;
use super::report::{Cause, Failure, Observed, Point, Report, RunError, Unconverged};
use crate::cosim::schedule::Schedule;
use crate::cosim::settings::Settings;
use crate::cosim::slave::{Severity, SlaveError};
use crate::cosim::step::engine::Engine;
use crate::cosim::step::level::Trouble;
use crate::cosim::step::notes::notes;
use crate::cosim::system::{Port, System, SystemError};
use std::collections::BTreeMap;
use std::ops::ControlFlow;

/// How many unconverged steps are listed.
const EXAMPLES: usize = 20;
/// Steps after which an energy residual shows an explosion: before, little energy has passed.
const SHOWN_AFTER: u64 = 50;
/// Two times that differ by less than this part of a step are the same.
const SAME: f64 = 1e-6;

/// Runs a system.
///
/// ```
/// use std::ops::ControlFlow;
/// use stickslip::cosim::{Algorithm, Master, NativeSlave, Settings, Source, System};
/// use stickslip::model::Model;
///
/// let contact = r#"
///     schema = "stickslip.model/1"
///     kind = "contact"
///     [contact]
///     law = "jenkins"
///     tangential_stiffness = 2e6
///     friction_coefficient = 0.5
///     normal_load = 100.0
/// "#;
/// let mut system = System::new();
/// let contact = NativeSlave::new("contact", &Model::parse(contact)?)?;
/// system.add(Box::new(contact))?;
/// system.add(Box::new(Source::new("shaker", "displacement", "m", |time| 4e-5 * (300.0 * time).sin())))?;
/// system.connect(("shaker", "displacement"), ("contact", "displacement"), 1.0, 0.0)?;
/// system.observe("contact", "force")?;
/// let settings = Settings::new(Algorithm::GaussSeidel { extrapolation: 0, order: None }, 1e-4, 0.1);
/// let mut largest = 0.0_f64;
/// let report = Master::new(system, settings)?.run(|point| {
///     largest = largest.max(point.values[0]);
///     ControlFlow::Continue(())
/// })?;
/// assert_eq!((report.steps, largest), (1000, 50.0));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Master {
    engine: Engine,
    settings: Settings,
    starts: Vec<(Port, f64)>,
    observed: Vec<Observed>,
    report: Report,
    control: Option<StepControl>,
    /// What was beyond its tolerance, and how often.
    limits: BTreeMap<String, u64>,
    /// All slaves take steps of any length.
    variable: bool,
    /// The slaves have begun to step.
    initialized: bool,
}

impl Master {
    /// Makes `system` ready for a run.
    ///
    /// # Errors
    /// Settings out of range, an order that does not fit, an algebraic loop where none is to be.
    pub fn new(mut system: System, settings: Settings) -> Result<Self, SystemError> {
        settings.check()?;
        if settings.refuse_algebraic_loops
            && let Some(ports) = system.algebraic_loops().first()
        {
            let variables = ports.iter().map(|port| system.full_name(*port)).collect();
            return Err(SystemError::AlgebraicLoop { variables });
        }
        let schedule = Schedule::new(&system, &settings)?;
        let observed = system.observed().into_iter().map(|port| {
            let row = system.variable(port);
            let slave = system.slaves[port.slave].name().to_owned();
            let unit = row.unit.as_deref().map(str::to_owned);
            Observed { slave, variable: row.name.to_string(), unit, kind: row.kind }
        });
        let observed = observed.collect();
        let abilities = || system.slaves.iter().map(|slave| slave.abilities());
        let variable = abilities().all(|able| able.variable_step);
        let repeatable = variable && abilities().all(|able| able.saves_state);
        let control = settings.adaptive.filter(|_| repeatable);
        let control = control.map(|adaptive| StepControl::new(adaptive, settings.step));
        let report = Report { notes: notes(&system, &settings, &schedule), ..Report::default() };
        let starts = std::mem::take(&mut system.starts);
        let engine = Engine::new(system, &settings, &schedule);
        let (limits, initialized) = (BTreeMap::new(), false);
        Ok(Self { engine, settings, starts, observed, report, control, limits, variable, initialized })
    }

    /// What the observer receives, in this order.
    pub fn observed(&self) -> &[Observed] {
        &self.observed
    }

    /// What slaves cannot do, and how this changes the accuracy.
    pub fn notes(&self) -> &[String] {
        &self.report.notes
    }

    /// Runs from start to stop; `observer` is called at the start and after each communication step, and may
    /// stop the run.
    ///
    /// # Errors
    /// [`Failure`], with the results so far.
    pub fn run(mut self, mut observer: impl FnMut(&Point) -> ControlFlow<()>) -> Result<Report, Failure> {
        let result = self.simulate(&mut observer);
        self.terminate(result.as_ref().err());
        self.report.energy = std::mem::take(&mut self.engine.energy.residuals);
        self.report.unwatched = self.engine.mismatches.found();
        self.report.limits = self.limits.into_iter().collect();
        self.report.limits.sort_by_key(|(_, steps)| std::cmp::Reverse(*steps));
        match result {
            Ok(()) => Ok(self.report),
            Err(cause) => {
                let error = RunError { time: self.report.time, cause };
                Err(Failure { error, report: Box::new(self.report) })
            }
        }
    }

    /// Terminates the slaves that can still be called.
    fn terminate(&mut self, cause: Option<&Cause>) {
        let fatal = cause.is_some_and(|cause| cause.severity() == Severity::Fatal);
        if fatal || !self.initialized {
            return;
        }
        for unit in &mut self.engine.units {
            let lost = matches!(cause, Some(Cause::Slave(error)) if error.slave == unit.slave.name());
            if lost {
                continue;
            }
            if let Err(error) = unit.slave.terminate() {
                self.report.notes.push(format!("at the end {error}"));
            }
        }
    }

    fn simulate(&mut self, observer: &mut impl FnMut(&Point) -> ControlFlow<()>) -> Result<(), Cause> {
        self.report.time = self.settings.start;
        let (count, last) = self.grid();
        let Settings { start, step, stop, .. } = self.settings;
        let end = if count == 0 { start } else { start + (count - 1) as f64 * step + last };
        initialize(&mut self.engine, &self.settings, &self.starts, end.max(stop))?;
        self.initialized = true;
        let mut values = vec![0.0; self.engine.reported.len()];
        if self.observe(&mut values, 0.0, observer).is_break() {
            return Ok(());
        }
        if self.control.is_some() {
            return self.adapt(&mut values, observer);
        }
        for index in 0..count {
            let length = if index + 1 == count { last } else { step };
            self.step(length)?;
            self.report.time = if index + 1 == count { end } else { start + (index + 1) as f64 * step };
            if self.observe(&mut values, length, observer).is_break() {
                break;
            }
        }
        Ok(())
    }

    /// Number of equal steps, and the length of the last one.
    fn grid(&mut self) -> (u64, f64) {
        let Settings { start, step, stop, .. } = self.settings;
        let whole = (stop - start) / step;
        let nearest = whole.round();
        // A step longer than the whole run is cut to it.
        if whole == 0.0 || nearest >= 1.0 && (whole - nearest).abs() < SAME {
            return (nearest as u64, step);
        }
        if self.variable {
            return (whole.ceil() as u64, stop - start - whole.floor() * step);
        }
        if self.control.is_none() {
            self.report
                .notes
                .push(format!("the run ends at the last whole step of {step} s before {stop} s"));
        }
        (whole.floor() as u64, step)
    }

    fn observe(
        &mut self,
        values: &mut [f64],
        step: f64,
        observer: &mut impl FnMut(&Point) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        for (value, signal) in values.iter_mut().zip(&self.engine.reported) {
            *value = self.engine.signals.now[*signal];
        }
        let energy = &self.engine.energy.residuals;
        let flow = observer(&Point { time: self.report.time, step, values, energy });
        self.report.interrupted |= flow.is_break();
        flow
    }

    /// A step that is not repeated.
    fn step(&mut self, step: f64) -> Result<(), Cause> {
        match self.engine.step(self.report.time, step, false) {
            Ok(evaluations) => self.report.evaluations += u64::from(evaluations),
            Err(trouble) => return Err(self.cause(trouble, "the step is not adapted")),
        }
        self.engine.measure_energy(step);
        self.accept(step)
    }

    fn accept(&mut self, step: f64) -> Result<(), Cause> {
        if let Some((residual, slave)) = self.engine.unsettled() {
            self.report.unconverged += 1;
            if self.report.examples.len() < EXAMPLES {
                let (time, slave) = (self.report.time, slave.to_owned());
                self.report.examples.push(Unconverged { time, residual, slave });
            }
        }
        self.engine.accept(step)?;
        self.report.steps += 1;
        let exploded = self.engine.energy.exploded().filter(|_| self.report.steps >= SHOWN_AFTER);
        exploded.map_or(Ok(()), |residual| {
            let (force, motion) = (residual.force.clone(), residual.motion.clone());
            Err(Cause::Unstable { force, motion, fraction: residual.sum / residual.exchanged })
        })
    }

    fn cause(&self, trouble: Trouble, reason: &str) -> Cause {
        match trouble {
            Trouble::Failed(error) => Cause::Slave(error),
            Trouble::Discarded(unit, reached) => {
                let slave = self.engine.units[unit].slave.name().to_owned();
                Cause::GaveUp { slave, reached, reason: reason.to_owned() }
            }
        }
    }

    /// Steps of varying length up to the stop.
    fn adapt(
        &mut self,
        values: &mut [f64],
        observer: &mut impl FnMut(&Point) -> ControlFlow<()>,
    ) -> Result<(), Cause> {
        let stop = self.settings.stop;
        while let Some(mut control) = self.control {
            let left = stop - self.report.time;
            if left <= SAME * control.step.min(self.settings.step) {
                break;
            }
            // Two halves rather than a whole and a crumb.
            let wanted = control.step;
            let step = if wanted >= left {
                left
            } else if 2.0 * wanted > left {
                0.5 * left
            } else {
                wanted
            };
            let good = self.attempt(&mut control, step)?;
            self.control = Some(control);
            if !good {
                self.report.rejected += 1;
                continue;
            }
            if step < wanted && control.step > step {
                // The step was cut, not chosen.
                control.step = control.step.max(wanted.min(2.0 * step));
                self.control = Some(control);
            }
            self.report.time = if step == left { stop } else { self.report.time + step };
            if self.observe(values, step, observer).is_break() {
                break;
            }
        }
        Ok(())
    }

    /// Tries a step: true if it is done, false if all slaves are back at its beginning.
    fn attempt(&mut self, control: &mut StepControl, step: f64) -> Result<bool, Cause> {
        self.engine.save()?;
        let tried = self.engine.step(self.report.time, step, true);
        let smallest = control.at_smallest(step);
        let good = match tried {
            Ok(evaluations) => {
                self.report.evaluations += u64::from(evaluations);
                let settled = self.engine.unsettled().is_none();
                let limit = control.judge(&mut self.engine, step, settled);
                let good = limit.is_none();
                limit.into_iter().for_each(|limit| *self.limits.entry(limit).or_default() += 1);
                good
            }
            Err(Trouble::Failed(SlaveError { severity: Severity::Fatal, slave, message })) => {
                return Err(Cause::Slave(SlaveError { severity: Severity::Fatal, slave, message }));
            }
            Err(trouble) if smallest => return Err(self.cause(trouble, "it is the smallest step")),
            Err(trouble) => {
                let reached = match trouble {
                    Trouble::Discarded(_, reached) => (reached - self.report.time) / step,
                    Trouble::Failed(_) => 0.0,
                };
                control.retreat(step, reached);
                self.engine.restore()?;
                return Ok(false);
            }
        };
        if !good && !smallest {
            self.engine.restore()?;
            return Ok(false);
        }
        self.report.forced += u64::from(!good);
        self.accept(step)?;
        Ok(true)
    }
}
