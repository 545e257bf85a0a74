//! Saves examples as NumPy arrays.

use super::fields::{CLIPS, MESHES, RunKind};
use crate::Error;
use crate::examples::{Clip, Examples, Matrix3x4};
use crate::files::PendingFile;
use crate::formats::npz::Writer;
use serde_json::json;
use sinew_runtime::format::{Handedness, Space};
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;

/// Saves examples to `path` in double precision, without authored normals and tangents. Joint names and parents also go
/// to the JSON beside it. Each file is written under a temporary name and renamed when complete, the JSON first. Equal
/// examples give equal bytes.
///
/// - `clips`: clips that cover the frames, or none. Times are saved if all clips share one rate; frame numbers are
///   saved if all clips have them.
///
/// # Errors
/// A file cannot be written; the error names the file.
pub fn save_npz(path: &Path, examples: &Examples, clips: &[Clip]) -> Result<(), Error> {
    let mut sidecar = json!({});
    if !examples.skeleton.is_still {
        sidecar["bone_names"] = json!(examples.skeleton.names);
        sidecar["bone_parents"] = json!(parent_numbers(examples));
    }
    if !examples.curve_names.is_empty() {
        sidecar["curve_names"] = json!(examples.curve_names);
    }
    replace(&path.with_extension("json"), |file| {
        let mut file = BufWriter::new(file);
        serde_json::to_writer_pretty(&mut file, &sidecar)?;
        file.write_all(b"\n")?;
        file.flush()
    })?;
    replace(path, |file| write(file, examples, clips))
}

fn write(file: &mut File, examples: &Examples, clips: &[Clip]) -> io::Result<()> {
    let (v, n) = (examples.vertex_len() as u64, examples.frame_len() as u64);
    let t = examples.triangles.len() as u64;
    let mut archive = Writer::new(file);
    archive.numbers("rest", &[v, 3], examples.rest.as_flattened().iter().copied())?;
    let corners = examples.triangles.as_flattened().iter().map(|&vertex| vertex as i64);
    archive.numbers("tris", &[t, 3], corners)?;
    if let Some(engine) = &examples.engine
        && let Some(uv) = &engine.uv
    {
        let len = uv.len() as u64;
        archive.numbers("uv", &[len, 2], uv.as_flattened().iter().copied())?;
        if !engine.is_one_each() {
            let corners = engine.triangles.as_flattened().iter().map(|&corner| corner as i64);
            archive.numbers("tris_uv", &[t, 3], corners)?;
        }
    }
    if !examples.skeleton.is_still {
        let j = examples.joint_len() as u64;
        archive.numbers("bone_parents", &[j], parent_numbers(examples).into_iter())?;
        archive.texts("bone_names", &examples.skeleton.names)?;
        archive.numbers("joint_world_rest", &[j, 4, 4], square(&examples.skeleton.rest))?;
        if let Some(weights) = &examples.joint_weights {
            archive.numbers("joint_weights", &[v, j], weights.iter().copied())?;
        }
        archive.numbers("bone_transforms", &[n, j, 4, 4], square(&examples.transforms))?;
    }
    if !examples.curve_names.is_empty() {
        let c = examples.curve_names.len() as u64;
        archive.texts("curve_names", &examples.curve_names)?;
        archive.numbers("curves", &[n, c], examples.curves.iter().copied())?;
    }
    archive.numbers("split", &[n], examples.split.iter().map(|&split| split as u8))?;
    write_clips(&mut archive, clips)?;
    let meshes = examples.ranges.iter().map(|(name, range)| (name, range.start));
    write_runs(&mut archive, &MESHES, meshes)?;
    if let Some(importance) = &examples.importance {
        archive.numbers("importance", &[v], importance.iter().copied())?;
    }
    if let Some(weights) = &examples.frame_weights {
        archive.numbers("frame_weights", &[n], weights.iter().copied())?;
    }
    let Space { up, forward, handedness, unit } = examples.space;
    for (array, axis) in [("up", up), ("forward", forward)] {
        if let Some(axis) = axis {
            archive.texts(array, &[axis.name().to_owned()])?;
        }
    }
    if handedness == Handedness::Left {
        archive.texts("handedness", &["left".to_owned()])?;
    }
    if let Some(metres) = unit {
        archive.numbers("unit", &[], [metres].into_iter())?;
    }
    archive.numbers("vertices", &[n, v, 3], examples.vertices.as_flattened().iter().copied())?;
    archive.finish()
}

fn write_clips(archive: &mut Writer<'_>, clips: &[Clip]) -> io::Result<()> {
    write_runs(archive, &CLIPS, clips.iter().map(|clip| (&clip.name, clip.first)))?;
    let numbers: Option<Vec<&Vec<i64>>> = clips.iter().map(|clip| clip.numbers.as_ref()).collect();
    if let Some(numbers) = numbers.filter(|numbers| !numbers.is_empty()) {
        let numbers: Vec<i64> = numbers.into_iter().flatten().copied().collect();
        archive.numbers("frame_numbers", &[numbers.len() as u64], numbers.into_iter())?;
    }
    match Clip::rate_of(clips) {
        Some(fps) => archive.numbers("fps", &[], [fps].into_iter()),
        None => Ok(()),
    }
}

fn write_runs<'a>(
    archive: &mut Writer<'_>,
    kind: &RunKind,
    runs: impl Iterator<Item = (&'a String, usize)>,
) -> io::Result<()> {
    let (names, starts): (Vec<String>, Vec<i64>) =
        runs.map(|(name, start)| (name.clone(), start as i64)).unzip();
    if names.is_empty() {
        return Ok(());
    }
    archive.texts(kind.names, &names)?;
    archive.numbers(kind.starts, &[starts.len() as u64], starts.into_iter())
}

fn square(maps: &[Matrix3x4]) -> impl Iterator<Item = f64> {
    maps.iter().flat_map(|map| map.iter().copied().chain([[0.0, 0.0, 0.0, 1.0]])).flatten()
}

/// Returns the number of each joint's parent in the source, J; -1 for none.
fn parent_numbers(examples: &Examples) -> Vec<i64> {
    let parents = examples.skeleton.own_parents().into_iter();
    parents.map(|parent| parent.map_or(-1, |parent| parent as i64)).collect()
}

fn replace(path: &Path, write: impl FnOnce(&mut File) -> io::Result<()>) -> Result<(), Error> {
    PendingFile::create(path)
        .and_then(|mut part| write(&mut part.file).and_then(|()| part.finish()))
        .map_err(|error| Error::write(error).in_file(path))
}
