//! Formats that are no text. Files by the tools' own writers are read in `tests/formats` of the project; here are what the
//! libraries' writers make, universal files by hand, and what becomes of any of them when bytes are wrong.

use std::io::Write as _;
use std::path::Path;

use proptest::prelude::*;
use stickslip::data::Regime;
use stickslip_readers::{ColumnRule, ImportOptions, Imported, import_table, read_dataset_told};

const ROWS: usize = 32;

fn displacement() -> Vec<f64> {
    (0..ROWS).map(|row| (0.3 * row as f64).sin()).collect()
}

fn force() -> Vec<f64> {
    (0..ROWS).map(|row| (0.3 * row as f64).cos()).collect()
}

fn time() -> Vec<f64> {
    (0..ROWS).map(|row| 0.5 * row as f64).collect()
}

fn import(bytes: Vec<u8>, options: &ImportOptions) -> Result<Imported, String> {
    import_table(Path::new("loop.bin"), bytes, options).map_err(|error| error.render(false))
}

/// Time in ms, displacement in mm and force in kN come out in SI.
fn holds(imported: &Imported, record: usize, digits: i32) {
    let of = |name: &str| imported.records[record].channel(name).unwrap().values.clone();
    for (name, values, size) in
        [("time", time(), 1e-3), ("displacement", displacement(), 1e-3), ("force", force(), 1e3)]
    {
        let largest = values.iter().fold(0.0_f64, |top, value| top.max(value.abs())) * size;
        let close =
            |(read, value): (f64, f64)| (read - value * size).abs() <= 10.0_f64.powi(-digits) * largest;
        assert!(of(name).into_iter().zip(values).all(close), "{name}: {:?}", of(name));
    }
}

pub fn hdf5() -> Vec<u8> {
    let mut builder = hdf5_pure::FileBuilder::new();
    for (name, values, unit) in
        [("time", time(), "ms"), ("displacement", displacement(), "mm"), ("force", force(), "kN")]
    {
        let data = builder.create_dataset(name);
        data.with_f64_data(&values);
        data.set_attr("units", hdf5_pure::AttrValue::String(unit.into()));
    }
    builder.finish().unwrap()
}

pub fn mat() -> Vec<u8> {
    let mut run = matrw::MatFile::new();
    for (name, values) in [("time_ms", time()), ("displacement_mm", displacement()), ("force_kN", force())] {
        run.insert(name, matrw::MatVariable::from(values));
    }
    let file = tempfile::NamedTempFile::new().unwrap();
    matrw::save_matfile_v7(file.path().to_str().unwrap(), run, true).unwrap();
    std::fs::read(file.path()).unwrap()
}

/// How a TDMS file is laid out.
#[derive(Clone, Copy, Default)]
struct Layout {
    big_endian: bool,
    interleaved: bool,
    /// Rows of a block; 0 for all of them.
    block: usize,
}

/// One segment with three channels of a group, by hand.
fn tdms_as(layout: Layout) -> Vec<u8> {
    let ordered = |little: &[u8]| {
        let mut bytes = little.to_vec();
        bytes.reverse();
        if layout.big_endian { bytes } else { little.to_vec() }
    };
    let text = |text: &str| [&ordered(&(text.len() as u32).to_le_bytes())[..], text.as_bytes()].concat();
    let block = if layout.block == 0 { ROWS } else { layout.block };
    let columns = [("time_ms", time()), ("displacement_mm", displacement()), ("force_kN", force())];
    let mut meta = ordered(&3u32.to_le_bytes());
    for (name, _) in &columns {
        meta.extend(text(&format!("/'loop'/'{name}'")));
        [20u32, 10, 1].iter().for_each(|number| meta.extend(ordered(&number.to_le_bytes())));
        meta.extend(ordered(&(block as u64).to_le_bytes()));
        meta.extend(ordered(&0u32.to_le_bytes()));
    }
    let mut raw = Vec::new();
    for first in (0..ROWS).step_by(block) {
        let places: Vec<(usize, usize)> = if layout.interleaved {
            (first..first + block).flat_map(|row| (0..3).map(move |column| (row, column))).collect()
        } else {
            (0..3).flat_map(|column| (first..first + block).map(move |row| (row, column))).collect()
        };
        places.iter().for_each(|(row, column)| raw.extend(ordered(&columns[*column].1[*row].to_le_bytes())));
    }
    let contents = 14 + (u32::from(layout.interleaved) << 5) + (u32::from(layout.big_endian) << 6);
    let mut bytes = [&b"TDSm"[..], &contents.to_le_bytes(), &ordered(&4713u32.to_le_bytes())].concat();
    bytes.extend(ordered(&((meta.len() + raw.len()) as u64).to_le_bytes()));
    bytes.extend(ordered(&(meta.len() as u64).to_le_bytes()));
    [bytes, meta, raw].concat()
}

pub fn tdms() -> Vec<u8> {
    tdms_as(Layout::default())
}

