//! Writes the standard FMUs to a folder, those of FMI 3.0 to `fmi3` in it, and beside each a CSV file of a run of the same model without
//! FMI: for `tests/fmi`, which runs the FMUs on the same inputs and demands the same outputs.
//!
//! `cargo run -p stickslip-fmu-package --example native_trajectories -- FOLDER`

use std::fmt::Write as _;
use std::path::Path;
use std::{env, fs};
use stickslip_fmu_package::FmiVersion;

mod native {
    //! The models by the library's own means, not through a slave.
    use stickslip::contact::{Inputs, SlipSlapInputs, SlipSlapWork};
    use stickslip::model::{Beam, Contact, Model, Structure};
    use stickslip::system::ModalBeam;
    use stickslip::time::{ClassicalSteps, Integrator, Outputs, Ramp, Settings};

    /// Column names and rows.
    pub type Table = (Vec<String>, Vec<Vec<f64>>);

    /// Start of a smooth cycle of displacement with growing amplitude.
    fn displacement(time: f64) -> (f64, f64) {
        let (amplitude, growth, rate) = (20e-6, 60e-6, 2.0 * std::f64::consts::PI * 7.0);
        let (sine, cosine) = (rate * time).sin_cos();
        let level = amplitude + growth * time;
        (level * sine, growth * sine + level * rate * cosine)
    }

    /// Columns and rows of a run of `model`.
    pub fn run(model: &Model) -> Table {
        match (&model.structure, &model.contact) {
            (Structure::Beam(beam), contact) => self::beam(beam, contact.as_ref()),
            (Structure::PinRig(_), contact) => pin_rig(model, contact.is_some()),
            (Structure::Oscillator(_), _) => unreachable!("no standard FMU is an oscillator"),
            (Structure::Prescribed, Some(contact)) if contact.normal.is_some() => slip_slap(model),
            (Structure::Prescribed, contact) => self::contact(&contact.expect("a contact model")),
        }
    }

    /// A contact under a prescribed displacement and a normal load that lifts off twice.
    fn contact(contact: &Contact) -> Table {
        let law = contact.law().expect("legal");
        let mut state = vec![0.0; law.state_len()];
        let mut next = state.clone();
        let names = ["displacement", "velocity", "normal_load", "force", "dissipated_energy", "slip_state"];
        let mut rows = Vec::new();
        let mut energy = 0.0;
        for row in 0..=1000 {
            let time = f64::from(row) * 1e-3;
            let (displacement, velocity) = displacement(time);
            let normal_load = contact.normal_load * (1.0 + 1.1 * (11.0 * time).sin());
            let inputs = Inputs { displacement, velocity, normal_load };
            if row == 0 {
                law.set_state(0.0, normal_load, 0.0, &mut state);
            }
            let response = law.step(&state, inputs, &mut next);
            std::mem::swap(&mut state, &mut next);
            energy += response.dissipated_energy;
            let slip = f64::from(response.slip_state as i32);
            rows.push(vec![time, displacement, velocity, normal_load, response.force, energy, slip]);
        }
        (names.map(String::from).to_vec(), rows)
    }

    /// A contact in two directions that slips, lifts off and slaps.
    fn slip_slap(model: &Model) -> Table {
        let contact = model.slip_slap().expect("legal").expect("a normal law");
        let mut state = vec![0.0; contact.state_len()];
        contact.set_state([0.0; 2], 0.0, &mut state);
        let (mut next, mut work) = (state.clone(), SlipSlapWork::default());
        let inputs = ["displacement", "velocity", "opening", "opening_velocity"];
        let outputs = ["force", "opening_force", "normal_force", "separation", "dissipated_energy"];
        let more = ["impact_energy", "slip_state"];
        let (depth, rate) = (1.2 * contact.normal().static_approach(), 2.0 * std::f64::consts::PI * 21.0);
        let (mut energies, mut rows) = ([0.0; 2], Vec::new());
        for row in 0..=1000 {
            let time = f64::from(row) * 1e-3;
            let (u, v) = displacement(time);
            let (opening, speed) = (depth * (rate * time).sin(), depth * rate * (rate * time).cos());
            let inputs = SlipSlapInputs { displacement: [u, opening], velocity: [v, speed] };
            let response = contact.step(&state, inputs, &mut next, &mut work);
            std::mem::swap(&mut state, &mut next);
            energies[0] += response.friction_energy;
            energies[1] += response.impact_energy;
            let [force, opening_force] = response.force;
            let slip = f64::from(response.slip_state as i32);
            let forces = [force, opening_force, response.normal_force, response.separation];
            let inputs = [time, u, v, opening, speed];
            rows.push([&inputs[..], &forces, &energies, &[slip]].concat());
        }
        ([&inputs[..], &outputs, &more].concat().into_iter().map(String::from).collect(), rows)
    }

