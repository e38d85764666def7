//! Mutated descriptions of either version of FMI: read whole or refused with a place, never a panic.
//!
//! `FUZZ_RUNS=10000000 cargo test --release -p stickslip-fmi-host --test host fuzz -- --nocapture --test-threads 1` reads ten
//! million of each.

use stickslip_fmi_host::{ImportProblem, ModelDescription};
use stickslip_fuzz::{Rng, folder, fuzz, mutate_text};
use tempfile::TempDir;

const TWO: &str = include_str!("../unruly/modelDescription.xml");
const THREE: &str = r#"<fmiModelDescription fmiVersion="3.0" modelName="Kinds" instantiationToken="token">
<CoSimulation modelIdentifier="Kinds" canGetAndSetFMUState="true" providesIntermediateUpdate="true" maxOutputDerivativeOrder="1"/>
<UnitDefinitions>
<Unit name="N"><BaseUnit kg="1" m="1" s="-2"/><DisplayUnit name="kN" factor="0.001"/></Unit>
</UnitDefinitions>
<TypeDefinitions>
<Float64Type name="Force" unit="N"/>
<EnumerationType name="Mode"><Item name="off" value="1"/><Item name="on" value="4"/></EnumerationType>
</TypeDefinitions>
<DefaultExperiment startTime="0" stopTime="1" stepSize="0.01"/>
<ModelVariables>
<Float64 name="in" valueReference="1" causality="input" declaredType="Force" start="1"/>
<Boolean name="flag" valueReference="11" causality="input" start="false"/>
<Enumeration name="mode" valueReference="12" causality="input" declaredType="Mode" start="1"/>
<Float64 name="list" valueReference="13" causality="input" start="1 2 3"><Dimension valueReference="20"/></Float64>
<String name="text" valueReference="15" causality="parameter" variability="fixed"><Start value="none"/></String>
<UInt64 name="length" valueReference="20" causality="structuralParameter" variability="fixed" start="3"/>
<Float64 name="out" valueReference="101" causality="output" declaredType="Force"><Alias name="same"/></Float64>
<Float64 name="outs" valueReference="113" causality="output"><Dimension start="3"/><Dimension start="2"/></Float64>
</ModelVariables>
<ModelStructure>
<Output valueReference="101" dependencies="1"/>
<Output valueReference="113" dependencies="13 11"/>
</ModelStructure>
</fmiModelDescription>
"#;

/// What is promised of a description that was read.
fn sound(description: &ModelDescription) -> Result<u64, String> {
    let variables = &description.variables;
    let mut names: Vec<&str> = variables.iter().map(|variable| &*variable.name).collect();
    names.sort_unstable();
    if names.windows(2).any(|pair| pair[0] == pair[1]) {
        return Err("a name twice".to_owned());
    }
    let ends = description.dependencies.iter().flat_map(|(of, on)| on.iter().chain([of]));
    if ends.into_iter().any(|position| *position >= variables.len()) {
        return Err("a dependency on no variable".to_owned());
    }
    match variables.iter().find(|variable| variable.passed.element >= variable.passed.size) {
        Some(variable) => Err(format!("{variable:?} is outside of its array")),
        None => Ok(1),
    }
}

fn read(folder: &TempDir, seed: &str, chance: &mut Rng) -> Result<u64, String> {
    let path = folder.path().join("modelDescription.xml");
    std::fs::write(&path, mutate_text(seed.into(), chance)).unwrap();
    match ModelDescription::read(&path) {
        Ok(description) => sound(&description),
        Err(ImportProblem::Description(error)) if chance.u8(0..16) == 0 => {
            let text = error.render(false);
            if text.contains("--> modelDescription.xml") { Ok(1) } else { Err(text) }
        }
        Err(problem) if problem.to_string().is_empty() => Err("an empty message".to_owned()),
        Err(_) => Ok(1),
    }
}

fn place() -> TempDir {
    TempDir::new_in(folder()).unwrap()
}

#[test]
fn fuzz_descriptions_of_fmi_2() {
    let folder = place();
    fuzz("modelDescription.xml of FMI 2.0", |chance| read(&folder, TWO, chance));
}

#[test]
fn fuzz_descriptions_of_fmi_3() {
    let folder = place();
    fuzz("modelDescription.xml of FMI 3.0", |chance| read(&folder, THREE, chance));
}
