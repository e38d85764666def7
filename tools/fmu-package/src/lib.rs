//! Carries the FMU library and writes FMUs
