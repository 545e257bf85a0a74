//! `sinew face train`: from shapes and a take to a face in a file.

use super::input::{self, TakeFile};
use crate::cli::files::{OutputFile, write};
use crate::cli::space::{self, StatedSpace};
use crate::cli::{Output, counted, printable};
use anyhow::{Context, bail};
use serde_json::json;
use sinew_runtime::Model;
use sinew_trainer::envelope::model::{FileModel, ShapeNumbers};
use sinew_trainer::face::baked::BakedFace;
use sinew_trainer::face::basis::Basis;
use sinew_trainer::face::outline;
use sinew_trainer::face::prior::is_moving;
use sinew_trainer::face::source::{self, Source};
use sinew_trainer::face::train::{HANDLES, Options, measure, of_meshes, of_take};
use std::path::PathBuf;

/// Learns how the expressions of a face go together
///
/// It learns from a take, and bakes the face with its prior into a file.
///
/// Beside FACE stands FACE.obj, the neutral mesh with its faces, texture coordinates and landmarks, which the runtime
/// does without and `pin` and `report` draw with.
#[derive(clap::Args)]
#[command(after_help = "\
A face is an .npz with neutral, expression_deltas, expression_names, quads or tris, and if there are any uv, uv_quads, \
identity_deltas and landmarks; a .glb, .gltf or .fbx with named shape keys; or a folder with neutral.obj and an .obj a \
shape. An .npz with meshes (N, V, 3) is a face without shapes: its principal components become shapes, and no take is \
needed. Columns of a take have the names of the shapes or those of ARKit: EyeBlinkLeft is eyeBlink_L and \
blendShape1.eyeBlink_L. Cells stand between commas, semicolons or tabs. Rows in which the tracking is lost are left \
out and counted.")]
pub(in crate::cli) struct Arguments {
    /// The face: .npz, .glb, .gltf, .fbx, or a folder of .obj files
    #[arg(long, value_name = "FACE")]
    basis: PathBuf,
    /// Weights of its shapes, frame by frame: .csv with a column a shape, or .npz with weights and names [default: none,
    /// and no weight knows of another]
    #[arg(long, value_name = "TAKE")]
    animation: Option<PathBuf>,
    /// 100 is a full shape in the take, and not 1
    #[arg(long, requires = "animation")]
    percent: bool,
    /// The file to write
    #[arg(short, long, value_name = "FACE")]
    out: PathBuf,
    /// Frames of the take to learn from, the first being 0 [default: all]
    #[arg(long, value_name = "A..B", value_parser = input::range)]
    frames: Option<[Option<usize>; 2]>,
    /// Bake an identity into the neutral face: its number and how much of it; may be given several times
    #[arg(long, value_name = "I=X", value_parser = identity, value_delimiter = ',', allow_hyphen_values = true)]
    identity: Vec<(usize, f64)>,
    /// How many shapes to find in example meshes [default: as many as keep 99.9 % of what moves]
    #[arg(long)]
    rank: Option<usize>,
    /// The length by which a pin may miss, in the face's unit [default: 0.0005 of its diagonal]
    #[arg(long, value_name = "LENGTH", value_parser = input::length)]
    tolerance: Option<f64>,
    /// What the file holds shapes in
    #[arg(long, value_enum, default_value = "f32")]
    numbers: NumbersName,
    /// Vertices at known places of the face, of which `eval` draws handles: .npy, .txt or .csv [default: landmarks of
    /// the .npz, or those of ICT-FaceKit beside it]
    #[arg(long, value_name = "FILE")]
    landmarks: Option<PathBuf>,
    #[command(flatten)]
    space: StatedSpace,
}

/// What a face was learned from, in words, and how many frames were lost.
struct Learned {
    text: String,
    lost: usize,
}

/// Types of numbers by name.
#[derive(Clone, Copy, Debug, clap::ValueEnum)]
enum NumbersName {
    F32,
    F16,
    I8,
}