#[test]
fn tdms_is_read_in_either_order_of_bytes_in_turn_and_in_blocks() {
    for big_endian in [false, true] {
        for interleaved in [false, true] {
            for block in [0, ROWS / 4] {
                let layout = Layout { big_endian, interleaved, block };
                let imported = import(tdms_as(layout), &ImportOptions::default());
                holds(
                    &imported.unwrap_or_else(|error| panic!("{big_endian} {interleaved} {block}: {error}")),
                    0,
                    14,
                );
            }
        }
    }
    // Two segments, of which the second says nothing new of its channels.
    let first = tdms();
    let data = first.len() - 3 * 8 * ROWS;
    let size = (3 * 8 * ROWS as u64).to_le_bytes();
    let lead =
        [&b"TDSm"[..], &8u32.to_le_bytes(), &4713u32.to_le_bytes(), &size, &0u64.to_le_bytes()].concat();
    let twice = [&first[..], &lead, &first[data..]].concat();
    let options = ImportOptions {
        columns: vec![("time_ms".into(), ColumnRule::of("sample [1]"))],
        ..ImportOptions::default()
    };
    let force = import(twice, &options)
        .map(|imported| imported.records[0].channel("force").map(|force| force.values.len()));
    assert!(force.clone().is_err() || force == Ok(Some(2 * ROWS)), "{force:?}");
    // What cannot be is said.
    let cut = &first[..data + 8];
    let mut daqmx = first.clone();
    daqmx[4] |= 1 << 7;
    for (bytes, word) in [(cut.to_vec(), "cut off"), (daqmx, "raw DAQmx data")] {
        let refused = import(bytes, &ImportOptions::default()).unwrap_err();
        assert!(refused.contains(word), "{refused}");
    }
}

/// A function of a universal file; `uneven` writes pairs.
fn function(name: &str, unit: &str, kind: u32, values: &[f64], uneven: bool, binary: bool) -> Vec<u8> {
    let mut out = Vec::new();
    let head = if binary {
        format!("    58b     1     2          11{:12}     0     0           0           0", 8 * values.len())
    } else {
        "    58".to_owned()
    };
    write!(out, "    -1\n{head}\n{name:<80}\nNONE\nNONE\nNONE\nNONE\n").unwrap();
    writeln!(out, "    1         0    0         0       NONE         0   3       NONE         0   0")
        .unwrap();
    let step = if uneven { 0.0 } else { 5e-4 };
    writeln!(
        out,
        "{:10}{:10}{:10}{:13.5e}{step:13.5e}{:13.5e}",
        4,
        values.len(),
        u8::from(!uneven),
        0.0,
        0.0
    )
    .unwrap();
    let line = |kind: u32, unit: &str| format!("{kind:10}    0    0    0 {:<20} {unit:<20}\n", "NONE");
    out.extend([line(17, "s"), line(kind, unit), line(0, "NONE"), line(0, "NONE")].concat().bytes());
    let pairs = values
        .iter()
        .enumerate()
        .flat_map(|(row, value)| if uneven { vec![5e-4 * row as f64, *value] } else { vec![*value] });
    for (index, value) in pairs.enumerate() {
        if binary {
            out.extend(value.to_le_bytes());
        } else {
            write!(out, "{value:20.11e}{}", if index % 4 == 3 { "\n" } else { "" }).unwrap();
        }
    }
    out.extend(b"\n    -1\n");
    out
}

pub fn universal(uneven: bool, binary: bool) -> Vec<u8> {
    let displacement = function("displacement", "mm", 8, &displacement(), uneven, binary);
    let other = b"    -1\n   151\nanything\nat all\n    -1\n".to_vec();
    [displacement, other, function("force", "kN", 13, &force(), uneven, binary)].concat()
}

#[test]
fn every_format_gives_the_same_numbers() {
    for (what, bytes, digits) in [
        ("HDF5", hdf5(), 14),
        ("MAT", mat(), 14),
        ("TDMS", tdms(), 14),
        ("UFF", universal(false, false), 9),
        ("UFF pairs", universal(true, false), 9),
        ("UFF binary", universal(false, true), 14),
        ("UFF binary pairs", universal(true, true), 14),
    ] {
        let imported =
            import(bytes, &ImportOptions::default()).unwrap_or_else(|error| panic!("{what}: {error}"));
        assert_eq!(imported.records.len(), 1, "{what}");
        assert!(
            imported.notes.iter().any(|note| note.starts_with("this is a")),
            "{what}: {:?}",
            imported.notes
        );
        holds(&imported, 0, digits);
    }
}

#[test]
fn a_name_that_comes_again_begins_the_next_record_and_parts_can_be_asked_for() {
    let both = [universal(false, false), universal(false, true)].concat();
    let imported = import(both.clone(), &ImportOptions::default()).unwrap();
    let names: Vec<&str> = imported.records.iter().map(|record| record.name.as_str()).collect();
    assert_eq!(names, ["loop-1.csv", "loop-2.csv"]);
    holds(&imported, 0, 9);
    holds(&imported, 1, 14);
    let part = |part: &str| ImportOptions { part: Some(part.into()), ..ImportOptions::default() };
    assert_eq!(import(both.clone(), &part("2")).unwrap().records.len(), 1);
    assert!(import(both, &part("3")).unwrap_err().contains("`1`, `2`"));
}

