//! Systems and references shared by the tests of co-simulation.

use std::ops::ControlFlow;
use stickslip::cosim::{
    Algorithm, Failure, Master, Method, NativeSlave, Report, Settings, Slave, Source, Strong, System,
};
use stickslip::model::{Model, Structure};
use stickslip::system::ModalBeam;
use stickslip::time::{Integrator, Outputs, Ramp, Settings as Accuracy};

pub const BEAM: &str = include_str!("../../modelDescription/ModalBeam.toml");
pub const TWO_CONTACTS: &str = include_str!("../../modelDescription/ModalBeamTwoContacts.toml");
pub const VALANIS: &str = include_str!("../../modelDescription/ValanisContact.toml");
pub const JENKINS: &str = include_str!("../../modelDescription/JenkinsContact.toml");

pub const JACOBI: Algorithm = Algorithm::Jacobi { extrapolation: 0 };
pub const GAUSS_SEIDEL: Algorithm = Algorithm::GaussSeidel { extrapolation: 0, order: None };

pub fn strong(method: Method) -> Algorithm {
    Algorithm::Strong(Strong { method, tolerance: 1e-9, iterations: 40 })
}

/// A force that grows smoothly to its amplitude (N) over the first `growth` seconds.
#[derive(Debug, Clone, Copy)]
pub struct Shaker {
    pub amplitude: f64,
    pub omega: f64,
    pub growth: f64,
}

impl Shaker {
    pub fn force(&self, time: f64) -> f64 {
        let part = (time / self.growth).min(1.0);
        self.amplitude * part.powi(3) * (10.0 - part * (15.0 - 6.0 * part)) * (self.omega * time).sin()
    }

    pub fn rate(&self, time: f64) -> f64 {
        let part = (time / self.growth).min(1.0);
        let envelope = part.powi(3) * (10.0 - part * (15.0 - 6.0 * part));
        let slope = 30.0 * (part * (1.0 - part)).powi(2) / self.growth;
        let phase = self.omega * time;
        self.amplitude * (slope * phase.sin() + envelope * self.omega * phase.cos())
    }
}

pub fn native(name: &str, text: &str) -> Box<dyn Slave> {
    Box::new(NativeSlave::new(name, &Model::parse(text).expect("a model")).expect("a slave"))
}

/// Shaker, beam and contact, each a slave. Reported: displacement, velocity, force of the contact, and the
/// displacement at the shaker.
pub fn beam_with(contact: &str, shaker: Shaker) -> System {
    let mut system = System::new();
    let source = Source::new("shaker", "force", "N", move |time| shaker.force(time));
    let source = source.with_derivative(move |time| shaker.rate(time));
    system.add(Box::new(source)).unwrap();
    system.add(native("beam", BEAM)).unwrap();
    system.add(native("contact", contact)).unwrap();
    for (from, to) in [
        (("shaker", "force"), ("beam", "excitation")),
        (("beam", "displacement"), ("contact", "displacement")),
        (("beam", "velocity"), ("contact", "velocity")),
        (("contact", "force"), ("beam", "contact_force")),
    ] {
        system.connect(from, to, 1.0, 0.0).unwrap();
    }
    for (slave, variable) in [
        ("beam", "displacement"),
        ("beam", "velocity"),
        ("contact", "force"),
        ("beam", "displacement:x=0.55"),
    ] {
        system.observe(slave, variable).unwrap();
    }
    system
}

/// Jenkins' contact under this normal load (N), weak enough to slip on the beam.
pub fn damper(load: f64) -> String {
    JENKINS.replace("147.15 ", &format!("{load} "))
}

/// The shipped system BeamWithTwoContacts, with an exciter: a frictional support and a damper at midspan.
pub fn beam_with_two_contacts(shaker: Source) -> System {
    let mut system = System::new();
    system.add(Box::new(shaker)).unwrap();
    for (name, text) in [("beam", TWO_CONTACTS), ("contact", VALANIS), ("damper", &damper(15.0))] {
        system.add(native(name, text)).unwrap();
    }
    for (from, to) in [
        (("shaker", "force"), ("beam", "excitation")),
        (("beam", "displacement"), ("contact", "displacement")),
        (("contact", "force"), ("beam", "contact_force")),
        (("beam", "displacement:x=0.3"), ("damper", "displacement")),
        (("damper", "force"), ("beam", "contact_force:x=0.3")),
    ] {
        system.connect(from, to, 1.0, 0.0).unwrap();
    }
    system
}

/// The beam with one contact in one piece: rows of time, and the displacements at contact and shaker, every `every` steps.
pub fn monolithic(contact: &str, shaker: Shaker, step: f64, stop: f64, every: u64) -> Vec<[f64; 3]> {
    let model = Model::parse(BEAM).unwrap();
    let Structure::Beam(mut beam) = model.structure.clone() else { panic!("a beam") };
    beam.sensors = vec![0.55];
    let law = Model::parse(contact).unwrap().law().unwrap().unwrap();
    let load = Model::parse(contact).unwrap().contact.unwrap().normal_load;
    let system = ModalBeam::new(&beam).unwrap().system(Some((law.into(), load))).unwrap();
    let mut integrator = Integrator::new(&system).unwrap();
    let mut motion = integrator.rest(&integrator.held_inputs()).unwrap();
    let mut outputs = Outputs::default();
    let accuracy = Accuracy { tolerance: 1e-10, ..Accuracy::default() };
    let mut rows = vec![[0.0; 3]];
    for index in 0..(stop / step).round() as u64 {
        let (from, to) = (index as f64 * step, (index + 1) as f64 * step);
        let [start, middle, end] = [from, 0.5 * (from + to), to].map(|time| shaker.force(time));
        let force = Ramp { start, end, bow: 4.0 * middle - 2.0 * (start + end), skew: 0.0 };
        let inputs = [force, Ramp::held(load)];
        integrator.advance(&mut motion, step, &inputs, &accuracy).unwrap();
        if (index + 1) % every == 0 {
            let inputs = [Ramp::held(shaker.force(to)), Ramp::held(load)];
            integrator.outputs(&motion, f64::INFINITY, &inputs, &mut outputs).unwrap();
            rows.push([to, outputs.contacts[0].displacement, outputs.sensors[0].displacement]);
        }
    }
    rows
}

/// Times and values at all communication points.
pub type Rows = Vec<(f64, Vec<f64>)>;

pub fn record(system: System, settings: Settings) -> Result<(Rows, Report), Failure> {
    let mut rows = Rows::new();
    let report = Master::new(system, settings).expect("a system").run(|point| {
        rows.push((point.time, point.values.to_vec()));
        ControlFlow::Continue(())
    })?;
    Ok((rows, report))
}

/// Half the range of `values`.
pub fn amplitude(values: impl Iterator<Item = f64>) -> f64 {
    let (low, high) = values.fold((f64::MAX, f64::MIN), |(low, high), x| (low.min(x), high.max(x)));
    0.5 * (high - low)
}
