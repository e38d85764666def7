//! The functions of the FMU library are those of the official headers: a C compiler sees both.

use crate::external::skip;
use crate::tools::{fmi_headers, folder, output_of, program};
use std::path::{Path, PathBuf};
use std::process::Command;

/// Names of the library's types and the official ones.
const TYPES: [(&str, &str); 11] = [
    ("Handle", "fmi2Component"),
    ("StateHandle", "fmi2FMUstate"),
    ("ValueReference", "fmi2ValueReference"),
    ("Real", "fmi2Real"),
    ("Integer", "fmi2Integer"),
    ("Boolean", "fmi2Boolean"),
    ("Byte", "fmi2Byte"),
    ("FmiString", "fmi2String"),
    ("Status", "fmi2Status"),
    ("CallbackFunctions", "fmi2CallbackFunctions"),
    ("EventInfo", "fmi2EventInfo"),
];

/// Those of FMI 3.0.
const TYPES_OF_FMI3: [(&str, &str); 8] = [
    ("Handle", "fmi3Instance"),
    ("StateHandle", "fmi3FMUState"),
    ("ValueReference", "fmi3ValueReference"),
    ("Bool", "fmi3Boolean"),
    ("FmiString", "fmi3String"),
    ("Byte", "fmi3Byte"),
    ("LogMessage", "fmi3LogMessageCallback"),
    ("IntermediateUpdate", "fmi3IntermediateUpdateCallback"),
];

/// All but those that a macro makes, which only say that there is nothing, and one with callbacks that nobody calls.
#[test]
fn functions_of_fmi_3_are_those_of_the_official_headers() {
    let Some(official) = fmi_headers() else { return skip("there are no FMI headers") };
    let Some(compiler) = program(&["cc", "gcc", "clang"]) else { return skip("there is no C compiler") };
    let made = tempfile::tempdir().unwrap();
    let sources = sources(made.path());
    let of_fmi3 = sources.iter().filter(|source| text(source).contains("fn fmi3"));
    let types = TYPES_OF_FMI3.into_iter().chain([("Status", "fmi3Status")]);
    let builder = builder(of_fmi3, &[]).exclude_item("fmi3InstantiateScheduledExecution");
    let functions = declared(builder, types);
    assert_eq!(functions.matches("fmi3Status fmi3").count(), 35, "{functions}");
    let (header, unit) = (made.path().join("fmu_functions3.h"), made.path().join("unit.c"));
    std::fs::write(&unit, "#include <fmi3Functions.h>\n#include \"fmu_functions3.h\"\n").unwrap();
    let compile = |text: &str| {
        std::fs::write(&header, text).unwrap();
        let mut command = Command::new(&compiler);
        command.args(["-std=c11", "-Wall", "-Wextra", "-Werror", "-fsyntax-only", "-isystem"]).arg(&official);
        command.arg("-I").arg(made.path()).arg(&unit);
        command
    };
    output_of(&mut compile(&functions));
    for (from, to) in [
        ("double *values", "float *values"),
        ("fmi3Reset(fmi3Instance handle", "fmi3Reset(fmi3Instance handle, int more"),
    ] {
        let drifted = functions.replacen(from, to, 1);
        assert_ne!(drifted, functions);
        assert!(!compile(&drifted).output().unwrap().status.success(), "{to} was not seen");
    }
}

