//! FMI 2.0 co-simulation: the shared library inside every FMU
