//! Messages to the importer.

use crate::ffi::{CallbackFunctions, LogMessage, Logger, Status};
use std::ffi::{CStr, CString, c_int, c_void};
use std::ptr;

/// Log categories, as the model description lists them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Category {
    Events,
    StatusWarning,
    StatusDiscard,
    StatusError,
    StatusFatal,
}

impl Category {
    pub const ALL: [Self; 5] =
        [Self::Events, Self::StatusWarning, Self::StatusDiscard, Self::StatusError, Self::StatusFatal];

    pub fn name(self) -> &'static CStr {
        match self {
            Self::Events => c"logEvents",
            Self::StatusWarning => c"logStatusWarning",
            Self::StatusDiscard => c"logStatusDiscard",
            Self::StatusError => c"logStatusError",
            Self::StatusFatal => c"logStatusFatal",
        }
    }

    fn bit(self) -> u8 {
        1 << self as u8
    }
}

/// All categories, `logAll`.
const ALL: u8 = 0b1_1111;
/// What is reported although debug logging is off: why a call failed, or gave a warning.
const FAILURES: u8 = 0b1_1110;

/// A logger of either version of FMI.
#[derive(Clone, Copy)]
enum Listener {
    Fmi2(Logger),
    Fmi3(LogMessage),
}

/// The importer's logger and what it wants to hear.
pub struct Log {
    logger: Option<Listener>,
    environment: *mut c_void,
    instance_name: CString,
    enabled: u8,
}

impl Log {
    /// # Safety
    /// A non-NULL `callbacks` must point to the importer's functions; they must be callable as long as
    /// the log is used.
    pub unsafe fn new(
        callbacks: *const CallbackFunctions,
        instance_name: Option<&CStr>,
        logging_on: bool,
    ) -> Self {
        // SAFETY: the caller's promise. Read here once: importers are known to free the structure early.
        let callbacks = (!callbacks.is_null()).then(|| unsafe { callbacks.read_unaligned() });
        Self {
            logger: callbacks.and_then(|functions| functions.logger).map(Listener::Fmi2),
            environment: callbacks.map_or(ptr::null_mut(), |functions| functions.component_environment),
            instance_name: instance_name.map(CStr::to_owned).unwrap_or_default(),
            enabled: if logging_on { ALL } else { FAILURES },
        }
    }

    /// Of FMI 3.0, where nothing is told unless logging is on.
    ///
    /// # Safety
    /// `logger` must be callable with `environment` as long as the log is used.
    pub unsafe fn of_fmi3(logger: Option<LogMessage>, environment: *mut c_void, logging_on: bool) -> Self {
        let enabled = if logging_on { ALL } else { 0 };
        Self { logger: logger.map(Listener::Fmi3), environment, instance_name: CString::default(), enabled }
    }

    /// Tells everything from now on.
    pub fn enable(&mut self) {
        self.enabled = ALL;
    }

    /// `fmi2SetDebugLogging`: on with categories means exactly these, off with categories means
    /// without these; without categories, everything or nothing.
    ///
    /// # Errors
    /// A category that does not exist; nothing is changed then.
    pub fn configure(&mut self, on: bool, categories: &[&CStr]) -> Result<(), String> {
        let mut bits = if categories.is_empty() { ALL } else { 0 };
        for wanted in categories {
            bits |= match Category::ALL.iter().find(|category| category.name() == *wanted) {
                Some(category) => category.bit(),
                None if *wanted == c"logAll" => ALL,
                None => return Err(format!("there is no log category {:?}", wanted.to_string_lossy())),
            };
        }
        self.enabled = if on { bits } else { self.enabled & !bits };
        Ok(())
    }

    /// Passes `message` on, if its category is wanted.
    pub fn send(&self, status: Status, category: Category, message: &str) {
        let Some(logger) = self.logger.filter(|_| self.enabled & category.bit() != 0) else {
            return;
        };
        // A NUL inside would cut the message short.
        let message = CString::new(message.replace('\0', "\u{fffd}")).unwrap_or_default();
        let (environment, status, category) = (self.environment, status as c_int, category.name().as_ptr());
        match logger {
            Listener::Fmi2(logger) => {
                let name = self.instance_name.as_ptr();
                // SAFETY: the importer's logger; the format takes exactly one string.
                unsafe { logger(environment, name, status, category, c"%s".as_ptr(), message.as_ptr()) }
            }
            // SAFETY: the importer's logger.
            Listener::Fmi3(logger) => unsafe { logger(environment, status, category, message.as_ptr()) },
        }
    }

    /// Passes a life-cycle message on.
    pub fn event(&self, message: &str) {
        self.send(Status::Ok, Category::Events, message);
    }

    /// Whether life-cycle messages are wanted, so that none is composed in vain.
    pub fn wants_events(&self) -> bool {
        self.logger.is_some() && self.enabled & Category::Events.bit() != 0
    }
}