#[test]
fn functions_of_the_fmu_library_are_those_of_the_official_headers() {
    let Some(official) = fmi_headers() else {
        return skip(
            "there are no FMI 2 headers (`cargo xtask test` fetches them, or set STICKSLIP_FMI_HEADERS)",
        );
    };
    let Some(compiler) = program(&["cc", "gcc", "clang"]) else { return skip("there is no C compiler") };
    let made = tempfile::tempdir().unwrap();
    let sources = sources(made.path());
    let functions = functions(&sources);
    // All but the two that tell the version, and those that give an instance and nothing.
    assert_eq!(functions.matches("fmi2Status fmi2").count(), 40, "{functions}");
    std::fs::write(made.path().join("fmu_functions.h"), &functions).unwrap();
    std::fs::write(made.path().join("fmu_types.h"), types(&sources)).unwrap();
    let compile = || {
        let mut command = Command::new(&compiler);
        command.args(["-std=c11", "-Wall", "-Wextra", "-Werror", "-fsyntax-only", "-isystem"]).arg(&official);
        command.arg("-I").arg(made.path()).arg("-I").arg(folder().join("include"));
        command.arg(folder().join("tests/c/drift.c"));
        command
    };
    output_of(&mut compile());
    // What has drifted is seen: another type, another number of arguments.
    for (from, to) in [
        ("const fmi2Real *", "const fmi2Integer *"),
        ("fmi2Reset(fmi2Component handle", "fmi2Reset(fmi2Component handle, fmi2Real more"),
    ] {
        let drifted = functions.replacen(from, to, 1);
        assert_ne!(drifted, functions);
        std::fs::write(made.path().join("fmu_functions.h"), drifted).unwrap();
        assert!(!compile().output().unwrap().status.success(), "{to} was not seen");
    }
}

/// Declarations of the exported functions, with the official names of their types.
fn functions(sources: &[PathBuf]) -> String {
    let builder = builder(sources.iter().filter(|source| text(source).contains("fn fmi2")), &[]);
    let declared = declared(builder, TYPES);
    // Enumerations come in as plain numbers, which nobody can make invalid; to C they are of another type of the same size.
    let declared =
        declared.replace("int fmu_type", "fmi2Type fmu_type").replace("int kind", "fmi2StatusKind kind");
    declared.replace("int *value", "fmi2Status *value")
}

/// What `builder` declares, with the official names of types.
fn declared<'a>(builder: cbindgen::Builder, types: impl IntoIterator<Item = (&'a str, &'a str)>) -> String {
    let rename =
        |builder: cbindgen::Builder, (ours, official)| builder.rename_item(ours, official).exclude_item(ours);
    written(types.into_iter().fold(builder, rename))
}

/// Types and numbers, each with `fmu_` before its name.
fn types(sources: &[PathBuf]) -> String {
    use cbindgen::ItemType::{Constants, Enums, Structs, Typedefs};
    let mut builder = builder(sources, &[Constants, Enums, Structs, Typedefs]);
    for (ours, _) in TYPES {
        builder = builder.include_item(ours);
    }
    written(builder.with_item_prefix("fmu_"))
}

fn builder<'a>(
    sources: impl IntoIterator<Item = &'a PathBuf>,
    items: &[cbindgen::ItemType],
) -> cbindgen::Builder {
    let mut configuration = cbindgen::Config {
        usize_is_size_t: true,
        documentation: false,
        no_includes: true,
        ..Default::default()
    };
    configuration.enumeration.prefix_with_name = true;
    configuration.export.item_types = items.to_vec();
    configuration.language = cbindgen::Language::C;
    configuration.style = cbindgen::Style::Type;
    let builder = cbindgen::Builder::new().with_config(configuration);
    sources.into_iter().fold(builder, |builder, source| builder.with_src(source))
}

fn written(builder: cbindgen::Builder) -> String {
    let mut declared = Vec::new();
    builder.generate().unwrap().write(&mut declared);
    String::from_utf8(declared).unwrap()
}

/// The sources of the FMU library, without its tests, in `copies`. cbindgen knows no functions with any number of
/// arguments: the logger loses its last three dots, which do not change the pointer to it; nor does that it may be absent.
fn sources(copies: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut folders = vec![folder().join("../fmu/src")];
    while let Some(next) = folders.pop() {
        for entry in std::fs::read_dir(next).unwrap().map(|entry| entry.unwrap().path()) {
            if entry.is_dir() && !entry.ends_with("tests") {
                folders.push(entry);
            } else if entry.extension().is_some_and(|extension| extension == "rs") {
                let copy = copies.join(format!("{}.rs", found.len()));
                std::fs::write(
                    &copy,
                    text(&entry)
                        .replace("    ...\n", "")
                        .replace("Option<Logger>", "Logger")
                        .replace("Option<LogMessage>", "LogMessage")
                        .replace("Option<IntermediateUpdate>", "IntermediateUpdate"),
                )
                .unwrap();
                found.push(copy);
            }
        }
    }
    found
}

fn text(file: &Path) -> String {
    std::fs::read_to_string(file).unwrap()
}
