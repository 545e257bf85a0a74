//! Errors in faces, takes and tracks.

use crate::bake::BakeError;
use crate::formats::{CsvError, FileError, FormatError, GlbError};
use sinew_runtime::CallError;
use std::fmt::Display;
use std::path::PathBuf;

/// Items that a message lists; further items are counted.
const LISTED: usize = 5;

/// An unusable face, take or track.
#[derive(Debug, thiserror::Error)]
pub enum FaceError {
    /// The file cannot be read or has the wrong format.
    #[error(transparent)]
    Format(#[from] FormatError),
    /// A file in a folder cannot be read.
    #[error(transparent)]
    File(#[from] FileError),
    /// The face has no shape.
    #[error("has no shape: a face needs a neutral mesh and at least one")]
    NoShapes,
    /// Two shapes have the same name.
    #[error("two shapes are named {name:?}")]
    Twice {
        /// The name.
        name: String,
    },
    /// An array has the wrong length.
    #[error("array {array}: expected {expected} {what}, found {found}")]
    Count {
        /// Name of the array.
        array: &'static str,
        /// The counted items.
        what: &'static str,
        /// Expected number.
        expected: usize,
        /// Number found.
        found: usize,
    },
    /// A vertex number is out of range.
    #[error("{place} names vertex {found} of {len}")]
    Vertex {
        /// Location of the number.
        place: String,
        /// The number found.
        found: i64,
        /// Number of vertices.
        len: usize,
    },
    /// A number of the face is not finite.
    #[error("array {array} holds a number that is not finite")]
    NotFinite {
        /// Name of the array.
        array: &'static str,
    },
    /// The identity does not exist.
    #[error("there is no identity {found}: there are {len}, the first is 0")]
    Identity {
        /// Requested number.
        found: usize,
        /// Number of identities.
        len: usize,
    },
    /// Columns of a take are not shapes of the face, and not known as columns without a shape.
    #[error("unknown {}: name each column after a shape of the face, or remove the column", listed(.unknown.iter()))]
    Names {
        /// Unknown names with suggestions.
        unknown: Vec<Unknown>,
    },
    /// A take drives no shape of the face.
    #[error("no column drives a shape of the face; its shapes are {}", listed(.known.iter()))]
    NoColumns {
        /// Names of the face's shapes.
        known: Vec<String>,
    },
    /// Two columns of a take drive the same shape with different weights.
    #[error(
        "columns {:?} and {:?} both drive shape {shape:?}, and differ in {place}: {} and {}: remove one of {}",
        .columns[0], .columns[1], .found[0], .found[1],
        if *.pairs > 1 { format!("each of {} such pairs", .pairs) } else { "them".to_owned() }
    )]
    Contradiction {
        /// Name of the shape.
        shape: String,
        /// Names of the columns.
        columns: [String; 2],
        /// First difference: line of a table or frame of an array.
        place: String,
        /// Weights at the first difference.
        found: [f64; 2],
        /// Number of contradicting pairs of columns.
        pairs: usize,
    },
    /// Tracking is lost in every row of a take.
    #[error("has no frame: the tracking is lost in all {len} rows")]
    Lost {
        /// Number of rows.
        len: usize,
    },
    /// A range of frames or vertices is empty or out of bounds.
    #[error("{what} {first}..{end}: expected a range within 0..{len} that is not empty")]
    Range {
        /// The counted items.
        what: &'static str,
        /// Start of the range.
        first: usize,
        /// End of the range, exclusive.
        end: usize,
        /// Number of items.
        len: usize,
    },
    /// The file holds no face.
    #[error("has no face: no prior over the shapes of a skin; `sinew face train` makes one")]
    NoFace,
    /// There are fewer landmarks than requested handles, or no handles are requested.
    #[error("{found} handles: expected 1 to {len}, as many as the face has landmarks")]
    Handles {
        /// Requested handles.
        found: usize,
        /// Number of landmarks.
        len: usize,
    },
    /// The meshes have fewer principal components than requested shapes.
    #[error("rank {found}: the meshes have {most} principal components")]
    Rank {
        /// Requested shapes.
        found: usize,
        /// Principal components.
        most: usize,
    },
    /// The tolerance of pins is outside the range that a file can hold.
    #[error(
        "tolerance of pins {found:e}: expected {:e} to {:e}; the default is {share} of the face's diagonal: \
         give a tolerance, or scale the face",
        .range[0], .range[1]
    )]
    Tolerance {
        /// The tolerance.
        found: f64,
        /// Default tolerance, as a fraction of the neutral mesh's diagonal.
        share: f64,
        /// Least and greatest tolerance.
        range: [f64; 2],
    },
    /// A scene cannot be written.
    #[error(transparent)]
    Glb(GlbError),
    /// The trained face cannot be baked.
    #[error(transparent)]
    Bake(#[from] BakeError),
    /// A picture cannot be encoded.
    #[error(transparent)]
    Picture(#[from] png::EncodingError),
    /// The mesh has no faces to draw.
    #[error("has points alone, no faces: give an .obj to write, not a picture or a scene")]
    NoFaces,
    /// The mesh beside the file has the wrong number of vertices.
    #[error("{}: expected {expected} vertices, as the face beside it has, found {found}", file.display())]
    Beside {
        /// The mesh file.
        file: PathBuf,
        /// Vertices of the face.
        expected: usize,
        /// Vertices of the mesh.
        found: usize,
    },
    /// The runtime refuses the call.
    #[error(transparent)]
    Call(#[from] CallError),
    /// A cell is not a whole number, or not positive.
    #[error("line {line}, column {column:?}: expected {expected}, found {found}")]
    Cell {
        /// Line number, from 1.
        line: u64,
        /// Name of the column.
        column: &'static str,
        /// Allowed values.
        expected: String,
        /// Value of the cell.
        found: f64,
    },
}

/// An unknown name.
#[derive(Debug)]
pub struct Unknown {
    /// The name.
    pub name: String,
    /// Similar known names, the most similar first.
    pub nearest: Vec<String>,
}

/// Joins the first items of a list and counts the rest.
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
