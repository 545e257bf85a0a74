//! Finds parameters from points: the parameters at which the points lie where they are seen (S1 §2's attitude, METHOD
//! §6.2).
//!
//! The search takes a few damped Gauss-Newton steps on the map, from the start of the nearest shape. It accepts any set
//! of visible points. A second map from points to parameters would have to be trained for each set of visible points.

use super::fit::{angles_of, given, names_of, with_features};
use super::object::{ObjectMap, centred, norm};
use super::set::Values;
use crate::Error;
use crate::scattered::model::{InputKind, KernelModel, features};
use nalgebra::{DMatrix, DVector};

/// Largest number of steps.
const STEPS: usize = 60;
/// First damping, as a share of the diagonal of the normal matrix, and the factor of its changes.
const DAMPING: (f64, f64) = (1e-3, 10.0);
/// Damping above which the search stops.
const MOST_DAMPING: f64 = 1e12;
/// Relative change of the error at which the search stops.
const FOUND: f64 = 1e-14;
/// Largest number of starts if all places of each parameter are combined.
const STARTS: usize = 1000;
/// Step of an input for the central difference.
const DIFFERENCE: f64 = 1e-4;

/// Parameters found from points, and the remaining error.
#[derive(Clone, Debug)]
pub struct Found {
    /// Values of the parameters.
    pub values: Values,
    /// RMS distance of the map's points from the given points, moved and scaled onto them, pixels.
    pub rms: f64,
}

impl ObjectMap {
    /// Finds the parameters at which the object has given points, up to a shift and a scale.
    ///
    /// For a transferred object the points are the instance's. The deformation depends on the parameters, so the search
    /// solves for both (METHOD §6.6).
    ///
    /// - `points`: K points, pixels; `None` if a point is hidden.
    /// - `starts`: parameters to start from: those of the training views, those of the previous frame, or [`starts`].
    ///   The search begins with the start of the nearest shape.
    ///
    /// # Errors
    /// The values of a start are invalid.
    pub fn find(&self, points: &[Option<[f64; 2]>], starts: &[Values]) -> Result<Found, Error> {
        let seen: Vec<usize> = (0..points.len()).filter(|&k| points[k].is_some()).collect();
        let target: Vec<[f64; 2]> = points.iter().copied().flatten().collect();
        let problem = Problem { object: self, seen: &seen, target: &target };
        let start = problem.nearest(starts)?;
        problem.solve(given(&self.model.inputs, &start)?)
    }
}

/// Lists starts over the whole training range, for a search without prior knowledge. Numbers start at the middle and
/// both ends of their range. A single angle starts all the way round, and several angles at poses of a face. If there
/// are too many combinations, each start moves one parameter off its middle.
pub fn starts(model: &KernelModel) -> Vec<Values> {
    // Places of each parameter, the middle first.
    let mut axes: Vec<(&str, Vec<f64>)> = Vec::new();
    for (input, first) in with_features(&model.inputs) {
        let [low, high] = model.ranges[first];
        let own = names_of(std::slice::from_ref(input));
        let places: Vec<f64> = match (input.kind, own.len()) {
            (InputKind::Rotation { .. }, 1) => (0..12).map(|step| 30.0 * f64::from(step)).collect(),
            (InputKind::Rotation { .. }, _) => vec![0.0, -40.0, -15.0, 15.0, 40.0],
            _ => vec![0.5 * (low + high), low, high],
        };
        axes.extend(own.into_iter().map(|name| (name, places.clone())));
    }
    let with = |values: &Values, name: &str, place: f64| {
        let mut values = values.clone();
        values.insert(name.to_owned(), place);
        values
    };
    let middle: Values =
        axes.iter().map(|(name, places)| ((*name).to_owned(), places[0])).collect();
    let mut out = vec![middle.clone()];
    let all = axes.iter().map(|(_, places)| places.len()).try_fold(1, usize::checked_mul);
    for (name, places) in &axes {
        let from = match all {
            Some(all) if all <= STARTS => out.clone(),
            _ => vec![middle.clone()],
        };
        for values in from {
            out.extend(places[1..].iter().map(|&place| with(&values, name, place)));
        }
    }
    out
}

struct Problem<'a> {
    object: &'a ObjectMap,
    /// Indices of the given points.
    seen: &'a [usize],
    /// Positions of the given points.
    target: &'a [[f64; 2]],
}

/// A state of the search: the inputs of the map, and the similarity from the target points to the map's points.
struct Guess {
    given: Vec<f64>,
    scale: f64,
    shift: [f64; 2],
}

