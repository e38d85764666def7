//! harmonic
