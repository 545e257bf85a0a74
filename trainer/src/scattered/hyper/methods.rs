//! Methods that lower the energy (METHOD §3).
//!
//! - Variable projection (Golub and Pereyra 1973): L-BFGS moves centres and metric, and the coefficients are solved at
//!   every step. Directions of descent come from the last steps, and step lengths meet Wolfe's conditions (Nocedal and
//!   Wright 2006, §3.1 and algorithm 7.4).
//! - S1's dynamical system: centres, metric and coefficients move down the gradient of the energy, times ω.
//! - S1's random changes: a centre or the metric changes at random, and the coefficients are solved. A change that
//!   raises the energy by ΔE is accepted with probability e^(-ΔE/T).

use super::energy::{Energy, Parameters, Point};
use super::options::{Step, Trace};
use crate::numeric::columns::dot;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use std::collections::VecDeque;

/// Largest length of the first step, in units of u and of W.
const REACH: f64 = 0.1;
/// Number of steps that must together lower the energy by more than a share, and that share. Otherwise learning stops.
const SETTLED: (usize, f64) = (20, 1e-4);

/// Runs variable projection from a point, up to the limit of evaluations.
pub(super) fn variable_projection(
    energy: &Energy,
    mut here: Point,
    budget: usize,
    trace: &mut Trace,
) -> Point {
    let mut memory = Memory::default();
    let mut gradient = downhill(energy, &here);
    loop {
        let direction = memory.direction(&gradient, REACH);
        let slope = dot(&gradient, &direction);
        let at = |length: f64| {
            if trace.evaluations >= budget {
                return None;
            }
            trace.evaluations += 1;
            let there = energy.solved(stepped(&here.parameters, length, &direction));
            let gradient = downhill(energy, &there);
            Some((there.energy, dot(&gradient, &direction), (there, gradient)))
        };
        let found = if slope < 0.0 { search(here.energy, slope, at) } else { None };
        let Some((there, after)) = found else {
            if trace.evaluations < budget && memory.forget() {
                continue;
            }
            return here;
        };
        let mut step = flattened(&there.parameters);
        add(&mut step, -1.0, &flattened(&here.parameters));
        let mut change = after.clone();
        add(&mut change, -1.0, &gradient);
        // Wolfe's conditions ensure this, except for rounding.
        if dot(&step, &change) > 0.0 {
            memory.remember(step, change);
        }
        (here, gradient) = (there, after);
        trace.steps.push(Step { energy: here.energy, accepted: true });
        if is_settled(trace) {
            return here;
        }
    }
}

fn is_settled(trace: &Trace) -> bool {
    let (count, share) = SETTLED;
    let before = trace.steps.len().checked_sub(count + 1).map(|place| trace.steps[place].energy);
    let now = trace.steps.last().map(|step| step.energy);
    before.zip(now).is_some_and(|(before, now)| before - now <= share * before)
}

/// Returns the gradient by centres and metric. The gradient by the solved coefficients is 0.
fn downhill(energy: &Energy, point: &Point) -> Vec<f64> {
    flattened(&energy.gradient(point))
}

/// Joins the centres and the metric.
fn flattened(parameters: &Parameters) -> Vec<f64> {
    [parameters.centres.as_slice(), &parameters.metric].concat()
}

fn stepped(from: &Parameters, length: f64, direction: &[f64]) -> Parameters {
    let mut to = from.clone();
    let (of_centres, of_metric) = direction.split_at(to.centres.len());
    add(&mut to.centres, length, of_centres);
    add(&mut to.metric, length, of_metric);
    to
}

/// Runs the dynamical system from a point, up to the limit of evaluations; halves ω whenever the energy would rise.
pub(super) fn gradient_flow(
    energy: &Energy,
    mut here: Point,
    mut omega: f64,
    budget: usize,
    trace: &mut Trace,
) -> Point {
    let mut gradient = energy.gradient(&here);
    while trace.evaluations < budget {
        let parameters = descended(&here.parameters, -omega, &gradient);
        if parameters == here.parameters {
            break;
        }
        trace.evaluations += 1;
        let there = energy.at(parameters);
        let accepted = there.energy <= here.energy;
        if accepted {
            gradient = energy.gradient(&there);
            here = there;
        } else {
            omega *= 0.5;
        }
        trace.steps.push(Step { energy: here.energy, accepted });
    }
    here
}

