//! Examples and models: arguments, and reading of their files.

use super::arguments::number;
use super::output::Bars;
use super::{OfFile, Output};
use crate::Error;
use crate::examples::{
    self, Curves, Examples, Loaded, RATES, Source, Split, Warning, check_share, hash_file, load,
    load_importance,
};
use anyhow::{Context, bail};
use serde_json::{Value, json};
use sinew_runtime::{Model, Skin};
use std::path::{Path, PathBuf};

/// Example poses to read.
#[derive(clap::Args)]
#[command(next_help_heading = "Examples")]
pub(super) struct ExampleArguments {
    /// Example poses: a scene with mesh, skeleton and clips (.glb, .gltf, .fbx), or a .npz
    ///
    /// Names and parents of a .npz are in the file or in a .json beside it. The frames of several files follow one
    /// another, in the axes and unit of the first; all files are of one character, and their clips are named FILE:CLIP.
    #[arg(required = true, num_args = 1.., help_heading = None::<&str>)]
    pub(super) examples: Vec<PathBuf>,
    /// Posed meshes of a scene, one for each frame of its clips [default: the scene's own skin and shapes]
    ///
    /// Vertices are those of the scene's mesh, split along seams or not. Formats: Alembic (.abc), a point cache (.pc2,
    /// .mdd), a folder of numbered .obj files or one of them, the `vertices` of a .npz, or a .glb. Vertices of a .npz
    /// with `rest` may have any order, and so may vertices of a .glb, which plays its skin and morph targets.
    ///
    /// For several scenes, once for each in order. If --clip names clips, the file may hold those of all clips.
    #[arg(long, value_name = "FILE")]
    pub(super) targets: Vec<PathBuf>,
    /// Frames a second at which clips of a scene are sampled [default: at their keys]
    #[arg(long, value_name = "FPS", value_parser = number(RATES, " frames a second"), allow_negative_numbers = true)]
    pub(super) fps: Option<f64>,
    /// Clip to read, of a scene or of a .npz that names its clips; repeatable [default: all]
    #[arg(long, value_name = "NAME")]
    pub(super) clip: Vec<String>,
    /// Curve that may move the skin beside the joints; repeatable [default: see --curves]
    #[arg(long, value_name = "NAME", conflicts_with = "curves")]
    pub(super) curve: Vec<String>,
    /// Curves that may move the skin beside the joints [default: all of a .npz or of --curves-from, none of a scene]
    ///
    /// Curves of a scene are the weights of its named morph targets (glTF) or blendshapes (FBX).
    #[arg(long, value_name = "CURVES")]
    pub(super) curves: Option<CurveChoice>,
    /// Curves of a scene: a .csv with a line of names and a row for each frame, as Live Link Face writes it
    ///
    /// With a column `time`, in seconds, the rows are interpolated at the frames. For several scenes, once for each in
    /// order.
    #[arg(long, value_name = "FILE")]
    pub(super) curves_from: Vec<PathBuf>,
    /// Weight of each vertex in fits and errors: one number a vertex (.npy, .txt, .csv) [default: from a .npz, else
    /// equal]
    ///
    /// For several files, once for all or once for each in order.
    #[arg(long, value_name = "FILE")]
    pub(super) importance: Vec<PathBuf>,
    /// Hold out this share of the frames (0.25 is a quarter), in blocks, in place of the file's split
    ///
    /// `train`, `eval` and `report` need the same share.
    #[arg(long, value_name = "SHARE", value_parser = share, allow_negative_numbers = true)]
    pub(super) hold_out: Option<f64>,
    /// Hold out the frames of this clip, NAME or FILE:NAME; repeatable
    #[arg(long, value_name = "NAME", conflicts_with = "hold_out")]
    pub(super) hold_out_clip: Vec<String>,
}

/// Choice of all curves or none.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(super) enum CurveChoice {
    /// Every curve.
    All,
    /// No curve: joints alone.
    None,
}

