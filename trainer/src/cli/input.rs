//! Examples and models as the command line names them.

use super::Output;
use super::bars::Bars;
use anyhow::{Context, bail};
use sinew_runtime::Model;
use sinew_trainer::examples::{
    self, Clip, Examples, ExamplesError, LoadError, Loaded, Source, Split, hash_file, load,
    load_importance,
};
use sinew_trainer::formats::Content;
use std::path::{Path, PathBuf};

/// Example poses to read.
#[derive(clap::Args)]
pub(super) struct ExampleArguments {
    /// Example poses: a scene with mesh, skeleton and clips (.glb, .gltf, .fbx), or a .npz with
    /// everything, its names and parents in it or in a .json beside it
    pub(super) examples: PathBuf,
    /// The posed meshes of a scene, one a frame of its clips and with the vertices of its mesh, split
    /// along seams or not: Alembic (.abc), a point cache (.pc2, .mdd), a folder of numbered .obj files or one of them, the
    /// `vertices` of a .npz, in any order where it has `rest`, or the morph targets of a .glb [default: the scene's own skin and shapes]
    #[arg(long, value_name = "FILE")]
    pub(super) targets: Option<PathBuf>,
    /// Frames a second at which the clips of a scene are sampled [default: at their keys]
    #[arg(long, value_name = "FPS", value_parser = rate, allow_negative_numbers = true)]
    pub(super) fps: Option<f64>,
    /// The one clip of a scene to read [default: all]
    #[arg(long, value_name = "NAME")]
    pub(super) clip: Option<String>,
    /// How much each vertex counts, in a fit and in what is measured: one number a vertex, as .npy,
    /// .txt or .csv [default: all alike]
    #[arg(long, value_name = "FILE")]
    pub(super) importance: Option<PathBuf>,
    /// Hold out this share of the frames (0.25 is a quarter), in contiguous blocks, instead of the
    /// file's own split; give `train`, `eval` and `report` the same
    #[arg(long, value_name = "SHARE", value_parser = share, allow_negative_numbers = true)]
    pub(super) hold_out: Option<f64>,
    /// Hold out the frames of this clip; may be given several times
    #[arg(long, value_name = "NAME", conflicts_with = "hold_out")]
    pub(super) hold_out_clip: Vec<String>,
}

/// Examples as they were read.
pub(super) struct LoadedInput {
    pub(super) examples: Examples,
    /// The clips that its frames come from.
    pub(super) clips: Vec<Clip>,
    /// What was told about them.
    pub(super) warnings: Vec<String>,
}

/// A file that is read, for the record.
#[derive(serde::Serialize)]
pub(super) struct InputFile {
    file: String,
    sha256: String,
}

impl ExampleArguments {
    /// Loads the examples and tells on standard error what should be known about them.
    pub(super) fn load(&self, output: Output) -> anyhow::Result<LoadedInput> {
        let mut input = read(self.source(), output, load)?;
        let examples = &mut input.examples;
        if let Some(file) = &self.importance {
            let numbers = load_importance(file)?;
            examples.weigh(numbers).with_context(|| file.display().to_string())?;
        }
        if let Some(share) = self.hold_out {
            examples.hold_out(share).with_context(|| self.examples.display().to_string())?;
        }
        examples
            .hold_out_clips(&input.clips, &self.hold_out_clip)
            .with_context(|| self.examples.display().to_string())?;
        Ok(input)
    }

    /// Hashes every file that a load reads.
    pub(super) fn hashes(&self) -> anyhow::Result<Vec<InputFile>> {
        check(&self.examples)?;
        self.files().iter().filter(|file| file.exists()).map(|file| hash(file)).collect()
    }

    /// Names every file that a load reads, where it is there.
    pub(super) fn files(&self) -> Vec<PathBuf> {
        let mut files = self.source().files();
        files.extend(self.importance.clone());
        files
    }

    fn source(&self) -> Source<'_> {
        Source {
            file: &self.examples,
            targets: self.targets.as_deref(),
            fps: self.fps,
            clip: self.clip.as_deref(),
        }
    }
}

/// Hashes a file that is read.
pub(super) fn hash(file: &Path) -> anyhow::Result<InputFile> {
    let sha256 = hash_file(file).with_context(|| file.display().to_string())?;
    let name = file.file_name().unwrap_or_default().to_string_lossy().into_owned();
    Ok(InputFile { file: name, sha256 })
}

