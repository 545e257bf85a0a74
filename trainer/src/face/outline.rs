//! The mesh beside a face's file: faces and texture coordinates, which the runtime does without, and landmarks. It is
//! an OBJ with the vertices of the face's skin, its landmarks as points.

use super::basis::Basis;
use super::error::FaceError;
use crate::formats::obj::{self, ObjError};
use crate::formats::{FileError, FormatError, Mesh};
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// The mesh beside a face's file.
pub struct Outline {
    /// What the file says.
    pub text: String,
    /// What that is, if it has faces.
    pub mesh: Option<Mesh>,
    /// Its landmarks.
    pub landmarks: Vec<usize>,
}

/// Says where the mesh beside a face is.
pub fn beside(face: &Path) -> PathBuf {
    match face.extension().is_some_and(|ending| ending == "sinew") {
        true => face.with_extension("obj"),
        false => PathBuf::from(format!("{}.obj", face.display())),
    }
}

/// Writes the mesh beside a face.
pub fn text(basis: &Basis) -> String {
    let mesh = &basis.mesh;
    let mut text = obj::text(&mesh.positions, &mesh.uv, &mesh.faces, &mesh.uv_faces);
    for vertex in &basis.landmarks {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "p {}", vertex + 1);
    }
    text
}

impl Outline {
    /// Reads the mesh beside a face.
    ///
    /// - `vertex_len`: vertices of the face, V.
    ///
    /// # Errors
    /// [`FaceError::File`], which names the mesh: it cannot be read or is damaged; [`FaceError::Beside`]: it has not
    /// the face's vertices.
    pub fn read(face: &Path, vertex_len: usize) -> Result<Self, FaceError> {
        let file = beside(face);
        let mesh = match obj::load(&file) {
            Ok(mesh) => Some(mesh),
            Err(FileError { error: FormatError::Obj(ObjError::NoFaces), .. }) => None,
            Err(error) => return Err(error.into()),
        };
        let text = std::fs::read_to_string(&file)
            .map_err(|error| FileError { file: file.clone(), error: FormatError::Read(error) })?;
        let found = text.lines().filter(|line| line.starts_with("v ")).count();
        if found != vertex_len {
            return Err(FaceError::Beside { file, expected: vertex_len, found });
        }
        let points = text.lines().filter_map(|line| line.strip_prefix("p "));
        let numbers = points.flat_map(str::split_ascii_whitespace).filter_map(|n| n.parse().ok());
        let landmarks = numbers.filter(|n| (1..=vertex_len).contains(n)).map(|n: usize| n - 1);
        let landmarks = landmarks.collect();
        Ok(Self { text, mesh, landmarks })
    }

    /// Gives the mesh, where the face has faces.
    ///
    /// # Errors
    /// [`FaceError::NoFaces`]
    pub fn faces(&self) -> Result<&Mesh, FaceError> {
        self.mesh.as_ref().ok_or(FaceError::NoFaces)
    }

    /// Writes the mesh with its vertices elsewhere.
    pub fn moved(&self, positions: &[[f64; 3]]) -> String {
        obj::with_positions(&self.text, positions)
    }
}
