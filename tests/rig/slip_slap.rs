//! Both forces of a contact that slips and slaps come back from the records of the rig.

use std::sync::{Arc, OnceLock};

use stickslip::contact::{ContactLaw, Inputs, Response, SlipSlap, StateTangents};
use stickslip::data::{Dataset, Record, Regime};
use stickslip::harmonic::fourier::from_samples;
use stickslip::identify::{IdentifyOptions, ModeCount, SlipSlapIdentification, identify_slip_slap};
use stickslip::rig::{Chain, DualMode, RigError, Tested, dual_mode_on, separation_on, slap_in_time};
use stickslip::system::{ModalPinRig, System};

use crate::common::pin_rig::{contact, model_b};

const PERIODS: usize = 2;
const LEVELS: [[f64; 2]; 3] = [[14.0, 34.0], [17.5, 42.5], [20.0, 50.0]];

/// The paper's three levels on the rig of the reference values, with 20 modes.
fn tested() -> &'static [Tested] {
    static TESTED: OnceLock<Vec<Tested>> = OnceLock::new();
    TESTED.get_or_init(|| tested_with(contact(&model_b()), &LEVELS))
}

fn tested_with(contact: Arc<SlipSlap>, levels: &[[f64; 2]]) -> Vec<Tested> {
    let system = ModalPinRig::new(&model_b()).unwrap().system(Some(contact));
    let test = DualMode { periods: PERIODS, ..DualMode::at(52.0, levels.to_vec()) };
    dual_mode_on(&system, &[0.55, 0.3, 0.05], &Chain::default(), &test).unwrap()
}

/// The records as a chain with these gains of accelerometers and load cell shows them.
fn dataset(gains: [f64; 4]) -> Dataset {
    let shown = |tested: &Tested| {
        let mut record: Record = tested.record.clone();
        let mut next = gains.iter();
        for channel in &mut record.channels {
            let gain = match channel.name.as_str() {
                "time" => 1.0,
                "excitation" => gains[3],
                _ => *next.next().unwrap(),
            };
            channel.values.iter_mut().for_each(|value| *value *= gain);
        }
        record
    };
    Dataset { title: None, records: tested().iter().map(shown).collect() }
}

/// 30 modes, which the simulation does not have.
fn identified(gains: [f64; 4], doubt: f64) -> SlipSlapIdentification {
    let options = IdentifyOptions {
        excitation_gain: doubt,
        sensor_gain: doubt,
        modes: ModeCount::Fixed(30),
        ..IdentifyOptions::default()
    };
    identify_slip_slap(&model_b(), &dataset(gains), &options).unwrap()
}

/// From records without any fault, told to be exact.
fn clean() -> &'static SlipSlapIdentification {
    static CLEAN: OnceLock<SlipSlapIdentification> = OnceLock::new();
    CLEAN.get_or_init(|| identified([1.0; 4], 0.0))
}

/// Root mean square of a difference over that of the truth, means left out.
fn error(found: &[f64], truth: &[f64]) -> f64 {
    let square = |x: &mut dyn Iterator<Item = f64>| x.skip(1).map(|x| x * x).sum::<f64>();
    let at = |k: usize| found.get(k).copied().unwrap_or(0.0);
    let off = square(&mut truth.iter().enumerate().map(|(k, truth)| at(k) - truth));
    (off / square(&mut truth.iter().copied())).sqrt()
}

/// Coefficients of the true force S, N or displacement ξ in record `k`.
fn truth(k: usize, quantity: usize) -> Vec<f64> {
    let (name, sign) = [("force", 1.0), ("normal_load", -1.0), ("displacement", 1.0)][quantity];
    let values = &tested()[k].contact.as_ref().unwrap().channel(name).unwrap().values;
    from_samples(values, PERIODS, 15).iter().map(|x| sign * x).collect()
}

