//! Samples of a function: checked sites and values, without repetitions (METHOD §2.5).

use super::matrix::{distances, some_rows};
use super::scaling::{Block, Scaling};
use crate::Error;
use crate::numeric::columns::ends;
use faer::{ColRef, Mat};
use serde::Serialize;

/// Distance below which two sites count as the same site, over the mean distance.
pub const ONE_SITE: f64 = 1e-9;
/// Largest difference of two samples that agree, over the range of the value: a few units in the last place of f32.
const AGREE: f64 = 1e-6;
/// Range that replaces the range of a constant, over its magnitude.
pub const OFFSET: f64 = 1e-4;
/// Share of a value's magnitude below which its range is the f64 rounding of a constant.
const CONSTANT: f64 = 1e-14;

/// Treatment of samples with the same site and different values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Conflicts {
    /// Returns an error.
    Refuse,
    /// Averages the values.
    Average,
    /// Keeps each sample: the smoothing weighs them.
    Keep,
}

/// Samples of a fit.
#[derive(Clone, Debug)]
pub struct Samples {
    /// Sites, n x d.
    pub sites: Mat<f64>,
    /// Values, n x m.
    pub values: Mat<f64>,
    /// Scaling for distances between sites.
    pub scaling: Scaling,
    /// Given row of each sample, n.
    pub rows: Vec<usize>,
    /// Additional smoothing λ of each sample, n; initially 0.
    pub smoothing: Vec<f64>,
    /// Rows that were merged into samples.
    pub merged: Vec<Merged>,
}

/// Row that was merged into an earlier row.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Merged {
    /// Merged row.
    pub row: usize,
    /// Earlier row.
    pub into: usize,
    /// Distance of their sites, over the mean distance.
    pub distance: f64,
    /// Whether their values differed and were averaged.
    pub averaged: bool,
}

impl Samples {
    /// Takes sites (n x d, in blocks of columns) and values (n x m).
    ///
    /// # Errors
    /// In this order:
    /// - if there are no samples, inputs or values;
    /// - if the numbers of sites and values differ;
    /// - if a number is not finite;
    /// - if the blocks do not match the columns;
    /// - if two samples of one site have different values, and conflicts are refused.
    pub fn new(
        sites: &Mat<f64>,
        values: &Mat<f64>,
        blocks: &[Block],
        conflicts: Conflicts,
    ) -> Result<Self, Error> {
        Self::refusing(sites, values, blocks, conflicts, |[first, second], distance| {
            let how = same_site(distance);
            Error::mismatch(format!("rows {first} and {second} have {how} and different values"))
        })
    }

    /// Takes sites and values as [`Self::new`], with another error for a conflict.
    ///
    /// - `refused`: makes the error of two rows whose sites have the given distance, over the mean distance.
    pub(crate) fn refusing(
        sites: &Mat<f64>,
        values: &Mat<f64>,
        blocks: &[Block],
        conflicts: Conflicts,
        refused: impl Fn([usize; 2], f64) -> Error,
    ) -> Result<Self, Error> {
        check(sites, values)?;
        let scaling = Scaling::new(sites, blocks)?;
        let points = scaling.apply(sites);
        let ranges = ranges(values);
        let agree = |a: usize, b: usize| {
            (0..ranges.len()).all(|o| (values[(a, o)] - values[(b, o)]).abs() <= AGREE * ranges[o])
        };
        let (groups, merged) = merge(&points, conflicts, agree, refused)?;
        let rows: Vec<usize> = groups.iter().map(|group| group[0]).collect();
        let mean = |i: usize, o: usize| {
            let group = &groups[i];
            group.iter().map(|&row| values[(row, o)]).sum::<f64>() / group.len() as f64
        };
        Ok(Self {
            sites: some_rows(sites, &rows),
            values: Mat::from_fn(rows.len(), values.ncols(), mean),
            scaling,
            smoothing: vec![0.0; rows.len()],
            rows,
            merged,
        })
    }

    /// Takes sites (n x d, in blocks of columns) without values. Each sample has its own value: 1 at the sample and 0
    /// at the others.
    ///
    /// A function of these values gives the weights of the samples.
    ///
    /// # Errors
    /// Errors of [`Self::new`]; two samples of one site are a conflict.
    pub fn of_weights(sites: &Mat<f64>, blocks: &[Block]) -> Result<Self, Error> {
        let own = Mat::identity(sites.nrows(), sites.nrows());
        Self::new(sites, &own, blocks, Conflicts::Refuse)
    }

