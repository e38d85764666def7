//! The examples in C and C++: they compile without a warning, and run without a complaint of the sanitizers.

use crate::external::skip;
use crate::tools::{SYSTEM_LIBRARIES, folder, libraries, output_of, program};
use std::process::Command;

const WARNINGS: [&str; 4] = ["-Wall", "-Wextra", "-Werror", "-pedantic"];
const SANITIZERS: [&str; 3] = ["-fsanitize=address,undefined", "-fno-sanitize-recover=all", "-g"];

/// Compiles and runs an example, with each library; what it printed.
fn run(compilers: &[&str], standard: &str, source: &str) -> Option<String> {
    let Some(compiler) = program(compilers) else {
        skip(&format!("there is no compiler ({})", compilers.join(", ")));
        return None;
    };
    let made = tempfile::tempdir().unwrap();
    let model = folder().join("examples/friction.toml");
    let mut printed = Vec::new();
    for linked in ["shared", "static"] {
        let example = made.path().join(linked);
        let mut compile = Command::new(&compiler);
        compile.arg(standard).args(WARNINGS).args(SANITIZERS).arg("-I").arg(folder().join("include"));
        compile.arg("-o").arg(&example).arg(folder().join("examples").join(source));
        if linked == "static" {
            compile.arg(libraries().join("libstickslip_c.a")).args(SYSTEM_LIBRARIES);
        } else {
            // Under the name that the library itself has.
            let found = made.path().join("libstickslip.so.0");
            std::fs::copy(libraries().join("libstickslip_c.so"), &found).unwrap();
            compile.arg(&found).arg("-Wl,-rpath,$ORIGIN").args(["-lm", "-lpthread"]);
        }
        output_of(&mut compile);
        printed.push(output_of(Command::new(&example).arg(&model)));
    }
    assert_eq!(printed[0], printed[1], "the two libraries do not agree");
    printed.pop()
}

/// The example itself ends with an error where the order of convergence is below 1.7 or a step takes more than ten
/// iterations; here is what it told.
#[test]
fn newtons_method_on_finite_elements_converges_quadratically_by_the_tangent() {
    let Some(printed) = run(&["cc", "gcc", "clang"], "-std=c11", "newton.c") else { return };
    let orders = printed.lines().filter_map(|line| line.split_once("order ")?.1.parse::<f64>().ok());
    let lowest = orders.clone().fold(f64::INFINITY, f64::min);
    assert!(orders.count() >= 8 && lowest > 1.7, "{printed}");
}

#[test]
fn contacts_in_threads_of_a_program_in_cpp_agree_with_one_that_goes_on_alone() {
    let Some(printed) = run(&["c++", "g++", "clang++"], "-std=c++17", "threads.cpp") else { return };
    assert!(printed.contains("8 threads"), "{printed}");
}
