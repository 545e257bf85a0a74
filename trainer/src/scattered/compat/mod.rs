//! Functions of other solvers, by their own names and rules (METHOD §2.4, §2.7), and a comparison with reference
//! results.
//!
//! These solvers warn where our fit would be refused, because the originals return a result. A reference case has
//! sites, values, options by SciPy's names, queries, and the results of another implementation.

pub mod published;
pub mod scipy;

use crate::Error;
use crate::scattered::problem::rows;
use crate::scattered::solver::samples::ranges;
use faer::Mat;
use scipy::{RbfInterpolator, ScipyOptions};
use serde::{Deserialize, Serialize};
use serde_json::Value;

/// Largest allowed deviation of an output, over its range (METHOD §2.7).
pub const DEVIATION: f64 = 1e-9;
/// Reciprocal condition above which the deviation is limited.
pub const RCOND: f64 = 1e-10;

/// File of reference cases.
#[derive(Deserialize)]
pub struct Cases {
    cases: Vec<Case>,
}

#[derive(Deserialize)]
struct Case {
    name: String,
    #[serde(default)]
    options: Value,
    sites: Value,
    values: Value,
    queries: Value,
    expected: Value,
}

/// Results of all cases.
#[derive(Clone, Debug, Serialize)]
pub struct CheckReport {
    /// Results, in the order of the cases.
    pub cases: Vec<CaseReport>,
    /// Number of compared cases whose condition is good enough for the limit.
    pub held: usize,
    /// Number of compared cases whose condition is too poor for the limit.
    pub ill_conditioned: usize,
    /// Number of cases that could not be compared.
    pub skipped: usize,
    /// Number of well-conditioned cases with a deviation above the limit.
    pub failed: usize,
}

/// Result of a case.
#[derive(Clone, Debug, Serialize)]
pub struct CaseReport {
    /// Name of the case.
    pub name: String,
    /// Largest deviation over the output's range.
    pub deviation: Option<f64>,
    /// Reciprocal condition of the solved system; the worst if each query has its own system.
    pub rcond: Option<f64>,
    /// Reason why the case could not be compared.
    pub skipped: Option<String>,
}

impl Cases {
    /// Reads cases from JSON.
    ///
    /// # Errors
    /// If the text is not JSON of this form.
    pub fn read(text: &[u8]) -> Result<Self, serde_json::Error> {
        serde_json::from_slice(text)
    }

    /// Evaluates every case.
    pub fn check(self) -> CheckReport {
        let cases: Vec<CaseReport> = self.cases.into_iter().map(Case::check).collect();
        let compared = |case: &&CaseReport| case.deviation.is_some();
        let is_held = |case: &&CaseReport| case.rcond.is_some_and(|rcond| rcond > RCOND);
        let held = cases.iter().filter(compared).filter(is_held);
        let failed = held.clone().filter(|case| {
            // A NaN fails.
            !case.deviation.is_some_and(|deviation| deviation <= DEVIATION)
        });
        let (held, failed) = (held.count(), failed.count());
        let all = cases.iter().filter(compared).count();
        CheckReport { held, failed, ill_conditioned: all - held, skipped: cases.len() - all, cases }
    }
}

impl CheckReport {
    /// Returns true if at least one case was held to the limit and no case failed.
    pub fn passes(&self) -> bool {
        self.held > 0 && self.failed == 0
    }
}

impl Case {
    fn check(self) -> CaseReport {
        let name = self.name.clone();
        match self.deviation() {
            Ok((deviation, rcond)) => {
                CaseReport { name, deviation: Some(deviation), rcond: Some(rcond), skipped: None }
            }
            Err(why) => CaseReport { name, deviation: None, rcond: None, skipped: Some(why) },
        }
    }

    fn deviation(self) -> Result<(f64, f64), String> {
        let said = |error: Error| error.to_string();
        let read = |what, of| rows(what, of).map_err(said);
        let (sites, values) = (read("sites", &self.sites)?, read("values", &self.values)?);
        let (queries, expected) =
            (read("queries", &self.queries)?, read("expected", &self.expected)?);
        let options = match self.options {
            Value::Null => ScipyOptions::default(),
            options => serde_json::from_value(options).map_err(|error| error.to_string())?,
        };
        let (sites, values) = (matrix(&sites)?, matrix(&values)?);
        let fit = RbfInterpolator::new(&sites, &values, &options).map_err(said)?;
        if queries.is_empty() || queries.len() != expected.len() {
            let (queries, expected) = (queries.len(), expected.len());
            return Err(format!("expected results of {queries} queries, found {expected}"));
        }
        let expected = matrix(&expected)?;
        if expected.ncols() != values.ncols() {
            let (found, wanted) = (expected.ncols(), values.ncols());
            return Err(format!("expected {wanted} results a query, found {found}"));
        }
        let ranges = ranges(&expected);
        let (mut most, mut rcond) = (0.0f64, 1.0f64);
        for (row, query) in queries.iter().enumerate() {
            let (found, own) = fit.evaluate(query).map_err(said)?;
            rcond = rcond.min(own);
            for (o, found) in found.iter().enumerate() {
                let deviation = (found - expected[(row, o)]).abs() / ranges[o];
                // Not `max`, which ignores a NaN.
                most = if deviation <= most { most } else { deviation };
            }
        }
        Ok((most, rcond))
    }
}

fn matrix(rows: &[Vec<f64>]) -> Result<Mat<f64>, String> {
    let width = rows.first().map_or(0, Vec::len);
    match rows.iter().position(|row| row.len() != width) {
        Some(row) => Err(format!("row {row}: expected {width} numbers, found {}", rows[row].len())),
        None => Ok(Mat::from_fn(rows.len(), width, |i, c| rows[i][c])),
    }
}
