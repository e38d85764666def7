//! Linear slaves, exact for inputs that are held or run linearly, with whatever abilities a test wants.

use nalgebra::{DMatrix, DVector};
use stickslip::cosim::{Abilities, Causality, Kind, Setup, Severity, Slave, SlaveError, Stepped, Variable};

pub const EVERYTHING: Abilities = Abilities {
    saves_state: true,
    variable_step: true,
    interpolates_inputs: true,
    input_derivative_order: 1,
    output_derivative_order: 2,
    directional_derivatives: true,
};

/// `ẋ = A x + B u`, `y = C x + D u`.
#[derive(Debug)]
pub struct Linear {
    name: String,
    table: Vec<Variable>,
    pub abilities: Abilities,
    matrices: [DMatrix<f64>; 4],
    start: DVector<f64>,
    state: State,
    saved: Vec<Option<State>>,
    /// Steps beyond this (s) are given up half way.
    pub longest: f64,
    /// Fails in the step that reaches this time (s).
    pub fails_at: f64,
}

#[derive(Debug, Clone)]
struct State {
    x: DVector<f64>,
    u: DVector<f64>,
    slope: DVector<f64>,
}

impl Linear {
    /// Inputs and outputs by name and unit; matrices row by row; `x` the start.
    pub fn new(
        name: &str,
        inputs: &[(&str, &str)],
        outputs: &[(&str, &str)],
        [a, b, c, d]: [&[f64]; 4],
        x: &[f64],
    ) -> Self {
        let (n, m, p) = (x.len(), inputs.len(), outputs.len());
        let d = DMatrix::from_row_slice(p, m, d);
        let row = |causality, (name, unit): &(&str, &str), depends_on| Variable {
            name: (*name).into(),
            reference: 0,
            kind: Kind::Real,
            causality,
            unit: Some((*unit).into()),
            start: None,
            depends_on,
        };
        let mut table: Vec<Variable> =
            inputs.iter().map(|input| row(Causality::Input, input, None)).collect();
        for (index, output) in outputs.iter().enumerate() {
            let on = (0..m).filter(|input| d[(index, *input)] != 0.0).collect();
            table.push(row(Causality::Output, output, Some(on)));
        }
        let state =
            State { x: DVector::from_column_slice(x), u: DVector::zeros(m), slope: DVector::zeros(m) };
        Self {
            name: name.to_owned(),
            table,
            abilities: EVERYTHING,
            matrices: [
                DMatrix::from_row_slice(n, n, a),
                DMatrix::from_row_slice(n, m, b),
                DMatrix::from_row_slice(p, n, c),
                d,
            ],
            start: state.x.clone(),
            state,
            saved: Vec::new(),
            longest: f64::INFINITY,
            fails_at: f64::INFINITY,
        }
    }

    pub fn with(self, abilities: Abilities) -> Self {
        Self { abilities, ..self }
    }

    /// Does not tell what its outputs depend on.
    pub fn silent(mut self) -> Self {
        self.table.iter_mut().for_each(|row| row.depends_on = None);
        self
    }

    /// All its variables are true or false.
    pub fn of_truths(mut self) -> Self {
        self.table.iter_mut().for_each(|row| row.kind = Kind::Boolean);
        self
    }

    pub fn boxed(self) -> Box<dyn Slave> {
        Box::new(self)
    }

    fn error(&self, message: &str) -> SlaveError {
        SlaveError { slave: self.name.clone(), message: message.to_owned(), severity: Severity::Slave }
    }

    /// Value of row `variable` of the table.
    fn value(&self, variable: usize) -> f64 {
        let [_, _, c, d] = &self.matrices;
        match variable.checked_sub(self.state.u.len()) {
            None => self.state.u[variable],
            Some(output) => (c.row(output) * &self.state.x)[0] + (d.row(output) * &self.state.u)[0],
        }
    }
}

