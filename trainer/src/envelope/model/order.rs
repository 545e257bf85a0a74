//! Proxies in another order: what is predicted stays, to the last bit.

use super::envelope::EnvelopeModel;
use super::group::Group;
use faer::Mat;

impl EnvelopeModel {
    /// Lists the proxies with one of them first, and before the others those that share its group.
    pub fn order_from(&self, first: usize) -> Vec<usize> {
        let own = self.groups.iter().find(|group| group.proxies.contains(&first));
        let beside = |proxy: &usize| own.is_some_and(|group| group.proxies.contains(proxy));
        let mut order: Vec<usize> = (0..self.proxy_len()).collect();
        order.sort_by_key(|proxy| (*proxy != first, !beside(proxy)));
        order
    }

    /// Puts the proxies into an order in which those of a group stay together.
    #[must_use]
    pub fn ordered(&self, order: &[usize]) -> Self {
        let mut out = self.clone();
        if let Some(reconstruction) = &mut out.reconstruction {
            for matrix in [&mut reconstruction.c1, &mut reconstruction.c2] {
                *matrix = rows(matrix, 4, order);
            }
        }
        let place = |proxy: usize| order.iter().position(|&other| other == proxy).unwrap_or(proxy);
        out.groups.sort_by_key(|group| group.proxies.clone().map(place).min());
        let mut start = 0;
        for group in &mut out.groups {
            let Group { proxies, outputs, .. } = group;
            let mut own: Vec<usize> = (0..proxies.len()).collect();
            own.sort_by_key(|own| place(proxies.start + own));
            *outputs = rows(outputs, 12, &own);
            *proxies = start..start + own.len();
            start = proxies.end;
        }
        out
    }
}

/// Puts blocks of so many rows into an order.
fn rows(matrix: &Mat<f64>, each: usize, order: &[usize]) -> Mat<f64> {
    Mat::from_fn(matrix.nrows(), matrix.ncols(), |row, column| {
        matrix[(each * order[row / each] + row % each, column)]
    })
}
