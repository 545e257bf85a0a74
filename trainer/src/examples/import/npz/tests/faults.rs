//! Tests of refused sets: each error names the problem and its location.

use super::*;

/// Returns the frame and the message of an error.
fn told(fault: &Error) -> (Option<i64>, &str) {
    (fault.frame(), fault.message())
}

#[test]
fn not_finite_names_array_frame_and_vertex_or_joint() {
    for bad in [f64::NAN, f64::INFINITY] {
        let fault = Set::good().real("vertices", 2 * 15 + 3 * 4 + 1, bad).fault("nan-posed");
        assert_eq!(fault.kind(), ErrorKind::Value);
        assert_eq!(told(&fault), (Some(2), "array vertices is not finite at vertex 4"));
        assert!(
            fault
                .to_string()
                .ends_with("set.npz: frame 2: array vertices is not finite at vertex 4")
        );
        let fault = Set::good().real("rest", 3, bad).fault("nan-rest");
        assert_eq!(told(&fault), (None, "array rest is not finite at vertex 1"));
        let fault = Set::good().real("bone_transforms", 3 * 32 + 16 + 7, bad).fault("nan-joint");
        assert_eq!(told(&fault), (Some(3), "array bone_transforms is not finite at joint tip"));
        let mut set = Set::good();
        set.reals.insert("uv", (vec![5, 2], vec![bad; 10]));
        assert_eq!(told(&set.fault("nan-uv")), (None, "array uv is not finite at vertex 0"));
    }
}

#[test]
fn too_large_numbers_name_array_frame_and_vertex_or_joint() {
    let fault = Set::good().real("rest", 4, 1e30).fault("large-rest");
    let most = "exceeds 1e9, the most a model can hold,";
    assert_eq!(told(&fault), (None, format!("array rest {most} at vertex 1").as_str()));
    let fault = Set::good().real("vertices", 15 + 7, -1e10).fault("large-vertex");
    assert_eq!(told(&fault), (Some(1), format!("array vertices {most} at vertex 2").as_str()));
    let fault = Set::good().real("bone_transforms", 32 + 16 + 3, 1e300).fault("large-joint");
    let expected = format!("array bone_transforms {most} at joint tip");
    assert_eq!(told(&fault), (Some(1), expected.as_str()));
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
        set.fault(test).message().to_owned()
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
    let fault = Set::good().json(json).fault("fewer-parents");
    assert_eq!(fault.message(), "bone_names has 2 joints, bone_parents has 1");
    let mut set = Set::good();
    set.reals.insert("joint_world_rest", (vec![1, 4, 4], vec![0.0; 16]));
    let fault = set.fault("fewer-frames");
    assert_eq!(fault.message(), "bone_names has 2 joints, joint_world_rest has 1");
}

#[test]
fn joints_in_a_cycle_are_named() {
    let json = json!({"bone_names": ["a", "b"], "bone_parents": [1, 0]});
    let fault = Set::good().json(json).fault("cycle");
    assert_eq!(fault.message(), "joints are their own ancestors: a -> b -> a");
    let json = json!({"bone_names": ["a", "b"], "bone_parents": [-1, 1]});
    let fault = Set::good().json(json).fault("self");
    assert_eq!(fault.message(), "joints are their own ancestors: b -> b");
}

#[test]
fn missing_parents_and_duplicate_names_are_named() {
    for (parent, text) in [(json!(7), "7"), (json!(-2), "-2"), (json!("hip"), "hip")] {
        let json = json!({"bone_names": ["root", "tip"], "bone_parents": [-1, parent]});
        let fault = Set::good().json(json).fault("parent");
        let expected = format!("joint tip has parent {text}, which does not exist");
        assert_eq!(fault.message(), expected);
    }
    let json = json!({"bone_names": ["a", "a"], "bone_parents": [-1, 0]});
    let fault = Set::good().json(json).fault("double");
    assert_eq!(fault.message(), "joints 0 and 1 are both called a");
    let json = json!({"bone_names": ["a", "b"], "bone_parents": [-1, 0],
        "joint_rest_positions": {"c": [0, 0, 0]}});
    let fault = Set::good().json(json).fault("unknown");
    assert_eq!(fault.message(), "joint_rest_positions names joint c, which does not exist");
}

