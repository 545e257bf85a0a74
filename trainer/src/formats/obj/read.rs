//! Reads OBJ files.

use std::path::Path;

use super::error::ObjError;
use crate::formats::error::{FileError, FormatError};
use crate::formats::mesh::Mesh;
use crate::formats::polygons::Polygons;
use crate::mesh::Corners;

/// Characters of a faulty line that a message shows.
const SHOWN: usize = 60;

/// Reads a mesh: all vertices and faces of the file, whatever object or group they are in.
///
/// # Errors
/// A [`FileError`] that names the file: it cannot be read, has a line that is no OBJ, names a vertex
/// that it does not have, or has no faces.
pub fn load(path: &Path) -> Result<Mesh, FileError> {
    let Parsed { positions, polygons, corners, texture, normals } = read(path)?;
    let (triangles, places) =
        (polygons.triangles(&positions), polygons.corner_triangles(&positions));
    if triangles.is_empty() {
        return Err(FileError { file: path.to_owned(), error: ObjError::NoFaces.into() });
    }
    let uv = |corner: &Corner| corner.texture.map(|place| texture[place]).unwrap_or_default();
    let normal = |corner: &Corner| corner.normal.map(|place| normals[place]).unwrap_or_default();
    let corners = Corners {
        vertices: polygons.corners().to_vec(),
        normals: (!normals.is_empty()).then(|| corners.iter().map(normal).collect()),
        tangents: None,
        uv: (!texture.is_empty()).then(|| corners.iter().map(uv).collect()),
    };
    let (engine, _) = corners.engine_mesh(&positions, &places);
    let engine = (!engine.is_plain()).then_some(engine);
    Ok(Mesh { positions, triangles, engine })
}

/// What an OBJ file holds.
pub(in crate::formats) struct Parsed {
    /// Positions, V.
    pub(in crate::formats) positions: Vec<[f64; 3]>,
    pub(in crate::formats) polygons: Polygons,
    /// The corners of the polygons, one after another.
    pub(super) corners: Vec<Corner>,
    pub(super) texture: Vec<[f64; 2]>,
    normals: Vec<[f64; 3]>,
}

/// What a face names at a corner, from 0 on.
pub(super) struct Corner {
    vertex: usize,
    pub(super) texture: Option<usize>,
    normal: Option<usize>,
}

/// Reads a file without splitting its polygons.
pub(in crate::formats) fn read(path: &Path) -> Result<Parsed, FileError> {
    let bytes = std::fs::read(path).map_err(FormatError::Read);
    bytes
        .and_then(|bytes| parse(&bytes).map_err(FormatError::from))
        .map_err(|error| FileError { file: path.to_owned(), error })
}

/// Reads vertices, texture coordinates, normals and faces. What else a file holds says nothing of its shape.
///
/// No crate does: tobj numbers vertices by their first use, which loses the order that shapes have in
/// common; obj loses the faces between some `g` and `o` lines and panics on some names in them.
pub(super) fn parse(bytes: &[u8]) -> Result<Parsed, ObjError> {
    let mut positions = Vec::new();
    let mut texture = Vec::new();
    let mut normals = Vec::new();
    let mut corners = Vec::new();
    let mut polygons = Polygons::default();
    if bytes.contains(&0) {
        return Err(ObjError::Binary);
    }
    for (number, line) in String::from_utf8_lossy(bytes).lines().enumerate() {
        let mut words = line.split_ascii_whitespace();
        let read = match words.next() {
            Some("v") => numbers(&mut words).map(|position| positions.push(position)),
            Some("vt") => numbers(&mut words).map(|uv| texture.push(uv)),
            Some("vn") => numbers(&mut words).map(|normal| normals.push(normal)),
            Some("f") => {
                let begin = corners.len();
                words
                    .try_for_each(|word| {
                        let len = [positions.len(), texture.len(), normals.len()];
                        corners.push(Corner::parse(word, len)?);
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
            if corner.normal.is_some_and(|place| place >= normals.len()) {
                return Err(absent("normal", normals.len()));
            }
        }
    }
    Ok(Parsed { positions, polygons, corners, texture, normals })
}

impl Corner {
    /// Reads `vertex`, `vertex/texture`, `vertex/texture/normal` or `vertex//normal`, of which a number
    /// below 0 counts back from those there are so far.
    fn parse(word: &str, [vertex_len, texture_len, normal_len]: [usize; 3]) -> Option<Self> {
        let mut parts = word.split('/');
        let vertex = place(parts.next()?, vertex_len)?;
        let mut named = |len| match parts.next() {
            None | Some("") => Some(None),
            Some(part) => place(part, len).map(Some),
        };
        Some(Self { vertex, texture: named(texture_len)?, normal: named(normal_len)? })
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
