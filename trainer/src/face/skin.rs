//! A face's skin: its neutral mesh and its shapes.

use super::basis::Basis;
use crate::envelope::model::{ShapeNumbers, Shapes, SkinModel};
use crate::formats::ShapedMesh;
use crate::mesh::{EngineMesh, Surface, normals};
use std::collections::HashMap;

impl Basis {
    /// Makes the skin: the vertices in the file's order, the shapes in theirs, with the slopes of the shaped surface.
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
}

/// A mesh whose vertices are one where they stand and move alike: files for engines split them along seams.
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
            // Zero has two signs.
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
