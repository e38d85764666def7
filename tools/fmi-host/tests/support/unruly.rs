//! An FMU that misbehaves on demand, compiled by the C compiler here.
#![allow(dead_code, reason = "the tests of the program use a part")]

use std::io::{Cursor, Write};
use std::path::PathBuf;
use std::process::Command;
use std::sync::Arc;

use stickslip::cosim::Setup;
use stickslip_fmi_host::{Fmu, FmuSlave, platforms};
use tempfile::TempDir;
use zip::ZipWriter;
use zip::write::SimpleFileOptions;

pub const DESCRIPTION: &str = include_str!("../unruly/modelDescription.xml");

/// What `behaviour` says.
pub const ABORT: f64 = 1.0;
pub const SEGMENTATION: f64 = 2.0;
pub const EXIT: f64 = 3.0;
pub const DISCARD: f64 = 4.0;
pub const FAIL: f64 = 5.0;
pub const FATAL: f64 = 6.0;
pub const FLOOD: f64 = 7.0;
pub const PRINT: f64 = 8.0;
pub const END: f64 = 9.0;
pub const HANG: f64 = 10.0;
pub const EXIT_ZERO: f64 = 11.0;
pub const NO_NUMBER: f64 = 12.0;

/// Its library.
pub fn library() -> Vec<u8> {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("unruly.so");
    let source = folder.path().join("unruly.c");
    std::fs::write(&source, include_str!("../unruly/unruly.c")).unwrap();
    let compiler = std::env::var("CC").unwrap_or_else(|_| "cc".to_owned());
    let done = Command::new(compiler).args(["-shared", "-fPIC", "-O1", "-o"]).arg(&file).arg(source).status();
    assert!(done.expect("a C compiler").success());
    std::fs::read(file).unwrap()
}

/// An archive with these files.
pub fn archive(files: &[(&str, &[u8])]) -> Vec<u8> {
    let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
    for (name, content) in files {
        archive.start_file(*name, SimpleFileOptions::default()).unwrap();
        archive.write_all(content).unwrap();
    }
    archive.finish().unwrap().into_inner()
}

/// The FMU as a file.
pub fn file() -> (TempDir, PathBuf) {
    let binary = format!("binaries/{}/Unruly.so", platforms()[0]);
    let bytes = archive(&[("modelDescription.xml", DESCRIPTION.as_bytes()), (&binary, &library())]);
    written("Unruly.fmu", &bytes)
}

pub fn written(name: &str, bytes: &[u8]) -> (TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join(name);
    std::fs::write(&file, bytes).unwrap();
    (folder, file)
}

/// A component of it, initialized, that will behave like this.
pub fn running(fmu: &Arc<Fmu>, behaviour: f64) -> FmuSlave {
    let mut slave = fmu.instantiate("unruly").unwrap();
    begin(&mut slave, behaviour);
    slave
}

pub fn begin(slave: &mut dyn stickslip::cosim::Slave, behaviour: f64) {
    slave.set(&[2], &[behaviour]).unwrap();
    slave.set_up(Setup { tolerance: None, start: 0.0, stop: Some(1.0) }).unwrap();
    slave.enter_initialization().unwrap();
    slave.exit_initialization().unwrap();
    slave.set(&[0], &[2.0]).unwrap();
}
