//! The shapes of a skin in f64: how far each moves the vertices, and how it tilts the surface there (METHOD §5).

use sinew_runtime::Skin;
use sinew_runtime::format::Element;

/// The S shapes of a skin of V vertices.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Shapes {
    /// Names, S.
    pub names: Vec<String>,
    /// How far each moves each vertex at a weight of 1, S x V.
    pub deltas: Vec<Vec<[f64; 3]>>,
    /// How each tilts the surface at each vertex at a weight of 1, S x V: by how much it rises along the two directions
    /// of a vertex's frame; [`TrueNormals`](crate::envelope::normals::TrueNormals) finds them.
    pub slopes: Vec<Vec<[f64; 2]>>,
    /// What a file holds deltas and slopes in.
    pub numbers: ShapeNumbers,
}

/// What a file holds deltas and slopes in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ShapeNumbers {
    /// Single precision.
    #[default]
    F32,
    /// Half precision, times a power of two of each shape's own.
    F16,
    /// Whole numbers from -127 to 127, times a step of each shape's own.
    I8,
}

impl Shapes {
    /// Widens what a file holds.
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

    /// Counts the shapes, S.
    pub fn len(&self) -> usize {
        self.names.len()
    }

    /// Tells whether there are none.
    pub fn is_empty(&self) -> bool {
        self.names.is_empty()
    }
}

impl ShapeNumbers {
    /// Returns the type of a file's elements.
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