    /// Returns n.
    pub fn sample_len(&self) -> usize {
        self.sites.nrows()
    }
}

/// Finds the rows whose mean is a sample, one or several, and the rows that are merged.
fn merge(
    points: &Mat<f64>,
    conflicts: Conflicts,
    agree: impl Fn(usize, usize) -> bool,
    refused: impl Fn([usize; 2], f64) -> Error,
) -> Result<(Vec<Vec<usize>>, Vec<Merged>), Error> {
    let (mut groups, mut merged) = (Vec::new(), Vec::new());
    let mut taken = vec![false; points.nrows()];
    for into in 0..points.nrows() {
        if taken[into] {
            continue;
        }
        let distances = distances(points, into);
        let same = |row: &usize| !taken[*row] && distances[*row - into] < ONE_SITE;
        let others: Vec<usize> = (into + 1..points.nrows()).filter(same).collect();
        let conflict = others.iter().find(|row| !agree(into, **row));
        if let Some(&second) = conflict
            && conflicts == Conflicts::Refuse
        {
            return Err(refused([into, second], distances[second - into]));
        }
        if conflict.is_some() && conflicts == Conflicts::Keep {
            groups.push(vec![into]);
            continue;
        }
        let averaged = conflict.is_some();
        for &row in &others {
            taken[row] = true;
            merged.push(Merged { row, into, distance: distances[row - into], averaged });
        }
        let mean_of = if averaged { others } else { Vec::new() };
        groups.push([vec![into], mean_of].concat());
    }
    Ok((groups, merged))
}

/// Describes the distance of two sites that count as the same site.
pub(crate) fn same_site(distance: f64) -> String {
    match distance > 0.0 {
        true => format!("sites that are {distance:.1e} of the mean distance apart"),
        false => "the same site".to_owned(),
    }
}

/// Checks that sites and values are not empty, equally many, and finite.
///
/// # Errors
/// In this order:
/// - if there are no samples, inputs or values;
/// - if the numbers of sites and values differ;
/// - if a number is not finite.
pub fn check(sites: &Mat<f64>, values: &Mat<f64>) -> Result<(), Error> {
    let counts =
        [("samples", sites.nrows()), ("inputs", sites.ncols()), ("values", values.ncols())];
    if let Some((what, _)) = counts.into_iter().find(|(_, count)| *count == 0) {
        return Err(Error::missing(format!("there are no {what}")));
    }
    let (rows, found) = (sites.nrows(), values.nrows());
    if rows != found {
        return Err(Error::mismatch(format!(
            "expected a row of values for each of {rows} sites, found {found}"
        )));
    }
    for (what, matrix) in [("the site", sites), ("the value", values)] {
        for row in 0..matrix.nrows() {
            if let Some(column) = (0..matrix.ncols()).find(|&c| !matrix[(row, c)].is_finite()) {
                let message = format!("{what} of row {row}, column {column} is not finite");
                return Err(Error::value(message));
            }
        }
    }
    Ok(())
}

