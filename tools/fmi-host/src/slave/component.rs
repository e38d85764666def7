//! A component of either version of FMI.

use std::sync::Arc;

use crate::component::{Error, Slave, State};
use crate::fmi3::Slave3;
use crate::log::Log;

/// The component behind a slave of the master.
#[derive(Debug)]
pub(crate) enum Component {
    Two(Slave),
    Three(Slave3),
}

/// Functions that both have.
macro_rules! both {
    ($($(#[$inline:meta])? $name:ident($($argument:ident: $of:ty),*) -> $result:ty;)*) => {
        impl Component {
            $($(#[$inline])? pub fn $name(&mut self $(, $argument: $of)*) -> $result {
                match self {
                    Self::Two(slave) => slave.$name($($argument),*),
                    Self::Three(slave) => slave.$name($($argument),*),
                }
            })*
        }
    };
}

both! {
    enter_initialization() -> Result<(), Error>;
    exit_initialization() -> Result<(), Error>;
    #[inline] set_real(references: &[u32], values: &[f64]) -> Result<(), Error>;
    #[inline] get_real(references: &[u32], values: &mut [f64]) -> Result<(), Error>;
    get_string(reference: u32) -> Result<String, Error>;
    set_string(reference: u32, text: &str) -> Result<(), Error>;
    terminate() -> Result<(), Error>;
    save() -> Result<State, Error>;
    save_again(state: &mut State) -> Result<(), Error>;
    restore(state: &State) -> Result<(), Error>;
    free(state: State) -> Result<(), Error>;
    serialize(state: &State) -> Result<Vec<u8>, Error>;
    deserialize(bytes: &[u8]) -> Result<State, Error>;
}

impl Component {
    /// What it says.
    pub fn log(&self) -> &Arc<Log> {
        match self {
            Self::Two(slave) => slave.log(),
            Self::Three(slave) => slave.log(),
        }
    }

    pub fn set_up_until(
        &mut self,
        tolerance: Option<f64>,
        start: f64,
        stop: Option<f64>,
    ) -> Result<(), Error> {
        match self {
            Self::Two(slave) => slave.set_up_until(tolerance, start, stop),
            Self::Three(slave) => {
                slave.set_up_until(tolerance, start, stop);
                Ok(())
            }
        }
    }

    /// A step; `last` says that the FMU will never be set back behind `time`.
    #[inline]
    pub fn do_step(&mut self, time: f64, step: f64, last: bool) -> Result<(), Error> {
        match self {
            Self::Two(slave) if last => slave.do_final_step(time, step),
            Self::Two(slave) => slave.do_step(time, step),
            Self::Three(slave) => slave.do_step(time, step, last),
        }
    }

    /// Whether the FMU wants the simulation to end, after a step that was `discarded` or done.
    pub fn wants_to_end(&mut self, discarded: bool) -> bool {
        match self {
            Self::Two(slave) => discarded && slave.wants_to_end().unwrap_or(false),
            Self::Three(slave) => slave.wants_to_end(),
        }
    }

    /// How far a discarded step came (s), if the FMU tells.
    pub fn reached(&mut self) -> Option<f64> {
        let reached = match self {
            Self::Two(slave) => slave.last_successful_time().ok(),
            Self::Three(slave) => Some(slave.reached()),
        };
        reached.filter(|reached| reached.is_finite())
    }
}
