//! Other solvers' functions by their own names and rules (METHOD §2.4, §2.7): they warn where a fit of ours
//! would be refused, as their originals return.
//! Cases of another implementation, held against ours: sites, values, options by SciPy's names, queries
//! and what it gives there.

pub mod published;
pub mod scipy;

use crate::scattered::problem::rows;
use crate::scattered::solver::samples::ranges;
use faer::Mat;
use scipy::{RbfInterpolator, ScipyOptions};
use serde::{Deserialize, Serialize};
use serde_json::Value;

/// The most that an output may deviate, over its range (METHOD §2.7).
pub const DEVIATION: f64 = 1e-9;
/// Reciprocal condition above which it must not.
pub const RCOND: f64 = 1e-10;

/// A file of cases.
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

/// What came of all cases.
#[derive(Clone, Debug, Serialize)]
pub struct CheckReport {
    /// Case by case.
    pub cases: Vec<CaseReport>,
    /// Cases that were compared and are well enough conditioned to be held to it.
    pub held: usize,
    /// Cases that were compared, but whose condition promises nothing.
    pub ill_conditioned: usize,
    /// Cases that could not be compared.
    pub skipped: usize,
    /// Held cases that deviate too far.
    pub failed: usize,
}

/// What came of a case.
#[derive(Clone, Debug, Serialize)]
pub struct CaseReport {
    /// Its name.
    pub name: String,
    /// The largest deviation over the output's range.
    pub deviation: Option<f64>,
    /// Reciprocal condition of what was solved, the worst of all queries' where each has its own.
    pub rcond: Option<f64>,
    /// Why it could not be compared.
    pub skipped: Option<String>,
}

impl Cases {
    /// Reads cases from JSON.
    ///
    /// # Errors
    /// If it is no JSON of this shape.
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
            // What is not a number is no small deviation.
            !case.deviation.is_some_and(|deviation| deviation <= DEVIATION)
        });
        let (held, failed) = (held.count(), failed.count());
        let all = cases.iter().filter(compared).count();
        CheckReport { held, failed, ill_conditioned: all - held, skipped: cases.len() - all, cases }
    }
}

impl CheckReport {
    /// Whether something was held, and all of it came out.
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
        let read = |what, of| rows(what, of).map_err(|error| error.to_string());
        let (sites, values) = (read("sites", &self.sites)?, read("values", &self.values)?);
        let (queries, expected) =
            (read("queries", &self.queries)?, read("expected", &self.expected)?);
        let options = match self.options {
            Value::Null => ScipyOptions::default(),
            options => serde_json::from_value(options).map_err(|error| error.to_string())?,
        };
        let (sites, values) = (matrix(&sites)?, matrix(&values)?);
        let fit =
            RbfInterpolator::new(&sites, &values, &options).map_err(|error| error.to_string())?;
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
            let (found, own) = fit.conditioned(query).map_err(|error| error.to_string())?;
            rcond = rcond.min(own);
            for (o, found) in found.iter().enumerate() {
                let deviation = (found - expected[(row, o)]).abs() / ranges[o];
                // Not `max`, which passes over what is not a number.
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
