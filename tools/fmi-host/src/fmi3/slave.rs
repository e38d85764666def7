//! A component of FMI 3.0 and its functions, as they are.

use std::ffi::{CStr, CString, c_void};
use std::path::Path;
use std::ptr::{self, NonNull};
use std::sync::{Arc, Mutex, PoisonError};

use super::Format;
use super::binding::Functions3;
use super::teller::{Course, Environment, Teller, intermediate_update, log_message};
use crate::binding::Status;
use crate::component::{Error, State, call, next_number, opened, same_length};
use crate::log::Log;

/// A loaded library of FMI 3.0 with its functions.
#[derive(Debug)]
pub struct Library3 {
    functions: Functions3,
    /// Keeps the functions callable.
    _library: libloading::Library,
}

impl Library3 {
    /// As [`crate::Library::load`].
    ///
    /// # Errors
    /// A file that is no library of this platform, or lacks a function of FMI 3.0 co-simulation.
    pub fn load(path: &Path) -> Result<Arc<Self>, Error> {
        let library = opened(path)?;
        // SAFETY: the names have the signatures of the FMI 3.0 headers.
        let functions = unsafe { Functions3::bind(&library)? };
        Ok(Arc::new(Self { functions, _library: library }))
    }
}

/// One component.
#[derive(Debug)]
pub struct Slave3 {
    library: Arc<Library3>,
    handle: NonNull<c_void>,
    number: u64,
    /// What its callbacks are given.
    environment: Box<Environment>,
    /// Relative tolerance, start and stop (s), for the initialization.
    setup: (Option<f64>, f64, Option<f64>),
    /// Inputs whose derivatives are set for the next step.
    courses: Vec<Course>,
    /// How far the last step came (s), and whether the FMU then wants the simulation to end.
    reached: f64,
    ends: bool,
    /// Nothing may be called after [`Status::Fatal`].
    dead: bool,
}

// SAFETY: FMI allows any thread to call a component, one at a time; `&mut self` sees to that.
unsafe impl Send for Slave3 {}

macro_rules! numbers {
    ($self:ident $values:ident $references:expr, $format:ident, $action:ident; $($name:ident $get:ident $set:ident $of:ty)*) => {
        match $format {
            $(Format::$name => numbers!($action $self $values $references, $get $set $of),)*
            Format::Float64 | Format::Boolean => unreachable!("passed by the caller"),
        }
    };
    (get $self:ident $values:ident $references:expr, $get:ident $set:ident $of:ty) => {{
        let mut found = vec![<$of>::default(); $values.len()];
        let done = call!($self?.$get($references, 1, found.as_mut_ptr(), found.len()));
        $values.iter_mut().zip(found).for_each(|(value, found)| *value = found as f64);
        done
    }};
    (set $self:ident $values:ident $references:expr, $get:ident $set:ident $of:ty) => {{
        let given: Vec<$of> = $values.iter().map(|value| *value as $of).collect();
        call!($self?.$set($references, 1, given.as_ptr(), given.len()))
    }};
}

macro_rules! of_any_type {
    ($action:ident $self:ident $values:ident $references:expr, $format:ident) => {
        numbers!($self $values $references, $format, $action;
            Float32 fmi3GetFloat32 fmi3SetFloat32 f32
            Int8 fmi3GetInt8 fmi3SetInt8 i8
            UInt8 fmi3GetUInt8 fmi3SetUInt8 u8
            Int16 fmi3GetInt16 fmi3SetInt16 i16
            UInt16 fmi3GetUInt16 fmi3SetUInt16 u16
            Int32 fmi3GetInt32 fmi3SetInt32 i32
            UInt32 fmi3GetUInt32 fmi3SetUInt32 u32
            Int64 fmi3GetInt64 fmi3SetInt64 i64
            UInt64 fmi3GetUInt64 fmi3SetUInt64 u64)
    };
}

