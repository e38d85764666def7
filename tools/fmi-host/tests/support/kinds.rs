//! An FMU of FMI 3.0 with variables of every type, compiled by the C compiler here.
#![allow(dead_code, reason = "the tests of the program use a part")]

use std::path::PathBuf;
use std::process::Command;
use std::sync::Arc;

use stickslip::cosim::{Setup, Slave};
use stickslip_fmi_host::{Fmu, FmuSlave, platforms};
use tempfile::TempDir;

use super::unruly::{archive, written};

pub const DESCRIPTION: &str = include_str!("../kinds/modelDescription.xml");

/// Its library.
pub fn library() -> Vec<u8> {
    let folder = tempfile::tempdir().unwrap();
    let (file, source) = (folder.path().join("kinds.so"), folder.path().join("kinds.c"));
    std::fs::write(&source, include_str!("../kinds/kinds.c")).unwrap();
    let compiler = std::env::var("CC").unwrap_or_else(|_| "cc".to_owned());
    let done = Command::new(compiler)
        .args(["-Wall", "-Wextra", "-Werror", "-shared", "-fPIC", "-O1", "-o"])
        .arg(&file)
        .arg(source)
        .status();
    assert!(done.expect("a C compiler").success());
    std::fs::read(file).unwrap()
}

/// The FMU as a file.
pub fn file() -> (TempDir, PathBuf) {
    let platform = platforms().iter().find(|name| name.contains('-')).expect("a platform of FMI 3.0");
    let binary = format!("binaries/{platform}/Kinds.so");
    written("Kinds.fmu", &archive(&[("modelDescription.xml", DESCRIPTION.as_bytes()), (&binary, &library())]))
}

/// A component in its initialization.
pub fn beginning(fmu: &Arc<Fmu>) -> FmuSlave {
    let mut slave = fmu.instantiate("kinds").unwrap();
    slave.set_up(Setup { tolerance: None, start: 0.0, stop: None }).unwrap();
    slave.enter_initialization().unwrap();
    slave
}
