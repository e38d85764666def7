//! Mutated files for every reader: no panic, no half result, an error that says where, and an end soon.
//!
//! `FUZZ_RUNS=10000000 cargo test --release -p stickslip-readers --test readers fuzz -- --nocapture --test-threads 1` reads ten
//! million of each. Files are kept in memory where the system has a folder for it; `TMPDIR=/dev/shm` unpacks archives there, too.

use std::fs;
use std::io::Write as _;
use std::path::Path;

use stickslip::model::Model;
use stickslip_fuzz::{Rng, folder, fuzz, mutate, mutate_text};
use stickslip_readers::archive::{Limits, unpack};
use stickslip_readers::{
    GUARDED, ImportOptions, InputError, import_table, read_dataset, read_plan, read_signals, ssp,
};
use tempfile::TempDir;

use crate::formats;

const BEAM: &str = "schema = \"stickslip.model/1\"\nkind = \"beam\"\n[beam]\nlength = 0.6\nwidth = 0.04\n\
thickness = 0.005\ndensity = 7850\nyoungs_modulus = 2e11\nmodes = 2\ndamping_ratio = [0.003, 0.004]\n\
[excitation]\nposition = 0.5\n[contact]\nlaw = \"valanis\"\ntangential_stiffness = 1e6\n\
friction_coefficient = 0.5\nnormal_load = 100\nsmoothness = 0.3\n[support]\noffset = 0.006\n[fit]\nfree = [\"contact.*\"]\n";
const CONTACT: &str = "schema = \"stickslip.model/1\"\nkind = \"contact\"\n[contact]\nlaw = \"jenkins\"\n\
tangential_stiffness = 2.0e6\nfriction_coefficient = 0.5\nnormal_load = 100.0\n[[effect]]\nid = \"backlash\"\n\
half_gap = 1e-6\n";
const OSCILLATOR: &str = "schema = \"stickslip.model/1\"\nkind = \"oscillator\"\n\
mass = [{ name = \"m1\", mass = 1.0 }, { name = \"m2\", mass = 0.5 }]\n\
spring = [{ between = [\"ground\", \"m1\"], stiffness = 2e5, damping = 5.0 }]\nexcitation = { at = \"m1\" }\n\
[contact]\nat = \"m2\"\nlaw = \"jenkins\"\ntangential_stiffness = 1e5\nfriction_coefficient = 0.5\nnormal_load = 20.0\n";
const DATASET: &str = "schema = \"stickslip.dataset/1\"\ntitle = \"t\"\n[columns]\n\
\"Kraft\" = { name = \"force\", unit = \"kN\", sign = -1 }\n[[record]]\nfile = \"r.csv\"\n\
regime = \"unknown-initial-state\"\nuse = \"fit\"\nnoise = { \"force\" = 0.1 }\n";
const TABLE: &str = "time [s],displacement [mm],Kraft [kN]\n0,1,2\n0.1,-2e-3,3\n0.2,3,4\n0.3,3,5\n";
const PLAN: &str = "schema = \"stickslip.rig/1\"\nmodel = \"model.toml\"\n[sensors]\npositions = [0.5, 0.2]\n\
mass = [0.01, 0.02]\nnoise = 0.02\nseed = 7\n[[random]]\nforce = 0.1\nband = [10, 200]\nduration = 1\nsampling = 1000\n\
[[stepped_sine]]\nname = \"held\"\namplitude = 20\nfrom = 50\nto = 52\ncount = 5\nuse = \"fit\"\n";
const LABORATORY: [&str; 3] = [
    "Zeit (ms);Weg (mm);Kraft (kN)\n0,0;0,0;0,0\n0,5;0,1;0,2\n1,0;0,2;0,3\n1,5;0,1;0,4\n",
    "Operator\tsomebody\n\nTime\tDisplacement\tForce\ns\tmm\tN\n0.0\t1.0\t2\n0.1\t2\t-3e1\n0.2\t3\t4\n",
    "# 2026-11-26\ntime [s],displacement [m],force [N]\n0,1e-6,2\n0.1,2e-6,3\n0.2,-1e-6,4\n",
];
const SYSTEM: &str = r#"<ssd:SystemStructureDescription version="1.0" name="t" xmlns:ssd="http://ssp-standard.org/SSP1/SystemStructureDescription" xmlns:ssc="http://ssp-standard.org/SSP1/SystemStructureCommon">
<ssd:System name="root">
<ssd:Connectors><ssd:Connector name="in" kind="input"><ssc:Real unit="m"/></ssd:Connector></ssd:Connectors>
<ssd:ParameterBindings>
<ssd:ParameterBinding source="p.ssv"><ssd:ParameterMapping source="m.ssm"/></ssd:ParameterBinding>
</ssd:ParameterBindings>
<ssd:Elements>
<ssd:Component name="a" source="a.fmu"><ssd:Connectors>
<ssd:Connector name="x" kind="output"><ssc:Real unit="m"/></ssd:Connector>
<ssd:Connector name="f" kind="input"/>
</ssd:Connectors></ssd:Component>
<ssd:System name="rig"><ssd:Connectors><ssd:Connector name="u" kind="input"/></ssd:Connectors><ssd:Elements>
<ssd:Component name="b" source="b.fmu"><ssd:Connectors><ssd:Connector name="u" kind="input"><ssc:Real unit="mm"/></ssd:Connector></ssd:Connectors></ssd:Component>
</ssd:Elements><ssd:Connections><ssd:Connection startConnector="u" endElement="b" endConnector="u"/></ssd:Connections></ssd:System>
</ssd:Elements>
<ssd:Connections>
<ssd:Connection startElement="a" startConnector="x" endElement="rig" endConnector="u"><ssc:LinearTransformation factor="2" offset="1"/></ssd:Connection>
<ssd:Connection startConnector="in" endElement="a" endConnector="f"/>
</ssd:Connections>
</ssd:System>
<ssd:Units>
<ssc:Unit name="m"><ssc:BaseUnit m="1"/></ssc:Unit>
<ssc:Unit name="mm"><ssc:BaseUnit m="1" factor="0.001"/></ssc:Unit>
</ssd:Units>
<ssd:DefaultExperiment startTime="0" stopTime="0.5"/>
</ssd:SystemStructureDescription>
"#;
const VALUES: &str = r#"<ssv:ParameterSet version="1.0" name="p" xmlns:ssv="http://ssp-standard.org/SSP1/SystemStructureParameterValues" xmlns:ssc="http://ssp-standard.org/SSP1/SystemStructureCommon"><ssv:Parameters>
<ssv:Parameter name="k"><ssv:Real value="1" unit="mm"/></ssv:Parameter>
<ssv:Parameter name="a.n"><ssv:Integer value="2"/></ssv:Parameter>
</ssv:Parameters><ssv:Units>
<ssc:Unit name="mm"><ssc:BaseUnit m="1" factor="0.001"/></ssc:Unit>
</ssv:Units></ssv:ParameterSet>
"#;
const MAPPING: &str = r#"<ssm:ParameterMapping version="1.0" xmlns:ssm="http://ssp-standard.org/SSP1/SystemStructureParameterMapping" xmlns:ssc="http://ssp-standard.org/SSP1/SystemStructureCommon">
<ssm:MappingEntry source="k" target="rig.b.u"><ssc:LinearTransformation factor="10"/></ssm:MappingEntry>
</ssm:ParameterMapping>
"#;

