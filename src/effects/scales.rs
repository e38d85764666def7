//! Scales of a problem, by which the parameters of effects are bounded.

/// Magnitudes of the motion, the forces and the structure; all above zero.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scales {
    /// Largest relative displacement at the contact (m).
    pub displacement: f64,
    /// Largest relative velocity at the contact (m/s).
    pub velocity: f64,
    /// Longest way travelled by the contact in a record (m).
    pub travel: f64,
    /// Friction limit (N).
    pub limit: f64,
    /// Tangential stiffness in stick (N/m).
    pub stiffness: f64,
    /// Largest displacement of the structure where its nonlinearities act (m).
    pub structure_displacement: f64,
    /// Largest velocity there (m/s).
    pub structure_velocity: f64,
    /// Largest force on the structure (N).
    pub structure_force: f64,
    /// Mass of the structure (kg).
    pub structure_mass: f64,
    /// Bending stiffness of the structure against a rotation at the clamp (N m/rad).
    pub rotational_stiffness: f64,
    /// Typical frequency of the motion (Hz), of the record where it is highest.
    pub frequency: f64,
    /// The same of the record where it is lowest (Hz).
    pub lowest_frequency: f64,
    /// Time between samples (s).
    pub sample_step: f64,
    /// Standard deviation of the channel in question, in its SI unit.
    pub channel: f64,
    /// Largest normal displacement (m).
    pub normal_displacement: f64,
    /// Largest normal velocity (m/s).
    pub normal_velocity: f64,
    /// Normal load (N).
    pub normal_load: f64,
}

impl Default for Scales {
    /// Ones throughout.
    fn default() -> Self {
        Self {
            displacement: 1.0,
            velocity: 1.0,
            travel: 1.0,
            limit: 1.0,
            stiffness: 1.0,
            structure_displacement: 1.0,
            structure_velocity: 1.0,
            structure_force: 1.0,
            structure_mass: 1.0,
            rotational_stiffness: 1.0,
            frequency: 1.0,
            lowest_frequency: 1.0,
            sample_step: 1.0,
            channel: 1.0,
            normal_displacement: 1.0,
            normal_velocity: 1.0,
            normal_load: 1.0,
        }
    }
}
