//! Wavefront OBJ files: reads meshes, and folders of a neutral mesh with its shapes; writes meshes.

#[cfg(test)]
mod tests;

use super::extension::extension;
use super::mesh::{Mesh, NamedShape, ShapedMesh};
use super::polygons::Polygons;
use crate::Error;
use crate::mesh::Corners;
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// Characters of a faulty line that an error shows.
const SHOWN: usize = 60;

/// File stem of the neutral mesh.
const NEUTRAL: &str = "neutral";

/// Reads a mesh: all vertices and faces of the file, of every object and group.
///
/// # Errors
/// The file cannot be read or is not text, a line is not OBJ, a face refers to a missing item, or no face has three
/// corners.
pub fn load(path: &Path) -> Result<Mesh, Error> {
    load_optional(path)?.ok_or_else(|| no_faces(path))
}

/// Reads a mesh like [`load`]; `None` if no face has three corners.
///
/// # Errors
/// Those of [`load`], except for missing faces.
pub(crate) fn load_optional(path: &Path) -> Result<Option<Mesh>, Error> {
    let Parsed { positions, polygons, corners, texture, normals } = read(path)?;
    let (triangles, places) =
        (polygons.triangles(&positions), polygons.corner_triangles(&positions));
    if triangles.is_empty() {
        return Ok(None);
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
    Ok(Some(Mesh { positions, triangles, engine }))
}

fn no_faces(path: &Path) -> Error {
    Error::missing("has no face of three corners or more; export a polygon mesh").in_file(path)
}

/// The contents of an OBJ file.
pub(in crate::formats) struct Parsed {
    /// Positions, V.
    pub(in crate::formats) positions: Vec<[f64; 3]>,
    pub(in crate::formats) polygons: Polygons,
    /// Corners of the polygons, in order.
    corners: Vec<Corner>,
    texture: Vec<[f64; 2]>,
    normals: Vec<[f64; 3]>,
}

/// Reads a file without splitting its polygons.
pub(in crate::formats) fn read(path: &Path) -> Result<Parsed, Error> {
    let bytes = std::fs::read(path).map_err(Error::read);
    bytes.and_then(|bytes| parse(&bytes)).map_err(|error| error.in_file(path))
}

/// Reads `neutral.obj` and every other OBJ of its folder. Shapes are named after their files and sorted by name.
///
/// # Errors
/// The folder has no neutral mesh, or no other mesh. A file cannot be read; the neutral mesh has no faces; or a shape
/// has another number of vertices than the neutral mesh.
pub(crate) fn read_folder(folder: &Path) -> Result<ShapedMesh, Error> {
    let unread = |error| Error::read(error).in_file(folder);
    let mut files: Vec<PathBuf> = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(unread)? {
        let path = entry.map_err(unread)?.path();
        if extension(&path) == "obj" {
            files.push(path);
        }
    }
    files.sort();
    let name = |path: &Path| path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let neutral = files.iter().position(|path| name(path).to_lowercase() == NEUTRAL);
    let no_neutral =
        "has no neutral.obj: save the face at rest under that name, and each shape beside it";
    let neutral = neutral.ok_or_else(|| Error::missing(no_neutral).in_file(folder))?;
    let neutral = files.remove(neutral);
    if files.is_empty() {
        let no_shapes = "has no shape beside neutral.obj: save each as an OBJ of its own";
        return Err(Error::missing(no_shapes).in_file(folder));
    }
    let Parsed { positions, polygons, corners, texture, .. } = read(&neutral)?;
    let faces: Vec<Vec<usize>> = polygons.iter().map(<[usize]>::to_vec).collect();
    if faces.iter().all(|face| face.len() < 3) {
        return Err(no_faces(&neutral));
    }
    let mut left = corners.iter().map(|corner| corner.texture);
    let uv_faces: Option<Vec<Vec<usize>>> =
        faces.iter().map(|face| left.by_ref().take(face.len()).collect()).collect();
    let uv_faces = uv_faces.filter(|_| !texture.is_empty());
    let mut shapes = Vec::new();
    for file in files {
        let found = read(&file)?.positions;
        if found.len() != positions.len() {
            let (expected, found) = (positions.len(), found.len());
            let error = format!("expected {expected} vertices, as neutral.obj has, found {found}");
            return Err(Error::mismatch(error).in_file(file));
        }
        let by = |(at, from): (&[f64; 3], &[f64; 3])| [0, 1, 2].map(|axis| at[axis] - from[axis]);
        let deltas = found.iter().zip(&positions).map(by).collect();
        shapes.push(NamedShape { name: name(&file), deltas });
    }
    let uv = if uv_faces.is_some() { texture } else { Vec::new() };
    let uv_faces = uv_faces.unwrap_or_default();
    Ok(ShapedMesh { positions, faces, uv, uv_faces, shapes, ..ShapedMesh::default() })
}

/// Writes a mesh as text: positions, texture coordinates, faces.
///
/// - `uv_faces`: texture coordinate of each corner, in the layout of `faces`; empty without texture.
pub(crate) fn text(
    positions: &[[f64; 3]],
    uv: &[[f64; 2]],
    faces: &[Vec<usize>],
    uv_faces: &[Vec<usize>],
) -> String {
    let mut out = String::new();
    positions.iter().for_each(|position| push_line(&mut out, "v", position));
    uv.iter().for_each(|uv| push_line(&mut out, "vt", uv));
    for (at, face) in faces.iter().enumerate() {
        out.push('f');
        for (corner, vertex) in face.iter().enumerate() {
            let uv = uv_faces.get(at).and_then(|uv| uv.get(corner));
            // Writing to a string cannot fail.
            let _ = match uv {
                Some(uv) => write!(out, " {}/{}", vertex + 1, uv + 1),
                None => write!(out, " {}", vertex + 1),
            };
        }
        out.push('\n');
    }
    out
}

/// Replaces the positions in a mesh's text; all other lines stay.
pub(crate) fn with_positions(text: &str, positions: &[[f64; 3]]) -> String {
    let mut left = positions.iter();
    let mut out = String::with_capacity(text.len());
    for line in text.lines() {
        match (line.starts_with("v "), left.as_slice().first()) {
            (true, Some(position)) => {
                push_line(&mut out, "v", position);
                left.next();
            }
            _ => {
                out += line;
                out.push('\n');
            }
        }
    }
    out
}

/// Indices of a corner of a face, from 0.
struct Corner {
    vertex: usize,
    texture: Option<usize>,
    normal: Option<usize>,
}

/// Parses vertices, texture coordinates, normals and faces; other lines do not concern the shape.
///
/// No crate serves here. tobj renumbers vertices by their first use, which loses the order that shapes share. obj loses
/// faces between some `g` and `o` lines, and panics on some names in them.
fn parse(bytes: &[u8]) -> Result<Parsed, Error> {
    let mut positions = Vec::new();
    let mut texture = Vec::new();
    let mut normals = Vec::new();
    let mut corners = Vec::new();
    let mut polygons = Polygons::default();
    if bytes.contains(&0) {
        return Err(Error::damaged("is no text, as an OBJ file is"));
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
        read.ok_or_else(|| {
            let text: String = line.trim().chars().take(SHOWN).collect();
            let line = number + 1;
            Error::damaged(format!(
                "line {line} is no vertex, texture coordinate, normal or face of numbers: {text}"
            ))
        })?;
    }
    // Checked at the end, because faces may precede their vertices.
    let faces = polygons.iter().enumerate();
    let faces = faces.flat_map(|(face, polygon)| std::iter::repeat_n(face + 1, polygon.len()));
    for (face, corner) in faces.zip(&corners) {
        for (what, place, len) in [
            ("vertex", Some(corner.vertex), positions.len()),
            ("texture coordinate", corner.texture, texture.len()),
            ("normal", corner.normal, normals.len()),
        ] {
            if place.is_some_and(|place| place >= len) {
                let what = format!("face {face} refers to a missing {what}; the file has {len}");
                return Err(Error::damaged(what));
            }
        }
    }
    Ok(Parsed { positions, polygons, corners, texture, normals })
}

impl Corner {
    /// Parses `vertex`, `vertex/texture`, `vertex/texture/normal` or `vertex//normal`. A negative number counts back
    /// from the items read so far.
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

/// Turns a number that counts from 1, or back from -1, into an index. A number before the first item gives an index
/// past the end.
fn place(word: &str, len: usize) -> Option<usize> {
    match word.parse::<isize>().ok()? {
        0 => None,
        number if number > 0 => Some(number.unsigned_abs() - 1),
        number => Some(len.checked_sub(number.unsigned_abs()).unwrap_or(usize::MAX)),
    }
}

/// Parses N finite numbers; ignores any words behind them.
fn numbers<'a, const N: usize>(words: &mut impl Iterator<Item = &'a str>) -> Option<[f64; N]> {
    let mut numbers = [0.0; N];
    for number in &mut numbers {
        *number = words.next()?.parse().ok().filter(|number: &f64| number.is_finite())?;
    }
    Some(numbers)
}

fn push_line(out: &mut String, word: &str, numbers: &[f64]) {
    *out += word;
    for number in numbers {
        let _ = write!(out, " {}", *number as f32);
    }
    out.push('\n');
}
