//! Kind `beam`: a beam whose end rubs on a support, in steady states around its first two resonances.
//!
//! draw.rs: its numbers and what is hidden; excitation.rs: what drives it; motion.rs: how it moves.

mod draw;
mod excitation;
mod motion;

use std::f64::consts::TAU;
use std::fmt::Write;

use crate::physics::finite_elements::{Geometry, Modes};
use crate::physics::joint::Joint;
use crate::records::record::{Column, Fault, Fine, Record, Regime, Role};
use crate::rigs::effect::Hidden;
use crate::rigs::prescribed::contact_table;
use crate::rigs::rig::Rig;
use excitation::Excitation;
use motion::Motion;

const MODES: usize = 6;
/// Samples of a period, and periods of a record.
const SAMPLES: usize = 128;
const PERIODS: usize = 4;
/// A level at which the motion never repeats itself is replaced by one of these multiples.
const OTHER_LEVELS: [f64; 7] = [1.0, 0.8, 1.25, 0.6, 1.6, 0.4, 0.2];
const SENSORS: [f64; 3] = [0.55, 0.3, 0.1];
const EXCITATION: f64 = 0.55;
const OFFSET: f64 = 0.006;

/// The beam with its support.
#[derive(Clone)]
pub struct Beam {
    geometry: Geometry,
    damping_ratio: f64,
    joint: Joint,
    normal_load: f64,
    /// Swing of the normal load: share, and harmonic of the excitation.
    swing: Option<(f64, f64)>,
    cubic_stiffness: f64,
    quadratic_damping: f64,
    /// Mass (kg) and frequency (Hz) of a resonator hung at the contact.
    hanging: Option<(f64, f64)>,
    fault: Option<Fault>,
    /// Fraction of the excitation that comes as its third harmonic and is not measured.
    disturbance: f64,
    records: Vec<Excitation>,
    hidden: Vec<Hidden>,
}

impl Beam {
    fn load(&self, excitation: &Excitation, angle: f64) -> f64 {
        let swing = self
            .swing
            .map_or(0.0, |(share, harmonic)| share * (harmonic * angle + excitation.phases[0]).sin());
        self.normal_load * (1.0 + swing)
    }

    fn record(&self, modes: &Modes, planned: &Excitation) -> Record {
        let mut levels = OTHER_LEVELS.iter().map(|level| planned.at_level(*level));
        let found = levels.find_map(|excitation| {
            let (fine, size) = Motion::new(self, modes, &excitation).steady()?;
            Some((fine, Excitation { size, ..excitation }))
        });
        let (fine, excitation) = found.unwrap_or_else(|| self.silence(planned));
        let excitation = &excitation;
        let period = 1.0 / excitation.frequency / SAMPLES as f64;
        let count = SAMPLES * PERIODS;
        let times: Vec<f64> = (0..count).map(|index| index as f64 * period).collect();
        let angle = |time: &f64| TAU * excitation.frequency * time;
        let force =
            times.iter().map(|time| excitation.size * (angle(time) + excitation.phase).cos()).collect();
        let loads = times.iter().map(|time| self.load(excitation, angle(time))).collect();
        let mut columns = vec![
            Column::new("time", "s", Role::Exact, times),
            Column::new("excitation", "N", Role::Driven, force),
        ];
        for (position, fine) in SENSORS.iter().zip(&fine) {
            let name = format!("acceleration:x={position}");
            let shown = fine.sample(&name, count, period, self.fault.as_ref());
            columns.push(Column::new(name, "m/s^2", Role::Response, shown));
        }
        if self.swing.is_some() {
            columns.push(Column::new("normal_load", "N", Role::Driven, loads));
        }
        Record { regime: Regime::Steady, columns, told: Vec::new() }
    }

    /// A record of nothing, should no level give a steady state.
    fn silence(&self, planned: &Excitation) -> ([Fine; 3], Excitation) {
        let fine = SENSORS.map(|_| Fine { values: vec![0.0; 2], step: 1.0, start: 0.0 });
        (fine, Excitation { size: 0.0, ..planned.clone() })
    }
}

impl Rig for Beam {
    fn respond(&self) -> Vec<Record> {
        let modes = Modes::of(&self.geometry, MODES);
        self.records.iter().map(|excitation| self.record(&modes, excitation)).collect()
    }

    fn base(&self) -> Vec<f64> {
        let joint = &self.joint;
        vec![self.geometry.youngs_modulus, self.damping_ratio, joint.stiffness, joint.friction_coefficient]
    }

    fn with_base(&self, values: &[f64]) -> Box<dyn Rig> {
        let mut rig = self.clone();
        (rig.geometry.youngs_modulus, rig.damping_ratio) = (values[0], values[1]);
        (rig.joint.stiffness, rig.joint.friction_coefficient) = (values[2], values[3]);
        Box::new(rig)
    }

    fn plain(&self) -> Box<dyn Rig> {
        let mut rig = self.clone();
        rig.joint = Joint::jenkins(self.joint.stiffness, self.joint.friction_coefficient);
        rig.geometry.point_masses.truncate(SENSORS.len());
        rig.geometry.clamp_stiffness = None;
        (rig.cubic_stiffness, rig.quadratic_damping, rig.disturbance) = (0.0, 0.0, 0.0);
        (rig.swing, rig.hanging, rig.fault) = (None, None, None);
        rig.hidden.clear();
        Box::new(rig)
    }

    fn ignorance(&self) -> Vec<f64> {
        // Of the paper's rig nothing is unknown but the law.
        let paper = self.records.iter().any(|excitation| excitation.held.is_some());
        if paper { vec![0.0; 4] } else { vec![0.02, 0.15, 0.15, 0.15] }
    }

    fn model(&self, off: &[f64]) -> String {
        let geometry = &self.geometry;
        let mut text = format!(
            "schema = \"stickslip.model/1\"\nkind = \"beam\"\n\n[beam]\nlength = {}\nwidth = {}\n\
             thickness = {}\ndensity = {:?}\nyoungs_modulus = {}\nmodes = {MODES}\ndamping_ratio = {}\n\n",
            geometry.length,
            geometry.width,
            geometry.thickness,
            geometry.density,
            geometry.youngs_modulus * off[0],
            self.damping_ratio * off[1]
        );
        for (position, mass) in &geometry.point_masses[..SENSORS.len()] {
            let _ = write!(text, "[[beam.point_mass]]\nposition = {position}\nmass = {mass}\n\n");
        }
        let _ = write!(text, "[support]\noffset = {OFFSET}\n\n[excitation]\nposition = {EXCITATION}\n\n");
        let (stiffness, friction) = (self.joint.stiffness * off[2], self.joint.friction_coefficient * off[3]);
        contact_table(&mut text, "", stiffness, friction, self.normal_load);
        text
    }

    fn hidden(&self) -> &[Hidden] {
        &self.hidden
    }

    fn tells_noise(&self, _: Regime) -> bool {
        false
    }
}