/// Returns the range of each value, m. A constant has a share of its magnitude as range, or 1 if it is 0.
pub fn ranges(values: &Mat<f64>) -> Vec<f64> {
    let range = |column: ColRef<'_, f64>| {
        let [least, most] = ends(column.iter());
        let magnitude = least.abs().max(most.abs());
        match most - least {
            range if range > CONSTANT * magnitude => range,
            _ if magnitude > 0.0 => OFFSET * magnitude,
            _ => 1.0,
        }
    };
    values.col_iter().map(range).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ErrorKind;

    const LINE: [Block; 1] = [Block { len: 1, weight: 1.0 }];

    fn column(of: &[f64]) -> Mat<f64> {
        Mat::from_fn(of.len(), 1, |i, _| of[i])
    }

    fn samples(sites: &[f64], values: &[f64], conflicts: Conflicts) -> Result<Samples, Error> {
        Samples::new(&column(sites), &column(values), &LINE, conflicts)
    }

    #[test]
    fn repetitions_that_agree_are_merged_and_reported() {
        let found = samples(
            &[0.0, 1.0, 0.0, 2.0, 2.0 + 1e-10],
            &[5.0, 6.0, 5.0, 7.0, 7.0],
            Conflicts::Refuse,
        )
        .unwrap();
        assert_eq!((found.rows, found.values), (vec![0, 1, 3], column(&[5.0, 6.0, 7.0])));
        let merged: Vec<_> = found.merged.iter().map(|m| (m.row, m.into, m.averaged)).collect();
        assert_eq!(merged, [(2, 0, false), (4, 3, false)]);
        assert!(found.merged[0].distance == 0.0 && found.merged[1].distance > 1e-11);
    }

    #[test]
    fn conflicts_are_refused_by_name_or_averaged() {
        let (sites, values) = ([0.0, 1.0, 1.0, 1.0], [0.0, 1.0, 4.0, 1.0]);
        let refused = samples(&sites, &values, Conflicts::Refuse).unwrap_err();
        assert_eq!(refused.to_string(), "rows 1 and 2 have the same site and different values");
        assert_eq!(refused.kind(), ErrorKind::Mismatch);
        let found = samples(&sites, &values, Conflicts::Average).unwrap();
        assert_eq!(found.values, column(&[0.0, 2.0]));
        assert!(found.merged.iter().all(|merged| merged.averaged));
    }

    #[test]
    fn conflicts_may_stay_samples() {
        let (sites, values) = ([0.0, 1.0, 1.0, 1.0, 2.0, 2.0], [0.0, 1.0, 4.0, 1.0, 3.0, 3.0]);
        let found = samples(&sites, &values, Conflicts::Keep).unwrap();
        assert_eq!((found.rows, found.merged.len()), (vec![0, 1, 2, 3, 4], 1));
    }

    #[test]
    fn near_sites_that_differ_are_kept() {
        assert_eq!(
            samples(&[0.0, 1e-8, 1.0], &[0.0, 9.0, 1.0], Conflicts::Refuse).unwrap().rows.len(),
            3
        );
    }

    #[test]
    fn bad_samples_are_named() {
        let refused = |sites: &[f64], values: &[f64]| {
            samples(sites, values, Conflicts::Refuse).unwrap_err().to_string()
        };
        assert_eq!(refused(&[], &[]), "there are no samples");
        let rows = "expected a row of values for each of 2 sites, found 1";
        assert_eq!(refused(&[1.0, 2.0], &[1.0]), rows);
        let site = "the site of row 1, column 0 is not finite";
        assert_eq!(refused(&[1.0, f64::NAN], &[1.0, 2.0]), site);
        let value = "the value of row 0, column 0 is not finite";
        assert_eq!(refused(&[1.0, 2.0], &[f64::INFINITY, 2.0]), value);
        let none = Mat::zeros(2, 0);
        let two = column(&[1.0, 2.0]);
        let of = |sites, values| Samples::new(sites, values, &[], Conflicts::Refuse).unwrap_err();
        assert_eq!(of(&none, &two).to_string(), "there are no inputs");
        assert_eq!(of(&two, &none).to_string(), "there are no values");
        assert_eq!(of(&two, &none).kind(), ErrorKind::Missing);
    }

    #[test]
    fn a_range_is_more_than_rounding() {
        let values = Mat::from_fn(2, 4, |i, o| [[1.0, 1e6, 0.0, 5.0], [-2.0, 1e6, 0.0, 5.1]][i][o]);
        let found = ranges(&values);
        assert_eq!(found[..3], [3.0, 100.0, 1.0]);
        assert!((found[3] - 0.1).abs() < 1e-12);
        // A large offset does not increase the range. The rounding of a sum is not a range.
        let values = Mat::from_fn(2, 3, |i, o| {
            [[1e9, 1e15, 0.3], [1e9 + 25.0, 1e15 + 25.0, 0.1 + 0.2]][i][o]
        });
        let found = ranges(&values);
        assert_eq!(found[..2], [25.0, 25.0]);
        assert!((found[2] - 0.3e-4).abs() < 1e-12);
    }

    #[test]
    fn weights_are_one_at_their_own_sample() {
        let found = Samples::of_weights(&column(&[0.0, 1.0, 3.0]), &LINE).unwrap();
        assert_eq!(found.values, Mat::<f64>::identity(3, 3));
        let twice = Samples::of_weights(&column(&[0.0, 1.0, 0.0]), &LINE).unwrap_err();
        assert_eq!(twice.to_string(), "rows 0 and 2 have the same site and different values");
    }
}
