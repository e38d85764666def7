//! Motion in time under a force that is a function of time, seen by sensors that lag.

use super::bench::Bench;
use super::error::RigError;
use super::measured::ContactSamples;
use crate::time::{Integrator, Motion, Outputs, Ramp, Settings};

/// Far below any sensor's noise.
const SETTINGS: Settings = Settings { tolerance: 1e-7, step_limit: 1_000_000 };
/// Intervals between two looks at whether to go on.
const BETWEEN_LOOKS: usize = 64;
/// Time between two looks where nothing is sampled (s).
const BETWEEN_LOOKS_TIME: f64 = 0.02;

/// A force of the shaker.
pub(super) struct Drive<'f> {
    /// Force (N) at a time (s).
    pub force: &'f dyn Fn(f64) -> f64,
    /// A parabola follows it over so long (s).
    pub smooth: f64,
}

impl Drive<'_> {
    /// The shaker is disconnected.
    pub const NONE: Drive<'static> = Drive { force: &|_| 0.0, smooth: f64::INFINITY };
}

/// When samples are taken.
pub(super) struct Sampling<'d> {
    /// Time between two (s); the first is at 0.
    pub step: f64,
    /// How many.
    pub count: usize,
    /// How late every accelerometer is (s).
    pub delays: &'d [f64],
}

impl Sampling<'_> {
    /// Whole intervals before 0 that the most delayed sensor still shows.
    pub fn before(&self) -> usize {
        self.delays.iter().map(|delay| (delay / self.step).ceil() as usize).max().unwrap_or(0)
    }

    pub fn times(&self) -> Vec<f64> {
        (0..self.count).map(|k| k as f64 * self.step).collect()
    }

    /// Where in an interval sensors are read, from its beginning on.
    fn visits(&self) -> Vec<Visit> {
        let mut visits = vec![Visit { offset: 0.0, way: 0.0, reads: Vec::new() }];
        for (sensor, delay) in self.delays.iter().enumerate() {
            let later = (delay / self.step).ceil();
            let offset = (later * self.step - delay).max(0.0);
            let read = (sensor, later as usize);
            match visits.iter_mut().find(|visit| visit.offset == offset) {
                Some(visit) => visit.reads.push(read),
                None => visits.push(Visit { offset, way: 0.0, reads: vec![read] }),
            }
        }
        visits.sort_by(|a, b| a.offset.total_cmp(&b.offset));
        let mut last = visits[visits.len() - 1].offset - self.step;
        for visit in &mut visits {
            visit.way = visit.offset - last;
            last = visit.offset;
        }
        visits
    }
}

/// A place in every interval between two samples.
struct Visit {
    /// Time after the beginning of the interval (s).
    offset: f64,
    /// From the visit before (s): to the last digit the same in every interval, so that steps of one length serve all.
    way: f64,
    /// Sensors that are read, and how many samples later they show it.
    reads: Vec<(usize, usize)>,
}

/// A beam in motion.
pub(super) struct March {
    integrator: Integrator,
    motion: Motion,
    inputs: Vec<Ramp>,
    time: f64,
    outputs: Outputs,
}

impl March {
    /// At rest at a time (s).
    pub fn at_rest(bench: &Bench, time: f64) -> Result<Self, RigError> {
        let mut integrator = Integrator::new(bench.system())?;
        let inputs = integrator.held_inputs();
        let motion = integrator.rest(&inputs)?;
        Self { integrator, motion, inputs, time, outputs: Outputs::default() }.taken_up()
    }

    /// At a time (s) with modal displacements, velocities, and a contact force (N).
    pub fn moving(
        bench: &Bench,
        time: f64,
        [displacement, velocity]: [&[f64]; 2],
        contact_force: f64,
    ) -> Result<Self, RigError> {
        let mut integrator = Integrator::new(bench.system())?;
        let inputs = integrator.held_inputs();
        let motion = integrator.moving(displacement, velocity, &inputs, &[contact_force])?;
        Self { integrator, motion, inputs, time, outputs: Outputs::default() }.taken_up()
    }

    fn taken_up(mut self) -> Result<Self, RigError> {
        self.integrator.take_up(&self.motion, &self.inputs)?;
        Ok(self)
    }

    /// Goes on by `way` (s).
    fn advance(&mut self, way: f64, drive: &Drive) -> Result<(), RigError> {
        let parts = (way / drive.smooth - 1e-9).ceil().max(1.0);
        let step = way / parts;
        for part in 0..parts as usize {
            let at = |fraction: f64| (drive.force)(self.time + step * (part as f64 + fraction));
            let [start, middle, end] = [0.0, 0.5, 1.0].map(at);
            self.inputs[0] = Ramp { start, end, bow: 4.0 * middle - 2.0 * (start + end), skew: 0.0 };
            self.integrator.advance(&mut self.motion, step, &self.inputs, &SETTINGS)?;
        }
        self.time += way;
        Ok(())
    }

    /// Goes on to `to` (s), in parts after each of which `watch` may end it.
    pub fn run_in(
        &mut self,
        to: f64,
        drive: &Drive,
        watch: &mut dyn FnMut(f64) -> bool,
    ) -> Result<(), RigError> {
        let way = to - self.time;
        if way <= 0.0 {
            return Ok(());
        }
        let parts = (way / BETWEEN_LOOKS_TIME).ceil();
        for _ in 0..parts as usize {
            if !watch(0.0) {
                return Err(RigError::Interrupted);
            }
            self.advance(way / parts, drive)?;
        }
        self.time = to;
        Ok(())
    }

    /// The samples of every accelerometer under one force before 0 and another after it, from where the first interval
    /// begins. `watch` sees the fraction done.
    pub fn sample(
        &mut self,
        sampling: &Sampling,
        [before, after]: [&Drive; 2],
        watch: &mut dyn FnMut(f64) -> bool,
    ) -> Result<(Vec<Vec<f64>>, Option<ContactSamples>), RigError> {
        let mut out = vec![vec![0.0; sampling.count]; sampling.delays.len()];
        let mut contact = (self.motion.contacts() > 0).then(ContactSamples::default);
        let (visits, lead) = (sampling.visits(), sampling.before());
        for interval in 0..lead + sampling.count {
            if interval.is_multiple_of(BETWEEN_LOOKS)
                && !watch(interval as f64 / (lead + sampling.count) as f64)
            {
                return Err(RigError::Interrupted);
            }
            for (place, Visit { offset, way, reads }) in visits.iter().enumerate() {
                let instant = (interval as f64 - lead as f64) * sampling.step + offset;
                if interval + place > 0 {
                    self.advance(*way, if instant <= 0.0 { before } else { after })?;
                    self.time = instant;
                }
                for (sensor, later) in reads {
                    let sample = (interval + later).checked_sub(lead);
                    if let Some(value) = sample.and_then(|sample| out[*sensor].get_mut(sample)) {
                        *value = self.integrator.sensor(*sensor, 2);
                    }
                }
                // Only now: a look at the contact leaves the shaker's force out.
                if let Some(contact) = contact.as_mut().filter(|_| place == 0 && interval >= lead) {
                    self.look(contact)?;
                }
            }
        }
        Ok((out, contact))
    }

    /// What the contact does now.
    fn look(&mut self, contact: &mut ContactSamples) -> Result<(), RigError> {
        let held = self.integrator.held_inputs();
        self.integrator.outputs(&self.motion, f64::INFINITY, &held, &mut self.outputs)?;
        if let Some(now) = self.outputs.contacts.first() {
            contact.displacement.push(now.displacement);
            contact.velocity.push(now.velocity);
            contact.force.push(now.force);
        }
        Ok(())
    }
}
