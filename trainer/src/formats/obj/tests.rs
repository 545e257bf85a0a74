//! Tests of OBJ: meshes read and written, faulty lines, folders of shapes.

use super::*;
use crate::ErrorKind;
use crate::formats::testing::{Folder, shared, spoil};

const SQUARE: &str = "\
# a comment
mtllib square.mtl
v 0 0 0
v 1 0 0 0.5 0.5 0.5
v 1 1 0
v 0 1 0.125
vt 0 0
vt 0.5 0.25
vn 0 0 1
usemtl grey
s off
f 4/2/1 2/1/1 1/1/1
f -1//1 -2//1 -3//1
";

fn mesh(text: &str) -> Result<Mesh, Error> {
    let name = text.len().to_string() + &text.lines().count().to_string();
    load(&Folder::new(&format!("obj-{name}")).write("mesh.obj", text))
}

#[track_caller]
fn refused(text: &str, expected: &str) {
    let error = mesh(text).expect_err("the mesh should be refused");
    assert!(error.file().is_some_and(|file| file.ends_with("mesh.obj")), "{error}");
    assert_eq!(error.message(), expected);
}

#[test]
fn vertices_keep_their_order_and_numbers_count_from_either_end() {
    let mesh = mesh(SQUARE).unwrap();
    let positions = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.125]];
    assert_eq!(mesh.positions, positions);
    assert_eq!(mesh.triangles, [[3, 1, 0], [3, 2, 1]]);
    let engine = mesh.engine.unwrap();
    assert_eq!(engine.copy_of, [0, 1, 2, 3, 3]);
    assert_eq!(engine.triangles, [[3, 1, 0], [4, 2, 1]]);
    let none = [0.0; 2];
    let uv = vec![none, none, none, [0.5, 0.25], none];
    assert_eq!(engine.uv, Some(uv), "the second face has none");
    assert_eq!(engine.normals, Some(vec![[0.0, 0.0, 1.0]; 5]));
}

#[test]
fn a_seam_splits_only_the_engine_s_vertices() {
    let whole = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nvt 1 1\nvt 1 0\n";
    let uv = vec![[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]];
    let faces = "f 1/1 2/2 3/3\nf 2/5 4/4 3/3\n";
    let engine = mesh(&format!("{whole}{faces}")).unwrap().engine.unwrap();
    assert!(engine.is_one_each());
    assert_eq!(engine.uv, Some(uv));
    let seam = "f 1/1 2/2 3/3\nf 2/4 4/4 3/3\n";
    let mesh = mesh(&format!("{whole}{seam}")).unwrap();
    assert_eq!((mesh.positions.len(), &mesh.triangles[..]), (4, &[[0, 1, 2], [1, 3, 2]][..]));
    let engine = mesh.engine.unwrap();
    assert_eq!(engine.copy_of, [0, 1, 1, 2, 3]);
    assert_eq!(engine.triangles, [[0, 1, 3], [2, 4, 3]]);
    assert_eq!(engine.uv.unwrap()[1..3], [[1.0, 0.0], [1.0, 1.0]]);
}

#[test]
fn normals_by_corner_keep_edges_hard() {
    let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nvn 0 0 -2\nvn 0 -1 0\nvn 0 0 0\n\
                f 1//1 3//1 2//1\nf 1//2 2//2 4//3\n";
    let engine = mesh(text).unwrap().engine.unwrap();
    assert_eq!(engine.copy_of, [0, 0, 1, 1, 2, 3]);
    assert_eq!(engine.triangles, [[0, 4, 2], [1, 3, 5]]);
    let (down, back) = ([0.0, 0.0, -1.0], [0.0, -1.0, 0.0]);
    // The third normal has no direction; the normal of the face replaces it.
    assert_eq!(engine.normals.unwrap(), [down, back, down, back, down, back]);
}

