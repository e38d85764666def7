//! What FMUs say, kept within bounds.
//!
//! The logger of FMI 2.0 is a C function with a variable number of arguments, which stable Rust can call but not
//! define. Where this is built for x86-64 Linux, the function is assembly that collects the arguments as the platform's
//! calling convention says, and hands them to `vsnprintf`: the message is complete. Elsewhere it is a function of the
//! six first arguments: a message `"%s"` is read from the sixth, as careful FMUs send it, and of any other message the
//! placeholders stay as they are.

use std::collections::VecDeque;
use std::ffi::{CStr, c_char, c_int, c_void};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Mutex, MutexGuard, PoisonError};

use crate::binding::Status;

/// Messages kept: the last ones.
const KEPT: usize = 200;
/// Bytes of a message at most.
const LONGEST: usize = 4096;

/// In place of the letter of a type, in FMI 3.0.
pub(crate) const NO_LETTER: u8 = 0;

/// A message of an FMU.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Message {
    /// How bad it is, as the FMU says.
    pub status: Status,
    /// Its category.
    pub category: String,
    /// What it says.
    pub text: String,
    /// How often it came in succession.
    pub times: u64,
}

/// The messages of an instance. The last ones are kept, each shortened where it is very long; equal ones in
/// succession are counted: an FMU that says something at every step takes no memory.
#[derive(Default)]
pub struct Log {
    inner: Mutex<Inner>,
    names: Option<Box<Names>>,
}

/// The name of a variable by the letter of its type and its value reference, for `#r12#` in messages.
type Names = dyn Fn(u8, u32) -> Option<String> + Send + Sync;

impl std::fmt::Debug for Log {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Log").field("inner", &self.inner).finish_non_exhaustive()
    }
}

#[derive(Debug, Default)]
struct Inner {
    messages: VecDeque<Message>,
    forgotten: u64,
    /// The last message of something that failed, until somebody asks for it.
    failure: Option<String>,
}

impl Log {
    /// An empty log; `names` gives those of variables by the letter of their type (`r`, `i`, `b`, `s`) and their value
    /// reference.
    pub fn new(names: impl Fn(u8, u32) -> Option<String> + Send + Sync + 'static) -> Self {
        Self { names: Some(Box::new(names)), ..Self::default() }
    }

    fn name(&self, letter: u8, reference: u32) -> Option<String> {
        self.names.as_ref()?(letter, reference)
    }

    fn inner(&self) -> MutexGuard<'_, Inner> {
        self.inner.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Takes down a message.
    pub fn push(&self, status: Status, category: &str, text: &str) {
        let text = self.with_names(shortened(text.trim_end(), LONGEST));
        let mut inner = self.inner();
        if !matches!(status, Status::Ok | Status::Warning | Status::Pending) {
            inner.failure = Some(text.clone());
        }
        if let Some(last) = inner.messages.back_mut()
            && last.status == status
            && last.text == text
        {
            last.times += 1;
            return;
        }
        if inner.messages.len() == KEPT {
            inner.messages.pop_front();
            inner.forgotten += 1;
        }
        let category = shortened(category, 100).to_owned();
        inner.messages.push_back(Message { status, category, text, times: 1 });
    }

    /// The messages kept, oldest first.
    pub fn messages(&self) -> Vec<Message> {
        self.inner().messages.iter().cloned().collect()
    }

    /// The messages kept, which are forgotten then.
    pub fn take(&self) -> Vec<Message> {
        self.inner().messages.drain(..).collect()
    }

    /// Number of messages that came before those kept.
    pub fn forgotten(&self) -> u64 {
        self.inner().forgotten
    }

    /// What the FMU last said of something that failed, each message once.
    pub fn take_failure(&self) -> Option<String> {
        self.inner().failure.take()
    }

    /// `#r12#` becomes the name of the Real variable 12, `##` a number sign.
    fn with_names(&self, text: &str) -> String {
        let mut whole = String::with_capacity(text.len());
        let mut rest = text;
        while let Some(at) = rest.find('#') {
            whole.push_str(&rest[..at]);
            rest = &rest[at + 1..];
            if let Some(after) = rest.strip_prefix('#') {
                whole.push('#');
                rest = after;
                continue;
            }
            let name = rest.split_once('#').and_then(|(inner, after)| {
                // FMI 3.0 has no letters.
                if let Ok(reference) = inner.parse() {
                    return Some((self.name(NO_LETTER, reference)?, after));
                }
                let letter = *inner.as_bytes().first()?;
                let reference = inner.get(1..)?.parse().ok()?;
                Some((self.name(letter, reference)?, after))
            });
            match name {
                Some((name, after)) => {
                    whole.push_str(&name);
                    rest = after;
                }
                None => whole.push('#'),
            }
        }
        whole.push_str(rest);
        whole
    }
}

