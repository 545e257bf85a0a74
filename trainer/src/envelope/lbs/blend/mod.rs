//! Blends of linear maps: the least-squares problem of LBS weights, proxies and keys.
//!
//! An item is a vertex or a triangle. It has one or more rows h of width m. Each row has a target trajectory y in R^r.
//! Maps `M_l` (r x m) are blended with weights w of the item: `y ≈ Σ_l w_l M_l h` with w ≥ 0 and Σw = 1. At most K
//! weights of an item are above 0. Weights and maps are fitted in turn (METHOD §1.2, §1.7).

mod alternation;
mod items;
mod weights;

pub use alternation::{Alternation, Blend, InTurn, Normal, fit_maps};
pub use items::{Items, Pull, Supports, Weights};
pub use weights::{CANDIDATES, fit_weights};

#[cfg(test)]
mod tests {
    use super::*;
    use crate::examples::Importance;
    use faer::Mat;
    use rand::{RngExt, SeedableRng};
    use std::ops::Range;

    /// Makes items, maps and weights without any error.
    fn exact(count: usize, rank: usize) -> (Vec<f64>, Mat<f64>, Mat<f64>, Vec<[f64; 3]>) {
        let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(5);
        let columns = Mat::from_fn(rank, 3 * 4, |_, _| random.random_range(-1.0..1.0));
        let mut h = Vec::new();
        let mut y = Mat::zeros(rank, count);
        let mut weights = Vec::new();
        for item in 0..count {
            let x: [f64; 4] =
                std::array::from_fn(|k| if k == 3 { 1.0 } else { random.random_range(-1.0..1.0) });
            let a: f64 = random.random_range(0.0..1.0);
            let b: f64 = random.random_range(0.0..1.0 - a);
            let w = [a, b, 1.0 - a - b];
            for row in 0..rank {
                y[(row, item)] = (0..12).map(|k| w[k / 4] * x[k % 4] * columns[(row, k)]).sum();
            }
            h.extend(x);
            weights.push(w);
        }
        (h, y, columns, weights)
    }

    #[test]
    fn true_maps_give_the_true_weights() {
        let (h, y, maps, truth) = exact(300, 30);
        let items = Items::new([4, 1], h, &y, Importance::UNIFORM);
        let (weights, errors) = fit_weights(&items, &maps, Supports::Free(3));
        assert!(errors.iter().all(|&e| e < 1e-9));
        let (again, errors) = fit_weights(&items, &maps, Supports::Fixed(&weights));
        assert!(errors.iter().all(|&e| e < 1e-9));
        assert!((0..300).all(|i| again.of(i).map(|w| w.0).eq(weights.of(i).map(|w| w.0))));
        for (item, expected) in truth.iter().enumerate() {
            let found: Vec<_> = weights.of(item).collect();
            assert!(found.is_sorted_by(|a, b| a.1 >= b.1), "strongest first");
            for (map, weight) in found {
                assert!((weight - expected[map]).abs() < 1e-6, "item {item}");
            }
        }
    }

    #[test]
    fn an_item_changes_its_maps_only_for_a_smaller_cost() {
        let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(6);
        let (count, rank, maps) = (200, 40, 30);
        let mut numbers = |rows, columns| {
            Mat::<f64>::from_fn(rows, columns, |_, _| random.random_range(-1.0..1.0))
        };
        let (y, maps) = (numbers(rank, count), numbers(rank, 4 * maps));
        let h = (0..count).flat_map(|_| [0.3, -0.2, 0.5, 1.0]).collect();
        let items = Items::new([4, 1], h, &y, Importance::UNIFORM);
        let (chosen, of_chosen) = fit_weights(&items, &maps, Supports::Free(3));
        let random_ones = (0..count).map(|i| [7, 11, 13].map(|k| (i * k % 30, 1.0 / 3.0)).to_vec());
        let start = Weights::from_lists(3, random_ones);
        let (last, of_last) = fit_weights(&items, &maps, Supports::Fixed(&start));
        let better = Supports::Better { most: 3, others: &chosen, last: &last };
        let (_, errors) = fit_weights(&items, &maps, better);
        let least: Vec<f64> = of_chosen.iter().zip(&of_last).map(|(a, b)| a.min(*b)).collect();
        assert!(errors.iter().zip(&least).all(|(found, least)| *found <= least * (1.0 + 1e-12)));
        assert!(of_last.iter().zip(&of_chosen).any(|(last, chosen)| last < chosen), "both happen");
        assert!(of_last.iter().zip(&of_chosen).any(|(last, chosen)| last > chosen));
    }

    /// Computes the cost of weights: squared error and pull.
    fn cost(items: &Items<'_>, maps: &Mat<f64>, item: usize, weights: &[f64]) -> f64 {
        let h = items.row(item);
        let error = |row: usize| {
            let blended: f64 =
                (0..maps.ncols()).map(|k| weights[k / 4] * h[k % 4] * maps[(row, k)]).sum();
            (blended - items.y[(row, item)]).powi(2)
        };
        let Pull { to, joints, strength } = items.pull.unwrap();
        let pull = |joint: usize| {
            let of_joint = joints.iter().zip(weights).filter(|(j, _)| **j == joint);
            let p = to[(joint, item)];
            (of_joint.map(|(_, w)| w).sum::<f64>() - p).powi(2) / (p + 1e-4)
        };
        let errors: f64 = (0..items.y.nrows()).map(error).sum();
        errors + strength * (0..to.nrows()).map(pull).sum::<f64>()
    }

