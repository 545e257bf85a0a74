//! A face's basis: the neutral mesh, its shapes and identities.

use crate::Error;
use crate::envelope::model::{ShapeNumbers, Shapes, SkinModel};
use crate::formats::ShapedMesh;
use crate::formats::npz::read_numbers;
use crate::mesh::{EngineMesh, Surface, normals};
use std::collections::{HashMap, HashSet};
use std::ops::Range;
use std::path::Path;

/// A face with V vertices and S shapes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Basis {
    /// The neutral mesh and its shapes.
    pub mesh: ShapedMesh,
    /// Deltas of each identity at weight 1, V each.
    pub identities: Vec<Vec<[f64; 3]>>,
    /// Landmark vertices, such as the corners of the eyes and the mouth.
    pub landmarks: Vec<usize>,
    /// Consecutive ranges of vertices with their names.
    pub regions: Vec<(String, Range<usize>)>,
}

/// Example meshes of N expressions, without shapes.
#[derive(Clone, Debug, PartialEq)]
pub struct ExampleMeshes {
    /// Topology of all meshes; positions of the first mesh, no shapes.
    pub mesh: ShapedMesh,
    /// Positions, N x V.
    pub positions: Vec<Vec<[f64; 3]>>,
}

impl Basis {
    /// Creates a basis from a mesh with shapes; no identities, landmarks or regions.
    pub(super) fn of(mesh: ShapedMesh) -> Self {
        Self { mesh, ..Self::default() }
    }

    /// Returns the number of vertices, V.
    pub fn vertex_len(&self) -> usize {
        self.mesh.positions.len()
    }

    /// Returns the diagonal of the neutral mesh's bounding box.
    pub fn diagonal(&self) -> f64 {
        diagonal(self.mesh.positions.iter().copied())
    }

    /// Returns the names of the shapes.
    pub fn names(&self) -> Vec<String> {
        self.mesh.shapes.iter().map(|shape| shape.name.clone()).collect()
    }

    /// Adds an identity to the neutral mesh, at weight `by`.
    ///
    /// # Errors
    /// [`ErrorKind::Missing`](crate::ErrorKind::Missing): the identity does not exist.
    pub fn apply_identity(&mut self, identity: usize, by: f64) -> Result<(), Error> {
        let len = self.identities.len();
        let missing = || {
            Error::missing(format!(
                "there is no identity {identity}: there are {len}, the first is 0"
            ))
        };
        let deltas = self.identities.get(identity).ok_or_else(missing)?;
        for (position, delta) in self.mesh.positions.iter_mut().zip(deltas) {
            *position = [0, 1, 2].map(|axis| position[axis] + by * delta[axis]);
        }
        // The file's normals belong to the mesh without the identity.
        self.mesh.normals = None;
        Ok(())
    }

    /// Reads the landmarks: vertex numbers in a `.npy`, `.txt` or `.csv` file.
    ///
    /// # Errors
    /// The file cannot be read, has another ending, or is damaged; or a number is not a vertex.
    pub fn read_landmarks(&mut self, path: &Path) -> Result<(), Error> {
        let len = self.vertex_len();
        let vertex = |x: f64| match x >= 0.0 && x.fract() == 0.0 && x < len as f64 {
            true => Ok(x as usize),
            false => Err(no_vertex("a landmark", x as i64, len)),
        };
        let numbers = read_numbers(path, "landmarks")?;
        self.landmarks = numbers.into_iter().map(vertex).collect::<Result<_, _>>()?;
        Ok(())
    }

    /// Creates the skin, with normal slopes of the shaped surface. Vertices and shapes keep the file's order.
    pub fn skin(&self, name: &str, numbers: ShapeNumbers) -> SkinModel {
        let mesh = &self.mesh;
        let welded = Welded::new(mesh);
        let surface = welded.surface();
        let rest_normals = match &mesh.normals {
            Some(normals) => normals.clone(),
            None => surface.copied(&normals(&welded.positions, &welded.triangles)),
        };
        let shapes = Shapes {
            names: self.names(),
            deltas: mesh.shapes.iter().map(|shape| shape.deltas.clone()).collect(),
            slopes: Vec::new(),
            numbers,
        };
        let mut skin = SkinModel {
            name: name.to_owned(),
            envelope: None,
            rest_positions: mesh.positions.clone(),
            rest_normals,
            rest_tangents: None,
            influences: Vec::new(),
            tangent_coefficients: None,
            normal_errors: None,
            ranges: self.regions.clone(),
            shapes,
        };
        skin.tilt_shapes(&surface);
        skin
    }

