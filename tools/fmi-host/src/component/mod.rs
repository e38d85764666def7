//! The functions of an FMU of FMI 2.0, as they are.
//!
//! A `library` is loaded once; a [`Slave`] is a component that it made, whose functions are called here. `state` saves
//! one and goes back to it.

mod error;
mod library;

use crate::binding::{CO_SIMULATION, Callbacks, LAST_SUCCESSFUL_TIME, Status, TERMINATED};
use crate::log::Log;
use std::ffi::{CStr, CString, c_void};
use std::path::Path;
use std::ptr::{self, NonNull};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

pub use error::Error;
pub use library::Library;
pub(crate) use library::opened;
pub use state::State;

/// One component.
#[derive(Debug)]
pub struct Slave {
    library: Arc<Library>,
    handle: NonNull<c_void>,
    /// No other slave in this process has or had it.
    number: u64,
    /// Some libraries keep the pointer they are given.
    _callbacks: Box<Callbacks>,
    /// Where the callbacks write.
    log: Arc<Log>,
    /// Nothing may be called after [`Status::Fatal`].
    dead: bool,
}

// SAFETY: FMI allows any thread to call a component, one at a time; `&mut self` sees to that.
unsafe impl Send for Slave {}

macro_rules! call {
    ($self:ident.$function:ident($($argument:expr),*)) => {{
        let function = $self.library.functions.$function;
        call!($self, function, $function, $($argument),*)
    }};
    ($self:ident?.$function:ident($($argument:expr),*)) => {{
        let function = $self.library.functions.$function.ok_or(Error::Missing(stringify!($function)))?;
        call!($self, function, $function, $($argument),*)
    }};
    ($self:ident, $callable:ident, $function:ident, $($argument:expr),*) => {{
        if $self.dead {
            return Err(Error::Call { function: stringify!($function), status: $crate::binding::Status::Fatal });
        }
        // SAFETY: the handle is alive, saved states are its own, and pointers and lengths come from the
        // same slices.
        let status = unsafe { $callable($self.handle.as_ptr(), $($argument),*) };
        $self.checked(stringify!($function), status)
    }};
}

pub(crate) use call;

// Below the macro that it uses.
mod state;

/// A number that no other slave in this process has or had.
pub(crate) fn next_number() -> u64 {
    static COUNT: AtomicU64 = AtomicU64::new(0);
    COUNT.fetch_add(1, Ordering::Relaxed)
}

impl Slave {
    /// A new component called `name`. `guid` is that of the model description, `resources` the folder
    /// in the unpacked FMU.
    ///
    /// # Errors
    /// [`Error::Instantiate`], e.g. for another GUID.
    pub fn new(library: Arc<Library>, name: &str, guid: &str, resources: &Path) -> Result<Self, Error> {
        Self::logging(library, name, guid, resources, Arc::new(Log::default()), false)
    }

    /// As [`Slave::new`], with a log for what the FMU says: about everything, or by its own choice what failed.
    ///
    /// # Errors
    /// [`Error::Instantiate`]; the log may say why.
    pub fn logging(
        library: Arc<Library>,
        name: &str,
        guid: &str,
        resources: &Path,
        log: Arc<Log>,
        everything: bool,
    ) -> Result<Self, Error> {
        let (name, guid) = (CString::new(name)?, CString::new(guid)?);
        let resources = CString::new(file_uri(resources))?;
        let callbacks = Box::new(Callbacks::new(&log));
        let logs = i32::from(everything);
        let functions = &library.functions;
        // SAFETY: all strings end with zero; the callbacks outlive the component.
        let handle = unsafe {
            let (name, guid, resources) = (name.as_ptr(), guid.as_ptr(), resources.as_ptr());
            (functions.fmi2Instantiate)(name, CO_SIMULATION, guid, resources, &*callbacks, 0, logs)
        };
        let handle = NonNull::new(handle).ok_or(Error::Instantiate)?;
        Ok(Self { library, handle, number: next_number(), _callbacks: callbacks, log, dead: false })
    }

