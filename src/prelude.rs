//! What most programs that use this library need, by one line.
//!
//! ```
//! use stickslip::prelude::*;
//!
//! let model = Model::parse(
//!     r#"
//!     schema = "stickslip.model/1"
//!     kind = "contact"
//!     contact = { law = "jenkins", tangential_stiffness = 2e3, friction_coefficient = 0.1, normal_load = 10.0 }
//!     "#,
//! )?;
//! let law: Box<dyn ContactLaw> = model.law()?.expect("the model has a contact");
//! assert_eq!(law.limit(10.0), 1.0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub use crate::contact::{
    ContactLaw, Inputs, Iwan, Jenkins, LawError, LoadedContact, Response, SlipState, StateTangents, Tangents,
    Valanis,
};
pub use crate::data::{Channel, Dataset, Record, Regime};
#[cfg(feature = "analysis")]
pub use crate::diagnose::{DiagnoseOptions, DiagnoseWatch, Diagnosis, Verdict, diagnose};
#[cfg(feature = "analysis")]
pub use crate::fit::compare::{Refit, Stage, Watch, evaluate, refit};
#[cfg(feature = "analysis")]
pub use crate::fit::predict::predict;
#[cfg(feature = "analysis")]
pub use crate::harmonic::{Assembly, Control, Curve, CurveSettings, frequency_response};
pub use crate::model::{Model, Structure};
pub use crate::system::{Core, Element, Port, System};
