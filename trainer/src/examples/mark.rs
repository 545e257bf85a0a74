//! Marks by which a frame is known again (METHOD §1.11).

use super::Examples;

/// Shares of the mesh by which the vertices of a pair are apart in their order, one a number.
const APART: [f64; 4] = [1.0 / 2.0, 1.0 / 3.0, 1.0 / 7.0, 1.0 / 17.0];
/// Share of the diagonal within which two numbers are one: what single precision and six digits of a text leave.
const SAME: f64 = 1e-6;

/// Numbers that tell a posed mesh from others, whatever axes and unit it is in.
pub type Mark = [f32; APART.len()];

impl Examples {
    /// Computes the mark of a frame: RMS distances over all pairs of vertices that are so far apart in their order,
    /// as shares of the rest diagonal.
    ///
    /// # Panics
    /// If `frame` is not one.
    pub fn mark(&self, frame: usize) -> Mark {
        let (posed, diagonal) = (self.frame(frame), self.diagonal());
        APART.map(|share| {
            let apart = ((share * posed.len() as f64) as usize).max(1);
            let pairs = posed.iter().zip(posed.iter().cycle().skip(apart));
            let squared = |(a, b): (&[f64; 3], &[f64; 3])| -> f64 {
                a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum()
            };
            let mean = pairs.map(squared).sum::<f64>() / posed.len().max(1) as f64;
            (mean.sqrt() / diagonal.max(f64::MIN_POSITIVE)) as f32
        })
    }
}

/// Whether two marks are those of one frame.
pub fn is_same(a: &Mark, b: &Mark) -> bool {
    a.iter().zip(b).all(|(a, b)| f64::from(a - b).abs() <= SAME)
}

#[cfg(test)]
mod tests {
    use super::super::testing::triangle;
    use super::*;

    #[test]
    fn frames_are_known_again_in_other_axes_and_another_unit() {
        let mut examples = triangle(2);
        examples.vertices[3][0] += 0.01;
        let [first, second] = [0, 1].map(|frame| examples.mark(frame));
        assert!(!is_same(&first, &second));
        let turned = |[x, y, z]: [f64; 3]| [100.0 * z, -100.0 * x, 100.0 * y];
        examples.rest = examples.rest.iter().copied().map(turned).collect();
        examples.vertices = examples.vertices.iter().copied().map(turned).collect();
        assert!(is_same(&first, &examples.mark(0)) && is_same(&second, &examples.mark(1)));
    }
}
