//! Least squares and what is fitted with it.

#[path = "../common/mod.rs"]
mod common;

mod backbone;
mod least_squares;
mod ring_down;
mod steady_oscillators;
mod stepped_sine;
