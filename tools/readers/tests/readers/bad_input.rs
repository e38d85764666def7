//! Every bad input gives one message that names the file and the line, and no result.

use std::fs;
use std::path::Path;

use stickslip_readers::{InputError, Problem, check_columns, read_dataset, read_model};
use tempfile::TempDir;

const DATASET: &str =
    "schema = \"stickslip.dataset/1\"\n\n[[record]]\nfile = \"r.csv\"\nregime = \"steady\"\n";
const TABLE: &str = "time [s],displacement [mm],force [N]\n0,0,0\n0.1,1,2\n0.2,2,3\n";

fn folder(dataset: &[u8], table: &[u8]) -> TempDir {
    let folder = TempDir::new().unwrap();
    fs::write(folder.path().join("dataset.toml"), dataset).unwrap();
    fs::write(folder.path().join("r.csv"), table).unwrap();
    folder
}

fn dataset_error(dataset: &[u8], table: &[u8]) -> InputError {
    read_dataset(folder(dataset, table).path()).expect_err("bad input")
}

/// Asserts file, line and words of the error, and that its rendering has all of them, once.
#[track_caller]
fn says(error: &InputError, file: &str, line: usize, words: &[&str]) {
    let text = error.render(false);
    assert_eq!(error.path.file_name().unwrap(), file, "{text}");
    assert_eq!(error.line(), Some(line), "{text}");
    assert!(text.starts_with("error: "), "{text}");
    assert_eq!(text.matches("error: ").count(), 1, "{text}");
    assert!(text.contains(&format!("--> {}:{line}", error.path.display())), "{text}");
    for word in words {
        assert!(text.contains(word), "`{word}` is missing from\n{text}");
    }
}

#[track_caller]
fn table_says(table: &str, line: usize, words: &[&str]) {
    says(&dataset_error(DATASET.as_bytes(), table.as_bytes()), "r.csv", line, words);
    let windows = table.replace('\n', "\r\n");
    says(&dataset_error(DATASET.as_bytes(), windows.as_bytes()), "r.csv", line, words);
}

#[track_caller]
fn dataset_says(dataset: &str, line: usize, words: &[&str]) {
    says(&dataset_error(dataset.as_bytes(), TABLE.as_bytes()), "dataset.toml", line, words);
}

#[test]
fn good_input_is_read_in_si_whatever_its_line_ends_and_byte_order_mark() {
    let variants = [
        TABLE.to_owned(),
        TABLE.replace('\n', "\r\n"),
        format!("\u{feff}{TABLE}"),
        TABLE.replace(',', " , "),
        TABLE.replace('\n', "\n\n"),
        TABLE.trim_end().to_owned(),
        TABLE.replace("time [s]", "\"time [s]\""),
    ];
    let noise = format!("{DATASET}noise = {{ \"displacement\" = 0.5 }}\nuse = \"fit\"\n");
    for table in variants {
        let folder = folder(noise.replace('\n', "\r\n").as_bytes(), table.as_bytes());
        let dataset = read_dataset(folder.path()).unwrap_or_else(|error| panic!("{}", error.render(false)));
        let record = &dataset.records[0];
        assert_eq!((record.name.as_str(), record.len()), ("r.csv", 3));
        let displacement = record.channel("displacement").unwrap();
        assert_eq!((displacement.unit, displacement.values.as_slice()), ("m", &[0.0, 0.001, 0.002][..]));
        assert_eq!(displacement.noise, Some(0.0005), "noise is in the column's unit");
        assert_eq!(record.channel("force").unwrap().noise, None);
        let by_file = read_dataset(folder.path().join("dataset.toml")).unwrap();
        assert_eq!(by_file, dataset);
    }
}

#[test]
fn both_micro_signs_are_read_and_latin_1_is_explained() {
    for micro in ["\u{b5}m", "\u{3bc}m", "um"] {
        let folder = folder(DATASET.as_bytes(), TABLE.replace("mm", micro).as_bytes());
        let dataset = read_dataset(folder.path()).unwrap();
        assert_eq!(dataset.records[0].channel("displacement").unwrap().values[1], 1e-6);
    }
    let latin: Vec<u8> = TABLE.replace("mm", "\u{b5}m").chars().map(|letter| letter as u8).collect();
    let error = dataset_error(DATASET.as_bytes(), &latin);
    says(&error, "r.csv", 1, &["not UTF-8", "Latin-1", "displacement ["]);
    assert_eq!(error.excerpt.unwrap().column, 1 + TABLE.find("mm").unwrap());
    let wide: Vec<u8> = [0xff, 0xfe].into_iter().chain(TABLE.bytes().flat_map(|byte| [byte, 0])).collect();
    says(&dataset_error(DATASET.as_bytes(), &wide), "r.csv", 1, &["UTF-16"]);
    says(&dataset_error(&latin, b""), "dataset.toml", 1, &["not UTF-8"]);
}