fn shortened(text: &str, longest: usize) -> &str {
    let end = text.len().min(longest);
    let end = (0..=end).rev().find(|end| text.is_char_boundary(*end)).unwrap_or(0);
    &text[..end]
}

/// The function for `fmi2CallbackFunctions`.
pub(crate) fn callback() -> *const c_void {
    logger as *const () as *const c_void
}

/// The text of a C string, with what is not UTF-8 replaced.
///
/// # Safety
/// NULL, or a string that ends with zero.
unsafe fn text(string: *const c_char) -> String {
    if string.is_null() {
        return String::new();
    }
    // SAFETY: the caller's promise.
    unsafe { CStr::from_ptr(string) }.to_string_lossy().into_owned()
}

/// Notes down a finished message. Nothing may unwind into the FMU.
///
/// # Safety
/// `environment` is NULL or points to a live [`Log`]; the strings are NULL or end with zero.
pub(crate) unsafe fn note(
    environment: *const c_void,
    status: c_int,
    category: *const c_char,
    message: *const c_char,
) {
    if environment.is_null() {
        return;
    }
    let _ = catch_unwind(AssertUnwindSafe(|| {
        // SAFETY: the caller's promise.
        let (log, category, message) =
            unsafe { (&*environment.cast::<Log>(), text(category), text(message)) };
        log.push(Status::from_number(status), &category, &message);
    }));
}

#[cfg(all(target_arch = "x86_64", target_os = "linux"))]
unsafe extern "C" {
    fn vsnprintf(buffer: *mut c_char, size: usize, format: *const c_char, arguments: *mut c_void) -> c_int;
}

/// `fmi2CallbackLogger`: `(environment, instance name, status, category, message, ...)`.
///
/// As the System V calling convention for x86-64 says: the named arguments are in rdi, rsi, edx, rcx and r8, so that
/// of the registers for integers only r9 can hold an unnamed one; floating-point ones are in xmm0 to xmm7 if al is not
/// zero; further ones are on the stack above the return address. A `va_list` of these is built and its address passed
/// on as the sixth argument, everything else as it came.
#[cfg(all(target_arch = "x86_64", target_os = "linux"))]
#[unsafe(naked)]
unsafe extern "C" fn logger() {
    std::arch::naked_asm!(
        "push rbp",
        "mov rbp, rsp",
        // From rsp: the va_list (24 bytes), padding, and at 32 the register save area (48 + 128 bytes).
        "sub rsp, 208",
        "mov [rsp + 32 + 40], r9",
        "test al, al",
        "je 2f",
        "movaps [rsp + 32 + 48], xmm0",
        "movaps [rsp + 32 + 64], xmm1",
        "movaps [rsp + 32 + 80], xmm2",
        "movaps [rsp + 32 + 96], xmm3",
        "movaps [rsp + 32 + 112], xmm4",
        "movaps [rsp + 32 + 128], xmm5",
        "movaps [rsp + 32 + 144], xmm6",
        "movaps [rsp + 32 + 160], xmm7",
        "2:",
        // gp_offset: five of the integer registers are named arguments. fp_offset: none of the others is.
        "mov dword ptr [rsp], 40",
        "mov dword ptr [rsp + 4], 48",
        // overflow_arg_area: above the saved rbp and the return address. reg_save_area.
        "lea rax, [rbp + 16]",
        "mov [rsp + 8], rax",
        "lea rax, [rsp + 32]",
        "mov [rsp + 16], rax",
        "mov r9, rsp",
        "call {formatted}",
        "leave",
        "ret",
        formatted = sym formatted,
    )
}

