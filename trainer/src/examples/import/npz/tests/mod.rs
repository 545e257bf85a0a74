//! Tests of sets of arrays that load.

use std::collections::BTreeMap;
use std::fs::File;
use std::path::PathBuf;

use npyz::{AutoSerialize, DType, Order, WriteOptions, WriterBuilder};
use serde_json::json;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipArchive, ZipWriter};

use super::*;
use crate::ErrorKind;
use crate::examples::testing::{IDENTITY, triangle};
use crate::formats::npz::Writer;
use crate::formats::testing::{self, Folder};
use crate::mesh::EngineMesh;

mod faults;
mod fields;

/// A valid set of arrays: a quad and a triangle on two joints, four frames.
struct Set {
    reals: BTreeMap<&'static str, (Vec<u64>, Vec<f64>)>,
    wholes: BTreeMap<&'static str, (Vec<u64>, Vec<i64>)>,
    words: BTreeMap<&'static str, Vec<String>>,
    json: String,
}

impl Folder {
    fn npz(&self) -> PathBuf {
        self.0.join("set.npz")
    }

    fn create(&self) -> ZipWriter<File> {
        ZipWriter::new(File::create(self.npz()).unwrap())
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
            words: BTreeMap::new(),
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

    /// Adds an array of numbers with one dimension; a single number has none.
    fn row(mut self, array: &'static str, numbers: &[f64]) -> Self {
        let shape = if numbers.len() == 1 { vec![] } else { vec![numbers.len() as u64] };
        self.reals.insert(array, (shape, numbers.to_vec()));
        self
    }

    /// Adds an array of whole numbers with one dimension.
    fn count(mut self, array: &'static str, numbers: &[i64]) -> Self {
        self.wholes.insert(array, (vec![numbers.len() as u64], numbers.to_vec()));
        self
    }

    fn without(mut self, array: &'static str) -> Self {
        self.reals.remove(array);
        self
    }

    fn words(mut self, array: &'static str, words: &[&str]) -> Self {
        self.words.insert(array, words.iter().map(|&word| word.to_owned()).collect());
        self
    }

    fn json(mut self, json: serde_json::Value) -> Self {
        self.json = json.to_string();
        self
    }

    fn write(&self, folder: &Folder) -> PathBuf {
        let mut file = File::create(folder.npz()).unwrap();
        let mut archive = Writer::new(&mut file);
        for (name, (shape, numbers)) in &self.reals {
            archive.numbers(name, shape, numbers.iter().copied()).unwrap();
        }
        for (name, (shape, numbers)) in &self.wholes {
            archive.numbers(name, shape, numbers.iter().copied()).unwrap();
        }
        for (name, words) in &self.words {
            archive.texts(name, words).unwrap();
        }
        archive.finish().unwrap();
        std::fs::write(folder.npz().with_extension("json"), &self.json).unwrap();
        folder.npz()
    }

    fn load(&self, test: &str) -> Result<Loaded, Error> {
        load(&self.write(&Folder::new(test)))
    }

    fn fault(&self, test: &str) -> Error {
        let error = self.load(test).expect_err("the set should be refused");
        assert!(error.file().is_some_and(|file| file.ends_with("set.npz")), "{error}");
        assert!(!error.message().ends_with('.'), "{error}");
        error
    }
}

/// Adds an array in the numbers' own type, in C order.
fn add<T: AutoSerialize>(
    zip: &mut ZipWriter<File>,
    name: &str,
    shape: &[u64],
    numbers: impl Iterator<Item = T>,
) {
    zip.start_file(format!("{name}.npy"), SimpleFileOptions::DEFAULT).unwrap();
    let mut array =
        WriteOptions::new().default_dtype().shape(shape).writer(zip).begin_nd().unwrap();
    array.extend(numbers).unwrap();
    array.finish().unwrap();
}

#[test]
fn a_good_set_loads_without_a_warning() {
    let Loaded { examples, warnings, .. } = Set::good().load("good").unwrap();
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
fn saved_sets_load_the_same_with_and_without_the_json() {
    let folder = Folder::new("round");
    let mut saved = triangle(3);
    saved.vertices[4] = [0.1, 1.0 / 3.0, -7e-9];
    saved.transforms[3] = [[0.0, -1.0, 0.0, 0.1], [1.0, 0.0, 0.0, 0.2], [0.0, 0.0, 1.0, 0.3]];
    saved.skeleton.rest[1][2][3] = 0.7;
    saved.skeleton.roots = vec![1];
    saved.split = vec![Split::Extreme, Split::Train, Split::HeldOut];
    saved.engine = Some(EngineMesh::of_vertices(&saved.rest, &saved.triangles, &[[0.25, 0.5]; 3]));
    save_npz(&folder.npz(), &saved, &[]).unwrap();
    let first = std::fs::read(folder.npz()).unwrap();
    for _ in 0..2 {
        let loaded = load(&folder.npz()).unwrap();
        assert_eq!(format!("{:?}", loaded.examples), format!("{saved:?}"));
        assert!(matches!(loaded.warnings[..], [Warning::SeveralRoots(_)]));
        let _ = std::fs::remove_file(folder.npz().with_extension("json"));
    }
    save_npz(&folder.npz(), &saved, &[]).unwrap();
    assert_eq!(std::fs::read(folder.npz()).unwrap(), first, "same examples, same bytes");
    assert_eq!(std::fs::read_dir(&folder.0).unwrap().count(), 2, "nothing is left beside");
}

#[test]
fn saving_where_nothing_can_be_written_names_the_file() {
    let error = save_npz(Path::new("no such folder/x.npz"), &triangle(1), &[]).unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Write);
    assert_eq!(error.file(), Some(Path::new("no such folder/x.json")));
}

#[test]
fn numbers_of_any_width_and_order_are_read() {
    let folder = Folder::new("widths");
    let mut zip = folder.create();
    let rest = [0.5f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    zip.start_file("rest.npy", SimpleFileOptions::DEFAULT).unwrap();
    let big_endian = DType::Plain(">f4".parse().unwrap());
    let options = WriteOptions::new().dtype(big_endian).order(Order::Fortran).shape(&[3, 3]);
    let mut numbers = options.writer(&mut zip).begin_nd().unwrap();
    numbers.extend([0, 3, 6, 1, 4, 7, 2, 5, 8].map(|place| rest[place])).unwrap();
    numbers.finish().unwrap();
    add(&mut zip, "vertices", &[1, 3, 3], 1..=9i16);
    add(&mut zip, "tris", &[1, 3], 0..=2u8);
    zip.start_file("bone_transforms.npy", SimpleFileOptions::DEFAULT).unwrap();
    let options = WriteOptions::new().default_dtype().order(Order::Fortran).shape(&[1, 1, 4, 4]);
    let mut numbers = options.writer(&mut zip).begin_nd().unwrap();
    numbers.extend([1.0, 0., 0., 0., 0., 1., 0., 0., 0., 0., 1., 0., 7., 8., 9., 1.]).unwrap();
    numbers.finish().unwrap();
    zip.finish().unwrap();
    let json = json!({"bone_names": ["root"], "bone_parents": [null]}).to_string();
    std::fs::write(folder.npz().with_extension("json"), json).unwrap();
    let examples = load(&folder.npz()).unwrap().examples;
    assert_eq!(examples.rest.as_flattened(), rest.map(f64::from));
    assert_eq!(examples.vertices[2], [7.0, 8.0, 9.0]);
    assert_eq!(examples.pose(0)[0].map(|row| row[3]), [7.0, 8.0, 9.0]);
}

/// Rewrites the archive as `numpy.savez` does: uncompressed, with 64-bit sizes.
fn store(folder: &Folder) {
    let bytes = std::fs::read(folder.npz()).unwrap();
    let mut compressed = ZipArchive::new(std::io::Cursor::new(bytes)).unwrap();
    let options = SimpleFileOptions::DEFAULT.compression_method(CompressionMethod::Stored);
    let mut stored = folder.create();
    for index in 0..compressed.len() {
        let mut file = compressed.by_index(index).unwrap();
        assert_eq!(file.compression(), CompressionMethod::Deflated);
        stored.start_file(file.name().unwrap(), options.large_file(true)).unwrap();
        std::io::copy(&mut file, &mut stored).unwrap();
    }
    stored.finish().unwrap();
}

#[test]
fn uncompressed_sets_load_the_same() {
    let folder = Folder::new("stored");
    let compressed = load(&Set::good().write(&folder)).unwrap();
    store(&folder);
    let stored = load(&folder.npz()).unwrap();
    assert_eq!(format!("{stored:?}"), format!("{compressed:?}"));
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
    let skeleton = &loaded.examples.skeleton;
    assert_eq!((&skeleton.parents[..], &skeleton.roots[..]), (&[None, Some(0)][..], &[1][..]));
    assert_eq!(skeleton.own_parents(), [None, None]);
    let joints = vec!["a".to_owned(), "b".to_owned()];
    assert_eq!(loaded.warnings, [Warning::SeveralRoots(joints)]);
}

#[test]
fn noise_in_held_out_frames_loads() {
    let mut set = Set::good();
    for (place, number) in set.reals.get_mut("vertices").unwrap().1[30..].iter_mut().enumerate() {
        *number = 1e30 * (place as f64).sin();
    }
    assert_eq!(set.load("noise").unwrap().warnings, []);
    let maps = &mut set.reals.get_mut("bone_transforms").unwrap().1;
    for (place, number) in maps[64..].iter_mut().enumerate() {
        *number = 1e30 * (place as f64).sin();
    }
    let loaded = set.load("noise").unwrap();
    assert!(matches!(loaded.warnings[..], [Warning::NonRigidJoint { matrix_len: 2, .. }, _]));
    let fault = loaded.examples.check_poses(&[0, 3]).unwrap_err();
    assert_eq!((fault.kind(), fault.frame()), (ErrorKind::Value, Some(3)), "{fault}");
    assert!(fault.message().starts_with("joint root is "), "{fault}");
    assert!(loaded.examples.check_poses(&[0, 1]).is_ok());
}

/// Creates the valid set with a UV seam along the edge from 1 to 2, between the quad and the triangle.
fn seamed(names: [&'static str; 2]) -> Set {
    let mut set = Set::good();
    let uv =
        [[0.0, 0.0], [0.5, 0.0], [0.5, 1.0], [0.0, 1.0], [0.75, 0.5], [1.0, 0.5], [0.75, 0.25]];
    set.reals.insert("uv", (vec![7, 2], uv.as_flattened().to_vec()));
    set.wholes.insert(names[0], (vec![1, 4], vec![0, 1, 2, 3]));
    set.wholes.insert(names[1], (vec![1, 3], vec![4, 5, 6]));
    set
}

#[test]
fn uv_by_corner_makes_the_engine_s_vertices() {
    for names in [["quads_uv", "tris_uv"], ["uv_quads", "uv_tris"]] {
        let Loaded { examples, warnings, .. } = seamed(names).load("uv-corners").unwrap();
        assert_eq!(warnings, []);
        assert_eq!(examples.triangles, [[0, 1, 2], [0, 2, 3], [1, 4, 2]]);
        let engine = examples.engine.unwrap();
        // Sorted by vertex, then by first use.
        assert_eq!(engine.copy_of, [0, 1, 1, 2, 2, 3, 4]);
        assert_eq!(engine.triangles, [[0, 1, 3], [0, 3, 5], [2, 6, 4]]);
        let uv = engine.uv.unwrap();
        assert_eq!(
            [uv[1], uv[2], uv[4], uv[6]],
            [[0.5, 0.0], [0.75, 0.5], [0.75, 0.25], [1.0, 0.5]]
        );
        assert!(engine.normals.is_none() && engine.tangents.is_some());
    }
}

#[test]
fn seams_are_saved_and_load_the_same() {
    let folder = Folder::new("seams");
    let saved = seamed(["quads_uv", "tris_uv"]).load("seams-first").unwrap().examples;
    save_npz(&folder.npz(), &saved, &[]).unwrap();
    let loaded = load(&folder.npz()).unwrap().examples;
    assert_eq!(loaded.engine, saved.engine);
}

#[test]
fn corners_that_agree_are_the_vertices() {
    let mut set = seamed(["quads_uv", "tris_uv"]);
    set.wholes.insert("tris_uv", (vec![1, 3], vec![1, 4, 2]));
    let engine = set.load("uv-agree").unwrap().examples.engine.unwrap();
    assert!(engine.is_one_each());
    assert_eq!(engine.triangles, [[0, 1, 2], [0, 2, 3], [1, 4, 2]]);
}

/// Loads a set of `../shared/data`, which must exist where CI is set.
fn shared(set: &str) -> Option<Loaded> {
    testing::shared(set).map(|set| load(&set).unwrap())
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
    let Some(Loaded { mut examples, warnings, .. }) = shared("dem-bones/bone.npz") else { return };
    assert_eq!(counts(&examples), [400, 754, 1504, 6, 300, 100, 0]);
    let joints = vec!["joint1".to_owned(), "joint4".to_owned()];
    assert_eq!(warnings, [Warning::SeveralRoots(joints)]);
    let parents = [None, Some(0), Some(0), Some(0), Some(3), Some(3)];
    assert_eq!(examples.skeleton.parents, parents);
    assert_eq!(examples.skeleton.roots, [3]);
    let split = examples.split.clone();
    examples.hold_out(0.25).unwrap();
    assert_eq!(examples.split, split);
}

#[test]
fn mpfb_arm_loads_and_its_origins_can_be_estimated() {
    let Some(Loaded { mut examples, warnings, .. }) = shared("mpfb-arm/mpfb_arm.npz") else {
        return;
    };
    assert_eq!(counts(&examples), [264, 899, 1666, 5, 180, 70, 14]);
    assert_eq!(warnings, []);
    // All are ball joints, except that the elbow is a hinge with pronation; the data contains its origin too.
    let diagonal = examples.diagonal();
    let given = examples.skeleton.rest.clone();
    examples.skeleton.unplaced = (1..5).collect();
    examples.place_joints();
    for joint in 1..5 {
        let [given, found] =
            [&given, &examples.skeleton.rest].map(|rest| rest[joint].map(|row| row[3]));
        // A hinge's origin may slide along its axis, so only the agreement of both maps there counts.
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
    assert!(examples.engine.is_none() && examples.surface().tangents().is_none());
}

#[test]
fn mpfb_body_loads() {
    let Some(Loaded { examples, warnings, .. }) = shared("mpfb-body/mpfb_body.npz") else { return };
    assert_eq!(counts(&examples), [220, 13380, 26756, 53, 160, 60, 0]);
    assert_eq!(warnings, []);
    // One engine vertex per texture coordinate that a corner uses.
    let engine = examples.engine.as_ref().unwrap();
    assert_eq!(engine.copy_of.len(), 14517);
    let normals = examples.surface().normals();
    // Shading is continuous across seams.
    for (copy, &vertex) in engine.copy_of.iter().enumerate().skip(1) {
        let beside = engine.copy_of[copy - 1] == vertex;
        assert!(!beside || normals[copy - 1] == normals[copy]);
    }
    assert!(normals.iter().all(|n| (n.iter().map(|x| x * x).sum::<f64>() - 1.0).abs() < 1e-12));
}
