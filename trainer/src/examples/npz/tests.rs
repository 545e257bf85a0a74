use std::collections::BTreeMap;
use std::path::PathBuf;

use npyz::WriterBuilder;
use npyz::npz::NpzWriter;
use serde_json::json;

use super::super::Element;
use super::super::testing::{IDENTITY, triangle};
use super::*;

/// A good set, as the arrays of its file: a quad and a triangle on two joints, four frames.
struct Set {
    reals: BTreeMap<&'static str, (Vec<u64>, Vec<f64>)>,
    wholes: BTreeMap<&'static str, (Vec<u64>, Vec<i64>)>,
    json: String,
}

/// A folder of its own for one test, removed at its end.
struct Folder(PathBuf);

impl Folder {
    fn new(test: &str) -> Self {
        let path = std::env::temp_dir().join(format!("sinew-npz-{}-{test}", std::process::id()));
        std::fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    fn npz(&self) -> PathBuf {
        self.0.join("set.npz")
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

impl Set {
    fn good() -> Self {
        let rest =
            [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0], [2.0, 0.5, 0.0]];
        let identity = [1.0, 0., 0., 0., 0., 1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1.];
        Self {
            reals: BTreeMap::from([
                ("rest", (vec![5, 3], rest.as_flattened().to_vec())),
                ("vertices", (vec![4, 5, 3], rest.repeat(4).as_flattened().to_vec())),
                ("bone_transforms", (vec![4, 2, 4, 4], identity.repeat(8))),
            ]),
            wholes: BTreeMap::from([
                ("quads", (vec![1, 4], vec![0, 1, 2, 3])),
                ("tris", (vec![1, 3], vec![1, 4, 2])),
                ("split", (vec![4], vec![0, 0, 1, 2])),
            ]),
            json: json!({"bone_names": ["root", "tip"], "bone_parents": [-1, 0]}).to_string(),
        }
    }

    fn real(mut self, array: &'static str, place: usize, number: f64) -> Self {
        self.reals.get_mut(array).unwrap().1[place] = number;
        self
    }

    fn whole(mut self, array: &'static str, place: usize, number: i64) -> Self {
        self.wholes.get_mut(array).unwrap().1[place] = number;
        self
    }

    fn json(mut self, json: serde_json::Value) -> Self {
        self.json = json.to_string();
        self
    }

    fn write(&self, folder: &Folder) -> PathBuf {
        let mut npz = NpzWriter::create(folder.npz()).unwrap();
        for (name, (shape, numbers)) in &self.reals {
            let array = npz.array::<f64>(name, Default::default()).unwrap();
            let mut array = array.default_dtype().shape(shape).begin_nd().unwrap();
            array.extend(numbers.iter().copied()).unwrap();
            array.finish().unwrap();
        }
        for (name, (shape, numbers)) in &self.wholes {
            let array = npz.array::<i64>(name, Default::default()).unwrap();
            let mut array = array.default_dtype().shape(shape).begin_nd().unwrap();
            array.extend(numbers.iter().copied()).unwrap();
            array.finish().unwrap();
        }
        npz.zip_writer().finish().unwrap();
        drop(npz);
        std::fs::write(folder.npz().with_extension("json"), &self.json).unwrap();
        folder.npz()
    }

    fn load(&self, test: &str) -> Result<Loaded, LoadError> {
        load(&self.write(&Folder::new(test)))
    }

    fn fault(&self, test: &str) -> ExamplesError {
        let error = self.load(test).expect_err("the set should be refused");
        assert!(error.file.ends_with("set.npz"), "{error}");
        let text = error.error.to_string();
        assert!(!text.ends_with('.'), "{text}");
        error.error
    }
}

#[test]
fn a_good_set_loads_without_a_warning() {
    let Loaded { examples, warnings } = Set::good().load("good").unwrap();
    assert_eq!(warnings, []);
    assert_eq!(examples.triangles, [[0, 1, 2], [0, 2, 3], [1, 4, 2]]);
    assert_eq!(examples.split, [Split::Train, Split::Train, Split::HeldOut, Split::Extreme]);
    assert_eq!(examples.skeleton.parents, [None, Some(0)]);
    assert_eq!((examples.vertex_len(), examples.frame_len(), examples.joint_len()), (5, 4, 2));
    assert_eq!(examples.diagonal(), 5f64.sqrt());
    assert_eq!(examples.frame(1), examples.rest);
    assert_eq!(examples.pose(3), [IDENTITY; 2]);
}

#[test]
fn without_a_split_every_frame_trains() {
    let mut set = Set::good();
    set.wholes.remove("split");
    assert_eq!(set.load("no-split").unwrap().examples.frames_of(Split::Train).len(), 4);
}

#[test]
fn what_is_saved_loads_the_same_with_and_without_the_json() {
    let folder = Folder::new("round");
    let mut saved = triangle(3);
    saved.vertices[4] = [0.1, 1.0 / 3.0, -7e-9];
    saved.transforms[3] = [[0.0, -1.0, 0.0, 0.1], [1.0, 0.0, 0.0, 0.2], [0.0, 0.0, 1.0, 0.3]];
    saved.skeleton.rest[1][2][3] = 0.7;
    saved.split = vec![Split::Extreme, Split::Train, Split::HeldOut];
    saved.uv = Some(vec![[0.25, 0.5]; 3]);
    save_npz(&folder.npz(), &saved).unwrap();
    let first = std::fs::read(folder.npz()).unwrap();
    for _ in 0..2 {
        let loaded = load(&folder.npz()).unwrap();
        assert_eq!(format!("{:?}", loaded.examples), format!("{saved:?}"));
        assert_eq!(loaded.warnings, []);
        let _ = std::fs::remove_file(folder.npz().with_extension("json"));
    }
    save_npz(&folder.npz(), &saved).unwrap();
    assert_eq!(std::fs::read(folder.npz()).unwrap(), first, "same examples, same bytes");
    assert_eq!(std::fs::read_dir(&folder.0).unwrap().count(), 2, "nothing is left beside");
}

#[test]
fn saving_where_nothing_can_be_written_names_the_file() {
    let error = save_npz(Path::new("no such folder/x.npz"), &triangle(1)).unwrap_err();
    assert!(matches!(error.error, ExamplesError::Io(_)) && error.file.ends_with("x.json"));
}

#[test]
fn numbers_of_any_width_and_order_are_read() {
    let folder = Folder::new("widths");
    let mut npz = NpzWriter::create(folder.npz()).unwrap();
    let rest = [0.5f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    let array = npz.array::<f32>("rest", Default::default()).unwrap();
    let array = array.dtype(npyz::DType::Plain(">f4".parse().unwrap())).order(npyz::Order::Fortran);
    let mut array = array.shape(&[3, 3]).begin_nd().unwrap();
    array.extend([0, 3, 6, 1, 4, 7, 2, 5, 8].map(|place| rest[place])).unwrap();
    array.finish().unwrap();
    let array = npz.array::<i16>("vertices", Default::default()).unwrap();
    let mut array = array.default_dtype().shape(&[1, 3, 3]).begin_nd().unwrap();
    array.extend([1, 2, 3, 4, 5, 6, 7, 8, 9]).unwrap();
    array.finish().unwrap();
    let array = npz.array::<u8>("tris", Default::default()).unwrap();
    let mut array = array.default_dtype().shape(&[1, 3]).begin_nd().unwrap();
    array.extend([0, 1, 2]).unwrap();
    array.finish().unwrap();
    let array = npz.array::<f64>("bone_transforms", Default::default()).unwrap();
    let array = array.default_dtype().order(npyz::Order::Fortran).shape(&[1, 1, 4, 4]);
    let mut array = array.begin_nd().unwrap();
    array.extend([1.0, 0., 0., 0., 0., 1., 0., 0., 0., 0., 1., 0., 7., 8., 9., 1.]).unwrap();
    array.finish().unwrap();
    npz.zip_writer().finish().unwrap();
    drop(npz);
    let json = json!({"bone_names": ["root"], "bone_parents": [null]}).to_string();
    std::fs::write(folder.npz().with_extension("json"), json).unwrap();
    let examples = load(&folder.npz()).unwrap().examples;
    assert_eq!(examples.rest.as_flattened(), rest.map(f64::from));
    assert_eq!(examples.vertices[2], [7.0, 8.0, 9.0]);
    assert_eq!(examples.pose(0)[0].map(|row| row[3]), [7.0, 8.0, 9.0]);
}

#[test]
fn parents_may_be_names_and_positions_may_be_described() {
    let json = json!({"bone_names": ["tip", "root"], "bone_parents": ["root", null],
        "joint_rest_positions": {"tip": [1, 2, 3]}, "units": "anything"});
    let examples = Set::good().json(json).load("names").unwrap().examples;
    assert_eq!(examples.skeleton.parents, [Some(1), None]);
    assert_eq!(examples.skeleton.rest[0].map(|row| row[3]), [1.0, 2.0, 3.0]);
    assert_eq!(examples.skeleton.rest[1].map(|row| row[3]), [0.8, 0.5, 0.0], "the centroid");
}

#[test]
fn further_roots_become_children_of_the_first() {
    let json = json!({"bone_names": ["a", "b"], "bone_parents": [-1, -1]});
    let loaded = Set::good().json(json).load("roots").unwrap();
    assert_eq!(loaded.examples.skeleton.parents, [None, Some(0)]);
    let joints = vec!["a".to_owned(), "b".to_owned()];
    assert_eq!(loaded.warnings, [Warning::SeveralRoots { joints }]);
}

#[test]
fn noise_in_held_out_frames_loads() {
    let mut set = Set::good();
    for (place, number) in set.reals.get_mut("vertices").unwrap().1[30..].iter_mut().enumerate() {
        *number = 1e30 * (place as f64).sin();
    }
    assert_eq!(set.load("noise").unwrap().warnings, []);
}

#[test]
fn uv_per_corner_is_ignored_and_said() {
    let mut set = Set::good();
    set.reals.insert("uv", (vec![7, 2], vec![0.0; 14]));
    let loaded = set.load("uv").unwrap();
    assert!(loaded.examples.uv.is_none());
    assert_eq!(loaded.warnings, [Warning::UvIgnored { uv_len: 7, vertex_len: 5 }]);
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
fn missing_parents_and_doubled_names_are_named() {
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
        assert!(matches!(fault, ExamplesError::WrongShape { found, .. } if found == shape));
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
    assert!(matches!(set.fault("untrained"), ExamplesError::TooFewPoses { found: 0, needed: 1 }));
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
    assert_eq!(loaded.warnings[0].to_string(), "1 rest triangles have no area: 1");
    assert_eq!(loaded.examples.degenerate_triangles(), [1]);
    let mut set = Set::good();
    set.reals.insert("rest", (vec![5, 3], vec![1.0; 15]));
    assert!(matches!(set.fault("all-flat"), ExamplesError::NoArea { triangle_len: 3 }));
}

#[test]
fn maps_that_are_not_rigid_are_refused_and_near_ones_reported() {
    let tip_in_frame_1 = 32 + 16;
    // Scale, shear, reflection, collapse, and a last row that is not 0 0 0 1.
    for (place, number) in [(0, 1.5), (1, 0.05), (0, -1.0), (5, 0.0), (12, 0.1), (15, 2.0)] {
        let fault =
            Set::good().real("bone_transforms", tip_in_frame_1 + place, number).fault("rigid");
        let ExamplesError::NonRigidJoint { frame: Some(1), joint, deviation, .. } = &fault else {
            panic!("{fault}")
        };
        assert!(joint == "tip" && *deviation > 1e-2, "{fault}");
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
        assert!(matches!(fault, ExamplesError::Archive { .. }), "{len}: {fault}");
    }
    // Bytes of the data of one array, whose checksum then disagrees.
    let mut broken = whole.clone();
    broken[60..90].fill(0x55);
    std::fs::write(&path, &broken).unwrap();
    let fault = load(&path).unwrap_err().error;
    assert!(matches!(fault, ExamplesError::DamagedArray { .. }), "{fault}");

    std::fs::write(&path, &whole).unwrap();
    let json = path.with_extension("json");
    std::fs::write(&json, "{\"bone_names\": [").unwrap();
    let error = load(&path).unwrap_err();
    assert!(error.file == json && matches!(error.error, ExamplesError::Json { .. }), "{error}");

    std::fs::remove_file(&path).unwrap();
    std::fs::remove_file(&json).unwrap();
    assert!(matches!(load(&path).unwrap_err().error, ExamplesError::Io(_)));
}

#[test]
fn a_shape_beyond_the_bytes_is_refused() {
    let folder = Folder::new("huge");
    let mut npz = NpzWriter::create(folder.npz()).unwrap();
    let array = npz.array::<f64>("rest", Default::default()).unwrap();
    array.default_dtype().shape(&[1 << 40, 3]).write_header_only().unwrap();
    npz.zip_writer().finish().unwrap();
    drop(npz);
    let fault = load(&folder.npz()).unwrap_err().error;
    assert!(matches!(fault, ExamplesError::DamagedArray { .. }), "{fault}");
}

/// Loads a set of `../shared/data`, which must be there where CI is set.
fn shared(set: &str) -> Option<Loaded> {
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data");
    if !data.is_dir() {
        assert!(std::env::var_os("CI").is_none(), "CI is set, but there is no {}", data.display());
        eprintln!("not run: there is no {}", data.display());
        return None;
    }
    Some(load(&data.join(set)).unwrap())
}

fn counts(examples: &Examples) -> [usize; 7] {
    [
        examples.frame_len(),
        examples.vertex_len(),
        examples.triangles.len(),
        examples.joint_len(),
        examples.frames_of(Split::Train).len(),
        examples.frames_of(Split::HeldOut).len(),
        examples.frames_of(Split::Extreme).len(),
    ]
}

#[test]
fn dem_bones_loads() {
    let Some(Loaded { mut examples, warnings }) = shared("dem-bones/bone.npz") else { return };
    assert_eq!(counts(&examples), [400, 754, 1504, 6, 300, 100, 0]);
    let joints = vec!["joint1".to_owned(), "joint4".to_owned()];
    assert_eq!(warnings, [Warning::SeveralRoots { joints }]);
    let parents = [None, Some(0), Some(0), Some(0), Some(3), Some(3)];
    assert_eq!(examples.skeleton.parents, parents);
    let split = examples.split.clone();
    examples.hold_out(0.25).unwrap();
    assert_eq!(examples.split, split);
}

#[test]
fn mpfb_arm_loads_and_its_origins_can_be_found_again() {
    let Some(Loaded { mut examples, warnings }) = shared("mpfb-arm/mpfb_arm.npz") else { return };
    assert_eq!(counts(&examples), [264, 899, 1666, 5, 180, 70, 14]);
    assert_eq!(warnings, []);
    // Ball joints: the elbow is a hinge with pronation, whose origin the data gives as well.
    let diagonal = examples.diagonal();
    for joint in 1..5 {
        let given = examples.skeleton.rest[joint].map(|row| row[3]);
        let found = origins::rest_origin(&examples, joint);
        // A hinge's origin may slide along its axis: what counts is that both maps agree there.
        let mut worst: f64 = 0.0;
        for frame in examples.frames_of(Split::Train) {
            let pose = examples.pose(frame);
            let parent = examples.skeleton.parents[joint].unwrap();
            for row in 0..3 {
                let at = |map: &Matrix3x4| {
                    map[row][3] + (0..3).map(|axis| map[row][axis] * found[axis]).sum::<f64>()
                };
                worst = worst.max((at(&pose[joint]) - at(&pose[parent])).abs());
            }
        }
        assert!(
            worst < 1e-5 * diagonal,
            "joint {joint}: {worst}, given {given:?}, found {found:?}"
        );
    }
    examples.uv = None;
    assert!(examples.rest_tangents().is_none());
}

#[test]
fn mpfb_body_loads() {
    let Some(Loaded { examples, warnings }) = shared("mpfb-body/mpfb_body.npz") else { return };
    assert_eq!(counts(&examples), [220, 13380, 26756, 53, 160, 60, 0]);
    assert_eq!(warnings, [Warning::UvIgnored { uv_len: 14517, vertex_len: 13380 }]);
    assert!(examples.uv.is_none());
    let normals = examples.rest_normals();
    assert!(normals.iter().all(|n| (n.iter().map(|x| x * x).sum::<f64>() - 1.0).abs() < 1e-12));
}
