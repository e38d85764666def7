//! Every signal of the systems that ship and have two contacts or a contact in two directions, under every algorithm,
//! against the same in one piece.

use std::fmt::Write as _;

use stickslip::cosim::{Settings, Source, System};
use stickslip::fmi::{Instance, Setup};
use stickslip::model::{Model, Structure};
use stickslip::system::{Element, ModalBeam};
use stickslip::time::{Integrator, Outputs, Ramp, Settings as Accuracy};

use crate::algorithms;
use crate::common::cosim::*;
use crate::drawing::{Curve, Panel};

const PIN_BEAM: &str = include_str!("../../modelDescription/PinnedBeam.toml");
const SLIP_SLAP: &str = include_str!("../../modelDescription/SlipSlapContact.toml");
const SLIP_SLAP_BEAM: &str = include_str!("../../modelDescription/SlipSlapBeam.toml");

/// Of the beams under a shaker: the contact at the pin slips, and the damper too.
const SHAKER: Shaker = Shaker { amplitude: 60.0, omega: 324.0, growth: 0.02 };
const STOP: f64 = 0.05;
/// Of the pin that slips and slaps: the exciter's force (N), which is there from the start on.
const EXCITATION: f64 = 60.0;
const STOP_OF_PIN: f64 = 4e-3;
/// Communication steps (s), and those that the pin's stiff contact needs. The first is the grid of the comparison.
const STEPS: &[f64] = &[1e-4, 5e-5, 2e-5, 1e-5, 5e-6, 2e-6];
const STEPS_OF_PIN: &[f64] = &[1e-5, 5e-6, 2e-6, 1e-6];
/// Step (s) and tolerance in one piece.
const FINE: (f64, f64) = (1e-6, 1e-10);
const SENSORS: [f64; 3] = [0.55, 0.3, 0.1];

/// A system with the same in one piece.
struct Shipped {
    name: &'static str,
    signals: Vec<(&'static str, String)>,
    coupled: fn() -> System,
    /// A row of all signals every first step.
    exact: Vec<Vec<f64>>,
    steps: &'static [f64],
    stop: f64,
}

/// Tables in `text` and a panel per signal.
pub fn every_signal(text: &mut String, panels: &mut Vec<Panel>) {
    text.push_str(
        "\n## Every signal of BeamWithTwoContacts and BeamWithSlipSlap\n\nRoot mean square of the error over the standard \
         deviation of the signal at 1e-5 s, and in brackets the order between the\nfinest two steps (2e-6 and 1e-6 s of \
         BeamWithSlipSlap, 5e-6 and 2e-6 s of the other). In one piece: the beam with both\ncontacts inside, integrated at \
         1e-6 s with a tolerance of 1e-10; SlipSlapBeam. The shaker's force grows to 60 N at 324 rad/s;\nthe pin that slips \
         and slaps is pushed by 60 N from the start on. A dash: the run ended early, or the signal stands still.\nThe systems with \
         one contact: [Masters on one system](masters/masters.md).\n",
    );
    for system in [two_contacts(), slip_slap()] {
        let errors = algorithms().map(|(name, algorithm)| {
            let at = |step: &f64| {
                let settings = Settings {
                    tolerance: Some(1e-10),
                    ..Settings::new(algorithm.clone(), *step, system.stop)
                };
                let rows = record(system.observed(), settings).ok();
                rows.map_or_else(
                    || vec![f64::NAN; system.signals.len()],
                    |(rows, _)| system.errors(&rows, *step),
                )
            };
            (name, system.steps.iter().map(at).collect::<Vec<_>>())
        });
        table(text, &system, &errors);
        for (signal, (slave, variable)) in system.signals.iter().enumerate() {
            let curve = |(name, errors): &(&'static str, Vec<Vec<f64>>)| {
                let of: Vec<f64> = errors.iter().map(|errors| errors[signal]).collect();
                Curve::new(name, system.steps, &of)
            };
            let title = format!("{}, {slave}.{variable}", system.name);
            panels.push(Panel { title, curves: errors.iter().map(curve).collect() });
        }
    }
}

fn table(text: &mut String, system: &Shipped, errors: &[(&str, Vec<Vec<f64>>)]) {
    // 1e-5 s, which all systems have.
    let shown = system.steps.iter().position(|step| *step == 1e-5).unwrap_or(0);
    let names: Vec<&str> = errors.iter().map(|(name, _)| *name).collect();
    let _ = writeln!(
        text,
        "\n### {}\n\n| signal | {} |\n|---|{}",
        system.name,
        names.join(" | "),
        "---|".repeat(names.len())
    );
    let last = system.steps.len() - 1;
    for (signal, (slave, variable)) in system.signals.iter().enumerate() {
        let cell = |(_, errors): &(&str, Vec<Vec<f64>>)| {
            let [there, coarse, fine] = [shown, last - 1, last].map(|step| errors[step][signal]);
            let order = (coarse / fine).ln() / (system.steps[last - 1] / system.steps[last]).ln();
            if there.is_finite() { format!("{there:.1e} ({order:.1})") } else { "–".to_owned() }
        };
        let cells: Vec<String> = errors.iter().map(cell).collect();
        let _ = writeln!(text, "| `{slave}.{variable}` | {} |", cells.join(" | "));
    }
}

impl Shipped {
    fn observed(&self) -> System {
        let mut system = (self.coupled)();
        for (slave, variable) in &self.signals {
            system.observe(slave, variable).expect("a variable");
        }
        system
    }

