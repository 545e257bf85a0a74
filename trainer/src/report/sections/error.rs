//! Why a page could not be made.

use crate::evaluate::EvaluateError;
use png::EncodingError;

/// A page that could not be made.
#[derive(Debug, thiserror::Error)]
pub enum ReportError {
    /// A frame could not be skinned.
    #[error(transparent)]
    Evaluate(#[from] EvaluateError),
    /// A picture could not be encoded.
    #[error("cannot encode a picture: {0}")]
    Picture(#[from] EncodingError),
}