/// The largest errors over the records: of S, N and ξ.
fn errors(found: &SlipSlapIdentification) -> [f64; 3] {
    let mut worst = [0.0_f64; 3];
    for (k, (along, across)) in found.inversion.periods.iter().zip(&found.inversion.normal).enumerate() {
        for (place, found) in [&along.force, &across.force, &along.displacement].into_iter().enumerate() {
            worst[place] = worst[place].max(error(found, &truth(k, place)));
        }
    }
    worst
}

#[test]
fn both_forces_come_back_at_every_level() {
    let found = clean();
    let [tangential, normal, displacement] = errors(found);
    assert!(tangential <= 0.05 && normal <= 0.03, "S {tangential}, N {normal}");
    assert!(displacement <= 0.02, "ξ {displacement}");
    for (record, [first, third]) in found.records.iter().zip(LEVELS) {
        assert!(
            (record.accelerations[0] - first).abs() < 1e-6 && (record.accelerations[1] - third).abs() < 1e-6
        );
    }
    // Forces hang little on what is assumed of the beam; the normal displacement does, however exact the records are.
    assert!(found.by_modulus[0] < 0.05 && found.by_modulus[1] < 0.01, "{:?}", found.by_modulus);
    assert!(found.by_normal_stiffness.iter().all(|change| *change < 1e-3), "{:?}", found.by_normal_stiffness);
    for name in ["normal_displacement", "normal_stiffness", "hardening", "published_normal_displacement"] {
        assert!(found.unidentified.iter().any(|one| one.name == name), "{:?}", found.unidentified);
    }
    // The least normal force of the reference values: the pin stays on its support.
    let [least, most] = found.records[2].normal_force;
    assert!((least - 44.0).abs() < 1.5 && most < 95.0, "{least} … {most}");
}

#[test]
fn gains_of_the_measuring_chain_leave_both_forces_and_make_the_normal_displacement_unidentified() {
    // One per cent off each, in turn, and all at once against each other.
    let off = [[1.01, 0.99, 1.01, 0.99], [0.99, 0.985, 1.01, 1.005], [0.99, 1.01, 1.01, 1.0]];
    for gains in off {
        let found = identified(gains, 0.01);
        let [tangential, normal, _] = errors(&found);
        assert!(tangential <= 0.10 && normal <= 0.05, "{gains:?}: S {tangential}, N {normal}");
        let names: Vec<&str> = found.unidentified.iter().map(|one| one.name).collect();
        assert!(names.contains(&"normal_displacement") && names.contains(&"normal_stiffness"), "{names:?}");
        assert!(!names.contains(&"tangential_displacement"), "{:?}", found.unidentified);
    }
    // Told to be exact, the chain's faults become a force.
    let [tangential, ..] = errors(&identified(off[0], 0.0));
    assert!(tangential > 0.2, "S {tangential}");
}

#[test]
fn a_contact_that_gives_energy_tells_no_force() {
    let gives = |found: &SlipSlapIdentification| {
        let names: Vec<&str> = found.unidentified.iter().map(|one| one.name).collect();
        let told = names.contains(&"tangential_force") && names.contains(&"normal_force");
        (found.warnings.iter().filter(|one| one.contains("gives")).count(), told)
    };
    assert_eq!(gives(clean()), (0, false));
    // The sign of the load cell, and of the accelerometer at the drive.
    for gains in [[1.0, 1.0, 1.0, -1.0], [-1.0, 1.0, 1.0, 1.0]] {
        let found = identified(gains, 0.01);
        assert!(gives(&found).0 >= LEVELS.len() && gives(&found).1, "{:?}", found.warnings);
    }
    // One that shows g for m/s² fits no model of the beam.
    let found = identified([1.0 / 9.81, 1.0, 1.0, 1.0], 0.01);
    assert!(found.warnings.iter().any(|one| one.contains("No force")), "{:?}", found.warnings);
}

/// Few modes hold the contact across the beam by their own stiffness: what is identified with them is an echo of it.
#[test]
fn too_few_modes_leave_the_normal_direction_unidentified() {
    let options = IdentifyOptions { modes: ModeCount::Fixed(10), ..IdentifyOptions::default() };
    let found = identify_slip_slap(&model_b(), &dataset([1.0; 4]), &options).unwrap();
    let names: Vec<&str> = found.unidentified.iter().map(|one| one.name).collect();
    assert!(names.contains(&"normal_force") && names.contains(&"normal_displacement"), "{names:?}");
    assert!(!names.contains(&"tangential_force"), "{names:?}");
}

