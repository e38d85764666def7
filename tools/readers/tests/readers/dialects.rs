//! Tables as laboratories export them: the same numbers, whatever the dialect, or a sentence that says what to do.

use std::path::Path;

use stickslip::data::Regime;
use stickslip_readers::{ColumnRule, ImportOptions, Imported, import_table};

/// Time (ms), displacement (mm) and force (kN), as written in every file.
fn rows() -> Vec<[f64; 3]> {
    (0..40)
        .map(|row| {
            let phase = 0.3 * f64::from(row);
            [0.5 * f64::from(row), (1e4 * phase.sin()).round() / 1e4, (1e5 * phase.cos()).round() / 1e8]
        })
        .collect()
}

fn body(separator: &str, decimal: &str, end: &str, quoted: bool) -> String {
    let field = |value: &f64| {
        let text = value.to_string().replace('.', decimal);
        if quoted { format!("\"{text}\"") } else { text }
    };
    let line = |row: [f64; 3]| row.iter().map(field).collect::<Vec<_>>().join(separator) + end;
    rows().into_iter().map(line).collect()
}

fn import(bytes: impl Into<Vec<u8>>) -> Result<Imported, String> {
    import_with(bytes, &ImportOptions::default())
}

fn import_with(bytes: impl Into<Vec<u8>>, options: &ImportOptions) -> Result<Imported, String> {
    import_table(Path::new("loop.txt"), bytes.into(), options).map_err(|error| error.render(false))
}

/// Asserts that the records together hold the rows, in SI, without those that are missing.
fn holds_the_rows(imported: &Imported, missing: &[usize], what: &str) {
    let sizes = [("time", 1e-3), ("displacement", 1e-3), ("force", 1e3)];
    for (column, (name, size)) in sizes.into_iter().enumerate() {
        let read: Vec<f64> = imported
            .records
            .iter()
            .flat_map(|record| record.channel(name).expect(what).values.clone())
            .collect();
        let written = rows().into_iter().enumerate().filter(|(row, _)| !missing.contains(row));
        let written: Vec<f64> = written.map(|(_, row)| row[column] * size).collect();
        assert_eq!(read.len(), written.len(), "{what}: {name}");
        let close = |(read, written): (&f64, &f64)| (read - written).abs() <= 1e-15 * written.abs();
        assert!(read.iter().zip(&written).all(close), "{what}: {name}");
    }
}

const HEADINGS: [[&str; 3]; 7] = [
    ["time [ms]", "displacement [mm]", "force [kN]"],
    ["Time (ms)", "Displacement (mm)", "Force (kN)"],
    ["time_ms", "disp_mm", "force_kN"],
    ["Zeit / ms", "Weg / mm", "Kraft / kN"],
    ["t in ms", "x in mm", "F in kN"],
    ["Time ms", "Slip mm", "Load Cell kN"],
    ["TIME (msec)", "DISP (millimeter)", "FORCE (kilonewton)"],
];

fn encoded(text: &str, encoding: usize) -> Vec<u8> {
    let wide = |bytes: fn(u16) -> [u8; 2]| text.encode_utf16().flat_map(bytes).collect::<Vec<u8>>();
    match encoding {
        0 => text.as_bytes().to_vec(),
        1 => [b"\xef\xbb\xbf", text.as_bytes()].concat(),
        2 => [b"\xff\xfe".to_vec(), wide(u16::to_le_bytes)].concat(),
        3 => [b"\xfe\xff".to_vec(), wide(u16::to_be_bytes)].concat(),
        _ => wide(u16::to_le_bytes),
    }
}

#[test]
fn every_dialect_gives_the_same_numbers() {
    let dialects = [
        (",", ".", false),
        (";", ".", false),
        (";", ",", false),
        ("\t", ".", false),
        ("\t", ",", false),
        (",", ",", true),
    ];
    let mut files = 0;
    for (separator, decimal, quoted) in dialects {
        for heading in HEADINGS {
            for (encoding, end) in [(0, "\n"), (1, "\r\n"), (2, "\r\n"), (3, "\n"), (4, "\r")] {
                let text = heading.join(separator) + end + &body(separator, decimal, end, quoted);
                let what = format!("{heading:?} {separator:?} {decimal:?} {encoding} {end:?}");
                let imported =
                    import(encoded(&text, encoding)).unwrap_or_else(|error| panic!("{what}: {error}"));
                holds_the_rows(&imported, &[], &what);
                assert_eq!(imported.records[0].regime, Regime::UnknownInitialState);
                files += 1;
            }
        }
    }
    assert_eq!(files, 210);
}

