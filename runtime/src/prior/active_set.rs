//! Least squares between bounds. An active-set method holds many weights at a bound at a time.
//!
//! The method takes projected Newton steps (Bertsekas, Projected Newton methods for optimization
//! problems with simple constraints, SIAM J. Control and Optimization 1982). A round solves for the
//! free weights, cuts the solution to the bounds, and holds the weights that the gradient presses
//! against a bound. The cost falls in every round, so no set of held weights repeats. The solution
//! depends only on the held weights, not on the path of the search.

use super::packed::{dot, factor, multiply, rows, solve};

/// Rounds after which the search stops. No test with 53 shapes needed 20.
pub(super) const ROUNDS_MAX: u32 = 100;
/// Least share of a step in the line search.
const STEP_MIN: f64 = 1.0e-9;
/// Tolerance at a bound for rounding, relative to the bounds' span.
const SLACK: f64 = 1.0e-10;

/// Least share of a diagonal entry that the factor must keep. A smaller share is rounding: with
/// pins so stiff nothing of the prior is left.
const SHARE_MIN: f64 = 1.0e-13;

/// The step is free.
pub(super) const FREE: f64 = 0.0;
/// The step is held at its lower bound.
pub(super) const LOW: f64 = -1.0;
/// The step is held at its upper bound.
pub(super) const HIGH: f64 = 1.0;
/// The step keeps its weight at 0, for any gradient.
pub(super) const ZERO: f64 = 2.0;

/// Minimises `½ dᵀ H d - gᵀ d` over steps d of n weights between bounds.
pub(super) struct ActiveSet<'a> {
    /// H, packed.
    pub(super) hessian: &'a [f64],
    /// g, the right-hand side.
    pub(super) rhs: &'a [f64],
    /// Lower and upper bounds of the steps; infinite without bounds.
    pub(super) low: &'a [f64],
    pub(super) high: &'a [f64],
    /// Steps that bring the weights to 0.
    pub(super) zero: &'a [f64],
    /// State of each step: [`FREE`], [`LOW`], [`HIGH`] or [`ZERO`].
    pub(super) held: &'a mut [f64],
    /// Factor of the rows and columns of H of the free steps, packed.
    pub(super) factor: &'a mut [f64],
    /// Whether `factor` belongs to `held`.
    pub(super) is_factored: bool,
    pub(super) is_bounded: bool,
    /// d.
    pub(super) step: &'a mut [f64],
    /// Solution of a round: held steps fixed, free steps without bounds.
    pub(super) solution: &'a mut [f64],
    /// H d - g, the gradient.
    pub(super) slope: &'a mut [f64],
    /// The free steps packed together, or a trial step.
    pub(super) free: &'a mut [f64],
}

/// Result of a search.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum End {
    /// The step is the minimum.
    Least,
    /// The step is within the bounds, and may not be the minimum.
    Cut,
    /// H has no factor.
    NoFactor,
}

