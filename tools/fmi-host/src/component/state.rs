//! Saved states of a slave.

use std::ptr;

use super::{Error, Slave};
use crate::binding::StateHandle;

/// A saved state. It belongs to the slave that saved it, which frees it; dropped, it leaks.
#[derive(Debug)]
#[must_use = "give it back to Slave::free"]
pub struct State {
    handle: StateHandle,
    owner: u64,
}

// SAFETY: only its slave does anything with it, and that can be sent.
unsafe impl Send for State {}

impl State {
    /// What the slave with the number `owner` has saved.
    pub(crate) fn new(handle: StateHandle, owner: u64) -> Self {
        Self { handle, owner }
    }

    /// The C pointer of a state of the slave with the number `owner`.
    pub(crate) fn of(&self, owner: u64) -> Result<StateHandle, Error> {
        if self.owner == owner { Ok(self.handle) } else { Err(Error::ForeignState) }
    }

    /// The FMU has used the state's memory again, or other memory.
    pub(crate) fn moved(&mut self, handle: StateHandle) {
        self.handle = handle;
    }
}

impl Slave {
    /// `fmi2GetFMUstate` into a state saved before, whose memory the FMU can use again.
    ///
    /// # Errors
    /// A state of another slave; the FMU's status.
    pub fn save_again(&mut self, state: &mut State) -> Result<(), Error> {
        let mut handle = self.own(state)?;
        let saved = call!(self?.fmi2GetFMUstate(&mut handle));
        state.handle = handle;
        saved
    }

    /// `fmi2GetFMUstate`. Give it back to [`Slave::free`].
    ///
    /// # Errors
    /// The FMU's status.
    pub fn save(&mut self) -> Result<State, Error> {
        let mut state = ptr::null_mut();
        call!(self?.fmi2GetFMUstate(&mut state))?;
        Ok(State { handle: state, owner: self.number })
    }

    /// The C pointer of a state of this slave.
    fn own(&self, state: &State) -> Result<StateHandle, Error> {
        state.of(self.number)
    }

    /// `fmi2SetFMUstate`.
    ///
    /// # Errors
    /// A state of another slave; the FMU's status.
    pub fn restore(&mut self, state: &State) -> Result<(), Error> {
        let state = self.own(state)?;
        call!(self?.fmi2SetFMUstate(state))
    }

    /// `fmi2FreeFMUstate`.
    ///
    /// # Errors
    /// A state of another slave; the FMU's status.
    pub fn free(&mut self, state: State) -> Result<(), Error> {
        let mut state = self.own(&state)?;
        call!(self?.fmi2FreeFMUstate(&mut state))
    }

    /// `fmi2SerializeFMUstate`.
    ///
    /// # Errors
    /// A state of another slave; the FMU's status.
    pub fn serialize(&mut self, state: &State) -> Result<Vec<u8>, Error> {
        let (state, mut size) = (self.own(state)?, 0);
        call!(self?.fmi2SerializedFMUstateSize(state, &mut size))?;
        let mut bytes = vec![0_u8; size];
        call!(self?.fmi2SerializeFMUstate(state, bytes.as_mut_ptr().cast(), size))?;
        Ok(bytes)
    }

    /// `fmi2DeSerializeFMUstate`.
    ///
    /// # Errors
    /// The FMU's status, e.g. for changed bytes.
    pub fn deserialize(&mut self, bytes: &[u8]) -> Result<State, Error> {
        let mut state = ptr::null_mut();
        call!(self?.fmi2DeSerializeFMUstate(bytes.as_ptr().cast(), bytes.len(), &mut state))?;
        Ok(State { handle: state, owner: self.number })
    }
}
