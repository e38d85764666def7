//! The energy of slaves that slip and slap, from their own inputs and outputs: what comes in is kept or dissipated.
//!
//! Items to verify: over a cycle to 1e-6, and the error falls with the square of the step.

use std::f64::consts::TAU;

use nalgebra::{DMatrix, DVector};
use stickslip::contact::SlipSlap;
use stickslip::fmi::{Instance, Setup};
use stickslip::model::Model;
use stickslip::system::{Core, Element, Port, System};

const CONTACT: &str = include_str!("../../modelDescription/SlipSlapContact.toml");
const BEAM: &str = include_str!("../../examples/slip-slap/model.toml");
const FREQUENCY: f64 = 52.0;
const STIFFNESS: f64 = 3.95e6;

fn running(model: &str) -> Instance {
    let mut instance = Instance::new(model).unwrap();
    instance.set_up(Setup::default()).unwrap();
    instance.enter_initialization().unwrap();
    instance.exit_initialization().unwrap();
    instance
}

fn references(instance: &Instance, names: &[&str]) -> Vec<u32> {
    names.iter().map(|name| instance.description().reference(name).unwrap()).collect()
}

fn read(instance: &mut Instance, references: &[u32]) -> Vec<f64> {
    let mut values = vec![0.0; references.len()];
    instance.get_real(references, &mut values).unwrap();
    values
}

/// Work (J) along both directions in the second of two equal cycles of so many steps, and what friction and impacts take in it.
fn cycle_of_a_contact(of: usize) -> [f64; 3] {
    let mut instance = running(CONTACT);
    let inputs = references(&instance, &["displacement", "velocity", "opening", "opening_velocity"]);
    let outputs = references(&instance, &["force", "opening_force", "dissipated_energy", "impact_energy"]);
    let step = 1.0 / FREQUENCY / of as f64;
    let motion = |k: usize| {
        let (phase, speed) = (TAU * k as f64 / of as f64, TAU * FREQUENCY);
        let (xi, eta) = (phase.sin() + 0.6 * (3.0 * phase).sin(), 0.3 - (3.0 * phase + 0.4).cos());
        let (xi_rate, eta_rate) = (phase.cos() + 1.8 * (3.0 * phase).cos(), 3.0 * (3.0 * phase + 0.4).sin());
        [20e-6 * xi, 20e-6 * speed * xi_rate, 5e-6 * eta, 5e-6 * speed * eta_rate]
    };
    let mut before = (motion(0), read(&mut instance, &outputs));
    let [mut work, mut start] = [[0.0; 3], [0.0; 3]];
    for k in 0..2 * of {
        if k == of {
            start = [0.0, before.1[2], before.1[3]];
            work[0] = 0.0;
        }
        let now = motion(k + 1);
        instance.set_real(&inputs, &now).unwrap();
        instance.do_step(k as f64 * step, step).unwrap();
        let forces = read(&mut instance, &outputs);
        for (place, motion) in [0, 2].into_iter().enumerate() {
            work[0] += 0.5 * (forces[place] + before.1[place]) * (now[motion] - before.0[motion]);
        }
        before = (now, forces);
    }
    [work[0], before.1[2] - start[1], before.1[3] - start[2]]
}

#[test]
fn a_contact_by_itself_dissipates_the_work_of_a_cycle_to_1e_6() {
    let missing = |of: usize| {
        let [work, friction, impact] = cycle_of_a_contact(of);
        assert!(friction > 1e-4 && impact > 1e-3 * friction, "{friction} {impact}");
        (work / (friction + impact) - 1.0).abs()
    };
    let (coarse, fine) = (missing(2_500), missing(40_000));
    assert!(fine < 1e-6, "{fine}");
    assert!(fine < coarse / 64.0, "{coarse} {fine}");
}

/// More sensors than modes: their motion tells that of all modes.
const SENSORS: [f64; 6] = [0.55, 0.48, 0.37, 0.26, 0.15, 0.05];
const MODES: usize = 6;

/// A rig with one slider, whose energies have closed forms.
fn rig() -> String {
    let plain = &BEAM[..BEAM.find("[[effect]]").unwrap()];
    let sensors: String = SENSORS.iter().map(|x| format!("\n[[sensor]]\nposition = {x:?}\n")).collect();
    format!("{}{sensors}", plain.replace("modes = 20", &format!("modes = {MODES}")))
}

/// What the outputs of a rig say of its motion.
struct Seen {
    system: System,
    to_modes: DMatrix<f64>,
}

impl Seen {
    fn new(system: System) -> Self {
        let row = |name: &str| {
            let mut row = vec![0.0; MODES];
            system.ports[system.port(name).unwrap()].row.iter().for_each(|(i, b)| row[*i] += b);
            row
        };
        let names = SENSORS.map(|x| format!("x={x}"));
        let rows: Vec<Vec<f64>> =
            names.iter().map(String::as_str).chain(["contact.normal"]).map(row).collect();
        let shapes = DMatrix::from_fn(rows.len(), MODES, |i, j| rows[i][j]);
        Self { to_modes: shapes.pseudo_inverse(0.0).unwrap(), system }
    }

    fn modes(&self, seen: &[f64]) -> DVector<f64> {
        &self.to_modes * DVector::from_column_slice(seen)
    }

    /// Displacement or, with `rate`, velocity of a port.
    fn port(&self, port: &Port, q: &DVector<f64>, rate: Option<&DVector<f64>>) -> f64 {
        let shortening = DMatrix::from_row_slice(MODES, MODES, &self.system.shortening);
        let along = |v: &DVector<f64>| port.row.iter().map(|(i, b)| b * v[*i]).sum::<f64>();
        match rate {
            None => along(q) - 0.5 * port.shortening * q.dot(&(&shortening * q)),
            Some(v) => along(v) - port.shortening * v.dot(&(&shortening * q)),
        }
    }

