//! Writing examples as NumPy arrays.

use std::fs::File;
use std::io::{self, BufWriter, Seek, Write};
use std::path::Path;

use npyz::npz::file_name_from_array_name;
use npyz::{AutoSerialize, DType, WriteOptions, WriterBuilder};
use zip::write::SimpleFileOptions;
use zip::{System, ZipWriter};

use crate::files::Part;

use super::sidecar::{Parent, Sidecar};
use super::{Examples, ExamplesError, LoadError, Matrix3x4, Split};

/// Writes examples to `path`, whole in double precision, and names and parents also to the JSON of
/// the same name. Each file is written beside its place and moved there when complete, the JSON
/// first. The same examples give the same bytes.
///
/// # Errors
/// A [`LoadError`] with the file that could not be written.
pub fn save_npz(path: &Path, examples: &Examples) -> Result<(), LoadError> {
    let skeleton = &examples.skeleton;
    let number = |parent: &Option<usize>| Some(Parent::Number(parent_number(*parent)));
    let sidecar = Sidecar {
        bone_names: Some(skeleton.names.clone()),
        bone_parents: Some(skeleton.parents.iter().map(number).collect()),
        ..Sidecar::default()
    };
    replace(&path.with_extension("json"), |file| {
        let mut file = BufWriter::new(file);
        serde_json::to_writer_pretty(&mut file, &sidecar)?;
        file.write_all(b"\n")?;
        file.flush()
    })?;
    replace(path, |file| write(file, examples))
}

fn write(file: &mut File, examples: &Examples) -> io::Result<()> {
    let [v, n, j, t] = [
        examples.vertex_len(),
        examples.frame_len(),
        examples.joint_len(),
        examples.triangles.len(),
    ]
    .map(|len| len as u64);
    let mut zip = ZipWriter::new(BufWriter::new(file));
    let skeleton = &examples.skeleton;
    array(&mut zip, "rest", &[v, 3], examples.rest.as_flattened().iter().copied())?;
    let corners = examples.triangles.as_flattened().iter().map(|&vertex| vertex as i64);
    array(&mut zip, "tris", &[t, 3], corners)?;
    if let Some(uv) = &examples.uv {
        array(&mut zip, "uv", &[v, 2], uv.as_flattened().iter().copied())?;
    }
    let parents = skeleton.parents.iter().map(|&parent| parent_number(parent));
    array(&mut zip, "bone_parents", &[j], parents)?;
    names(&mut zip, &skeleton.names)?;
    array(&mut zip, "joint_world_rest", &[j, 4, 4], square(&skeleton.rest))?;
    array(&mut zip, "split", &[n], examples.split.iter().map(|&split| code(split)))?;
    array(&mut zip, "bone_transforms", &[n, j, 4, 4], square(&examples.transforms))?;
    array(&mut zip, "vertices", &[n, v, 3], examples.vertices.as_flattened().iter().copied())?;
    zip.finish()?.flush()
}

/// Writes an array of numbers in C order, as many as fill `shape`.
pub(super) fn array<T: AutoSerialize>(
    zip: &mut ZipWriter<impl Write + Seek>,
    name: &str,
    shape: &[u64],
    numbers: impl Iterator<Item = T>,
) -> io::Result<()> {
    zip.start_file(file_name_from_array_name(name), OPTIONS)?;
    let mut array = WriteOptions::new().default_dtype().shape(shape).writer(zip).begin_nd()?;
    array.extend(numbers)?;
    array.finish()
}

fn names(zip: &mut ZipWriter<impl Write + Seek>, names: &[String]) -> io::Result<()> {
    let longest = names.iter().map(|name| name.chars().count()).max().unwrap_or(0).max(1);
    let invalid = |_| io::Error::from(io::ErrorKind::InvalidInput);
    let dtype = DType::Plain(format!("<U{longest}").parse().map_err(invalid)?);
    let shape = [names.len() as u64];
    zip.start_file(file_name_from_array_name("bone_names"), OPTIONS)?;
    let mut array = WriteOptions::<str>::new().dtype(dtype).shape(&shape).writer(zip).begin_nd()?;
    for name in names {
        array.push(name)?;
    }
    array.finish()
}

/// Compressed, able to pass 4 GB, and the same everywhere: dated 1980, and from one system.
const OPTIONS: SimpleFileOptions = SimpleFileOptions::DEFAULT.large_file(true).system(System::Unix);

fn square(maps: &[Matrix3x4]) -> impl Iterator<Item = f64> {
    maps.iter().flat_map(|map| map.iter().copied().chain([[0.0, 0.0, 0.0, 1.0]])).flatten()
}

fn parent_number(parent: Option<usize>) -> i64 {
    parent.map_or(-1, |parent| parent as i64)
}

fn code(split: Split) -> u8 {
    match split {
        Split::Train => 0,
        Split::HeldOut => 1,
        Split::Extreme => 2,
    }
}

fn replace(path: &Path, write: impl FnOnce(&mut File) -> io::Result<()>) -> Result<(), LoadError> {
    Part::create(path)
        .and_then(|mut part| write(part.file()).and_then(|()| part.finish()))
        .map_err(|error| LoadError { file: path.to_owned(), error: ExamplesError::Write(error) })
}
