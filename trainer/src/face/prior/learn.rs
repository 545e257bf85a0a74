//! What a take of weights says of them all.

use super::model::PriorModel;
use super::pairs::Pairs;
use faer::Mat;
use sinew_runtime::prior::PriorFit;

/// The floor of every variance, in mean variances: so that shapes which a take never used can move still. Below 1e-3
/// eight pins on such a shape leave as much as they found (METHOD §5.1).
pub const FLOOR: f64 = 0.1;

/// Least RMS change of moving weights, in shares of the full shape or of the largest weight. Tolerances of pins are wider,
/// and reciprocals of smaller variances leave the range of numbers that a file may hold.
const STILL: f64 = 1e-4;

/// Whether weights change by more than noise and rounding.
///
/// - `frames`: N x S weights.
pub fn is_moving(frames: &[Vec<f64>]) -> bool {
    let all = || frames.iter().flatten();
    let mean = mean(frames);
    let squares = all().zip(mean.iter().cycle()).map(|(w, mean)| (w - mean).powi(2));
    let variance = squares.sum::<f64>() / all().count().max(1) as f64;
    let largest = all().fold(1.0, |most: f64, w| most.max(w.abs()));
    variance.sqrt() > STILL * largest
}

/// Computes the mean weights, S; none without frames.
fn mean(frames: &[Vec<f64>]) -> Vec<f64> {
    let n = frames.len() as f64;
    let len = frames.first().map_or(0, Vec::len);
    (0..len).map(|shape| frames.iter().map(|frame| frame[shape] / n).sum()).collect()
}

/// Learns a prior from frames of weights: their mean, and their covariance with [`FLOOR`] on its diagonal. Of frames
/// without a motion the covariance is the identity, as [`slider`] has it.
///
/// - `frames`: N x S weights.
/// - `bounds`: S.
/// - `tolerance`: the length by which a pin may miss.
///
/// # Panics
/// If frames differ in length from `bounds`.
pub fn learned(
    frames: &[Vec<f64>],
    bounds: Vec<[f64; 2]>,
    pairs: &Pairs,
    tolerance: f64,
) -> PriorModel {
    let (n, s) = (frames.len().max(1) as f64, bounds.len());
    assert!(frames.iter().all(|frame| frame.len() == s), "frames of {s} weights");
    let mut model = slider(bounds, tolerance);
    if !frames.is_empty() {
        model.mean = mean(frames);
    }
    let centred = Mat::from_fn(frames.len(), s, |i, j| frames[i][j] - model.mean[j]);
    let covariance = centred.transpose() * &centred * faer::Scale(1.0 / n);
    let mean_variance = (0..s).map(|i| covariance[(i, i)]).sum::<f64>() / s.max(1) as f64;
    let is_moving = is_moving(frames);
    if is_moving {
        let floor = Mat::from_fn(s, s, |i, j| if i == j { FLOOR * mean_variance } else { 0.0 });
        model.covariance = covariance + floor;
    }
    // By how much mirrored weights differ; as for weights, never less than the floor.
    let floor = if is_moving { FLOOR * mean_variance } else { 1.0 };
    let apart = |[a, b]: [usize; 2]| {
        frames.iter().map(|frame| (frame[a] - frame[b]).powi(2)).sum::<f64>() / n
    };
    model.symmetry =
        pairs.mirrored.iter().map(|&pair| (pair, 1.0 / (apart(pair) + floor))).collect();
    model.cancel.clone_from(&pairs.cancelling);
    model.name = "prior".to_owned();
    model.fit.frames = frames.len() as f32;
    model
}

/// Makes the prior of the slider norm: no weight knows of another (Lewis and Anjyo 2010).
///
/// - `bounds`: S.
/// - `tolerance`: the length by which a pin may miss.
pub fn slider(bounds: Vec<[f64; 2]>, tolerance: f64) -> PriorModel {
    let s = bounds.len();
    PriorModel {
        name: "slider".to_owned(),
        skin: 0,
        mean: vec![0.0; s],
        covariance: Mat::identity(s, s),
        bounds,
        symmetry: Vec::new(),
        cancel: Vec::new(),
        fit: PriorFit { beta: beta(tolerance) as f32, ..PriorFit::default() },
    }
}

/// Returns β of the length by which a pin may miss: where the prior's misses are normal, that length is a pin's
/// standard deviation.
pub fn beta(tolerance: f64) -> f64 {
    tolerance * tolerance
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn covariance_is_that_of_the_frames_with_a_floor() {
        let frames = vec![vec![0.0, 1.0, 0.5], vec![1.0, 0.0, 0.5], vec![0.5, 0.5, 0.5]];
        let pairs = Pairs { mirrored: vec![[0, 1]], cancelling: vec![[1, 2]] };
        let model = learned(&frames, vec![[0.0, 1.0]; 3], &pairs, 0.02);
        assert!(model.mean.iter().all(|mean| (mean - 0.5).abs() < 1e-15));
        // Each of the first two has a variance of 1/6, the third none.
        let floor = FLOOR / 9.0;
        let sixth = 1.0 / 6.0;
        let expected =
            [[sixth + floor, -sixth, 0.0], [-sixth, sixth + floor, 0.0], [0.0, 0.0, floor]];
        for (i, row) in expected.iter().enumerate() {
            for (j, x) in row.iter().enumerate() {
                assert!((model.covariance[(i, j)] - x).abs() < 1e-15, "{i} {j}");
            }
        }
        let [([0, 1], stiffness)] = model.symmetry[..] else { panic!("one pair") };
        assert!((stiffness - 1.0 / (2.0 / 3.0 + floor)).abs() < 1e-12);
        assert_eq!((model.cancel, model.fit.frames), (vec![[1, 2]], 3.0));
        assert!((f64::from(model.fit.beta) - 4e-4).abs() < 1e-10);
    }

    #[test]
    fn frames_without_a_motion_give_the_slider_norm() {
        // Rounding makes a variance of about 1e-33 of 0.3 and 0.7, and programs write with some noise.
        let pose = |noise: f64| vec![0.25 + noise, 0.3, 0.7 - noise, 1.0];
        for (count, noise) in [(0, 0.0), (1, 0.0), (3, 0.0), (7, 0.0), (50, 0.0), (50, 1e-5)] {
            let frames: Vec<_> =
                (0..count).map(|k| pose(if k % 2 == 0 { noise } else { -noise })).collect();
            assert!(!is_moving(&frames));
            let model = learned(&frames, vec![[0.0, 1.0]; 4], &Pairs::default(), 1.0);
            assert_eq!(model.covariance, Mat::<f64>::identity(4, 4), "{count} {noise}");
            let expected = if frames.is_empty() { vec![0.0; 4] } else { pose(0.0) };
            assert!(model.mean.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12));
        }
        // What counts is the largest weight where it is above 1.
        let scaled = |by: f64| {
            vec![pose(0.0), pose(0.01)]
                .into_iter()
                .map(move |frame| frame.into_iter().map(|w| by * w).collect::<Vec<_>>())
        };
        assert!(is_moving(&scaled(1.0).collect::<Vec<_>>()));
        assert!(is_moving(&scaled(100.0).collect::<Vec<_>>()));
        assert!(!is_moving(&scaled(0.001).collect::<Vec<_>>()));
    }
}