#[test]
fn a_dataset_maps_columns_of_any_file() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let rows = |turned: f64| -> String {
        let row = |k: usize| format!("{},{},{}\n", time()[k], displacement()[k], turned * force()[k] / 2.0);
        "ms,AI0,AI1\n".to_owned() + &(0..ROWS).map(row).collect::<String>()
    };
    std::fs::write(at("a.csv"), rows(-1.0)).unwrap();
    std::fs::write(at("b.csv"), rows(1.0)).unwrap();
    std::fs::write(at("c.uff"), universal(false, false)).unwrap();
    let text = "schema = \"stickslip.dataset/1\"\n[columns]\n1 = \"time [ms]\"\nAI0 = \"displacement [mm]\"\n\
                AI1 = { name = \"force\", unit = \"kN\", scale = 2, sign = -1 }\n\
                [[record]]\nfile = \"a.csv\"\nregime = \"steady\"\nnoise = { force = 0.1 }\n\
                [[record]]\nfile = \"b.csv\"\nregime = \"steady\"\ncolumns.AI1 = { name = \"force\", unit = \"kN\", scale = 2 }\n";
    std::fs::write(at("dataset.toml"), text).unwrap();
    let (dataset, notes) = read_dataset_told(folder.path()).unwrap();
    let imported = Imported { records: dataset.records, notes: notes.clone(), factors: Vec::new() };
    holds(&imported, 0, 14);
    holds(&imported, 1, 14);
    assert_eq!(imported.records[0].regime, Regime::Steady);
    // Noise is in the column's unit, before it is scaled: 0.1 kN of what is multiplied by two.
    assert_eq!(imported.records[0].channel("force").unwrap().noise, Some(200.0));
    assert!(
        notes.iter().any(|note| note.starts_with("a.csv: ") && note.contains("multiplied by -2")),
        "{notes:?}"
    );
    // Another format needs no map.
    let text = "schema = \"stickslip.dataset/1\"\n[[record]]\nfile = \"c.uff\"\nregime = \"steady\"\n";
    std::fs::write(at("dataset.toml"), text).unwrap();
    let (dataset, _) = read_dataset_told(folder.path()).unwrap();
    assert_eq!(dataset.records[0].name, "c.uff");
    // What is wrong is said with its line.
    for (rule, sentence) in [
        ("AI7 = \"force [N]\"", "there is no column `AI7`"),
        ("AI0 = { unit = \"mm\" }", "name"),
        ("AI0 = { name = \"force\", unit = \"N\", sign = 2 }", "1 or -1"),
    ] {
        let text = format!(
            "schema = \"stickslip.dataset/1\"\n[columns]\n1 = \"time [ms]\"\n{rule}\n[[record]]\nfile = \"a.csv\"\nregime = \"steady\"\n"
        );
        std::fs::write(at("dataset.toml"), text).unwrap();
        let refused = read_dataset_told(folder.path()).unwrap_err().render(false);
        assert!(refused.contains(sentence), "{refused}");
    }
}

#[test]
fn a_delay_moves_a_channel_to_where_it_belongs() {
    let rows: String = (0..ROWS).map(|row| format!("{},{},{}\n", row, row, row as f64 - 2.5)).collect();
    let late = ColumnRule { delay: 2.5, ..ColumnRule::of("force [N]") };
    let options = ImportOptions { columns: vec![("AI0".into(), late)], ..ImportOptions::default() };
    let imported = import(format!("time [s],displacement [m],AI0\n{rows}").into_bytes(), &options).unwrap();
    let record = &imported.records[0];
    // Without the last rows, whose force was not measured.
    assert_eq!(record.channel("time").unwrap().values.len(), ROWS - 3);
    assert_eq!(record.channel("force").unwrap().values, record.channel("time").unwrap().values);
    assert!(imported.notes.iter().any(|note| note.contains("delay of 2.5 s")), "{:?}", imported.notes);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    /// No panic of the libraries comes through, and no file takes long.
    #[test]
    fn broken_files_are_read_or_refused(which in 0usize..6, flips in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6), keep in 0.2f64..1.2) {
        let mut bytes = match which {
            0 => hdf5(),
            1 => mat(),
            2 => tdms_as(Layout { big_endian: keep > 1.0, interleaved: keep > 0.6, block: ROWS / 4 }),
            3 => universal(false, false),
            4 => universal(false, true),
            _ => universal(true, true),
        };
        for (place, value) in flips {
            let at = place.index(bytes.len());
            bytes[at] = value;
        }
        bytes.truncate((keep * bytes.len() as f64) as usize);
        if let Err(refused) = import(bytes, &ImportOptions::default()) {
            prop_assert!(refused.contains("help: "), "{}", refused);
        }
    }
}
