//! Variables of slaves, and what is between them.

/// A variable of one of the system's slaves.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Port {
    /// The slave, in the order in which they were added.
    pub slave: usize,
    /// The variable's position in the slave's table.
    pub variable: usize,
}

/// What an input is fed from: `input = factor · source + offset`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Connection {
    /// Where the value comes from.
    pub from: Port,
    /// The input it is for.
    pub to: Port,
    /// Units and gains, resolved.
    pub factor: f64,
    /// In the unit of the input.
    pub offset: f64,
}

/// A force and a motion that two slaves give each other.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PowerConnection {
    /// The input that takes the force.
    pub force: Port,
    /// The other slave's input that takes the displacement, if one is connected.
    pub displacement: Option<Port>,
    /// The other slave's input that takes the velocity, if one is connected.
    pub velocity: Option<Port>,
}