/// Micro-slip at every level, macro-slip at the higher ones; what sticks has the stiffness of all sliders. Hertz' law hardens.
#[test]
fn loops_show_micro_slip_macro_slip_and_hardening() {
    let records = &clean().records;
    for record in records {
        let [sticks, partly, whole] = record.slopes.parts;
        assert!((record.slopes.stuck / 3.95e6 - 1.0).abs() < 0.05, "{:?}", record.slopes);
        assert!(sticks > 0.1 && partly > 0.5 && (sticks + partly + whole - 1.0).abs() < 1e-9);
        let [soft, hard] = record.normal_slopes;
        assert!(2.0e7 < soft && soft < 2.37e7 && 2.37e7 < hard && hard < 2.7e7, "{soft} {hard}");
        // A large loop and two within it, in both directions.
        assert_eq!(record.loops(), [3, 3]);
        // A modulus 0.1 % larger takes off about half of the hardening.
        let [here, stiffer] = record.hardening();
        assert!((0.08..0.16).contains(&here) && stiffer < 0.6 * here, "{here} {stiffer}");
    }
    assert!(records[0].slopes.parts[2] < 1e-3 && records[2].slopes.parts[2] > 0.01);
}

/// The nonlinear modes hardly move the contact across the beam: their projection gives N many times too large, and η is what
/// the assumed normal stiffness makes of it.
#[test]
fn the_published_way_says_that_it_cannot_be_trusted() {
    let found = clean();
    assert_eq!(
        found.warnings.iter().filter(|warning| warning.contains("do not trust")).count(),
        LEVELS.len()
    );
    for (k, record) in found.records.iter().enumerate() {
        let published = record.published.as_ref().unwrap();
        assert!(!published.trusted() && published.modes.iter().all(|mode| mode.normal_ratio.abs() < 0.02));
        let [tangential, normal] = [0, 1].map(|place| error(&published.forces[place], &truth(k, place)));
        assert!(
            (0.4..0.8).contains(&tangential) && (10.0..16.0).contains(&normal),
            "S {tangential}, N {normal}"
        );
        assert!((published.difference[1] / normal - 1.0).abs() < 0.05, "{:?}", published.difference);
        assert!((published.echo + 1.0).abs() < 0.05, "{}", published.echo);
        // What it does well: both modes reproduce the acceleration, nearly in phase (the paper: within 10°).
        let [measured, reconstructed] = &published.acceleration;
        assert!(error(reconstructed, &measured[..reconstructed.len()]) < 0.02);
        assert!(published.modes.iter().all(|mode| mode.phase_scatter < 10.0_f64.to_radians()));
    }
}

/// A law under a normal load that follows the true one by so much about the preload.
#[derive(Debug)]
struct Following {
    law: Arc<dyn ContactLaw>,
    preload: f64,
    following: f64,
}

impl Following {
    fn seen(&self, load: f64) -> f64 {
        self.preload + self.following * (load - self.preload)
    }

    fn inputs(&self, inputs: Inputs) -> Inputs {
        Inputs { normal_load: self.seen(inputs.normal_load), ..inputs }
    }
}

impl ContactLaw for Following {
    fn state_len(&self) -> usize {
        self.law.state_len()
    }

    fn set_state(&self, displacement: f64, normal_load: f64, force: f64, state: &mut [f64]) {
        self.law.set_state(displacement, self.seen(normal_load), force, state);
    }

    fn step(&self, state: &[f64], inputs: Inputs, next: &mut [f64]) -> Response {
        let mut response = self.law.step(state, self.inputs(inputs), next);
        response.tangents.normal_load *= self.following;
        response
    }

    fn state_tangents(&self, state: &[f64], inputs: Inputs, out: &mut StateTangents) {
        self.law.state_tangents(state, self.inputs(inputs), out);
        out.next_by_normal_load.iter_mut().for_each(|by| *by *= self.following);
    }
}