fn descended(from: &Parameters, omega: f64, gradient: &Parameters) -> Parameters {
    let mut to = from.clone();
    add(&mut to.centres, omega, &gradient.centres);
    add(&mut to.metric, omega, &gradient.metric);
    add(&mut to.coefficients, omega, &gradient.coefficients);
    to
}

/// Number of sizes of a change: the reach, a half of it, a quarter, and so on, with equal probability.
///
/// The sizes do not depend on the point, so a change and its reverse have the same probability.
const HALVES: u32 = 8;

/// Random changes of a point.
pub(super) struct Walk<'a> {
    /// Energy to lower.
    pub(super) energy: &'a Energy,
    /// Largest change of a number.
    pub(super) reach: f64,
    /// T at the start and at the end; linear in the number of evaluations.
    pub(super) temperatures: [f64; 2],
    /// Largest number of evaluations of the trace.
    pub(super) budget: usize,
}

impl Walk<'_> {
    /// Changes a point; returns the best point of all.
    pub(super) fn run(&self, mut here: Point, random: &mut ChaCha8Rng, trace: &mut Trace) -> Point {
        let entries = 0..here.parameters.metric.len();
        let entries: Vec<usize> = entries.filter(|&entry| self.energy.learns(entry)).collect();
        let [first, last] = self.temperatures;
        let begin = trace.evaluations;
        let mut best = here.clone();
        while trace.evaluations < self.budget {
            let done = (trace.evaluations - begin) as f64 / (self.budget - begin) as f64;
            let temperature = first + (last - first) * done;
            let there = self.energy.solved(self.changed(&here.parameters, &entries, random));
            trace.evaluations += 1;
            let rise = there.energy - here.energy;
            let accepted = rise <= 0.0
                || (temperature > 0.0 && random.random::<f64>() < libm::exp(-rise / temperature));
            if accepted {
                here = there;
            }
            if here.energy < best.energy {
                best = here.clone();
            }
            trace.steps.push(Step { energy: here.energy, accepted });
        }
        best
    }

    /// Changes a centre, or the learned entries of the metric.
    fn changed(&self, from: &Parameters, entries: &[usize], random: &mut ChaCha8Rng) -> Parameters {
        let mut to = from.clone();
        let input_len = self.energy.input_len;
        let group_len = to.centres.len() / input_len + usize::from(!entries.is_empty());
        let group = random.random_range(0..group_len);
        let size = self.reach / f64::from(1u32 << random.random_range(0..HALVES));
        let mut change = || size * (2.0 * random.random::<f64>() - 1.0);
        match to.centres.chunks_exact_mut(input_len).nth(group) {
            Some(centre) => centre.iter_mut().for_each(|t| *t += change()),
            None => entries.iter().for_each(|&entry| to.metric[entry] += change()),
        }
        to
    }
}

/// Number of steps in the memory of L-BFGS.
const MEMORY: usize = 20;
/// Least fall of the value, as a share of the first slope: Armijo's condition.
const FALL: f64 = 1e-4;
/// Share of the first slope that may remain: the curvature condition.
const LEFT: f64 = 0.9;
/// Largest number of lengths for a step. After so many halvings a step is below any rounding.
const TRIALS: usize = 60;

/// Last steps, each with the change of the gradient.
#[derive(Default)]
struct Memory(VecDeque<(Vec<f64>, Vec<f64>)>);

impl Memory {
    /// Stores a step along which the slope grew.
    fn remember(&mut self, step: Vec<f64>, change: Vec<f64>) {
        if self.0.len() == MEMORY {
            self.0.pop_front();
        }
        self.0.push_back((step, change));
    }

    /// Removes all steps; returns false if there were none.
    fn forget(&mut self) -> bool {
        !std::mem::take(&mut self.0).is_empty()
    }

