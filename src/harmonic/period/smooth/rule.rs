//! Quadrature on a panel, and the test whether the panel is resolved.

use crate::contact::quadrature::GAUSS_LEGENDRE_16;

/// Nodes of a panel.
pub(super) const NODES: usize = 2 * GAUSS_LEGENDRE_16.len();
/// Fraction of the largest force that the highest Legendre coefficients on a panel may have.
const RESOLVED: f64 = 1e-6;
/// Fraction of it that the coefficients as far beyond them may have, where the rule ceases to be exact. Those of a smooth
/// force fall from order to order by a ratio, those of a force with a knee far slower.
const INTEGRATED: f64 = 1e-9;
/// What is known at a node.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Node {
    pub phase: f64,
    pub slope: f64,
    pub force: f64,
    pub stiffness: f64,
    pub damping: f64,
    pub stuck: bool,
}

/// Quadrature on a panel, and the test whether the panel is resolved.
#[derive(Debug)]
pub(super) struct Rule {
    pub nodes: [f64; NODES],
    pub weights: [f64; NODES],
    /// Rows that give the three highest Legendre coefficients of values at the nodes.
    tail: [[f64; NODES]; 3],
    /// The same of the three whose orders are half as high.
    middle: [[f64; NODES]; 3],
}

impl Rule {
    pub fn new() -> Self {
        let mut rule = Self {
            nodes: [0.0; NODES],
            weights: [0.0; NODES],
            tail: [[0.0; NODES]; 3],
            middle: [[0.0; NODES]; 3],
        };
        for (i, (node, weight)) in GAUSS_LEGENDRE_16.iter().enumerate() {
            let (left, right) = (NODES / 2 - 1 - i, NODES / 2 + i);
            (rule.nodes[left], rule.nodes[right]) = (-node, *node);
            (rule.weights[left], rule.weights[right]) = (*weight, *weight);
        }
        for i in 0..NODES {
            let x = rule.nodes[i];
            let (mut before, mut legendre) = (1.0, x);
            for k in 1..NODES {
                let row = (k as f64 + 0.5) * rule.weights[i] * legendre;
                match k {
                    6..=8 => rule.middle[k - 6][i] = row,
                    13..NODES => rule.tail[k - 13][i] = row,
                    _ => (),
                }
                let k = k as f64;
                (before, legendre) = (legendre, ((2.0 * k + 1.0) * x * legendre - k * before) / (k + 1.0));
            }
        }
        rule
    }

    /// Whether nodes are too few for the force at them, `scale` (N) being its size.
    pub fn too_wide(&self, nodes: &[Node; NODES], scale: f64) -> bool {
        let coefficient =
            |row: &[f64; NODES]| row.iter().zip(nodes).map(|(r, node)| r * node.force).sum::<f64>().abs();
        let sum = |rows: &[[f64; NODES]; 3]| rows.iter().map(coefficient).sum::<f64>();
        let (middle, tail) = (sum(&self.middle), sum(&self.tail));
        // From order 7 to 14 by a ratio, from 14 to 28 by its square.
        let unfounded = tail > INTEGRATED * scale && tail.powi(3) > INTEGRATED * scale * middle * middle;
        tail > RESOLVED * scale || unfounded
    }
}