#[test]
fn missing_files_are_named() {
    let error = read_model("nowhere/model.toml").unwrap_err();
    assert_eq!((error.path.as_path(), error.line()), (Path::new("nowhere/model.toml"), None));
    assert!(error.render(false).contains("--> nowhere/model.toml"), "{}", error.render(false));
    assert!(read_dataset("nowhere").is_err());
    dataset_says(&DATASET.replace("r.csv", "q.csv"), 4, &["cannot read `q.csv`", "file = \"q.csv\""]);
    let empty = TempDir::new().unwrap();
    assert!(matches!(*read_dataset(empty.path()).unwrap_err().problem, Problem::Unreadable { .. }));
}

#[test]
fn empty_tables_are_refused() {
    table_says("", 1, &["the file is empty"]);
    table_says("\n\n", 1, &["the file is empty"]);
    table_says("time [s],force [N]\n", 1, &["no row below the header"]);
}

#[test]
fn headers_are_refused_with_what_would_be_right() {
    table_says("time [s],farce [N]\n0,1\n", 1, &["unknown column `farce`", "did you mean `force`"]);
    table_says("time [s],force\n0,1\n", 1, &["no unit", "`force [N]`"]);
    table_says("time [s],force [m]\n0,1\n", 1, &["does not measure force", "N, mN, kN"]);
    table_says("time [s],force [newton]\n0,1\n", 1, &["`newton` is not a unit", "kN"]);
    table_says("time [s],force [N],force [kN]\n0,1,1\n", 1, &["`force` is listed twice"]);
    table_says("time [s],displacement:x=0.10 [m],displacement:x=0.1 [m]\n0,1,1\n", 1, &["twice"]);
    table_says("time [s],acceleration:x=here [g]\n0,1\n", 1, &["not a place", ":x=0.55"]);
    table_says("time [s];force [N]\n0;1\n", 1, &["separated by semicolons", "commas"]);
    table_says("time [s],,force [N]\n0,,1\n", 1, &["unknown column"]);
    table_says("0,1\n0.1,2\n", 1, &["unknown column `0`"]);
}

#[test]
fn fields_are_refused_in_their_line() {
    let header = "time [s],force [N]\n0,1\n\n0.1,2\n";
    table_says(&format!("{header}0.2,abc\n"), 5, &["`abc` in column `force` is not a number"]);
    table_says(&format!("{header}0.2,\n"), 5, &["`` in column `force` is not a number"]);
    table_says(&format!("{header}0.2,NaN\n"), 5, &["not a finite number"]);
    table_says(&format!("{header}0.2,-inf\n"), 5, &["not a finite number"]);
    table_says(&format!("{header}0.2,1e999\n"), 5, &["not a finite number"]);
    table_says(&format!("{header}0.2,3,4\n"), 5, &["differ in length: 3 against 2"]);
    table_says(&format!("{header}0.2\n0.3,4\n"), 5, &["1 against 2"]);
    table_says(&format!("{header}0.1,3\n"), 5, &["time does not increase"]);
    table_says(&format!("{header}\n\n0.05,3\n"), 7, &["time does not increase: 0.05 s after 0.1 s"]);
}

#[test]
fn the_wrong_field_is_marked() {
    let error = dataset_error(DATASET.as_bytes(), b"time [s], force [N]\n0, one\n");
    let excerpt = error.excerpt.unwrap();
    assert_eq!((&excerpt.text[excerpt.span.clone()], excerpt.line, excerpt.column), ("one", 2, 4));
}

#[test]
fn columns_that_the_regime_needs_are_asked_for() {
    table_says("force [N]\n1\n", 1, &["`time [s]` is missing"]);
    let backbone = DATASET.replace("steady", "backbone");
    let error = dataset_error(backbone.as_bytes(), b"amplitude [g]\n1\n");
    says(&error, "r.csv", 1, &["`frequency [Hz]` is missing"]);
    let error = dataset_error(backbone.as_bytes(), b"amplitude [g],frequency [Hz]\n1,50\n2,0\n");
    says(&error, "r.csv", 3, &["out of bounds", "above 0"]);
    let error =
        dataset_error(backbone.as_bytes(), b"amplitude [g],frequency [Hz],damping_ratio [%]\n1,50,300\n");
    says(&error, "r.csv", 2, &["`300`", "at least 0 and at most 1"]);
}

