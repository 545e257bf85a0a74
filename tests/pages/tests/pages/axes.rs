//! "Your axes": converts an engine's poses into the file's axes and palettes back, and compares
//! with a file in the engine's axes.

use crate::math::{diagonal, farthest, moved, palette, product, rest, skinned};
use crate::shown::axes::{TO_ENGINE, TO_FILE, palette_of_engine, pose_of_file};
use models::cells;
use pages::arm;
use sinew_runtime::envelope::Predictor;
use sinew_runtime::format::Space;
use sinew_runtime::skin::Output;
use sinew_runtime::{Envelope, Matrix3x4, Model, Skin, SkinJob};

/// Frames of clips that the training did not use.
fn held_out() -> impl Iterator<Item = usize> {
    (0..arm::EXAMPLES.split.len())
        .filter(|&f| arm::EXAMPLES.split[f] == sinew_trainer::examples::Split::HeldOut)
}

/// Rotates a direction and normalises it.
fn turned(m: &Matrix3x4, [x, y, z]: [f32; 3]) -> [f32; 3] {
    let v = m.map(|[a, b, c, _]| a * x + b * y + c * z);
    let length = dot(v, v).sqrt();
    v.map(|x| x / length)
}

fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

#[test]
fn a_left_handed_engine_gets_the_same_skin_by_both_ways() {
    let file = Model::from_bytes(arm::FILE.as_slice()).unwrap();
    let mut converted = arm::EXAMPLES.clone();
    assert!(converted.convert_to(&Space::UNREAL).unwrap().is_mirrored());
    let baked = Model::from_bytes(arm::file(&converted, Predictor::Kernel)).unwrap();
    assert!(file.space() == Space::GLTF && baked.space() == Space::UNREAL);
    let (envelope, skin) = (file.first::<Envelope>().unwrap(), file.first::<Skin>().unwrap());
    let size = diagonal(&rest(&skin));
    let (mut by_matrices, mut by_training) = (0.0_f32, 0.0_f32);
    for frame in held_out() {
        let pose = arm::pose(&arm::EXAMPLES, frame);
        let (own, _) = palette(&envelope, &pose);
        let expected: Vec<_> =
            skinned(&file, &own).into_iter().map(|x| moved(&TO_ENGINE, x)).collect();
        // Poses in the engine's axes.
        let engine = arm::pose(&converted, frame);
        let mut taken = vec![Matrix3x4::default(); pose.len()];
        pose_of_file(&engine, &mut taken);
        let (mut given, _) = palette(&envelope, &taken);
        palette_of_engine(&mut given);
        by_matrices = by_matrices.max(farthest(&skinned(&file, &given), &expected, 100.0 * size));
        // The engine's mesh, in the engine's axes: S T S⁻¹.
        let ours: Vec<_> = given.iter().map(|transform| product(transform, &TO_FILE)).collect();
        let blended = |v: usize| {
            let x = moved(&TO_ENGINE, skin.rest_position(v).unwrap());
            let mut sum = [0.0; 3];
            for (transform, weight) in skin.influences(v) {
                let own = moved(&ours[transform], x);
                (0..3).for_each(|c| sum[c] += weight * own[c]);
            }
            sum
        };
        let plainly: Vec<_> = (0..skin.vertex_len()).map(blended).collect();
        by_matrices = by_matrices.max(farthest(&plainly, &expected, 100.0 * size));
        let (trained, _) = palette(&baked.first::<Envelope>().unwrap(), &engine);
        by_training =
            by_training.max(farthest(&skinned(&baked, &trained), &expected, 100.0 * size));
    }
    println!("axes: by matrices {by_matrices:.1e}, by training {by_training:.1e} of the diagonal");
    assert!(by_matrices < 2e-5 && by_training < 3e-5, "what the page says");
    assert!(by_matrices > 0.0 && by_training > 0.0, "they are not compared with themselves");
}

#[test]
fn normals_stay_outward_and_tangents_change_their_sign() {
    let file = Model::from_bytes(arm::FILE.as_slice()).unwrap();
    let (envelope, skin) = (file.first::<Envelope>().unwrap(), file.first::<Skin>().unwrap());
    assert!(skin.has_tangents());
    let (own, _) = palette(&envelope, &arm::pose(&arm::EXAMPLES, 36));
    let mut given = own.clone();
    palette_of_engine(&mut given);
    let directions = |palette: &[Matrix3x4]| {
        let mut all = vec![0.0; 7 * skin.vertex_len()];
        let floats = cells(&mut all);
        SkinJob::new(skin, palette)
            .normals(Output::shared(floats, 7))
            .tangents(Output::shared(&floats[3..], 7))
            .run()
            .unwrap();
        all.as_chunks::<7>().0.to_vec()
    };
    for (own, given) in directions(&own).into_iter().zip(directions(&given)) {
        let [[a, b, c, d, e, f, w], [g, h, i, j, k, l, hand]] = [own, given];
        let (normal, tangent) = ([a, b, c], [d, e, f]);
        assert!(dot(turned(&TO_ENGINE, normal), [g, h, i]) > 0.9999);
        assert!(dot(turned(&TO_ENGINE, tangent), [j, k, l]) > 0.9999);
        // The bitangent, transformed as a direction on the surface, has the opposite sign.
        let bitangent = turned(&TO_ENGINE, cross(normal, tangent).map(|x| w * x));
        let found = cross([g, h, i], [j, k, l]).map(|x| -hand * x);
        assert!(dot(bitangent, found) > 0.99);
    }
}