/// exp(A h) for A of the inputs' motion as well: `x` after `h` where `u` runs from `u` with `slope`.
fn advance([a, b, ..]: &[DMatrix<f64>; 4], state: &State, h: f64) -> DVector<f64> {
    let (n, m) = (state.x.len(), state.u.len());
    let mut big = DMatrix::zeros(n + 2 * m, n + 2 * m);
    big.view_mut((0, 0), (n, n)).copy_from(a);
    big.view_mut((0, n), (n, m)).copy_from(b);
    big.view_mut((n, n + m), (m, m)).fill_with_identity();
    let mut all = DVector::zeros(n + 2 * m);
    all.rows_mut(0, n).copy_from(&state.x);
    all.rows_mut(n, m).copy_from(&state.u);
    all.rows_mut(n + m, m).copy_from(&state.slope);
    ((big * h).exp() * all).rows(0, n).into_owned()
}

impl Slave for Linear {
    fn name(&self) -> &str {
        &self.name
    }

    fn variables(&self) -> &[Variable] {
        &self.table
    }

    fn abilities(&self) -> Abilities {
        self.abilities
    }

    fn set_up(&mut self, _: Setup) -> Result<(), SlaveError> {
        self.state.x = self.start.clone();
        Ok(())
    }

    fn set(&mut self, variables: &[usize], values: &[f64]) -> Result<(), SlaveError> {
        for (variable, value) in variables.iter().zip(values) {
            if value.abs() > 1e30 || value.is_nan() {
                let name = &self.table[*variable].name;
                return Err(self.error(&format!("{name} = {value:e} is refused")));
            }
            self.state.u[*variable] = *value;
        }
        Ok(())
    }

    fn get(&mut self, variables: &[usize], values: &mut [f64]) -> Result<(), SlaveError> {
        for (variable, value) in variables.iter().zip(values) {
            *value = self.value(*variable);
        }
        Ok(())
    }

    fn set_input_derivatives(
        &mut self,
        variables: &[usize],
        order: u32,
        derivatives: &[f64],
    ) -> Result<(), SlaveError> {
        assert!(self.abilities.interpolates_inputs && order == 1);
        for (variable, derivative) in variables.iter().zip(derivatives) {
            self.state.slope[*variable] = *derivative;
        }
        Ok(())
    }

    fn output_derivatives(
        &mut self,
        variables: &[usize],
        order: u32,
        derivatives: &mut [f64],
    ) -> Result<(), SlaveError> {
        assert!(order >= 1 && order <= self.abilities.output_derivative_order);
        let [a, b, c, d] = &self.matrices;
        let State { x, u, slope } = &self.state;
        let first = a * x + b * u;
        let all = if order == 1 { c * first + d * slope } else { c * (a * first + b * slope) };
        for (variable, derivative) in variables.iter().zip(derivatives) {
            *derivative = all[variable - u.len()];
        }
        Ok(())
    }

    fn directional_derivative(
        &mut self,
        unknowns: &[usize],
        knowns: &[usize],
        direction: &[f64],
        change: &mut [f64],
    ) -> Result<(), SlaveError> {
        assert!(self.abilities.directional_derivatives);
        let d = &self.matrices[3];
        for (unknown, change) in unknowns.iter().zip(change) {
            let row = unknown - self.state.u.len();
            *change = knowns.iter().zip(direction).map(|(known, part)| d[(row, *known)] * part).sum();
        }
        Ok(())
    }

    fn do_step(&mut self, time: f64, step: f64) -> Result<Stepped, SlaveError> {
        if time + step > self.fails_at {
            return Err(self.error("velocity is beyond all bounds"));
        }
        if step > self.longest {
            return Ok(Stepped::Discarded(time + 0.5 * step));
        }
        self.state.x = advance(&self.matrices, &self.state, step);
        let slope = self.state.slope.clone();
        self.state.u += slope * step;
        // For one step only. What it was is needed for output derivatives.
        if !self.abilities.interpolates_inputs {
            self.state.slope.fill(0.0);
        }
        Ok(Stepped::Done)
    }

    fn save(&mut self, slot: usize) -> Result<(), SlaveError> {
        assert!(self.abilities.saves_state);
        if self.saved.len() <= slot {
            self.saved.resize(slot + 1, None);
        }
        self.saved[slot] = Some(self.state.clone());
        Ok(())
    }

