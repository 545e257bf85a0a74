//! Distances between faces of one skin by their weights alone.

use super::baked::BakedFace;
use faer::Mat;
use std::ops::Range;

/// Inner products of shapes over some vertices: a face is linear in its weights, so that these give every distance.
pub struct Gram {
    matrix: Mat<f64>,
}

impl Gram {
    /// Computes them of the shapes as a file holds them.
    pub fn new(face: &BakedFace<'_>, vertices: Range<usize>) -> Self {
        let (len, shapes) = (vertices.len().max(1), face.skin.shape_len());
        let mut matrix = Mat::<f64>::zeros(shapes, shapes);
        for vertex in vertices {
            let moved: Vec<(usize, [f64; 3])> =
                face.skin.deltas_of(vertex).map(|(shape, u)| (shape, u.map(f64::from))).collect();
            for (a, u) in &moved {
                for (b, v) in &moved {
                    matrix[(*a, *b)] += (u[0] * v[0] + u[1] * v[1] + u[2] * v[2]) / len as f64;
                }
            }
        }
        Self { matrix }
    }

    /// Computes the mean square over the vertices of the distance between faces of two weights.
    pub fn mean_square(&self, a: &[f64], b: &[f64]) -> f64 {
        let by: Vec<f64> = a.iter().zip(b).map(|(a, b)| a - b).collect();
        let row = |i: usize| (0..by.len()).map(|j| self.matrix[(i, j)] * by[j]).sum::<f64>();
        (0..by.len()).map(|i| by[i] * row(i)).sum::<f64>().max(0.0)
    }
}

/// Counts the weights above 0.01, on average over frames.
pub fn cardinality(frames: &[Vec<f64>]) -> f64 {
    const AT_WORK: f64 = 0.01;
    let count = frames.iter().flatten().filter(|weight| weight.abs() > AT_WORK).count();
    count as f64 / frames.len().max(1) as f64
}

/// Computes the RMS over weights and frames of the second difference in time; 0 of fewer than three frames.
pub fn roughness(frames: &[Vec<f64>]) -> f64 {
    let mut sum = 0.0;
    let mut len = 0;
    for three in frames.windows(3) {
        for ((a, b), c) in three[0].iter().zip(&three[1]).zip(&three[2]) {
            sum += (a - 2.0 * b + c).powi(2);
            len += 1;
        }
    }
    if len == 0 { 0.0 } else { (sum / f64::from(len)).sqrt() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_is_smooth_and_a_zigzag_rough() {
        let line: Vec<Vec<f64>> = (0..5).map(|k| vec![0.1 * f64::from(k), 0.3]).collect();
        assert!(roughness(&line) < 1e-15);
        let zigzag: Vec<Vec<f64>> = (0..5).map(|k| vec![f64::from(k % 2), 0.0]).collect();
        // 2 in one weight of two.
        assert!((roughness(&zigzag) - 2.0_f64.sqrt()).abs() < 1e-12);
        assert_eq!(roughness(&line[..2]), 0.0);
        assert_eq!(cardinality(&line), 9.0 / 5.0);
    }
}
