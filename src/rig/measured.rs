//! What a test gives before the sensors spoil it.

/// Channels as the sensors would show them without faults other than their delays, and what the contact did.
pub(super) struct Measured {
    pub time: Vec<f64>,
    /// Force of the shaker (N); `None` where it is disconnected.
    pub excitation: Option<Vec<f64>>,
    /// Of each accelerometer (m/s²).
    pub accelerations: Vec<Vec<f64>>,
    /// `None` for a beam without a contact.
    pub contact: Option<ContactSamples>,
}

/// A contact's own displacement (m), velocity (m/s) and restoring force (N) at the times of the record, not delayed.
#[derive(Default)]
pub(super) struct ContactSamples {
    pub displacement: Vec<f64>,
    pub velocity: Vec<f64>,
    pub force: Vec<f64>,
    /// Of a contact in two directions.
    pub normal: Option<NormalSamples>,
}

/// Normal displacement (m), positive where it closes the contact, and normal load (N).
pub(super) struct NormalSamples {
    pub displacement: Vec<f64>,
    pub load: Vec<f64>,
}