    /// `fmi2SetupExperiment` from `start` (s), with a relative tolerance if given.
    ///
    /// # Errors
    /// The FMU's status.
    pub fn set_up(&mut self, tolerance: Option<f64>, start: f64) -> Result<(), Error> {
        self.set_up_until(tolerance, start, None)
    }

    /// As [`Slave::set_up`], with the `stop` (s) that no step may pass, if given.
    ///
    /// # Errors
    /// The FMU's status.
    pub fn set_up_until(
        &mut self,
        tolerance: Option<f64>,
        start: f64,
        stop: Option<f64>,
    ) -> Result<(), Error> {
        let (defined, tolerance) = (i32::from(tolerance.is_some()), tolerance.unwrap_or(0.0));
        let (ends, stop) = (i32::from(stop.is_some()), stop.unwrap_or(0.0));
        call!(self.fmi2SetupExperiment(defined, tolerance, start, ends, stop))
    }

    /// `fmi2SetDebugLogging`: turns messages of `categories` on, or of all if there are none.
    ///
    /// # Errors
    /// A category with a zero byte; the FMU's status.
    pub fn log_categories(&mut self, categories: &[String]) -> Result<(), Error> {
        let names =
            categories.iter().map(|name| CString::new(name.as_str())).collect::<Result<Vec<_>, _>>()?;
        let pointers: Vec<_> = names.iter().map(|name| name.as_ptr()).collect();
        call!(self?.fmi2SetDebugLogging(1, pointers.len(), pointers.as_ptr()))
    }

    /// What it says.
    pub fn log(&self) -> &Arc<Log> {
        &self.log
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
        call!(self?.fmi2GetInteger(references.as_ptr(), references.len(), values.as_mut_ptr()))
    }

    /// `fmi2SetInteger`.
    ///
    /// # Errors
    /// Slices of different lengths; the FMU's status.
    pub fn set_integer(&mut self, references: &[u32], values: &[i32]) -> Result<(), Error> {
        same_length(references.len(), values.len())?;
        call!(self?.fmi2SetInteger(references.as_ptr(), references.len(), values.as_ptr()))
    }

    /// `fmi2GetBoolean`, zero for false.
    ///
    /// # Errors
    /// Slices of different lengths; the FMU's status.
    pub fn get_boolean(&mut self, references: &[u32], values: &mut [i32]) -> Result<(), Error> {
        same_length(references.len(), values.len())?;
        call!(self?.fmi2GetBoolean(references.as_ptr(), references.len(), values.as_mut_ptr()))
    }

    /// `fmi2SetBoolean`, zero for false and 1 for true.
    ///
    /// # Errors
    /// Slices of different lengths; the FMU's status.
    pub fn set_boolean(&mut self, references: &[u32], values: &[i32]) -> Result<(), Error> {
        same_length(references.len(), values.len())?;
        call!(self?.fmi2SetBoolean(references.as_ptr(), references.len(), values.as_ptr()))
    }

    /// `fmi2GetString` of one variable; what is not UTF-8 is replaced.
    ///
    /// # Errors
    /// The FMU's status.
    pub fn get_string(&mut self, reference: u32) -> Result<String, Error> {
        let mut text = ptr::null();
        call!(self?.fmi2GetString(&reference, 1, &mut text))?;
        if text.is_null() {
            return Ok(String::new());
        }
        // SAFETY: FMI: it ends with zero and lives until the next call.
        Ok(unsafe { CStr::from_ptr(text) }.to_string_lossy().into_owned())
    }

    /// `fmi2SetString` of one variable.
    ///
    /// # Errors
    /// A text with a zero byte; the FMU's status.
    pub fn set_string(&mut self, reference: u32, text: &str) -> Result<(), Error> {
        let text = CString::new(text)?;
        let pointer = text.as_ptr();
        call!(self?.fmi2SetString(&reference, 1, &pointer))
    }

