//! Loads the shared library of an FMI 2.0 co-simulation FMU and calls it.
//!
//! [`Library`] binds the functions, [`Slave`] is one component. Unzipping and reading the model
//! description are the caller's. The library is code of others: it can do anything, and nothing here
//! can prevent that.

mod binding;

pub use binding::Status;

use binding::{CO_SIMULATION, Callbacks, Functions, StateHandle};
use std::ffi::{CString, NulError, c_void};
use std::path::Path;
use std::ptr::{self, NonNull};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// Why an FMU's library does not do what it should.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// It cannot be loaded, or a function is missing.
    #[error("the library cannot be used: {0}")]
    Load(#[from] libloading::Error),
    /// A name with a zero byte.
    #[error("{0}")]
    Name(#[from] NulError),
    /// `fmi2Instantiate` returned NULL.
    #[error("the FMU refuses to be instantiated")]
    Instantiate,
    /// A function returned a status other than OK or warning.
    #[error("{function} returned {status:?}")]
    Call {
        /// The function.
        function: &'static str,
        /// What it returned.
        status: Status,
    },
    /// As many values as value references are needed.
    #[error("{references} value references, but {values} values")]
    Lengths {
        /// Number of value references.
        references: usize,
        /// Number of values.
        values: usize,
    },
    /// A saved state of another slave: its library would take it for one of its own.
    #[error("the saved state belongs to another slave")]
    ForeignState,
}

/// A loaded library with its functions.
#[derive(Debug)]
pub struct Library {
    functions: Functions,
    /// Keeps the functions callable.
    _library: libloading::Library,
}

impl Library {
    /// Loads the library at `path` (absolute, or the system searches its own folders).
    ///
    /// # Errors
    /// A file that is no library of this platform, or lacks a function of FMI 2.0 co-simulation.
    pub fn load(path: &Path) -> Result<Arc<Self>, Error> {
        // SAFETY: loading runs the library's constructors. The user chose to run this FMU.
        let library = unsafe { libloading::Library::new(path)? };
        // SAFETY: the names have the signatures of the FMI 2.0 headers.
        let functions = unsafe { Functions::bind(&library)? };
        Ok(Arc::new(Self { functions, _library: library }))
    }
}

/// One component.
#[derive(Debug)]
pub struct Slave {
    library: Arc<Library>,
    handle: NonNull<c_void>,
    /// No other slave in this process has or had it.
    number: u64,
    /// Some libraries keep the pointer they are given.
    _callbacks: Box<Callbacks>,
}

// SAFETY: FMI allows any thread to call a component, one at a time; `&mut self` sees to that.
unsafe impl Send for Slave {}

/// A saved state. It belongs to the slave that saved it, which frees it; dropped, it leaks.
#[derive(Debug)]
#[must_use = "give it back to Slave::free"]
pub struct State {
    handle: StateHandle,
    owner: u64,
}

macro_rules! call {
    ($self:ident.$function:ident($($argument:expr),*)) => {{
        // SAFETY: the handle is alive, saved states are its own, and pointers and lengths come from the
        // same slices.
        let status = unsafe { ($self.library.functions.$function)($self.handle.as_ptr(), $($argument),*) };
        checked(stringify!($function), status)
    }};
}

impl Slave {
    /// A new component called `name`. `guid` is that of the model description, `resources` the folder
    /// in the unpacked FMU.
    ///
    /// # Errors
    /// [`Error::Instantiate`], e.g. for another GUID.
    pub fn new(library: Arc<Library>, name: &str, guid: &str, resources: &Path) -> Result<Self, Error> {
        let (name, guid) = (CString::new(name)?, CString::new(guid)?);
        let resources = CString::new(file_uri(resources))?;
        let callbacks = Box::new(Callbacks::none());
        let functions = &library.functions;
        // SAFETY: all strings end with zero; the callbacks outlive the component.
        let handle = unsafe {
            let (name, guid, resources) = (name.as_ptr(), guid.as_ptr(), resources.as_ptr());
            (functions.fmi2Instantiate)(name, CO_SIMULATION, guid, resources, &*callbacks, 0, 0)
        };
        let handle = NonNull::new(handle).ok_or(Error::Instantiate)?;
        static COUNT: AtomicU64 = AtomicU64::new(0);
        let number = COUNT.fetch_add(1, Ordering::Relaxed);
        Ok(Self { library, handle, number, _callbacks: callbacks })
    }

    /// `fmi2SetupExperiment` from `start` (s), with a relative tolerance if given.
    ///
    /// # Errors
    /// The FMU's status.
    pub fn set_up(&mut self, tolerance: Option<f64>, start: f64) -> Result<(), Error> {
        let (defined, tolerance) = (i32::from(tolerance.is_some()), tolerance.unwrap_or(0.0));
        call!(self.fmi2SetupExperiment(defined, tolerance, start, 0, 0.0))
    }

    /// `fmi2EnterInitializationMode`.
    ///
    /// # Errors
    /// The FMU's status.
    pub fn enter_initialization(&mut self) -> Result<(), Error> {
        call!(self.fmi2EnterInitializationMode())
    }

    /// `fmi2ExitInitializationMode`.
    ///
    /// # Errors
    /// The FMU's status.
    pub fn exit_initialization(&mut self) -> Result<(), Error> {
        call!(self.fmi2ExitInitializationMode())
    }

    /// `fmi2SetReal`.
    ///
    /// # Errors
    /// Slices of different lengths; the FMU's status.
    #[inline]
    pub fn set_real(&mut self, references: &[u32], values: &[f64]) -> Result<(), Error> {
        same_length(references.len(), values.len())?;
        call!(self.fmi2SetReal(references.as_ptr(), references.len(), values.as_ptr()))
    }

    /// `fmi2GetReal`.
    ///
    /// # Errors
    /// Slices of different lengths; the FMU's status.
    #[inline]
    pub fn get_real(&mut self, references: &[u32], values: &mut [f64]) -> Result<(), Error> {
        same_length(references.len(), values.len())?;
        call!(self.fmi2GetReal(references.as_ptr(), references.len(), values.as_mut_ptr()))
    }

    /// `fmi2GetInteger`.
    ///
    /// # Errors
    /// Slices of different lengths; the FMU's status.
    pub fn get_integer(&mut self, references: &[u32], values: &mut [i32]) -> Result<(), Error> {
        same_length(references.len(), values.len())?;
        call!(self.fmi2GetInteger(references.as_ptr(), references.len(), values.as_mut_ptr()))
    }

    /// `fmi2DoStep` from `time` to `time + step` (s). The FMU may be set back behind `time` later.
    ///
    /// # Errors
    /// The FMU's status.
    #[inline]
    pub fn do_step(&mut self, time: f64, step: f64) -> Result<(), Error> {
        call!(self.fmi2DoStep(time, step, 0))
    }

    /// `fmi2Terminate`.
    ///
    /// # Errors
    /// The FMU's status.
    pub fn terminate(&mut self) -> Result<(), Error> {
        call!(self.fmi2Terminate())
    }

    /// `fmi2Reset`.
    ///
    /// # Errors
    /// The FMU's status.
    pub fn reset(&mut self) -> Result<(), Error> {
        call!(self.fmi2Reset())
    }

    /// `fmi2GetFMUstate`. Give it back to [`Slave::free`].
    ///
    /// # Errors
    /// The FMU's status.
    pub fn save(&mut self) -> Result<State, Error> {
        let mut state = ptr::null_mut();
        call!(self.fmi2GetFMUstate(&mut state))?;
        Ok(State { handle: state, owner: self.number })
    }

    /// The C pointer of a state of this slave.
    fn own(&self, state: &State) -> Result<StateHandle, Error> {
        if state.owner == self.number { Ok(state.handle) } else { Err(Error::ForeignState) }
    }

    /// `fmi2SetFMUstate`.
    ///
    /// # Errors
    /// A state of another slave; the FMU's status.
    pub fn restore(&mut self, state: &State) -> Result<(), Error> {
        let state = self.own(state)?;
        call!(self.fmi2SetFMUstate(state))
    }

    /// `fmi2FreeFMUstate`.
    ///
    /// # Errors
    /// A state of another slave; the FMU's status.
    pub fn free(&mut self, state: State) -> Result<(), Error> {
        let mut state = self.own(&state)?;
        call!(self.fmi2FreeFMUstate(&mut state))
    }

    /// `fmi2SerializeFMUstate`.
    ///
    /// # Errors
    /// A state of another slave; the FMU's status.
    pub fn serialize(&mut self, state: &State) -> Result<Vec<u8>, Error> {
        let (state, mut size) = (self.own(state)?, 0);
        call!(self.fmi2SerializedFMUstateSize(state, &mut size))?;
        let mut bytes = vec![0_u8; size];
        call!(self.fmi2SerializeFMUstate(state, bytes.as_mut_ptr().cast(), size))?;
        Ok(bytes)
    }

    /// `fmi2DeSerializeFMUstate`.
    ///
    /// # Errors
    /// The FMU's status, e.g. for changed bytes.
    pub fn deserialize(&mut self, bytes: &[u8]) -> Result<State, Error> {
        let mut state = ptr::null_mut();
        call!(self.fmi2DeSerializeFMUstate(bytes.as_ptr().cast(), bytes.len(), &mut state))?;
        Ok(State { handle: state, owner: self.number })
    }
}

impl Drop for Slave {
    fn drop(&mut self) {
        // SAFETY: alive until here.
        unsafe { (self.library.functions.fmi2FreeInstance)(self.handle.as_ptr()) };
    }
}

#[inline]
fn checked(function: &'static str, status: i32) -> Result<(), Error> {
    match Status::from_number(status) {
        Status::Ok | Status::Warning => Ok(()),
        status => Err(Error::Call { function, status }),
    }
}

#[inline]
fn same_length(references: usize, values: usize) -> Result<(), Error> {
    if references == values { Ok(()) } else { Err(Error::Lengths { references, values }) }
}

/// The URI of an absolute path, with everything escaped that could have a meaning.
fn file_uri(path: &Path) -> String {
    let text = path.to_string_lossy().replace('\\', "/");
    let mut uri = String::from(if text.starts_with('/') { "file://" } else { "file:///" });
    for byte in text.bytes() {
        match byte {
            b'a'..=b'z' | b'A'..=b'Z' | b'0'..=b'9' | b'/' | b'.' | b'-' | b'_' | b'~' | b':' => {
                uri.push(char::from(byte));
            }
            _ => uri.push_str(&format!("%{byte:02X}")),
        }
    }
    uri
}
