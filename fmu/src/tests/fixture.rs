//! A component with a folder of resources and a logger that remembers.

use crate::exports::lifecycle::*;
use crate::exports::states::*;
use crate::exports::stepping::fmi2DoStep;
use crate::exports::values::*;
use crate::ffi::{
    CO_SIMULATION, CallbackFunctions, FmiString, Handle, Logger, MODEL_EXCHANGE, StateHandle, Status,
};
use crate::guard::Component;
use std::ffi::{CStr, CString, c_int, c_void};
use std::path::PathBuf;
use std::ptr::null;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use stickslip::fmi::Instance;

pub const JENKINS: &str = "schema = \"stickslip.model/1\"\nkind = \"contact\"\n[contact]\nlaw = \"jenkins\"\n\
    tangential_stiffness = 2e6\nfriction_coefficient = 0.5\nnormal_load = 100.0\n";
pub const VALANIS: &str = "schema = \"stickslip.model/1\"\nkind = \"contact\"\n[contact]\nlaw = \"valanis\"\n\
    tangential_stiffness = 2e6\nfriction_coefficient = 0.5\nnormal_load = 100.0\nsmoothness = 0.3\n\
    residual_stiffness = 1e5\n";

// Rows of a contact's table.
pub const DISPLACEMENT: u32 = 0;
pub const VELOCITY: u32 = 1;
pub const NORMAL_LOAD: u32 = 2;
pub const FORCE: u32 = 3;
pub const DISSIPATED_ENERGY: u32 = 4;
pub const SLIP_STATE: u32 = 5;
pub const TANGENTIAL_STIFFNESS: u32 = 7;
pub const FRICTION_COEFFICIENT: u32 = 8;

/// What a logger received: status, category, message.
pub type Messages = Mutex<Vec<(c_int, String, String)>>;

/// The importer's logger. Rust cannot define a variadic function; on the platforms this test runs on,
/// pointers passed for `...` arrive like any further argument.
unsafe extern "C" fn remember(
    environment: *mut c_void,
    instance_name: FmiString,
    status: c_int,
    category: FmiString,
    format: FmiString,
    message: FmiString,
) {
    unsafe {
        assert_eq!(CStr::from_ptr(format), c"%s");
        assert!(!instance_name.is_null());
        let text = |pointer| CStr::from_ptr(pointer).to_str().unwrap().to_owned();
        let messages = &*environment.cast::<Messages>();
        messages.lock().unwrap().push((status, text(category), text(message)));
    }
}

/// A folder with a model file, removed at the end.
pub struct Resources(PathBuf);

impl Resources {
    pub fn new(model_toml: &str) -> Self {
        static COUNT: AtomicUsize = AtomicUsize::new(0);
        let number = COUNT.fetch_add(1, Ordering::Relaxed);
        let folder = std::env::temp_dir().join(format!("stickslip fmu {}-{number}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        std::fs::write(folder.join("model.toml"), model_toml).unwrap();
        Self(folder)
    }

    /// As FMI 3.0 has it, with a separator at its end.
    pub fn path(&self) -> CString {
        CString::new(format!("{}/", self.0.to_str().unwrap())).unwrap()
    }

    pub fn uri(&self) -> CString {
        CString::new(format!("file://{}", self.0.to_str().unwrap().replace(' ', "%20"))).unwrap()
    }
}

impl Drop for Resources {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// The importer's side.
pub struct Importer {
    pub resources: Resources,
    pub guid: CString,
    pub messages: Box<Messages>,
    pub callbacks: CallbackFunctions,
}

impl Importer {
    pub fn new(model_toml: &str) -> Self {
        let guid = format!("{{{}}}", Instance::new(model_toml).unwrap().guid());
        let messages: Box<Messages> = Box::default();
        let logger =
            remember as unsafe extern "C" fn(*mut c_void, FmiString, c_int, FmiString, FmiString, FmiString);
        let callbacks = CallbackFunctions {
            // SAFETY: see `remember`.
            logger: Some(unsafe { std::mem::transmute::<*const (), Logger>(logger as *const ()) }),
            allocate_memory: null(),
            free_memory: null(),
            step_finished: null(),
            component_environment: (&raw const *messages).cast_mut().cast(),
        };
        let (resources, guid) = (Resources::new(model_toml), CString::new(guid).unwrap());
        Self { resources, guid, messages, callbacks }
    }

    pub fn instantiate(&self, logging_on: c_int) -> Handle {
        let uri = self.resources.uri();
        let (name, guid) = (c"one".as_ptr(), self.guid.as_ptr());
        unsafe { fmi2Instantiate(name, CO_SIMULATION, guid, uri.as_ptr(), &self.callbacks, 0, logging_on) }
    }

    /// The last message; panics without one.
    pub fn last(&self) -> (c_int, String, String) {
        self.messages.lock().unwrap().last().cloned().expect("a message")
    }

    pub fn count(&self) -> usize {
        self.messages.lock().unwrap().len()
    }

    /// An instantiated component.
    pub fn component(&self) -> Running<'_> {
        let handle = self.instantiate(0);
        assert!(!handle.is_null(), "{:?}", self.messages.lock().unwrap());
        Running { handle, importer: self }
    }

    /// A component that its importer integrates.
    pub fn continuous(&self) -> Running<'_> {
        let (name, uri) = (c"one".as_ptr(), self.resources.uri());
        // SAFETY: the strings outlive the call.
        let handle = unsafe {
            fmi2Instantiate(name, MODEL_EXCHANGE, self.guid.as_ptr(), uri.as_ptr(), &self.callbacks, 0, 0)
        };
        assert!(!handle.is_null(), "{:?}", self.messages.lock().unwrap());
        Running { handle, importer: self }
    }

    /// A component after initialization.
    pub fn running(&self) -> Running<'_> {
        let running = self.component();
        running.initialize();
        running
    }
}

