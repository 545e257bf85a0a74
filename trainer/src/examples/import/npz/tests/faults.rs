//! Tests of refused sets: each error names the problem and its location.

use super::*;
use crate::examples::{Distortion, Element};
use crate::formats::{ArrayError, FormatError};

/// Extracts the error of an array.
#[track_caller]
fn array_fault(fault: ExamplesError) -> ArrayError {
    match fault {
        ExamplesError::Format(FormatError::Array(fault)) => fault,
        other => panic!("{other}"),
    }
}

#[test]
fn not_finite_names_array_frame_and_vertex_or_joint() {
    use ExamplesError::NotFinite;
    for bad in [f64::NAN, f64::INFINITY] {
        let fault = Set::good().real("vertices", 2 * 15 + 3 * 4 + 1, bad).fault("nan-posed");
        assert!(matches!(
            fault,
            NotFinite { array: "vertices", frame: Some(2), element: Element::Vertex(4) }
        ));
        assert_eq!(fault.to_string(), "array vertices is not finite at frame 2, vertex 4");
        let fault = Set::good().real("rest", 3, bad).fault("nan-rest");
        assert!(matches!(
            fault,
            NotFinite { array: "rest", frame: None, element: Element::Vertex(1) }
        ));
        let fault = Set::good().real("bone_transforms", 3 * 32 + 16 + 7, bad).fault("nan-joint");
        assert_eq!(fault.to_string(), "array bone_transforms is not finite at frame 3, joint tip");
        let mut set = Set::good();
        set.reals.insert("uv", (vec![5, 2], vec![bad; 10]));
        assert!(matches!(set.fault("nan-uv"), NotFinite { array: "uv", .. }));
    }
}

#[test]
fn too_large_numbers_name_array_frame_and_vertex_or_joint() {
    let fault = Set::good().real("rest", 4, 1e30).fault("large-rest");
    assert!(matches!(fault, ExamplesError::TooLarge { array: "rest", frame: None, .. }), "{fault}");
    let fault = Set::good().real("vertices", 15 + 7, -1e10).fault("large-vertex");
    let ExamplesError::TooLarge { frame: Some(1), element: Element::Vertex(2), .. } = fault else {
        panic!("{fault}")
    };
    let fault = Set::good().real("bone_transforms", 32 + 16 + 3, 1e300).fault("large-joint");
    assert!(fault.to_string().contains("joint tip"), "{fault}");
}

#[test]
fn counts_that_disagree_name_both_arrays() {
    let shortened = |array: &'static str, shape: &[u64], test| {
        let mut set = Set::good();
        let len = shape.iter().product::<u64>() as usize;
        if let Some((kept, numbers)) = set.reals.get_mut(array) {
            numbers.truncate(len);
            *kept = shape.to_vec();
        } else if let Some((kept, numbers)) = set.wholes.get_mut(array) {
            numbers.truncate(len);
            *kept = shape.to_vec();
        }
        set.fault(test).to_string()
    };
    let found = shortened("bone_transforms", &[3, 2, 4, 4], "fewer-maps");
    assert_eq!(found, "vertices has 4 frames, bone_transforms has 3");
    let found = shortened("bone_transforms", &[4, 1, 4, 4], "fewer-joints");
    assert_eq!(found, "bone_names has 2 joints, bone_transforms has 1");
    let found = shortened("vertices", &[4, 4, 3], "fewer-vertices");
    assert_eq!(found, "rest has 5 vertices, vertices has 4");
    let found = shortened("split", &[3], "fewer-splits");
    assert_eq!(found, "vertices has 4 frames, split has 3");
    let json = json!({"bone_names": ["root", "tip"], "bone_parents": [-1]});
    let found = Set::good().json(json).fault("fewer-parents").to_string();
    assert_eq!(found, "bone_names has 2 joints, bone_parents has 1");
    let mut set = Set::good();
    set.reals.insert("joint_world_rest", (vec![1, 4, 4], vec![0.0; 16]));
    let found = set.fault("fewer-frames").to_string();
    assert_eq!(found, "bone_names has 2 joints, joint_world_rest has 1");
}

#[test]
fn joints_in_a_cycle_are_named() {
    let json = json!({"bone_names": ["a", "b"], "bone_parents": [1, 0]});
    let fault = Set::good().json(json).fault("cycle");
    assert_eq!(fault.to_string(), "joints are their own ancestors: a -> b -> a");
    let json = json!({"bone_names": ["a", "b"], "bone_parents": [-1, 1]});
    let fault = Set::good().json(json).fault("self");
    assert_eq!(fault.to_string(), "joints are their own ancestors: b -> b");
}

