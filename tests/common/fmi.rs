//! Slaves under inputs that are sums of waves.

use stickslip::fmi::{Causality, Instance, Setup, Variability, VariableType};

pub const JENKINS: &str = include_str!("../../modelDescription/JenkinsContact.toml");
pub const VALANIS: &str = include_str!("../../modelDescription/ValanisContact.toml");
pub const SLIP_SLAP: &str = include_str!("../../modelDescription/SlipSlapContact.toml");
pub const MODAL: &str = include_str!("../../modelDescription/ModalBeam.toml");
pub const TWO_CONTACTS: &str = include_str!("../../modelDescription/ModalBeamTwoContacts.toml");
pub const FRICTIONAL: &str = include_str!("../../modelDescription/FrictionalBeam.toml");
pub const PIN_RIG: &str = include_str!("../../examples/slip-slap/model.toml");
pub const OSCILLATOR: &str = include_str!("../../examples/friction-vibration/model.toml");

/// A contact with every effect whose force is smooth between events.
pub const CHANGED: &str = "schema = \"stickslip.model/1\"\nkind = \"contact\"\n\n[contact]\nlaw = \"jenkins\"\n\
    tangential_stiffness = 5e6\nfriction_coefficient = 0.5\nnormal_load = 150.0\n\n\
    [[effect]]\nid = \"micro_slip\"\nspread = 0.6\n\n[[effect]]\nid = \"contact_damping\"\ndamping = 400.0\n\n\
    [[effect]]\nid = \"normal_load_variation\"\nload_gain = 0.8\n";

/// Amplitude, angular frequency, phase and mean of each input.
pub type Waves<'a> = &'a [(&'a str, [f64; 4])];

/// A model, a step, a number of steps, the tolerance of the slave, and its inputs.
pub struct Case<'a> {
    pub name: &'a str,
    pub model: String,
    pub step: f64,
    pub steps: usize,
    pub tolerance: f64,
    /// Half the span of differences, relative to the amplitudes.
    pub span: f64,
    pub waves: Waves<'a>,
}

pub const OF_A_CONTACT: Waves = &[
    ("displacement", [4e-5, 300.0, 0.0, 0.0]),
    ("velocity", [4e-5 * 300.0, 300.0, 1.57, 0.0]),
    ("normal_load", [60.0, 170.0, 0.3, 140.0]),
];
pub const OF_SLIP_AND_SLAP: Waves = &[
    ("displacement", [4e-5, 300.0, 0.0, 0.0]),
    ("velocity", [4e-5 * 300.0, 300.0, 1.57, 0.0]),
    ("opening", [5e-6, 170.0, 0.3, 0.0]),
    ("opening_velocity", [5e-6 * 170.0, 170.0, 0.3 + 1.57, 0.0]),
];
pub const OF_A_BEAM: Waves =
    &[("excitation", [20.0, 330.0, 0.2, 0.0]), ("contact_force", [60.0, 200.0, 0.0, 10.0])];
pub const OF_TWO_CONTACTS: Waves = &[
    ("excitation", [20.0, 330.0, 0.2, 0.0]),
    ("contact_force", [60.0, 200.0, 0.0, 10.0]),
    ("contact_force:x=0.3", [8.0, 260.0, 0.9, -3.0]),
];
pub const OF_A_FRICTIONAL_BEAM_WITH_ANOTHER: Waves = &[
    ("excitation", [30.0, 330.0, 0.2, 0.0]),
    ("normal_load", [40.0, 90.0, 0.0, 140.0]),
    ("contact_force:x=0.2", [8.0, 260.0, 0.9, -3.0]),
];
pub const OF_A_FRICTIONAL_BEAM: Waves =
    &[("excitation", [30.0, 330.0, 0.2, 0.0]), ("normal_load", [40.0, 90.0, 0.0, 140.0])];
pub const OF_AN_OSCILLATOR: Waves = &[
    ("excitation:m1", [0.4, 0.54, 0.0, 0.0]),
    ("excitation:m2", [0.1, 1.3, 0.0, 0.0]),
    ("normal_load", [0.3, 0.2, 0.0, 1.0]),
];
pub const OF_A_PIN_RIG: Waves = &[("excitation", [400.0, 400.0, 0.2, 0.0])];

pub fn cases() -> Vec<Case<'static>> {
    let case = |name, model: &str, (step, steps, tolerance), waves| Case {
        name,
        model: model.to_owned(),
        step,
        steps,
        tolerance,
        // Wider than the errors of a controlled step.
        span: if tolerance < 1e-9 { 1e-3 } else { 1e-5 },
        waves,
    };
    let gradual = |text: &str, stiffness: &str| {
        let law = format!("law = \"valanis\"\ntangential_stiffness = {stiffness}\nsmoothness = 0.4\n");
        text.replace("law = \"jenkins\"\n", &law).replace("tangential_stiffness = 0.2 ", "# ")
    };
    let valanis = SLIP_SLAP.replace("\"jenkins\"", "\"valanis\"\nsmoothness = 0.4").replace("hertz", "cubic");
    let valanis = valanis.replace("normal_exponent = 1.5", "normal_cubic_stiffness = 1e18");
    let stiff = FRICTIONAL
        .replace("law = \"valanis\"", "law = \"jenkins\"")
        .replace("smoothness = 0.3\n", "")
        .replace("residual_stiffness = 0.0 ", "# ");
    // With drag, stretching and a mass that hangs, too.
    let another = format!(
        "{FRICTIONAL}\n[[contact_point]]\nposition = 0.2\n\n[[effect]]\nid = \"quadratic_damping\"\n\
         quadratic_damping = 3.0\n\n[[effect]]\nid = \"geometric_stiffening\"\ncubic_stiffness = 1e8\n\n\
         [[effect]]\nid = \"hanging_mass\"\nmass = 0.05\nhanging_frequency = 45.0\n"
    );
    vec![
        case("Jenkins", JENKINS, (1e-3, 40, 1e-6), OF_A_CONTACT),
        case("Valanis", VALANIS, (1e-3, 40, 1e-6), OF_A_CONTACT),
        case("effects", CHANGED, (1e-3, 40, 1e-6), OF_A_CONTACT),
        case("ModalBeam", MODAL, (5e-4, 30, 1e-11), OF_A_BEAM),
        case("two contacts", TWO_CONTACTS, (5e-4, 30, 1e-11), OF_TWO_CONTACTS),
        case("FrictionalBeam", FRICTIONAL, (5e-4, 30, 1e-11), OF_A_FRICTIONAL_BEAM),
        case("FrictionalBeam, Jenkins", &stiff, (5e-4, 30, 1e-11), OF_A_FRICTIONAL_BEAM),
        case("FrictionalBeam, another", &another, (5e-4, 30, 1e-11), OF_A_FRICTIONAL_BEAM_WITH_ANOTHER),
        case("Oscillator", OSCILLATOR, (0.4, 60, 1e-6), OF_AN_OSCILLATOR),
        case("Oscillator, Valanis", &gradual(OSCILLATOR, "0.2"), (0.4, 60, 1e-6), OF_AN_OSCILLATOR),
        case("slip and slap", SLIP_SLAP, (1e-3, 40, 1e-6), OF_SLIP_AND_SLAP),
        case("slip and slap, Valanis", &valanis, (1e-3, 40, 1e-6), OF_SLIP_AND_SLAP),
    ]
}

