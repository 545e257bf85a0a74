//! Tests of faces and takes as arrays, and of refused arrays.

use super::basis::Basis;
use super::source::{self, Source};
use super::take;
use crate::Error;
use crate::formats::npz::Writer;
use crate::formats::testing::{Folder, shared};
use std::fs::File;
use std::path::PathBuf;

/// Arrays of a small face: three vertices, one face, two shapes.
struct Arrays {
    neutral: Vec<f64>,
    tris: Vec<i64>,
    uv_tris: Vec<i64>,
    deltas: (Vec<u64>, Vec<f64>),
    names: Vec<String>,
    landmarks: Vec<i64>,
}

impl Arrays {
    fn sound() -> Self {
        Self {
            neutral: vec![0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0],
            tris: vec![0, 1, 2],
            uv_tris: vec![1, 0, 1],
            deltas: (vec![2, 3, 3], (0..18).map(f64::from).collect()),
            names: vec!["smile_L".to_owned(), "smile_R".to_owned()],
            landmarks: vec![2],
        }
    }

    fn write(&self, folder: &Folder) -> PathBuf {
        let path = folder.0.join("face.npz");
        let mut file = File::create(&path).unwrap();
        let mut npz = Writer::new(&mut file);
        let rows = (self.neutral.len() / 3) as u64;
        npz.numbers("neutral", &[rows, 3], self.neutral.iter().copied()).unwrap();
        npz.numbers("tris", &[1, 3], self.tris.iter().copied()).unwrap();
        npz.numbers("uv", &[2, 2], [0.0, 0.25, 0.5, 0.75].into_iter()).unwrap();
        npz.numbers("uv_tris", &[1, 3], self.uv_tris.iter().copied()).unwrap();
        npz.numbers("expression_deltas", &self.deltas.0, self.deltas.1.iter().copied()).unwrap();
        npz.texts("expression_names", &self.names).unwrap();
        npz.numbers("landmarks", &[self.landmarks.len() as u64], self.landmarks.iter().copied())
            .unwrap();
        npz.finish().unwrap();
        path
    }

    fn read(&self, test: &str) -> Result<Basis, Error> {
        match source::read(&self.write(&Folder::new(test)))? {
            Source::Shapes(basis) => Ok(basis),
            Source::Meshes(_) => panic!("it has shapes"),
        }
    }
}

#[test]
fn arrays_become_a_face() {
    let basis = Arrays::sound().read("face-sound").unwrap();
    assert_eq!((basis.mesh.faces, basis.mesh.uv_faces), (vec![vec![0, 1, 2]], vec![vec![1, 0, 1]]));
    assert_eq!(basis.mesh.shapes[1].deltas[2], [15.0, 16.0, 17.0]);
    assert_eq!((basis.landmarks, basis.mesh.uv[1]), (vec![2], [0.5, 0.75]));
}

#[test]
fn arrays_that_do_not_fit_are_refused() {
    let refused = |change: fn(&mut Arrays), expected: &str| {
        let mut arrays = Arrays::sound();
        change(&mut arrays);
        let error = arrays.read("face-refused").unwrap_err().to_string();
        assert_eq!(error, expected);
    };
    refused(|a| a.tris[1] = 3, "face 0 of tris names vertex 3 of 3");
    refused(|a| a.tris[1] = -1, "face 0 of tris names vertex -1 of 3");
    refused(|a| a.uv_tris[2] = 2, "face 0 of uv_tris names vertex 2 of 2");
    refused(|a| a.landmarks[0] = 3, "array landmarks names vertex 3 of 3");
    refused(
        |a| a.deltas = (vec![3, 2, 3], a.deltas.1.clone()),
        "array expression_deltas: expected 3 vertices, found 2",
    );
    refused(|a| a.names.truncate(1), "array expression_names: expected 2 names, found 1");
    refused(|a| a.names[1] = "smile_L".to_owned(), "two shapes are named \"smile_L\"");
    refused(|a| a.neutral[4] = f64::NAN, "array neutral holds a number that is not finite");
    refused(
        |a| a.deltas.1[4] = f64::INFINITY,
        "array expression_deltas holds a number that is not finite",
    );
    refused(
        |a| (a.deltas, a.names) = ((vec![0, 3, 3], Vec::new()), Vec::new()),
        "has no shape: a face needs a neutral mesh and at least one",
    );
}

#[test]
fn an_identity_moves_the_neutral_mesh_alone() {
    let mut basis = Arrays::sound().read("face-identity").unwrap();
    basis.identities = vec![vec![[1.0, 0.0, 0.0]; 3], vec![[0.0, 0.0, 2.0]; 3]];
    let shapes = basis.mesh.shapes.clone();
    basis.apply_identity(1, -0.5).unwrap();
    basis.apply_identity(0, 2.0).unwrap();
    assert_eq!(basis.mesh.positions[1], [3.0, 0.0, -1.0]);
    assert_eq!(basis.mesh.shapes, shapes);
    let error = basis.apply_identity(2, 1.0).unwrap_err().to_string();
    assert_eq!(error, "there is no identity 2: there are 2, the first is 0");
}

