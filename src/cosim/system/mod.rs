//! What is coupled to what: slaves, connections, start values, power connections; checked when they are made.
//!
//! ports.rs: variables of slaves and what is between them; power.rs: the power that passes, and the energy residual; unwatched.rs: where
//! none is known.

mod ports;
pub(in crate::cosim) mod power;
mod unwatched;

pub use ports::{Connection, Port, PowerConnection};
pub use unwatched::Unwatched;

use crate::cosim::slave::{Causality, Kind, Slave, Variable};

/// How a slave that cannot interpolate its inputs is given them where more than the first order is asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum InputRule {
    /// [`InputRule::End`] where every output of the slave depends on the input at once, as the slave itself declares,
    /// [`InputRule::Middle`] elsewhere.
    #[default]
    Auto,
    /// The value at the end of the step: for slaves that answer at once.
    End,
    /// The value at the middle of the step: for slaves that hold the input and integrate. Outputs that depend on it at
    /// once are corrected to the end of the step where the slave can save its state or give its derivatives.
    Middle,
}

/// Why a system cannot be what is asked for. Slaves and variables go by their names.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SystemError {
    /// Two slaves of one name.
    #[error("two slaves are called {slave}")]
    DuplicateSlave {
        /// The name.
        slave: String,
    },
    /// No such slave.
    #[error("the system has no slave {slave}")]
    UnknownSlave {
        /// What was asked for.
        slave: String,
    },
    /// No such variable.
    #[error("{slave} has no variable {variable}")]
    UnknownVariable {
        /// The slave.
        slave: String,
        /// What was asked for.
        variable: String,
    },
    /// Something is connected to what is not an input.
    #[error("{slave}.{variable} is not an input: nothing can be connected to it")]
    NotAnInput {
        /// The slave.
        slave: String,
        /// The variable.
        variable: String,
    },
    /// Something is fed from what is not an output.
    #[error("{slave}.{variable} is not an output: nothing can be fed from it")]
    NotAnOutput {
        /// The slave.
        slave: String,
        /// The variable.
        variable: String,
    },
    /// The two ends hold different kinds of numbers.
    #[error("{from} is {from_kind:?} and {to} is {to_kind:?}: they cannot be connected")]
    KindMismatch {
        /// Slave and variable at the beginning.
        from: String,
        /// Its kind.
        from_kind: Kind,
        /// Slave and variable at the end.
        to: String,
        /// Its kind.
        to_kind: Kind,
    },
    /// Units and gains are for Real inputs.
    #[error("the connection to {slave}.{variable} has a factor or an offset, but the input is not Real")]
    TransformedWholeNumber {
        /// The slave.
        slave: String,
        /// The variable.
        variable: String,
    },
    /// An input has two sources.
    #[error("{slave}.{variable} is fed from both {first} and {second}")]
    ConnectedTwice {
        /// The slave.
        slave: String,
        /// The input.
        variable: String,
        /// The source connected first.
        first: String,
        /// The other.
        second: String,
    },
    /// A start value for what the slave itself computes.
    #[error("{slave}.{variable} cannot be given a start value: the slave computes it")]
    NotSettable {
        /// The slave.
        slave: String,
        /// The variable.
        variable: String,
    },
    /// A factor, an offset or a start value is not a finite number.
    #[error("{slave}.{variable}: {what} = {value} is not a finite number")]
    NotFinite {
        /// The slave.
        slave: String,
        /// The variable.
        variable: String,
        /// Which number.
        what: &'static str,
        /// Its value.
        value: f64,
    },
    /// A declared power connection that is none.
    #[error("force {force} and motion {motion} are no power connection: {reason}")]
    Power {
        /// The input that takes the force.
        force: String,
        /// The input that takes the motion.
        motion: String,
        /// Why.
        reason: &'static str,
    },
    /// An order of slaves that does not name each once.
    #[error("the order of slaves must name each slave once; {slave} is named {times} times")]
    Order {
        /// The slave.
        slave: String,
        /// How often.
        times: usize,
    },
    /// Outputs and inputs that depend on each other at once, where that was not to be.
    #[error("algebraic loop: {}", .variables.join(" -> "))]
    AlgebraicLoop {
        /// The inputs of the loop, as `slave.variable`.
        variables: Vec<String>,
    },
    /// A number among the settings is not what it must be.
    #[error("{name} = {value:?} is refused; it must be {allowed}")]
    Setting {
        /// Which.
        name: &'static str,
        /// Its value.
        value: f64,
        /// What is allowed.
        allowed: &'static str,
    },
}

