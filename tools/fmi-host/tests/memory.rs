//! Memory stays flat. Alone in its process: other tests would be measured too.
#![cfg(target_os = "linux")]

use stickslip_fmi_host::Slave;

mod support;
use support::{initialize, unpack};

/// Memory of this process that is in use (kB).
fn resident() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap();
    let line = status.lines().find(|line| line.starts_with("VmRSS:")).unwrap();
    line.split_whitespace().nth(1).unwrap().parse().unwrap()
}

#[test]
fn resets_saves_and_instances_leave_no_memory_behind() {
    let fmu = unpack("JenkinsContact");
    let mut slave = fmu.running();
    let work = |slave: &mut Slave, rounds: u32| {
        for round in 0..rounds {
            slave.do_step(0.0, 1e-3).unwrap();
            let state = slave.save().unwrap();
            slave.restore(&state).unwrap();
            slave.free(state).unwrap();
            slave.reset().unwrap();
            initialize(slave);
            if round % 100 == 0 {
                drop(fmu.running());
            }
        }
    };
    work(&mut slave, 1_000);
    let before = resident();
    work(&mut slave, 100_000);
    let grown = resident().saturating_sub(before);
    assert!(grown < 2_000, "{grown} kB more after 100 000 resets");
}
