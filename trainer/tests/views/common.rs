//! Objects, cameras and sets of views for the tests.

use models::shared;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use sinew_trainer::views::fit::{FitOptions, FittedMap, fit};
use sinew_trainer::views::set::{Examples, Parameter, Values, View, ViewSet, read};
use std::path::PathBuf;

/// Reads the views of a head, with depths from its mesh.
pub(crate) fn head() -> Option<ViewSet> {
    let (views, mesh) = (shared("ict-views/views.json")?, head_mesh()?);
    Some(read(&views, Some(&mesh)).unwrap())
}

/// Returns the mesh of the head.
pub(crate) fn head_mesh() -> Option<PathBuf> {
    shared("ict-facekit/generic_neutral_mesh.obj")
}

/// Returns a source of random numbers between -1 and 1.
pub(crate) fn random(seed: u64) -> impl FnMut() -> f64 {
    let mut stream = ChaCha8Rng::seed_from_u64(seed);
    move || stream.random_range(-1.0..1.0)
}

/// Returns K random points in a cube of side 2.
pub(crate) fn object(seed: u64, len: usize) -> Vec<[f64; 3]> {
    let mut number = random(seed);
    (0..len).map(|_| [number(), number(), number()]).collect()
}

/// Turns a point about y by a yaw and then about x by a pitch, degrees.
pub(crate) fn turned([x, y, z]: [f64; 3], yaw: f64, pitch: f64) -> [f64; 3] {
    let ((s, c), (t, d)) = (yaw.to_radians().sin_cos(), pitch.to_radians().sin_cos());
    let (x, z) = (c * x + s * z, c * z - s * x);
    [x, d * y - t * z, t * y + d * z]
}

/// Makes a view of points at parameters by name.
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

/// Makes one rotation of yaw and pitch, with an open order.
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

/// Returns the squared distances between a map's points and a view's.
pub(crate) fn squares(map: &FittedMap, view: &View) -> Vec<f64> {
    apart(&points(map, &view.values), &view.known())
}

pub(crate) fn points(map: &FittedMap, values: &Values) -> Vec<[f64; 2]> {
    map.shown(values).unwrap().points
}

/// Returns the squared distances between points.
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

/// Returns twice the signed area of a triangle.
pub(crate) fn cross(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// Returns the convex hull of points, in order.
pub(crate) fn hull(points: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let mut sorted = points.to_vec();
    sorted.sort_by(|a, b| a.partial_cmp(b).unwrap());
    let half = |points: &mut dyn Iterator<Item = &[f64; 2]>| {
        let mut out: Vec<[f64; 2]> = Vec::new();
        for &point in points {
            while out.len() > 1 && cross(out[out.len() - 2], out[out.len() - 1], point) <= 0.0 {
                out.pop();
            }
            out.push(point);
        }
        out.pop();
        out
    };
    [half(&mut sorted.iter()), half(&mut sorted.iter().rev())].concat()
}

/// Whether a convex hull contains a point.
pub(crate) fn is_inside(hull: &[[f64; 2]], point: [f64; 2]) -> bool {
    (0..hull.len()).all(|at| cross(hull[at], hull[(at + 1) % hull.len()], point) >= 0.0)
}

/// A separate folder for one test, removed at its end.
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