/// Writes weights as arrays and reads them as a take.
fn weights(
    test: &str,
    width: u64,
    numbers: &[f64],
    names: Option<&[&str]>,
) -> Result<take::Take, Error> {
    let folder = Folder::new(test);
    let path = folder.0.join("take.npz");
    let mut file = File::create(&path).unwrap();
    let mut npz = Writer::new(&mut file);
    let shape = [numbers.len() as u64 / width, width];
    npz.numbers("weights", &shape, numbers.iter().copied()).unwrap();
    if let Some(names) = names {
        let names: Vec<String> = names.iter().map(|name| (*name).to_owned()).collect();
        npz.texts("names", &names).unwrap();
    }
    npz.finish().unwrap();
    take::read(&path, &Arrays::sound().names)
}

#[test]
fn weights_as_arrays_are_a_take() {
    let numbers = [0.1, 0.2, 0.3, 0.4];
    let plain = weights("take-plain", 2, &numbers, None).unwrap();
    assert_eq!(plain.frames, [[0.1, 0.2], [0.3, 0.4]]);
    let named = weights("take-named", 2, &numbers, Some(&["SmileRight", "SmileLeft"])).unwrap();
    assert_eq!(named.frames, [[0.2, 0.1], [0.4, 0.3]]);
    let both = weights("take-both", 2, &numbers, Some(&["Smile", "JawOpen"])).unwrap();
    assert_eq!(
        (both.frames, both.skipped),
        (vec![vec![0.1, 0.1], vec![0.3, 0.3]], vec!["JawOpen".to_owned()])
    );
    let again = weights("take-again", 2, &[0.1, 0.1, 0.3, 0.3], Some(&["smile_R", "SmileRight"]));
    assert_eq!(again.unwrap().frames, [[0.0, 0.1], [0.0, 0.3]]);
    let said = |found: Result<take::Take, Error>| found.unwrap_err().to_string();
    assert_eq!(
        said(weights("take-apart", 2, &[0.1, 0.1, 0.3, 0.4], Some(&["smile_R", "SmileRight"]))),
        "columns \"smile_R\" and \"SmileRight\" both drive shape \"smile_R\", and differ in frame 1: 0.3 \
         and 0.4: remove one of them"
    );
    assert_eq!(plain.largest.map(|largest| largest.place), Some("frame 1".to_owned()));
    assert_eq!(
        said(weights("take-width", 3, &[0.0; 6], None)),
        "array weights: expected 2 columns, found 3"
    );
    assert_eq!(
        said(weights("take-nan", 2, &[0.0, f64::NAN], None)),
        "array weights holds a number that is not finite"
    );
    assert!(said(weights("take-empty", 2, &[], None)).contains("0..0"));
}

#[test]
fn frames_are_picked_within_a_take() {
    let frames = (0..10).map(|k| vec![f64::from(k)]).collect();
    let whole = take::Take { frames, numbers: (0..10).collect(), ..take::Take::default() };
    let picked_of = |take: &take::Take, range, from, every| {
        take.pick(&range, from, every)
            .map(|frames| frames.iter().map(|frame| frame[0]).collect::<Vec<_>>())
    };
    let picked = |range, from, every| picked_of(&whole, range, from, every);
    assert_eq!(picked(2..9, 1, 3).unwrap(), [3.0, 6.0]);
    for (range, from) in [(3..3, 0), (4..11, 0), (2..5, 3)] {
        let error = picked(range.clone(), from, 1).unwrap_err();
        let expected = format!(
            "frames {}..{}: expected a range within 0..10 that is not empty",
            range.start + from,
            range.end
        );
        assert_eq!(error.message(), expected);
    }
    // Frames keep their row numbers if others are lost.
    let mut holed = whole.clone();
    holed.frames.drain(5..7);
    holed.numbers.drain(5..7);
    holed.lost = vec![7, 8];
    assert_eq!(picked_of(&holed, 2..9, 1, 3).unwrap(), [3.0]);
    assert_eq!(picked_of(&holed, 7..10, 0, 1).unwrap(), [7.0, 8.0, 9.0]);
    let error = picked_of(&holed, 5..7, 0, 1).unwrap_err();
    assert!(error.message().starts_with("frames 5..7: expected a range within 0..10"), "{error}");
}

/// The end of the narrow face is from the kit's README; the kit's list has 68 landmarks.
#[test]
fn the_head_of_ict_facekit_is_known() {
    let Some(file) = shared("ict-facekit/ict_head.npz") else { return };
    let Source::Shapes(basis) = source::read(&file).unwrap() else { panic!("it has shapes") };
    assert_eq!((basis.vertex_len(), basis.mesh.shapes.len()), (11_248, 57));
    assert_eq!((basis.mesh.faces.len(), basis.identities.len()), (11_144, 30));
    assert_eq!((basis.landmarks.len(), basis.landmarks[0]), (68, 1225));
    assert_eq!(basis.regions[0], ("narrow_face".to_owned(), 0..6706));
    assert_eq!(basis.regions[2].1, 9409..11_248);
}