    /// What is written of a beam, but the time.
    fn columns_of_beam(beam: &Beam, has_contact: bool, places: &[(usize, f64)]) -> Vec<String> {
        let own: &[&str] = match has_contact {
            true => &["excitation", "normal_load", "force", "dissipated_energy", "slip_state"],
            false => &["excitation", "contact_force"],
        };
        let mut names: Vec<String> = own.iter().copied().map(String::from).collect();
        names.extend(beam.contact_points.iter().map(|place| format!("contact_force:x={place}")));
        names.extend(["displacement", "velocity"].map(String::from));
        for (_, place) in places {
            names
                .extend(["displacement", "velocity", "acceleration"].map(|name| format!("{name}:x={place}")));
        }
        names
    }

    /// A beam shaken near its first resonance, the inputs held over each step of 0.1 ms.
    fn beam(beam: &Beam, contact: Option<&Contact>) -> Table {
        let modal = ModalBeam::new(beam).expect("a standard model");
        let law = contact.map(|contact| (contact.law().expect("legal").into(), contact.normal_load));
        let mut integrator = Integrator::new(&modal.system(law).expect("a beam")).expect("a beam");
        let load = |time: f64| {
            contact.map_or(0.0, |contact| contact.normal_load) * (1.0 + 0.5 * (30.0 * time).sin())
        };
        let mut motion = integrator.rest(&integrator.held_inputs()).expect("legal inputs");
        let mut outputs = Outputs::default();
        // The force transducer and an accelerometer may share a place: one sensor there is enough.
        let mut places: Vec<(usize, f64)> = Vec::new();
        for (index, sensor) in modal.sensors.iter().enumerate() {
            if places.iter().all(|(_, place)| *place != sensor.position) {
                places.push((index, sensor.position));
            }
        }
        let names = columns_of_beam(beam, contact.is_some(), &places);
        let mut rows = Vec::new();
        let (count, step) = (2000, 1e-4);
        let mut before: Vec<Ramp> = Vec::new();
        for index in 0..=count {
            let time = f64::from(index) * step;
            let excitation = 20.0 * (2.0 * std::f64::consts::PI * 51.0 * time).sin();
            let other = match contact {
                Some(_) => load(time),
                None => 30.0 * (2.0 * std::f64::consts::PI * 17.0 * time).sin(),
            };
            let across = 5.0 * (2.0 * std::f64::consts::PI * 140.0 * time).sin();
            let at_points = vec![Ramp::held(across); beam.contact_points.len()];
            let mut inputs = vec![Ramp::held(excitation), Ramp::held(other)];
            inputs.extend(&at_points);
            if index == 0 {
                before.clone_from(&inputs);
            } else {
                let settings = Settings { tolerance: 1e-6, ..Settings::default() };
                integrator.advance(&mut motion, step, &inputs, &settings).expect("a step");
            }
            // Inputs held one after the other stand for inputs that run: their rates are those of the differences.
            let rising = inputs
                .iter()
                .zip(&before)
                .map(|(now, before)| Ramp::line(now.end, 2.0 * now.end - before.end));
            let (rising, lasting) =
                (rising.collect::<Vec<_>>(), if index > 0 { step } else { f64::INFINITY });
            integrator.outputs(&motion, lasting, &rising, &mut outputs).expect("outputs");
            before.clone_from(&inputs);
            let mut row = vec![time, excitation, other];
            row.extend(at_points.iter().map(|force| force.start));
            let end = &outputs.contacts[0];
            if contact.is_some() {
                row.extend([end.force, end.dissipated_energy, f64::from(end.slip_state as i32)]);
            }
            row.extend([end.displacement, end.velocity]);
            for (index, _) in &places {
                let sensor = &outputs.sensors[*index];
                row.extend([sensor.displacement, sensor.velocity, sensor.acceleration]);
            }
            rows.push(row);
        }
        (names, rows)
    }