impl Slave3 {
    /// A new component called `name`, as [`crate::Slave::logging`], which may ask for the inputs `required` within its
    /// steps.
    ///
    /// # Errors
    /// [`Error::Instantiate`]; the log may say why.
    pub fn logging(
        library: Arc<Library3>,
        name: &str,
        token: &str,
        resources: &Path,
        log: Arc<Log>,
        required: &[u32],
    ) -> Result<Self, Error> {
        let (name, token) = (CString::new(name)?, CString::new(token)?);
        // As the standard wants it: an absolute path with a separator at its end; NULL where there is none.
        let folder = resources
            .is_dir()
            .then(|| resources.join(""))
            .map(|folder| folder.to_string_lossy().into_owned());
        let folder = folder.map(CString::new).transpose()?;
        let environment = Box::new(Environment { log, teller: Mutex::new(None) });
        let functions = &library.functions;
        // SAFETY: all strings end with zero; the environment outlives the component.
        let handle = unsafe {
            (functions.fmi3InstantiateCoSimulation)(
                name.as_ptr(),
                token.as_ptr(),
                folder.as_ref().map_or(ptr::null(), |folder| folder.as_ptr()),
                0,
                1,
                0,
                0,
                required.as_ptr(),
                required.len(),
                ptr::from_ref(&*environment).cast_mut().cast(),
                log_message,
                intermediate_update,
            )
        };
        let handle = NonNull::new(handle).ok_or(Error::Instantiate)?;
        let (setup, courses) = ((None, 0.0, None), Vec::new());
        let number = next_number();
        Ok(Self {
            library,
            handle,
            number,
            environment,
            setup,
            courses,
            reached: 0.0,
            ends: false,
            dead: false,
        })
    }

    /// What it says.
    pub fn log(&self) -> &Arc<Log> {
        &self.environment.log
    }

    /// Notes down what [`Slave3::enter_initialization`] tells the FMU.
    pub fn set_up_until(&mut self, tolerance: Option<f64>, start: f64, stop: Option<f64>) {
        self.setup = (tolerance, start, stop);
    }

    /// `fmi3EnterInitializationMode`.
    ///
    /// # Errors
    /// The FMU's status.
    pub fn enter_initialization(&mut self) -> Result<(), Error> {
        let (tolerance, start, stop) = self.setup;
        let (defined, ends) = (tolerance.is_some().into(), stop.is_some().into());
        let (tolerance, stop) = (tolerance.unwrap_or(0.0), stop.unwrap_or(0.0));
        call!(self.fmi3EnterInitializationMode(defined, tolerance, start, ends, stop))
    }

    /// `fmi3ExitInitializationMode`.
    ///
    /// # Errors
    /// The FMU's status.
    pub fn exit_initialization(&mut self) -> Result<(), Error> {
        call!(self.fmi3ExitInitializationMode())
    }

    /// `fmi3SetFloat64` of variables that are no arrays.
    ///
    /// # Errors
    /// Slices of different lengths; the FMU's status.
    #[inline]
    pub fn set_real(&mut self, references: &[u32], values: &[f64]) -> Result<(), Error> {
        same_length(references.len(), values.len())?;
        call!(self.fmi3SetFloat64(references.as_ptr(), references.len(), values.as_ptr(), values.len()))
    }

    /// `fmi3GetFloat64` of variables that are no arrays.
    ///
    /// # Errors
    /// Slices of different lengths; the FMU's status.
    #[inline]
    pub fn get_real(&mut self, references: &[u32], values: &mut [f64]) -> Result<(), Error> {
        same_length(references.len(), values.len())?;
        call!(self.fmi3GetFloat64(references.as_ptr(), references.len(), values.as_mut_ptr(), values.len()))
    }

    /// All `values` of one variable, by the function of its `format`.
    ///
    /// # Errors
    /// The FMU's status.
    pub fn get_numbers(&mut self, format: Format, reference: u32, values: &mut [f64]) -> Result<(), Error> {
        match format {
            Format::Float64 => {
                call!(self.fmi3GetFloat64(&reference, 1, values.as_mut_ptr(), values.len()))
            }
            Format::Boolean => {
                let mut found = vec![0_u8; values.len()];
                let done = call!(self?.fmi3GetBoolean(&reference, 1, found.as_mut_ptr(), found.len()));
                // Any number but zero is true.
                values.iter_mut().zip(found).for_each(|(value, found)| *value = u8::from(found != 0).into());
                done
            }
            _ => of_any_type!(get self values &reference, format),
        }
    }

