//! What no program in C can show.

use crate::guard::{Status, guarded, text};
use crate::object::Object;
use std::ffi::CStr;

const CONTACT: &str = "schema = \"stickslip.model/1\"\nkind = \"contact\"\n[contact]\nlaw = \"jenkins\"\n\
                       tangential_stiffness = 2e6\nfriction_coefficient = 0.5\nnormal_load = 100.0\n";

fn error_text() -> String {
    // SAFETY: a text of this thread, read at once.
    unsafe { CStr::from_ptr(text()) }.to_string_lossy().into_owned()
}

#[test]
fn a_panic_ends_in_a_status_and_breaks_the_one_model_it_happened_in() {
    let model = Object::new(CONTACT).unwrap();
    let other = model.copy().unwrap();
    let status = guarded(|| {
        let _running = model.lock()?;
        panic!("out of luck")
    });
    assert_eq!(status, Status::Broken);
    assert!(error_text().contains("tests.rs") && error_text().ends_with("out of luck"), "{}", error_text());
    assert_eq!(guarded(|| model.lock().map(drop)), Status::Broken);
    assert!(error_text().contains("free it"));
    assert_eq!(guarded(|| other.lock()?.start(None, 0.0)), Status::Ok);
}