/// Slaves and how they are coupled.
///
/// ```
/// use stickslip::cosim::{Source, System};
///
/// let mut system = System::new();
/// system.add(Box::new(Source::new("exciter", "force", "N", |time| (300.0 * time).sin())))?;
/// assert!(system.connect(("exciter", "force"), ("beam", "excitation"), 1.0, 0.0).is_err());
/// # Ok::<(), stickslip::cosim::SystemError>(())
/// ```
#[derive(Debug, Default)]
pub struct System {
    pub(in crate::cosim) slaves: Vec<Box<dyn Slave>>,
    pub(in crate::cosim) rules: Vec<InputRule>,
    pub(in crate::cosim) connections: Vec<Connection>,
    pub(in crate::cosim) starts: Vec<(Port, f64)>,
    power: Vec<PowerConnection>,
    pub(in crate::cosim) observed: Vec<Port>,
}

impl System {
    /// A system without slaves.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a slave; the number counts from 0.
    ///
    /// # Errors
    /// [`SystemError::DuplicateSlave`].
    pub fn add(&mut self, slave: Box<dyn Slave>) -> Result<usize, SystemError> {
        if self.slaves.iter().any(|other| other.name() == slave.name()) {
            return Err(SystemError::DuplicateSlave { slave: slave.name().to_owned() });
        }
        self.slaves.push(slave);
        self.rules.push(InputRule::Auto);
        Ok(self.slaves.len() - 1)
    }

    /// The slaves, in the order in which they were added.
    pub fn slaves(&self) -> &[Box<dyn Slave>] {
        &self.slaves
    }

    /// The connections, in the order in which they were made.
    pub fn connections(&self) -> &[Connection] {
        &self.connections
    }

    /// The port called `variable` of the slave called `slave`.
    ///
    /// # Errors
    /// [`SystemError::UnknownSlave`], [`SystemError::UnknownVariable`].
    pub fn port(&self, slave: &str, variable: &str) -> Result<Port, SystemError> {
        let index = self.slave(slave)?;
        let mut table = self.slaves[index].variables().iter();
        match table.position(|row| *row.name == *variable) {
            Some(position) => Ok(Port { slave: index, variable: position }),
            None => {
                Err(SystemError::UnknownVariable { slave: slave.to_owned(), variable: variable.to_owned() })
            }
        }
    }

    fn slave(&self, name: &str) -> Result<usize, SystemError> {
        let found = self.slaves.iter().position(|slave| slave.name() == name);
        found.ok_or_else(|| SystemError::UnknownSlave { slave: name.to_owned() })
    }

    /// The row of `port` in its slave's table; ports of this system always have one.
    pub(in crate::cosim) fn variable(&self, port: Port) -> &Variable {
        &self.slaves[port.slave].variables()[port.variable]
    }

    /// `slave.variable`.
    pub fn full_name(&self, port: Port) -> String {
        format!("{}.{}", self.slaves[port.slave].name(), self.variable(port).name)
    }

    fn names(&self, port: Port) -> (String, String) {
        (self.slaves[port.slave].name().to_owned(), self.variable(port).name.to_string())
    }

