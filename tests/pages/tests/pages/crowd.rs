//! "Threads", "Crowds and culling", "Ownership", "Hot reload", "Packed vertices", "Levels of
//! detail".

use crate::math::{diagonal, farthest, palette, rest, skinned};
use crate::shown::{crowd, crowd_on_threads, culling, levels, ownership, packed, reload, threads};
use models::{Pieces, SMALL, Shape};
use pages::arm;
use sinew_runtime::envelope::Predictor;
use sinew_runtime::{Envelope, Matrix3x4, Model, Skin};
use std::sync::Arc;

const CROWD: usize = 24;

/// Poses of a crowd, in sequence.
fn poses() -> Vec<Matrix3x4> {
    (0..CROWD).flat_map(|character| arm::pose(&arm::EXAMPLES, character)).collect()
}

#[test]
fn pieces_on_threads_have_the_bits_of_one_job() {
    // More vertices than two pieces.
    let shape = Shape { vertices: 2500, ..SMALL };
    let model = Model::from_bytes(Pieces::sample(Predictor::Kernel, shape).bytes()).unwrap();
    let skin = model.first::<Skin>().unwrap();
    let transform = |at: usize| {
        let shift = at as f32;
        [[0.5, 0.0, 1.0, shift], [0.0, 1.0, 0.25, -shift], [1.0, 0.0, 0.5, 1.0]]
    };
    let palette: Vec<Matrix3x4> = (0..skin.palette_len()).map(transform).collect();
    let mut buffer = vec![7.0; 5 * skin.vertex_len()];
    threads::skin_in_pieces(skin, &palette, &mut buffer, 5).unwrap();
    let found: Vec<_> = buffer.chunks_exact(5).map(|v| [v[0], v[1], v[2]]).collect();
    assert_eq!(found, skinned(&model, &palette));
    assert!(buffer.chunks_exact(5).all(|vertex| vertex[3..] == [7.0; 2]));
}

#[test]
fn a_crowd_is_the_same_on_one_thread_and_on_many_and_those_behind_are_culled() {
    let model = Model::from_bytes(arm::FILE.as_slice()).unwrap();
    let (envelope, skin) = (model.first::<Envelope>().unwrap(), model.first::<Skin>().unwrap());
    let mut palettes = [0, 1].map(|_| vec![Matrix3x4::default(); CROWD * envelope.palette_len()]);
    let mut confidences = [[0.0; CROWD]; 2];
    let [one, many] = &mut palettes;
    let mut scratch = vec![0.0; envelope.scratch_len()];
    let poses = poses();
    crowd::crowd(&envelope, (&poses, &[]), &mut scratch, one, &mut confidences[0]).unwrap();
    crowd_on_threads::crowd_on_threads(&envelope, (&poses, &[]), many, &mut confidences[1])
        .unwrap();
    assert_eq!(one, many);
    assert_eq!(confidences[0], confidences[1]);
    // A camera that sees boxes that reach beyond a wall: half of the boxes do.
    let all: Vec<_> = one.chunks_exact(envelope.palette_len()).collect();
    let boxes = all.iter().map(|palette| skin.bounds(palette, 0.0).unwrap().unwrap().max[1]);
    let mut sides: Vec<f32> = boxes.collect();
    sides.sort_by(f32::total_cmp);
    let wall = sides[CROWD / 2];
    let list = culling::seen(skin, one, |_, bounds| bounds.max[1] > wall).unwrap();
    assert!(!list.is_empty() && list.len() < CROWD, "{list:?}");
    for (character, palette) in all.into_iter().enumerate() {
        let seen = skinned(&model, palette).iter().any(|x| x[1] > wall);
        assert!(list.contains(&character) || !seen, "nobody who is seen is culled");
    }
}

#[test]
fn a_kind_opens_its_file_and_a_reload_replaces_it() {
    let model = Arc::new(Model::from_bytes(arm::FILE.clone()).unwrap());
    let kind = ownership::Kind::new(Arc::clone(&model)).unwrap();
    let own = std::thread::scope(|scope| {
        let other = kind.clone();
        scope.spawn(move || other.views().map(|(envelope, _)| envelope.joint_len())).join().unwrap()
    });
    assert_eq!(own, Some(model.first::<Envelope>().unwrap().joint_len()));
    let asset = reload::Asset::new(Model::from_bytes(arm::FILE.clone()).unwrap());
    assert!(asset.reload(vec![1, 2, 3]).is_err());
    assert_eq!(asset.model().id(), model.id());
    asset.reload(models::GOLDEN[0].to_vec()).unwrap();
    assert!(asset.model().id() != model.id());
    let other = asset.model();
    let level = levels::levels(&other, other.first::<Envelope>().unwrap().name())[0];
    let (envelope, mut positions) = (model.first::<Envelope>().unwrap(), vec![[0.0; 3]; 1]);
    let (palette, _) = palette(&envelope, &arm::pose(&arm::EXAMPLES, 3));
    // With another file, the level opens nothing.
    levels::skin_level(&model, &level, &palette, &mut positions).unwrap();
    assert_eq!(positions, [[0.0; 3]]);
}

#[test]
fn packed_positions_are_within_a_step_of_16_bits() {
    let model = Model::from_bytes(arm::FILE.as_slice()).unwrap();
    let skin = model.first::<Skin>().unwrap();
    let (palette, _) = palette(&model.first::<Envelope>().unwrap(), &arm::pose(&arm::EXAMPLES, 3));
    let bounds = skin.bounds(&palette, 0.0).unwrap().unwrap();
    let mut out = vec![[0; 4]; skin.vertex_len()];
    packed::skin_packed(skin, &palette, bounds, &mut out).unwrap();
    let position = |v: &[u16; 4]| {
        [0, 1, 2]
            .map(|c| bounds.min[c] + f32::from(v[c]) / 65535.0 * (bounds.max[c] - bounds.min[c]))
    };
    let found: Vec<_> = out.iter().map(position).collect();
    let size = diagonal(&[bounds.min, bounds.max]);
    assert!(farthest(&found, &skinned(&model, &palette), size) < 1.0 / 65535.0);
    assert!(diagonal(&rest(&skin)) < 2.0 * size);
}
