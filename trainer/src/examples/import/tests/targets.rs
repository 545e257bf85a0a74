//! Which files are read as posed meshes, and what is refused.

use super::super::npz;
use super::super::targets::{TargetMeshes, read};
use crate::examples::testing::triangle;
use crate::examples::{ExamplesError, Split};
use crate::formats::posed_meshes::PosedMeshes;
use crate::formats::testing::Folder;
use crate::formats::{FormatError, save_pc2};
use std::path::Path;

#[track_caller]
fn refused(path: &Path, at: &Path, expected: &str) {
    let error = read(path).expect_err("the file should be refused");
    assert_eq!((error.file.as_path(), error.error.to_string().as_str()), (at, expected));
}

#[test]
fn arrays_give_what_they_have() {
    let folder = Folder::new("arrays");
    let mut examples = triangle(4);
    examples.vertices[5] = [0.25, -3.5, 1e-3];
    examples.split[2] = Split::Extreme;
    let file = folder.0.join("set.npz");
    npz::save_npz(&file, &examples, &[]).unwrap();
    let meshes = PosedMeshes {
        rest: Some(examples.rest.clone()),
        triangles: Some(examples.triangles.clone()),
        ..PosedMeshes::bare(3, examples.vertices.clone())
    };
    let expected = TargetMeshes { split: Some(examples.split.clone()), ..meshes.into() };
    assert_eq!(read(&file).unwrap(), expected);
}

#[test]
fn endings_may_be_in_capitals() {
    let folder = Folder::new("capitals");
    let file = folder.0.join("a.PC2");
    let vertices = vec![[0.5, -0.25, 1024.0], [1.0, 2.0, 3.0]];
    save_pc2(&file, 1, &vertices).unwrap();
    let meshes = PosedMeshes::bare(1, vertices);
    assert_eq!(read(&file).unwrap(), TargetMeshes::from(meshes));
}

#[test]
fn what_is_no_kind_of_posed_meshes_is_named() {
    let folder = Folder::new("kinds");
    let kinds = "expected a file that ends in .abc, .pc2, .mdd, .npz, .glb, .gltf or .obj";
    for (name, found) in [("a.txt", ".txt"), ("a", "none"), ("a.FBX", ".fbx")] {
        let path = folder.0.join(name);
        let expected = format!("{kinds}, found {found}");
        refused(&path, &path, &expected);
    }
    let expected = "is a folder without an .obj file; export one a frame, numbered: pose_1.obj, \
                    pose_2.obj";
    refused(&folder.0, &folder.0, expected);
    for name in ["a.pc2", "a.mdd", "a.npz"] {
        let error = read(&folder.0.join(name)).unwrap_err();
        assert!(
            matches!(error.error, ExamplesError::Format(FormatError::Read(_)))
                && error.file.ends_with(name)
        );
    }
    let error = read(&folder.0.join("none/a1.obj")).unwrap_err();
    assert!(
        matches!(error.error, ExamplesError::Format(FormatError::Read(_)))
            && error.file.ends_with("none")
    );
}