    /// `fmi2SetRealInputDerivatives` of the orders `orders`, for the next step.
    ///
    /// # Errors
    /// Slices of different lengths; the FMU's status.
    #[inline]
    pub fn set_input_derivatives(
        &mut self,
        references: &[u32],
        orders: &[i32],
        values: &[f64],
    ) -> Result<(), Error> {
        same_length(references.len(), values.len())?;
        same_length(references.len(), orders.len())?;
        let count = references.len();
        call!(self?.fmi2SetRealInputDerivatives(references.as_ptr(), count, orders.as_ptr(), values.as_ptr()))
    }

    /// `fmi2GetRealOutputDerivatives` of the orders `orders`.
    ///
    /// # Errors
    /// Slices of different lengths; the FMU's status.
    #[inline]
    pub fn get_output_derivatives(
        &mut self,
        references: &[u32],
        orders: &[i32],
        values: &mut [f64],
    ) -> Result<(), Error> {
        same_length(references.len(), values.len())?;
        same_length(references.len(), orders.len())?;
        let (count, values) = (references.len(), values.as_mut_ptr());
        call!(self?.fmi2GetRealOutputDerivatives(references.as_ptr(), count, orders.as_ptr(), values))
    }

    /// `fmi2GetDirectionalDerivative`: the change of `unknowns` where `knowns` change by `direction`.
    ///
    /// # Errors
    /// Slices of different lengths; the FMU's status.
    #[inline]
    pub fn directional_derivative(
        &mut self,
        unknowns: &[u32],
        knowns: &[u32],
        direction: &[f64],
        change: &mut [f64],
    ) -> Result<(), Error> {
        same_length(unknowns.len(), change.len())?;
        same_length(knowns.len(), direction.len())?;
        let (count, known) = (unknowns.len(), knowns.len());
        call!(self?.fmi2GetDirectionalDerivative(
            unknowns.as_ptr(),
            count,
            knowns.as_ptr(),
            known,
            direction.as_ptr(),
            change.as_mut_ptr()
        ))
    }

    /// `fmi2GetRealStatus`: the time (s) up to which a discarded step came.
    ///
    /// # Errors
    /// The FMU's status.
    pub fn last_successful_time(&mut self) -> Result<f64, Error> {
        let mut time = f64::NAN;
        call!(self?.fmi2GetRealStatus(LAST_SUCCESSFUL_TIME, &mut time))?;
        Ok(time)
    }

    /// `fmi2GetBooleanStatus`: whether a discarded step means that the FMU wants the simulation to end.
    ///
    /// # Errors
    /// The FMU's status.
    pub fn wants_to_end(&mut self) -> Result<bool, Error> {
        let mut ends = 0;
        call!(self?.fmi2GetBooleanStatus(TERMINATED, &mut ends))?;
        Ok(ends != 0)
    }

    /// `fmi2DoStep` from `time` to `time + step` (s). The FMU may be set back behind `time` later.
    ///
    /// # Errors
    /// The FMU's status.
    #[inline]
    pub fn do_step(&mut self, time: f64, step: f64) -> Result<(), Error> {
        call!(self.fmi2DoStep(time, step, 0))
    }

    /// As [`Slave::do_step`]; the FMU will never be set back behind `time`.
    ///
    /// # Errors
    /// The FMU's status.
    #[inline]
    pub fn do_final_step(&mut self, time: f64, step: f64) -> Result<(), Error> {
        call!(self.fmi2DoStep(time, step, 1))
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
        call!(self?.fmi2Reset())
    }
}

impl Slave {
    /// The status of `function` as a result.
    #[inline]
    fn checked(&mut self, function: &'static str, status: i32) -> Result<(), Error> {
        match Status::from_number(status) {
            Status::Ok | Status::Warning => Ok(()),
            status => {
                self.dead = status == Status::Fatal;
                Err(Error::Call { function, status })
            }
        }
    }
}

impl Drop for Slave {
    fn drop(&mut self) {
        // FMI: after a fatal error nothing may be called, not even this.
        if self.dead {
            return;
        }
        // SAFETY: alive until here.
        unsafe { (self.library.functions.fmi2FreeInstance)(self.handle.as_ptr()) };
    }
}

#[inline]
pub(crate) fn same_length(references: usize, values: usize) -> Result<(), Error> {
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