#[test]
fn faces_of_every_group_and_object_are_kept_in_order() {
    // The crate obj drops the face before `o`, and panics on names between wide spaces.
    let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\ng a\nf 1 2 3\ng\no b\nf 2 3 1\ng\u{2003}name\n\u{3000}o\n\
                usemtl m\nf 3 1 2\ncurv 0 1 2\n";
    assert_eq!(mesh(text).unwrap().triangles, [[0, 1, 2], [1, 2, 0], [2, 0, 1]]);
}

#[test]
fn a_comment_in_another_encoding_does_no_harm() {
    let folder = Folder::new("obj-latin");
    let mut text = b"# caf\xe9\n".to_vec();
    text.extend(SQUARE.as_bytes());
    assert_eq!(load(&folder.write("a.obj", text)).unwrap(), mesh(SQUARE).unwrap());
}

#[test]
fn binary_files_are_refused() {
    let folder = Folder::new("obj-binary");
    let error = load(&folder.write("a.obj", b"PK\x03\x04\0\0v \xff")).unwrap_err();
    assert!(error.to_string().ends_with("is no text, as an OBJ file is"), "{error}");
}

#[test]
fn bad_lines_are_named() {
    let line = |line: usize, text: &str| {
        format!("line {line} is no vertex, texture coordinate, normal or face of numbers: {text}")
    };
    for bad in [
        "v 0 0",
        "v 0 0 x",
        "v",
        "vt 0",
        "vt a b",
        "vn 0 1",
        "vn 0 nan 1",
        "f 1//x 2 3",
        "f a b c",
        "f 0 1 2",
        "f 1 2 /3",
        "f 1/x 2 3",
        "f 1 2 \\",
    ] {
        refused(&format!("{SQUARE}{bad}\n# more"), &line(14, bad));
    }
    let long = format!("f {}", "x".repeat(1000));
    refused(&format!("{SQUARE}\n{long}"), &line(15, &long[..60]));
}

#[test]
fn faces_with_missing_items_are_refused() {
    for bad in
        ["f 1 2 5", "f -5 1 2", &format!("f 1 2 {}", i64::MAX), &format!("f 1 2 {}", i64::MIN)]
    {
        refused(&format!("{SQUARE}{bad}\n"), "face 3 refers to a missing vertex; the file has 4");
    }
    let expected = "face 3 refers to a missing texture coordinate; the file has 2";
    refused(&format!("{SQUARE}f 1/1 2/3 3/1\n"), expected);
    let expected = "face 3 refers to a missing normal; the file has 1";
    refused(&format!("{SQUARE}f 1//1 2//2 3//1\n"), expected);
}

#[test]
fn a_mesh_without_faces_is_refused() {
    for text in ["", "v 0 0 0\nv 1 0 0\nl 1 2\n", "v 0 0 0\nv 1 0 0\nf 1 2\n"] {
        refused(text, "has no face of three corners or more; export a polygon mesh");
    }
    let error = load(Path::new("no such.obj")).unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Read);
}

#[test]
fn spoiled_files_do_not_panic() {
    spoil(SQUARE.as_bytes(), |bytes| {
        if let Ok(parsed) = parse(bytes) {
            parsed.polygons.triangles(&parsed.positions);
        }
    });
}

#[test]
fn a_real_head_is_as_another_reader_sees_it() {
    let Some(file) = shared("ict-facekit/generic_neutral_mesh.obj") else { return };
    let mesh = load(&file).unwrap();
    let options = ufbx::LoadOpts {
        file_format: ufbx::FileFormat::Obj,
        obj_merge_objects: true,
        obj_merge_groups: true,
        ..Default::default()
    };
    let scene = ufbx::load_memory(&std::fs::read(&file).unwrap(), options).unwrap();
    let other = &scene.meshes[0];
    assert_eq!(mesh.positions.len(), other.num_vertices);
    assert_eq!(mesh.triangles.len(), other.num_triangles);
    for (position, v) in mesh.positions.iter().zip(&other.vertices) {
        assert_eq!(*position, [v.x, v.y, v.z]);
    }
    let mut corners = Vec::new();
    for face in &other.faces {
        let corner =
            |corner: u32| other.vertex_indices[(face.index_begin + corner) as usize] as usize;
        corners.extend((2..face.num_indices).map(|last| [0, last - 1, last].map(corner)));
    }
    assert_eq!(mesh.triangles, corners);
}