    /// Returns a direction of descent: Newton's direction for the curvature that the stored steps show.
    ///
    /// Without stored steps, the direction is at most `reach` long.
    fn direction(&self, gradient: &[f64], reach: f64) -> Vec<f64> {
        let mut direction: Vec<f64> = gradient.iter().map(|g| -g).collect();
        let Some((step, change)) = self.0.back() else {
            let length = dot(gradient, gradient).sqrt();
            direction.iter_mut().for_each(|d| *d *= (reach / length).min(1.0));
            return direction;
        };
        let mut shares = Vec::with_capacity(self.0.len());
        for (step, change) in self.0.iter().rev() {
            let share = dot(step, &direction) / dot(step, change);
            add(&mut direction, -share, change);
            shares.push(share);
        }
        let scale = dot(step, change) / dot(change, change);
        direction.iter_mut().for_each(|d| *d *= scale);
        for ((step, change), share) in self.0.iter().zip(shares.into_iter().rev()) {
            let back = dot(change, &direction) / dot(step, change);
            add(&mut direction, share - back, step);
        }
        direction
    }
}

/// Finds a step length that meets Wolfe's conditions, by doubling and bisection; `None` if no length is found or `at`
/// returns `None`.
///
/// - `at`: returns the value at a length, the slope along the step, and the caller's point.
fn search<P>(
    value: f64,
    slope: f64,
    mut at: impl FnMut(f64) -> Option<(f64, f64, P)>,
) -> Option<P> {
    let (mut low, mut high, mut length) = (0.0, f64::INFINITY, 1.0);
    for _ in 0..TRIALS {
        let (found, left, point) = at(length)?;
        // A NaN has not fallen.
        let fallen = found <= value + FALL * length * slope;
        if fallen && left >= LEFT * slope {
            return Some(point);
        }
        *(if fallen { &mut low } else { &mut high }) = length;
        length = if high.is_finite() { 0.5 * (low + high) } else { 2.0 * low };
    }
    None
}

/// Adds a multiple of b to a.
fn add(a: &mut [f64], factor: f64, b: &[f64]) {
    a.iter_mut().zip(b).for_each(|(a, b)| *a += factor * b);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_along_the_axes_of_a_bowl_give_newtons_direction() {
        let curvatures = [1.0, 10.0, 100.0];
        let mut memory = Memory::default();
        for (axis, curvature) in curvatures.into_iter().enumerate() {
            let along = |length: f64| {
                let mut step = vec![0.0; 3];
                step[axis] = length;
                step
            };
            memory.remember(along(0.5), along(0.5 * curvature));
        }
        let direction = memory.direction(&[3.0, -20.0, 700.0], 1.0);
        for (found, newton) in direction.iter().zip([-3.0, 2.0, -7.0]) {
            assert!((found - newton).abs() < 1e-12, "{direction:?}");
        }
        assert!(memory.forget() && !memory.forget());
        assert_eq!(memory.direction(&[3.0, 4.0], 2.5), [-1.5, -2.0]);
    }

    #[test]
    fn lengths_meet_both_conditions() {
        // Curves that are steep at the start, with the minimum far, near, and behind a rise.
        type Curve = fn(f64) -> (f64, f64);
        let curves: [Curve; 3] = [
            |x| ((x - 40.0) * (x - 40.0), 2.0 * (x - 40.0)),
            |x| ((x - 0.01) * (x - 0.01), 2.0 * (x - 0.01)),
            |x| (-x.sin() + 0.02 * x * x, 0.04 * x - x.cos()),
        ];
        for curve in curves {
            let (value, slope) = curve(0.0);
            let length = search(value, slope, |x| Some((curve(x).0, curve(x).1, x))).unwrap();
            let (found, left) = curve(length);
            assert!(found <= value + FALL * length * slope && left >= LEFT * slope, "{length}");
        }
        let uphill = search(0.0, -1.0, |x| Some((x, 1.0, ())));
        assert!(uphill.is_none());
        let endless = search(0.0, -1.0, |x| Some((f64::NAN, x, ())));
        assert!(endless.is_none());
    }
}
