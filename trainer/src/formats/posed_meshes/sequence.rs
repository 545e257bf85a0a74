//! Sequences of OBJ files, one a frame, ordered by the numbers in their names.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use rayon::prelude::*;

use super::PosedMeshes;
use crate::Error;
use crate::formats::extension::extension;
use crate::formats::obj;
use crate::formats::polygons::Polygons;

/// Reads the sequence that [`files`] finds, with the triangles of its first file.
pub(crate) fn read(path: &Path) -> Result<PosedMeshes, Error> {
    let files = files(path)?;
    let Some((first, others)) = files.split_first() else {
        let none = "is a folder without an .obj file; export one a frame, numbered: pose_1.obj, \
                    pose_2.obj";
        return Err(Error::missing(none).in_file(path));
    };
    let obj::Parsed { positions, polygons, .. } = obj::read(first)?;
    let read = |file: &PathBuf| {
        let found = obj::read(file)?;
        check_same_mesh(first, positions.len(), &polygons, &found)
            .map_err(|error| error.in_file(file))?;
        Ok(found.positions)
    };
    let shapes: Vec<Result<Vec<[f64; 3]>, Error>> = others.par_iter().map(read).collect();
    let mut vertices = positions.clone();
    vertices.reserve_exact(others.len() * positions.len());
    for shape in shapes {
        vertices.extend(shape?);
    }
    let triangles = Some(polygons.triangles(&positions)).filter(|triangles| !triangles.is_empty());
    Ok(PosedMeshes { triangles, ..PosedMeshes::bare(positions.len(), vertices) })
}

/// Lists the files of a sequence in the order of their numbers.
///
/// - `path`: a folder, for all its `.obj` files; or a file, for all files beside it whose names differ from its name
///   only in the number at the end.
pub(crate) fn files(path: &Path) -> Result<Vec<PathBuf>, Error> {
    let whole = path.is_dir();
    let folder = if whole { path } else { path.parent().unwrap_or(path) };
    let stem = match whole {
        true => None,
        false => Some(numbered(path).ok_or_else(|| no_number(path))?.0),
    };
    // The folder of a bare file name is the empty path, which cannot be listed.
    let listed = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let unread = |error| Error::read(error).in_file(listed);
    let mut files = BTreeMap::new();
    let mut names = Vec::new();
    for entry in std::fs::read_dir(listed).map_err(unread)? {
        names.push(entry.map_err(unread)?.file_name());
    }
    // The system lists folders in no particular order.
    names.sort();
    for name in names {
        let file = folder.join(&name);
        let is_obj = file.extension().is_some_and(|found| found.eq_ignore_ascii_case("obj"));
        // Operating systems keep hidden files beside files.
        if !is_obj || name.as_encoded_bytes().starts_with(b".") {
            continue;
        }
        let number = match (numbered(&file), &stem) {
            (Some((found, _)), Some(stem)) if found != *stem => continue,
            (None, Some(_)) => continue,
            (None, None) => return Err(no_number(&file)),
            (Some((_, number)), _) => number,
        };
        if let Some(other) = files.insert(number, file.clone()) {
            let other = name_of(&other);
            let error = Error::value(format!(
                "has the frame number of {other}, {number}; keep one of them, or one sequence a \
                 folder"
            ));
            return Err(error.in_file(file));
        }
    }
    Ok(files.into_values().collect())
}

fn no_number(file: &Path) -> Error {
    Error::value("has no frame number before .obj; export one file a frame: pose_1.obj, pose_2.obj")
        .in_file(file)
}

/// Names the files that a sequence lacks, if its numbers are otherwise evenly spaced.
pub(crate) fn missing(files: &[PathBuf]) -> Vec<String> {
    let numbers: Option<Vec<(String, u64)>> = files.iter().map(|file| numbered(file)).collect();
    let numbers = numbers.unwrap_or_default();
    let steps = numbers.windows(2).map(|pair| pair[1].1 - pair[0].1);
    let Some(step) = most_frequent(steps.clone()) else { return Vec::new() };
    let gaps = steps.clone().filter(|gap| *gap != step);
    let missing: u64 = gaps.map(|gap| gap / step - 1).sum();
    // Uneven numbers, or more missing files than files, are not a sequence with a gap.
    if steps.clone().any(|gap| gap % step != 0) || missing > files.len() as u64 {
        return Vec::new();
    }
    let mut names = Vec::new();
    for ((file, (stem, number)), gap) in files.iter().zip(&numbers).zip(steps) {
        let name = file.file_stem().unwrap_or_default().to_string_lossy();
        let (digits, ending) = (name.len() - stem.len(), extension(file));
        let absent = (1..gap / step).map(|count| number + count * step);
        names.extend(absent.map(|number| format!("{stem}{number:0digits$}.{ending}")));
    }
    names
}

/// Returns the most frequent step, the smallest of several; `None` without steps.
fn most_frequent(steps: impl Iterator<Item = u64>) -> Option<u64> {
    let mut counts = BTreeMap::new();
    for step in steps {
        *counts.entry(step).or_insert(0_usize) += 1;
    }
    let most = counts.into_iter().max_by_key(|&(step, count)| (count, std::cmp::Reverse(step)));
    most.map(|(step, _)| step)
}

/// Splits a file's name, without its extension, into its stem and the number at its end.
fn numbered(file: &Path) -> Option<(String, u64)> {
    let name = file.file_stem()?.to_string_lossy().into_owned();
    let stem = name.trim_end_matches(|digit: char| digit.is_ascii_digit());
    Some((stem.to_owned(), name[stem.len()..].parse().ok()?))
}

/// Checks that a mesh has the vertices and faces of the first mesh.
fn check_same_mesh(
    first: &Path,
    vertex_len: usize,
    polygons: &Polygons,
    found: &obj::Parsed,
) -> Result<(), Error> {
    let first = name_of(first);
    if found.positions.len() != vertex_len {
        let found = found.positions.len();
        return Err(Error::mismatch(format!(
            "has {found} vertices, expected {vertex_len} as in {first}; export every frame with \
             the same vertices in the same order"
        )));
    }
    if found.polygons != *polygons {
        let pairs = found.polygons.iter().zip(polygons.iter());
        let face = pairs.take_while(|(found, expected)| found == expected).count() + 1;
        let (found_len, expected_len) = (found.polygons.iter().count(), polygons.iter().count());
        return Err(Error::mismatch(format!(
            "has other faces than {first}, from face {face} on ({found_len} in all, expected \
             {expected_len}); export every frame with the same faces, not triangulated anew"
        )));
    }
    Ok(())
}

/// Returns the name of a file, without its folder.
pub(crate) fn name_of(file: &Path) -> String {
    file.file_name().unwrap_or_default().to_string_lossy().into_owned()
}