impl ExampleArguments {
    /// Loads examples, and prints some of the warnings.
    pub(super) fn load(
        &self,
        output: Output,
        is_printed: fn(&Warning) -> bool,
    ) -> anyhow::Result<Loaded> {
        let (mut files, mut found) = (Vec::new(), Vec::new());
        let (len, given) = (self.examples.len(), self.importance.len());
        if given > 1 && given != len {
            bail!(
                "--importance: expected one for all files or one for each of {len}, found {given}"
            );
        }
        for (number, source) in self.sources()?.iter().enumerate() {
            let loaded = read(*source, output, load);
            // Warnings about earlier files may explain why a file is refused.
            let mut input = loaded.inspect_err(|_| print_all(&found, is_printed, output))?;
            join_warnings(&mut found, source.file, input.warnings);
            if let Some(file) = self.importance.get(if given > 1 { number } else { 0 }) {
                input.examples.set_importance(load_importance(file)?).of(file)?;
            }
            files.push((source.file.to_owned(), input.examples, input.clips));
        }
        print_all(&found, is_printed, output);
        let mut warnings: Vec<Warning> = found.into_iter().map(|(warning, _)| warning).collect();
        let (mut examples, clips) = examples::join(files)?;
        if let Some(share) = self.hold_out {
            let rounded = examples.hold_out(share).with_context(|| self.named())?;
            rounded.iter().for_each(|warning| output.report(self.named(), warning));
            warnings.extend(rounded);
        }
        examples.hold_out_clips(&clips, &self.hold_out_clip).with_context(|| self.named())?;
        Ok(Loaded { examples, clips, warnings })
    }

    /// Returns the choice of curves.
    fn chosen_curves(&self) -> Curves<'_> {
        match self.curves {
            Some(CurveChoice::All) => Curves::All,
            Some(CurveChoice::None) => Curves::None,
            None if self.curve.is_empty() => Curves::Usual,
            None => Curves::Named(&self.curve),
        }
    }

    /// Hashes every file that is read.
    pub(super) fn hashes(&self) -> anyhow::Result<Vec<Value>> {
        self.examples.iter().try_for_each(|file| check(file))?;
        self.files().iter().filter(|file| file.exists()).map(|file| hash(file)).collect()
    }

    /// Returns the paths of all files to read, whether they exist or not.
    pub(super) fn files(&self) -> Vec<PathBuf> {
        let sources = self.sources().unwrap_or_default();
        let mut files: Vec<PathBuf> = sources.iter().flat_map(Source::files).collect();
        files.extend_from_slice(&self.importance);
        files
    }

    /// Names all examples, for messages.
    pub(super) fn named(&self) -> String {
        let names: Vec<String> =
            self.examples.iter().map(|file| file.display().to_string()).collect();
        names.join(", ")
    }

    /// Returns the source of each set of examples.
    fn sources(&self) -> anyhow::Result<Vec<Source<'_>>> {
        let is_scene = |file: &Path| file.extension().is_none_or(|ending| ending != "npz");
        let scenes = self.examples.iter().filter(|file| is_scene(file)).count();
        let several = self.examples.len() > 1;
        let given = [("--targets", &self.targets), ("--curves-from", &self.curves_from)];
        for (option, files) in given {
            let found = files.len();
            if several && found > 0 && found != scenes {
                bail!("{option}: expected one for each scene in order: {scenes}, found {found}");
            }
            if let ([_], [_, second, ..]) = (&self.examples[..], &files[..]) {
                let second = second.display();
                bail!("{option} {second}: there is one file of examples, which has its own");
            }
        }
        let [mut targets, mut tables] =
            [&self.targets, &self.curves_from].map(|files| files.iter().peekable());
        let mut sources = Vec::new();
        for file in &self.examples {
            let has_own = !several || is_scene(file);
            let [targets, curves_from] = [&mut targets, &mut tables]
                .map(|files| files.next_if(|_| has_own).map(PathBuf::as_path));
            let (fps, clips, curves) = (self.fps, &self.clip[..], self.chosen_curves());
            let source = Source { targets, fps, clips, curves, curves_from, ..Source::file(file) };
            sources.push(source);
        }
        Ok(sources)
    }
}

/// Hashes an input file, for the record of a training.
pub(super) fn hash(file: &Path) -> anyhow::Result<Value> {
    let sha256 = hash_file(file).of(file)?;
    let name = file.file_name().unwrap_or_default().to_string_lossy();
    Ok(json!({ "file": name, "sha256": sha256 }))
}

