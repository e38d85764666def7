//! A crash of an FMU leaves the simulation with an error and what there was so far.
#![cfg(target_os = "linux")]

use std::path::Path;
use std::process::Command;
use std::sync::Arc;

use stickslip::cosim::{Severity, Slave, SlaveError, Stepped};
use stickslip_fmi_host::{Fmu, IsolatedSlave, Status, serve};

use crate::unruly;

/// Not a test: the other process, when the tests start themselves.
#[test]
fn the_other_process() {
    if let (Some(folder), Some(name)) =
        (std::env::var_os("STICKSLIP_SERVE_FOLDER"), std::env::var("STICKSLIP_SERVE_NAME").ok())
    {
        serve(Path::new(&folder), "Unruly.fmu", &name).unwrap();
    }
}

fn isolated(fmu: &Arc<Fmu>) -> IsolatedSlave {
    let mut command = Command::new(std::env::current_exe().unwrap());
    command.args(["--exact", "isolation::the_other_process"]);
    command.env("STICKSLIP_SERVE_FOLDER", fmu.folder()).env("STICKSLIP_SERVE_NAME", "unruly");
    fmu.isolated("unruly", command, || false).unwrap()
}

/// Steps of 0.1 s until something happens; the outputs so far.
fn steps(slave: &mut dyn Slave) -> (Vec<f64>, Option<SlaveError>) {
    let mut outputs = Vec::new();
    for step in 0..10 {
        match slave.do_step(f64::from(step) * 0.1, 0.1) {
            Ok(Stepped::Done) => {}
            Ok(Stepped::Discarded(time)) => panic!("discarded at {time}"),
            Err(error) => return (outputs, Some(error)),
        }
        let mut y = [0.0];
        slave.get(&[1], &mut y).unwrap();
        outputs.push(y[0]);
    }
    (outputs, None)
}

#[test]
fn a_crash_is_an_error_that_names_the_fmu_and_results_so_far_stay() {
    let (_folder, file) = unruly::file();
    let fmu = Fmu::open(&file).unwrap();
    let cases = [
        (unruly::ABORT, "SIGABRT"),
        (unruly::SEGMENTATION, "SIGSEGV"),
        (unruly::EXIT, "exit status: 7"),
        (unruly::EXIT_ZERO, "exit status: 0"),
    ];
    for (behaviour, how) in cases {
        let mut slave = isolated(&fmu);
        unruly::begin(&mut slave, behaviour);
        let (outputs, error) = steps(&mut slave);
        assert_eq!(outputs.len(), 4);
        assert!((outputs[3] - 0.8).abs() < 1e-12);
        let error = error.expect("a crash");
        assert_eq!((error.severity, error.slave.as_str()), (Severity::Fatal, "unruly"));
        for word in [how, "Unruly.fmu", "from 0.4 s"] {
            assert!(error.message.contains(word), "{word}: {}", error.message);
        }
        if behaviour == unruly::ABORT {
            assert!(error.message.contains("the end is near"), "{}", error.message);
        }
        // It stays an error, and nothing waits.
        assert_eq!(slave.get(&[1], &mut [0.0]).unwrap_err().severity, Severity::Fatal);
        assert_eq!(slave.terminate().unwrap_err().severity, Severity::Fatal);
    }
}

#[test]
fn a_crash_leaves_other_slaves_alone() {
    let (_folder, file) = unruly::file();
    let fmu = Fmu::open(&file).unwrap();
    let (mut one, mut other) = (isolated(&fmu), isolated(&fmu));
    unruly::begin(&mut one, unruly::ABORT);
    unruly::begin(&mut other, 0.0);
    assert!(steps(&mut one).1.is_some());
    let (outputs, error) = steps(&mut other);
    assert!(error.is_none() && outputs.len() == 10);
}

#[test]
fn a_slave_in_its_own_process_gives_the_same_bits() {
    let (_folder, file) = unruly::file();
    let fmu = Fmu::open(&file).unwrap();
    let mut here = unruly::running(&fmu, unruly::PRINT);
    let mut there = isolated(&fmu);
    unruly::begin(&mut there, unruly::PRINT);
    assert_eq!(here.variables(), there.variables());
    let (outputs, error) = steps(&mut there);
    assert!(error.is_none(), "{error:?}");
    assert_eq!(outputs, steps(&mut here).0);
    for slave in [&mut here as &mut dyn Slave, &mut there] {
        slave.set(&[3, 0], &[1.0, 4.0]).unwrap();
        let mut values = [0.0; 3];
        slave.get(&[2, 3, 0], &mut values).unwrap();
        assert_eq!(values, [unruly::PRINT, 1.0, 4.0]);
    }
    there.set_text("note", "über").unwrap();
}

#[test]
fn statuses_and_messages_come_through() {
    let (_folder, file) = unruly::file();
    let fmu = Fmu::open(&file).unwrap();
    let mut slave = isolated(&fmu);
    unruly::begin(&mut slave, unruly::FAIL);
    let error = slave.set(&[0], &[2e6]).unwrap_err();
    assert_eq!(error.severity, Severity::Call);
    assert!(error.message.contains("u = 2e+06 is more than 1000000"), "{}", error.message);
    let error = steps(&mut slave).1.unwrap();
    assert_eq!(error.severity, Severity::Slave);
    for words in ["unruly gave up at 0.40 s", "(Unruly.fmu)"] {
        assert!(error.message.contains(words), "{words}: {}", error.message);
    }
    assert!(slave.log().messages().iter().any(|message| message.status == Status::Error));
}

#[test]
fn the_other_process_ends_with_its_slave() {
    let (_folder, file) = unruly::file();
    let fmu = Fmu::open(&file).unwrap();
    let slave = isolated(&fmu);
    let process = format!("/proc/{}", slave.process_id());
    assert!(Path::new(&process).exists());
    drop(slave);
    assert!(!Path::new(&process).exists());
}
