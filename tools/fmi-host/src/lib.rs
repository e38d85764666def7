//! Loads FMUs