pub(in crate::cli) fn run(arguments: &Arguments, output: Output) -> anyhow::Result<()> {
    let Arguments { basis: path, animation, out, .. } = arguments;
    let mut inputs = vec![path.clone()];
    inputs.extend(animation.iter().chain(&arguments.landmarks).cloned());
    let target = OutputFile::new(out, &inputs)?.of_a_model()?;
    let mesh = OutputFile::new(&outline::beside(out), &inputs)?;
    if target.is(&mesh) {
        bail!("cannot write {}: its mesh is to stand beside it under that name", out.display());
    }
    let about = || path.display().to_string();
    let options = Options {
        name: path.file_stem().unwrap_or_default().to_string_lossy().into_owned(),
        tolerance: arguments.tolerance,
        numbers: match arguments.numbers {
            NumbersName::F32 => ShapeNumbers::F32,
            NumbersName::F16 => ShapeNumbers::F16,
            NumbersName::I8 => ShapeNumbers::I8,
        },
    };
    let found = source::read(path).with_context(about)?;
    let (basis, model, learned) = match found {
        Source::Meshes(mut meshes) => {
            meshes.mesh.space =
                arguments.space.of(meshes.mesh.space, &path.display().to_string())?;
            refuse_for_meshes(arguments).with_context(about)?;
            let len = counted(meshes.positions.len(), "mesh", "meshes");
            let (mut basis, model) =
                of_meshes(&meshes, arguments.rank, &options).with_context(about)?;
            mark(&mut basis, arguments)?;
            (basis, model, Learned { text: format!("learned from {len}\n"), lost: 0 })
        }
        Source::Shapes(mut basis) => {
            if arguments.rank.is_some() {
                bail!(
                    "{}: it has shapes: --rank is for example meshes, of which shapes are found",
                    about()
                );
            }
            basis.mesh.space = arguments.space.of(basis.mesh.space, &path.display().to_string())?;
            for &(identity, by) in &arguments.identity {
                basis.apply_identity(identity, by).with_context(about)?;
            }
            mark(&mut basis, arguments)?;
            let (model, learned) = of_shapes(&basis, arguments, &options, output)?;
            (basis, model, learned)
        }
    };
    for warning in &basis.mesh.warnings {
        output.warn(about(), printable(&warning.to_string()));
    }
    // Numbers of the face or of the take may be too large for a file.
    let both =
        || animation.iter().fold(about(), |face, take| format!("{face} with {}", take.display()));
    let bytes = model.bake().with_context(both)?;
    let text = outline::text(&basis);
    write(&[(&mesh, text.as_bytes()), (&target, &bytes)])?;
    print(&bytes, &basis, &learned, [&target, &mesh], output)
}

fn print(
    bytes: &[u8],
    basis: &Basis,
    learned: &Learned,
    [target, mesh]: [&OutputFile; 2],
    output: Output,
) -> anyhow::Result<()> {
    let model = Model::from_bytes(bytes)?;
    let face = BakedFace::open(&model)?;
    let (fit, counts) = (face.prior.fit(), face.prior.counts());
    let (vertices, shapes) = (basis.vertex_len(), basis.mesh.shapes.len());
    let tolerance = f64::from(fit.beta).sqrt();
    let json = json!({
        "vertices": vertices,
        "shapes": shapes,
        "landmarks": basis.landmarks.len(),
        "frames": fit.frames,
        "lost_frames": learned.lost,
        "tolerance": tolerance,
        "error": fit.error,
        "slider_error": fit.slider_error,
        "mirrored_pairs": counts.symmetry_len,
        "cancelling_pairs": counts.cancel_len,
        "space": space::as_json(&model.space()),
        "bytes": bytes.len(),
        "mesh": mesh.named().display().to_string(),
    });
    let reached = match fit.error > 0.0 {
        true => format!(
            "{HANDLES} landmarks leave {:.3e} on the last quarter, learned from the rest; the slider norm {:.3e}\n",
            fit.error, fit.slider_error
        ),
        false => String::new(),
    };
    let text = format!(
        "{}: {}, {}, {}\n{}{reached}pins hold to {tolerance:.3e}; {} mirrored, {} cancelling\n\
         wrote {} ({} bytes) and {}\n",
        printable(face.skin.name()),
        counted(vertices, "vertex", "vertices"),
        counted(shapes, "shape", "shapes"),
        counted(basis.landmarks.len(), "landmark", "landmarks"),
        learned.text,
        counted(counts.symmetry_len as usize, "pair of shapes is", "pairs of shapes are"),
        counted(counts.cancel_len as usize, "pair is", "pairs are"),
        target.named().display(),
        bytes.len(),
        mesh.named().display(),
    );
    output.print(&json, &text)
}

