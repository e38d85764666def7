//! What is read, and what is refused where.

mod any_bytes;
mod bad_input;
mod examples;
mod shared_data;
mod ssp;