#[test]
fn a_load_that_only_pulls_has_the_wrong_sign() {
    let table = "time [s],displacement [mm],normal_load [kN]\n0,0,-0.1\n0.1,1,-0.2\n";
    table_says(table, 1, &["`normal_load`", "change the sign"]);
    // Lift-off in part of a record is what contacts do.
    let lifted = table.replace("-0.1", "0.1");
    assert!(read_dataset(folder(DATASET.as_bytes(), lifted.as_bytes()).path()).is_ok());
}

#[test]
fn dataset_files_are_refused_at_the_line() {
    dataset_says(&DATASET.replace("dataset/1", "dataset/9"), 1, &["stickslip.dataset/1"]);
    dataset_says(&DATASET.replace("schema", "scheme"), 1, &["`schema` is missing"]);
    dataset_says(&DATASET.replace("regime", "regine"), 5, &["unknown key `regine`", "did you mean `regime`"]);
    dataset_says(&DATASET.replace("[[record]]", "[[recrod]]"), 3, &["did you mean `record`"]);
    dataset_says(&DATASET.replace("[[record]]", "[record]"), 3, &["[[record]]"]);
    dataset_says(
        &DATASET.replace("steady", "stedy"),
        5,
        &["unknown regime", "did you mean `steady`", "`backbone`"],
    );
    dataset_says(&DATASET.replace("regime = \"steady\"", ""), 3, &["`regime` is missing", "`from-rest`"]);
    dataset_says(&DATASET.replace("file = \"r.csv\"", ""), 3, &["`file` is missing"]);
    dataset_says(&format!("{DATASET}use = \"train\"\n"), 6, &["unknown use", "`confirm`"]);
    dataset_says(&DATASET.replace("\"r.csv\"", "3"), 4, &["must be a string, not a number"]);
    dataset_says(
        &format!("{DATASET}[[record]]\nfile = \"r.csv\"\nregime = \"steady\"\n"),
        7,
        &["listed twice"],
    );
    dataset_says("schema = \"stickslip.dataset/1\"\n", 1, &["`record` is missing"]);
    dataset_says(&DATASET.replace("regime =", "regime"), 5, &["not TOML"]);
    dataset_says("", 1, &["`schema` is missing"]);
}

#[test]
fn noise_belongs_to_a_column_and_is_positive() {
    for (noise, words) in [
        ("{ \"velocity\" = 1 }", &["no such column", "`displacement`"][..]),
        ("{ \"force\" = 0 }", &["above 0"]),
        ("{ \"force\" = nan }", &["finite"]),
        ("{ \"force\" = \"1\" }", &["must be a number"]),
        ("3", &["must be a table"]),
    ] {
        dataset_says(&format!("{DATASET}noise = {noise}\n"), 6, words);
    }
}

const MODEL: &str = "schema = \"stickslip.model/1\"\nkind = \"contact\"\n\n[contact]\nlaw = \"jenkins\"\n\
                     tangential_stiffness = 1e6\nfriction_coefficient = 0.5\nnormal_load = 100\n";

fn model(text: &str) -> Result<stickslip::model::Model, InputError> {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("model.toml");
    fs::write(&path, text).unwrap();
    read_model(path)
}

#[test]
fn model_files_are_refused_at_the_line() {
    says(
        &model(&MODEL.replace("normal_load", "normal_laod")).unwrap_err(),
        "model.toml",
        8,
        &["unknown key `normal_laod`", "did you mean `normal_load`", "normal_laod = 100"],
    );
    says(&model("").unwrap_err(), "model.toml", 1, &["`schema` is missing"]);
    says(&model(&MODEL.replace("0.5", "-1")).unwrap_err(), "model.toml", 7, &["above 0, not -1"]);
}

