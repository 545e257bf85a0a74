//! What can be wrong with an OBJ file.

/// An OBJ file that cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum ObjError {
    /// It is no text.
    #[error("is no text, as an OBJ file is")]
    Binary,
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
    /// A folder has no neutral mesh.
    #[error("has no neutral.obj: save the face at rest under that name, and each shape beside it")]
    NoNeutral,
    /// A folder has a neutral mesh alone.
    #[error("has no shape beside neutral.obj: save each as an OBJ of its own")]
    NoShapes,
    /// A shape has other vertices than the neutral mesh.
    #[error("expected {expected} vertices, as neutral.obj has, found {found}")]
    Vertices {
        /// How many the neutral mesh has.
        expected: usize,
        /// How many the shape has.
        found: usize,
    },
}