/// Now and then the whole message, which takes longer than reading: it names the file.
fn tellable(error: &InputError, chance: &mut Rng) -> Result<u64, String> {
    if chance.u8(0..16) > 0 {
        return if error.to_string().is_empty() { Err("an empty message".to_owned()) } else { Ok(1) };
    }
    let text = error.render(false);
    if text.starts_with("error: ") && text.contains("--> ") { Ok(1) } else { Err(text) }
}

fn place() -> TempDir {
    TempDir::new_in(folder()).unwrap()
}

/// One of `files` is mutated as a text, and all are written.
fn written(folder: &Path, files: &[(&str, &str)], chance: &mut Rng) {
    let changed = chance.usize(..files.len());
    for (number, (name, text)) in files.iter().enumerate() {
        let text = text.as_bytes().to_vec();
        let text = if number == changed { mutate_text(text, chance) } else { text };
        fs::write(folder.join(name), text).unwrap();
    }
}

fn told<T>(error: InputError) -> T {
    panic!("{}", error.render(false))
}

#[test]
fn the_seeds_are_good() {
    let folder = place();
    let at = |name: &str| folder.path().join(name);
    for (name, text) in [
        ("model.toml", BEAM),
        ("dataset.toml", DATASET),
        ("r.csv", TABLE),
        ("plan.toml", PLAN),
        ("s.ssd", SYSTEM),
        ("p.ssv", VALUES),
        ("m.ssm", MAPPING),
        ("a.fmu", ""),
        ("b.fmu", ""),
    ] {
        fs::write(at(name), text).unwrap();
    }
    read_dataset(folder.path()).unwrap_or_else(told);
    read_plan(at("plan.toml")).unwrap_or_else(told);
    read_signals(at("r.csv")).unwrap_or_else(told);
    assert_eq!(ssp::read(at("s.ssd")).unwrap_or_else(told).parameters.len(), 1);
    for text in [BEAM, CONTACT, OSCILLATOR] {
        Model::parse(text).unwrap();
    }
    for text in LABORATORY {
        import_table("a.txt".as_ref(), text.into(), &ImportOptions::default()).unwrap_or_else(told);
    }
}

