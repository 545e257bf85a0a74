//! Real archives beside the repository, against what another importer made of them.

use super::*;
use crate::examples::{Examples, npz};
use crate::formats::testing::shared;

/// Reads an archive of y up, and the arrays of z up that Blender made of the same.
fn both(archive: &str, arrays: &str) -> Option<(PosedMeshes, Examples)> {
    let bytes = std::fs::read(shared(archive)?).unwrap();
    Some((parse(&bytes).unwrap(), npz::load(&shared(arrays)?).unwrap().examples))
}

/// Farthest that positions of y up lie from some of z up.
fn farthest(found: &[[f64; 3]], expected: &[[f64; 3]]) -> f64 {
    assert_eq!(found.len(), expected.len());
    let apart = |(&[x, y, z], expected): (&[f64; 3], &[f64; 3])| {
        let differences = [x, -z, y].into_iter().zip(expected).map(|(a, b)| (a - b).abs());
        differences.fold(0.0, f64::max)
    };
    found.iter().zip(expected).map(apart).fold(0.0, f64::max)
}

/// From Maya: a transform above the mesh, every other sample stored.
#[test]
fn an_archive_from_maya_is_as_blender_reads_it() {
    let Some((found, expected)) = both("dem-bones/Bone_Anim.abc", "dem-bones/bone.npz") else {
        return;
    };
    assert_eq!((found.vertex_len, found.vertices.len()), (754, 754 * 400));
    // The arrays stand a little higher, in every frame alike, than the archive's transform says.
    let lifted: Vec<_> = found.vertices.iter().map(|&[x, y, z]| [x, y + 9.8e-6, z]).collect();
    assert!(farthest(&lifted, &expected.vertices) < 5e-7);
    assert_eq!(found.triangles, Some(expected.triangles));
    assert_eq!((found.rest, found.reference), (None, None));
    assert_eq!(found.parts[0].names, ["Bone", "BoneShape"]);
}

/// From Blender, with coordinates for textures.
#[test]
fn an_archive_from_blender_holds_its_meshes() {
    let Some((found, expected)) = both("leg/leg.abc", "leg/leg.npz") else { return };
    assert_eq!((found.vertex_len, found.vertices.len()), (3938, 3938 * 122));
    assert_eq!(farthest(&found.vertices, &expected.vertices), 0.0);
    assert_eq!(found.reference.unwrap().len(), 3938);
    assert_eq!(found.triangles, Some(expected.triangles));
    assert_eq!(found.parts[0].names, ["Leg", "LegMesh"]);
}

#[test]
fn spoiled_real_archives_do_no_harm() {
    let Some(file) = shared("dem-bones/Bone_Anim.abc") else { return };
    let mut bytes = std::fs::read(file).unwrap();
    let len = bytes.len();
    for len in (0..len).step_by(len / 40) {
        assert!(parse(&bytes[..len]).is_err());
    }
    // Samples stand at the front, what names them at the end.
    let random = (0..80).map(|number| number * 7919 * 31 % len);
    for place in random.chain((len - len / 60..len).step_by(997)) {
        for change in [0x01, 0x80, 0xff] {
            bytes[place] ^= change;
            drop(parse(&bytes));
            bytes[place] ^= change;
        }
    }
}
