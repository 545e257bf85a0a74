//! What can be wrong with an OBJ file.

/// An OBJ file that cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum ObjError {
    /// A line cannot be read.
    #[error("line {line} is no vertex, texture coordinate, normal or face of numbers: {text}")]
    Line {
        /// The line, the first being 1.
        line: usize,
        /// Its beginning.
        text: String,
    },
    /// A face names something that is not there.
    #[error("face {face} names a {what} that is none of the {len} there are")]
    Corner {
        /// The face, the first being 1.
        face: usize,
        /// What it names.
        what: &'static str,
        /// How many there are.
        len: usize,
    },
    /// There is no face to build triangles of.
    #[error("has no face of three corners or more; export a polygon mesh")]
    NoFaces,
}
