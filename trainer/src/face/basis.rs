//! What a face is made of: a neutral mesh and its shapes.

use super::error::FaceError;
use crate::formats::ShapedMesh;
use crate::formats::npz::read_numbers;
use std::collections::HashSet;
use std::ops::Range;
use std::path::Path;

/// A face of V vertices and S shapes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Basis {
    /// The neutral mesh and its shapes.
    pub mesh: ShapedMesh,
    /// What each identity adds to the neutral mesh at 1, V each.
    pub identities: Vec<Vec<[f64; 3]>>,
    /// Vertices at places of the face that are known by sight: corners of the eyes, of the mouth.
    pub landmarks: Vec<usize>,
    /// Its regions by name, one after the other.
    pub regions: Vec<(String, Range<usize>)>,
}

/// Example meshes of N expressions, without shapes.
#[derive(Clone, Debug, PartialEq)]
pub struct ExampleMeshes {
    /// The faces and the vertices' count; positions are those of the first mesh, and there are no shapes.
    pub mesh: ShapedMesh,
    /// Positions, N x V.
    pub positions: Vec<Vec<[f64; 3]>>,
}

impl Basis {
    /// Makes a face of a mesh and its shapes alone.
    pub(super) fn of(mesh: ShapedMesh) -> Self {
        Self { mesh, ..Self::default() }
    }

    /// Counts the vertices, V.
    pub fn vertex_len(&self) -> usize {
        self.mesh.positions.len()
    }

    /// Measures the diagonal of the neutral mesh's box.
    pub fn diagonal(&self) -> f64 {
        diagonal(self.mesh.positions.iter().copied())
    }

    /// Names the shapes.
    pub fn names(&self) -> Vec<String> {
        self.mesh.shapes.iter().map(|shape| shape.name.clone()).collect()
    }

    /// Bakes an identity into the neutral mesh: adds it `by` times.
    ///
    /// # Errors
    /// [`FaceError::Identity`]
    pub fn identify(&mut self, identity: usize, by: f64) -> Result<(), FaceError> {
        let len = self.identities.len();
        let deltas =
            self.identities.get(identity).ok_or(FaceError::Identity { found: identity, len })?;
        for (position, delta) in self.mesh.positions.iter_mut().zip(deltas) {
            *position = [0, 1, 2].map(|axis| position[axis] + by * delta[axis]);
        }
        // What was authored belongs to another face.
        self.mesh.normals = None;
        Ok(())
    }

    /// Reads its landmarks: vertex numbers in a `.npy`, `.txt` or `.csv` file.
    ///
    /// # Errors
    /// Those of the format; [`FaceError::Vertex`]
    pub fn mark(&mut self, path: &Path) -> Result<(), FaceError> {
        let len = self.vertex_len();
        let vertex = |x: f64| match x >= 0.0 && x.fract() == 0.0 && x < len as f64 {
            true => Ok(x as usize),
            false => {
                Err(FaceError::Vertex { place: "a landmark".to_owned(), found: x as i64, len })
            }
        };
        let numbers = read_numbers(path, "landmarks")?;
        self.landmarks = numbers.into_iter().map(vertex).collect::<Result<_, _>>()?;
        Ok(())
    }

    /// Checks it.
    ///
    /// # Errors
    /// [`FaceError::NoShapes`], [`FaceError::Twice`] and [`FaceError::NotFinite`].
    pub(super) fn check(self) -> Result<Self, FaceError> {
        let shapes = &self.mesh.shapes;
        if shapes.is_empty() {
            return Err(FaceError::NoShapes);
        }
        let mut known = HashSet::new();
        if let Some(shape) = shapes.iter().find(|shape| !known.insert(&shape.name)) {
            return Err(FaceError::Twice { name: shape.name.clone() });
        }
        let finite = |all: &[[f64; 3]]| all.as_flattened().iter().all(|x| x.is_finite());
        for (array, sound) in [
            ("neutral", finite(&self.mesh.positions)),
            ("expression_deltas", shapes.iter().all(|shape| finite(&shape.deltas))),
            ("identity_deltas", self.identities.iter().all(|deltas| finite(deltas))),
        ] {
            if !sound {
                return Err(FaceError::NotFinite { array });
            }
        }
        Ok(self)
    }
}

/// Measures the diagonal of the box of some places; 0 of none.
pub(super) fn diagonal(places: impl Iterator<Item = [f64; 3]>) -> f64 {
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for place in places {
        for ((low, high), x) in low.iter_mut().zip(&mut high).zip(place) {
            (*low, *high) = (low.min(x), high.max(x));
        }
    }
    low.iter().zip(high).map(|(low, high)| (high - low).max(0.0).powi(2)).sum::<f64>().sqrt()
}