#[test]
fn datasets_must_have_what_the_model_needs() {
    let beam = "schema = \"stickslip.model/1\"\nkind = \"beam\"\n[beam]\nlength = 0.6\nwidth = 0.04\n\
                thickness = 0.005\ndensity = 7850\nyoungs_modulus = 2e11\nmodes = 4\ndamping_ratio = 0.003\n\
                [excitation]\nposition = 0.5\n";
    let oscillator = "schema = \"stickslip.model/1\"\nkind = \"oscillator\"\n[[mass]]\nname = \"m1\"\nmass = 1\n\
                      [[mass]]\nname = \"m2\"\nmass = 1\n[excitation]\nat = \"m2\"\n";
    let (contact, beam, oscillator) =
        (model(MODEL).unwrap(), model(beam).unwrap(), model(oscillator).unwrap());
    let check = |model, regime: &str, table: &str| {
        let dataset = DATASET.replace("steady", regime);
        let dataset = read_dataset(folder(dataset.as_bytes(), table.as_bytes()).path()).unwrap();
        check_columns(&dataset, model)
    };
    assert_eq!(check(&contact, "steady", TABLE), Ok(()));
    let motion = "time [s],excitation [N],acceleration:x=0.5 [g]\n0,1,1\n1,1,2\n";
    assert_eq!(check(&beam, "steady", motion), Ok(()));
    let masses = "time [s],excitation:m2 [N],displacement:m1 [mm]\n0,1,1\n1,1,2\n";
    assert_eq!(check(&oscillator, "steady", masses), Ok(()));
    let backbone = "amplitude [g],frequency [Hz]\n1,50\n2,49\n";
    let placed = |place: &str| backbone.replace("amplitude", &format!("amplitude:{place}"));
    assert_eq!(check(&beam, "backbone", backbone), Ok(()));
    assert_eq!(check(&beam, "backbone", &placed("x=0.5")), Ok(()));
    let free = "time [s],acceleration:x=0.5 [g]\n0,1\n1,2\n";
    assert_eq!(check(&beam, "unknown-initial-state", free), Ok(()));
    assert_eq!(check(&oscillator, "unknown-initial-state", &free.replace("x=0.5", "m1")), Ok(()));
    assert_eq!(check(&oscillator, "backbone", backbone), Ok(()));
    assert_eq!(check(&oscillator, "backbone", &placed("m1")), Ok(()));
    for (model, regime, table, words) in [
        (&contact, "steady", "time [s],force [N]\n0,1\n", "`displacement [m]` is missing"),
        (&contact, "steady", "time [s],displacement [m]\n0,1\n", "`force [N]` is missing"),
        (
            &contact,
            "steady",
            "time [s],displacement:m1 [m],force [N]\n0,1,1\n",
            "`displacement [m]` is missing",
        ),
        (&contact, "steady", "time [s],displacement [m],force [N]\n0,1,5\n1,2,5\n", "same number throughout"),
        (&beam, "steady", &motion.replace(",2\n", ",1\n"), "same number throughout"),
        (&beam, "backbone", &backbone.replace("49", "50"), "same number throughout"),
        (&beam, "backbone", &backbone.replace("2,49\n", ""), "one row shows no change"),
        (&beam, "backbone", &placed("x=0.7"), "from 0 to 0.6 m"),
        (&oscillator, "backbone", &placed("m3"), "the model's masses are `:m1`, `:m2`"),
        (&contact, "backbone", backbone, "kind is \"contact\""),
        (&beam, "steady", TABLE, "`excitation [N]` is missing"),
        (&beam, "steady", "time [s],excitation [N]\n0,1\n", "`acceleration:x=... [m/s^2]` is missing"),
        (&beam, "steady", "time [s],excitation [N],acceleration [g]\n0,1,1\n", "say where on the beam"),
        (&beam, "steady", "time [s],excitation [N],acceleration:x=0.7 [g]\n0,1,1\n", "from 0 to 0.6 m"),
        (&oscillator, "steady", TABLE, "`excitation:m2 [N]` is missing"),
        (&oscillator, "steady", "time [s],excitation:m2 [N]\n0,1\n", "`displacement:... [m]` is missing"),
        (&oscillator, "steady", &masses.replace(":m1", ":m3"), "the model's masses are `:m1`, `:m2`"),
        (&oscillator, "steady", &masses.replace(":m1", ""), "the model's masses are `:m1`, `:m2`"),
    ] {
        says(&check(model, regime, table).unwrap_err(), "r.csv", 1, &[words]);
    }
}

#[test]
fn a_message_reads_like_this() {
    let mut error = model(&MODEL.replace("normal_load", "normal_laod")).unwrap_err();
    error.path = "model.toml".into();
    let expected = "\
error: unknown key `normal_laod` in [contact]
 --> model.toml:8:1
  |
8 | normal_laod = 100
  | ^^^^^^^^^^^
  |
  = help: did you mean `normal_load`? legal keys: `law`, `tangential_stiffness`, `friction_coefficient`, `normal_load`, `normal_stiffness`, `normal_law`, `normal_cubic_stiffness`, `normal_exponent`, `impact_damping`";
    assert_eq!(error.render(false), expected);
    assert_eq!(error.to_string(), "model.toml:8:1: unknown key `normal_laod` in [contact]");
}

#[test]
fn color_adds_escapes_and_nothing_else() {
    let error = model(&MODEL.replace("0.5", "-1")).unwrap_err();
    let colored = error.render(true);
    assert!(colored.contains("\u{1b}["));
    let mut plain = String::new();
    let mut rest = colored.as_str();
    while let Some((before, after)) = rest.split_once('\u{1b}') {
        plain.push_str(before);
        rest = after.split_once('m').unwrap().1;
    }
    assert_eq!(plain + rest, error.render(false));
}
