//! What pages, tables and JSON promise.

#[path = "../synthetic/mod.rs"]
mod synthetic;

mod browser;
mod comparison;
mod diagnosis;
mod responses;
