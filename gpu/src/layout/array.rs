//! Where an array lies in a buffer of the host's.

/// Where an array with one stretch of words an instance lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Array {
    /// The first instance's first word.
    pub offset: usize,
    /// Words from an instance to the next.
    pub stride: usize,
}
