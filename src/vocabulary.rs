//! The project's one vocabulary: FMI variables, model-file keys and CSV columns that mean the same
//! quantity have the same name, unit, description and bounds, and take them from here.

/// A named physical quantity with its SI unit and bounds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Quantity {
    /// The name in FMI variables, model files and CSV headers.
    pub name: &'static str,
    /// SI unit as FMI and the CSV headers spell it, e.g. `N/m`; `1` for a plain number.
    pub unit: &'static str,
    /// One line for an engineer.
    pub description: &'static str,
    /// Smallest legal value, if any.
    pub min: Option<f64>,
    /// Largest legal value, if any.
    pub max: Option<f64>,
    /// Typical size, for scaling.
    pub nominal: f64,
    /// The bounds themselves are not legal values (`0 < mass`), in which case `min`/`max` are open.
    pub open: bool,
}

/// In which measure a parameter is stepped and its interval is symmetric.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Scale {
    /// As it is.
    #[default]
    Linear,
    /// By its logarithm: positive parameters known by order of magnitude.
    Logarithmic,
}

macro_rules! vocabulary {
    ($($id:ident = $name:literal [$unit:literal] $min:expr, $max:expr, $open:literal, $nominal:literal, $text:literal;)*) => {
        $(
            #[doc = concat!($text, " (", $unit, ").")]
            pub const $id: Quantity = Quantity {
                name: $name, unit: $unit, description: $text,
                min: $min, max: $max, open: $open, nominal: $nominal,
            };
        )*
        /// Every quantity, in the order of this file.
        pub const ALL: &[Quantity] = &[$($id),*];
    };
}

