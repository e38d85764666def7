//! Cases, and the score of a diagnosis of them.

mod generation;
mod later;
mod scoring;
