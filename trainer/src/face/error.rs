//! What can be wrong with a face, a take or a track.

use crate::bake::BakeError;
use crate::formats::{CsvError, FileError, FormatError, GlbError};
use sinew_runtime::CallError;
use std::fmt::Display;
use std::path::PathBuf;

/// How many items of a list are told; the others are counted.
const LISTED: usize = 5;

/// A face, a take or a track that cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum FaceError {
    /// The file cannot be read, or is no such file.
    #[error(transparent)]
    Format(#[from] FormatError),
    /// A file of a folder cannot be read.
    #[error(transparent)]
    File(#[from] FileError),
    /// The face has no shape.
    #[error("has no shape: a face needs a neutral mesh and at least one")]
    NoShapes,
    /// Two shapes have one name.
    #[error("two shapes are named {name:?}")]
    Twice {
        /// The name.
        name: String,
    },
    /// Two arrays do not fit each other.
    #[error("array {array}: expected {expected} {what}, found {found}")]
    Count {
        /// The array.
        array: &'static str,
        /// What is counted.
        what: &'static str,
        /// How many there must be.
        expected: usize,
        /// How many there are.
        found: usize,
    },
    /// Something names a vertex that is not there.
    #[error("{place} names vertex {found} of {len}")]
    Vertex {
        /// Where.
        place: String,
        /// The number found.
        found: i64,
        /// How many there are.
        len: usize,
    },
    /// A number of the face is not finite.
    #[error("array {array} holds a number that is not finite")]
    NotFinite {
        /// The array.
        array: &'static str,
    },
    /// An identity is asked for that is not there.
    #[error("there is no identity {found}: there are {len}, the first is 0")]
    Identity {
        /// The number asked for.
        found: usize,
        /// How many there are.
        len: usize,
    },
    /// Columns of a take are neither shapes of the face nor known to have none.
    #[error("unknown {}: name each column after a shape of the face, or remove the column", listed(.unknown.iter()))]
    Names {
        /// Each, with those that are most like it.
        unknown: Vec<Unknown>,
    },
    /// A take drives no shape.
    #[error("no column drives a shape of the face; its shapes are {}", listed(.known.iter()))]
    NoColumns {
        /// The shapes.
        known: Vec<String>,
    },
    /// Columns of a take drive one shape and differ.
    #[error(
        "columns {:?} and {:?} both drive shape {shape:?}, and differ in {place}: {} and {}: remove one of {}",
        .columns[0], .columns[1], .found[0], .found[1],
        if *.pairs > 1 { format!("each of {} such pairs", .pairs) } else { "them".to_owned() }
    )]
    Contradiction {
        /// The shape.
        shape: String,
        /// Names of the columns.
        columns: [String; 2],
        /// The first line of a table, or frame of an array, where they differ.
        place: String,
        /// The weights there.
        found: [f64; 2],
        /// Pairs of columns that differ.
        pairs: usize,
    },
    /// The tracking is lost in every row of a take.
    #[error("has no frame: the tracking is lost in all {len} rows")]
    Lost {
        /// Rows.
        len: usize,
    },
    /// A range of frames or vertices is empty or reaches beyond what is there.
    #[error("{what} {first}..{end}: expected a range within 0..{len} that is not empty")]
    Range {
        /// What is counted.
        what: &'static str,
        /// The first.
        first: usize,
        /// The end.
        end: usize,
        /// How many there are.
        len: usize,
    },
    /// A file holds no face.
    #[error("has no face: no prior over the shapes of a skin; `sinew face train` makes one")]
    NoFace,
    /// A face has not as many landmarks as handles are asked for.
    #[error("{found} handles: expected 1 to {len}, as many as the face has landmarks")]
    Handles {
        /// Handles asked for.
        found: usize,
        /// Landmarks.
        len: usize,
    },
    /// Meshes have not as many principal components as shapes are asked for.
    #[error("rank {found}: the meshes have {most} principal components")]
    Rank {
        /// Shapes asked for.
        found: usize,
        /// Components.
        most: usize,
    },
    /// A file cannot hold the tolerance of pins.
    #[error(
        "tolerance of pins {found:e}: expected {:e} to {:e}; the default is {share} of the face's diagonal: \
         give a tolerance, or scale the face",
        .range[0], .range[1]
    )]
    Tolerance {
        /// The tolerance.
        found: f64,
        /// Its default, in diagonals of the neutral mesh.
        share: f64,
        /// Least and greatest tolerance.
        range: [f64; 2],
    },
    /// A scene cannot be written.
    #[error(transparent)]
    Glb(GlbError),
    /// What was learned cannot be baked.
    #[error(transparent)]
    Bake(#[from] BakeError),
    /// A picture cannot be encoded.
    #[error(transparent)]
    Picture(#[from] png::EncodingError),
    /// A face has no faces to draw.
    #[error("has points alone, no faces: give an .obj to write, not a picture or a scene")]
    NoFaces,
    /// The mesh beside a face is another's.
    #[error("{}: expected {expected} vertices, as the face beside it has, found {found}", file.display())]
    Beside {
        /// The mesh.
        file: PathBuf,
        /// Vertices of the face.
        expected: usize,
        /// Vertices of the mesh.
        found: usize,
    },
    /// The runtime refuses what is asked.
    #[error(transparent)]
    Call(#[from] CallError),
    /// A cell must be a whole number, or a positive one, and is not.
    #[error("line {line}, column {column:?}: expected {expected}, found {found}")]
    Cell {
        /// The line, the first being 1.
        line: u64,
        /// The column.
        column: &'static str,
        /// What it must be.
        expected: String,
        /// What it is.
        found: f64,
    },
}

/// A name that is unknown.
#[derive(Debug)]
pub struct Unknown {
    /// The name.
    pub name: String,
    /// Known names that are like it, the most like it first.
    pub nearest: Vec<String>,
}

/// Joins the first of some items, and counts the others.
pub fn listed(items: impl ExactSizeIterator<Item = impl Display>) -> String {
    let more = items.len().saturating_sub(LISTED);
    let first: Vec<String> = items.take(LISTED).map(|item| item.to_string()).collect();
    let first = first.join(", ");
    if more == 0 { first } else { format!("{first} and {more} more") }
}

impl Display for Unknown {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{:?}", self.name)?;
        match self.nearest.as_slice() {
            [] => Ok(()),
            nearest => write!(f, " (did you mean {}?)", nearest.join(", ")),
        }
    }
}

impl From<CsvError> for FaceError {
    fn from(error: CsvError) -> Self {
        FormatError::from(error).into()
    }
}