    /// A pin rig shaken with two tones, its forces running to their values over each step; those from outside those of two
    /// springs that move by themselves.
    fn pin_rig(model: &Model, has_contact: bool) -> Table {
        let system = model.system().expect("a standard model");
        let mut steps = ClassicalSteps::new(&system).expect("a standard model");
        let mut motion = steps.rest();
        let inputs: &[&str] =
            if has_contact { &["excitation"] } else { &["excitation", "contact_force", "opening_force"] };
        let of_contact = ["force", "opening_force", "normal_force", "dissipated_energy", "impact_energy"];
        let of_contact: &[&str] = if has_contact { &of_contact } else { &[] };
        let of_pin = ["displacement", "velocity", "opening", "opening_velocity"];
        let names = [inputs, of_contact, &of_pin].concat().into_iter().map(String::from);
        let mut names: Vec<String> = names.collect();
        for sensor in &system.sensors {
            let place = &system.ports[*sensor].name;
            names.extend(["displacement", "velocity", "acceleration"].map(|name| format!("{name}:{place}")));
        }
        let (count, step) = (1000, if has_contact { 1e-4 } else { 1e-5 });
        let parts = (step / steps.longest_step()).ceil().max(1.0);
        let given = |time: f64| {
            let wave =
                |size: f64, frequency: f64| size * (2.0 * std::f64::consts::PI * frequency * time).sin();
            let all = [wave(1.85, 52.0) + wave(6.2, 156.0), wave(10.0, 130.0), wave(5.0, 170.0)];
            all[..inputs.len()].to_vec()
        };
        let contact = system.port("contact").expect("a rig");
        let normal = system.port("contact.normal").expect("a rig");
        let (mut motions, mut accelerations, mut rows) = (Vec::new(), Vec::new(), Vec::new());
        for index in 0..=count {
            let time = f64::from(index) * step;
            let (from, to) = (given(time - step), given(time));
            for part in 0..if index == 0 { 0 } else { parts as usize } {
                let line = |input: usize| {
                    [0.0, 0.5, 1.0]
                        .map(|place| from[input] + (to[input] - from[input]) * (part as f64 + place) / parts)
                };
                let outside: Vec<[f64; 3]> = (1..inputs.len()).map(line).collect();
                steps.advance_under(&mut motion, step / parts, line(0), &outside);
            }
            steps.motions_of_ports(&motion, &mut motions);
            steps.accelerations_of_ports(&motion, to[0], &to[1..], &mut accelerations);
            let mut row = vec![time];
            row.extend(&to);
            if has_contact {
                let now = motion.contacts[0];
                let lost = motion.energies;
                row.extend([now.force[0], now.force[1], now.normal_force, lost.friction, lost.impact]);
            }
            row.extend([contact, normal].into_iter().flat_map(|port| [motions[port].0, motions[port].1]));
            for sensor in &system.sensors {
                row.extend([motions[*sensor].0, motions[*sensor].1, accelerations[*sensor]]);
            }
            rows.push(row);
        }
        (names, rows)
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = env::args().nth(1).ok_or("which folder?")?;
    let folder = Path::new(&folder);
    fs::create_dir_all(folder.join("fmi3"))?;
    for (name, model_toml) in stickslip_fmu_package::standard_models() {
        let fmu = stickslip_fmu_package::write_fmu(name, model_toml)?;
        fs::write(folder.join(format!("{name}.fmu")), fmu)?;
        let fmu = stickslip_fmu_package::write_fmu_of(FmiVersion::Three, name, model_toml)?;
        fs::write(folder.join(format!("fmi3/{name}.fmu")), fmu)?;
        let model = stickslip::model::Model::parse(model_toml)?;
        let (names, rows) = native::run(&model);
        let mut csv = format!("time,{}\n", names.join(","));
        for row in rows {
            let cells: Vec<String> = row.iter().map(f64::to_string).collect();
            writeln!(csv, "{}", cells.join(","))?;
        }
        fs::write(folder.join(format!("{name}.csv")), csv)?;
    }
    Ok(())
}
