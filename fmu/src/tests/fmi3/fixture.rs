//! An instance of FMI 3.0 with a folder of resources and a logger that remembers.

use crate::ffi::{Bool, FmiString, Handle, IntermediateUpdate, StateHandle, Status};
use crate::fmi3::lifecycle::*;
use crate::fmi3::states::*;
use crate::fmi3::stepping::fmi3DoStep;
use crate::fmi3::values::*;
use crate::guard::Component;
use crate::tests::fixture::Resources;
use std::cell::RefCell;
use std::ffi::{CStr, CString, c_int, c_void};
use std::ptr::null_mut;
use stickslip::fmi::Instance;

/// What a logger received: status, category, message.
pub type Messages = RefCell<Vec<(c_int, String, String)>>;

unsafe extern "C" fn remember(
    environment: *mut c_void,
    status: c_int,
    category: FmiString,
    message: FmiString,
) {
    unsafe {
        let text = |pointer| CStr::from_ptr(pointer).to_str().unwrap().to_owned();
        (*environment.cast::<Messages>()).borrow_mut().push((status, text(category), text(message)));
    }
}

/// The importer's side.
pub struct Importer {
    pub resources: Resources,
    pub token: CString,
    pub messages: Box<Messages>,
}

impl Importer {
    pub fn new(model_toml: &str) -> Self {
        let token = CString::new(format!("{{{}}}", Instance::new(model_toml).unwrap().guid())).unwrap();
        Self { resources: Resources::new(model_toml), token, messages: Box::default() }
    }

    pub fn environment(&self) -> *mut c_void {
        (&raw const *self.messages).cast_mut().cast()
    }

    /// An instance for co-simulation.
    pub fn slave(&self) -> Running<'_> {
        self.asked(&[], None, null_mut())
    }

    /// One whose importer has a function to be called within steps, with an environment of its own: then without a logger.
    pub fn asked(
        &self,
        required: &[u32],
        update: Option<IntermediateUpdate>,
        environment: *mut c_void,
    ) -> Running<'_> {
        let (path, name) = (self.resources.path(), c"one".as_ptr());
        let (environment, logger) =
            if update.is_some() { (environment, None) } else { (self.environment(), Some(remember as _)) };
        let handle = unsafe {
            let (token, count) = (self.token.as_ptr(), required.len());
            let (references, path) = (required.as_ptr(), path.as_ptr());
            fmi3InstantiateCoSimulation(
                name,
                token,
                path,
                0,
                1,
                0,
                0,
                references,
                count,
                environment,
                logger,
                update,
            )
        };
        assert!(!handle.is_null(), "{:?}", self.messages.borrow());
        Running { handle, importer: self }
    }

    /// An instance that its importer integrates.
    pub fn continuous(&self) -> Running<'_> {
        let (path, name) = (self.resources.path(), c"one".as_ptr());
        let handle = unsafe {
            let token = self.token.as_ptr();
            fmi3InstantiateModelExchange(name, token, path.as_ptr(), 0, 1, self.environment(), Some(remember))
        };
        assert!(!handle.is_null(), "{:?}", self.messages.borrow());
        Running { handle, importer: self }
    }

    pub fn last(&self) -> (c_int, String, String) {
        self.messages.borrow().last().cloned().expect("a message")
    }

    /// Tries to instantiate for co-simulation with these; the message if it is refused.
    pub fn refused(
        &self,
        name: FmiString,
        token: FmiString,
        path: FmiString,
        event_mode: Bool,
        required: &[u32],
    ) -> String {
        let handle = unsafe {
            // Logging is off: why it failed is told nevertheless.
            fmi3InstantiateCoSimulation(
                name,
                token,
                path,
                0,
                0,
                event_mode,
                0,
                required.as_ptr(),
                required.len(),
                self.environment(),
                Some(remember),
                None,
            )
        };
        assert!(handle.is_null());
        self.last().2
    }
}

/// An instance that is freed at the end.
pub struct Running<'a> {
    pub handle: Handle,
    pub importer: &'a Importer,
}

impl Running<'_> {
    pub fn initialize(&self) {
        unsafe {
            assert_eq!(fmi3EnterInitializationMode(self.handle, 0, 0.0, 0.0, 0, 0.0), Status::Ok);
            assert_eq!(fmi3ExitInitializationMode(self.handle), Status::Ok);
        }
    }

    /// What is behind the handle, for looking only.
    pub fn component(&self) -> &Component {
        unsafe { &*self.handle.cast::<Component>() }
    }

    pub fn set(&self, reference: u32, value: f64) -> Status {
        unsafe { fmi3SetFloat64(self.handle, &reference, 1, &value, 1) }
    }

    pub fn get(&self, reference: u32) -> f64 {
        let mut value = f64::NAN;
        assert_eq!(unsafe { fmi3GetFloat64(self.handle, &reference, 1, &mut value, 1) }, Status::Ok);
        value
    }

    pub fn do_step(&self, time: f64, step: f64) -> Status {
        let (mut event, mut terminate, mut early, mut last) = (9, 9, 9, f64::NAN);
        let status = unsafe {
            fmi3DoStep(self.handle, time, step, 1, &mut event, &mut terminate, &mut early, &mut last)
        };
        if status == Status::Ok {
            assert_eq!((event, terminate, early, last), (0, 0, 0, time + step));
        }
        status
    }

    pub fn bytes(&self) -> Vec<u8> {
        unsafe {
            let mut state: StateHandle = null_mut();
            assert_eq!(fmi3GetFMUState(self.handle, &mut state), Status::Ok);
            let mut size = 0;
            assert_eq!(fmi3SerializedFMUStateSize(self.handle, state, &mut size), Status::Ok);
            let mut bytes = vec![0_u8; size];
            let target = bytes.as_mut_ptr().cast();
            assert_eq!(fmi3SerializeFMUState(self.handle, state, target, size), Status::Ok);
            assert_eq!(fmi3FreeFMUState(self.handle, &mut state), Status::Ok);
            bytes
        }
    }

    /// Deserializes and sets `bytes`.
    pub fn set_bytes(&self, bytes: &[u8]) -> Status {
        unsafe {
            let mut state: StateHandle = null_mut();
            let status = fmi3DeserializeFMUState(self.handle, bytes.as_ptr().cast(), bytes.len(), &mut state);
            if status != Status::Ok {
                return status;
            }
            let status = fmi3SetFMUState(self.handle, state);
            assert_eq!(fmi3FreeFMUState(self.handle, &mut state), Status::Ok);
            status
        }
    }
}

impl Drop for Running<'_> {
    fn drop(&mut self) {
        unsafe { fmi3FreeInstance(self.handle) };
    }
}
