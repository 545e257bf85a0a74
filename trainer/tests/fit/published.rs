//! S3 as published: content of its file, and its errors; and the envelope without reduction.

use crate::fit::full::Full;
use nalgebra::Matrix3x4 as Transform;
use sinew_runtime::{Envelope, Matrix3x4, Model};
use sinew_trainer::envelope::model::EnvelopeModel;
use sinew_trainer::envelope::oracle::Pose;
use sinew_trainer::envelope::s3::ProxyCount;
use sinew_trainer::envelope::{Options, Predict, train};
use sinew_trainer::evaluate::{Frames, evaluate};
use sinew_trainer::examples::Split;
use sinew_trainer::examples::demo::{DemoOptions, demo};
use sinew_trainer::progress::Silent;

#[test]
fn a_published_fit_is_near_and_not_exact_at_rest_and_its_file_is_the_oracle() {
    let examples = demo(&DemoOptions { vertices: 600, poses: 60, held_out: 20, seed: 3 });
    let (proxies, joints) = (20, examples.joint_len());
    let options = Options {
        predictor: Predict::Published,
        proxies: Some(ProxyCount::Fixed(proxies)),
        ..Options::default()
    };
    let trained = train(&examples, &options, &Silent).unwrap();
    let found = evaluate(&trained.model, None, &examples, Frames::Of(Split::HeldOut)).unwrap();
    let share = found.errors.rms / found.lbs.rms;
    // On the demo the error is a fraction of that of LBS, but never as small as a refinement's
    // 0.03.
    assert!((0.1..0.9).contains(&share), "{share}");
    let report = trained.report.rotational.as_ref().unwrap();
    assert!((0.3..1.0).contains(&report.choice.near_rigid_fraction), "{:?}", report.choice);
    assert!(report.near_rigid_deviation < 1e-12, "F stays on LBS: {report:?}");

    let file = Model::from_bytes(&trained.model).unwrap();
    let envelope = file.first::<Envelope>().unwrap();
    let oracle = EnvelopeModel::from_file(&envelope);
    let mut scratch = vec![0.0; envelope.scratch_len()];
    let mut palette = vec![Matrix3x4::default(); envelope.palette_len()];
    assert_eq!(palette.len(), 2 * proxies);
    let mut of = |pose: &[Matrix3x4]| {
        envelope.palette(pose, &[], &mut scratch, &mut palette).unwrap();
        let wide = |m: &Matrix3x4| Transform::from_fn(|r, c| f64::from(m[r][c]));
        let pose: Vec<_> = pose.iter().map(wide).collect();
        (
            palette.iter().map(wide).collect::<Vec<_>>(),
            oracle.evaluate(Pose { joints: &pose, curves: &[] }).0,
        )
    };
    for frame in examples.frames_of(Split::HeldOut) {
        let pose: Vec<Matrix3x4> =
            examples.pose(frame).iter().map(|m| m.map(|r| r.map(|x| x as f32))).collect();
        let (found, expected) = of(&pose);
        for (found, expected) in found.iter().zip(&expected) {
            assert!((found - expected).amax() < 1e-4 * expected.amax().max(1.0), "frame {frame}");
        }
    }
    let rest = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
    let (mut found, _) = of(&vec![rest; joints]);
    // Reconstructions from the bias only have a zero proxy.
    found.retain(|m| m.fixed_columns::<3>(0).amax() > 1e-3);
    assert_eq!(found.len(), proxies + joints);
    let moved = |m: &Transform<f64>| (m - Transform::identity()).amax();
    let still = found.iter().filter(|m| moved(m) < 1e-5).count();
    assert!((joints..joints + proxies).contains(&still), "{still}");
}

#[test]
fn an_arm_is_reconstructed_in_full_from_poses_that_were_not_seen() {
    let examples = demo(&DemoOptions { vertices: 300, poses: 60, held_out: 20, seed: 1 });
    let full = Full::fit(&examples, 0.25).unwrap();
    let [found, lbs] = [full.rms(Full::reconstruct), full.rms(Full::skinned)];
    assert!(found < 0.5 * lbs, "{found} against {lbs} of LBS");
}
