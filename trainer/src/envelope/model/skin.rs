//! A skin in f64: a mesh, and how it follows a palette.

use nalgebra::{Matrix3x4, Vector3, Vector4};
use sinew_runtime::Skin;
use std::ops::Range;

/// A mesh that follows a palette.
#[derive(Clone, Debug)]
pub struct SkinModel {
    /// Name of the part.
    pub name: String,
    /// Its envelope's number in the [`FileModel`](super::FileModel); `None` for a mesh that follows none.
    pub envelope: Option<usize>,
    /// Rest positions, V.
    pub rest_positions: Vec<[f64; 3]>,
    /// Rest normals, V, of length 1 or 0.
    pub rest_normals: Vec<[f64; 3]>,
    /// Rest tangents of length 1 and, last, handedness, V.
    pub rest_tangents: Option<Vec<[f64; 4]>>,
    /// Influences of each vertex, V: palette index and weight. K is the longest list's length. Empty
    /// without an envelope.
    pub influences: Vec<Vec<(usize, f64)>>,
    /// The meshes that it was made of, by name: ranges of vertices, one after the other.
    pub ranges: Vec<(String, Range<usize>)>,
}

/// A vertex of the rest pose.
pub struct Vertex<'a> {
    /// `[x̂ 1]`.
    pub position: Vector4<f64>,
    /// Unit normal, or 0.
    pub normal: Vector3<f64>,
    /// Unit tangent and handedness.
    pub tangent: Option<(Vector3<f64>, f64)>,
    /// Palette index and weight, K.
    pub influences: &'a [(usize, f64)],
}

impl SkinModel {
    /// Widens what a file holds.
    pub fn from_file(skin: &Skin<'_>) -> Self {
        let vertices = 0..skin.vertex_len();
        let wide = |v: Option<[f32; 3]>| v.unwrap_or([f32::NAN; 3]).map(f64::from);
        let tangents = vertices.clone().filter_map(|v| skin.rest_tangent(v));
        let tangents: Vec<_> = tangents.map(|tangent| tangent.map(f64::from)).collect();
        let influences = |v| skin.influences(v).map(|(l, w)| (l, f64::from(w))).collect();
        Self {
            name: skin.name().to_owned(),
            envelope: skin.envelope_part(),
            rest_positions: vertices.clone().map(|v| wide(skin.rest_position(v))).collect(),
            rest_normals: vertices.clone().map(|v| wide(skin.rest_normal(v))).collect(),
            rest_tangents: (!tangents.is_empty()).then_some(tangents),
            influences: vertices.map(influences).collect(),
            ranges: skin.ranges().map(|(name, range)| (name.to_owned(), range)).collect(),
        }
    }

    /// Gives a vertex.
    ///
    /// # Panics
    /// If `index` is not a vertex.
    pub fn vertex(&self, index: usize) -> Vertex<'_> {
        let tangent = |&[x, y, z, hand]: &[f64; 4]| (Vector3::new(x, y, z), hand);
        Vertex {
            position: Vector3::from(self.rest_positions[index]).push(1.0),
            normal: self.rest_normals[index].into(),
            tangent: self.rest_tangents.as_ref().map(|tangents| tangent(&tangents[index])),
            influences: self.influences.get(index).map_or(&[], Vec::as_slice),
        }
    }

    /// Gives the V vertices.
    pub fn vertices(&self) -> impl Iterator<Item = Vertex<'_>> {
        (0..self.rest_positions.len()).map(|index| self.vertex(index))
    }
}

impl Vertex<'_> {
    /// Blends the vertex's transforms.
    pub fn blend(&self, palette: &[Matrix3x4<f64>]) -> Matrix3x4<f64> {
        self.influences.iter().map(|&(l, weight)| palette[l] * weight).sum()
    }
}