#[test]
fn coupling_is_none_of_a_constant_limit_and_one_of_coulombs() {
    let rig = model_b();
    let truth = contact(&rig);
    for following in [0.0, 1.0] {
        let law = Following { law: truth.law().clone(), preload: rig.preload(), following };
        let contact = SlipSlap::new(Arc::new(law), *truth.normal());
        let tested = tested_with(Arc::new(contact), &LEVELS[1..]);
        let records = tested.iter().map(|tested| tested.record.clone()).collect();
        let options = IdentifyOptions { modes: ModeCount::Fixed(30), ..IdentifyOptions::default() };
        let found = identify_slip_slap(&rig, &Dataset { title: None, records }, &options).unwrap();
        // Each loop holds two more of the third harmonic.
        assert!(found.records.iter().all(|record| record.reversals[0] == 6));
        let coupling = found.coupling.unwrap();
        assert!((coupling.following - following).abs() < 0.1, "{following}: {coupling:?}");
        let [low, high] = coupling.interval;
        assert!(low <= following && following <= high && high - low < 0.3, "{following}: {coupling:?}");
        assert!((coupling.explained - following).abs() < 0.1, "{following}: {coupling:?}");
        assert!(coupling.left[1] < 0.02, "{coupling:?}");
    }
}

/// Model B under another preload: Hertz' law makes the contact softer where less presses on it.
fn under(preload: f64) -> Result<System, RigError> {
    let mut rig = model_b();
    let part = preload / rig.preload();
    rig.string.mass *= part;
    rig.stuck_stiffness[1] *= part.cbrt();
    Ok(ModalPinRig::new(&rig).unwrap().system(Some(contact(&rig))))
}

#[test]
fn the_pin_stays_on_its_support_at_the_published_level_and_slaps_under_a_lower_preload() {
    let preload = model_b().preload();
    let test = DualMode::at(52.0, vec![LEVELS[2]]);
    let found = &separation_on(&under, preload, &test).unwrap()[0];
    assert!((found.least_normal_force - 44.0).abs() < 1.0, "{found:?}");
    // The normal force swings by about as much under any preload, so that the records alone foretell the onset.
    let onset = found.onset.unwrap();
    assert!((onset / (preload - found.least_normal_force) - 1.0).abs() < 0.05, "{found:?}");
    let in_time = |part: f64| slap_in_time(&under(part * onset).unwrap(), found.forces, &test, 12).unwrap();
    let (above, below) = (in_time(1.5), in_time(0.8));
    assert_eq!(above.partings, 0);
    assert!(above.separation.iter().all(|apart| *apart == 0.0));
    assert!(below.partings > 12 && below.impact_energy > 10.0 * above.impact_energy, "{}", below.partings);
    for (force, apart) in below.normal_force.iter().zip(&below.separation) {
        assert!(*force >= 0.0 && (*apart == 0.0 || *force == 0.0) && *apart < 1e-3);
    }
}

/// Records that cannot tell both forces are refused, with the reason.
#[test]
fn too_few_sensors_a_part_of_a_period_and_other_regimes_are_refused() {
    let refused = |change: &dyn Fn(&mut Record), words: &str| {
        let mut data = dataset([1.0; 4]);
        data.records.truncate(1);
        data.records.iter_mut().for_each(change);
        let error =
            identify_slip_slap(&model_b(), &data, &IdentifyOptions::default()).unwrap_err().to_string();
        assert!(error.contains(words), "{error}");
    };
    let cut = |rows: usize| {
        move |record: &mut Record| {
            record.channels.iter_mut().for_each(|channel| channel.values.truncate(rows))
        }
    };
    let two = |record: &mut Record| record.channels.retain(|channel| !channel.name.ends_with("x=0.3"));
    refused(&two, "motions at 2 of the 3 places");
    // Of 256 samples a period.
    refused(&cut(200), "no steady state");
    refused(&|record| record.regime = Regime::FromRest, "its regime is not `steady`");
}
