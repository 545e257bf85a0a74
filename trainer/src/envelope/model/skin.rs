//! A skin in f64: a mesh that follows a palette, and its shapes (METHOD §5).

use crate::mesh::Surface;
use crate::numeric::affine;
use nalgebra::{Matrix3x4, Vector3, Vector4};
use sinew_runtime::Skin;
use sinew_runtime::format::Element;
use sinew_runtime::skin::NormalErrors;
use std::ops::Range;

/// A mesh that follows a palette.
#[derive(Clone, Debug)]
pub struct SkinModel {
    /// Name of the part.
    pub name: String,
    /// Index of its envelope in the [`FileModel`](super::FileModel); `None` for a mesh without an envelope.
    pub envelope: Option<usize>,
    /// Rest positions, V.
    pub rest_positions: Vec<[f64; 3]>,
    /// Rest normals of length 1 or 0, V.
    pub rest_normals: Vec<[f64; 3]>,
    /// Rest tangents of length 1, then handedness, V.
    pub rest_tangents: Option<Vec<[f64; 4]>>,
    /// Influences of each vertex, V: palette index and weight. K is the length of the longest list. Empty without an
    /// envelope.
    pub influences: Vec<Vec<(usize, f64)>>,
    /// Tangent coefficients g, h of each influence of each vertex, V x K, per unit of length. The coefficients of a
    /// vertex sum to 0 (METHOD §1.8). `None` if normals come from cofactors.
    pub tangent_coefficients: Option<Vec<Vec<[f64; 2]>>>,
    /// Measured errors of the normals.
    pub normal_errors: Option<NormalErrors>,
    /// Meshes that were joined to this skin: name and range of vertices, in order.
    pub ranges: Vec<(String, Range<usize>)>,
    /// Shapes of the skin.
    pub shapes: Shapes,
}

/// The S shapes of a skin of V vertices.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Shapes {
    /// Names, S.
    pub names: Vec<String>,
    /// Displacement of each vertex by each shape at a weight of 1, S x V.
    pub deltas: Vec<Vec<[f64; 3]>>,
    /// Slopes of the surface at each vertex by each shape at a weight of 1, S x V, along the two axes of
    /// [`Vertex::tilt_frame`]. [`SkinModel::tilt_shapes`] computes them.
    pub slopes: Vec<Vec<[f64; 2]>>,
    /// Number type of deltas and slopes in a file.
    pub numbers: ShapeNumbers,
}

/// Number type of deltas and slopes in a file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ShapeNumbers {
    /// Single precision.
    #[default]
    F32,
    /// Half precision, times a power of two per shape.
    F16,
    /// Integers from -127 to 127, times a step per shape.
    I8,
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
    /// Tangent coefficients g, h, K; empty if normals come from cofactors.
    pub coefficients: &'a [[f64; 2]],
}

impl SkinModel {
    /// Creates the skin of a surface that follows the first envelope, with cofactor normals.
    ///
    /// - `influences`: of the surface's vertices.
    pub(crate) fn new(name: &str, surface: &Surface<'_>, influences: &[Vec<(usize, f64)>]) -> Self {
        Self {
            name: name.to_owned(),
            envelope: Some(0),
            rest_positions: surface.copied(surface.positions),
            rest_normals: surface.normals(),
            rest_tangents: surface.tangents(),
            influences: surface.copied(influences),
            tangent_coefficients: None,
            normal_errors: None,
            ranges: Vec::new(),
            shapes: Shapes::default(),
        }
    }

    /// Converts a loaded skin to f64.
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

