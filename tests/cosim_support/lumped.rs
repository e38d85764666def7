//! Small slaves with exact solutions.
