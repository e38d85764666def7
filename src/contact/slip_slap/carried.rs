//! Derivatives carried over the instant at which the bodies part or meet.
//!
//! A row of `carried` is a number of the law's memory; its columns are the motion at the end of the way, that at its start,
//! and the memory at its start.

use super::way::{MOTION, Piece};
use super::{SlipSlapTangents, SlipSlapWork};
use crate::contact::{Response, StateTangents};

/// Columns before those of the memory.
const ENDS: usize = 2 * MOTION;

/// What the inputs of a piece do to number `row` of the law's next memory, by `column` of the ends.
fn by_ends(piece: &Piece, tangents: &StateTangents, row: usize, column: usize) -> f64 {
    tangents.next_by_displacement[row] * piece.by[0][column]
        + tangents.next_by_velocity[row] * piece.by[1][column]
        + tangents.next_by_normal_load[row] * piece.by[2][column]
}

/// `Σ row[i] carried[i, column]`, of `carried` with so many `columns`.
pub(super) fn product(row: &[f64], carried: &[f64], columns: usize, column: usize) -> f64 {
    row.iter().zip(carried.chunks_exact(columns)).map(|(by, carried)| by * carried[column]).sum()
}

/// The memory after `piece` by the motion at the end of the way alone.
pub(super) fn by_inputs(piece: &Piece, tangents: &StateTangents, carried: &mut Vec<f64>) {
    carried.clear();
    let rows = 0..tangents.force_by_state.len();
    carried.extend(rows.flat_map(|row| (0..MOTION).map(move |column| by_ends(piece, tangents, row, column))));
}

/// The memory at the start of the way, of `n` numbers.
pub(super) fn begin(n: usize, carried: &mut Vec<f64>) {
    let columns = ENDS + n;
    carried.clear();
    carried.resize(n * columns, 0.0);
    for row in 0..n {
        carried[row * columns + ENDS + row] = 1.0;
    }
}

/// The memory after `piece`, the first of the way.
pub(super) fn over(piece: &Piece, tangents: &StateTangents, carried: &mut Vec<f64>) {
    let n = tangents.force_by_state.len();
    carried.clear();
    for row in 0..n {
        carried.extend((0..ENDS).map(|column| by_ends(piece, tangents, row, column)));
        carried.extend_from_slice(&tangents.next_by_state[row * n..(row + 1) * n]);
    }
}

/// Writes the derivatives of the whole way; those of S by the motion at its end are returned. `work` holds the law's
/// tangents in the last `piece` and what is carried up to it.
pub(super) fn write(
    piece: &Piece,
    response: &Response,
    work: &mut SlipSlapWork,
    out: &mut SlipSlapTangents,
) -> [f64; MOTION] {
    let SlipSlapWork { tangents, carried, row: found, .. } = work;
    let n = tangents.force_by_state.len();
    let (columns, len) = (ENDS + n, MOTION + n);
    out.reset(len);
    // A law's memory is mostly numbers that know nothing of each other: what is zero is left out.
    let carry = |found: &mut Vec<f64>, own: &dyn Fn(usize) -> f64, by: &[f64]| {
        found.clear();
        found.extend((0..ENDS).map(own));
        found.resize(columns, 0.0);
        for (by, row) in by.iter().zip(carried.chunks_exact(columns)).filter(|(by, _)| **by != 0.0) {
            found.iter_mut().zip(row).for_each(|(found, carried)| *found += by * carried);
        }
    };
    carry(found, &|column| piece.force_by(response, column), &tangents.force_by_state);
    out.force_by_state[..len].copy_from_slice(&found[MOTION..]);
    let force_by = [found[0], found[1], found[2], found[3]];
    // The next motion is the one at the end of the way.
    for direction in 0..2 {
        out.next_by_displacement[2 * direction + direction] = 1.0;
        out.next_by_velocity[2 * (2 + direction) + direction] = 1.0;
    }
    for row in 0..n {
        let memory = &tangents.next_by_state[row * n..(row + 1) * n];
        carry(found, &|column| by_ends(piece, tangents, row, column), memory);
        let place = MOTION + row;
        out.next_by_displacement[2 * place..2 * place + 2].copy_from_slice(&found[..2]);
        out.next_by_velocity[2 * place..2 * place + 2].copy_from_slice(&found[2..MOTION]);
        out.next_by_state[place * len..(place + 1) * len].copy_from_slice(&found[MOTION..]);
    }
    force_by
}

impl SlipSlapTangents {
    /// Zeros for a state of `n` numbers.
    fn reset(&mut self, n: usize) {
        let sizes = [2 * n, n * n, 2 * n, 2 * n];
        let vectors = [
            &mut self.force_by_state,
            &mut self.next_by_state,
            &mut self.next_by_displacement,
            &mut self.next_by_velocity,
        ];
        for (vector, size) in vectors.into_iter().zip(sizes) {
            vector.clear();
            vector.resize(size, 0.0);
        }
    }
}
