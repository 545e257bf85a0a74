//! Learns priors over the weights of shapes from takes (METHOD §5.1).

use super::names::{Expression, Side};
use crate::envelope::model::PriorModel;
use faer::Mat;
use sinew_runtime::prior::PriorFit;

/// Floor of every variance, as a fraction of the mean variance, so that shapes unused in a take can still move. With a
/// floor below 1e-3, eight pins on an unused shape do not reduce the error (METHOD §5.1).
pub const FLOOR: f64 = 0.1;

/// Least RMS change of moving weights, relative to the full shape or the largest weight. Tolerances of pins are wider.
/// Reciprocals of smaller variances exceed the range of numbers in a file.
const STILL: f64 = 1e-4;

/// Cosine between the deltas of a pair below which the shapes cancel. In ICT-FaceKit the jaw has -0.98 and the mouth
/// -0.78; all other pairs are above -0.01.
const OPPOSED: f64 = -0.5;

/// Pairs of a left and a right shape.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Pairs {
    /// Pairs that mirror each other, such as a smile's two sides.
    pub mirrored: Vec<[usize; 2]>,
    /// Mutually exclusive pairs that move the same part to opposite sides, such as the jaw.
    pub cancelling: Vec<[usize; 2]>,
}

/// Learns a prior from frames of weights: the mean, and the covariance with [`FLOOR`] on its diagonal. Without motion
/// the covariance is the identity, as in [`slider`].
///
/// - `frames`: weights, N x S.
/// - `bounds`: least and greatest weight, S.
/// - `tolerance`: pins may miss by this length.
///
/// # Panics
/// If a frame's length differs from S.
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
    let mut floor = 1.0;
    if is_moving(frames) {
        floor = FLOOR * mean_variance;
        model.covariance = covariance + Mat::from_fn(s, s, |i, j| if i == j { floor } else { 0.0 });
    }
    // The stiffness depends on the mean square difference of mirrored weights, plus the floor.
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

/// Creates the prior of the slider norm: independent weights of equal variance (Lewis and Anjyo 2010).
///
/// - `bounds`: least and greatest weight, S.
/// - `tolerance`: pins may miss by this length.
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
        fit: PriorFit { beta: (tolerance * tolerance) as f32, ..PriorFit::default() },
    }
}

/// Finds left and right pairs by name, and classifies them by their deltas.
///
/// - `names`: S.
/// - `deltas`: S x V.
pub fn pairs(names: &[String], deltas: &[Vec<[f64; 3]>]) -> Pairs {
    let all: Vec<Expression> = names.iter().map(|name| Expression::of(name)).collect();
    let mut found = Pairs::default();
    for (left, expression) in all.iter().enumerate() {
        if expression.side != Some(Side::Left) {
            continue;
        }
        let other = Expression { stem: expression.stem.clone(), side: Some(Side::Right) };
        let Some(right) = all.iter().position(|expression| *expression == other) else { continue };
        let [Some(a), Some(b)] = [left, right].map(|shape| deltas.get(shape)) else { continue };
        let (a, b) = (a.as_flattened(), b.as_flattened());
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let is_opposed = dot(a, b) < OPPOSED * (dot(a, a) * dot(b, b)).sqrt();
        let which = if is_opposed { &mut found.cancelling } else { &mut found.mirrored };
        which.push([left, right]);
    }
    found
}

/// Returns whether weights change by more than noise and rounding.
///
/// - `frames`: weights, N x S.
pub fn is_moving(frames: &[Vec<f64>]) -> bool {
    let all = || frames.iter().flatten();
    let mean = mean(frames);
    let squares = all().zip(mean.iter().cycle()).map(|(w, mean)| (w - mean).powi(2));
    let variance = squares.sum::<f64>() / all().count().max(1) as f64;
    let largest = all().fold(1.0, |most: f64, w| most.max(w.abs()));
    variance.sqrt() > STILL * largest
}

/// Computes the mean weights, S; empty without frames.
fn mean(frames: &[Vec<f64>]) -> Vec<f64> {
    let n = frames.len() as f64;
    let len = frames.first().map_or(0, Vec::len);
    (0..len).map(|shape| frames.iter().map(|frame| frame[shape] / n).sum()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_covariance_of_frames_gets_a_floor() {
        let frames = vec![vec![0.0, 1.0, 0.5], vec![1.0, 0.0, 0.5], vec![0.5, 0.5, 0.5]];
        let pairs = Pairs { mirrored: vec![[0, 1]], cancelling: vec![[1, 2]] };
        let model = learned(&frames, vec![[0.0, 1.0]; 3], &pairs, 0.02);
        assert!(model.mean.iter().all(|mean| (mean - 0.5).abs() < 1e-15));
        // The first two weights have a variance of 1/6, the third has 0.
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
        // Rounding gives 0.3 and 0.7 a variance of about 1e-33, and some programs write noisy weights.
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
        // Above 1, the largest weight sets the scale.
        let scaled = |by: f64| {
            vec![pose(0.0), pose(0.01)]
                .into_iter()
                .map(move |frame| frame.into_iter().map(|w| by * w).collect::<Vec<_>>())
        };
        assert!(is_moving(&scaled(1.0).collect::<Vec<_>>()));
        assert!(is_moving(&scaled(100.0).collect::<Vec<_>>()));
        assert!(!is_moving(&scaled(0.001).collect::<Vec<_>>()));
    }

    #[test]
    fn opposed_pairs_cancel_and_other_pairs_mirror() {
        let names = ["smile_R", "jawLeft", "smile_L", "jawOpen", "jawRight", "blinkLeft"];
        let names = names.map(str::to_owned);
        let deltas: Vec<Vec<[f64; 3]>> = [
            [[-1.0, 1.0, 0.0], [0.0; 3]],
            [[1.0, 0.0, 0.0], [1.0, 0.0, 0.1]],
            [[0.0; 3], [1.0, 1.0, 0.0]],
            [[0.0, -1.0, 0.0], [0.0, -1.0, 0.0]],
            [[-1.0, 0.0, 0.1], [-1.0, 0.0, 0.0]],
            [[1.0, 0.0, 0.0], [0.0; 3]],
        ]
        .map(Vec::from)
        .into();
        let found = pairs(&names, &deltas);
        assert_eq!(found, Pairs { mirrored: vec![[2, 0]], cancelling: vec![[1, 4]] });
    }
}
