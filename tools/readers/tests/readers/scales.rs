//! What a binary file says of its numbers beside them: scales, fill values, steps of time and their units, complex numbers.

use std::path::Path;

use hdf5_pure::AttrValue;
use matrw::{MatFile, MatVariable};
use stickslip_readers::{ImportOptions, Imported, import_table};

const ROWS: usize = 64;

fn wave(phase: f64) -> Vec<f64> {
    (0..ROWS).map(|row| (0.3 * row as f64 + phase).sin()).collect()
}

fn time() -> Vec<f64> {
    (0..ROWS).map(|row| 5e-4 * row as f64).collect()
}

fn import(bytes: Vec<u8>) -> Result<Imported, String> {
    import_table(Path::new("loop.bin"), bytes, &ImportOptions::default()).map_err(|error| error.render(false))
}

fn values(imported: &Imported, name: &str) -> Vec<f64> {
    imported.records[0].channel(name).unwrap_or_else(|| panic!("no {name}")).values.clone()
}

fn noted(imported: &Imported, words: &[&str]) {
    let has = |note: &String| words.iter().all(|word| note.contains(word));
    assert!(imported.notes.iter().any(has), "{words:?} in {:?}", imported.notes);
}

enum Property {
    Words(&'static str),
    Number(f64),
    Count(u32),
}

/// A TDMS file of one segment whose channel of force has these properties.
fn tdms(properties: &[(&str, Property)]) -> Vec<u8> {
    let text = |text: &str| [&(text.len() as u32).to_le_bytes()[..], text.as_bytes()].concat();
    let columns = [("time_s", time()), ("displacement_mm", wave(0.0)), ("force_N", wave(1.0))];
    let mut meta = 3u32.to_le_bytes().to_vec();
    for (name, _) in &columns {
        meta.extend(text(&format!("/'loop'/'{name}'")));
        [20u32, 10, 1].iter().for_each(|number| meta.extend(number.to_le_bytes()));
        meta.extend((ROWS as u64).to_le_bytes());
        let own: &[(&str, Property)] = if *name == "force_N" { properties } else { &[] };
        meta.extend((own.len() as u32).to_le_bytes());
        for (key, value) in own {
            meta.extend(text(key));
            match value {
                Property::Words(words) => meta.extend([&0x20u32.to_le_bytes()[..], &text(words)].concat()),
                Property::Number(number) => {
                    meta.extend([&10u32.to_le_bytes()[..], &number.to_le_bytes()].concat());
                }
                Property::Count(count) => {
                    meta.extend([&7u32.to_le_bytes()[..], &count.to_le_bytes()].concat());
                }
            }
        }
    }
    let raw: Vec<u8> =
        columns.iter().flat_map(|(_, values)| values.iter().flat_map(|value| value.to_le_bytes())).collect();
    let length = ((meta.len() + raw.len()) as u64).to_le_bytes();
    let start = (meta.len() as u64).to_le_bytes();
    let lead = [&b"TDSm"[..], &14u32.to_le_bytes(), &4713u32.to_le_bytes(), &length, &start].concat();
    [lead, meta, raw].concat()
}

fn scaled(kind: &'static str, status: Option<&'static str>) -> Vec<u8> {
    let mut properties = vec![
        ("NI_Number_Of_Scales", Property::Count(1)),
        ("NI_Scale[0]_Scale_Type", Property::Words(kind)),
        ("NI_Scale[0]_Linear_Slope", Property::Number(10.0)),
        ("NI_Scale[0]_Linear_Y_Intercept", Property::Number(5.0)),
        ("NI_Scale[0]_Linear_Input_Source", Property::Count(u32::MAX)),
    ];
    properties.extend(status.map(|status| ("NI_Scaling_Status", Property::Words(status))));
    tdms(&properties)
}

#[test]
fn a_scale_of_tdms_applies_unless_the_channel_is_said_to_be_scaled() {
    let expected: Vec<f64> = wave(1.0).iter().map(|value| 10.0 * value + 5.0).collect();
    for status in [None, Some("unscaled")] {
        let imported = import(scaled("Linear", status)).unwrap();
        assert_eq!(values(&imported, "force"), expected, "{status:?}");
        noted(&imported, &["`force_N`", "10", "5"]);
        let refused = import(scaled("Polynomial", status)).unwrap_err();
        assert!(refused.contains("`force_N` is stored unscaled"), "{refused}");
    }
    let imported = import(scaled("Linear", Some("scaled"))).unwrap();
    assert_eq!(values(&imported, "force"), wave(1.0));
}

/// An HDF5 file whose dataset of force holds `force`, with attributes.
fn hdf5(force: &[f64], attributes: &[(&str, AttrValue)]) -> Vec<u8> {
    let mut builder = hdf5_pure::FileBuilder::new();
    for (name, values, unit) in
        [("time", time(), "s"), ("displacement", wave(0.0), "mm"), ("force", force.to_vec(), "N")]
    {
        let data = builder.create_dataset(name);
        data.with_f64_data(&values);
        data.set_attr("units", AttrValue::String(unit.into()));
        if name == "force" {
            attributes.iter().for_each(|(key, value)| {
                data.set_attr(key, value.clone());
            });
        }
    }
    builder.finish().unwrap()
}

#[test]
fn hdf5_packed_by_factor_and_offset_is_unpacked() {
    let raw: Vec<f64> = wave(1.0).iter().map(|value| (100.0 * value).round()).collect();
    let expected: Vec<f64> = raw.iter().map(|value| value * 0.01 + 5.0).collect();
    let attributes = [("scale_factor", AttrValue::F32Array(vec![0.01])), ("add_offset", AttrValue::I64(5))];
    let imported = import(hdf5(&raw, &attributes)).unwrap();
    for (read, value) in values(&imported, "force").iter().zip(expected) {
        assert!((read - value).abs() < 1e-7, "{read} {value}");
    }
    noted(&imported, &["`force`", "`scale_factor`", "`add_offset`", "5"]);
    let words = [("scale_factor", AttrValue::String("a tenth".into()))];
    let refused = import(hdf5(&raw, &words)).unwrap_err();
    assert!(refused.contains("`force`") && refused.contains("`scale_factor`"), "{refused}");
}

#[test]
fn fill_values_of_hdf5_are_missing_values() {
    let mut force = wave(1.0);
    (force[20], force[21], force[40]) = (-9999.0, -9999.0, 1e20);
    // The fill value is that of the packed numbers.
    let attributes = [
        ("_FillValue", AttrValue::I32(-9999)),
        ("missing_value", AttrValue::F64Array(vec![1e20, 2e20])),
        ("scale_factor", AttrValue::F64(2.0)),
    ];
    let imported = import(hdf5(&force, &attributes)).unwrap();
    noted(&imported, &["`force`", "2 values", "missing"]);
    let all: Vec<f64> =
        imported.records.iter().flat_map(|record| record.channel("force").unwrap().values.clone()).collect();
    assert!(all.len() <= ROWS - 3 && all.iter().all(|value| value.abs() <= 2.0), "{all:?}");
}

#[test]
fn a_rate_in_hdf5_is_in_the_unit_beside_it() {
    let mut builder = hdf5_pure::FileBuilder::new();
    for (name, values) in [("displacement_mm", wave(0.0)), ("force_N", wave(1.0)), ("fs", vec![2.0])] {
        builder.create_dataset(name).with_f64_data(&values);
    }
    let letters: Vec<u16> = "kHz".encode_utf16().collect();
    let unit = builder.create_dataset("Fs_unit");
    unit.with_u16_data(&letters);
    unit.set_attr("MATLAB_class", AttrValue::String("char".into()));
    let imported = import(builder.finish().unwrap()).unwrap();
    assert_eq!(values(&imported, "time"), time());
}

fn mat(members: Vec<(&str, MatVariable)>) -> Vec<u8> {
    let mut run = MatFile::new();
    members.into_iter().for_each(|(name, value)| run.insert(name, value));
    let file = tempfile::NamedTempFile::new().unwrap();
    matrw::save_matfile_v7(file.path().to_str().unwrap(), run, true).unwrap();
    std::fs::read(file.path()).unwrap()
}

/// Displacement and force with steps that are told beside them.
fn stepped(steps: Vec<(&'static str, MatVariable)>) -> Result<Imported, String> {
    let channels = [("displacement_mm", wave(0.0)), ("force_N", wave(1.0))];
    import(mat(channels
        .into_iter()
        .map(|(name, values)| (name, MatVariable::from(values)))
        .chain(steps)
        .collect()))
}

fn number(value: f64) -> MatVariable {
    MatVariable::from(value)
}

fn text(text: &str) -> MatVariable {
    MatVariable::from(text)
}

#[test]
fn a_step_or_rate_of_a_mat_file_is_in_its_unit() {
    for steps in [
        vec![("dt", number(0.5)), ("dt_unit", text("ms"))],
        vec![("fs", number(2.0)), ("Fs_unit", text("kHz"))],
        vec![("fs_kHz", number(2.0))],
        vec![("sample_rate_hz", number(2000.0))],
        vec![("fs", number(2000.0)), ("dt", number(5e-4))],
    ] {
        let what = format!("{steps:?}");
        let imported = stepped(steps).unwrap_or_else(|error| panic!("{what}: {error}"));
        for (read, value) in values(&imported, "time").iter().zip(time()) {
            assert!((read - value).abs() < 1e-12, "{what}: {read} {value}");
        }
    }
    for (steps, words) in [
        (vec![("fs", number(2000.0)), ("dt", number(1e-3))], "`fs` and `dt` contradict each other"),
        (vec![("dt", number(0.5)), ("dt_unit", text("mm"))], "`dt` is in `mm`"),
    ] {
        let refused = stepped(steps).unwrap_err();
        assert!(refused.contains(words) && refused.contains("help: "), "{refused}");
    }
}

#[test]
fn complex_channels_are_named_in_a_note() {
    let complex = MatVariable::NumericArray(
        matrw::NumericArray::new(
            vec![1, ROWS],
            matrw::MatlabType::F64(wave(1.0)),
            Some(matrw::MatlabType::F64(wave(2.0))),
        )
        .unwrap(),
    );
    let imported = stepped(vec![("dt", number(5e-4)), ("response_N", complex)]).unwrap();
    assert_eq!(values(&imported, "force"), wave(1.0));
    noted(&imported, &["complex", "`response_N`"]);
}

#[test]
fn a_file_of_single_numbers_holds_no_record() {
    let s = matrw::matvar!({ a: 1.0, b: 2.0 });
    let refused = import(mat(vec![("run", s)])).unwrap_err();
    assert!(refused.contains("there is no measurement in the file"), "{refused}");
}
