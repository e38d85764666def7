//! From a file of measurements to numbers that are taken away: import, faults named before a fit, what was fitted.

mod data_faults;
mod import;
mod numbers;
