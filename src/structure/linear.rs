//! A linear structure as matrices, with the points where contacts, excitation and observers are.

/// A sparse row: `(degree of freedom, factor)`, e.g. a relative displacement `[(1, 1.0), (0, -1.0)]`.
pub type Row = Vec<(usize, f64)>;

/// Entries `(row, column, value)` of a symmetric matrix, both triangles, each place once, sorted.
pub type Entries = Vec<(usize, usize, f64)>;

/// A named point whose displacement is observed.
#[derive(Debug, Clone, PartialEq)]
pub struct Output {
    /// Its name, e.g. of a mass.
    pub name: String,
    /// Its displacement (m) in terms of the degrees of freedom.
    pub row: Row,
}

/// `M q̈ + C q̇ + K q + Σ Bᵢᵀ Tᵢ = f(t) e`, contact `i` displaced by `uᵢ = Bᵢ q`.
#[derive(Debug, Clone, PartialEq)]
pub struct LinearStructure {
    /// Number of degrees of freedom.
    pub size: usize,
    /// M (kg).
    pub mass: Entries,
    /// C (N s/m).
    pub damping: Entries,
    /// K (N/m).
    pub stiffness: Entries,
    /// Bᵢ of every contact.
    pub contacts: Vec<Row>,
    /// e.
    pub excitation: Row,
    /// Where the displacement is observed.
    pub outputs: Vec<Output>,
}
