//! A skin in f64: a mesh, and how it follows a palette.

use super::shapes::Shapes;
use crate::numeric::affine;
use nalgebra::{Matrix3x4, Vector3, Vector4};
use sinew_runtime::Skin;
use sinew_runtime::skin::NormalErrors;
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
    /// Tangent coefficients g, h of each influence of each vertex, V x K, per unit of length; those of a
    /// vertex sum to 0 (METHOD §1.8). Normals go by cofactors without.
    pub tangent_coefficients: Option<Vec<Vec<[f64; 2]>>>,
    /// How far the normals were measured to be from the true ones.
    pub normal_errors: Option<NormalErrors>,
    /// The meshes that it was made of, by name: ranges of vertices, one after the other.
    pub ranges: Vec<(String, Range<usize>)>,
    /// Its shapes.
    pub shapes: Shapes,
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
    /// Tangent coefficients g, h, K; empty where normals go by cofactors.
    pub coefficients: &'a [[f64; 2]],
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
            influences: match skin.envelope_part() {
                Some(_) => vertices.clone().map(influences).collect(),
                None => Vec::new(),
            },
            tangent_coefficients: skin
                .has_coefficients()
                .then(|| vertices.map(|v| coefficients(skin, v)).collect()),
            normal_errors: skin.normal_errors(),
            ranges: skin.ranges().map(|(name, range)| (name.to_owned(), range)).collect(),
            shapes: Shapes::from_file(skin),
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
            coefficients: self.coefficients().get(index).map_or(&[], Vec::as_slice),
        }
    }

    /// Counts the influences of a vertex, K.
    pub fn influence_len(&self) -> usize {
        self.influences.iter().map(Vec::len).max().unwrap_or(0)
    }

    /// Makes room for the tangent coefficients that a fit gives it.
    pub fn reserve_coefficients(&mut self) {
        let k = self.influence_len();
        let none = || vec![vec![[0.0; 2]; k]; self.influences.len()];
        self.tangent_coefficients = (k > 1).then(none);
    }

    fn coefficients(&self) -> &[Vec<[f64; 2]>] {
        self.tangent_coefficients.as_deref().unwrap_or_default()
    }

    /// Gives the V vertices.
    pub fn vertices(&self) -> impl Iterator<Item = Vertex<'_>> {
        (0..self.rest_positions.len()).map(|index| self.vertex(index))
    }
}

/// Widens a vertex's tangent coefficients; those of the last influence are minus the others' sums.
fn coefficients(skin: &Skin<'_>, vertex: usize) -> Vec<[f64; 2]> {
    let mut all: Vec<_> = skin.tangent_coefficients(vertex).map(|c| c.map(f64::from)).collect();
    let sum = |which: usize| all.iter().map(|c| c[which]).sum::<f64>();
    let last = [-sum(0), -sum(1)];
    all.push(last);
    all
}

impl Vertex<'_> {
    /// Gives the tangent frame t, b that its coefficients are along: t is the rest tangent, or else one
    /// that the normal gives, and b = n x t.
    pub fn frame(&self) -> [Vector3<f64>; 2] {
        let along = self.tangent.map_or_else(|| affine::tangent(&self.normal), |(t, _)| t);
        [along, self.normal.cross(&along)]
    }

    /// Gives the frame g, h that slopes are along: that of the rest tangent made square to the normal, as far as it is
    /// not, or else of the normal alone.
    pub fn tilt_frame(&self) -> [Vector3<f64>; 2] {
        let [along, across] = self.frame();
        [self.tangent.map_or(along, |_| across.cross(&self.normal)), across]
    }

    /// Blends the vertex's transforms.
    pub fn blend(&self, palette: &[Matrix3x4<f64>]) -> Matrix3x4<f64> {
        self.influences.iter().map(|&(l, weight)| palette[l] * weight).sum()
    }
}
