//! Reads the arrays of examples: faces, texture coordinates, clips, meshes, weights and space.

use super::sidecar::Sidecar;
use crate::Error;
use crate::examples::validate::{empty, out_of_range, same};
use crate::examples::{Clip, RATES, Split};
use crate::formats::npz::{Archive, Number, Rows, missing};
use crate::mesh::{Corners, EngineMesh};
use sinew_runtime::format::{Axis, Handedness, Space};
use std::ops::Range;
use std::path::Path;

/// Arrays of faces: quads, then triangles.
pub(super) const FACES: [&str; 2] = ["quads", "tris"];
/// Arrays with the texture coordinates of the corners of quads and triangles, the usual names first.
const UV_BY_CORNER: [[&str; 2]; 2] = [["quads_uv", "tris_uv"], ["uv_quads", "uv_tris"]];
/// Arrays with the normals of the corners of quads and triangles.
const NORMALS_BY_CORNER: [[&str; 2]; 1] = [["quads_normals", "tris_normals"]];
/// Clips, as runs of frames.
pub(super) const CLIPS: RunKind =
    RunKind { what: "clips", names: "clip_names", starts: "clip_starts" };
/// Meshes, as runs of vertices.
pub(super) const MESHES: RunKind =
    RunKind { what: "meshes", names: "mesh_names", starts: "mesh_starts" };

/// Faces split into triangles.
pub(super) struct Faces {
    /// Indices of each triangle's corners. Quads come first, split into corners 0 1 2 and 0 2 3.
    pub(super) triangles: Vec<[usize; 3]>,
    /// Number of quads and of triangles; `None` without the array.
    pub(super) counts: [Option<usize>; 2],
}

/// Names of consecutive ranges of frames or vertices.
type Runs = Vec<(String, Range<usize>)>;

/// Kind of consecutive ranges in a file.
pub(super) struct RunKind {
    /// The items, for messages.
    pub(super) what: &'static str,
    /// Array of the names.
    pub(super) names: &'static str,
    /// Array of the starts.
    pub(super) starts: &'static str,
}