/// An instance on its way.
pub struct Run<'a> {
    pub case: &'a Case<'a>,
    pub instance: Instance,
    pub inputs: Vec<u32>,
    pub outputs: Vec<u32>,
    /// So many inputs get their derivatives.
    pub sloped: usize,
}

impl<'a> Run<'a> {
    pub fn new(case: &'a Case<'a>) -> Self {
        let mut run = Self::at_initialization(case);
        run.instance.exit_initialization().unwrap();
        run
    }

    /// Before the end of the initialization, with the inputs set.
    pub fn at_initialization(case: &'a Case<'a>) -> Self {
        let instance = Instance::new(&case.model).unwrap_or_else(|error| panic!("{}: {error}", case.name));
        let description = instance.description();
        let inputs: Vec<u32> =
            case.waves.iter().map(|(name, _)| description.reference(name).expect(name)).collect();
        let continuous = |row: &u32| {
            let row = &description.variables[*row as usize];
            (row.variable_type, row.variability()) == (VariableType::Real, Variability::Continuous)
        };
        let outputs = description.references(Causality::Output).filter(continuous).collect();
        let sloped = inputs.len();
        let mut run = Self { case, instance, inputs, outputs, sloped };
        let setup = Setup { tolerance: Some(case.tolerance), start: 0.0, stop: None };
        run.instance.set_up(setup).unwrap();
        run.instance.enter_initialization().unwrap();
        run.set(&run.waves(0.0, 0));
        run
    }

    /// Inputs at `time` (s), or their derivatives of `order`.
    pub fn waves(&self, time: f64, order: i32) -> Vec<f64> {
        let wave = |[amplitude, omega, phase, mean]: [f64; 4]| {
            let angle = omega * time + phase + f64::from(order) * std::f64::consts::FRAC_PI_2;
            amplitude * omega.powi(order) * angle.sin() + if order == 0 { mean } else { 0.0 }
        };
        self.case.waves.iter().map(|(_, numbers)| wave(*numbers)).collect()
    }

    /// The lowest value of an input.
    pub fn lowest(&self, input: usize) -> f64 {
        let row = &self.instance.description().variables[self.inputs[input] as usize];
        row.allowed_range().0.unwrap_or(f64::NEG_INFINITY)
    }

    pub fn set(&mut self, values: &[f64]) {
        self.instance.set_real(&self.inputs, values).unwrap();
    }

    pub fn slope(&mut self, slopes: &[f64]) {
        let inputs = &self.inputs[..self.sloped];
        self.instance.set_input_derivatives(inputs, &vec![1; self.sloped], &slopes[..self.sloped]).unwrap();
    }

    /// Leaves the normal load of a frictional beam held: under one that runs, the beam's own steps follow the path of
    /// displacement and load to a hundred-thousandth of the limit only, and differences show that.
    pub fn with_loads_held(mut self) -> Self {
        if self.case.name.starts_with("FrictionalBeam") {
            self.sloped = 1;
        }
        self
    }

    pub fn step(&mut self, k: usize) {
        self.instance.do_step(k as f64 * self.case.step, self.case.step).unwrap();
    }

    pub fn read(&mut self) -> Vec<f64> {
        let mut values = vec![0.0; self.outputs.len()];
        self.instance.get_real(&self.outputs, &mut values).unwrap();
        values
    }

    pub fn rates(&mut self) -> Vec<f64> {
        let mut rates = vec![0.0; self.outputs.len()];
        self.instance.output_derivatives(&self.outputs, &vec![1; self.outputs.len()], &mut rates).unwrap();
        rates
    }

    pub fn changes(&mut self, input: usize) -> Vec<f64> {
        let mut changes = vec![0.0; self.outputs.len()];
        let known = [self.inputs[input]];
        self.instance.directional_derivative(&self.outputs, &known, &[1.0], &mut changes).unwrap();
        changes
    }

    pub fn name(&self, output: usize) -> &str {
        &self.instance.description().variables[self.outputs[output] as usize].name
    }
}
