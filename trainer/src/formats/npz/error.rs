//! What can be wrong with arrays.

/// Arrays, of an archive or alone, that cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum ArrayError {
    /// The archive is truncated or is no npz at all.
    #[error(
        "is no whole .npz archive: its {found} bytes do not end with the archive's directory; write it, or copy it, again"
    )]
    Archive {
        /// Bytes of the file.
        found: u64,
    },
    /// An array is damaged or is no npy data.
    #[error("array {array} is damaged: {reason}; write the file, or copy it, again")]
    Damaged {
        /// The array.
        array: String,
        /// What is wrong.
        reason: String,
    },
    /// A word of a text is not a number.
    #[error("array {array} has {word:?} as number {place}, expected a number")]
    NoNumber {
        /// The array.
        array: String,
        /// Where the word stands, from 0.
        place: usize,
        /// The word.
        word: String,
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
