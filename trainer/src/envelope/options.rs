//! What a training is asked for.

use super::levels::Level;
use crate::envelope::s3::{Method, ProxyCount};
use crate::settings::Settings;
use sinew_runtime::envelope::Predictor;

/// What predicts the palette from the pose.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Predict {
    /// This predictor.
    Only(Predictor),
    /// The rotational predictor as S3 publishes it, to the letter ([`published`]).
    ///
    /// [`published`]: crate::envelope::s3::published
    Published,
}

/// What a training is asked for.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// What predicts.
    pub predictor: Predict,
    /// P, or the error that decides it; chosen by cross-validation where none is given.
    pub proxies: Option<ProxyCount>,
    /// K, the most maps of the palette that a vertex follows.
    pub influences: usize,
    /// Whether c1 and c2 may be refined on the training meshes; as published they never are.
    pub refine: bool,
    /// Most bytes of the file, all of its skins included.
    pub budget: Option<usize>,
    /// The meshes that the file holds.
    pub meshes: FileSkins,
    /// The numbers that the fit of helpers is set to.
    pub settings: Settings,
}

/// The meshes that a model's file holds.
#[derive(Clone, Debug, PartialEq)]
pub enum FileSkins {
    /// The examples' own, then further ones, each as a skin.
    Skins(Vec<Level>),
    /// None: a palette alone, for an engine that keeps its meshes and their weights.
    PaletteAlone,
}

impl Options {
    /// How a reconstruction is to be fitted.
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
            influences: 4,
            refine: true,
            budget: None,
            meshes: FileSkins::Skins(Vec::new()),
            settings: Settings::default(),
        }
    }
}
