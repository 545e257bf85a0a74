//! Reads OBJ files.

use std::path::Path;

use super::error::ObjError;
use crate::formats::error::{FileError, FormatError};
use crate::formats::mesh::Mesh;
use crate::formats::polygons::{Polygons, uv_of_vertices};

/// Characters of a faulty line that a message shows.
const SHOWN: usize = 60;

/// Reads a mesh: all vertices and faces of the file, whatever object or group they are in.
///
/// # Errors
/// A [`FileError`] that names the file: it cannot be read, has a line that is no OBJ, names a vertex
/// that it does not have, or has no faces.
pub fn load(path: &Path) -> Result<Mesh, FileError> {
    let Parsed { positions, polygons, corners, texture } = read(path)?;
    let triangles = polygons.triangles(&positions);
    if triangles.is_empty() {
        return Err(FileError { file: path.to_owned(), error: ObjError::NoFaces.into() });
    }
    let uv = |corner: &Corner| (corner.vertex, corner.texture.map(|place| texture[place]));
    let uv = uv_of_vertices(positions.len(), corners.iter().map(uv));
    Ok(Mesh { positions, triangles, uv })
}

/// What an OBJ file holds.
pub(in crate::formats) struct Parsed {
    /// Positions, V.
    pub(in crate::formats) positions: Vec<[f64; 3]>,
    pub(in crate::formats) polygons: Polygons,
    /// The corners of the polygons, one after another.
    corners: Vec<Corner>,
    texture: Vec<[f64; 2]>,
}

/// What a face names at a corner, from 0 on.
struct Corner {
    vertex: usize,
    texture: Option<usize>,
}

/// Reads a file without splitting its polygons.
pub(in crate::formats) fn read(path: &Path) -> Result<Parsed, FileError> {
    let bytes = std::fs::read(path).map_err(FormatError::Read);
    bytes
        .and_then(|bytes| parse(&bytes).map_err(FormatError::from))
        .map_err(|error| FileError { file: path.to_owned(), error })
}

/// Reads vertices, texture coordinates and faces. What else a file holds says nothing of its shape.
///
/// No crate does: tobj numbers vertices by their first use, which loses the order that shapes have in
/// common; obj loses the faces between some `g` and `o` lines and panics on some names in them.
pub(super) fn parse(bytes: &[u8]) -> Result<Parsed, ObjError> {
    let mut positions = Vec::new();
    let mut texture = Vec::new();
    let mut corners = Vec::new();
    let mut polygons = Polygons::default();
    for (number, line) in String::from_utf8_lossy(bytes).lines().enumerate() {
        let mut words = line.split_ascii_whitespace();
        let read = match words.next() {
            Some("v") => numbers(&mut words).map(|position| positions.push(position)),
            Some("vt") => numbers(&mut words).map(|uv| texture.push(uv)),
            Some("f") => {
                let begin = corners.len();
                words
                    .try_for_each(|word| {
                        corners.push(Corner::parse(word, positions.len(), texture.len())?);
                        Some(())
                    })
                    .map(|()| polygons.push(corners[begin..].iter().map(|corner| corner.vertex)))
            }
            _ => Some(()),
        };
        read.ok_or_else(|| ObjError::Line {
            line: number + 1,
            text: line.trim().chars().take(SHOWN).collect(),
        })?;
    }
    // Faces may name what comes later.
    let mut left = corners.iter();
    for (face, polygon) in polygons.iter().enumerate() {
        let absent = |what, len| ObjError::Corner { face: face + 1, what, len };
        for corner in left.by_ref().take(polygon.len()) {
            if corner.vertex >= positions.len() {
                return Err(absent("vertex", positions.len()));
            }
            if corner.texture.is_some_and(|place| place >= texture.len()) {
                return Err(absent("texture coordinate", texture.len()));
            }
        }
    }
    Ok(Parsed { positions, polygons, corners, texture })
}

impl Corner {
    /// Reads `vertex`, `vertex/texture`, `vertex/texture/normal` or `vertex//normal`, of which a number
    /// below 0 counts back from those there are so far.
    fn parse(word: &str, vertex_len: usize, texture_len: usize) -> Option<Self> {
        let mut parts = word.split('/');
        let vertex = place(parts.next()?, vertex_len)?;
        let texture = match parts.next() {
            None | Some("") => None,
            Some(part) => Some(place(part, texture_len)?),
        };
        Some(Self { vertex, texture })
    }
}

/// Turns a number that counts from 1, or back from -1, into a place. One before the first becomes one
/// after all.
fn place(word: &str, len: usize) -> Option<usize> {
    match word.parse::<isize>().ok()? {
        0 => None,
        number if number > 0 => Some(number.unsigned_abs() - 1),
        number => Some(len.checked_sub(number.unsigned_abs()).unwrap_or(usize::MAX)),
    }
}

/// Reads finite numbers, and leaves what follows them.
fn numbers<'a, const N: usize>(words: &mut impl Iterator<Item = &'a str>) -> Option<[f64; N]> {
    let mut numbers = [0.0; N];
    for number in &mut numbers {
        *number = words.next()?.parse().ok().filter(|number: &f64| number.is_finite())?;
    }
    Some(numbers)
}