    fn restore(&mut self, slot: usize) -> Result<(), SlaveError> {
        match self.saved.get(slot) {
            Some(Some(state)) => self.state = state.clone(),
            _ => return Err(self.error("nothing was saved there")),
        }
        Ok(())
    }

    fn terminate(&mut self) -> Result<(), SlaveError> {
        Ok(())
    }
}

/// Two masses, each on a spring and damper, joined by another: the first takes the force of the joint, the second holds
/// the joint and takes the motion of the first.
#[derive(Debug, Clone, Copy)]
pub struct TwoMasses {
    pub mass: [f64; 2],
    pub stiffness: [f64; 2],
    pub damping: [f64; 2],
    pub joint_stiffness: f64,
    pub joint_damping: f64,
    pub start: [f64; 4],
}

pub const TWO_MASSES: TwoMasses = TwoMasses {
    mass: [1.0, 0.5],
    stiffness: [10.0, 20.0],
    damping: [0.1, 0.2],
    joint_stiffness: 30.0,
    joint_damping: 0.4,
    start: [0.1, 0.3, -0.2, 0.5],
};

impl TwoMasses {
    /// Displacement and velocity of both after `time`.
    pub fn exact(&self, time: f64) -> [f64; 4] {
        let ([m1, m2], [k1, k2], [c1, c2]) = (self.mass, self.stiffness, self.damping);
        let (k, c) = (self.joint_stiffness, self.joint_damping);
        #[rustfmt::skip]
        let a = DMatrix::from_row_slice(4, 4, &[
            0.0, 1.0, 0.0, 0.0,
            -(k1 + k) / m1, -(c1 + c) / m1, k / m1, c / m1,
            0.0, 0.0, 0.0, 1.0,
            k / m2, c / m2, -(k2 + k) / m2, -(c2 + c) / m2,
        ]);
        let end = (a * time).exp() * DVector::from_column_slice(&self.start);
        [end[0], end[1], end[2], end[3]]
    }

    /// The first mass, and the second with the joint.
    pub fn slaves(&self) -> [Linear; 2] {
        let ([m1, m2], [k1, k2], [c1, c2]) = (self.mass, self.stiffness, self.damping);
        let (k, c) = (self.joint_stiffness, self.joint_damping);
        let first = Linear::new(
            "first",
            &[("force", "N")],
            &[("displacement", "m"), ("velocity", "m/s")],
            [&[0.0, 1.0, -k1 / m1, -c1 / m1], &[0.0, -1.0 / m1], &[1.0, 0.0, 0.0, 1.0], &[0.0; 2]],
            &self.start[..2],
        );
        let second = Linear::new(
            "second",
            &[("displacement", "m"), ("velocity", "m/s")],
            &[("force", "N"), ("position", "m"), ("rate", "m/s")],
            [
                &[0.0, 1.0, -(k2 + k) / m2, -(c2 + c) / m2],
                &[0.0, 0.0, k / m2, c / m2],
                &[-k, -c, 1.0, 0.0, 0.0, 1.0],
                &[k, c, 0.0, 0.0, 0.0, 0.0],
            ],
            &self.start[2..],
        );
        [first, second]
    }
}

/// `first` and `second` joined; reported: the first's motion, the second's displacement.
pub fn joined(slaves: [Linear; 2]) -> stickslip::cosim::System {
    let mut system = stickslip::cosim::System::new();
    for slave in slaves {
        system.add(slave.boxed()).unwrap();
    }
    system.connect(("first", "displacement"), ("second", "displacement"), 1.0, 0.0).unwrap();
    system.connect(("first", "velocity"), ("second", "velocity"), 1.0, 0.0).unwrap();
    system.connect(("second", "force"), ("first", "force"), 1.0, 0.0).unwrap();
    for (slave, variable) in [("first", "displacement"), ("first", "velocity"), ("second", "position")] {
        system.observe(slave, variable).unwrap();
    }
    system
}
