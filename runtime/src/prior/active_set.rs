//! Least squares between bounds: which weights are held at one, many at a time.
//!
//! Projected Newton steps (Bertsekas, Projected Newton methods for optimization problems with simple constraints, SIAM J.
//! Control and Optimization 1982): solve what is free, cut it to the bounds, and hold what the slope presses against one.
//! The cost falls in every round, so none comes twice; what is found is solved from what is held alone, whatever led there.

use super::packed::{dot, factor, multiply, rows, solve};

/// Rounds after which the weights stay as they are: of 53 shapes none was seen to need 20.
pub(super) const ROUNDS_MAX: u32 = 100;
/// The least share of a step that is tried.
const STEP_MIN: f64 = 1.0e-9;
/// What rounding may leave of a bound, in its span.
const SLACK: f64 = 1.0e-10;

/// The least share of a diagonal that its factor must have kept: what is below is of rounding, and nothing of the
/// prior is left under pins that are so stiff.
const SHARE_MIN: f64 = 1.0e-13;

/// A step that is free.
pub(super) const FREE: f64 = 0.0;
/// One that is held at its least.
pub(super) const LOW: f64 = -1.0;
/// One that is held at its greatest.
pub(super) const HIGH: f64 = 1.0;
/// One that keeps its weight at 0, whatever pulls.
pub(super) const ZERO: f64 = 2.0;

/// Minimises `½ dᵀ H d - gᵀ d` over steps d of n weights between bounds.
pub(super) struct ActiveSet<'a> {
    /// H, packed.
    pub(super) hessian: &'a [f64],
    /// g.
    pub(super) pull: &'a [f64],
    /// The least of each step, and below the greatest; infinite without bounds.
    pub(super) low: &'a [f64],
    pub(super) high: &'a [f64],
    /// What brings each weight to 0.
    pub(super) zero: &'a [f64],
    /// [`FREE`], [`LOW`], [`HIGH`] or [`ZERO`] of each step.
    pub(super) held: &'a mut [f64],
    /// Factor of the rows and columns of H whose steps are free, packed.
    pub(super) factor: &'a mut [f64],
    /// Whether it is that of `held`.
    pub(super) is_factored: bool,
    pub(super) is_bounded: bool,
    /// d.
    pub(super) step: &'a mut [f64],
    /// What d would be without the bounds of what is free.
    pub(super) aim: &'a mut [f64],
    /// H d - g.
    pub(super) slope: &'a mut [f64],
    /// The free steps, one after the other; or a step that is tried.
    pub(super) free: &'a mut [f64],
}

/// How a search ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum End {
    /// The step is the least.
    Least,
    /// The step is within the bounds, and may not be the least.
    Cut,
    /// H has no factor.
    NoFactor,
}

