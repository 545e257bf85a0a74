//! Why a grid could not be made, or not be written.

use crate::formats::GlbError;
use crate::views::fit::FitError;
use crate::views::player::PlayError;

/// A grid that cannot be made, or not be written.
#[derive(Debug, thiserror::Error)]
pub enum GridError {
    /// A side's parameter is none of the map's.
    #[error("\"{name}\" is no parameter: expected {expected}")]
    Unknown {
        /// What was asked for.
        name: String,
        /// The parameters there are.
        expected: String,
    },
    /// A parameter is asked for twice: by two sides, or by a side and by a value.
    #[error("parameter \"{0}\" is given twice")]
    Twice(String),
    /// The file does not tell how far a parameter goes.
    #[error("how far does \"{0}\" go? Say from where to where: {0}=-30..30")]
    Range(String),
    /// A side has no two nodes.
    #[error("parameter \"{0}\": expected 2 nodes or more, and a range that is not empty")]
    Empty(String),
    /// No key view is the map's.
    #[error("no key view is of this map: say a grid")]
    NoKeyView,
    /// Nothing is drawn at any node.
    #[error("nothing is drawn at any node")]
    Nothing,
    /// The model cannot be shown.
    #[error(transparent)]
    Play(#[from] PlayError),
    /// A key view's parameters cannot be found.
    #[error(transparent)]
    Fit(#[from] FitError),
    /// A texture cannot be encoded.
    #[error(transparent)]
    Encode(#[from] png::EncodingError),
    /// The puppet cannot be put together.
    #[error("cannot be put together: {0}")]
    Json(#[from] serde_json::Error),
    /// A section of the puppet would be larger than its format allows.
    #[error("the file takes {0} bytes in one section, and INP holds 4 GiB")]
    TooLarge(usize),
    /// The scene cannot be put together.
    #[error(transparent)]
    Glb(#[from] GlbError),
}
