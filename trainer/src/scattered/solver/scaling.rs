//! Shift and scale of inputs, before distances are measured (METHOD §2.2).

use super::matrix::distances;
use super::options::out_of_range;
use crate::Error;
use faer::{ColRef, Mat};

/// Share of the block's spread below which a column is constant.
const CONSTANT: f64 = 1e-5;
/// Share of the block's magnitude below which its spread is rounding.
const ROUNDING: f64 = 1e-13;

/// Columns with a common scale: a number, a vector, a rotation's features.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Block {
    /// Number of columns.
    pub len: usize,
    /// Factor of the block's distances.
    pub weight: f64,
}

/// Shift and scale of each column: `u = (x - shift) scale`.
#[derive(Clone, Debug)]
pub struct Scaling {
    /// Centroid, d, rounded to f32 as in a file. The difference of an f32 site and an f32 shift is exact.
    pub shift: Vec<f64>,
    /// Scale, d: the block's weight over the block's spread, divided by the mean distance that results; 0 for dropped
    /// columns.
    pub scale: Vec<f64>,
}

impl Scaling {
    /// Measures finite sites (n x d, in blocks of columns).
    ///
    /// The spread of a block is the RMS distance from its centroid. The mean distance includes all pairs of sites. So
    /// the meaning of a width depends neither on the number of samples nor on the number of inputs.
    ///
    /// # Errors
    /// If the blocks do not have d columns, or a weight is negative or not finite.
    pub fn new(sites: &Mat<f64>, blocks: &[Block]) -> Result<Self, Error> {
        let (n, d) = sites.shape();
        let columns: usize = blocks.iter().map(|block| block.len).sum();
        if columns != d {
            return Err(Error::mismatch(format!(
                "blocks of inputs have {columns} columns, sites {d}"
            )));
        }
        let centroid: Vec<f64> = sites.col_iter().map(mean).collect();
        let mut scale = Vec::with_capacity(d);
        for block in blocks {
            if !(block.weight >= 0.0 && block.weight.is_finite()) {
                let expected = "a finite number that is not negative";
                return Err(out_of_range("a weight", block.weight, expected));
            }
            let own = scale.len()..scale.len() + block.len;
            let spread = |c: usize| {
                let squares = sites.col(c).iter().map(|x| (x - centroid[c]) * (x - centroid[c]));
                (squares.sum::<f64>() / n as f64).sqrt()
            };
            let spreads: Vec<f64> = own.clone().map(spread).collect();
            let all = spreads.iter().map(|spread| spread * spread).sum::<f64>().sqrt();
            let largest = sites.subcols(own.start, own.len()).norm_max();
            let moves = all > ROUNDING * largest;
            let kept = |spread: &f64| moves && *spread > CONSTANT * all;
            let factor = |spread: &f64| if kept(spread) { block.weight / all } else { 0.0 };
            scale.extend(spreads.iter().map(factor));
        }
        let shift = centroid.into_iter().map(rounded).collect();
        let mut scaling = Self { shift, scale };
        let points = scaling.apply(sites);
        let sum: f64 = (0..n).map(|i| distances(&points, i).iter().sum::<f64>()).sum();
        if sum > 0.0 {
            let by = (n * (n - 1)) as f64 / (2.0 * sum);
            scaling.scale.iter_mut().for_each(|scale| *scale *= by);
        }
        Ok(scaling)
    }

    /// Shifts and scales sites, n x d.
    pub fn apply(&self, sites: &Mat<f64>) -> Mat<f64> {
        Mat::from_fn(sites.nrows(), sites.ncols(), |i, c| {
            (sites[(i, c)] - self.shift[c]) * self.scale[c]
        })
    }

    /// Lists the columns that count in distances.
    pub fn kept(&self) -> Vec<usize> {
        (0..self.scale.len()).filter(|&c| self.scale[c] != 0.0).collect()
    }

    /// Lists the columns that do not count in distances.
    pub fn dropped(&self) -> Vec<usize> {
        (0..self.scale.len()).filter(|&c| self.scale[c] == 0.0).collect()
    }
}

/// Rounds to f32, unless the number is too large for f32.
fn rounded(x: f64) -> f64 {
    let rounded = f64::from(x as f32);
    if rounded.is_finite() { rounded } else { x }
}