#[test]
fn preambles_rows_of_units_comments_and_blanks_are_passed_over_and_told() {
    let comma = body(",", ".", "\n", false);
    let semicolon = body(";", ",", "\r\n", false);
    let files = [
        format!("Test rig 3\nOperator,Meier\nRate,2000\n\ntime [ms],displacement [mm],force [kN]\n{comma}"),
        format!("time,displacement,force\nms,mm,kN\n{comma}"),
        format!("Zeit;Weg;Kraft\r\n[ms];[mm];[kN]\r\n{semicolon}"),
        format!("Datum:;12.03.2026\r\nPrüfer:;Müller\r\nZeit (ms);Weg (mm);Kraft (kN);\r\n{semicolon}"),
        format!("# time [ms],displacement [mm],force [kN]\n{comma}"),
        format!("% time [ms],displacement [mm],force [kN]\n{comma}"),
        format!("time [ms] displacement [mm] force [kN]\n{}", body("   ", ".", "\n", false)),
        format!("Time Disp Force\n(ms) (mm) (kN)\n{}", body(" ", ".", "\n", false)),
        format!("time [ms],displacement [mm],force [kN]\n{comma}End of data\n"),
        format!("time [ms],displacement [mm],force [kN]\n\n{}", body(",", ".", ",\n", false)),
    ];
    for file in files {
        let imported = import(file.clone()).unwrap_or_else(|error| panic!("{file}\n{error}"));
        holds_the_rows(&imported, &[], &file);
    }
}

#[test]
fn windows_text_is_read_and_told() {
    let text = format!("Prüfung\nZeit (ms);Weg (mm);Kraft (kN)\n{}", body(";", ",", "\n", false));
    let bytes: Vec<u8> = text.chars().map(|letter| u8::try_from(u32::from(letter)).unwrap()).collect();
    let imported = import(bytes).unwrap();
    holds_the_rows(&imported, &[], "windows-1252");
    assert!(imported.notes.iter().any(|note| note.contains("windows-1252")), "{:?}", imported.notes);
}

#[test]
fn further_columns_are_told_and_not_used() {
    let rows = body(",", ".", ",21.5,ok\n", false);
    let imported =
        import(format!("time [ms],displacement [mm],force [kN],Temp (°C),Comment\n{rows}")).unwrap();
    holds_the_rows(&imported, &[], "further columns");
    assert!(imported.notes.contains(&"not used: `Temp (°C)`, `Comment`".to_owned()), "{:?}", imported.notes);
}

#[test]
fn a_record_is_cut_where_values_are_missing_and_nothing_is_filled_in() {
    for gap in ["", "NaN", "nan", "#N/A", "inf", "OVERLOAD"] {
        let mut lines: Vec<String> = body(",", ".", "\n", false).lines().map(str::to_owned).collect();
        for line in &mut lines[18..20] {
            *line = format!("{},{gap}", line.rsplit_once(',').unwrap().0);
        }
        let text = format!("time [ms],displacement [mm],force [kN]\n{}", lines.join("\n"));
        let imported = import(text).unwrap();
        holds_the_rows(&imported, &[18, 19], gap);
        assert_eq!(imported.records.len(), 2);
        assert!(
            imported.notes.iter().any(|note| note.starts_with("2 rows lack a value")),
            "{:?}",
            imported.notes
        );
    }
}

#[test]
fn several_records_in_one_file_are_several_records() {
    let rows = body(",", ".", "\n", false);
    let imported = import(format!("time [ms],displacement [mm],force [kN]\n{rows}{rows}")).unwrap();
    let names: Vec<&str> = imported.records.iter().map(|record| record.name.as_str()).collect();
    assert_eq!(names, ["loop-1.csv", "loop-2.csv"]);
    assert!(imported.records[0].channels == imported.records[1].channels);
}

#[test]
fn columns_are_what_the_user_says() {
    let columns = [("AI0", "time [ms]"), ("AI1", "displacement [mm]"), ("3", "force [kN]")];
    let columns = columns.map(|(heading, name)| (heading.to_owned(), ColumnRule::of(name))).to_vec();
    let options = ImportOptions { columns, ..ImportOptions::default() };
    let imported = import_with(format!("AI0,AI1,AI2\n{}", body(",", ".", "\n", false)), &options).unwrap();
    holds_the_rows(&imported, &[], "columns by the user");
    assert!(imported.notes.contains(&"`AI2` was read as force [kN]".to_owned()), "{:?}", imported.notes);
}