/// Learns from the take, where there is one; else no weight knows of another.
fn of_shapes(
    basis: &Basis,
    arguments: &Arguments,
    options: &Options,
    output: Output,
) -> anyhow::Result<(FileModel, Learned)> {
    let about = || arguments.basis.display().to_string();
    let Some(path) = &arguments.animation else {
        if arguments.frames.is_some() {
            bail!("--frames is of a take: give --animation");
        }
        let text = "learned from no take: no weight knows of another\n".to_owned();
        let model = of_take(basis, &[], options).with_context(about)?;
        return Ok((model, Learned { text, lost: 0 }));
    };
    let file = TakeFile { path, is_percent: arguments.percent };
    let take = input::take(file, &basis.names(), output)?;
    let range = input::within(arguments.frames, take.file_len());
    let frames = take.pick(&range, 0, 1).with_context(|| path.display().to_string())?;
    let frames: Vec<Vec<f64>> = frames.iter().map(|frame| frame.to_vec()).collect();
    let lost = range.len() - frames.len();
    let driven =
        (0..basis.mesh.shapes.len()).filter(|&s| frames.iter().any(|f| f[s] != 0.0)).count();
    let mut text = format!(
        "learned from {} of {}, which move {}\n",
        counted(frames.len(), "frame", "frames"),
        path.display(),
        counted(driven, "shape", "shapes"),
    );
    if lost > 0 {
        text += &format!(
            "left out {} in which the tracking is lost\n",
            counted(lost, "frame", "frames")
        );
    }
    if !is_moving(&frames) {
        let frames = counted(frames.len(), "frame", "frames");
        output.warn(
            path.display(),
            format!("weights do not change in {frames}: only their mean is learned"),
        );
    }
    let mut model = of_take(basis, &frames, options).with_context(about)?;
    measure(&mut model, basis, &frames, options)?;
    Ok((model, Learned { text, lost }))
}

/// Sets the landmarks that were given.
fn mark(basis: &mut Basis, arguments: &Arguments) -> anyhow::Result<()> {
    let Some(path) = &arguments.landmarks else { return Ok(()) };
    basis.read_landmarks(path).with_context(|| path.display().to_string())
}

/// Refuses what example meshes cannot have.
fn refuse_for_meshes(arguments: &Arguments) -> anyhow::Result<()> {
    let given = [
        ("--animation", arguments.animation.is_some()),
        ("--frames", arguments.frames.is_some()),
        ("--identity", !arguments.identity.is_empty()),
    ];
    match given.into_iter().find(|(_, given)| *given) {
        Some((option, _)) => {
            bail!("it has meshes without shapes: {option} is for a face that has some")
        }
        None => Ok(()),
    }
}

/// Parses an identity's number and how much of it.
fn identity(text: &str) -> Result<(usize, f64), String> {
    let pair = text
        .split_once('=')
        .and_then(|(identity, by)| Some((identity.trim().parse().ok()?, by.trim().parse().ok()?)));
    pair.filter(|(_, by): &(usize, f64)| by.is_finite())
        .ok_or_else(|| "expected I=X, the number of an identity and how much of it".to_owned())
}