    /// Returns a vertex.
    ///
    /// # Panics
    /// If `index` is not a vertex.
    pub fn vertex(&self, index: usize) -> Vertex<'_> {
        let coefficients = self.tangent_coefficients.as_ref();
        let tangent = |&[x, y, z, hand]: &[f64; 4]| (Vector3::new(x, y, z), hand);
        Vertex {
            position: Vector3::from(self.rest_positions[index]).push(1.0),
            normal: self.rest_normals[index].into(),
            tangent: self.rest_tangents.as_ref().map(|tangents| tangent(&tangents[index])),
            influences: self.influences.get(index).map_or(&[], Vec::as_slice),
            coefficients: coefficients.and_then(|all| all.get(index)).map_or(&[], Vec::as_slice),
        }
    }

    /// Returns the maximum number of influences of a vertex, K.
    pub fn influence_len(&self) -> usize {
        self.influences.iter().map(Vec::len).max().unwrap_or(0)
    }

    /// Adds placeholder tangent coefficients, so that the size of the file is known before the fit.
    pub fn reserve_coefficients(&mut self) {
        let k = self.influence_len();
        let none = || vec![vec![[0.0; 2]; k]; self.influences.len()];
        self.tangent_coefficients = (k > 1).then(none);
    }

    /// Iterates over the V vertices.
    pub fn vertices(&self) -> impl Iterator<Item = Vertex<'_>> {
        (0..self.rest_positions.len()).map(|index| self.vertex(index))
    }
}

/// Converts a vertex's tangent coefficients to f64; the first influence gets minus the sum of the others.
fn coefficients(skin: &Skin<'_>, vertex: usize) -> Vec<[f64; 2]> {
    let mut all: Vec<_> = skin.tangent_coefficients(vertex).map(|c| c.map(f64::from)).collect();
    let sum = |which: usize| all.iter().map(|c| c[which]).sum::<f64>();
    all.insert(0, [-sum(0), -sum(1)]);
    all
}

impl Vertex<'_> {
    /// Returns the tangent frame t, b of the coefficients. t is the rest tangent, or a tangent computed from the
    /// normal; b = n x t.
    pub fn frame(&self) -> [Vector3<f64>; 2] {
        let along = self.tangent.map_or_else(|| affine::tangent(&self.normal), |(t, _)| t);
        [along, self.normal.cross(&along)]
    }

    /// Returns the frame g, h of the slopes: [`Self::frame`], with the rest tangent replaced by its part orthogonal to
    /// the normal.
    pub fn tilt_frame(&self) -> [Vector3<f64>; 2] {
        let [along, across] = self.frame();
        [self.tangent.map_or(along, |_| across.cross(&self.normal)), across]
    }

    /// Blends the transforms of a palette by the vertex's weights.
    pub fn blend(&self, palette: &[Matrix3x4<f64>]) -> Matrix3x4<f64> {
        self.influences.iter().map(|&(l, weight)| palette[l] * weight).sum()
    }
}

impl Shapes {
    /// Converts the shapes of a loaded skin to f64.
    pub fn from_file(skin: &Skin<'_>) -> Self {
        let (shapes, vertices) = (0..skin.shape_len(), 0..skin.vertex_len());
        let delta = |s, v| skin.shape_delta(s, v).unwrap_or([f32::NAN; 3]).map(f64::from);
        let slopes = |s, v| skin.shape_slopes(s, v).unwrap_or([f32::NAN; 2]).map(f64::from);
        let name = |s| skin.shape_name(s).unwrap_or_default().to_owned();
        Self {
            names: shapes.clone().map(name).collect(),
            deltas: shapes
                .clone()
                .map(|s| vertices.clone().map(|v| delta(s, v)).collect())
                .collect(),
            slopes: shapes.map(|s| vertices.clone().map(|v| slopes(s, v)).collect()).collect(),
            numbers: ShapeNumbers::of(skin.shape_element()),
        }
    }

    /// Returns the number of shapes, S.
    pub fn len(&self) -> usize {
        self.names.len()
    }

    /// Returns true if there are no shapes.
    pub fn is_empty(&self) -> bool {
        self.names.is_empty()
    }
}

impl ShapeNumbers {
    /// Returns the element type of a file.
    pub const fn element(self) -> Element {
        match self {
            Self::F32 => Element::F32,
            Self::F16 => Element::F16,
            Self::I8 => Element::I8,
        }
    }

    const fn of(element: Element) -> Self {
        match element {
            Element::I8 => Self::I8,
            Element::F16 => Self::F16,
            _ => Self::F32,
        }
    }
}
