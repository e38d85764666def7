//! Cases, and the score of a diagnosis of them.

mod generation;
mod scoring;
