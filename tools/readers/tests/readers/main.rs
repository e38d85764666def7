//! What is read, and what is refused where.

#[path = "../../../../tests/common/external.rs"]
mod external;

mod any_bytes;
mod bad_input;
mod dialects;
mod examples;
mod formats;
mod fuzz;
mod plan;
mod scales;
mod shared_data;
mod ssp;
mod ssp_spelling;
mod unpacked;