    /// Sets all `values` of one variable, which its `format` must hold.
    ///
    /// # Errors
    /// The FMU's status.
    pub fn set_numbers(&mut self, format: Format, reference: u32, values: &[f64]) -> Result<(), Error> {
        match format {
            Format::Float64 => call!(self.fmi3SetFloat64(&reference, 1, values.as_ptr(), values.len())),
            Format::Boolean => {
                let given: Vec<u8> = values.iter().map(|value| u8::from(*value != 0.0)).collect();
                call!(self?.fmi3SetBoolean(&reference, 1, given.as_ptr(), given.len()))
            }
            _ => of_any_type!(set self values &reference, format),
        }
    }

    /// `fmi3GetString` of one variable; what is not UTF-8 is replaced.
    ///
    /// # Errors
    /// The FMU's status.
    pub fn get_string(&mut self, reference: u32) -> Result<String, Error> {
        let mut text = ptr::null();
        call!(self?.fmi3GetString(&reference, 1, &mut text, 1))?;
        if text.is_null() {
            return Ok(String::new());
        }
        // SAFETY: FMI: it ends with zero and lives until the next call.
        Ok(unsafe { CStr::from_ptr(text) }.to_string_lossy().into_owned())
    }

    /// `fmi3SetString` of one variable.
    ///
    /// # Errors
    /// A text with a zero byte; the FMU's status.
    pub fn set_string(&mut self, reference: u32, text: &str) -> Result<(), Error> {
        let text = CString::new(text)?;
        let pointer = text.as_ptr();
        call!(self?.fmi3SetString(&reference, 1, &pointer, 1))
    }

    /// Derivatives of one order of inputs with respect to time for the next step, in which the FMU asks for the values.
    pub fn set_input_derivatives(&mut self, references: &[u32], order: u32, values: &[f64]) {
        for (reference, value) in references.iter().zip(values) {
            let place = self.courses.iter().position(|course| course.reference == *reference);
            let place = place.unwrap_or_else(|| {
                self.courses.push(Course { reference: *reference, value: 0.0, derivatives: [0.0; 3] });
                self.courses.len() - 1
            });
            if let Some(derivative) = self.courses[place].derivatives.get_mut(order as usize - 1) {
                *derivative = *value;
            }
        }
    }

    /// `fmi3GetOutputDerivatives` of one order; an array has as many `values` as it has elements.
    ///
    /// # Errors
    /// The FMU's status.
    pub fn get_output_derivatives(
        &mut self,
        references: &[u32],
        order: i32,
        values: &mut [f64],
    ) -> Result<(), Error> {
        let orders = vec![order; references.len()];
        let (count, length) = (references.len(), values.len());
        call!(self?.fmi3GetOutputDerivatives(
            references.as_ptr(),
            count,
            orders.as_ptr(),
            values.as_mut_ptr(),
            length
        ))
    }

    /// `fmi3GetDirectionalDerivative`; an array has as many numbers as it has elements.
    ///
    /// # Errors
    /// The FMU's status.
    pub fn directional_derivative(
        &mut self,
        unknowns: &[u32],
        knowns: &[u32],
        seed: &[f64],
        sensitivity: &mut [f64],
    ) -> Result<(), Error> {
        call!(self?.fmi3GetDirectionalDerivative(
            unknowns.as_ptr(),
            unknowns.len(),
            knowns.as_ptr(),
            knowns.len(),
            seed.as_ptr(),
            seed.len(),
            sensitivity.as_mut_ptr(),
            sensitivity.len()
        ))
    }

    /// `fmi3DoStep` from `time` to `time + step` (s); `last` says that the FMU will never be set back behind `time`.
    ///
    /// # Errors
    /// The FMU's status.
    pub fn do_step(&mut self, time: f64, step: f64, last: bool) -> Result<(), Error> {
        if !self.courses.is_empty() {
            self.tell_from(time)?;
        }
        let (mut event, mut terminate, mut early, mut reached) = (0, 0, 0, f64::NAN);
        let last = last.into();
        let done =
            call!(self.fmi3DoStep(time, step, last, &mut event, &mut terminate, &mut early, &mut reached));
        if !self.courses.is_empty() {
            self.courses.clear();
            *self.environment.teller.lock().unwrap_or_else(PoisonError::into_inner) = None;
        }
        (self.reached, self.ends) = (reached, terminate != 0);
        match done {
            // It was not allowed to.
            Ok(()) if early != 0 && reached < time + step => {
                Err(Error::Call { function: "fmi3DoStep", status: Status::Discard })
            }
            done => done,
        }
    }