/// A component that is freed at the end.
pub struct Running<'a> {
    pub handle: Handle,
    pub importer: &'a Importer,
}

impl Running<'_> {
    pub fn initialize(&self) {
        unsafe {
            assert_eq!(fmi2SetupExperiment(self.handle, 0, 0.0, 0.0, 0, 0.0), Status::Ok);
            assert_eq!(fmi2EnterInitializationMode(self.handle), Status::Ok);
            assert_eq!(fmi2ExitInitializationMode(self.handle), Status::Ok);
        }
    }

    /// What is behind the handle, for looking only.
    pub fn component(&self) -> &Component {
        unsafe { &*self.handle.cast::<Component>() }
    }

    pub fn set(&self, reference: u32, value: f64) -> Status {
        unsafe { fmi2SetReal(self.handle, &reference, 1, &value) }
    }

    pub fn get(&self, reference: u32) -> f64 {
        let mut value = f64::NAN;
        assert_eq!(unsafe { fmi2GetReal(self.handle, &reference, 1, &mut value) }, Status::Ok);
        value
    }

    pub fn slip_state(&self) -> i32 {
        let mut value = -1;
        assert_eq!(unsafe { fmi2GetInteger(self.handle, &SLIP_STATE, 1, &mut value) }, Status::Ok);
        value
    }

    pub fn do_step(&self, time: f64, step: f64) -> Status {
        unsafe { fmi2DoStep(self.handle, time, step, 1) }
    }

    /// Everything that a run may depend on, as bytes.
    pub fn bytes(&self) -> Vec<u8> {
        unsafe {
            let mut state: StateHandle = std::ptr::null_mut();
            assert_eq!(fmi2GetFMUstate(self.handle, &mut state), Status::Ok);
            let mut size = 0;
            assert_eq!(fmi2SerializedFMUstateSize(self.handle, state, &mut size), Status::Ok);
            let mut bytes = vec![0; size];
            let target = bytes.as_mut_ptr();
            assert_eq!(fmi2SerializeFMUstate(self.handle, state, target, size), Status::Ok);
            assert_eq!(fmi2FreeFMUstate(self.handle, &mut state), Status::Ok);
            assert!(state.is_null());
            bytes.into_iter().map(|byte| byte as u8).collect()
        }
    }

    /// Deserializes and sets `bytes`.
    pub fn set_bytes(&self, bytes: &[u8]) -> Status {
        unsafe {
            let mut state: StateHandle = std::ptr::null_mut();
            let status = fmi2DeSerializeFMUstate(self.handle, bytes.as_ptr().cast(), bytes.len(), &mut state);
            if status != Status::Ok {
                assert!(state.is_null());
                return status;
            }
            let status = fmi2SetFMUstate(self.handle, state);
            assert_eq!(fmi2FreeFMUstate(self.handle, &mut state), Status::Ok);
            status
        }
    }

    /// The last message, which must come from a call that returned fmi2Error.
    pub fn error(&self) -> String {
        let (status, category, message) = self.importer.last();
        assert_eq!((status, category.as_str()), (Status::Error as c_int, "logStatusError"));
        message
    }
}

impl Drop for Running<'_> {
    fn drop(&mut self) {
        unsafe { fmi2FreeInstance(self.handle) };
    }
}
