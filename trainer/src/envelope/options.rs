//! Options of a training.

use super::levels::Level;
use crate::envelope::s3::{Method, ProxyCount};
use crate::settings::Settings;
use sinew_runtime::envelope::{HelperKind, Predictor};

/// Predictor of the palette from the pose.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Predict {
    /// The given predictor. The rotational predictor improves on S3.
    Only(Predictor),
    /// The rotational predictor exactly as S3 publishes it ([`published`]).
    ///
    /// [`published`]: crate::envelope::s3::published
    Published,
}

/// Options of a training.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// Predictor of the palette.
    pub predictor: Predict,
    /// Number of proxies P, or the error that decides P. `None` chooses P by cross-validation.
    pub proxies: Option<ProxyCount>,
    /// Transforms that the helpers may have; affine for the rotational predictor.
    pub helper_kind: HelperKind,
    /// K, the largest number of palette transforms that a vertex follows.
    pub influences: usize,
    /// Whether c1 and c2 may be refined on the training meshes. The published method never refines them.
    pub refine: bool,
    /// Largest size of the file with all its skins, in bytes.
    pub budget: Option<usize>,
    /// The meshes that the file holds.
    pub meshes: FileSkins,
    /// Settings of the fit of helpers.
    pub settings: Settings,
}

/// The meshes that a model's file holds.
#[derive(Clone, Debug, PartialEq)]
pub enum FileSkins {
    /// The mesh of the examples and further meshes, each as a skin.
    Skins(Vec<Level>),
    /// No mesh, only a palette, for an engine that keeps its meshes and weights.
    PaletteAlone,
}

impl Options {
    /// Returns the method of fitting the reconstruction.
    pub(super) fn method(&self) -> Method {
        match (self.predictor, self.refine) {
            (Predict::Published, _) => Method::Published,
            (_, false) => Method::Unrefined,
            (_, true) => Method::Refined,
        }
    }
}

impl Default for Options {
    fn default() -> Self {
        Self {
            predictor: Predict::Only(Predictor::Kernel),
            proxies: None,
            helper_kind: HelperKind::Affine,
            influences: 4,
            refine: true,
            budget: None,
            meshes: FileSkins::Skins(Vec::new()),
            settings: Settings::default(),
        }
    }
}
