//! Small linear systems that may lack rank.

/// Gauss–Jordan elimination with full pivoting of `n` rows of width `n + right`; unknowns whose pivot
/// falls below `threshold` are set to zero. Returns the rank; `pivots` then
/// starts with the unknowns that were solved for.
///
/// A row with one unknown comes first: it takes nothing from the other rows, whose small pivots would be lost where
/// they know that unknown by large numbers.
pub(crate) fn solve_ranked(
    system: &mut [f64],
    pivots: &mut [usize],
    right: usize,
    threshold: f64,
    out: &mut [f64],
) -> usize {
    let n = pivots.len();
    let width = n + right;
    out[..n * right].fill(0.0);
    let mut solved = 0;
    while solved < n {
        let mut best = (solved, 0, 0.0, false);
        for i in solved..n {
            let row = &system[i * width..i * width + n];
            let alone = row.iter().filter(|x| **x != 0.0).count() == 1;
            for (j, size) in row.iter().map(|x| x.abs()).enumerate() {
                if size
                    > if alone {
                        threshold
                    } else if best.3 {
                        f64::INFINITY
                    } else {
                        best.2
                    }
                {
                    best = (i, j, size, alone);
                }
            }
        }
        let (row, column, size, _) = best;
        // A NaN never compares greater: it ends here as a missing pivot and shows in the force.
        if size <= threshold {
            break;
        }
        for j in 0..width {
            system.swap(solved * width + j, row * width + j);
        }
        pivots[solved] = column;
        let pivot = system[solved * width + column];
        for j in 0..width {
            system[solved * width + j] /= pivot;
        }
        for i in (0..n).filter(|i| *i != solved) {
            let factor = system[i * width + column];
            if factor != 0.0 {
                for j in 0..width {
                    system[i * width + j] -= factor * system[solved * width + j];
                }
                // Exactly zero, so that a later search cannot pick the column again.
                system[i * width + column] = 0.0;
            }
        }
        solved += 1;
    }
    for (i, column) in pivots[..solved].iter().enumerate() {
        out[column * right..(column + 1) * right].copy_from_slice(&system[i * width + n..(i + 1) * width]);
    }
    solved
}

#[cfg(test)]
mod tests {
    use super::solve_ranked;

    #[test]
    fn full_rank_is_solved_and_missing_rank_left_at_zero() {
        // x + 2y = 5, 3x + 4y = 11.
        let mut system = [1.0, 2.0, 5.0, 3.0, 4.0, 11.0];
        let (mut pivots, mut out) = ([0; 2], [0.0; 2]);
        assert_eq!(solve_ranked(&mut system, &mut pivots, 1, 1e-9, &mut out), 2);
        assert!((out[0] - 1.0).abs() < 1e-14 && (out[1] - 2.0).abs() < 1e-14);
        let mut system = [0.0, 4.0, 8.0, 0.0, 2.0, 4.0];
        assert_eq!(solve_ranked(&mut system, &mut pivots, 1, 1e-9, &mut out), 1);
        assert_eq!((out, pivots[0]), ([0.0, 2.0], 1));
        // 1e-8 x + 500 y = 502, y = 1.
        let mut system = [1e-8, 500.0, 502.0, 0.0, 1.0, 1.0];
        assert_eq!(solve_ranked(&mut system, &mut pivots, 1, 1e-9, &mut out), 2);
        assert!((out[0] / 2e8 - 1.0).abs() < 1e-14 && out[1] == 1.0, "{out:?}");
    }
}