vocabulary! {
    // Contact: inputs and outputs.
    DISPLACEMENT = "displacement" ["m"] None, None, false, 1e-5, "Relative tangential displacement at the contact";
    VELOCITY = "velocity" ["m/s"] None, None, false, 1e-2, "Relative tangential velocity at the contact";
    NORMAL_LOAD = "normal_load" ["N"] None, None, false, 100.0, "Normal load on the contact; at zero or below the bodies are apart";
    NORMAL_DISPLACEMENT = "normal_displacement" ["m"] None, None, false, 1e-5, "Relative normal displacement at the contact";
    FORCE = "force" ["N"] None, None, false, 100.0, "Restoring contact force, positive when it resists positive displacement";
    DISSIPATED_ENERGY = "dissipated_energy" ["J"] Some(0.0), None, false, 1e-3, "Energy dissipated in the contact since the start";
    SLIP_STATE = "slip_state" ["1"] Some(0.0), Some(2.0), false, 1.0, "0 stick, 1 slip, 2 separated";
    SLIP_FRACTION = "slip_fraction" ["1"] Some(0.0), Some(1.0), false, 1.0, "Share of the sliders that slip, by stiffness: 0 all stick, 1 none does";
    // Contact in two directions.
    OPENING = "opening" ["m"] None, None, false, 1e-6, "Relative normal displacement at the contact, positive where it opens; 0 at rest under the normal load";
    OPENING_VELOCITY = "opening_velocity" ["m/s"] None, None, false, 1e-3, "Relative normal velocity at the contact, positive where it opens";
    OPENING_FORCE = "opening_force" ["N"] None, None, false, 100.0, "Restoring normal force, positive when it resists opening: the load at rest less the contact's normal force";
    NORMAL_FORCE = "normal_force" ["N"] Some(0.0), None, false, 100.0, "Normal force in the contact, by which the bodies press on each other; 0 where they are apart";
    SEPARATION = "separation" ["m"] Some(0.0), None, false, 1e-6, "Distance between the bodies; 0 in contact";
    IMPACT_ENERGY = "impact_energy" ["J"] Some(0.0), None, false, 1e-3, "Energy dissipated by impact damping since the start";
    // Contact: parameters.
    TANGENTIAL_STIFFNESS = "tangential_stiffness" ["N/m"] Some(0.0), None, true, 1e6, "Tangential stiffness in stick (e0 of the Valanis law)";
    FRICTION_COEFFICIENT = "friction_coefficient" ["1"] Some(0.0), None, true, 0.5, "Coefficient of friction; the friction limit is its product with the normal load";
    SMOOTHNESS = "smoothness" ["1"] Some(0.0), Some(1.0), true, 0.5, "Kappa of the Valanis law, from 0 (included: most gradual slip) to 1 (excluded: would be Jenkins)";
    RESIDUAL_STIFFNESS = "residual_stiffness" ["N/m"] Some(0.0), None, false, 1e5, "Slope left in macro-slip (e_t of the Valanis law), below the tangential stiffness";
    EXPONENT = "exponent" ["1"] Some(-1.0), None, true, 0.5, "Chi of the four-parameter Iwan law, above -1 and at most 0: the energy lost in small loops grows with the power chi + 3 of the amplitude";
    RATIO = "ratio" ["1"] Some(0.0), None, false, 1.0, "Beta of the four-parameter Iwan law: stiffness of the sliders that yield last, all at once, over that of all others";
    SHARPNESS = "sharpness" ["1"] Some(1.0), Some(50.0), false, 2.0, "Exponent of Bouc and Wen's law: slip sets in most gradually at 1, and at a corner as it grows";
    UNLOADING_RATIO = "unloading_ratio" ["1"] Some(1.0), Some(2.0), false, 1.0, "Slope on reversal from slip over that in stick: 1 unloads along a straight line; in Bouc and Wen's law beta/gamma is ratio/(2 - ratio)";
    SLOPE_KEPT_1 = "slope_kept_1" ["1"] Some(0.0), Some(1.0), false, 1.0, "Measured loading curve: slope after knot 1 of 12, at 1.5^-11 of its range, over that before";
    SLOPE_KEPT_2 = "slope_kept_2" ["1"] Some(0.0), Some(1.0), false, 1.0, "Measured loading curve: slope after knot 2 of 12, at 1.5^-10 of its range, over that before";
    SLOPE_KEPT_3 = "slope_kept_3" ["1"] Some(0.0), Some(1.0), false, 1.0, "Measured loading curve: slope after knot 3 of 12, at 1.5^-9 of its range, over that before";
    SLOPE_KEPT_4 = "slope_kept_4" ["1"] Some(0.0), Some(1.0), false, 1.0, "Measured loading curve: slope after knot 4 of 12, at 1.5^-8 of its range, over that before";
    SLOPE_KEPT_5 = "slope_kept_5" ["1"] Some(0.0), Some(1.0), false, 1.0, "Measured loading curve: slope after knot 5 of 12, at 1.5^-7 of its range, over that before";
    SLOPE_KEPT_6 = "slope_kept_6" ["1"] Some(0.0), Some(1.0), false, 1.0, "Measured loading curve: slope after knot 6 of 12, at 1.5^-6 of its range, over that before";
    SLOPE_KEPT_7 = "slope_kept_7" ["1"] Some(0.0), Some(1.0), false, 1.0, "Measured loading curve: slope after knot 7 of 12, at 1.5^-5 of its range, over that before";
    SLOPE_KEPT_8 = "slope_kept_8" ["1"] Some(0.0), Some(1.0), false, 1.0, "Measured loading curve: slope after knot 8 of 12, at 1.5^-4 of its range, over that before";
    SLOPE_KEPT_9 = "slope_kept_9" ["1"] Some(0.0), Some(1.0), false, 1.0, "Measured loading curve: slope after knot 9 of 12, at 1.5^-3 of its range, over that before";
    SLOPE_KEPT_10 = "slope_kept_10" ["1"] Some(0.0), Some(1.0), false, 1.0, "Measured loading curve: slope after knot 10 of 12, at 1.5^-2 of its range, over that before";
    SLOPE_KEPT_11 = "slope_kept_11" ["1"] Some(0.0), Some(1.0), false, 1.0, "Measured loading curve: slope after knot 11 of 12, at 1.5^-1 of its range, over that before";
    // Beam: parameters.
    LENGTH = "length" ["m"] Some(0.0), None, true, 1.0, "Length of the beam from clamp to pin";
    WIDTH = "width" ["m"] Some(0.0), None, true, 0.05, "Width of the beam";
    THICKNESS = "thickness" ["m"] Some(0.0), None, true, 0.005, "Thickness of the beam in the direction of bending";
    DENSITY = "density" ["kg/m^3"] Some(0.0), None, true, 7850.0, "Mass density of the beam";
    YOUNGS_MODULUS = "youngs_modulus" ["Pa"] Some(0.0), None, true, 2e11, "Young's modulus of the beam";
    MODES = "modes" ["1"] Some(1.0), Some(40.0), false, 6.0, "Number of modes kept";
    PHASE = "phase" ["rad"] None, None, false, 1.0, "Phase of the first harmonic of the motion at the same place, ahead of the excitation";
    DAMPING_RATIO = "damping_ratio" ["1"] Some(0.0), Some(1.0), false, 0.003, "Modal damping ratio, one for all modes or one per mode";
    FREQUENCY_INTERVAL = "frequency_interval" ["Hz"] Some(0.0), None, true, 0.01, "Half of the 95 % interval of a resonance frequency";
    DAMPING_INTERVAL = "damping_interval" ["1"] Some(0.0), None, true, 1e-4, "Half of the 95 % interval of a damping ratio";
    WINDOW = "window" ["s"] Some(0.0), None, true, 0.5, "Length of the stretch of a free decay that a row of a table was taken from, its amplitude in the middle";
    MASS_DAMPING = "mass_damping" ["1/s"] Some(0.0), None, false, 1.0, "Mass-proportional damping";
    STIFFNESS_DAMPING = "stiffness_damping" ["s"] Some(0.0), None, false, 1e-5, "Stiffness-proportional damping";
    POSITION = "position" ["m"] Some(0.0), None, false, 0.5, "Distance from the clamp";
    MASS = "mass" ["kg"] Some(0.0), None, true, 0.01, "Mass fixed to the structure";
    OFFSET = "offset" ["m"] None, None, false, 0.006, "Distance of the contact's line of action from the neutral axis";
    ROTATIONAL_STIFFNESS = "rotational_stiffness" ["N.m/rad"] Some(0.0), None, false, 100.0, "Rotational spring at the pinned end";
    CLAMP_STIFFNESS = "clamp_stiffness" ["N.m/rad"] Some(0.0), None, true, 1e5, "Rotational spring in place of a rigid clamp";
    INERTIA = "inertia" ["kg.m^2"] Some(0.0), None, false, 1e-3, "Moment of inertia about its own axis";
    TANGENTIAL_LEVER = "tangential_lever" ["m"] None, None, false, 0.006, "Distance of the friction's line of action from the neutral axis of the beam";
    NORMAL_LEVER = "normal_lever" ["m"] None, None, false, 0.006, "Distance of the normal force's line of action from the end of the beam";
    STRING_STIFFNESS = "stiffness" ["N/m"] Some(0.0), None, true, 1e6, "Axial stiffness of the string that a mass hangs from";
    STRING_LENGTH = "length" ["m"] Some(0.0), None, true, 0.3, "Length of the string that a mass hangs from";
    // Oscillator: parameters.
    STIFFNESS = "stiffness" ["N/m"] Some(0.0), None, false, 1e4, "Stiffness of a spring";
    DAMPING = "damping" ["N.s/m"] Some(0.0), None, false, 1.0, "Damping of the damper beside a spring";
    NORMAL_STIFFNESS = "normal_stiffness" ["N/m"] Some(0.0), None, false, 1e7, "Normal stiffness of the contact, by which a measured normal displacement changes the normal load";
    NORMAL_EXPONENT = "normal_exponent" ["1"] Some(1.0), Some(2.0), false, 1.5, "Exponent p of Hertz' law in the normal direction: the normal force grows with the power p of the approach";
    // Effects: parameters.
    SPREAD = "spread" ["1"] Some(0.0), Some(1.0), false, 0.5, "Half-width of the distribution of yield displacements over its mean: 0 one slider, 1 slip from the first displacement on";
    LOAD_GAIN = "load_gain" ["1"] None, None, false, 1.0, "Fraction of the measured change of normal load that reaches the contact";
    WEAKENING = "weakening" ["1"] Some(-1.0), None, true, 0.3, "Excess of the friction limit at rest over that at high velocity, as a fraction of the latter";
    WEAKENING_VELOCITY = "weakening_velocity" ["m/s"] Some(0.0), None, true, 1e-3, "Relative velocity at which the excess of the friction limit has fallen to 1/e";
    RATE = "rate" ["1/m"] None, None, false, 1.0, "Relative change of the friction limit per metre of slip";
    CONTACT_DAMPING = "damping" ["N.s/m"] None, None, false, 1.0, "Damping of the damper beside the contact";
    HALF_GAP = "half_gap" ["m"] Some(0.0), None, false, 1e-5, "Half of the play in series with the contact";
    CUBIC_STIFFNESS = "cubic_stiffness" ["N/m^3"] None, None, false, 1e12, "Cubic stiffness: force over the third power of the displacement";
    ASYMMETRY = "asymmetry" ["1"] Some(-1.0), Some(1.0), true, 0.1, "Excess of the friction limit against positive slip, and lack against negative, as a fraction of their mean";
    QUADRATIC_DAMPING = "quadratic_damping" ["N.s^2/m^2"] None, None, false, 1.0, "Drag: force over the square of the velocity, against the motion";
    ADDED_MASS = "mass" ["kg"] None, None, false, 0.01, "Mass on the structure beside the model's, below zero where the model has too much";
    HANGING_FREQUENCY = "hanging_frequency" ["Hz"] Some(0.0), None, true, 10.0, "Natural frequency of the hanging mass on its string, the contact held";
    NORMAL_CUBIC_STIFFNESS = "normal_cubic_stiffness" ["N/m^3"] None, None, false, 1e15, "Cubic stiffness of the contact in the normal direction";
    IMPACT_DAMPING = "impact_damping" ["s/m"] None, None, false, 1.0, "Hunt-Crossley damping: relative change of the normal load per approach velocity";
    DELAY = "delay" ["s"] None, None, false, 1e-4, "Delay of a sensor's signal";
    CLOCK_ERROR = "clock_error" ["1"] Some(-0.1), Some(0.1), false, 1e-4, "Relative error of a sensor's clock: the signal at the time t since the record's start is that of t (1 + error)";
    GAIN = "gain" ["1"] Some(0.0), None, true, 1.0, "Reading of a sensor over the true value";
    BIAS = "bias" ["1"] None, None, false, 1.0, "Constant that a sensor adds, in the SI unit of its channel";
    BIAS_FORCE = "bias" ["N"] None, None, false, 1.0, "Constant that a force sensor adds";
    BIAS_DISPLACEMENT = "bias" ["m"] None, None, false, 1e-6, "Constant that a displacement sensor adds";
    BIAS_VELOCITY = "bias" ["m/s"] None, None, false, 1e-3, "Constant that a velocity sensor adds";
    BIAS_ACCELERATION = "bias" ["m/s^2"] None, None, false, 1.0, "Constant that an accelerometer adds";
    // Beam: inputs and outputs.
    EXCITATION = "excitation" ["N"] None, None, false, 1.0, "Force of the exciter on the structure";
    CONTACT_FORCE = "contact_force" ["N"] None, None, false, 100.0, "Restoring force of the contact on the beam, positive when it resists positive displacement";
    ACCELERATION = "acceleration" ["m/s^2"] None, None, false, 10.0, "Transverse acceleration of a sensor";
    // Records.
    TIME = "time" ["s"] None, None, false, 1.0, "Time";
    AMPLITUDE = "amplitude" ["m/s^2"] Some(0.0), None, true, 10.0, "Amplitude of the first harmonic of the acceleration at the excitation, held in the test";
    FREQUENCY = "frequency" ["Hz"] Some(0.0), None, true, 50.0, "Resonance frequency (phase resonance at the held amplitude)";
}

/// The quantity called `name`, if there is one.
///
/// ```
/// assert_eq!(stickslip::vocabulary::find("force").unwrap().unit, "N");
/// assert!(stickslip::vocabulary::find("farce").is_none());
/// ```
pub fn find(name: &str) -> Option<&'static Quantity> {
    ALL.iter().find(|quantity| quantity.name == name)
}
