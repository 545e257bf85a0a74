//! "Your mesh": an engine's vertices, matched with the file's.

use crate::math::{diagonal, farthest, palette, rest, skinned};
use crate::shown;
use pages::arm;
use sinew_runtime::Model;

#[test]
fn a_mesh_in_another_order_is_matched_and_skinned() {
    let model = Model::from_bytes(arm::FILE.as_slice()).unwrap();
    let skin = model.skin().unwrap();
    let v = skin.vertex_len();
    // Backwards, and every third twice.
    let own: Vec<usize> =
        (0..v).rev().flat_map(|v| [v; 2].into_iter().take(1 + usize::from(v % 3 == 0))).collect();
    let vertex = |&v: &usize| (skin.rest_position(v).unwrap(), skin.rest_normal(v).unwrap());
    let all: Vec<_> = own.iter().map(vertex).collect();
    let size = diagonal(&rest(&skin));
    let (remap, off) = shown::mesh::remap(&skin, &all, size / 1000.0);
    assert!(off == 0.0);
    let (palette, _) = palette(&model.envelope().unwrap(), &arm::pose(&arm::EXAMPLES, 35));
    let mut buffer = vec![7.0; 8 * own.len()];
    shown::vertices::skin_mesh(skin, &palette, &remap, &mut buffer).unwrap();
    let expected = skinned(&model, &palette);
    let expected: Vec<_> = own.iter().map(|&v| expected[v]).collect();
    let found: Vec<_> =
        buffer.chunks_exact(8).map(|vertex| [vertex[0], vertex[1], vertex[2]]).collect();
    assert!(farthest(&found, &expected, size) < 1e-6);
    assert!(
        buffer.chunks_exact(8).all(|vertex| vertex[6..] == [7.0; 2]),
        "texture coordinates stay"
    );
    // In centimetres it is another mesh.
    let other: Vec<_> = all.iter().map(|(x, n)| (x.map(|x| 100.0 * x), *n)).collect();
    assert!(shown::mesh::remap(&skin, &other, size / 1000.0).1 > size);
}
