//! The samples that are nearest to a query.

use faer::Mat;

/// Lists the k sites (n x d) nearest to x, ascending by their numbers; of sites equally far the first.
pub(super) fn nearest(sites: &Mat<f64>, x: &[f64], k: usize) -> Vec<usize> {
    let mut squared = vec![0.0; sites.nrows()];
    for (column, x) in x.iter().enumerate() {
        let coordinates = sites.col_as_slice(column);
        squared.iter_mut().zip(coordinates).for_each(|(s, site)| *s += (site - x) * (site - x));
    }
    let mut order: Vec<usize> = (0..sites.nrows()).collect();
    order.sort_by(|&a, &b| squared[a].total_cmp(&squared[b]));
    order.truncate(k);
    order.sort_unstable();
    order
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_are_found_in_order() {
        let sites = Mat::from_fn(5, 2, |i, c| {
            [[4.0, 0.0], [1.0, 0.0], [0.0, 1.0], [9.0, 9.0], [0.5, 0.0]][i][c]
        });
        assert_eq!(nearest(&sites, &[0.0, 0.0], 1), [4]);
        assert_eq!(nearest(&sites, &[0.0, 0.0], 2), [1, 4], "of two equally far the first");
        assert_eq!(nearest(&sites, &[0.0, 0.0], 9), [0, 1, 2, 3, 4]);
    }
}