    /// Feeds the input `to` from `from`, both (slave, variable): `to = factor · from + offset`.
    ///
    /// # Errors
    /// Whatever makes this no connection; see [`SystemError`].
    pub fn connect(
        &mut self,
        from: (&str, &str),
        to: (&str, &str),
        factor: f64,
        offset: f64,
    ) -> Result<(), SystemError> {
        let (from, to) = (self.port(from.0, from.1)?, self.port(to.0, to.1)?);
        let (slave, variable) = self.names(to);
        let (source, target) = (self.variable(from), self.variable(to));
        if !matches!(source.causality, Causality::Output | Causality::Local) {
            let (slave, variable) = self.names(from);
            return Err(SystemError::NotAnOutput { slave, variable });
        }
        if target.causality != Causality::Input {
            return Err(SystemError::NotAnInput { slave, variable });
        }
        // Whole numbers and truths are numbers too; the other way something would be lost.
        let fits = source.kind == target.kind
            || target.kind == Kind::Real
            || (source.kind, target.kind) == (Kind::Boolean, Kind::Integer);
        if !fits {
            return Err(SystemError::KindMismatch {
                from: self.full_name(from),
                from_kind: source.kind,
                to: self.full_name(to),
                to_kind: target.kind,
            });
        }
        // Of truths, any mapping to truths is linear.
        let truths = source.kind == Kind::Boolean
            && [offset, factor + offset].iter().all(|to| [0.0, 1.0].contains(to));
        if target.kind != Kind::Real && (factor != 1.0 || offset != 0.0) && !truths {
            return Err(SystemError::TransformedWholeNumber { slave, variable });
        }
        for (what, value) in [("factor", factor), ("offset", offset)] {
            if !value.is_finite() {
                return Err(SystemError::NotFinite { slave, variable, what, value });
            }
        }
        if let Some(other) = self.connections.iter().find(|other| other.to == to) {
            let (first, second) = (self.full_name(other.from), self.full_name(from));
            return Err(SystemError::ConnectedTwice { slave, variable, first, second });
        }
        self.connections.push(Connection { from, to, factor, offset });
        Ok(())
    }

    /// Gives a parameter or an input a start value.
    ///
    /// # Errors
    /// Unknown names, [`SystemError::NotSettable`], [`SystemError::NotFinite`].
    pub fn start(&mut self, slave: &str, variable: &str, value: f64) -> Result<(), SystemError> {
        let port = self.port(slave, variable)?;
        let (slave, variable) = self.names(port);
        if self.variable(port).causality == Causality::Output {
            return Err(SystemError::NotSettable { slave, variable });
        }
        if !value.is_finite() {
            return Err(SystemError::NotFinite { slave, variable, what: "start value", value });
        }
        self.starts.retain(|(other, _)| *other != port);
        self.starts.push((port, value));
        Ok(())
    }

    /// How the slave called `slave` is given inputs that it cannot interpolate.
    ///
    /// # Errors
    /// [`SystemError::UnknownSlave`].
    pub fn give_inputs(&mut self, slave: &str, rule: InputRule) -> Result<(), SystemError> {
        let index = self.slave(slave)?;
        self.rules[index] = rule;
        Ok(())
    }

    /// Has a variable reported at each communication point. Without any call all outputs of all slaves are.
    ///
    /// # Errors
    /// Unknown names.
    pub fn observe(&mut self, slave: &str, variable: &str) -> Result<(), SystemError> {
        let port = self.port(slave, variable)?;
        if !self.observed.contains(&port) {
            self.observed.push(port);
        }
        Ok(())
    }

    /// What is reported at each communication point, in this order.
    pub fn observed(&self) -> Vec<Port> {
        if !self.observed.is_empty() {
            return self.observed.clone();
        }
        let slaves = self.slaves.iter().enumerate();
        let ports = slaves.flat_map(|(slave, other)| {
            let rows = other.variables().iter().enumerate();
            let outputs = rows.filter(|(_, row)| row.causality == Causality::Output);
            outputs.map(move |(variable, _)| Port { slave, variable })
        });
        ports.collect()
    }

    /// Does the output `from` depend at once on the input `on` of the same slave?
    pub(in crate::cosim) fn depends(&self, slave: usize, output: usize, input: usize) -> bool {
        let row = &self.slaves[slave].variables()[output];
        row.depends_on.as_ref().is_none_or(|inputs| inputs.contains(&input))
    }

    /// Of each variable of a slave: the fraction of the slave's Real outputs that depend on it at once, as far as it is an
    /// input.
    pub(in crate::cosim) fn feed_through(&self, slave: usize) -> Vec<f64> {
        let rows = self.slaves[slave].variables();
        let outputs = rows.iter().filter(|row| row.causality == Causality::Output && row.kind == Kind::Real);
        let (mut counts, mut all, mut number) = (vec![0_usize; rows.len()], 0, 0);
        for output in outputs {
            number += 1;
            match &output.depends_on {
                None => all += 1,
                Some(inputs) => inputs.iter().for_each(|input| {
                    if let Some(count) = counts.get_mut(*input) {
                        *count += 1;
                    }
                }),
            }
        }
        let fraction = |count: &usize| (count + all) as f64 / f64::from(number.max(1));
        counts.iter().map(fraction).collect()
    }
}
