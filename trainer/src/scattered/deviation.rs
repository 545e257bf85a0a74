//! Difference between a baked function and f64, measured by the runtime at the samples and between them (METHOD §2.7).

use super::bake::part;
use super::model::{
    Figures, Input, InputKind, KernelModel, Output, OutputKind, features, query_numbers,
};
use super::solver::refusal::Refusal;
pub(crate) use super::solver::refusal::too_far;
use super::sum::KernelSum;
use crate::Error;
use crate::bake::bake;
use crate::regression::confidence::Fade;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use sinew_runtime::format::Space;
use sinew_runtime::kernel::{Kernel, Normalise, QueryRule};
use sinew_runtime::{KernelMap, Model};
use std::ops::Range;

/// Default limit of a baked function's deviation, over the value's range.
pub const F32_ERROR: f64 = 1e-3;
/// Share of the limit within which a width is preferred. The deviation is measured at some queries and must hold at
/// all.
pub const ROOM: f64 = 0.1;
/// Queries between the samples.
const BETWEEN: usize = 1000;

/// Queries of a function for the runtime and for f64, and the largest allowed deviation.
#[derive(Clone, Debug)]
pub struct Probe {
    /// Inputs, rotations as quaternions.
    inputs: Vec<Input>,
    /// Samples' numbers of the inputs, n rows.
    sites: Vec<Vec<f64>>,
    /// Samples, then queries between them.
    queries: Vec<Query>,
    /// Range of each value, m.
    ranges: Vec<f64>,
    /// Largest allowed deviation, over the range.
    pub(super) limit: f64,
}

#[derive(Clone, Debug)]
struct Query {
    /// Numbers that the runtime takes.
    numbers: Vec<f32>,
    /// Features in f64.
    features: Vec<f64>,
}

impl Probe {
    /// Makes queries: the sites of the samples, and 1,000 points between random pairs of sites.
    ///
    /// - `sites`: sites as given, n rows.
    /// - `ranges`: range of each value of the function, m, above 0.
    /// - `limit`: largest allowed deviation, over the range.
    ///
    /// # Errors
    /// Errors of [`query_numbers`] for a site; if a quaternion is zero or not finite.
    pub fn new(
        inputs: &[Input],
        sites: &[Vec<f64>],
        ranges: Vec<f64>,
        limit: f64,
    ) -> Result<Self, Error> {
        let sites = sites.iter().map(|site| query_numbers(inputs, site));
        let sites = sites.collect::<Result<Vec<_>, _>>()?;
        let inputs: Vec<Input> = inputs.iter().map(of_quaternions).collect();
        let query = |exact: &[f64]| -> Result<Query, Error> {
            let numbers = exact.iter().map(|x| *x as f32).collect();
            Ok(Query { numbers, features: features(&inputs, exact)? })
        };
        let mut queries = sites.iter().map(|site| query(site)).collect::<Result<Vec<_>, _>>()?;
        let mut random = ChaCha8Rng::seed_from_u64(0);
        for _ in 0..BETWEEN {
            let [a, b] = [(); 2].map(|()| &sites[random.random_range(0..sites.len())]);
            let between = between(&inputs, a, b, random.random());
            // The middle of opposite quaternions is no rotation.
            queries.extend(query(&between).ok());
        }
        Ok(Self { inputs, sites, queries, ranges, limit })
    }

    /// Measures the largest deviation of a baked function from f64, over the value's range.
    ///
    /// The deviation is infinite if the file contains or returns a number that is not finite.
    ///
    /// - `exact`: computes all values, m, from features, in f64.
    pub fn deviation(&self, sum: &KernelSum, exact: impl Fn(&[f64]) -> Vec<f64> + Sync) -> f64 {
        // The runtime refuses a file with numbers that are not finite in f32.
        let bytes = part(&self.model(sum)).and_then(|part| bake(Space::default(), &[part]));
        let Some(file) = bytes.ok().and_then(|bytes| Model::from_bytes(bytes).ok()) else {
            return f64::INFINITY;
        };
        let of = |query: &Query| {
            let Some(map) = file.first::<KernelMap>() else { return f64::INFINITY };
            let mut found = vec![0.0; map.result_len()];
            let mut scratch = vec![0.0; map.counts().scratch_len()];
            if map.evaluate(&query.numbers, &mut scratch, &mut found).is_err() {
                return f64::INFINITY;
            }
            let found: Vec<f64> = found.into_iter().map(f64::from).collect();
            self.largest_difference(&found, &exact(&query.features))
        };
        self.queries.par_iter().map(of).reduce(|| 0.0, f64::max)
    }

    /// Checks that a function's deviation is within the limit; returns the deviation.
    ///
    /// # Errors
    /// If the deviation is above the limit.
    pub fn check(
        &self,
        sum: &KernelSum,
        exact: impl Fn(&[f64]) -> Vec<f64> + Sync,
    ) -> Result<f64, Error> {
        match self.deviation(sum, &exact) {
            deviation if deviation <= self.limit => Ok(deviation),
            deviation => Err(self.refusal(deviation, sum.kernel, exact)),
        }
    }