    #[test]
    fn no_other_weights_cost_less() {
        let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(8);
        let mut numbers = |rows, columns| {
            Mat::<f64>::from_fn(rows, columns, |_, _| random.random_range(-1.0..1.0))
        };
        let (y, maps, prior) = (numbers(40, 50), numbers(40, 4 * 8), numbers(4, 50));
        let sum = |item: usize| (0..4).map(|j| prior[(j, item)].abs()).sum::<f64>();
        let prior = Mat::from_fn(4, 50, |j, item| prior[(j, item)].abs() / sum(item));
        // Two maps a joint.
        let pull = Pull { to: &prior, joints: &[0, 1, 2, 3, 0, 1, 2, 3], strength: 5.0 };
        let h = (0..50).flat_map(|_| [0.3, -0.2, 0.5, 1.0]).collect();
        let items = Items { pull: Some(pull), ..Items::new([4, 1], h, &y, Importance::UNIFORM) };
        // All eight maps are candidates, so the fit finds the least cost.
        let (weights, _) = fit_weights(&items, &maps, Supports::Free(8));
        for item in 0..50 {
            let mut found = [0.0; 8];
            weights.of(item).for_each(|(map, weight)| found[map] = weight);
            let least = cost(&items, &maps, item, &found);
            for map in 0..8 {
                let step = 1e-3;
                let mut other = found.map(|weight| (1.0 - step) * weight);
                other[map] += step;
                assert!(cost(&items, &maps, item, &other) >= least, "item {item}, map {map}");
            }
        }
    }

    #[test]
    fn the_prior_decides_between_equal_maps() {
        let (h, y, maps, truth) = exact(300, 30);
        // Each map twice.
        let maps = faer::concat![[&maps, &maps]];
        let prior =
            Mat::from_fn(6, 300, |map, item| f64::from(u8::from((map < 3) == (item < 150))) / 3.0);
        let pull = Pull { to: &prior, joints: &[0, 1, 2, 3, 4, 5], strength: 1e-9 };
        let items = Items { pull: Some(pull), ..Items::new([4, 1], h, &y, Importance::UNIFORM) };
        let (weights, errors) = fit_weights(&items, &maps, Supports::Free(3));
        // Weights below 0.001 are dropped, which adds an error in each of 30 rows.
        assert!(errors.iter().all(|&e| e < 30e-6), "{errors:?}");
        for (item, expected) in truth.iter().enumerate() {
            for (map, weight) in weights.of(item) {
                assert!(prior[(map, item)] > 0.0, "item {item}");
                assert!((weight - expected[map % 3]).abs() < 1e-3, "item {item}");
            }
        }
    }

    #[test]
    fn true_weights_give_the_true_maps() {
        let (h, y, maps, truth) = exact(300, 30);
        let items = Items::new([4, 1], h, &y, Importance::UNIFORM);
        let lists = truth.iter().map(|w| w.iter().copied().enumerate().collect());
        let start = Mat::zeros(30, 12);
        let fitted = fit_maps(&items, &Weights::from_lists(3, lists), &start, 1e-7);
        assert!((fitted - &maps).norm_max() < 1e-4);

        // The first map is fixed. The others are fitted to the rest of the motion.
        let lists = |own: Range<usize>| {
            let of = |w: &[f64; 3]| own.clone().map(|k| (k - own.start, w[k])).collect();
            Weights::from_lists(3, truth.iter().map(of).collect::<Vec<_>>().into_iter())
        };
        let (fixed, open) = (lists(0..1), lists(1..3));
        let fixed = Some((&fixed, &maps));
        let items = Items { fixed, ..items };
        let start = Mat::zeros(30, 8);
        let fitted = fit_maps(&items, &open, &start, 1e-7);
        assert!((fitted - maps.subcols(4, 8)).norm_max() < 1e-4);
    }

    #[test]
    fn momentum_lowers_the_error() {
        let (h, y, maps, _) = exact(300, 30);
        let items = Items::new([4, 1], h, &y, Importance::UNIFORM);
        let start = &maps + Mat::from_fn(30, 12, |r, c| ((7 * r + c) as f64).sin());
        let error = |momentum| {
            let alternation = Alternation { choices: 20, every: 1, rounds: 10, momentum };
            let blend = alternation.blend(&items, start.clone(), 3, || ());
            let (_, errors) = fit_weights(&items, &blend.maps, Supports::Fixed(&blend.weights));
            assert!((items.sum(&errors) - blend.error).abs() <= 1e-9 * blend.error);
            blend.error
        };
        let (plain, faster) = (error(0.0), error(0.9));
        assert!(faster < 0.5 * plain, "{faster} for {plain}");
    }

    #[test]
    fn an_unused_map_does_not_change() {
        let (h, y, maps, truth) = exact(50, 30);
        let items = Items::new([4, 1], h, &y, Importance::UNIFORM);
        let lists = truth.iter().map(|_| vec![(0, 1.0)]);
        let fitted = fit_maps(&items, &Weights::from_lists(1, lists), &maps, 1e-7);
        let change = fitted.subcols(4, 8) - maps.subcols(4, 8);
        assert!(change.norm_max() < 1e-12);
        assert!((fitted.subcols(0, 4) - maps.subcols(0, 4)).norm_max() > 1e-3);
    }
}
