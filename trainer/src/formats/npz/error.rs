//! What can be wrong with arrays.

/// Arrays, of an archive or alone, that cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum ArrayError {
    /// The archive is truncated or is no npz at all.
    #[error(
        "is not a whole npz archive: cut short or damaged ({reason}); write it, or copy it, again"
    )]
    Archive {
        /// What the archive's reader says.
        reason: String,
    },
    /// An array is damaged or is no npy data.
    #[error("array {array} is damaged: {reason}")]
    Damaged {
        /// The array.
        array: String,
        /// What the array's reader says.
        reason: String,
    },
    /// An array that is needed is absent.
    #[error("array {array} is missing")]
    Missing {
        /// The array, or the arrays of which one must be present.
        array: &'static str,
    },
    /// An array holds another kind of number.
    #[error("array {array} must hold {expected}, found dtype {found}")]
    WrongType {
        /// The array.
        array: String,
        /// The kind of number expected.
        expected: &'static str,
        /// The dtype found.
        found: String,
    },
    /// An array has another shape.
    #[error("array {array} must have shape {expected}, found {found:?}")]
    WrongShape {
        /// The array.
        array: String,
        /// The shape expected; letters stand for any count.
        expected: String,
        /// The shape found.
        found: Vec<u64>,
    },
}