/// Returns the mean of a column, exact if all numbers are equal.
fn mean(column: ColRef<'_, f64>) -> f64 {
    let first = column.iter().next().copied().unwrap_or(0.0);
    first + column.iter().map(|x| x - first).sum::<f64>() / column.nrows().max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sites() -> Mat<f64> {
        Mat::from_fn(7, 4, |i, c| match c {
            0 => 1000.0 + i as f64,
            1 => 1e-3 * (i as f64).sin(),
            2 => 5.0,
            _ => (i as f64 * 0.7).cos(),
        })
    }

    const BLOCKS: [Block; 2] = [Block { len: 1, weight: 1.0 }, Block { len: 3, weight: 2.0 }];

    fn mean_distance(points: &Mat<f64>) -> f64 {
        let n = points.nrows();
        let sum: f64 = (0..n).map(|i| distances(points, i).iter().sum::<f64>()).sum();
        2.0 * sum / (n * (n - 1)) as f64
    }

    #[test]
    fn the_mean_distance_is_one_and_blocks_have_their_weights() {
        let scaling = Scaling::new(&sites(), &BLOCKS).unwrap();
        let points = scaling.apply(&sites());
        assert!((mean_distance(&points) - 1.0).abs() < 1e-12);
        let spread = |from: usize, len: usize| {
            let own = points.subcols(from, len);
            own.norm_l2()
        };
        assert!((spread(1, 3) / spread(0, 1) - 2.0).abs() < 1e-12);
        assert_eq!((scaling.kept(), scaling.dropped()), (vec![0, 1, 3], vec![2]));
        assert_eq!(scaling.scale[1], scaling.scale[3], "one factor a block");
    }

    #[test]
    fn units_and_origins_do_not_matter() {
        let moved = Mat::from_fn(7, 4, |i, c| 1e4 * sites()[(i, c)] - 3e5);
        let points = Scaling::new(&sites(), &BLOCKS).unwrap().apply(&sites());
        let found = Scaling::new(&moved, &BLOCKS).unwrap().apply(&moved);
        // Each shift is rounded separately.
        let from_first = |of: Mat<f64>| Mat::from_fn(7, 4, |i, c| of[(i, c)] - of[(0, c)]);
        assert!((from_first(points) - from_first(found)).norm_max() < 1e-9);
    }

    #[test]
    fn shifts_are_f32_numbers() {
        let sites = Mat::from_fn(3, 2, |i, c| [1e7 + 0.3 * i as f64, 1e300][c]);
        let shift = Scaling::new(&sites, &[Block { len: 2, weight: 1.0 }]).unwrap().shift;
        // f32 has no number near 1e300; the function's file will be refused.
        assert_eq!(shift, [1e7, 1e300]);
    }

    #[test]
    fn sites_that_never_move_and_weights_of_zero_are_dropped() {
        let alike = Mat::from_fn(3, 2, |_, c| 0.1 + c as f64);
        let scaling = Scaling::new(&alike, &BLOCKS[..1].repeat(2)).unwrap();
        assert_eq!(scaling.dropped(), [0, 1]);
        assert_eq!(scaling.apply(&alike).norm_max(), 0.0);
        let blocks = [Block { len: 3, weight: 1.0 }, Block { len: 1, weight: 0.0 }];
        assert_eq!(Scaling::new(&sites(), &blocks).unwrap().dropped(), [2, 3]);
    }

    #[test]
    fn a_column_that_hardly_moves_beside_its_blocks_others_is_dropped() {
        let of = |share: f64| {
            let sites = Mat::from_fn(9, 2, |i, c| if c == 0 { i as f64 } else { share * i as f64 });
            Scaling::new(&sites, &[Block { len: 2, weight: 1.0 }]).unwrap().dropped()
        };
        assert_eq!((of(1e-6), of(1e-4)), (vec![1], vec![]));
        let alone = Mat::from_fn(9, 1, |i, _| 1000.0 + 1e-6 * i as f64);
        assert!(Scaling::new(&alone, &BLOCKS[..1]).unwrap().dropped().is_empty());
    }

    #[test]
    fn blocks_must_be_the_columns_and_weights_numbers() {
        let error = Scaling::new(&sites(), &BLOCKS[..1]).unwrap_err();
        assert_eq!(error.to_string(), "blocks of inputs have 1 columns, sites 4");
        for weight in [-1.0, f64::NAN] {
            let blocks = [Block { len: 4, weight }];
            let error = Scaling::new(&sites(), &blocks).unwrap_err();
            assert!(error.message().starts_with("a weight is "), "{error}");
        }
    }
}
