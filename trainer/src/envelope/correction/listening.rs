//! The inputs and the kernel of a map, chosen by folds of the training poses.

use super::features::near;
use super::target::CorrectionTarget;
use crate::envelope::model::Input;
use crate::regression::design::Design;
use crate::regression::function::SMOOTHEST_FIRST;
use crate::regression::inputs::{Inputs, WIDTHS};
use crate::regression::outputs::Outputs;
use crate::regression::ridge;
use sinew_runtime::envelope::GroupKernel;

/// Candidate hops, the fewest inputs first.
pub(super) const HOPS: [usize; 3] = [1, 2, 3];
/// Most centres that what maps listen to is chosen with: 128 are too few to tell what a map of more needs.
const CENTRES: usize = 192;

/// The joints that a map listens to, and its kernel.
#[derive(Clone)]
pub struct Listening {
    /// Hops of the joints.
    pub hops: usize,
    /// Their features.
    pub inputs: Vec<Input>,
    /// The kernel, and its squared width in median squared distances.
    pub kernel: (GroupKernel, f64),
}

impl Listening {
    /// Chooses joints and the width of the smoothest kernel; `None` if nothing near the joint moves.
    ///
    /// Of joints that score alike those with the narrowest kernel are taken, which fades first in poses unlike those of
    /// training, then the fewest.
    pub(super) fn near(
        target: &CorrectionTarget<'_>,
        outputs: &Outputs,
        joint: usize,
    ) -> Option<Self> {
        let mut tried = Vec::<(Self, f64)>::new();
        for hops in HOPS {
            let joints = near(target.features.parents, joint, hops);
            let inputs = target.features.inputs(target.poses, &joints);
            if tried.last().is_none_or(|last| last.0.inputs != inputs) {
                tried.extend(narrow(
                    target,
                    outputs,
                    (hops, &inputs),
                    (SMOOTHEST_FIRST[0], &WIDTHS),
                ));
            }
        }
        let tried = alike(target, tried).into_iter().map(|tried| tried.0);
        tried.min_by(|a, b| a.kernel.1.total_cmp(&b.kernel.1))
    }

    /// Chooses the kernel for the same joints, and a width near theirs.
    pub(super) fn best(&self, target: &CorrectionTarget<'_>, outputs: &Outputs) -> Option<Self> {
        // The roughest serves no set better than the others.
        let [kernels @ .., _] = SMOOTHEST_FIRST;
        let (_, own) = self.kernel;
        let widths: Vec<f64> =
            WIDTHS.into_iter().filter(|width| (own / 4.0..=own * 4.0).contains(width)).collect();
        let of = |kernel| narrow(target, outputs, (self.hops, &self.inputs), (kernel, &widths));
        let tried = kernels.into_iter().filter_map(of);
        tried.min_by(|a, b| a.1.total_cmp(&b.1)).map(|tried| tried.0)
    }

    /// Scores each output; `None` if nothing of the joints moves.
    pub(super) fn scores(
        &self,
        target: &CorrectionTarget<'_>,
        outputs: &Outputs,
    ) -> Option<Vec<f64>> {
        let values = Inputs::new(target.features.evaluate(target.poses, &self.inputs))?;
        scores(&values, outputs, self.kernel)
    }
}

/// Takes the narrowest width of a kernel that scores like the best, with its score.
fn narrow(
    target: &CorrectionTarget<'_>,
    outputs: &Outputs,
    (hops, inputs): (usize, &[Input]),
    (kernel, widths): (GroupKernel, &[f64]),
) -> Option<(Listening, f64)> {
    let values = Inputs::new(target.features.evaluate(target.poses, inputs))?;
    let of_width = |&width: &f64| {
        let kernel = (kernel, width);
        let score = scores(&values, outputs, kernel)?.iter().sum();
        Some((Listening { hops, inputs: inputs.to_vec(), kernel }, score))
    };
    alike(target, widths.iter().filter_map(of_width).collect()).into_iter().next()
}

/// Scores each output by a kernel and width.
fn scores(
    inputs: &Inputs,
    outputs: &Outputs,
    (kernel, width): (GroupKernel, f64),
) -> Option<Vec<f64>> {
    let count = inputs.sample_len().min(CENTRES);
    Some(ridge::best(&Design::each(inputs, kernel, width, &[count]).next()?, outputs)?.scores)
}

/// Keeps those whose score cannot be told from the least.
fn alike(target: &CorrectionTarget<'_>, mut tried: Vec<(Listening, f64)>) -> Vec<(Listening, f64)> {
    let least = tried.iter().map(|tried| tried.1).fold(f64::INFINITY, f64::min);
    tried.retain(|tried| tried.1 <= (1.0 + target.features.settings.alike) * least);
    tried
}