    /// Returns the error of a deviation above the limit.
    ///
    /// An input or a value is the cause if rounding it to f32 alone changes the exact function by more than the limit.
    ///
    /// - `exact`: computes all values, m, from features, in f64.
    pub(super) fn refusal(
        &self,
        deviation: f64,
        kernel: Kernel,
        exact: impl Fn(&[f64]) -> Vec<f64>,
    ) -> Error {
        let mut first = 0;
        let own = self.inputs.iter().map(|input| {
            let own = first..first + input.kind.number_len();
            first = own.end;
            let effects =
                self.sites.iter().map(|site| self.rounding_effect(site, own.clone(), &exact));
            let numbers = self.sites.iter().flat_map(|site| &site[own.clone()]);
            (input, effects.fold(0.0, f64::max), largest_magnitude(numbers))
        });
        let most = own.max_by(|a, b| a.1.total_cmp(&b.1));
        let values: Vec<Vec<f64>> =
            self.queries.iter().map(|query| exact(&query.features)).collect();
        let of_value = |o: usize| {
            let rounded = values.iter().map(|all| (f64::from(all[o] as f32) - all[o]).abs());
            let share = rounded.fold(0.0, f64::max) / self.ranges[o];
            (share, largest_magnitude(values.iter().map(|all| &all[o])), self.ranges[o])
        };
        let value = (0..self.ranges.len()).map(of_value).max_by(|a, b| a.0.total_cmp(&b.0));
        let limit = self.limit;
        let (whose, largest, with) = match (most, value) {
            (Some((Input { name, .. }, share, largest)), _) if share > limit => {
                (format!("the input \"{name}\""), largest, String::new())
            }
            (_, Some((share, largest, range))) if share > limit => {
                ("the values".to_owned(), largest, format!(" with a range of {range:.3e}"))
            }
            _ => return Refusal::Deviation { deviation, limit, kernel }.into(),
        };
        let remedy = format!(
            "take the offset off {whose} (numbers up to {largest:.3e}{with} do not fit single precision)"
        );
        too_far(deviation, limit, remedy)
    }

    /// Measures the change of the exact function if some numbers of a site are rounded to f32.
    fn rounding_effect(
        &self,
        site: &[f64],
        numbers: Range<usize>,
        exact: impl Fn(&[f64]) -> Vec<f64>,
    ) -> f64 {
        let mut rounded = site.to_vec();
        rounded[numbers].iter_mut().for_each(|x| *x = f64::from(*x as f32));
        let at = |numbers: &[f64]| Some(exact(&features(&self.inputs, numbers).ok()?));
        let both = at(site).zip(at(&rounded));
        both.map_or(f64::INFINITY, |(exact, rounded)| self.largest_difference(&rounded, &exact))
    }

    /// Returns the largest difference of values, over the range; infinite if a difference is not a number.
    fn largest_difference(&self, found: &[f64], exact: &[f64]) -> f64 {
        let share = |((found, exact), range): ((&f64, &f64), &f64)| {
            let share = (found - exact).abs() / range;
            // `max` would ignore a NaN.
            if share.is_nan() { f64::INFINITY } else { share }
        };
        found.iter().zip(exact).zip(&self.ranges).map(share).fold(0.0, f64::max)
    }

    /// Makes a model whose outputs are the function's values, without bounds or a fade.
    fn model(&self, sum: &KernelSum) -> KernelModel {
        let range = [f32::MIN, f32::MAX].map(f64::from);
        let value = |_| Output { name: String::new(), kind: OutputKind::FREE };
        KernelModel {
            name: String::new(),
            inputs: self.inputs.clone(),
            outputs: (0..sum.value_len()).map(value).collect(),
            sum: sum.clone(),
            ranges: vec![range; sum.shift.len()],
            query: QueryRule::Free,
            fade: Fade { start: 0.0, end: 0.0 },
            normalise: Normalise::Never,
            variance: None,
            fit: Figures::default(),
        }
    }
}

/// Returns the largest magnitude of the numbers.
fn largest_magnitude<'a>(numbers: impl Iterator<Item = &'a f64>) -> f64 {
    numbers.fold(0.0, |most, x| most.max(x.abs()))
}

/// Returns an input with the numbers that the runtime takes: a rotation is a quaternion.
fn of_quaternions(input: &Input) -> Input {
    let kind = match input.kind {
        InputKind::Rotation { feature, .. } => InputKind::Rotation { feature, order: None },
        kind => kind,
    };
    Input { name: input.name.clone(), kind, weight: input.weight }
}

/// Interpolates between a and b by a share, and rounds each number to f32. Rotations turn the shorter way.
fn between(inputs: &[Input], a: &[f64], b: &[f64], share: f64) -> Vec<f64> {
    let (mut a, mut b, mut out) = (a, b, Vec::with_capacity(a.len()));
    for Input { kind, .. } in inputs {
        let (own, other);
        (own, a) = a.split_at(kind.number_len());
        (other, b) = b.split_at(kind.number_len());
        let cosine: f64 = own.iter().zip(other).map(|(a, b)| a * b).sum();
        let is_opposite = matches!(kind, InputKind::Rotation { .. }) && cosine < 0.0;
        let sign = if is_opposite { -1.0 } else { 1.0 };
        let number = |(a, b): (&f64, &f64)| f64::from((a + share * (sign * b - a)) as f32);
        out.extend(own.iter().zip(other).map(number));
    }
    out
}
