//! The bias of scale and shear in a file, whose keys have none.
//!
//! With a bias B a key is `D = R (I + sym(H θ)) + R B` (S3 §1.3). A second key that turns alike and has no shear is R
//! itself, and where c1's columns `3k + i` multiply the first, `Σ_i c1[.., 3k + i] B[m, i]` in column m multiplies the
//! second. A file has as many proxies as keys, so the second keys come with proxies that no vertex follows.

use super::predictor::GradientPredictor;
use super::reduce::Reduced;
use crate::envelope::model::{Key, Reconstruction};
use faer::Mat;
use nalgebra::{Matrix3, Matrix6};

/// Makes a reconstruction of P predictors: of P keys, or where some have a bias of 2P, or as many more as `reduced` has
/// transforms. Its transforms are the first; no vertex may follow the others, which are zero.
pub fn carried(predictors: &[GradientPredictor], reduced: &Reduced) -> Reconstruction {
    let p = predictors.len();
    let mut keys: Vec<Key> = predictors.iter().map(|predictor| predictor.key.clone()).collect();
    if predictors.iter().all(|predictor| predictor.bias == Matrix3::zeros()) {
        return Reconstruction { keys, c1: reduced.c1.clone(), c2: reduced.c2.clone() };
    }
    keys.extend_from_within(..);
    keys[p..].iter_mut().for_each(|key| key.shear = Matrix6::zeros());
    let rows = reduced.c1.nrows();
    let len = (2 * p).max(rows / 4);
    keys.resize(len, keys[p].clone());
    let mut c1 = Mat::zeros(4 * len, 3 * len);
    let mut c2 = Mat::zeros(4 * len, reduced.c2.ncols());
    c1.submatrix_mut(0, 0, rows, 3 * p).copy_from(&reduced.c1);
    c2.subrows_mut(0, rows).copy_from(&reduced.c2);
    for (k, predictor) in predictors.iter().enumerate() {
        let bias = Mat::from_fn(3, 3, |i, m| predictor.bias[(m, i)]);
        let own = reduced.c1.subcols(3 * k, 3) * bias;
        c1.submatrix_mut(0, 3 * (p + k), rows, 3).copy_from(own);
    }
    Reconstruction { keys, c1, c2 }
}

#[cfg(test)]
mod tests {
    use super::super::options::Method;
    use super::super::predictor::predict_stacked;
    use super::*;
    use crate::envelope::fitted::Fitted;
    use crate::envelope::lbs::training::Training;
    use crate::examples::demo::{DemoOptions, demo};
    use crate::numeric::so3;
    use crate::progress::Silent;

    #[test]
    fn joints_with_an_offset_at_rest_are_reproduced_and_so_are_they_by_keys_without_a_bias() {
        let examples = demo(&DemoOptions { vertices: 300, poses: 30, held_out: 0, seed: 1 });
        let training = Training::new(&examples, &Silent).unwrap();
        let (poses, parents) = (&training.poses, &training.skeleton.parents);
        let offset = Matrix3::new(1.2, 0.05, 0.0, 0.05, 0.9, 0.03, 0.0, 0.03, 1.01);
        let moving = (0..poses.joint_len()).filter(|&joint| poses.angle_ranges()[joint] > 0.5);
        let sequences = moving.map(|joint| -> Vec<_> {
            let turn = |pose| so3::exp(poses.angle(pose, joint));
            (0..poses.len()).map(|i| poses.parent_rotation(i, joint) * turn(i) * offset).collect()
        });
        let fit = |d: Vec<_>| GradientPredictor::fit(poses, parents, &d, Method::Published);
        let sequences: Vec<_> = sequences.collect();
        let predictors: Vec<_> = sequences.iter().cloned().map(fit).collect();
        for (predictor, sequence) in predictors.iter().zip(&sequences) {
            for (pose, expected) in sequence.iter().enumerate() {
                let found = predictor.predict(poses, pose);
                assert!((found - expected).amax() < 1e-6, "pose {pose}: {found}{expected}");
            }
        }

        let (p, j) = (predictors.len(), poses.joint_len());
        let number = |row: usize, column: usize| ((row * 7919 + column * 104_729) as f64).sin();
        let proxies = Reduced {
            c1: Mat::from_fn(4 * p, 3 * p, number),
            c2: Mat::from_fn(4 * p, 4 * j, |row, column| number(row + 1, column)),
        };
        for (reduced, len) in [(proxies.and_joints(), (2 * p).max(p + j)), (proxies, 2 * p)] {
            let expected = reduced.palette(&predict_stacked(&predictors, poses), poses);
            let carried = carried(&predictors, &reduced);
            let weights = training.lbs.weights.clone();
            let found = Fitted::new(&training, weights, Some(carried)).envelope.palettes(poses);
            assert_eq!((p > 1, found.ncols()), (true, 4 * len));
            let apart = (found.subcols(0, expected.ncols()) - &expected).norm_max();
            assert!(apart < 1e-12 * expected.norm_max(), "{apart}");
        }
    }
}
