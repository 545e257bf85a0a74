//! Symmetric matrices in packed storage: the rows of the upper triangle, each starting at the
//! diagonal.
//!
//! Loops add a multiple of one row to another. No loop needs an ordered sum, so all vectorise with
//! equal bits.

/// Returns the number of entries in a triangle of n rows.
pub(crate) const fn packed_len(n: usize) -> usize {
    n * (n + 1) / 2
}

/// Lists the rows of a triangle of n rows.
pub(super) fn rows<T>(mut packed: &[T], n: usize) -> impl Iterator<Item = &[T]> {
    (1..=n).rev().map_while(move |len| {
        let (row, rest) = packed.split_at_checked(len)?;
        packed = rest;
        Some(row)
    })
}

/// Adds `strength b bᵀ`, b of n numbers.
pub(super) fn add_square(packed: &mut [f64], strength: f64, b: &[f64]) {
    let mut rest = packed;
    let mut tail = b;
    while let Some((first, next)) = tail.split_first() {
        let Some((row, others)) = rest.split_at_mut_checked(tail.len()) else { return };
        // Most shapes do not move a given vertex.
        if *first != 0.0 {
            add(row, strength * first, tail);
        }
        (rest, tail) = (others, next);
    }
}

/// Adds a number to the diagonal.
pub(super) fn add_to_diagonal(packed: &mut [f64], n: usize, x: f64) {
    let mut rest = packed;
    for len in (1..=n).rev() {
        let Some((row, others)) = rest.split_at_mut_checked(len) else { return };
        row.iter_mut().take(1).for_each(|diagonal| *diagonal += x);
        rest = others;
    }
}

/// Computes `out = H x`.
pub(super) fn multiply(packed: &[f64], x: &[f64], out: &mut [f64]) {
    out.fill(0.0);
    let (mut x, mut out) = (x, out);
    for row in rows(packed, x.len()) {
        let (Some((x0, xs)), Some((out0, outs))) = (x.split_first(), out.split_first_mut()) else {
            return;
        };
        let Some((diagonal, others)) = row.split_first() else { return };
        *out0 += diagonal * x0 + dot(others, xs);
        add(outs, *x0, others);
        (x, out) = (xs, outs);
    }
}

/// Replaces H of n rows by its factor U, `H = Uᵀ U`. Returns `false` if rounding leaves no positive
/// diagonal.
pub(super) fn factor(packed: &mut [f64], n: usize) -> bool {
    let mut rest = packed;
    for len in (1..=n).rev() {
        let Some((row, below)) = rest.split_at_mut_checked(len) else { return false };
        let pivot = row.first().copied().unwrap_or_default();
        if !(f64::MIN_POSITIVE..=f64::MAX).contains(&pivot) {
            return false;
        }
        let scale = 1.0 / libm::sqrt(pivot);
        row.iter_mut().for_each(|x| *x *= scale);
        let mut from = row.get(1..).unwrap_or_default();
        let mut target = &mut *below;
        while let Some((first, next)) = from.split_first() {
            let Some((own, others)) = target.split_at_mut_checked(from.len()) else { return false };
            add(own, -first, from);
            (target, from) = (others, next);
        }
        rest = below;
    }
    true
}

/// Solves `Uᵀ U x = x` in place.
pub(super) fn solve(factor: &[f64], x: &mut [f64]) {
    let n = x.len();
    let mut rest = &mut *x;
    for row in rows(factor, n) {
        let (Some((first, others)), Some((diagonal, row))) =
            (rest.split_first_mut(), row.split_first())
        else {
            return;
        };
        *first /= diagonal;
        add(others, -*first, row);
        rest = others;
    }
    let mut end = packed_len(n);
    for at in (0..n).rev() {
        let Some((own, solved)) = x.get_mut(at..).and_then(<[_]>::split_first_mut) else { return };
        let start = end - (n - at);
        let Some((diagonal, row)) = factor.get(start..end).and_then(<[_]>::split_first) else {
            return;
        };
        *own = (*own - dot(row, solved)) / diagonal;
        end = start;
    }
}

/// Adds a multiple of a vector to another.
#[inline(always)]
pub(super) fn add(out: &mut [f64], by: f64, x: &[f64]) {
    out.iter_mut().zip(x).for_each(|(out, x)| *out += by * x);
}

/// Returns a · b. Four accumulators hide the latency of addition.
#[inline]
pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    let ((a4, a), (b4, b)) = (a.as_chunks::<4>(), b.as_chunks::<4>());
    let mut sums = [0.0; 4];
    for (a, b) in a4.iter().zip(b4) {
        sums.iter_mut().zip(a.iter().zip(b)).for_each(|(sum, (a, b))| *sum += a * b);
    }
    let [s0, s1, s2, s3] = sums;
    let rest = a.iter().zip(b).fold(0.0, |sum, (a, b)| sum + a * b);
    ((s0 + s1) + (s2 + s3)) + rest
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::vec;
    use std::vec::Vec;

    /// A matrix of n rows made of squares, in packed and in full storage.
    fn sample(n: usize) -> (Vec<f64>, Vec<Vec<f64>>) {
        let mut packed = vec![0.0; packed_len(n)];
        let mut whole = vec![vec![0.0; n]; n];
        add_to_diagonal(&mut packed, n, 0.5);
        (0..n).for_each(|i| whole[i][i] += 0.5);
        for k in 0..n + 2 {
            let b: Vec<f64> = (0..n).map(|i| ((7 * i + 3 * k) % 11) as f64 - 5.0).collect();
            add_square(&mut packed, 0.25, &b);
            for i in 0..n {
                for j in 0..n {
                    whole[i][j] += 0.25 * b[i] * b[j];
                }
            }
        }
        (packed, whole)
    }

    #[test]
    fn a_triangle_holds_the_whole_matrix() {
        for n in 0..9 {
            let (packed, whole) = sample(n);
            for (i, row) in rows(&packed, n).enumerate() {
                assert_eq!(row, &whole[i][i..]);
            }
            let x: Vec<f64> = (0..n).map(|i| i as f64 - 1.5).collect();
            let mut out = vec![9.0; n];
            multiply(&packed, &x, &mut out);
            for (out, row) in out.iter().zip(&whole) {
                let exact: f64 = row.iter().zip(&x).map(|(a, b)| a * b).sum();
                assert!((out - exact).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn a_factor_solves_what_its_matrix_multiplies() {
        for n in 0..9 {
            let (mut packed, whole) = sample(n);
            let x: Vec<f64> = (0..n).map(|i| 2.0 - i as f64).collect();
            let mut found: Vec<f64> =
                whole.iter().map(|row| row.iter().zip(&x).map(|(a, b)| a * b).sum()).collect();
            assert!(factor(&mut packed, n));
            solve(&packed, &mut found);
            assert!(found.iter().zip(&x).all(|(a, b)| (a - b).abs() < 1e-11), "{n}");
        }
    }

    #[test]
    fn a_matrix_that_is_not_positive_has_no_factor() {
        for diagonal in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(!factor(&mut [4.0, 2.0, diagonal], 2));
        }
        // 1 - 2² is below 0.
        assert!(!factor(&mut [1.0, 2.0, 1.0], 2));
        assert!(factor(&mut [1.0, 2.0, 5.0], 2));
    }
}