#[test]
fn fuzz_models() {
    fuzz("model.toml", |chance| {
        let seed = [BEAM, CONTACT, OSCILLATOR][chance.usize(..3)];
        let bytes = mutate_text(seed.into(), chance);
        let text = String::from_utf8_lossy(&bytes);
        match Model::parse(&text) {
            Ok(model) => model.check().map(|()| 1).map_err(|error| format!("half a model: {error}")),
            Err(error) => match &error.span {
                Some(span) if text.get(span.clone()).is_none() => Err(format!("{span:?} of {text:?}")),
                _ => Ok(1),
            },
        }
    });
}

#[test]
fn fuzz_datasets() {
    let folder = place();
    fuzz("dataset.toml and its CSV", |chance| {
        written(folder.path(), &[("dataset.toml", DATASET), ("r.csv", TABLE)], chance);
        match read_dataset(folder.path()) {
            Err(error) => tellable(&error, chance),
            Ok(dataset) => {
                let sound = dataset.records.iter().all(|record| {
                    let channels = &record.channels;
                    !record.is_empty() && channels.iter().all(|channel| channel.values.len() == record.len())
                });
                if sound { Ok(1) } else { Err("half a dataset".to_owned()) }
            }
        }
    });
}

#[test]
fn fuzz_plans() {
    let folder = place();
    fuzz("plans of tests", |chance| {
        written(folder.path(), &[("plan.toml", PLAN), ("model.toml", BEAM)], chance);
        match read_plan(folder.path().join("plan.toml")) {
            Err(error) => tellable(&error, chance),
            Ok(plan) if plan.plan.tests.is_empty() => Err("a plan without a test".to_owned()),
            Ok(_) => Ok(1),
        }
    });
}

#[test]
fn fuzz_tables() {
    fuzz("tables of laboratories", |chance| {
        let seed = LABORATORY[chance.usize(..LABORATORY.len())];
        imported("a.txt", mutate_text(seed.into(), chance), chance)
    });
}