    /// Makes ready what the FMU will ask for within a step from `time`.
    fn tell_from(&mut self, time: f64) -> Result<(), Error> {
        let mut courses = std::mem::take(&mut self.courses);
        for course in &mut courses {
            let mut value = [0.0];
            self.get_real(&[course.reference], &mut value)?;
            course.value = value[0];
        }
        let (handle, set) = (self.handle.as_ptr(), self.library.functions.fmi3SetFloat64);
        let teller = Teller { handle, set, begin: time, courses: courses.clone() };
        *self.environment.teller.lock().unwrap_or_else(PoisonError::into_inner) = Some(teller);
        self.courses = courses;
        Ok(())
    }

    /// How far the last step came (s).
    pub fn reached(&self) -> f64 {
        self.reached
    }

    /// Whether the FMU wants the simulation to end.
    pub fn wants_to_end(&self) -> bool {
        self.ends
    }

    /// `fmi3Terminate`.
    ///
    /// # Errors
    /// The FMU's status.
    pub fn terminate(&mut self) -> Result<(), Error> {
        call!(self.fmi3Terminate())
    }

    /// `fmi3GetFMUState` into a state saved before.
    ///
    /// # Errors
    /// A state of another slave; the FMU's status.
    pub fn save_again(&mut self, state: &mut State) -> Result<(), Error> {
        let mut handle = state.of(self.number)?;
        let saved = call!(self?.fmi3GetFMUState(&mut handle));
        state.moved(handle);
        saved
    }

    /// `fmi3GetFMUState`. Give it back to [`Slave3::free`].
    ///
    /// # Errors
    /// The FMU's status.
    pub fn save(&mut self) -> Result<State, Error> {
        let mut state = ptr::null_mut();
        call!(self?.fmi3GetFMUState(&mut state))?;
        Ok(State::new(state, self.number))
    }

    /// `fmi3SetFMUState`.
    ///
    /// # Errors
    /// A state of another slave; the FMU's status.
    pub fn restore(&mut self, state: &State) -> Result<(), Error> {
        let state = state.of(self.number)?;
        // Derivatives were for a step from elsewhere.
        self.courses.clear();
        call!(self?.fmi3SetFMUState(state))
    }

    /// `fmi3FreeFMUState`.
    ///
    /// # Errors
    /// A state of another slave; the FMU's status.
    pub fn free(&mut self, state: State) -> Result<(), Error> {
        let mut state = state.of(self.number)?;
        call!(self?.fmi3FreeFMUState(&mut state))
    }

    /// `fmi3SerializeFMUState`.
    ///
    /// # Errors
    /// A state of another slave; the FMU's status.
    pub fn serialize(&mut self, state: &State) -> Result<Vec<u8>, Error> {
        let (state, mut size) = (state.of(self.number)?, 0);
        call!(self?.fmi3SerializedFMUStateSize(state, &mut size))?;
        let mut bytes = vec![0_u8; size];
        call!(self?.fmi3SerializeFMUState(state, bytes.as_mut_ptr(), size))?;
        Ok(bytes)
    }

    /// `fmi3DeserializeFMUState`.
    ///
    /// # Errors
    /// The FMU's status, e.g. for changed bytes.
    pub fn deserialize(&mut self, bytes: &[u8]) -> Result<State, Error> {
        let mut state = ptr::null_mut();
        call!(self?.fmi3DeserializeFMUState(bytes.as_ptr(), bytes.len(), &mut state))?;
        Ok(State::new(state, self.number))
    }

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

impl Drop for Slave3 {
    fn drop(&mut self) {
        // FMI: after a fatal error nothing may be called, not even this.
        if !self.dead {
            // SAFETY: alive until here.
            unsafe { (self.library.functions.fmi3FreeInstance)(self.handle.as_ptr()) };
        }
    }
}