const NEUTRAL_TEXT: &str =
    "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nf 1/1 2/2 3/3 4/1\n";
const SMILE: &str = "v 0 0 0\nv 1 0 0.5\nv 1 1 0\nv -1 1 0\n";

fn said(folder: &Folder) -> String {
    read_folder(&folder.0).unwrap_err().to_string()
}

#[test]
fn files_beside_the_neutral_one_are_shapes_by_name() {
    let folder = Folder::new("obj-shapes");
    folder.write("neutral.obj", NEUTRAL_TEXT);
    folder.write("smile.obj", SMILE);
    folder.write("blink.obj", NEUTRAL_TEXT);
    folder.write("notes.txt", "no mesh");
    let mesh = read_folder(&folder.0).unwrap();
    let names: Vec<_> = mesh.shapes.iter().map(|shape| shape.name.as_str()).collect();
    assert_eq!(names, ["blink", "smile"]);
    assert_eq!(mesh.shapes[0].deltas, [[0.0; 3]; 4]);
    let expected = [[0.0; 3], [0.0, 0.0, 0.5], [0.0; 3], [-1.0, 0.0, 0.0]];
    assert_eq!(mesh.shapes[1].deltas, expected);
    assert_eq!((mesh.faces, mesh.uv_faces), (vec![vec![0, 1, 2, 3]], vec![vec![0, 1, 2, 0]]));
    assert_eq!(mesh.uv, [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]]);
}

#[test]
fn folders_that_are_not_faces_are_refused() {
    let folder = Folder::new("obj-none");
    assert!(said(&folder).contains("has no neutral.obj"), "{}", said(&folder));
    folder.write("neutral.obj", NEUTRAL_TEXT);
    assert!(said(&folder).contains("has no shape beside neutral.obj"), "{}", said(&folder));
    folder.write("smile.obj", "v 0 0 0\nf 1 1 1\n");
    let error = said(&folder);
    assert!(
        error.ends_with("smile.obj: expected 4 vertices, as neutral.obj has, found 1"),
        "{error}"
    );
    folder.write("smile.obj", "v 0 0\n");
    assert!(said(&folder).contains("smile.obj: line 1 is no vertex"), "{}", said(&folder));
    folder.write("neutral.obj", "v 0 0 0\n");
    assert!(said(&folder).contains("neutral.obj: has no face"), "{}", said(&folder));
}

#[test]
fn a_written_mesh_reads_back_and_takes_other_positions() {
    let positions = [[0.0, 0.5, 0.0], [1.0, 0.0, -2.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    let (uv, faces) = ([[0.0, 0.25], [1.0, 0.0]], vec![vec![0, 1, 2, 3], vec![2, 1, 0]]);
    let uv_faces = vec![vec![0, 1, 1, 0], vec![1, 1, 1]];
    let text = text(&positions, &uv, &faces, &uv_faces);
    assert!(text.ends_with("f 1/1 2/2 3/2 4/1\nf 3/2 2/2 1/2\n"), "{text}");
    let parsed = parse(text.as_bytes()).unwrap();
    assert_eq!((parsed.positions, parsed.texture), (positions.to_vec(), uv.to_vec()));
    assert!(parsed.polygons.iter().eq(faces.iter().map(Vec::as_slice)));
    let other = positions.map(|position| position.map(|x| x + 0.125));
    let moved = with_positions(&text, &other);
    assert_eq!(parse(moved.as_bytes()).unwrap().positions, other);
    assert_eq!(moved.lines().skip(4).collect::<Vec<_>>(), text.lines().skip(4).collect::<Vec<_>>());
}

#[test]
fn faces_without_texture_have_only_vertex_numbers() {
    let text = text(&[[0.0; 3]; 3], &[], &[vec![0, 1, 2]], &[]);
    assert_eq!(text, "v 0 0 0\nv 0 0 0\nv 0 0 0\nf 1 2 3\n");
}