impl Problem<'_> {
    /// Returns the start with the nearest shape.
    fn nearest(&self, starts: &[Values]) -> Result<Values, Error> {
        let shape = |points: &[[f64; 2]]| {
            let own = centred(points).0;
            let size = norm(&own).max(f64::MIN_POSITIVE);
            own.into_iter().map(|point| point.map(|x| x / size)).collect::<Vec<_>>()
        };
        let own = shape(self.target);
        let mut best = (f64::INFINITY, None);
        for values in starts {
            let points = self.object.points(values)?;
            let other = shape(&self.seen_of(&points));
            let apart = own.as_flattened().iter().zip(other.as_flattened());
            let squares = apart.map(|(a, b)| (a - b) * (a - b)).sum::<f64>();
            if squares < best.0 {
                best = (squares, Some(values));
            }
        }
        Ok(best.1.cloned().unwrap_or_default())
    }

    fn solve(&self, given: Vec<f64>) -> Result<Found, Error> {
        let inputs = &self.object.model.inputs;
        // Numbers that have a name.
        let free = inputs.iter().flat_map(angles_of).enumerate();
        let free = free.filter(|(_, name)| !name.is_empty()).map(|(at, _)| at);
        let free: Vec<usize> = free.collect();
        let points = self.points(&given)?;
        let (own, other) = (centred(self.target), centred(&points));
        let scale = norm(&other.0) / norm(&own.0).max(f64::MIN_POSITIVE);
        let shift = [0, 1].map(|axis| other.1[axis] - scale * own.1[axis]);
        let mut guess = Guess { given, scale, shift };
        let mut residuals = self.residuals(&guess)?;
        let mut damping = DAMPING.0;
        for _ in 0..STEPS {
            let jacobian = self.jacobian(&guess, &free)?;
            let normal = jacobian.transpose() * &jacobian;
            let slope = jacobian.transpose() * &residuals;
            let before = residuals.norm_squared();
            let mut is_better = false;
            while damping < MOST_DAMPING {
                let mut damped = normal.clone();
                for i in 0..damped.nrows() {
                    damped[(i, i)] += damping * normal[(i, i)].max(f64::MIN_POSITIVE);
                }
                let step = damped.cholesky().map(|factor| factor.solve(&slope));
                let next = step.map(|step| guess.moved(&free, &step));
                if let Some(next) = next
                    && let Ok(left) = self.residuals(&next)
                    && left.norm_squared() < before
                {
                    (guess, residuals, is_better) = (next, left, true);
                    damping /= DAMPING.1;
                    break;
                }
                damping *= DAMPING.1;
            }
            if !is_better || before - residuals.norm_squared() < FOUND * before {
                break;
            }
        }
        let names = names_of(inputs).into_iter().map(str::to_owned);
        let values = names.zip(free.iter().map(|&at| guess.given[at])).collect();
        let rms = (residuals.norm_squared() / self.target.len().max(1) as f64).sqrt();
        Ok(Found { values, rms })
    }

    /// Evaluates the given points.
    fn points(&self, given: &[f64]) -> Result<Vec<[f64; 2]>, Error> {
        Ok(self.seen_of(&self.object.at(given)?))
    }

    /// Selects the given points of K points.
    fn seen_of(&self, points: &[[f64; 2]]) -> Vec<[f64; 2]> {
        self.seen.iter().map(|&k| points[k]).collect()
    }

    /// Returns the target points, moved and scaled, less the map's points: two numbers for each given point.
    fn residuals(&self, guess: &Guess) -> Result<DVector<f64>, Error> {
        let points = self.points(&guess.given)?;
        let (own, target) = (points.as_flattened(), self.target.as_flattened());
        let moved = |at: usize| guess.scale * target[at] + guess.shift[at % 2];
        Ok(DVector::from_fn(own.len(), |at, _| moved(at) - own[at]))
    }

    /// Returns the negative derivatives of the residuals by parameters, by scale and by shift.
    fn jacobian(&self, guess: &Guess, free: &[usize]) -> Result<DMatrix<f64>, Error> {
        let model = &self.object.model;
        let at = |given: &[f64]| features(&model.inputs, given);
        let by_features = model.sum.jacobian(&at(&guess.given)?);
        let numbers = model.evaluate(&guess.given)?.numbers;
        let target = self.target.as_flattened();
        let mut out = DMatrix::zeros(target.len(), free.len() + 3);
        for (column, &number) in free.iter().enumerate() {
            let step = |sign: f64| {
                let mut given = guess.given.clone();
                given[number] += sign * DIFFERENCE;
                at(&given)
            };
            let (after, before) = (step(1.0)?, step(-1.0)?);
            let slope = |output: usize| {
                let ends = after.iter().zip(&before).enumerate();
                let slopes = ends.map(|(f, (a, b))| by_features[(output, f)] * (a - b));
                slopes.sum::<f64>() / (2.0 * DIFFERENCE)
            };
            let slopes: Vec<f64> = (0..numbers.len()).map(slope).collect();
            let own = self.seen_of(&self.object.slopes(&numbers, &slopes));
            own.as_flattened().iter().enumerate().for_each(|(at, x)| out[(at, column)] = *x);
        }
        for (at, x) in target.iter().enumerate() {
            out[(at, free.len())] = -x;
            out[(at, free.len() + 1 + at % 2)] = -1.0;
        }
        Ok(out)
    }
}

impl Guess {
    fn moved(&self, free: &[usize], step: &DVector<f64>) -> Self {
        let mut given = self.given.clone();
        free.iter().enumerate().for_each(|(at, &number)| given[number] += step[at]);
        let last = free.len();
        let shift = [self.shift[0] + step[last + 1], self.shift[1] + step[last + 2]];
        Self { given, scale: self.scale + step[last], shift }
    }
}