impl ActiveSet<'_> {
    /// Searches for the minimum, and returns the number of rounds.
    pub(super) fn search(&mut self) -> (End, u32) {
        let mut cost = f64::INFINITY;
        self.step.fill(0.0);
        for round in 1..=ROUNDS_MAX {
            if !self.solve_free() {
                return (End::NoFactor, round);
            }
            if !self.is_bounded {
                copy(self.step, self.solution);
                return (End::Least, round);
            }
            if self.is_within() {
                copy(self.step, self.solution);
                cost = self.cost_of(Which::Step);
                if !self.update_held() {
                    return (End::Least, round);
                }
            } else {
                let Some(less) = self.line_search(cost) else { return (End::Cut, round) };
                cost = less;
                self.update_held();
            }
        }
        (End::Cut, ROUNDS_MAX)
    }

    /// Returns the weight after the step.
    pub(super) fn weight(&self, index: usize) -> f64 {
        let step = self.step.get(index).zip(self.zero.get(index));
        step.map_or(0.0, |(step, zero)| step - zero)
    }

    /// Holds a step at the value that brings its weight to 0.
    pub(super) fn hold_at_zero(&mut self, index: usize) {
        let step = self.held.get_mut(index).zip(self.step.get_mut(index)).zip(self.zero.get(index));
        if let Some(((held, step), zero)) = step {
            (*held, *step) = (ZERO, *zero);
            self.is_factored = false;
        }
    }

    /// Computes the solution for the current held steps.
    fn solve_free(&mut self) -> bool {
        if !self.is_factored {
            let Some(len) = self.gather() else { return false };
            if !factor(self.factor, len) || !self.is_sound(len) {
                return false;
            }
            self.is_factored = true;
        }
        let ends = self.low.iter().zip(self.high).zip(self.zero);
        let mut has_held = false;
        for ((solution, held), ((low, high), zero)) in
            self.solution.iter_mut().zip(&*self.held).zip(ends)
        {
            *solution = match *held {
                LOW => *low,
                HIGH => *high,
                ZERO => *zero,
                _ => 0.0,
            };
            has_held |= *solution != 0.0;
        }
        if has_held {
            multiply(self.hessian, self.solution, self.slope);
        } else {
            self.slope.fill(0.0);
        }
        let mut len = 0;
        let rhs_entries = self.rhs.iter().zip(&*self.slope).zip(&*self.held);
        let free =
            rhs_entries.filter(|(_, held)| **held == FREE).map(|((rhs, slope), _)| rhs - slope);
        for (out, rhs) in self.free.iter_mut().zip(free) {
            *out = rhs;
            len += 1;
        }
        let free = self.free.get_mut(..len).unwrap_or_default();
        solve(self.factor, free);
        let solutions =
            self.solution.iter_mut().zip(&*self.held).filter(|(_, held)| **held == FREE);
        solutions.zip(free).for_each(|((solution, _), free)| *solution = *free);
        true
    }

    /// Whether rounding has left enough of the diagonal of the `len` free rows.
    fn is_sound(&self, len: usize) -> bool {
        let whole = rows(self.hessian, self.held.len()).zip(&*self.held);
        let whole = whole.filter(|(_, held)| **held == FREE).map(|(row, _)| row);
        let mut both = whole.zip(rows(self.factor, len));
        both.all(|(row, factor)| match (row.first(), factor.first()) {
            (Some(diagonal), Some(root)) => root * root >= SHARE_MIN * diagonal,
            _ => false,
        })
    }

    /// Copies the free rows and columns of H, and returns their number.
    fn gather(&mut self) -> Option<usize> {
        let (mut len, mut out) = (0, self.factor.iter_mut());
        for (at, row) in rows(self.hessian, self.held.len()).enumerate() {
            let held = self.held.get(at..)?;
            if held.first() != Some(&FREE) {
                continue;
            }
            len += 1;
            for (x, _) in row.iter().zip(held).filter(|(_, held)| **held == FREE) {
                *out.next()? = *x;
            }
        }
        Some(len)
    }

    /// Whether the solution is within the bounds.
    fn is_within(&self) -> bool {
        let mut all = self.solution.iter().zip(self.low.iter().zip(self.high));
        all.all(|(solution, (low, high))| {
            let slack = SLACK * (high - low);
            low - slack <= *solution && *solution <= high + slack
        })
    }

    /// Moves toward the solution along the bounds while the cost falls, and returns the cost.
    /// `None` if the cost falls nowhere.
    fn line_search(&mut self, cost: f64) -> Option<f64> {
        let mut share = 1.0;
        while share > STEP_MIN {
            let ends = self.low.iter().zip(self.high);
            let way = self.step.iter().zip(&*self.solution).zip(ends);
            for (tried, ((step, solution), (low, high))) in self.free.iter_mut().zip(way) {
                *tried = (step + share * (solution - step)).max(*low).min(*high);
            }
            let less = self.cost_of(Which::Tried);
            if less < cost {
                copy(self.step, self.free);
                return Some(less);
            }
            share *= 0.5;
        }
        None
    }

    /// Computes the gradient at a step, and returns the cost.
    fn cost_of(&mut self, which: Which) -> f64 {
        let step = if which == Which::Step { &*self.step } else { &*self.free };
        multiply(self.hessian, step, self.slope);
        let cost = 0.5 * dot(step, self.slope) - dot(step, self.rhs);
        self.slope.iter_mut().zip(self.rhs).for_each(|(slope, rhs)| *slope -= rhs);
        cost
    }

    /// Holds the steps that the gradient presses against a bound, and frees the steps that it pulls
    /// off a bound. Returns whether anything changed.
    fn update_held(&mut self) -> bool {
        let mut is_changed = false;
        let bounds = self.low.iter().zip(self.high);
        let steps = self.step.iter().zip(&*self.slope).zip(bounds);
        let steps = steps.zip(rows(self.hessian, self.held.len()));
        for (held, (((step, slope), (low, high)), row)) in self.held.iter_mut().zip(steps) {
            // The diagonal converts a tolerance in steps to a tolerance in gradients.
            let steep = row.first().copied().unwrap_or_default() * SLACK * (high - low);
            let becomes = match *held {
                ZERO => ZERO,
                LOW if *slope >= -steep => LOW,
                HIGH if *slope <= steep => HIGH,
                _ if *step <= *low && *slope > steep => LOW,
                _ if *step >= *high && *slope < -steep => HIGH,
                _ if low >= high => LOW,
                _ => FREE,
            };
            is_changed |= becomes != *held;
            *held = becomes;
        }
        self.is_factored &= !is_changed;
        is_changed
    }
}

