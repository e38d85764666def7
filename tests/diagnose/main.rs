//! Models against measurements: comparison, noise, tables of few points.

#[path = "../common/mod.rs"]
mod common;

mod compare_columns;
mod compare_records;
mod few_points;
mod laws;
mod long_records;
mod noise;
mod oscillator;
mod pairs;
mod pin_rig;
mod skipped;
