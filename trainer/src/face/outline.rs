//! The mesh beside a face's file: an OBJ with the skin's vertices, faces, texture coordinates, and landmarks as points.
//! The runtime does not need this mesh.

use super::basis::Basis;
use crate::Error;
use crate::formats::{Mesh, obj};
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// The mesh beside a face's file.
pub struct Outline {
    /// Text of the OBJ file.
    pub text: String,
    /// The parsed mesh; `None` without faces.
    pub mesh: Option<Mesh>,
    /// Landmark vertices.
    pub landmarks: Vec<usize>,
}

/// Returns the path of the mesh beside a face.
pub fn beside(face: &Path) -> PathBuf {
    match face.extension().is_some_and(|ending| ending == "sinew") {
        true => face.with_extension("obj"),
        false => PathBuf::from(format!("{}.obj", face.display())),
    }
}

/// Formats the mesh beside a face as OBJ.
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
    /// - `vertex_len`: number of the face's vertices, V.
    ///
    /// # Errors
    /// The error names the mesh: the mesh cannot be read or is damaged, or its number of vertices differs from V.
    pub fn read(face: &Path, vertex_len: usize) -> Result<Self, Error> {
        let file = beside(face);
        let mesh = obj::load_optional(&file)?;
        let text =
            std::fs::read_to_string(&file).map_err(|error| Error::read(error).in_file(&file))?;
        let found = text.lines().filter(|line| line.starts_with("v ")).count();
        if found != vertex_len {
            let text =
                format!("expected {vertex_len} vertices, as the face beside it has, found {found}");
            return Err(Error::mismatch(text).in_file(file));
        }
        let points = text.lines().filter_map(|line| line.strip_prefix("p "));
        let numbers = points.flat_map(str::split_ascii_whitespace).filter_map(|n| n.parse().ok());
        let landmarks = numbers.filter(|n| (1..=vertex_len).contains(n)).map(|n: usize| n - 1);
        let landmarks = landmarks.collect();
        Ok(Self { text, mesh, landmarks })
    }

    /// Returns the mesh.
    ///
    /// # Errors
    /// [`ErrorKind::Missing`](crate::ErrorKind::Missing) without faces.
    pub fn faces(&self) -> Result<&Mesh, Error> {
        let text = "has points alone, no faces: give an .obj to write, not a picture or a scene";
        self.mesh.as_ref().ok_or_else(|| Error::missing(text))
    }

    /// Formats the mesh with new positions, V.
    pub fn moved(&self, positions: &[[f64; 3]]) -> String {
        obj::with_positions(&self.text, positions)
    }
}