#[test]
fn missing_parents_and_duplicate_names_are_named() {
    for (parent, text) in [(json!(7), "7"), (json!(-2), "-2"), (json!("hip"), "hip")] {
        let json = json!({"bone_names": ["root", "tip"], "bone_parents": [-1, parent]});
        let fault = Set::good().json(json).fault("parent");
        let expected = format!("joint tip has parent {text}, which does not exist");
        assert_eq!(fault.to_string(), expected);
    }
    let json = json!({"bone_names": ["a", "a"], "bone_parents": [-1, 0]});
    let fault = Set::good().json(json).fault("double");
    assert!(matches!(fault, ExamplesError::DuplicateJoint { first: 0, second: 1, .. }));
    let json = json!({"bone_names": ["a", "b"], "bone_parents": [-1, 0],
        "joint_rest_positions": {"c": [0, 0, 0]}});
    let fault = Set::good().json(json).fault("unknown");
    assert!(matches!(fault, ExamplesError::UnknownJoint { name } if name == "c"));
}

#[test]
fn missing_arrays_are_named() {
    for array in ["rest", "vertices", "bone_transforms"] {
        let mut set = Set::good();
        set.reals.remove(array);
        let found = set.fault("missing").to_string();
        assert_eq!(found, format!("array {array} is missing"));
    }
    let mut set = Set::good();
    set.wholes.clear();
    assert_eq!(set.fault("faces").to_string(), "array quads or tris is missing");
    for array in ["bone_names", "bone_parents"] {
        let names = json!({"bone_names": ["root", "tip"]});
        let json = if array == "bone_names" { json!({}) } else { names };
        let found = Set::good().json(json).fault("described").to_string();
        assert_eq!(found, format!("array {array} is missing"));
    }
}

#[test]
fn other_types_and_shapes_are_refused() {
    let mut set = Set::good();
    set.reals.insert("split", (vec![4], vec![0.0; 4]));
    set.wholes.remove("split");
    let found = set.fault("type").to_string();
    assert_eq!(found, "array split must hold whole numbers, found dtype '<f8'");
    for (shape, test) in [(vec![3, 5], "columns"), (vec![15], "rank")] {
        let mut set = Set::good();
        set.reals.get_mut("rest").unwrap().0 = shape.clone();
        let fault = set.fault(test);
        let ArrayError::WrongShape { found, .. } = array_fault(fault) else { panic!("{test}") };
        assert_eq!(found, shape);
    }
    let mut set = Set::good();
    set.reals.get_mut("vertices").unwrap().0 = vec![20, 3];
    let found = set.fault("flat").to_string();
    assert_eq!(found, "array vertices must have shape [n, n, 3], found [20, 3]");
}

#[test]
fn empty_sets_and_sets_that_never_train_are_refused() {
    let mut set = Set::good();
    set.reals.insert("vertices", (vec![0, 5, 3], vec![]));
    set.reals.insert("bone_transforms", (vec![0, 2, 4, 4], vec![]));
    set.wholes.insert("split", (vec![0], vec![]));
    assert!(matches!(set.fault("empty"), ExamplesError::Empty { array: "vertices" }));
    let set = Set::good().whole("split", 0, 1).whole("split", 1, 2);
    let frame_len = set.wholes["split"].1.len();
    let fault = set.fault("untrained");
    assert!(matches!(fault, ExamplesError::NothingTrains { frame_len: len } if len == frame_len));
}

#[test]
fn unknown_split_codes_name_the_frame() {
    let found = Set::good().whole("split", 3, 9).fault("split").to_string();
    assert_eq!(found, "array split has code 9 at frame 3, expected 0, 1 or 2");
}

#[test]
fn faces_out_of_range_name_face_and_vertex() {
    for bad in [5, -1, i64::MAX] {
        let found = Set::good().whole("tris", 1, bad).fault("range").to_string();
        assert_eq!(found, format!("tris 0 names vertex {bad} of 5"));
    }
    let found = Set::good().whole("quads", 3, 5).fault("range-quads").to_string();
    assert_eq!(found, "quads 0 names vertex 5 of 5");
}

#[test]
fn triangles_without_area_are_listed_unless_all_are() {
    let loaded = Set::good().whole("quads", 3, 2).load("repeated").unwrap();
    assert_eq!(loaded.warnings, [Warning::RepeatedVertex { triangles: vec![1] }]);
    let loaded = Set::good().real("rest", 9, 2.0).real("rest", 10, 2.0).load("flat").unwrap();
    assert_eq!(loaded.warnings, [Warning::ZeroArea { triangles: vec![1] }]);
    assert_eq!(
        loaded.warnings[0].to_string(),
        "triangles without area at rest are left out of the fit: 1"
    );
    assert_eq!(loaded.examples.degenerate_triangles(), [1]);
    let mut set = Set::good();
    set.reals.insert("rest", (vec![5, 3], vec![1.0; 15]));
    assert!(matches!(set.fault("all-flat"), ExamplesError::NoArea { triangle_len: 3 }));
}

