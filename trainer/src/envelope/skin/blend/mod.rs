//! Blends of maps: the least-squares problem that LBS weights, proxies and keys share.
//!
//! An item (a vertex, a triangle) has one or more rows h of width m with a target trajectory y in
//! R^r each; l maps `M_l` (r x m) are blended with weights w: `y ≈ Σ_l w_l M_l h`, w ≥ 0, Σw = 1,
//! at most K of them not zero. Weights and maps are fitted in turn (METHOD §1.2, §1.7).

mod alternation;
mod items;
mod maps;
mod weights;

pub use alternation::{Alternation, Blend, InTurn};
pub use items::{Items, Maps, Supports, Weights};
pub use maps::fit_maps;
pub use weights::{CANDIDATES, fit_weights};

#[cfg(test)]
mod tests {
    use super::*;
    use crate::constants::NEARER;
    use crate::examples::Importance;
    use faer::Mat;
    use rand::{RngExt, SeedableRng};

    /// Items that known maps and known weights move exactly.
    fn exact(count: usize, rank: usize) -> (Vec<f64>, Mat<f64>, Maps, Vec<[f64; 3]>) {
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
        (h, y, Maps { width: 4, columns }, weights)
    }

    #[test]
    fn true_maps_give_back_the_true_weights() {
        let (h, y, maps, truth) = exact(300, 30);
        let items =
            Items { width: 4, rows: 1, h, y: &y, importance: Importance::ALIKE, farther: None };
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
    fn what_an_item_followed_last_is_left_only_for_what_serves_better() {
        let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(6);
        let (count, rank, maps) = (200, 40, 30);
        let mut numbers = |rows, columns| {
            Mat::<f64>::from_fn(rows, columns, |_, _| random.random_range(-1.0..1.0))
        };
        let (y, columns) = (numbers(rank, count), numbers(rank, 4 * maps));
        let h = (0..count).flat_map(|_| [0.3, -0.2, 0.5, 1.0]).collect();
        let items =
            Items { width: 4, rows: 1, h, y: &y, importance: Importance::ALIKE, farther: None };
        let maps = Maps { width: 4, columns };
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

    #[test]
    fn of_weights_that_err_as_little_those_of_nearer_maps_are_taken() {
        let (h, y, Maps { width, columns }, truth) = exact(300, 30);
        // Each map twice, the second time farther.
        let maps = Maps { width, columns: faer::concat![[&columns, &columns]] };
        let farther =
            Mat::from_fn(6, 300, |map, item| if (map < 3) == (item < 150) { 1.0 } else { 2.0 });
        let items = Items {
            width: 4,
            rows: 1,
            h,
            y: &y,
            importance: Importance::ALIKE,
            farther: Some(&farther),
        };
        let (weights, errors) = fit_weights(&items, &maps, Supports::Free(3));
        assert!(errors.iter().all(|&e| e < 1e-6), "{errors:?}");
        for (item, expected) in truth.iter().enumerate() {
            for (map, weight) in weights.of(item) {
                assert_eq!(farther[(map, item)], 1.0, "item {item}");
                assert!((weight - expected[map % 3]).abs() < 1e-3, "item {item}");
            }
        }
    }

    #[test]
    fn what_is_near_adds_no_more_to_an_error_than_its_share() {
        let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(8);
        let mut numbers = |rows, columns| {
            Mat::<f64>::from_fn(rows, columns, |_, _| random.random_range(-1.0..1.0))
        };
        let (y, columns, farther) = (numbers(40, 200), numbers(40, 4 * 8), numbers(8, 200));
        let farther = Mat::from_fn(8, 200, |map, item| 1.0 + farther[(map, item)].abs());
        let h: Vec<f64> = (0..200).flat_map(|_| [0.3, -0.2, 0.5, 1.0]).collect();
        let free =
            Items { width: 4, rows: 1, h, y: &y, importance: Importance::ALIKE, farther: None };
        let near = Items { h: free.h.clone(), farther: Some(&farther), ..free };
        let maps = Maps { width: 4, columns };
        // Of eight maps none is left out, so that what is found is the least.
        let [free, near] = [&free, &near].map(|items| fit_weights(items, &maps, Supports::Free(8)));
        let distance = |weights: &Weights, item: usize| -> f64 {
            weights.of(item).map(|(map, weight)| weight * farther[(map, item)]).sum()
        };
        let mut nearer = 0.0;
        for (item, (least, error)) in free.1.iter().zip(&near.1).enumerate() {
            let [was, is] = [&free.0, &near.0].map(|weights| distance(weights, item));
            let share = 1.0 + NEARER.get() * (was * was - is * is);
            assert!(*error <= least * share + 1e-9, "item {item}: {error} for {least}");
            assert!(is <= was + 1e-9, "item {item}");
            nearer += was - is;
        }
        assert!(nearer > 1.0, "{nearer}");
    }

    #[test]
    fn true_weights_give_back_the_true_maps() {
        let (h, y, maps, truth) = exact(300, 30);
        let items =
            Items { width: 4, rows: 1, h, y: &y, importance: Importance::ALIKE, farther: None };
        let lists = truth.iter().map(|w| w.iter().copied().enumerate().collect());
        let start = Maps { width: 4, columns: Mat::zeros(30, 12) };
        let fitted = fit_maps(&items, &Weights::from_lists(3, lists), &start, 1e-7);
        assert!((fitted.columns - maps.columns).norm_max() < 1e-4);
    }

    #[test]
    fn rounds_that_start_ahead_come_nearer() {
        let (h, y, maps, _) = exact(300, 30);
        let items =
            Items { width: 4, rows: 1, h, y: &y, importance: Importance::ALIKE, farther: None };
        let start = Maps {
            columns: &maps.columns + Mat::from_fn(30, 12, |r, c| ((7 * r + c) as f64).sin()),
            ..maps
        };
        let error = |ahead| {
            let alternation = Alternation { choices: 20, rounds: 10, ahead };
            let blend = alternation.blend(&items, start.clone(), 3, || ());
            let (_, errors) = fit_weights(&items, &blend.maps, Supports::Fixed(&blend.weights));
            assert!((items.sum(&errors) - blend.error).abs() <= 1e-9 * blend.error);
            blend.error
        };
        let (plain, ahead) = (error(0.0), error(0.9));
        assert!(ahead < 0.5 * plain, "{ahead} for {plain}");
    }

    #[test]
    fn a_map_that_no_item_uses_stays_where_it_was() {
        let (h, y, maps, truth) = exact(50, 30);
        let items =
            Items { width: 4, rows: 1, h, y: &y, importance: Importance::ALIKE, farther: None };
        let lists = truth.iter().map(|_| vec![(0, 1.0)]);
        let fitted = fit_maps(&items, &Weights::from_lists(1, lists), &maps, 1e-7);
        let moved = fitted.columns.subcols(4, 8) - maps.columns.subcols(4, 8);
        assert!(moved.norm_max() < 1e-12);
        assert!((fitted.columns.subcols(0, 4) - maps.columns.subcols(0, 4)).norm_max() > 1e-3);
    }
}
