//! Coordinates in which the rows and columns of a map are alike in size, so that rounding is a fraction of each: metres,
//! metres per second and newtons are not.

use nalgebra::DMatrix;

/// The map `D⁻¹ A D` and the diagonal of D, powers of two, so that nothing is rounded (Parlett & Reinsch 1969).
pub(crate) fn balance(mut map: DMatrix<f64>) -> (DMatrix<f64>, Vec<f64>) {
    const WORTHWHILE: f64 = 0.95;
    const MOST_ROUNDS: usize = 100;
    let mut scales = vec![1.0; map.nrows()];
    for _ in 0..MOST_ROUNDS {
        let mut settled = true;
        for (k, scale) in scales.iter_mut().enumerate() {
            let others = |values: &mut dyn Iterator<Item = f64>| -> f64 {
                values.enumerate().filter(|(i, _)| *i != k).map(|(_, value)| value.abs()).sum()
            };
            let column = others(&mut map.column(k).iter().copied());
            let row = others(&mut map.row(k).iter().copied());
            if column == 0.0 || row == 0.0 || !(column.is_finite() && row.is_finite()) {
                continue;
            }
            let factor = (0.5 * (row / column).log2()).round().exp2();
            if column * factor + row / factor < WORTHWHILE * (column + row) {
                settled = false;
                *scale *= factor;
                map.column_mut(k).scale_mut(factor);
                map.row_mut(k).unscale_mut(factor);
            }
        }
        if settled {
            break;
        }
    }
    (map, scales)
}