impl ActiveSet<'_> {
    /// Searches, and returns in how many rounds.
    pub(super) fn search(&mut self) -> (End, u32) {
        let mut cost = f64::INFINITY;
        self.step.fill(0.0);
        for round in 1..=ROUNDS_MAX {
            if !self.solve_free() {
                return (End::NoFactor, round);
            }
            if !self.is_bounded {
                self.step.copy_from_slice(self.aim);
                return (End::Least, round);
            }
            if self.is_within() {
                self.step.copy_from_slice(self.aim);
                cost = self.cost_of(Which::Step);
                if !self.hold() {
                    return (End::Least, round);
                }
            } else {
                let Some(less) = self.approach(cost) else { return (End::Cut, round) };
                cost = less;
                self.hold();
            }
        }
        (End::Cut, ROUNDS_MAX)
    }

    /// Returns the weight that the step leads to.
    pub(super) fn weight(&self, index: usize) -> f64 {
        let step = self.step.get(index).zip(self.zero.get(index));
        step.map_or(0.0, |(step, zero)| step - zero)
    }

    /// Holds a step at what brings its weight to 0.
    pub(super) fn hold_at_zero(&mut self, index: usize) {
        let step = self.held.get_mut(index).zip(self.step.get_mut(index)).zip(self.zero.get(index));
        if let Some(((held, step), zero)) = step {
            (*held, *step) = (ZERO, *zero);
            self.is_factored = false;
        }
    }

    /// Computes the aim with what is held.
    fn solve_free(&mut self) -> bool {
        if !self.is_factored {
            let Some(len) = self.gather() else { return false };
            if !factor(self.factor, len) || !self.is_sound(len) {
                return false;
            }
            self.is_factored = true;
        }
        let ends = self.low.iter().zip(self.high).zip(self.zero);
        let mut is_moved = false;
        for ((aim, held), ((low, high), zero)) in self.aim.iter_mut().zip(&*self.held).zip(ends) {
            *aim = match *held {
                LOW => *low,
                HIGH => *high,
                ZERO => *zero,
                _ => 0.0,
            };
            is_moved |= *aim != 0.0;
        }
        if is_moved {
            multiply(self.hessian, self.aim, self.slope);
        } else {
            self.slope.fill(0.0);
        }
        let mut len = 0;
        let pulls = self.pull.iter().zip(&*self.slope).zip(&*self.held);
        let free = pulls.filter(|(_, held)| **held == FREE).map(|((pull, slope), _)| pull - slope);
        for (out, pull) in self.free.iter_mut().zip(free) {
            *out = pull;
            len += 1;
        }
        let free = self.free.get_mut(..len).unwrap_or_default();
        solve(self.factor, free);
        let aims = self.aim.iter_mut().zip(&*self.held).filter(|(_, held)| **held == FREE);
        aims.zip(free).for_each(|((aim, _), free)| *aim = *free);
        true
    }

    /// Whether rounding has left enough of the diagonal of so many free rows.
    fn is_sound(&self, len: usize) -> bool {
        let whole = rows(self.hessian, self.held.len()).zip(&*self.held);
        let whole = whole.filter(|(_, held)| **held == FREE).map(|(row, _)| row);
        let mut both = whole.zip(rows(self.factor, len));
        both.all(|(row, factor)| match (row.first(), factor.first()) {
            (Some(diagonal), Some(root)) => root * root >= SHARE_MIN * diagonal,
            _ => false,
        })
    }

    /// Copies the free rows and columns of H, and returns how many there are.
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

    /// Whether the aim is within the bounds.
    fn is_within(&self) -> bool {
        let mut all = self.aim.iter().zip(self.low.iter().zip(self.high));
        all.all(|(aim, (low, high))| {
            let slack = SLACK * (high - low);
            low - slack <= *aim && *aim <= high + slack
        })
    }

    /// Goes toward the aim as far as the cost falls, along the bounds, and returns the cost; `None` where it falls
    /// nowhere.
    fn approach(&mut self, cost: f64) -> Option<f64> {
        let mut share = 1.0;
        while share > STEP_MIN {
            let ends = self.low.iter().zip(self.high);
            let way = self.step.iter().zip(&*self.aim).zip(ends);
            for (tried, ((step, aim), (low, high))) in self.free.iter_mut().zip(way) {
                *tried = (step + share * (aim - step)).max(*low).min(*high);
            }
            let less = self.cost_of(Which::Tried);
            if less < cost {
                self.step.copy_from_slice(self.free);
                return Some(less);
            }
            share *= 0.5;
        }
        None
    }

    /// Computes the slope at a step, and returns the cost.
    fn cost_of(&mut self, which: Which) -> f64 {
        let step = if which == Which::Step { &*self.step } else { &*self.free };
        multiply(self.hessian, step, self.slope);
        let cost = 0.5 * dot(step, self.slope) - dot(step, self.pull);
        self.slope.iter_mut().zip(self.pull).for_each(|(slope, pull)| *slope -= pull);
        cost
    }

    /// Holds the steps that the slope presses against a bound, frees those that it pulls off one, and returns whether
    /// that changes anything.
    fn hold(&mut self) -> bool {
        let mut is_changed = false;
        let bounds = self.low.iter().zip(self.high);
        let steps = self.step.iter().zip(&*self.slope).zip(bounds);
        let steps = steps.zip(rows(self.hessian, self.held.len()));
        for (held, (((step, slope), (low, high)), row)) in self.held.iter_mut().zip(steps) {
            // What a slope is worth in steps goes by the diagonal.
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

/// A step whose cost is asked for.
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

    /// A problem of n steps, another for each seed.
    struct Problem {
        hessian: Vec<f64>,
        pull: Vec<f64>,
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
            let pull = (0..n).map(|_| 2.0 * number()).collect();
            let low: Vec<f64> = (0..n).map(|_| number().min(0.5)).collect();
            let high = low.iter().map(|low| low + number().abs()).collect();
            Self { hessian, pull, low, high }
        }

        /// Returns the step, how the search ended, and its rounds.
        fn solved(&self, held: &mut [f64], zero: &[f64]) -> (Vec<f64>, End, u32) {
            let n = self.pull.len();
            let [mut step, mut aim, mut slope, mut free] = [(); 4].map(|()| vec![7.0; n]);
            let mut set = ActiveSet {
                hessian: &self.hessian,
                pull: &self.pull,
                low: &self.low,
                high: &self.high,
                zero,
                held,
                factor: &mut vec![7.0; packed_len(n)],
                is_factored: false,
                is_bounded: self.low.iter().all(|low| low.is_finite()),
                step: &mut step,
                aim: &mut aim,
                slope: &mut slope,
                free: &mut free,
            };
            let (end, rounds) = set.search();
            (step, end, rounds)
        }

        fn cost(&self, step: &[f64]) -> f64 {
            let mut product = vec![0.0; step.len()];
            multiply(&self.hessian, step, &mut product);
            let each = step.iter().zip(&product).zip(&self.pull);
            each.map(|((d, h), g)| d * (0.5 * h - g)).sum()
        }

        /// The least cost over every way to hold steps: gaussian elimination of each, those within the bounds.
        fn least_cost(&self) -> f64 {
            let n = self.pull.len();
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
                        row.chain([self.pull[i] - slope[i]]).collect()
                    })
                    .collect();
                for k in 0..free.len() {
                    for i in (0..free.len()).filter(|i| *i != k) {
                        let by = table[i][k] / table[k][k];
                        for j in k..=free.len() {
                            table[i][j] -= by * table[k][j];
                        }
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
    fn the_least_is_that_of_every_way_to_hold_steps() {
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
    fn where_it_starts_changes_no_bit() {
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
    fn what_is_held_at_zero_stays_there() {
        let problem = Problem::new(5, 3);
        let zero = [0.25; 5];
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
        assert!(product.iter().zip(&problem.pull).all(|(a, b)| (a - b).abs() < 1e-10));
    }
}