#[test]
fn times_of_day_and_tables_over_frequency_are_understood() {
    let text = "Time;Weg (mm);Kraft (N)\n23:59:59,5;0,1;1\n2026-03-13 00:00:00,5;0,2;2\n";
    let record = &import(text).unwrap().records[0];
    assert_eq!(record.channel("time").unwrap().values, [0.0, 1.0]);
    let text = "Frequency (Hz),Excitation (N),acceleration:x=0.55 (g)\n50,1,1\n51,1,2\n";
    assert_eq!(import(text).unwrap().records[0].regime, Regime::SteppedSine);
    let text = "time [s],acceleration:x=0.55 [g],Force (N)\n0,1,1\n1,2,2\n";
    let imported = import(text).unwrap();
    assert!(imported.records[0].channel("excitation").is_some());
    assert!(imported.notes.iter().any(|note| note.contains("structure")));
}

#[test]
fn what_cannot_be_read_gets_a_sentence_that_says_what_to_do() {
    let heading = "time [ms],displacement [mm],force [kN]\n";
    let files: [(Vec<u8>, &str); 14] = [
        (b"".to_vec(), "export the measurement again"),
        (b"MATLAB 5.0 MAT-file, Platform".to_vec(), "-v7"),
        (b"\x89HDF\r\n\x1a\n".to_vec(), "one dataset per channel"),
        (b"PAR1\x15\x04".to_vec(), "to_parquet"),
        (b"TDSm\x0e\0\0\0".to_vec(), "nptdms"),
        (b"PK\x03\x04\x14\0".to_vec(), "save the sheet as CSV"),
        (b"    -1\n    58\nx".to_vec(), "pyuff"),
        (vec![1, 0, 3, 7, 0, 0, 2, 9], "export the measurement as CSV"),
        (b"some words only\n".to_vec(), "export a table with one column per channel"),
        (body(",", ".", "\n", false).into_bytes(), "write a first line"),
        (format!("{heading}{}", body(",", ",", "\n", false)).into_bytes(), "separate columns by semicolons"),
        (b"time,displacement,force\n0,0,0\n1,1,1\n".to_vec(), "write it in the heading, `time [s]`"),
        (format!("{heading}0,0,0\n1,0,0\n1,0,0\n").into_bytes(), "more digits"),
        (b"displacement [mm],force [kN]\n0,0\n1,1\n".to_vec(), "time [s]"),
    ];
    for (bytes, sentence) in files {
        let shown = import(bytes.clone()).expect_err(sentence);
        let words = shown.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(words.contains(sentence), "{:?}: {shown}", String::from_utf8_lossy(&bytes));
    }
}

/// The file that no other program writes so: a sentence holds the words, whatever else it says.
fn is_refused(text: &str, words: &str) {
    let said = import(text).expect_err(text);
    assert!(said.contains(words), "{text}: {said}");
}

#[test]
fn a_second_heading_is_passed_over_where_it_is_the_first_again_and_refused_otherwise() {
    let head = "time [s],displacement [mm],force [N]\n";
    let rows = "0,1,2\n1,2,3\n2,3,4\n";
    let later = "3,5,6\n4,6,7\n";
    let again = import(format!("{head}{rows}{head}{later}")).unwrap();
    assert_eq!(again.records[0].len(), 5);
    is_refused(
        &format!("{head}{rows}time [s],force [N],displacement [mm]\n{later}"),
        "line 5 names the columns anew",
    );
    is_refused(&format!("{head}{rows}time [s],displacement [um],force [kN]\n{later}"), "`displacement [um]`");
}

#[test]
fn numbers_with_signs_between_thousands_are_refused_and_none_is_lost() {
    for (rows, word) in [
        ("t [s];x [nm];F [mN]\n0,1;1.058,50;2,00\n0,2;20,50;1.702,29\n0,3;3,25;3,00\n", "1.058,50"),
        ("t [s],x [nm],F [mN]\n0.1,\"1,058.50\",2.0\n0.2,20.5,\"1,702.29\"\n0.3,3.25,3.0\n", "1,058.50"),
        ("t [s];x [nm];F [mN]\n0.1;1'058.5;2.0\n0.2;20.5;1'702.3\n0.3;3.25;3.0\n", "1'058.5"),
        ("t [s];x [nm];F [mN]\n0,1;1\u{a0}058,5;2,0\n0,2;20,5;1\u{a0}702,3\n0,3;3,25;3,0\n", "058,5"),
    ] {
        is_refused(rows, "signs between thousands");
        is_refused(rows, word);
    }
    // Three decimals behind a comma are no thousands.
    let plain =
        import("t [s];x [mm];F [N]\n0,100;1,058;2,000\n0,200;20,500;1,702\n0,300;3,250;3,000\n").unwrap();
    assert_eq!(plain.records[0].channel("force").unwrap().values, [2.0, 1.702, 3.0]);
}

