//! What is beyond a measured map is said once, and the simulation goes on.

use super::fixture::*;
use crate::ffi::Status;

#[test]
fn a_contact_beyond_its_measured_table_says_so_once_and_goes_on() {
    let kept: String = (1..12).map(|k| format!("slope_kept_{k} = 0.8\n")).collect();
    let model =
        VALANIS.replace("valanis", "measured").replace("smoothness = 0.3\nresidual_stiffness = 1e5\n", &kept);
    let importer = Importer::new(&model);
    let running = importer.running();
    // The table ends where the force is the limit, of 50 N: far beyond 25 um and far below 1 mm.
    for (k, (displacement, status)) in [
        (5e-6, Status::Ok),
        (-5e-6, Status::Ok),
        (1e-3, Status::Warning),
        (2e-3, Status::Ok),
        (-2e-3, Status::Ok),
    ]
    .into_iter()
    .enumerate()
    {
        running.set(DISPLACEMENT, displacement);
        assert_eq!(running.do_step(k as f64, 1.0), status, "{displacement} m");
    }
    assert!((running.get(FORCE) + 50.0).abs() < 1e-6);
    let messages = importer.messages.lock().unwrap();
    assert_eq!(messages.len(), 1);
    let (status, category, text) = &messages[0];
    assert_eq!((*status, category.as_str()), (Status::Warning as i32, "logStatusWarning"));
    assert!(text.contains("at 3 s") && text.contains("`measured`"), "{text}");
}
