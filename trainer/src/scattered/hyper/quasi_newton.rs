//! L-BFGS: directions of descent by the last steps, and lengths that hold Wolfe's conditions (Nocedal
//! and Wright 2006, §3.1 and algorithm 7.4).

use crate::numeric::columns::dot;
use std::collections::VecDeque;

/// Steps that are remembered.
const MEMORY: usize = 20;
/// Share of the first slope by which the value must fall: Armijo's condition.
const FALL: f64 = 1e-4;
/// Share of the first slope that may be left: the condition on curvature.
const LEFT: f64 = 0.9;
/// Most lengths that are tried for a step: then it is below any rounding.
const TRIALS: usize = 60;

/// The last steps, and how the gradient changed by each.
#[derive(Default)]
pub(super) struct Memory(VecDeque<(Vec<f64>, Vec<f64>)>);

impl Memory {
    /// Remembers a step along which the slope grew.
    pub(super) fn remember(&mut self, step: Vec<f64>, change: Vec<f64>) {
        if self.0.len() == MEMORY {
            self.0.pop_front();
        }
        self.0.push_back((step, change));
    }

    /// Forgets all steps; returns whether there were any.
    pub(super) fn forget(&mut self) -> bool {
        !std::mem::take(&mut self.0).is_empty()
    }

    /// Returns a direction of descent: Newton's, as far as the steps know the curvature. Without
    /// any it is as long as `reach` at most.
    pub(super) fn direction(&self, gradient: &[f64], reach: f64) -> Vec<f64> {
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

/// Finds a length of a step that holds Wolfe's conditions, by doubling and bisection; none where
/// `at` gives none, or where none is found.
///
/// `at` gives a value, its slope along the step, and whatever the caller wants back.
pub(super) fn search<P>(
    value: f64,
    slope: f64,
    mut at: impl FnMut(f64) -> Option<(f64, f64, P)>,
) -> Option<P> {
    let (mut low, mut high, mut length) = (0.0, f64::INFINITY, 1.0);
    for _ in 0..TRIALS {
        let (found, left, point) = at(length)?;
        // A value that is not a number has not fallen.
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
pub(super) fn add(a: &mut [f64], factor: f64, b: &[f64]) {
    a.iter_mut().zip(b).for_each(|(a, b)| *a += factor * b);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_direction_is_newtons_on_a_bowl_whose_axes_were_stepped_along() {
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
    fn lengths_hold_both_conditions() {
        // Steep where it starts, with its minimum far, near, and behind a rise.
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