#[test]
fn labview_and_catman_name_their_columns_in_the_line_that_does() {
    let rows = "0.0\t0.1\t2.0\t\n0.1\t0.2\t3.0\t\n0.2\t0.3\t4.0\t\n";
    let labview = format!(
        "LabVIEW Measurement\t\nWriter_Version\t2\n***End_of_Header***\t\n\t\t\t\nSamples\t3\t3\t\nDate\t2024/03/12\t2024/03/12\n\
         Time\t10:00:00.0\t10:00:00.0\nY_Unit_Label\tmm\tN\nX0\t0.0\t0.0\nDelta_X\t0.1\t0.1\n***End_of_Header***\t\t\n\
         X_Value\tDisplacement\tForce\tComment\n{rows}"
    );
    let options = ImportOptions {
        columns: vec![("X_Value".into(), ColumnRule::of("time [s]"))],
        ..ImportOptions::default()
    };
    let said = import(labview.clone()).unwrap_err();
    assert!(said.contains("`X_Value [s]`"), "{said}");
    let imported = import_with(labview, &options).unwrap();
    assert_eq!(imported.records[0].channel("displacement").unwrap().values, [0.1e-3, 0.2e-3, 0.3e-3]);
    assert_eq!(imported.records[0].channel("force").unwrap().values, [2.0, 3.0, 4.0]);
    let catman = "Datei:\tT0\n\nZeit\tWeg\tKraft\nRate: 2000 Hz\tRate: 2000 Hz\tRate: 2000 Hz\ns\tmm\tkN\n\
                  0,0\t0,1\t2,0\n0,1\t0,2\t3,0\n0,2\t0,3\t4,0\n";
    let imported = import(catman).unwrap();
    assert_eq!(imported.records[0].channel("force").unwrap().values, [2000.0, 3000.0, 4000.0]);
}

#[test]
fn time_stamps_are_made_of_a_sample_rate_that_is_told() {
    let text = "# Sample rate: 2000 Hz\ndisplacement [mm],force [N]\n1,2\n2,3\n3,4\n";
    is_refused(text, "no column of time");
    let options = ImportOptions { sample_rate: Some(2000.0), ..ImportOptions::default() };
    let imported = import_with(text, &options).unwrap();
    assert_eq!(imported.records[0].channel("time").unwrap().values, [0.0, 0.0005, 0.001]);
    let twice = import_with("time [s],displacement [mm]\n0,1\n1,2\n", &options).unwrap_err();
    assert!(twice.contains("has time stamps"), "{twice}");
}

#[test]
fn what_would_be_read_wrongly_without_a_word_is_refused() {
    is_refused(
        "time [s],displacement (um),force [N]\ns,mm,N\n0,1,2\n1,2,3\n2,3,4\n",
        "in `um` by its name and in `mm`",
    );
    is_refused("time [s],force [N]\n0,1\n1,2\n2,3\n", "no motion is known");
    is_refused("time [s],displacement [mm]\n3,1\n2,2\n1,3\n", "time does not increase");
    is_refused("time [Ms],displacement [mm]\n1,1\n2,2\n3,3\n", "`Ms` is not a unit");
    let twice =
        ["displacement [mm]", "-displacement [mm]"].map(|name| ("2".to_owned(), ColumnRule::of(name)));
    let options = ImportOptions { columns: twice.into(), ..ImportOptions::default() };
    let said = import_with("time [s],x [mm]\n0,1\n1,2\n", &options).unwrap_err();
    assert!(said.contains("described twice"), "{said}");
}

#[test]
fn the_german_degree_is_no_thousand_million_radians() {
    let text =
        "Frequenz [Hz];excitation [N];acceleration [m/s^2];phase [Grad]\n1;1;1;90\n2;1;1;180\n3;1;1;-90\n";
    let imported = import(text).unwrap();
    let phase = &imported.records[0].channel("phase").unwrap().values;
    assert!((phase[1] - std::f64::consts::PI).abs() < 1e-12, "{phase:?}");
}

#[test]
fn rounded_time_stamps_are_even_and_a_lost_sample_stays_lost() {
    let file = |lost: Option<usize>| {
        let row = |index: usize| format!("{:.4},{}\n", index as f64 / 2048.0, index % 7);
        let rows: String = (0..400).filter(|index| lost != Some(*index)).map(row).collect();
        import(format!("time [s],displacement [mm]\n{rows}")).unwrap()
    };
    let even = file(None);
    let step = even.records[0].sample_step().unwrap();
    assert!((step * 2048.0 - 1.0).abs() < 1e-3, "{step}");
    assert!(even.notes.iter().any(|note| note.contains("rounded")), "{:?}", even.notes);
    let lost = file(Some(200));
    assert_eq!(lost.records[0].sample_step(), None);
    assert!(!lost.notes.iter().any(|note| note.contains("rounded")));
}