#[test]
fn missing_arrays_are_named() {
    for array in ["rest", "vertices", "bone_transforms"] {
        let mut set = Set::good();
        set.reals.remove(array);
        let fault = set.fault("missing");
        assert_eq!(fault.message(), format!("array {array} is missing"));
    }
    let mut set = Set::good();
    set.wholes.clear();
    assert_eq!(set.fault("faces").message(), "array quads or tris is missing");
    for array in ["bone_names", "bone_parents"] {
        let names = json!({"bone_names": ["root", "tip"]});
        let json = if array == "bone_names" { json!({}) } else { names };
        let fault = Set::good().json(json).fault("described");
        assert_eq!(fault.message(), format!("array {array} is missing"));
    }
}

#[test]
fn other_types_and_shapes_are_refused() {
    let mut set = Set::good();
    set.reals.insert("split", (vec![4], vec![0.0; 4]));
    set.wholes.remove("split");
    let fault = set.fault("type");
    assert_eq!(fault.message(), "array split must hold whole numbers, found dtype '<f8'");
    for (shape, test) in [(vec![3, 5], "columns"), (vec![15], "rank")] {
        let mut set = Set::good();
        set.reals.get_mut("rest").unwrap().0 = shape.clone();
        let fault = set.fault(test);
        let expected = format!("array rest must have shape [n, 3], found {shape:?}");
        assert_eq!(fault.message(), expected);
    }
    let mut set = Set::good();
    set.reals.get_mut("vertices").unwrap().0 = vec![20, 3];
    let fault = set.fault("flat");
    assert_eq!(fault.message(), "array vertices must have shape [n, n, 3], found [20, 3]");
}

#[test]
fn empty_sets_and_sets_that_never_train_are_refused() {
    let mut set = Set::good();
    set.reals.insert("vertices", (vec![0, 5, 3], vec![]));
    set.reals.insert("bone_transforms", (vec![0, 2, 4, 4], vec![]));
    set.wholes.insert("split", (vec![0], vec![]));
    assert_eq!(set.fault("empty").message(), "array vertices is empty");
    let set = Set::good().whole("split", 0, 1).whole("split", 1, 2);
    let frame_len = set.wholes["split"].1.len();
    let fault = set.fault("untrained");
    let words = format!("every frame of {frame_len} is held out or extreme: none is left to train");
    assert_eq!((fault.kind(), fault.message()), (ErrorKind::Missing, words.as_str()));
}

#[test]
fn unknown_split_codes_name_the_frame() {
    let fault = Set::good().whole("split", 3, 9).fault("split");
    assert_eq!(told(&fault), (Some(3), "array split has code 9, expected 0, 1 or 2"));
}

#[test]
fn faces_out_of_range_name_face_and_vertex() {
    for bad in [5, -1, i64::MAX] {
        let fault = Set::good().whole("tris", 1, bad).fault("range");
        assert_eq!(fault.message(), format!("tris 0 names vertex {bad} of 5"));
    }
    let fault = Set::good().whole("quads", 3, 5).fault("range-quads");
    assert_eq!(fault.message(), "quads 0 names vertex 5 of 5");
}

#[test]
fn triangles_without_area_are_listed_unless_all_are() {
    let loaded = Set::good().whole("quads", 3, 2).load("repeated").unwrap();
    assert_eq!(loaded.warnings, [Warning::RepeatedVertex(vec![1])]);
    let loaded = Set::good().real("rest", 9, 2.0).real("rest", 10, 2.0).load("flat").unwrap();
    assert_eq!(loaded.warnings, [Warning::ZeroArea(vec![1])]);
    assert_eq!(
        loaded.warnings[0].to_string(),
        "triangles without area at rest are left out of the fit: 1"
    );
    assert_eq!(loaded.examples.degenerate_triangles(), [1]);
    let mut set = Set::good();
    set.reals.insert("rest", (vec![5, 3], vec![1.0; 15]));
    assert_eq!(set.fault("all-flat").message(), "none of the 3 rest triangles has an area");
}