/// Moves examples into the space of a model, as far as both are known, and leaves seams out that its skin, the
/// first where no name is given, does not have. A model that cannot be loaded is left to who measures it.
pub(super) fn convert_to_model(examples: &mut Examples, model: &[u8], skin: Option<&str>) {
    let Ok(model) = Model::from_bytes(model) else { return };
    examples.convert_to(&model.space());
    if let Some(skin) = skin.map_or_else(|| model.skin(), |name| model.skin_named(name)) {
        examples.unsplit_for(skin.vertex_len());
    }
}

/// Loads a file for its poses.
pub(super) fn load_poses(file: &Path, output: Output) -> anyhow::Result<LoadedInput> {
    read(Source::file(file), output, examples::load_poses)
}

/// Moves poses from a file to where their rest mesh is this one.
pub(super) fn move_to(
    input: &mut LoadedInput,
    file: &Path,
    rest: &[[f64; 3]],
    output: Output,
) -> anyhow::Result<()> {
    let moved = input.examples.move_to(rest).with_context(|| file.display().to_string())?;
    if let Some(warning) = moved {
        output.warn(file.display(), warning);
    }
    Ok(())
}

/// Loads examples and tells what should be known about them.
fn read(
    source: Source<'_>,
    output: Output,
    load: impl Fn(&Source<'_>) -> Result<Loaded, LoadError>,
) -> anyhow::Result<LoadedInput> {
    check(source.file)?;
    let reading = Bars::busy(output, "reading examples");
    let Loaded { examples, clips, warnings } = load(&source)?;
    drop(reading);
    let warnings: Vec<String> = warnings.iter().map(ToString::to_string).collect();
    for warning in &warnings {
        output.warn(source.file.display(), warning);
    }
    Ok(LoadedInput { examples, clips, warnings })
}

/// Refuses what is easily given by mistake.
fn check(examples: &Path) -> anyhow::Result<()> {
    let path = examples.display();
    if examples.is_dir() {
        bail!("{path}: is a folder, expected a file");
    }
    if examples.extension().is_some_and(|extension| extension == "json") {
        bail!("{path}: describes examples, expected the .npz file beside it");
    }
    Ok(())
}

/// Parses a number of frames a second.
fn rate(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(rate) if (0.001..=10_000.0).contains(&rate) => Ok(rate),
        _ => Err("expected a number from 0.001 to 10000".to_owned()),
    }
}

/// Parses a share of the frames.
fn share(text: &str) -> Result<f64, String> {
    let share: f64 = text.parse().map_err(|_| "expected a number".to_owned())?;
    if share > 0.0 && share < 1.0 {
        return Ok(share);
    }
    Err(ExamplesError::BadShare { share }.to_string())
}

/// Describes the examples in a line.
pub(super) fn describe(examples: &Examples) -> String {
    let (vertices, engine) = (examples.vertex_len(), examples.surface().engine_len());
    let split = if engine == vertices { String::new() } else { format!(" ({engine} in engines)") };
    format!(
        "{vertices} vertices{split}, {} triangles, {} joints; {}",
        examples.triangles.len(),
        examples.joint_len(),
        describe_frames(examples)
    )
}

/// Counts the frames by use.
pub(super) fn describe_frames(examples: &Examples) -> String {
    let count = |split| examples.frames_of(split).len();
    format!(
        "{} training, {} held-out, {} extreme frames",
        count(Split::Train),
        count(Split::HeldOut),
        count(Split::Extreme),
    )
}

/// Reads a model file.
pub(super) fn read_model(path: &Path) -> anyhow::Result<Vec<u8>> {
    let cannot_read = || format!("cannot read {}", path.display());
    let kind = std::fs::metadata(path).with_context(cannot_read)?;
    if !kind.is_file() {
        // A device may never end.
        bail!("{}: it is {}", cannot_read(), if kind.is_dir() { "a folder" } else { "no file" });
    }
    let bytes = std::fs::read(path).with_context(cannot_read)?;
    match Content::of(&bytes) {
        Some(Content::Examples(ending)) => bail!(
            "{}: holds what a .{ending} file holds, expected a model, which commands take first",
            path.display()
        ),
        _ if bytes.is_empty() => {
            bail!("{}: the model is refused: the file is empty", path.display())
        }
        _ => Ok(bytes),
    }
}