    /// Energy (J) kept by modes, springs and masses at ports, and the contact.
    fn kept(&self, q: &DVector<f64>, v: &DVector<f64>, [force, opening]: [f64; 2]) -> f64 {
        let Core::Modal { angular_frequency, .. } = &self.system.core else { panic!("modal") };
        let modes = (0..MODES).map(|i| 0.5 * (v[i].powi(2) + (angular_frequency[i] * q[i]).powi(2)));
        let square = |matrix: &[[f64; 2]; 2], [x, y]: [f64; 2]| {
            0.5 * (matrix[0][0] * x * x + (matrix[0][1] + matrix[1][0]) * x * y + matrix[1][1] * y * y)
        };
        let at = |ports: &[usize; 2], rate| ports.map(|port| self.port(&self.system.ports[port], q, rate));
        let of = |contact: &SlipSlap| {
            let normal = contact.normal();
            let pressed = normal.stored_energy(opening) - normal.stored_energy(0.0);
            force.powi(2) / (2.0 * STIFFNESS) + pressed + normal.preload() * opening
        };
        let elements = self.system.elements.iter().map(|element| match element {
            Element::Springs { ports, stiffness } => square(stiffness, at(ports, None)),
            Element::Inertia { ports, mass } => square(mass, at(ports, Some(v))),
            Element::SlipSlap { contact, .. } => of(contact),
            _ => panic!("not of a rig"),
        });
        modes.sum::<f64>() + elements.sum::<f64>()
    }

    /// Power (W) that the modes' damping takes.
    fn damping(&self, v: &DVector<f64>) -> f64 {
        let Core::Modal { angular_frequency, damping_ratio } = &self.system.core else { panic!("modal") };
        (0..MODES).map(|i| 2.0 * damping_ratio[i] * angular_frequency[i] * v[i] * v[i]).sum()
    }
}

/// Of each cycle from rest: work, what the modes' damping, friction and impacts take, and what more is kept (J).
fn cycles_of_a_beam(of: usize, cycles: usize) -> Vec<[f64; 5]> {
    let text = rig();
    let seen = Seen::new(Model::parse(&text).unwrap().system().unwrap());
    let mut instance = running(&text);
    let named = |quantity: &str, last: Option<&str>| -> Vec<String> {
        SENSORS.iter().map(|x| format!("{quantity}:x={x}")).chain(last.map(str::to_owned)).collect()
    };
    let (places, rates) =
        (named("displacement", Some("opening")), named("velocity", Some("opening_velocity")));
    let others = ["acceleration:x=0.55", "force", "opening", "dissipated_energy", "impact_energy"];
    let names: Vec<&str> = places.iter().chain(&rates).map(String::as_str).chain(others).collect();
    let (outputs, excitation) = (references(&instance, &names), references(&instance, &["excitation"]));
    let step = 1.0 / FREQUENCY / of as f64;
    let look = |instance: &mut Instance| {
        let values = read(instance, &outputs);
        let n = SENSORS.len() + 1;
        let (q, v) = (seen.modes(&values[..n]), seen.modes(&values[n..2 * n]));
        let rest = &values[2 * n..];
        let kept = seen.kept(&q, &v, [rest[1], rest[2]]);
        ([values[n], rest[0]], [seen.damping(&v), rest[3], rest[4], kept])
    };
    let (mut driven, mut before) = look(&mut instance);
    let mut start = before;
    let (mut found, mut sums, mut last) = (Vec::new(), [0.0; 2], 0.0);
    for k in 0..cycles * of {
        let force = 60.0 * (TAU * (k + 1) as f64 / of as f64).sin();
        instance.set_real(&excitation, &[force]).unwrap();
        instance.do_step(k as f64 * step, step).unwrap();
        let (moved, now) = look(&mut instance);
        // Hermite's quadrature of force times velocity, of which the force runs linearly.
        let slope = (force - last) / step;
        let power = |force: f64, [v, a]: [f64; 2]| [force * v, slope * v + force * a];
        let ([p, dp], [r, dr]) = (power(last, driven), power(force, moved));
        sums[0] += 0.5 * step * (p + r) + step * step / 12.0 * (dp - dr);
        sums[1] += 0.5 * step * (before[0] + now[0]);
        (driven, before, last) = (moved, now, force);
        if (k + 1).is_multiple_of(of) {
            let more = |place: usize| before[place] - start[place];
            found.push([sums[0], sums[1], more(1), more(2), more(3)]);
            (start, sums) = (before, [0.0; 2]);
        }
    }
    found
}

#[test]
fn a_beam_by_itself_keeps_or_dissipates_the_work_of_every_cycle_to_1e_6() {
    let missing = |of: usize| {
        let cycles = cycles_of_a_beam(of, 3);
        let worst = cycles.iter().map(|[work, viscous, friction, impact, kept]| {
            let size = work.abs().max(kept.abs()).max(friction + viscous);
            assert!(*friction > 1e-3 * size && *impact > 0.0, "{cycles:?}");
            (work - viscous - friction - impact - kept).abs() / size
        });
        worst.fold(0.0, f64::max)
    };
    let (coarse, fine) = (missing(10_000), missing(40_000));
    assert!(fine < 1e-6, "{coarse} {fine}");
    assert!(fine < coarse / 8.0, "{coarse} {fine}");
}