    /// Checks the shapes: at least one, unique names and finite numbers.
    ///
    /// # Errors
    /// There is no shape, two shapes have the same name, or a number is not finite.
    pub(super) fn check(self) -> Result<Self, Error> {
        let shapes = &self.mesh.shapes;
        if shapes.is_empty() {
            let text = "has no shape: a face needs a neutral mesh and at least one";
            return Err(Error::missing(text));
        }
        let mut known = HashSet::new();
        if let Some(shape) = shapes.iter().find(|shape| !known.insert(&shape.name)) {
            return Err(Error::value(format!("two shapes are named {:?}", shape.name)));
        }
        let finite = |all: &[[f64; 3]]| all.as_flattened().iter().all(|x| x.is_finite());
        for (array, sound) in [
            ("neutral", finite(&self.mesh.positions)),
            ("expression_deltas", shapes.iter().all(|shape| finite(&shape.deltas))),
            ("identity_deltas", self.identities.iter().all(|deltas| finite(deltas))),
        ] {
            if !sound {
                return Err(not_finite(array));
            }
        }
        Ok(self)
    }
}

/// Makes the error of an array with a number that is not finite.
pub(super) fn not_finite(array: &str) -> Error {
    Error::value(format!("array {array} holds a number that is not finite"))
}

/// Makes the error of a vertex number out of range.
///
/// - `place`: location of the number.
pub(super) fn no_vertex(place: &str, found: i64, len: usize) -> Error {
    Error::value(format!("{place} names vertex {found} of {len}"))
}

/// A mesh whose coincident vertices with equal deltas are merged. Files for engines split vertices along seams.
struct Welded {
    positions: Vec<[f64; 3]>,
    triangles: Vec<[usize; 3]>,
    engine: Option<EngineMesh>,
}

impl Welded {
    fn new(mesh: &ShapedMesh) -> Self {
        let triangles = mesh.triangles();
        if !mesh.is_split {
            return Self { positions: mesh.positions.clone(), triangles, engine: None };
        }
        let mut known = HashMap::new();
        let mut positions = Vec::new();
        let mut copy_of = Vec::with_capacity(mesh.positions.len());
        for (vertex, position) in mesh.positions.iter().enumerate() {
            let moved = mesh.shapes.iter().flat_map(|shape| shape.deltas[vertex]);
            // Adding 0 turns -0 into +0, so that both have the same bits.
            let key: Vec<u64> =
                position.iter().copied().chain(moved).map(|x| (x + 0.0).to_bits()).collect();
            let place = *known.entry(key).or_insert(positions.len());
            if place == positions.len() {
                positions.push(*position);
            }
            copy_of.push(place);
        }
        let welded =
            triangles.iter().map(|corners| corners.map(|corner| copy_of[corner])).collect();
        let engine = EngineMesh {
            copy_of,
            triangles,
            normals: mesh.normals.clone(),
            tangents: None,
            uv: None,
        };
        Self { positions, triangles: welded, engine: Some(engine) }
    }

    fn surface(&self) -> Surface<'_> {
        let Self { positions, triangles, engine } = self;
        Surface { positions, triangles, engine: engine.as_ref() }
    }
}

/// Returns the diagonal of a bounding box; 0 without places.
pub(super) fn diagonal(places: impl Iterator<Item = [f64; 3]>) -> f64 {
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for place in places {
        for ((low, high), x) in low.iter_mut().zip(&mut high).zip(place) {
            (*low, *high) = (low.min(x), high.max(x));
        }
    }
    low.iter().zip(high).map(|(low, high)| (high - low).max(0.0).powi(2)).sum::<f64>().sqrt()
}