    /// Of every signal, at the instants of the grid.
    fn errors(&self, rows: &Rows, step: f64) -> Vec<f64> {
        let every = (self.steps[0] / step).round() as usize;
        let count = self.exact.len() as f64;
        let error = |signal: usize| {
            let mean = self.exact.iter().map(|row| row[signal]).sum::<f64>() / count;
            let spread: f64 = self.exact.iter().map(|row| (row[signal] - mean).powi(2)).sum();
            let pairs = rows.iter().step_by(every).zip(&self.exact);
            let off: f64 = pairs.map(|((_, values), exact)| (values[signal] - exact[signal]).powi(2)).sum();
            (off / spread).sqrt()
        };
        (0..self.signals.len()).map(error).collect()
    }
}

fn shaken() -> System {
    let source = Source::new("shaker", "force", "N", |time| SHAKER.force(time));
    beam_with_two_contacts(source.with_derivative(|time| SHAKER.rate(time)))
}

fn two_contacts() -> Shipped {
    let mut signals: Vec<(&str, String)> =
        ["displacement", "velocity"].map(|name| ("beam", name.to_owned())).into();
    for place in SENSORS {
        let at = |quantity: &str| ("beam", format!("{quantity}:x={place}"));
        signals.extend(["displacement", "velocity", "acceleration"].map(at));
    }
    for contact in ["contact", "damper"] {
        signals.extend(["force", "dissipated_energy"].map(|name| (contact, name.to_owned())));
    }
    Shipped {
        name: "BeamWithTwoContacts",
        signals,
        coupled: shaken,
        exact: in_one_piece(),
        steps: STEPS,
        stop: STOP,
    }
}

/// The beam with both contacts inside: displacement and velocity at the pin, of all sensors displacement, velocity and
/// acceleration, of both contacts force and energy.
fn in_one_piece() -> Vec<Vec<f64>> {
    let model = Model::parse(TWO_CONTACTS).expect("a model");
    let Structure::Beam(mut beam) = model.structure else { panic!("a beam") };
    beam.sensors = SENSORS.to_vec();
    let [support, damper] = [VALANIS, &damper(15.0)].map(|contact| {
        let model = Model::parse(contact).expect("a model");
        let law = model.law().expect("a law").expect("a contact");
        (law.into(), model.contact.expect("a contact").normal_load)
    });
    let mut system = ModalBeam::new(&beam).and_then(|beam| beam.system(Some(support))).expect("a beam");
    for element in &mut system.elements {
        if let Element::Outside { port } = *element {
            let (law, normal_load) = damper.clone();
            *element = Element::Law { port, law, normal_load };
        }
    }
    let mut integrator = Integrator::new(&system).expect("a system");
    let mut inputs = integrator.held_inputs();
    let mut motion = integrator.rest(&inputs).expect("rest");
    let mut outputs = Outputs::default();
    let accuracy = Accuracy { tolerance: FINE.1, ..Accuracy::default() };
    let every = (STEPS[0] / FINE.0).round() as u64;
    let mut rows = Vec::new();
    for index in 0..=(STOP / FINE.0).round() as u64 {
        let [start, middle, end] = [0.0, 0.5, 1.0].map(|part| SHAKER.force((index as f64 + part) * FINE.0));
        if index % every == 0 {
            inputs[0] = Ramp::held(start);
            integrator.outputs(&motion, f64::INFINITY, &inputs, &mut outputs).expect("outputs");
            let mut row = vec![outputs.contacts[0].displacement, outputs.contacts[0].velocity];
            row.extend(outputs.sensors.iter().flat_map(|s| [s.displacement, s.velocity, s.acceleration]));
            row.extend(
                outputs.contacts.iter().flat_map(|contact| [contact.force, contact.dissipated_energy]),
            );
            rows.push(row);
        }
        inputs[0] = Ramp { start, end, bow: 4.0 * middle - 2.0 * (start + end), skew: 0.0 };
        integrator.advance(&mut motion, FINE.0, &inputs, &accuracy).expect("a step");
    }
    rows
}

fn slip_slap() -> Shipped {
    let of_beam = ["displacement", "velocity", "opening", "opening_velocity"].map(str::to_owned);
    let at =
        |place: f64| ["displacement", "velocity", "acceleration"].map(|name| format!("{name}:x={place}"));
    let beam = of_beam.into_iter().chain([0.55, 0.3, 0.05].map(at).concat()).map(|name| ("beam", name));
    let names =
        ["force", "opening_force", "normal_force", "separation", "dissipated_energy", "impact_energy"];
    let signals: Vec<(&str, String)> = beam.chain(names.map(|name| ("contact", name.to_owned()))).collect();
    let exact = pin_in_one_piece(&signals);
    Shipped {
        name: "BeamWithSlipSlap",
        signals,
        coupled: pinned,
        exact,
        steps: STEPS_OF_PIN,
        stop: STOP_OF_PIN,
    }
}

fn pinned() -> System {
    let mut system = System::new();
    system.add(native("beam", PIN_BEAM)).expect("a name");
    system.add(native("contact", SLIP_SLAP)).expect("a name");
    for name in ["displacement", "velocity", "opening", "opening_velocity"] {
        system.connect(("beam", name), ("contact", name), 1.0, 0.0).expect("a connection");
    }
    for (from, to) in [("force", "contact_force"), ("opening_force", "opening_force")] {
        system.connect(("contact", from), ("beam", to), 1.0, 0.0).expect("a connection");
    }
    system.start("beam", "excitation", EXCITATION).expect("an input");
    system
}

fn pin_in_one_piece(signals: &[(&str, String)]) -> Vec<Vec<f64>> {
    let mut instance = Instance::new(SLIP_SLAP_BEAM).expect("an instance");
    let reference = |name: &str| instance.description().reference(name).expect("a variable");
    let excitation = reference("excitation");
    let references: Vec<u32> = signals.iter().map(|(_, name)| reference(name)).collect();
    instance.set_real(&[excitation], &[EXCITATION]).expect("a value");
    instance.set_up(Setup { tolerance: Some(1e-9), ..Setup::default() }).expect("set up");
    instance.enter_initialization().expect("initialization");
    instance.exit_initialization().expect("initialization");
    let step = STEPS_OF_PIN[0];
    let count = (STOP_OF_PIN / step).round() as usize;
    let row = |k: usize| {
        let mut row = vec![0.0; references.len()];
        instance.get_real(&references, &mut row).expect("values");
        if k < count {
            instance.do_step(k as f64 * step, step).expect("a step");
        }
        row
    };
    (0..=count).map(row).collect()
}
