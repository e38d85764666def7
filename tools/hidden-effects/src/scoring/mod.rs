//! A diagnosis against the truth: run.rs runs the program, score.rs scores an answer, table.rs writes the page.
//!
//! figures.rs counts for it; questions.rs and calibration.rs are sections of it; machine.rs is the same for programs.
//! truth.rs: what is hidden; agreement.rs: the program's physics against the generator's; visibility.rs: what a refit cannot
//! absorb; wilson.rs: intervals of shares.

pub mod agreement;
pub mod assumptions;
mod calibration;
mod figures;
pub mod machine;
mod questions;
pub mod run;
pub mod score;
pub mod table;
pub mod truth;
pub mod visibility;
pub mod wilson;