/// Converts examples to the space of a model if both are known, and removes seams that the model's skin lacks.
///
/// Examples without a unit take the model's unit; if that is wrong, their rest mesh is refused later. A model that
/// cannot be loaded is refused by the measurement.
///
/// - `skin`: name of the skin; `None` for the model's first.
pub(super) fn convert_to_model(examples: &mut Examples, model: &[u8], skin: Option<&str>) {
    let Ok(model) = Model::from_bytes(model) else { return };
    examples.convert_to(&model.space());
    examples.space.unit = examples.space.unit.or(model.space().unit);
    if let Some(skin) = skin.map_or_else(|| model.first::<Skin>(), |name| model.named::<Skin>(name))
    {
        examples.unsplit_for(skin.vertex_len());
    }
}

/// Loads a file for its poses.
///
/// - `mesh`: file with the mesh of the character, if `source` has none.
pub(super) fn load_motion(
    source: Source<'_>,
    mesh: Option<&Path>,
    output: Output,
) -> anyhow::Result<Loaded> {
    let input = read(source, output, |source| examples::load_motion(source, mesh))?;
    input.warnings.iter().for_each(|warning| output.report(source.file.display(), warning));
    Ok(input)
}

/// Moves poses of a file so that their rest mesh coincides with `rest`.
pub(super) fn move_to(
    input: &mut Loaded,
    file: &Path,
    rest: &[[f64; 3]],
    output: Output,
) -> anyhow::Result<()> {
    if let Some(warning) = input.examples.move_to(rest).of(file)? {
        output.report(file.display(), &warning);
    }
    Ok(())
}

/// Loads examples by `load`.
fn read(
    source: Source<'_>,
    output: Output,
    load: impl Fn(&Source<'_>) -> Result<Loaded, Error>,
) -> anyhow::Result<Loaded> {
    check(source.file)?;
    let _reading = Bars::busy(output, "reading examples");
    Ok(load(&source)?)
}

/// Adds the warnings of a file to those of other files. Each warning occurs once, with the names of its files.
fn join_warnings(all: &mut Vec<(Warning, Vec<String>)>, file: &Path, warnings: Vec<Warning>) {
    let name = file.display().to_string();
    for warning in warnings {
        match all.iter_mut().find(|(other, _)| *other == warning) {
            Some((_, names)) if names.contains(&name) => {}
            Some((_, names)) => names.push(name.clone()),
            None => all.push((warning, vec![name.clone()])),
        }
    }
}

/// Prints warnings, each with the names of its files.
fn print_all(all: &[(Warning, Vec<String>)], is_printed: fn(&Warning) -> bool, output: Output) {
    for (warning, names) in all.iter().filter(|(warning, _)| is_printed(warning)) {
        output.report(names.join(", "), warning);
    }
}

/// Refuses folders and .json files, which are easily given by mistake.
fn check(examples: &Path) -> anyhow::Result<()> {
    let path = examples.display();
    if examples.is_dir() {
        bail!("{path}: is a folder, expected a file");
    }
    if examples.extension().is_some_and(|extension| extension == "json") {
        if !examples.exists() {
            bail!("{path}: there is no such file; --json prints its results and takes no name");
        }
        bail!("{path}: describes examples, expected the .npz file beside it");
    }
    Ok(())
}

/// Parses a share of the frames.
fn share(text: &str) -> Result<f64, String> {
    let share: f64 = text.parse().map_err(|_| "expected a number".to_owned())?;
    check_share(share).map_err(|error| error.to_string())?;
    Ok(share)
}

/// Describes examples in a line.
pub(super) fn describe(examples: &Examples) -> String {
    let (vertices, engine) = (examples.vertex_len(), examples.surface().engine_len());
    let split = if engine == vertices { String::new() } else { format!(" ({engine} in engines)") };
    format!(
        "{vertices} vertices{split}, {} triangles, {}; {}",
        examples.triangles.len(),
        examples.pose_size(),
        describe_frames(examples)
    )
}

/// Counts frames by use.
pub(super) fn describe_frames(examples: &Examples) -> String {
    let count = |split| examples.frames_of(split).len();
    let [train, held_out, extreme] = [Split::Train, Split::HeldOut, Split::Extreme].map(count);
    format!("{train} training, {held_out} held-out, {extreme} extreme frames")
}
