//! The shared library as a host sees it.

use std::collections::BTreeSet;
use std::path::PathBuf;
use std::process::Command;

use stickslip_fmi_host::{Error, Slave, Status};
use stickslip_fmu_package::library;

use crate::support::unpack;

#[test]
#[cfg(target_os = "linux")]
fn the_library_exports_the_functions_of_both_headers_and_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("library.so");
    std::fs::write(&file, library().bytes).unwrap();
    let output =
        Command::new("nm").args(["-D", "--defined-only"]).arg(&file).output().expect("nm (binutils)");
    assert!(output.status.success());
    let text = String::from_utf8(output.stdout).unwrap();
    let exported: BTreeSet<&str> = text.lines().filter_map(|line| line.split_whitespace().last()).collect();
    let headers = [include_str!("fmi2_functions.txt"), include_str!("fmi3_functions.txt")];
    let expected: BTreeSet<&str> = headers.iter().flat_map(|header| header.lines()).collect();
    assert_eq!(expected.len(), 44 + 75);
    assert_eq!(exported, expected);
}

#[test]
fn two_copies_of_the_library_in_one_process_do_not_clash() {
    let (jenkins, valanis) = (unpack("JenkinsContact"), unpack("ValanisContact"));
    let (mut one, mut other) = (jenkins.running(), valanis.running());
    one.set_real(&[0], &[10e-6]).unwrap();
    other.set_real(&[0], &[10e-6]).unwrap();
    one.do_step(0.0, 1e-3).unwrap();
    other.do_step(0.0, 1e-3).unwrap();
    let (mut stiff, mut smooth) = ([0.0], [0.0]);
    one.get_real(&[3], &mut stiff).unwrap();
    other.get_real(&[3], &mut smooth).unwrap();
    assert!((stiff[0] - 79.0).abs() < 1e-9);
    assert!(0.0 < smooth[0] && smooth[0] < stiff[0]);
}

#[test]
fn another_guid_is_refused() {
    let mut fmu = unpack("JenkinsContact");
    fmu.guid = unpack("ValanisContact").guid;
    assert!(matches!(fmu.slave(), Err(Error::Instantiate)));
}

#[test]
fn statuses_of_failed_calls_come_back() {
    let mut slave = unpack("JenkinsContact").running();
    let status = |result: Result<(), Error>| match result {
        Err(Error::Call { status, .. }) => status,
        other => panic!("{other:?}"),
    };
    assert_eq!(status(slave.do_step(0.0, -1.0)), Status::Error);
    assert_eq!(status(slave.set_real(&[3], &[0.0])), Status::Error);
    assert!(matches!(slave.set_real(&[0], &[]), Err(Error::Lengths { .. })));
}

#[test]
fn the_saved_state_of_another_slave_is_refused() {
    let (mut one, mut other) = (unpack("JenkinsContact").running(), unpack("JenkinsContact").running());
    let state = one.save().unwrap();
    assert!(matches!(other.restore(&state), Err(Error::ForeignState)));
    assert!(matches!(other.serialize(&state), Err(Error::ForeignState)));
    one.restore(&state).unwrap();
    one.free(state).unwrap();
}

#[test]
fn ten_thousand_instances_live_together() {
    let fmu = unpack("JenkinsContact");
    let mut all: Vec<Slave> = (0..10_000).map(|_| fmu.running()).collect();
    for (index, slave) in all.iter_mut().enumerate() {
        slave.set_real(&[0], &[1e-10 * index as f64]).unwrap();
        slave.do_step(0.0, 1e-3).unwrap();
    }
    for (index, slave) in all.iter_mut().enumerate() {
        let mut force = [0.0];
        slave.get_real(&[3], &mut force).unwrap();
        assert_eq!(force[0], 7.9e6 * (1e-10 * index as f64));
    }
}

#[test]
fn bytes_saved_in_one_process_continue_in_another() {
    let fmu = unpack("ValanisContact");
    let run = |slave: &mut Slave, first: i32| -> Vec<u64> {
        let step = |index: i32| {
            let time = f64::from(index) * 1e-3;
            slave.set_real(&[0], &[40e-6 * (800.0 * (time + 1e-3)).sin()]).unwrap();
            slave.do_step(time, 1e-3).unwrap();
            let mut values = [0.0; 2];
            slave.get_real(&[3, 4], &mut values).unwrap();
            values[0].to_bits() ^ values[1].to_bits().rotate_left(1)
        };
        (first..first + 50).map(step).collect()
    };
    let file = std::env::var_os("STICKSLIP_SAVED_STATE").map(PathBuf::from);
    if let Some(file) = file {
        // The other process: continue, and say what came out.
        let mut slave = fmu.slave().unwrap();
        let state = slave.deserialize(&std::fs::read(&file).unwrap()).unwrap();
        slave.restore(&state).unwrap();
        slave.free(state).unwrap();
        std::fs::write(file.with_extension("out"), format!("{:?}", run(&mut slave, 50))).unwrap();
        return;
    }
    let mut slave = fmu.running();
    run(&mut slave, 0);
    let state = slave.save().unwrap();
    let file = fmu.folder.path().join("state.bin");
    std::fs::write(&file, slave.serialize(&state).unwrap()).unwrap();
    slave.free(state).unwrap();
    let expected = format!("{:?}", run(&mut slave, 50));
    let child = Command::new(std::env::current_exe().unwrap())
        .args(["--exact", "library::bytes_saved_in_one_process_continue_in_another"])
        .env("STICKSLIP_SAVED_STATE", &file)
        .output()
        .unwrap();
    assert!(child.status.success(), "{}", String::from_utf8_lossy(&child.stdout));
    assert_eq!(std::fs::read_to_string(file.with_extension("out")).unwrap(), expected);
}