/// Formats a message and notes it down.
///
/// # Safety
/// As [`note`]; `arguments` is a `va_list` that suits the format.
#[cfg(all(target_arch = "x86_64", target_os = "linux"))]
unsafe extern "C" fn formatted(
    environment: *const c_void,
    _instance: *const c_char,
    status: c_int,
    category: *const c_char,
    message: *const c_char,
    arguments: *mut c_void,
) {
    if message.is_null() {
        return;
    }
    let mut buffer = [0_u8; LONGEST];
    let start = buffer.as_mut_ptr().cast::<c_char>();
    // SAFETY: the size is that of the buffer; format and arguments are the FMU's, as for any printf.
    let length = unsafe { vsnprintf(start, buffer.len(), message, arguments) };
    let shown = if length < 0 { message } else { start.cast_const() };
    // SAFETY: the environment is the log we gave to the FMU; vsnprintf ends with zero.
    unsafe { note(environment, status, category, shown) }
}

/// `fmi2CallbackLogger`, of which the first unnamed argument is taken for a pointer if the message is `"%s"`.
///
/// # Safety
/// As [`note`]. On the platforms this is used on, unnamed arguments are passed where named ones would be; on Apple's
/// arm64 they are not, and there the sixth is not looked at.
#[cfg(not(all(target_arch = "x86_64", target_os = "linux")))]
unsafe extern "C" fn logger(
    environment: *const c_void,
    _instance: *const c_char,
    status: c_int,
    category: *const c_char,
    message: *const c_char,
    first: *const c_char,
) {
    if message.is_null() {
        return;
    }
    let elsewhere = cfg!(all(target_arch = "aarch64", target_vendor = "apple"));
    // SAFETY: the message ends with zero.
    let only_string = !elsewhere && unsafe { CStr::from_ptr(message) } == c"%s";
    // SAFETY: the environment is the log we gave to the FMU; with "%s" there is a string.
    unsafe { note(environment, status, category, if only_string { first } else { message }) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::mem::transmute;

    type Variadic = unsafe extern "C" fn(*const Log, *const c_char, c_int, *const c_char, *const c_char, ...);

    #[test]
    fn messages_are_formatted_as_printf_does() {
        let log =
            Log::new(|letter, reference| (letter == b'r' && reference == 12).then(|| "force".to_owned()));
        // SAFETY: it is what the FMU takes it for.
        let logger: Variadic = unsafe { transmute(callback()) };
        // SAFETY: format and arguments fit.
        unsafe {
            logger(&log, c"one".as_ptr(), 3, c"error".as_ptr(), c"%s".as_ptr(), c"plain 100 %".as_ptr());
            #[cfg(all(target_arch = "x86_64", target_os = "linux"))]
            logger(
                &log,
                c"one".as_ptr(),
                1,
                c"warning".as_ptr(),
                c"#r12# %d %.3f %s %d %d %d %.1f %.1f %.1f %.1f %.1f %.1f %.1f %.1f %.1f".as_ptr(),
                -7,
                2.5_f64,
                c"text".as_ptr(),
                2,
                3,
                4,
                0.1_f64,
                0.2_f64,
                0.3_f64,
                0.4_f64,
                0.5_f64,
                0.6_f64,
                0.7_f64,
                0.8_f64,
                0.9_f64,
            );
            logger(std::ptr::null(), c"one".as_ptr(), 1, c"x".as_ptr(), c"nobody".as_ptr());
        }
        let messages = log.messages();
        assert_eq!(messages[0].text, "plain 100 %");
        assert_eq!(log.take_failure().as_deref(), Some("plain 100 %"));
        assert_eq!(log.take_failure(), None);
        #[cfg(all(target_arch = "x86_64", target_os = "linux"))]
        assert_eq!(messages[1].text, "force -7 2.500 text 2 3 4 0.1 0.2 0.3 0.4 0.5 0.6 0.7 0.8 0.9");
    }

    #[test]
    fn a_flood_of_messages_takes_no_memory() {
        let log = Log::default();
        let long = "x".repeat(1 << 20);
        for round in 0..1000 {
            log.push(Status::Ok, "all", &format!("{round} {long}"));
        }
        assert_eq!(log.messages().len(), KEPT);
        assert_eq!(log.forgotten(), 800);
        assert!(log.messages().iter().map(|message| message.text.len()).sum::<usize>() <= KEPT * LONGEST);
        for _ in 0..1000 {
            log.push(Status::Ok, "all", "the same");
        }
        assert_eq!(log.messages().last().unwrap().times, 1000);
    }

    #[test]
    fn placeholders_that_mean_nothing_stay() {
        let log = Log::default();
        log.push(Status::Ok, "all", "50 # ## #r1# #x#");
        assert_eq!(log.messages()[0].text, "50 # # #r1# #x#");
    }
}