#[test]
fn mirrored_and_flat_maps_are_refused_and_stretched_ones_taken() {
    let tip_in_frame_1 = 32 + 16;
    // Reflection, singular matrix, and a last row other than 0 0 0 1.
    for (place, number) in [(0, -1.0), (5, 0.0), (12, 0.1), (15, 2.0)] {
        let fault =
            Set::good().real("bone_transforms", tip_in_frame_1 + place, number).fault("rigid");
        let words = match (place, number) {
            (12 | 15, _) => "joint tip has a matrix whose last row is not 0 0 0 1: ",
            (_, -1.0) => "joint tip is mirrored: ",
            _ => "joint tip is scaled to 0: ",
        };
        assert!(fault.frame() == Some(1) && fault.message().starts_with(words), "{fault}");
    }
    // Scale and shear.
    for (place, number) in [(0, 1.5), (1, 0.05)] {
        let set = Set::good().real("bone_transforms", tip_in_frame_1 + place, number);
        let loaded = set.load("stretched").unwrap();
        assert_eq!(loaded.examples.stretching_joints(), [false, true]);
        assert_eq!(loaded.warnings, []);
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
        let fault = load(&path).unwrap_err();
        assert_eq!(fault.kind(), ErrorKind::Damaged, "{len}");
        let words = format!("is no whole .npz archive: its {len} bytes ");
        assert!(fault.message().starts_with(&words), "{fault}");
    }
    // Damages the compressed data of one array.
    let mut broken = whole.clone();
    broken[70..100].fill(0x55);
    std::fs::write(&path, &broken).unwrap();
    let fault = load(&path).unwrap_err();
    assert_eq!(fault.kind(), ErrorKind::Damaged);
    assert!(fault.message().starts_with("array "), "{fault}");

    std::fs::write(&path, &whole).unwrap();
    let json = path.with_extension("json");
    std::fs::write(&json, "{\"bone_names\": [").unwrap();
    let error = load(&path).unwrap_err();
    assert_eq!((error.kind(), error.file()), (ErrorKind::Damaged, Some(json.as_path())));
    assert!(error.message().starts_with("is not a description of examples: EOF "), "{error}");

    std::fs::remove_file(&path).unwrap();
    std::fs::remove_file(&json).unwrap();
    let fault = load(&path).unwrap_err();
    assert_eq!((fault.kind(), fault.file()), (ErrorKind::Read, Some(path.as_path())));
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
    let fault = load(&path).unwrap_err();
    assert!(fault.message().starts_with("array rest is damaged: "), "{fault}");
}

#[test]
fn a_shape_beyond_the_bytes_is_refused() {
    let folder = Folder::new("huge");
    let mut zip = folder.create();
    zip.start_file("rest.npy", SimpleFileOptions::DEFAULT).unwrap();
    let options = WriteOptions::<f64>::new().default_dtype().shape(&[1 << 40, 3]);
    options.writer(&mut zip).write_header_only().unwrap();
    zip.finish().unwrap();
    let fault = load(&folder.npz()).unwrap_err();
    assert!(fault.message().contains("asks for more than its 128 bytes"), "{fault}");
}

#[test]
fn texture_coordinates_that_fit_no_corner_name_the_array() {
    let with = |array: &'static str, shape: &[u64], numbers: &[i64]| {
        let mut set = seamed(["quads_uv", "tris_uv"]);
        set.wholes.insert(array, (shape.to_vec(), numbers.to_vec()));
        set.fault("uv-fault").message().to_owned()
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
    assert_eq!(set.fault("uv-half").message(), "quads has 1 faces, quads_uv has 0");
    set.wholes.remove("tris_uv");
    assert_eq!(set.fault("uv-none").message(), "rest has 5 vertices, uv has 7");
}
