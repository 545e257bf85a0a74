//! From a pose to the skin: the stages' tolerances chained.

use crate::Subject;
use crate::gradients::gradients_of;
use crate::palette::maps_within;
use crate::skin::{palette_of, skin, skin_within};
use conformance::backend::Backend;
use conformance::compare::{Mismatch, within};
use conformance::poses::{Kind, Pose, rigid_motion, rounded};
use conformance::tolerance::{self, EXACT, Inexact, Map, UNDERFLOW};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use sinew_runtime::Matrix3x4;
use sinew_trainer::envelope::oracle::after;

/// Largest ratios: palette, confidence, positions, normals, tangents.
pub(crate) fn body(backend: &impl Backend, subject: &Subject<'_>) -> Result<[f64; 5], Mismatch> {
    let mut worst = [0.0_f64; 5];
    for pose in &subject.poses {
        let ratios = one(backend, subject, &pose.maps, &Inexact::exact(pose.widened()))?;
        worst = std::array::from_fn(|i| worst[i].max(ratios[i]));
    }
    Ok(worst)
}

/// A pose carried off by a rigid motion, rounded after it, gives the moved skin. Largest ratios as
/// above.
pub(crate) fn equivariance(
    backend: &impl Backend,
    subject: &Subject<'_>,
) -> Result<[f64; 5], Mismatch> {
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let diagonal = f64::from(subject.envelope.certificate().diagonal);
    let mut worst = [0.0_f64; 5];
    for pose in subject.poses.iter().take(crate::FEWER_POSES) {
        let motion = rigid_motion(diagonal, &mut random);
        let moved: Vec<_> = pose.widened().iter().map(|map| after(&motion, map)).collect();
        oracle_is_equivariant(subject, pose, &motion, &moved);
        let given: Vec<_> = moved.iter().map(rounded).collect();
        let ratios = one(backend, subject, &given, &Inexact::rounded(moved))?;
        worst = std::array::from_fn(|i| worst[i].max(ratios[i]));
    }
    Ok(worst)
}

/// The rest pose gives the rest positions, although c1, c2 and the weights were rounded.
pub(crate) fn rest(backend: &impl Backend, subject: &Subject<'_>) -> Result<[f64; 2], Mismatch> {
    let Subject { envelope, oracle, poses, .. } = subject;
    assert_eq!(poses[0].kind, Kind::Rest);
    let (palette, _) = palette_of(backend, envelope, &poses[0].maps);
    let found = skin(backend, envelope, &palette);
    let expected: Vec<f64> =
        oracle.vertices.iter().flat_map(|v| <[f64; 3]>::from(v.position.xyz())).collect();
    let bounds = tolerance::rest(oracle);
    let tolerances: Vec<_> = bounds.iter().flat_map(|e| e.iter().map(|e| e + UNDERFLOW)).collect();
    let ratio = within(found.positions.as_flattened(), &expected, &tolerances)?;
    let errors = found.positions.as_flattened().iter().zip(&expected);
    let largest = errors.map(|(f, e)| (f64::from(*f) - e).abs()).fold(0.0, f64::max);
    // In roundings of a coordinate as long as the diagonal, for whoever reads the output.
    Ok([ratio, largest / (tolerance::U * f64::from(envelope.certificate().diagonal))])
}

fn one(
    backend: &impl Backend,
    subject: &Subject<'_>,
    given: &[Matrix3x4],
    pose: &Inexact<Map>,
) -> Result<[f64; 5], Mismatch> {
    let Subject { envelope, oracle, .. } = subject;
    let rotations = if envelope.predictor().reconstructs() {
        gradients_of(backend, envelope, given).rotations
    } else {
        Vec::new()
    };
    let (palette, found_confidence) = palette_of(backend, envelope, given);
    let found = skin(backend, envelope, &palette);
    let (expected, confidence) = tolerance::whole(oracle, pose, &rotations);
    let ratio = maps_within(&palette, &expected)?;
    let certain = within(&[found_confidence], &confidence.value, &confidence.error)?;
    let [positions, normals, tangents] = skin_within(&found, oracle, &expected)?;
    Ok([ratio, certain, positions, normals, tangents])
}

/// Equivariance is exact where nothing is rounded to f32; at a half turn f64 rounds too.
fn oracle_is_equivariant(subject: &Subject<'_>, pose: &Pose, motion: &Map, moved: &[Map]) {
    if pose.kind == Kind::HalfTurn {
        return;
    }
    let (still, confidence) = subject.oracle.evaluate(&pose.widened());
    let (carried, same) = subject.oracle.evaluate(moved);
    assert!((confidence - same).abs() <= EXACT);
    for (map, still) in carried.iter().zip(&still) {
        let expected = after(motion, still);
        assert!((map - expected).amax() <= EXACT * expected.amax().max(map.amax()).max(1e3));
    }
}
