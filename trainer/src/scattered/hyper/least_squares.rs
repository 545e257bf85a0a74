//! Least squares by Householder reflections, in scalar loops with a fixed order.

use crate::numeric::columns::dot;

/// Share of a column's length below which the column depends on earlier columns.
const DEPENDENT: f64 = 1e-13;

/// Solves `min |A x - y|²` for every y; returns the vectors x.
///
/// A column of A that depends on earlier columns gets the coefficient 0.
///
/// - `design`: A, column by column, `rows` numbers each.
/// - `right`: vectors y, `rows` numbers each.
pub(super) fn solve(mut design: Vec<f64>, mut right: Vec<f64>, rows: usize) -> Vec<f64> {
    let columns = design.len() / rows;
    // Columns of the triangular factor, and its diagonal.
    let (mut kept, mut diagonal) = (Vec::new(), Vec::new());
    for k in 0..columns {
        let (column, later) = design[k * rows..].split_at_mut(rows);
        let row = kept.len();
        let own = dot(&column[row..], &column[row..]).sqrt();
        // In this form a column with a NaN is left out.
        let independent = own > DEPENDENT * dot(column, column).sqrt();
        if !independent {
            continue;
        }
        let reflected = if column[row] > 0.0 { -own } else { own };
        column[row] -= reflected;
        let normal = &column[row..];
        let half = -reflected * normal[0];
        for other in later.chunks_exact_mut(rows).chain(right.chunks_exact_mut(rows)) {
            let other = &mut other[row..];
            let share = dot(normal, other) / half;
            other.iter_mut().zip(normal).for_each(|(x, n)| *x -= share * n);
        }
        kept.push(k);
        diagonal.push(reflected);
    }
    let mut out = vec![0.0; columns * (right.len() / rows)];
    for (x, y) in out.chunks_exact_mut(columns.max(1)).zip(right.chunks_exact(rows)) {
        for row in (0..kept.len()).rev() {
            let later = kept[row + 1..].iter().map(|&k| design[k * rows + row] * x[k]);
            x[kept[row]] = (y[row] - later.sum::<f64>()) / diagonal[row];
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_through_points_is_the_closed_form() {
        let (x, y) = ([0.0, 1.0, 2.0, 3.0], [1.0, 3.0, 2.0, 5.0]);
        let found = solve([[1.0; 4], x].concat(), y.to_vec(), 4);
        // Slope Σ(x - 1.5)(y - 2.75) / Σ(x - 1.5)² = 5.5 / 5.
        assert!((found[1] - 1.1).abs() < 1e-14 && (found[0] - 1.1).abs() < 1e-14, "{found:?}");
    }

    #[test]
    fn residuals_are_normal_to_all_columns() {
        let wave = |k: usize| (0.37 * (k * k) as f64).sin();
        let design: Vec<f64> = (0..60).map(wave).collect();
        let right: Vec<f64> = (60..84).map(wave).collect();
        let found = solve(design.clone(), right.clone(), 12);
        for (x, y) in found.chunks(5).zip(right.chunks(12)) {
            let left: Vec<f64> = (0..12)
                .map(|row| y[row] - (0..5).map(|k| design[12 * k + row] * x[k]).sum::<f64>())
                .collect();
            assert!(dot(&left, &left) > 0.1, "nothing is left");
            assert!(design.chunks(12).all(|column| dot(column, &left).abs() < 1e-14));
        }
    }

    #[test]
    fn dependent_columns_get_no_coefficient() {
        let columns = [[1.0, 2.0, 0.0, 1.0], [2.0, 4.0, 0.0, 2.0], [0.0; 4], [1.0, 0.0, 1.0, 0.0]];
        let found = solve(columns.concat(), vec![2.0, 2.0, 1.0, 1.0], 4);
        assert_eq!([found[1], found[2]], [0.0, 0.0]);
        assert!((found[0] - 1.0).abs() < 1e-14 && (found[3] - 1.0).abs() < 1e-14, "{found:?}");
    }
}