/// Reads faces and checks that their corners are below `len`; `None` if neither array exists.
pub(super) fn read_faces(
    archive: &mut Archive,
    [quads, tris]: [&'static str; 2],
    len: usize,
) -> Result<Option<Faces>, Error> {
    let of_quads = archive.rows::<i64, 4>(quads, &[4])?.map(|rows| rows.data);
    let of_tris = archive.rows::<i64, 3>(tris, &[3])?.map(|rows| rows.data);
    let counts = [of_quads.as_ref().map(Vec::len), of_tris.as_ref().map(Vec::len)];
    if counts == [None, None] {
        return Ok(None);
    }
    let mut triangles = Vec::new();
    for (face, quad) in of_quads.iter().flatten().enumerate() {
        let [a, b, c, d] = corners(quads, face, quad, len)?;
        triangles.extend([[a, b, c], [a, c, d]]);
    }
    for (face, triangle) in of_tris.iter().flatten().enumerate() {
        triangles.push(corners(tris, face, triangle, len)?);
    }
    Ok(Some(Faces { triangles, counts }))
}

/// Reads texture coordinates and normals, each per vertex or per corner, as engine vertices; `None` without either
/// array. Also returns the number of normals without a direction, which are repaired.
///
/// # Errors
/// An array cannot be read, the number of coordinates, normals or faces is wrong, or a corner is out of range.
pub(super) fn read_engine(
    archive: &mut Archive,
    positions: &[[f64; 3]],
    faces: &Faces,
) -> Result<(Option<EngineMesh>, usize), Error> {
    let vertex_len = positions.len();
    let uv = read_corners(archive, "uv", &UV_BY_CORNER, vertex_len, faces)?;
    let normals = read_corners(archive, "normals", &NORMALS_BY_CORNER, vertex_len, faces)?;
    if uv.is_none() && normals.is_none() {
        return Ok((None, 0));
    }
    let vertices = faces.triangles.as_flattened().to_vec();
    let places: Vec<usize> = (0..vertices.len()).collect();
    let corners = Corners { vertices, normals, uv, ..Corners::default() };
    let (engine, repaired) = corners.engine_mesh(positions, places.as_chunks().0);
    Ok((Some(engine), repaired))
}

/// Reads an attribute of K numbers at each corner of the triangles, 3T; `None` without the array.
///
/// - `by_corner`: possible names of the arrays with the index of each corner; without these arrays the attribute belongs
///   to the vertices.
fn read_corners<const K: usize>(
    archive: &mut Archive,
    array: &'static str,
    by_corner: &[[&'static str; 2]],
    vertex_len: usize,
    faces: &Faces,
) -> Result<Option<Vec<[f64; K]>>, Error> {
    let Some(rows) = archive.rows::<f64, K>(array, &[K as u64])? else { return Ok(None) };
    let all = rows.data;
    let mut found = None;
    for &names in by_corner {
        if found.is_none() {
            found = read_faces(archive, names, all.len())?.map(|found| (names, found));
        }
    }
    let places = match &found {
        Some((names, found)) => {
            for kind in 0..2 {
                let [expected, found] = [faces, found].map(|faces| faces.counts[kind].unwrap_or(0));
                same("faces", FACES[kind], expected, names[kind], found)?;
            }
            &found.triangles
        }
        None => {
            same("vertices", "rest", vertex_len, array, all.len())?;
            &faces.triangles
        }
    };
    Ok(Some(places.as_flattened().iter().map(|&place| all[place]).collect()))
}

/// Reads the clips of N frames, and the frame rate if given. Without named clips all frames are one clip, named after
/// the file.
///
/// # Errors
/// As [`read_runs`]; also if frame numbers do not ascend in a clip, or the frame rate is out of range.
pub(super) fn read_clips(
    archive: &mut Archive,
    sidecar: &Sidecar,
    file: &Path,
    frame_len: usize,
) -> Result<(Vec<Clip>, Option<f64>), Error> {
    let stated = (&sidecar.clip_names, &sidecar.clip_starts);
    let runs = read_runs(archive, &CLIPS, stated, frame_len)?;
    let runs = runs.unwrap_or_else(|| vec![(Clip::name_of(file), 0..frame_len)]);
    let numbers = read_each::<i64>(archive, "frame_numbers", ("frames", "vertices", frame_len))?;
    let fps = sidecar.fps.map_or_else(|| archive.number("fps"), |fps| Ok(Some(fps)))?;
    if let Some(fps) = fps.filter(|fps| !RATES.contains(fps)) {
        return Err(Error::value(format!(
            "array fps has {fps}, expected {} to {} frames a second",
            RATES.start(),
            RATES.end()
        )));
    }
    let clip = |(name, frames): (String, Range<usize>)| {
        let mut clip = match &numbers {
            None => Clip::regular(name, frames.start, frames.len()),
            Some(numbers) => Clip::numbered(name, frames.start, ascending(numbers, &frames)?),
        };
        if let Some(fps) = fps {
            clip.play_at(fps);
        }
        Ok(clip)
    };
    Ok((runs.into_iter().map(clip).collect::<Result<_, Error>>()?, fps))
}

/// Reads joint weights, V x J.
///
/// # Errors
/// The array cannot be read, or has other counts.
pub(super) fn read_joint_weights(
    archive: &mut Archive,
    [vertex_len, joint_len]: [usize; 2],
) -> Result<Option<Vec<f64>>, Error> {
    let rows = archive.rows::<f64, 1>("joint_weights", &[0])?;
    if let Some(rows) = &rows {
        same("vertices", "rest", vertex_len, "joint_weights", rows.lead[0])?;
        same("joints", "bone_names", joint_len, "joint_weights", rows.lead[1])?;
    }
    Ok(flat(rows))
}

/// Reads the names of C curves and their values, N x C; none without the array.
///
/// # Errors
/// An array cannot be read, or counts differ.
pub(super) fn read_curves(
    archive: &mut Archive,
    sidecar: &Sidecar,
    frame_len: usize,
) -> Result<(Vec<String>, Vec<f64>), Error> {
    let Some(rows) = archive.rows::<f64, 1>("curves", &[0])? else {
        return Ok(Default::default());
    };
    same("frames", "vertices", frame_len, "curves", rows.lead[0])?;
    let names = match &sidecar.curve_names {
        Some(names) => names.clone(),
        None => archive.texts("curve_names")?.ok_or_else(|| missing("curve_names"))?,
    };
    same("curves", "curve_names", names.len(), "curves", rows.lead[1])?;
    Ok((names, rows.data.into_flattened()))
}

/// Reads the use of each frame, N.
pub(super) fn read_split(
    archive: &mut Archive,
    frame_len: usize,
) -> Result<Option<Vec<Split>>, Error> {
    let codes = read_each::<i64>(archive, "split", ("frames", "vertices", frame_len))?;
    let Some(codes) = codes else { return Ok(None) };
    let split = codes.into_iter().enumerate().map(|(frame, code)| match code {
        0 => Ok(Split::Train),
        1 => Ok(Split::HeldOut),
        2 => Ok(Split::Extreme),
        _ => {
            let words = format!("array split has code {code}, expected 0, 1 or 2");
            Err(Error::value(words).in_frame(frame))
        }
    });
    split.collect::<Result<_, _>>().map(Some)
}

/// Reads axes, handedness and unit; the JSON takes precedence over the arrays.
///
/// # Errors
/// An array cannot be read, or has an unknown axis or handedness.
pub(super) fn read_space(archive: &mut Archive, sidecar: &Sidecar) -> Result<Space, Error> {
    let mut word = |array: &'static str, stated: &Option<String>| match stated {
        Some(word) => Ok(Some(word.clone())),
        None => archive.text(array),
    };
    let up = axis("up", word("up", &sidecar.up)?)?;
    let forward = axis("forward", word("forward", &sidecar.forward)?)?;
    let handedness = match word("handedness", &sidecar.handedness)?.as_deref() {
        None | Some("right") => Handedness::Right,
        Some("left") => Handedness::Left,
        Some(found) => return Err(unknown_word("handedness", found, "right or left")),
    };
    let unit = sidecar.unit.map_or_else(|| archive.number("unit"), |unit| Ok(Some(unit)))?;
    Ok(Space { up, forward, handedness, unit: unit.map(|metres| metres as f32) })
}

/// Reads consecutive named ranges that cover `len` frames or vertices. The JSON takes precedence over the arrays.
/// `None` if neither exists.
///
/// - `names`, `starts`: names and starts in the JSON.
///
/// # Errors
/// An array cannot be read, names and starts differ in number, or a range does not start after the previous one.
pub(super) fn read_runs(
    archive: &mut Archive,
    kind: &RunKind,
    (names, starts): (&Option<Vec<String>>, &Option<Vec<i64>>),
    len: usize,
) -> Result<Option<Runs>, Error> {
    let names = match names {
        Some(names) => Some(names.clone()),
        None => archive.texts(kind.names)?,
    };
    let starts = match starts {
        Some(starts) => Some(starts.clone()),
        None => flat(archive.rows(kind.starts, &[])?),
    };
    if names.is_none() && starts.is_none() {
        return Ok(None);
    }
    let names = names.ok_or_else(|| missing(kind.names))?;
    let starts = starts.ok_or_else(|| missing(kind.starts))?;
    same(kind.what, kind.names, names.len(), kind.starts, starts.len())?;
    if names.is_empty() {
        return Err(empty(kind.names));
    }
    let mut begins: Vec<usize> = Vec::with_capacity(starts.len());
    for (&found, name) in starts.iter().zip(&names) {
        let fits = |start: &usize| match begins.last() {
            None => *start == 0,
            Some(before) => start > before && *start < len,
        };
        let Some(start) = usize::try_from(found).ok().filter(fits) else {
            let array = kind.starts;
            return Err(Error::value(format!(
                "array {array} has {found} for {name}, expected 0 for the first, then ascending numbers below {len}"
            )));
        };
        begins.push(start);
    }
    let ends = begins.iter().skip(1).copied().chain([len]);
    let ranges = begins.iter().zip(ends).map(|(&begin, end)| begin..end);
    Ok(Some(names.into_iter().zip(ranges).collect()))
}

/// Reads one number per item.
///
/// - `things`, `of`, `len`: the items, another array over the same items, and its length.
///
/// # Errors
/// The array cannot be read, or has another count.
pub(super) fn read_each<T: Number>(
    archive: &mut Archive,
    array: &'static str,
    (things, of, len): (&'static str, &'static str, usize),
) -> Result<Option<Vec<T>>, Error> {
    let numbers = flat(archive.rows(array, &[])?);
    if let Some(numbers) = &numbers {
        same(things, of, len, array, numbers.len())?;
    }
    Ok(numbers)
}

/// Returns the numbers of an array.
fn flat<T>(rows: Option<Rows<T, 1>>) -> Option<Vec<T>> {
    rows.map(|rows| rows.data.into_flattened())
}

fn corners<const K: usize>(
    array: &'static str,
    face: usize,
    corners: &[i64; K],
    vertex_len: usize,
) -> Result<[usize; K], Error> {
    match corners.iter().find(|corner| !(0..vertex_len as i64).contains(*corner)) {
        Some(vertex) => Err(out_of_range(array, face, vertex, vertex_len)),
        None => Ok(corners.map(|vertex| vertex as usize)),
    }
}

/// Returns the frame numbers of a clip, which must ascend and fit 32 bits like those of animation programs.
fn ascending(numbers: &[i64], frames: &Range<usize>) -> Result<Vec<i64>, Error> {
    let numbers = &numbers[frames.clone()];
    let mut least = i64::from(i32::MIN);
    for (&found, frame) in numbers.iter().zip(frames.clone()) {
        if found < least || found > i64::from(i32::MAX) {
            let error = Error::value(format!(
                "array frame_numbers has {found}, expected {least} to {}: numbers ascend in each clip",
                i32::MAX
            ));
            return Err(error.in_frame(frame));
        }
        least = found + 1;
    }
    Ok(numbers.to_vec())
}

fn axis(array: &str, found: Option<String>) -> Result<Option<Axis>, Error> {
    let Some(found) = found else { return Ok(None) };
    let named = Axis::ALL.into_iter().find(|axis| axis.name() == found);
    named.ok_or_else(|| unknown_word(array, &found, "x, -x, y, -y, z or -z")).map(Some)
}

fn unknown_word(array: &str, found: &str, expected: &str) -> Error {
    Error::value(format!("array {array} has {found:?}, expected {expected}"))
}
