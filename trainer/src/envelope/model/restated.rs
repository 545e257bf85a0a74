//! A model fitted in other lengths and about another point, for those of the input.

use super::envelope::{EnvelopeModel, Reconstruction};
use super::group::{Group, Input};
use faer::Mat;

impl EnvelopeModel {
    /// Restates a model whose lengths are in a unit of the input and whose positions are measured
    /// from a centre: x of the input is `(x - centre) / unit` there.
    #[must_use]
    pub fn restated(&self, unit: f64, centre: [f64; 3]) -> Self {
        let mut out = self.clone();
        for frame in &mut out.skeleton.rest {
            for (row, centre) in frame.iter_mut().zip(centre) {
                row[3] = unit * row[3] + centre;
            }
        }
        out.pose_gaps.iter_mut().for_each(|gap| *gap *= unit);
        let root = self.skeleton.root();
        if let Some(reconstruction) = &mut out.reconstruction {
            reconstruction.scale(unit);
            reconstruction.shift(centre, root);
        }
        out.groups.iter_mut().for_each(|group| group.restate(unit, centre));
        out
    }
}

impl Reconstruction {
    fn scale(&mut self, unit: f64) {
        let is_translation = |index: usize| index % 4 == 3;
        for row in 0..self.c2.nrows() {
            let scale = if is_translation(row) { unit } else { 1.0 };
            for column in 0..self.c1.ncols() {
                self.c1[(row, column)] *= scale;
            }
            for column in 0..self.c2.ncols() {
                self.c2[(row, column)] *= scale / if is_translation(column) { unit } else { 1.0 };
            }
        }
    }

    /// About the centre o, a map `[Q | d]` is `[Q | d + Qo - o]`. The root's block of q is `[I | 0]`,
    /// so it carries the constant o.
    fn shift(&mut self, centre: [f64; 3], root: usize) {
        let (c1, c2) = (&mut self.c1, &mut self.c2);
        for row in 0..c2.nrows() {
            for joint in 0..c2.ncols() / 4 {
                let shift = c2[(row, 4 * joint + 3)];
                for (axis, o) in centre.iter().enumerate() {
                    c2[(row, 4 * joint + axis)] += o * shift;
                    c2[(row, 4 * root + axis)] -= o * shift;
                }
            }
        }
        for proxy in 0..c2.nrows() / 4 {
            let shift = 4 * proxy + 3;
            for (axis, o) in centre.iter().enumerate() {
                for column in 0..c1.ncols() {
                    c1[(shift, column)] -= o * c1[(4 * proxy + axis, column)];
                }
                for column in 0..c2.ncols() {
                    c2[(shift, column)] -= o * c2[(4 * proxy + axis, column)];
                }
                c2[(shift, 4 * root + axis)] += o;
            }
        }
    }
}

impl Group {
    /// About the centre o, a correction `[L | t]` in units u adds `L (x - o) + u t`.
    fn restate(&mut self, unit: f64, [ox, oy, oz]: [f64; 3]) {
        for input in self.inputs.iter_mut().filter(|input| input.is_displacement()) {
            *input = Input { weight: input.weight / unit, ..*input };
        }
        let outputs = &self.outputs;
        self.outputs = Mat::from_fn(outputs.nrows(), outputs.ncols(), |row, z| {
            let own = |c: usize| outputs[(row - row % 4 + c, z)];
            match row % 4 {
                3 => unit * own(3) - (own(0) * ox + own(1) * oy + own(2) * oz),
                c => own(c),
            }
        });
    }
}
