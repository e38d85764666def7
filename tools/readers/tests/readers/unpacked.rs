//! Small files that would take gigabytes once they are unpacked.

use std::io::Write as _;
use std::path::Path;

use stickslip_readers::{ImportOptions, import_table};

/// One sentence says that there is no room for it.
fn is_refused(bytes: Vec<u8>) {
    assert!(bytes.len() < 1 << 20, "{} bytes are no small file", bytes.len());
    let refused = import_table(Path::new("loop.bin"), bytes, &ImportOptions::default());
    let refused = refused.expect_err("there is no room for it").render(false);
    assert!(refused.contains("up to 300 MB are read") && refused.contains("help: "), "{refused}");
}

#[test]
fn the_datasets_of_an_hdf5_file_have_room_all_together() {
    const ROWS: usize = 14_000_000;
    let mut builder = hdf5_pure::FileBuilder::new();
    for name in ["time [s]", "displacement [m]", "force [N]"] {
        let data = builder.create_dataset(name);
        data.with_u8_data(&vec![0; ROWS]);
        data.with_chunks(&[1 << 20]);
        data.with_deflate(6);
    }
    is_refused(builder.finish().unwrap());
}

fn element(kind: u32, contents: &[u8]) -> Vec<u8> {
    let mut bytes = [&kind.to_le_bytes()[..], &(contents.len() as u32).to_le_bytes(), contents].concat();
    bytes.resize(bytes.len().next_multiple_of(8), 0);
    bytes
}

/// A MAT file with `variables`, each packed.
fn mat(variables: &[Vec<u8>]) -> Vec<u8> {
    let mut bytes = b"MATLAB 5.0 MAT-file, by hand".to_vec();
    bytes.resize(124, b' ');
    bytes[116..124].fill(0);
    bytes.extend([0, 1, b'I', b'M']);
    for variable in variables {
        let mut packed = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::new(6));
        packed.write_all(variable).unwrap();
        let packed = packed.finish().unwrap();
        bytes.extend([&15u32.to_le_bytes()[..], &(packed.len() as u32).to_le_bytes(), &packed].concat());
    }
    bytes
}

/// A vector of doubles that are stored as bytes.
fn vector(name: &str, rows: usize) -> Vec<u8> {
    let class = element(6, &[6, 0, 0, 0, 0, 0, 0, 0]);
    let size = element(5, &[1u32.to_le_bytes(), (rows as u32).to_le_bytes()].concat());
    element(14, &[class, size, element(1, name.as_bytes()), element(2, &vec![0; rows])].concat())
}

#[test]
fn the_variables_of_a_mat_file_have_room_all_together() {
    let rows = 14_000_000;
    is_refused(mat(&["time_s", "displacement_mm", "force_kN"].map(|name| vector(name, rows))));
}

#[test]
fn a_packed_variable_is_measured_whatever_it_says_of_its_length() {
    let mut long = vector("force_kN", 40_000_000);
    long[4..8].copy_from_slice(&64u32.to_le_bytes());
    is_refused(mat(&[long]));
    // Cells without contents take memory too.
    let class = element(6, &[1, 0, 0, 0, 0, 0, 0, 0]);
    let size = element(5, &[1u32.to_le_bytes(), 4_000_000u32.to_le_bytes()].concat());
    let cells = element(14, &[]).repeat(4_000_000);
    is_refused(mat(&[element(14, &[class, size, element(1, b"cells"), cells].concat())]));
}