/// Copies a vector of equal length. `copy_from_slice` would put a panic into firmware.
fn copy(out: &mut [f64], from: &[f64]) {
    out.iter_mut().zip(from).for_each(|(out, from)| *out = *from);
}

/// Step at which to compute the cost.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Which {
    Step,
    Tried,
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::super::packed::{add_square, add_to_diagonal, packed_len};
    use super::*;
    use std::vec;
    use std::vec::Vec;

    /// A random problem of n steps, chosen by the seed.
    struct Problem {
        hessian: Vec<f64>,
        rhs: Vec<f64>,
        low: Vec<f64>,
        high: Vec<f64>,
    }

    impl Problem {
        fn new(n: usize, seed: u64) -> Self {
            let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
            let mut number = || {
                state ^= state << 13;
                state ^= state >> 7;
                state ^= state << 17;
                (state >> 11) as f64 / (1u64 << 53) as f64 * 2.0 - 1.0
            };
            let mut hessian = vec![0.0; packed_len(n)];
            add_to_diagonal(&mut hessian, n, 0.05);
            for _ in 0..n {
                let b: Vec<f64> = (0..n).map(|_| number()).collect();
                add_square(&mut hessian, 1.0, &b);
            }
            let rhs = (0..n).map(|_| 2.0 * number()).collect();
            let low: Vec<f64> = (0..n).map(|_| number().min(0.5)).collect();
            let high = low.iter().map(|low| low + number().abs()).collect();
            Self { hessian, rhs, low, high }
        }

        /// Returns the step, the result of the search, and its rounds.
        fn solved(&self, held: &mut [f64], zero: &[f64]) -> (Vec<f64>, End, u32) {
            let n = self.rhs.len();
            let [mut step, mut solution, mut slope, mut free] = [(); 4].map(|()| vec![7.0; n]);
            let mut set = ActiveSet {
                hessian: &self.hessian,
                rhs: &self.rhs,
                low: &self.low,
                high: &self.high,
                zero,
                held,
                factor: &mut vec![7.0; packed_len(n)],
                is_factored: false,
                is_bounded: self.low.iter().all(|low| low.is_finite()),
                step: &mut step,
                solution: &mut solution,
                slope: &mut slope,
                free: &mut free,
            };
            let (end, rounds) = set.search();
            (step, end, rounds)
        }

        fn cost(&self, step: &[f64]) -> f64 {
            let mut product = vec![0.0; step.len()];
            multiply(&self.hessian, step, &mut product);
            let each = step.iter().zip(&product).zip(&self.rhs);
            each.map(|((d, h), g)| d * (0.5 * h - g)).sum()
        }

        /// The least cost over all choices of held steps, by Gaussian elimination of each;
        /// infeasible solutions do not count.
        fn least_cost(&self) -> f64 {
            let n = self.rhs.len();
            let mut least = f64::INFINITY;
            for code in 0..3usize.pow(n as u32) {
                let ways: Vec<usize> = (0..n).map(|i| code / 3usize.pow(i as u32) % 3).collect();
                let mut step: Vec<f64> =
                    (0..n).map(|i| [0.0, self.low[i], self.high[i]][ways[i]]).collect();
                let mut slope = vec![0.0; n];
                multiply(&self.hessian, &step, &mut slope);
                let free: Vec<usize> = (0..n).filter(|i| ways[*i] == 0).collect();
                let entry = |i: usize, j: usize| {
                    let (i, j) = (i.min(j), i.max(j));
                    self.hessian[i * n - i * (i + 1) / 2 + j]
                };
                let mut table: Vec<Vec<f64>> = free
                    .iter()
                    .map(|&i| {
                        let row = free.iter().map(|&j| entry(i, j));
                        row.chain([self.rhs[i] - slope[i]]).collect()
                    })
                    .collect();
                for k in 0..free.len() {
                    for i in (0..free.len()).filter(|i| *i != k) {
                        let by = table[i][k] / table[k][k];
                        let pivot = table[k].clone();
                        table[i].iter_mut().zip(&pivot).for_each(|(x, own)| *x -= by * own);
                    }
                }
                for (k, &i) in free.iter().enumerate() {
                    step[i] = table[k][free.len()] / table[k][k];
                }
                let within =
                    |i: usize| self.low[i] - 1e-12 <= step[i] && step[i] <= self.high[i] + 1e-12;
                if (0..n).all(within) {
                    least = least.min(self.cost(&step));
                }
            }
            least
        }
    }

    #[test]
    fn the_minimum_is_the_least_over_all_held_steps() {
        let mut several = 0;
        for (n, seed) in (1..7).flat_map(|n| (0..20).map(move |seed| (n, seed))) {
            let problem = Problem::new(n, seed * 7 + n as u64);
            let (step, end, rounds) = problem.solved(&mut vec![FREE; n], &vec![0.0; n]);
            assert_eq!(end, End::Least);
            let least = problem.least_cost();
            assert!((problem.cost(&step) - least).abs() < 1e-10, "{n} {seed}");
            several += usize::from(rounds > 2);
        }
        assert!(several > 20, "the problems ask for rounds: {several}");
    }

    #[test]
    fn the_start_changes_no_bit() {
        for seed in 0..20 {
            let problem = Problem::new(40, seed);
            let mut held = vec![FREE; 40];
            let (cold, _, rounds) = problem.solved(&mut held, &[0.0; 40]);
            let (again, end, one) = problem.solved(&mut held, &[0.0; 40]);
            assert_eq!((end, one), (End::Least, 1));
            assert_eq!(cold, again);
            assert!((2..30).contains(&rounds), "{rounds}");
        }
    }

    #[test]
    fn steps_held_at_zero_stay_there() {
        let mut problem = Problem::new(5, 3);
        let zero = [0.25; 5];
        // A weight can be held at 0 only if its bounds contain 0.
        for held in [1, 4] {
            (problem.low[held], problem.high[held]) = (-1.0, 1.0);
        }
        let (step, end, _) = problem.solved(&mut [FREE, ZERO, FREE, FREE, ZERO], &zero);
        assert_eq!((end, step[1], step[4]), (End::Least, 0.25, 0.25));
    }

    #[test]
    fn without_bounds_one_round_is_enough() {
        let mut problem = Problem::new(12, 5);
        problem.low.fill(f64::NEG_INFINITY);
        problem.high.fill(f64::INFINITY);
        let (step, end, rounds) = problem.solved(&mut [FREE; 12], &[0.0; 12]);
        assert_eq!((end, rounds), (End::Least, 1));
        let mut product = vec![0.0; 12];
        multiply(&problem.hessian, &step, &mut product);
        assert!(product.iter().zip(&problem.rhs).all(|(a, b)| (a - b).abs() < 1e-10));
    }
}
