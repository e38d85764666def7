//! What is in an FMU, and the committed descriptions.

mod archive;
mod golden;
