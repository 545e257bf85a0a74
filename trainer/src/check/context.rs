//! The examples as the parts of a check see them.

use super::finding::{FrameName, Place};
use super::turns::Turns;
use crate::envelope::correction::features::Features;
use crate::envelope::lbs::training::Residuals;
use crate::envelope::lbs::training::Training;
use crate::examples::{Clip, Examples};
use crate::space::beside;
use faer::Mat;

/// The examples, their training frames, and what LBS leaves of them.
pub(super) struct Context<'a> {
    pub(super) examples: &'a Examples,
    pub(super) clips: &'a [Clip],
    /// The n training frames.
    pub(super) frames: Vec<usize>,
    pub(super) training: &'a Training<'a>,
    /// What LBS leaves in the training frames, 3n x V, in diagonals.
    pub(super) residuals: Mat<f64>,
    /// The joint that each vertex follows most, V.
    pub(super) dominant: Vec<usize>,
    /// The joints in the training frames.
    pub(super) turns: Turns,
}

impl<'a> Context<'a> {
    pub(super) fn new(clips: &'a [Clip], training: &'a Training<'a>) -> Self {
        let (residuals, dominant) = training.lbs_residuals();
        Self {
            examples: training.examples,
            clips,
            frames: training.poses.frames(),
            residuals,
            dominant,
            turns: Turns::new(&training.poses, Features::of(training)),
            training,
        }
    }

    /// Returns the millimetres of a length in % of the diagonal; `None` where the unit is not known.
    pub(super) fn mm(&self, percent: f64) -> Option<f64> {
        self.examples.diagonal_mm().map(|diagonal| percent / 100.0 * diagonal)
    }

    /// Writes a length in diagonals for a finding: `0.49 % of the diagonal (4.8 mm)`.
    pub(super) fn length(&self, share: f64) -> String {
        let percent = 100.0 * share;
        format!("{percent:.2} % of the diagonal{}", beside(percent, self.examples.diagonal_mm()))
    }

    pub(super) fn left(&self) -> Residuals<'_> {
        Residuals { training: self.training, residuals: &self.residuals, dominant: &self.dominant }
    }

    /// Names the `i`-th training frame.
    pub(super) fn frame(&self, i: usize) -> FrameName {
        FrameName::new(self.clips, self.frames[i])
    }

    pub(super) fn frames(&self, of: impl IntoIterator<Item = usize>) -> Vec<Place> {
        of.into_iter().map(|i| Place::Frame(self.frame(i))).collect()
    }

    pub(super) fn joint(&self, joint: usize) -> &'a str {
        &self.examples.skeleton.names[joint]
    }

    pub(super) fn joint_place(&self, joint: usize) -> Place {
        Place::Joint(self.joint(joint).to_owned())
    }

    /// Lists the vertices that follow each joint most, J lists.
    pub(super) fn skins(&self) -> Vec<Vec<usize>> {
        self.left().skins()
    }

    /// Squared length of what LBS leaves of a vertex in the `i`-th training frame.
    pub(super) fn squared(&self, i: usize, vertex: usize) -> f64 {
        self.residuals.col_as_slice(vertex)[3 * i..3 * i + 3].iter().map(|x| x * x).sum()
    }

    /// RMS error of LBS over some vertices in the `i`-th training frame, in diagonals.
    pub(super) fn rms(&self, i: usize, vertices: &[usize]) -> f64 {
        let sum: f64 = vertices.iter().map(|&v| self.squared(i, v)).sum();
        (sum / vertices.len().max(1) as f64).sqrt()
    }

    /// RMS error of LBS over some vertices in all training frames, in diagonals.
    pub(super) fn rms_of(&self, vertices: &[usize]) -> f64 {
        let errors = &self.training.lbs.errors;
        let sum: f64 = vertices.iter().map(|&v| errors[v]).sum();
        (sum / (vertices.len() * self.frames.len()).max(1) as f64).sqrt()
    }

    /// RMS error of LBS over all, in diagonals.
    pub(super) fn lbs_rms(&self) -> f64 {
        self.training.lbs_rms()
    }
}

/// Sorts indices by what they measure, the largest first and equals in order.
pub(super) fn worst_first(
    indices: impl Iterator<Item = usize>,
    of: impl Fn(usize) -> f64,
) -> Vec<usize> {
    let mut sorted: Vec<(f64, usize)> = indices.map(|index| (of(index), index)).collect();
    sorted.sort_by(|a, b| b.0.total_cmp(&a.0));
    sorted.into_iter().map(|(_, index)| index).collect()
}
