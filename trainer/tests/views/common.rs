//! Objects, cameras and sets of views for the tests.

use super::shared::shared;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use sinew_trainer::views::fit::{FitOptions, FittedMap, fit};
use sinew_trainer::views::set::{Examples, Parameter, Values, View, ViewSet, read};
use std::path::PathBuf;

/// The views of a head, with depths from its mesh.
pub(crate) fn head() -> Option<ViewSet> {
    let (views, mesh) = (shared("ict-views/views.json")?, head_mesh()?);
    Some(read(&views, Some(&mesh)).unwrap())
}

/// The mesh that the head's views are pictures of.
pub(crate) fn head_mesh() -> Option<PathBuf> {
    shared("ict-facekit/generic_neutral_mesh.obj")
}

/// Numbers between -1 and 1, by a seed.
pub(crate) fn random(seed: u64) -> impl FnMut() -> f64 {
    let mut stream = ChaCha8Rng::seed_from_u64(seed);
    move || stream.random_range(-1.0..1.0)
}

/// Points in space: K of them in a cube of side 2.
pub(crate) fn object(seed: u64, len: usize) -> Vec<[f64; 3]> {
    let mut number = random(seed);
    (0..len).map(|_| [number(), number(), number()]).collect()
}

/// Turns a point about y by a yaw and then about x by a pitch, degrees; written out.
pub(crate) fn turned([x, y, z]: [f64; 3], yaw: f64, pitch: f64) -> [f64; 3] {
    let ((s, c), (t, d)) = (yaw.to_radians().sin_cos(), pitch.to_radians().sin_cos());
    let (x, z) = (c * x + s * z, c * z - s * x);
    [x, d * y - t * z, t * y + d * z]
}

/// A view of points at parameters by name.
pub(crate) fn view(values: &[(&str, f64)], points: Vec<[f64; 2]>) -> View {
    View {
        values: values.iter().map(|(name, value)| ((*name).to_owned(), *value)).collect(),
        visible: vec![true; points.len()],
        points: points.into_iter().map(Some).collect(),
        depths: Vec::new(),
        image: None,
        layers: Vec::new(),
    }
}

/// Yaw and pitch as one rotation, in an order that is to be found.
pub(crate) fn yaw_and_pitch() -> Parameter {
    let angles = [Some("pitch".to_owned()), Some("yaw".to_owned()), None];
    Parameter::Rotation { angles, order: None }
}

pub(crate) fn examples(parameters: Vec<Parameter>, train: Vec<View>) -> Examples {
    Examples { name: "main".to_owned(), parameters, train, test: Vec::new() }
}

pub(crate) fn fitted(examples: &Examples) -> FittedMap {
    fit(examples, &[], FitOptions::default()).unwrap()
}

/// Squares of the distances between a map's points and a view's.
pub(crate) fn squares(map: &FittedMap, view: &View) -> Vec<f64> {
    apart(&points(map, &view.values), &view.known())
}

pub(crate) fn points(map: &FittedMap, values: &Values) -> Vec<[f64; 2]> {
    map.shown(values).unwrap().points
}

/// Squares of the distances between points.
pub(crate) fn apart(a: &[[f64; 2]], b: &[[f64; 2]]) -> Vec<f64> {
    assert!(!a.is_empty() && a.len() == b.len());
    let square = |(a, b): (&[f64; 2], &[f64; 2])| (a[0] - b[0]).powi(2) + (a[1] - b[1]).powi(2);
    a.iter().zip(b).map(square).collect()
}

pub(crate) fn rms(squares: &[f64]) -> f64 {
    (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
}

pub(crate) fn most(squares: &[f64]) -> f64 {
    squares.iter().copied().fold(0.0, f64::max).sqrt()
}

/// A folder of its own for one test, removed at its end.
pub(crate) struct Folder(PathBuf);

impl Folder {
    pub(crate) fn new(test: &str) -> Self {
        let path = std::env::temp_dir().join(format!("sinew-views-{}-{test}", std::process::id()));
        std::fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}