#[test]
fn maps_that_are_not_rigid_are_refused_and_near_ones_reported() {
    let tip_in_frame_1 = 32 + 16;
    // Scale, shear, reflection, singular matrix, and a last row other than 0 0 0 1.
    for (place, number) in [(0, 1.5), (1, 0.05), (0, -1.0), (5, 0.0), (12, 0.1), (15, 2.0)] {
        let fault =
            Set::good().real("bone_transforms", tip_in_frame_1 + place, number).fault("rigid");
        let ExamplesError::NonRigidJoint { frame: Some(1), joint, distortion } = &fault else {
            panic!("{fault}")
        };
        let is_it = match (place, number) {
            (12 | 15, _) => *distortion == Distortion::Projects,
            (_, -1.0) => *distortion == Distortion::Mirrors,
            _ => matches!(distortion, Distortion::Stretches(_)),
        };
        assert!(joint == "tip" && is_it, "{fault}");
    }
    let loaded = Set::good().real("bone_transforms", tip_in_frame_1, 1.001).load("near").unwrap();
    let [Warning::NonRigidJoint { joint, matrix_len: 1, worst_frame: Some(1), deviation, .. }] =
        &loaded.warnings[..]
    else {
        panic!("{:?}", loaded.warnings)
    };
    assert!(joint == "tip" && (deviation - 1e-3).abs() < 1e-12);
    let loaded =
        Set::good().real("bone_transforms", tip_in_frame_1, 1.00005).load("rigid").unwrap();
    assert_eq!(loaded.warnings, []);
}

#[test]
fn damaged_files_are_refused_and_named() {
    let folder = Folder::new("damaged");
    let path = Set::good().write(&folder);
    let whole = std::fs::read(&path).unwrap();
    for len in [0, 10, whole.len() / 2, whole.len() - 1] {
        std::fs::write(&path, &whole[..len]).unwrap();
        let fault = load(&path).unwrap_err().error;
        assert!(matches!(array_fault(fault), ArrayError::Archive { .. }), "{len}");
    }
    // Damages the compressed data of one array.
    let mut broken = whole.clone();
    broken[70..100].fill(0x55);
    std::fs::write(&path, &broken).unwrap();
    let fault = load(&path).unwrap_err().error;
    assert!(matches!(array_fault(fault), ArrayError::Damaged { .. }));

    std::fs::write(&path, &whole).unwrap();
    let json = path.with_extension("json");
    std::fs::write(&json, "{\"bone_names\": [").unwrap();
    let error = load(&path).unwrap_err();
    assert!(error.file == json && matches!(error.error, ExamplesError::Json { .. }), "{error}");

    std::fs::remove_file(&path).unwrap();
    std::fs::remove_file(&json).unwrap();
    let fault = load(&path).unwrap_err().error;
    assert!(matches!(fault, ExamplesError::Format(FormatError::Read(_))), "{fault}");
}

#[test]
fn a_number_that_fails_its_checksum_is_refused() {
    let folder = Folder::new("checksum");
    let path = Set::good().write(&folder);
    store(&folder);
    let mut zip = ZipArchive::new(File::open(&path).unwrap()).unwrap();
    let file = zip.by_name("rest.npy").unwrap();
    let last = (file.data_start().unwrap() + file.size() - 1) as usize;
    drop(file);
    let mut broken = std::fs::read(&path).unwrap();
    assert_eq!(broken[last], 0, "of the last coordinate, 0.0");
    broken[last] = 0x3f;
    std::fs::write(&path, &broken).unwrap();
    let fault = load(&path).unwrap_err().error;
    let ArrayError::Damaged { array, .. } = array_fault(fault) else { panic!("no damage") };
    assert_eq!(array, "rest");
}

#[test]
fn a_shape_beyond_the_bytes_is_refused() {
    let folder = Folder::new("huge");
    let mut zip = folder.create();
    zip.start_file("rest.npy", SimpleFileOptions::DEFAULT).unwrap();
    let options = WriteOptions::<f64>::new().default_dtype().shape(&[1 << 40, 3]);
    options.writer(&mut zip).write_header_only().unwrap();
    zip.finish().unwrap();
    let fault = load(&folder.npz()).unwrap_err().error;
    assert!(fault.to_string().contains("asks for more than its 128 bytes"), "{fault}");
}

#[test]
fn texture_coordinates_that_fit_no_corner_name_the_array() {
    let with = |array: &'static str, shape: &[u64], numbers: &[i64]| {
        let mut set = seamed(["quads_uv", "tris_uv"]);
        set.wholes.insert(array, (shape.to_vec(), numbers.to_vec()));
        set.fault("uv-fault").to_string()
    };
    let two = [0, 1, 2, 3, 0, 1, 2, 3];
    assert_eq!(with("quads_uv", &[2, 4], &two), "quads has 1 faces, quads_uv has 2");
    assert_eq!(with("tris_uv", &[0, 3], &[]), "tris has 1 faces, tris_uv has 0");
    assert_eq!(with("tris_uv", &[1, 3], &[4, 7, 5]), "tris_uv 0 names vertex 7 of 7");
    assert_eq!(with("quads_uv", &[1, 4], &[0, -1, 2, 3]), "quads_uv 0 names vertex -1 of 7");
    let fault = with("quads_uv", &[1, 3], &[0, 1, 2]);
    assert!(fault.contains("quads_uv"), "{fault}");
    let mut set = seamed(["quads_uv", "tris_uv"]);
    set.wholes.remove("quads_uv");
    assert_eq!(set.fault("uv-half").to_string(), "quads has 1 faces, quads_uv has 0");
    set.wholes.remove("tris_uv");
    assert_eq!(set.fault("uv-none").to_string(), "rest has 5 vertices, uv has 7");
}
