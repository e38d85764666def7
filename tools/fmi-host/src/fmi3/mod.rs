//! FMUs of FMI 3.0, for co-simulation without event mode, clocks and early return.
//!
//! In: an archive of FMI 3.0. Out: the same description and the same slave as of FMI 2.0. `description` reads the XML, each
//! element of an array as a variable of its own; `binding` are the functions, `slave` calls them; `format` has the types
//! that numbers are passed as; `teller` tells inputs within a step, where the FMU asks for them.

mod binding;
mod description;
mod format;
mod slave;
mod teller;

pub(crate) use description::read;
pub use format::Format;
pub use slave::{Library3, Slave3};