#[test]
fn fuzz_formats() {
    // Where foreign code panics is caught and told as a sentence: ten million of them need not be printed.
    let other = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |panic| {
        if std::thread::current().name() != Some(GUARDED) {
            other(panic);
        }
    }));
    let seeds = [
        formats::hdf5(),
        formats::mat(),
        formats::tdms(),
        formats::universal(false, false),
        formats::universal(true, true),
    ];
    fuzz("files of other formats", |chance| {
        let bytes = seeds[chance.usize(..seeds.len())].clone();
        imported("a.bin", mutate(bytes, chance), chance)
    });
}

fn imported(name: &str, bytes: Vec<u8>, chance: &mut Rng) -> Result<u64, String> {
    match import_table(name.as_ref(), bytes, &ImportOptions::default()) {
        Err(error) => tellable(&error, chance),
        Ok(imported) => {
            let sound = imported
                .records
                .iter()
                .all(|record| record.channels.iter().all(|channel| channel.values.len() == record.len()));
            if sound { Ok(1) } else { Err("half a record".to_owned()) }
        }
    }
}

#[test]
fn fuzz_signals() {
    let folder = place();
    fuzz("CSV of inputs over time", |chance| {
        written(folder.path(), &[("r.csv", TABLE)], chance);
        match read_signals(folder.path().join("r.csv")) {
            Err(error) => tellable(&error, chance),
            Ok((times, signals)) => {
                let whole = signals.iter().all(|signal| signal.values.len() == times.len());
                if whole && times.is_sorted_by(|a, b| a < b) { Ok(1) } else { Err(format!("{times:?}")) }
            }
        }
    });
}

#[test]
fn fuzz_systems() {
    let folder = place();
    for fmu in ["a.fmu", "b.fmu"] {
        fs::write(folder.path().join(fmu), "").unwrap();
    }
    fuzz("systems of FMUs (.ssd, .ssv, .ssm)", |chance| {
        written(folder.path(), &[("s.ssd", SYSTEM), ("p.ssv", VALUES), ("m.ssm", MAPPING)], chance);
        match ssp::read(folder.path().join("s.ssd")) {
            Err(error) => tellable(&error, chance),
            Ok(system) => {
                let ends =
                    system.connections.iter().flat_map(|connection| [&connection.from, &connection.to]);
                let ends = ends.chain(system.parameters.iter().map(|parameter| &parameter.target));
                let known = ends.into_iter().all(|end| end.component < system.components.len());
                if known { Ok(1) } else { Err("an end of no component".to_owned()) }
            }
        }
    });
}

/// Two files, one packed, one in a folder.
fn archive() -> Vec<u8> {
    let mut writer = zip::ZipWriter::new(std::io::Cursor::new(Vec::new()));
    let method = zip::write::SimpleFileOptions::default().compression_method(zip::CompressionMethod::Stored);
    writer.start_file("modelDescription.xml", method).unwrap();
    writer.write_all(b"<a/>").unwrap();
    let method = method.compression_method(zip::CompressionMethod::Deflated);
    writer.start_file("resources/model.toml", method).unwrap();
    writer.write_all(CONTACT.as_bytes()).unwrap();
    writer.finish().unwrap().into_inner()
}

#[test]
fn fuzz_archives() {
    let (folder, good) = (place(), archive());
    let (path, outside) = (folder.path().join("a.zip"), folder.path().join("outside"));
    fuzz("zip archives", |chance| {
        fs::write(&path, mutate(good.clone(), chance)).unwrap();
        let limits = Limits { bytes: 100_000, entries: 10, expansion: 200 };
        let done = match unpack(&path, limits) {
            Ok(unpacked) if unpacked.path().is_dir() => Ok(1),
            Ok(_) => Err("unpacked to nowhere".to_owned()),
            Err(error) if error.to_string().is_empty() => Err("an empty message".to_owned()),
            Err(_) => Ok(1),
        };
        if outside.exists() { Err("written outside".to_owned()) } else { done }
    });
}
