//! The kernel maps, over very many poses.

use conformance::backend::{Poses, part};
use conformance::compare::Mismatch;
use conformance::cpu::Cpu;
use conformance::models::{self, shape_of};
use conformance::stages::correction::on;
use conformance::stages::features::features_of;
use conformance::subject::Subject;
use sinew_runtime::Matrix3x4;
use sinew_runtime::envelope::Predictor;

const IDENTITY: Matrix3x4 = [[1.0, 0., 0., 0.], [0., 1.0, 0., 0.], [0., 0., 1.0, 0.]];

/// Confidence of a pose that is outside the trained range (below), and inside (above).
const LOW: f32 = 0.1;
const HIGH: f32 = 0.5;

/// Compares the maps alone, without a base and a rotation, which would hide their errors; the first
/// group's outputs are its latent values. The errors reach at most 0.34 of the maps' bounds, and
/// 0.09 of the confidence's bound: a sum of squares, whose errors seldom have equal signs.
#[test]
fn a_hundred_thousand_poses_are_within_the_bound() {
    let bytes = models::random(shape_of(Predictor::Kernel));
    let subject = Subject::new("random", &bytes, 100_000);
    let envelope = &subject.loaded.envelope;
    let features = features_of(&Cpu, &subject).unwrap();
    let run = |half: usize| {
        let features = part(&features, 2, half);
        let n = features.len() / envelope.counts().feature_len();
        let still = vec![IDENTITY; n * envelope.joint_len()];
        let still = Poses { len: n, joints: &still, curves: &[] };
        let nothing = vec![[[0.0; 4]; 3]; n * envelope.palette_len()];
        let (findings, confidences) = on(&Cpu, &subject, still, features, &nothing).unwrap();
        let mut counts = [0; 3];
        for confidence in confidences {
            counts[if confidence < LOW { 0 } else { 1 + usize::from(confidence > HIGH) }] += 1;
        }
        (findings, counts)
    };
    let halves = std::thread::scope(|scope| {
        let other = scope.spawn(|| run(1));
        [run(0), other.join().expect("the other half ends as well")]
    });
    for (findings, counts) in halves {
        let beyond: Option<Mismatch> = findings.iter().find_map(|finding| finding.mismatch);
        assert_eq!(beyond, None);
        let worst = findings.map(|finding| finding.worst);
        println!("{worst:.3?} of the bounds; none, some, all: {counts:?}");
        assert!(counts.iter().all(|&count| count > 2_000), "{counts:?}");
        let is_of_use = worst[0] > 0.1 && worst[1] > 0.05;
        assert!(is_of_use, "a bound without use: {worst:?}");
    }
}
