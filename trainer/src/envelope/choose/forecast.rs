//! Forecasts of a model's error on unseen frames (METHOD §1.9). The fit is repeated without some frames and measured on
//! them.

use crate::envelope::fitted::Fitted;
use crate::envelope::lbs::targets::Targets;
use crate::envelope::lbs::training::Training;
use crate::regression::outputs::Block;
use rayon::prelude::*;

/// Returns the RMS error of [`errors`] over all blocks, in diagonals. Returns `None` if there are no blocks, or if a fit
/// fails.
pub(super) fn forecast(
    training: &Training,
    vertices: &[usize],
    blocks: &[Block],
    fit: &(impl Fn(&Training) -> Option<Fitted> + Sync),
) -> Option<f64> {
    pooled(&errors(training, vertices, blocks, fit)?, blocks)
}

/// Returns the RMS error over all blocks from the error of each; `None` if there are no blocks.
pub(super) fn pooled(errors: &[f64], blocks: &[Block]) -> Option<f64> {
    let poses: usize = blocks.iter().map(|block| block.own.len()).sum();
    let of_block = |(rms, block): (&f64, &Block)| rms.powi(2) * block.own.len() as f64;
    let sum: f64 = errors.iter().zip(blocks).map(of_block).sum();
    (poses > 0).then(|| (sum / poses as f64).sqrt())
}

/// Repeats a fit without each block of poses in turn. Returns the RMS error of each block, in diagonals. Returns `None`
/// if a fit fails.
///
/// - `vertices`: the vertices that are fitted and measured.
/// - `fit`: fits a model to a part of the training.
pub(super) fn errors(
    training: &Training,
    vertices: &[usize],
    blocks: &[Block],
    fit: &(impl Fn(&Training) -> Option<Fitted> + Sync),
) -> Option<Vec<f64>> {
    let error = |block: &Block| {
        let part = training.part(vertices, &block.others(training.poses.len()));
        let Fitted { envelope, weights } = fit(&part)?;
        let targets = Targets {
            rest: &part.rest,
            weights: &weights,
            trajectories: &training.trajectories_of(vertices, &block.own),
            importance: part.importance(),
        };
        let palettes = envelope.palettes(&training.poses.only(&block.own));
        Some(targets.rms(&palettes))
    };
    blocks.par_iter().map(error).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::envelope::lbs::blend::Weights;
    use crate::examples::demo::{DemoOptions, demo};
    use crate::progress::Silent;

    #[test]
    fn a_forecast_is_the_error_on_unseen_frames() {
        let mut examples = demo(&DemoOptions { vertices: 300, poses: 40, held_out: 0, seed: 1 });
        examples.clip_starts = vec![0, 15];
        let training = Training::new(&examples, &Silent).unwrap();
        let vertices: Vec<usize> = (0..100).collect();
        let clips = training.folds().clips();
        assert_eq!(clips.len(), 2);
        // This model leaves every vertex on the root.
        let fit = |part: &Training| {
            let frames = part.poses.frames();
            assert!(
                frames == Vec::from_iter(0..15) || frames == Vec::from_iter(15..40),
                "{frames:?}"
            );
            let root = part.poses.root();
            let weights = Weights::from_lists(1, part.rest.iter().map(|_| vec![(root, 1.0)]));
            Some(Fitted::new(part, weights, None))
        };
        let found = forecast(&training, &vertices, &clips, &fit).unwrap();
        let squared = |&vertex: &usize| -> f64 {
            let (rest, truth) = (training.rest[vertex], training.trajectories.col_as_slice(vertex));
            truth.iter().enumerate().map(|(k, y)| (y - rest[k % 3]).powi(2)).sum()
        };
        let expected = (vertices.iter().map(squared).sum::<f64>() / (100.0 * 40.0)).sqrt();
        assert!((found / expected - 1.0).abs() < 1e-9, "{found} {expected}");
        let [first, second] = errors(&training, &vertices, &clips, &fit).unwrap()[..] else {
            panic!("one error a clip")
        };
        let pooled = (15.0 * first.powi(2) + 25.0 * second.powi(2)) / 40.0;
        assert!(first != second && (pooled.sqrt() / expected - 1.0).abs() < 1e-9);
        assert_eq!(forecast(&training, &vertices, &[], &fit), None);
    }
}
