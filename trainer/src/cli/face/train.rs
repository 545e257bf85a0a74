//! `sinew face train`: from shapes and a take to a face in a file.

use super::input;
use crate::cli::files::write;
use crate::cli::{
    OfFile, Output, OutputFile, POSITIVE, Report, Run, StatedSpace, counted, named, number,
    printable, space_as_json,
};
use crate::envelope::model::{FileModel, ShapeNumbers};
use crate::face::baked::BakedFace;
use crate::face::basis::Basis;
use crate::face::outline;
use crate::face::prior::is_moving;
use crate::face::source::{self, Source};
use crate::face::train::{HANDLES, Options, measure, of_meshes, of_take};
use anyhow::{Context, bail};
use sinew_runtime::Model;
use std::path::PathBuf;

/// Learns which expressions of a face go together
///
/// The command learns from a take, and bakes the face with its prior into a file.
///
/// MODEL.obj is written beside MODEL: the neutral mesh with its faces, texture coordinates and landmarks. The runtime
/// does not need this mesh; `pin` and `report` draw it.
#[derive(clap::Args)]
#[command(after_help = "\
A face is an .npz with neutral, expression_deltas, expression_names, quads or tris, and optionally uv, uv_quads, \
identity_deltas and landmarks; a .glb, .gltf or .fbx with named shape keys; or a folder with neutral.obj and an .obj for \
each shape. An .npz with meshes (N, V, 3) is a face without shapes: its principal components become shapes, and no take \
is needed. Columns of a take have the names of the shapes or of ARKit: EyeBlinkLeft is eyeBlink_L and \
blendShape1.eyeBlink_L. Cells are separated by commas, semicolons or tabs. Rows without tracking are left out and \
counted.\n\nExample:\n  sinew face train --basis head.npz --animation take.csv -o head.sinew")]
pub(in crate::cli) struct Train {
    /// Face: .npz, .glb, .gltf, .fbx, or a folder of .obj files
    #[arg(long, value_name = "FACE")]
    basis: PathBuf,
    /// File to write
    #[arg(short, long, alias = "out", value_name = "MODEL")]
    output: PathBuf,
    /// Baked numbers of the shapes
    #[arg(long, value_parser = named(NUMBERS), default_value = "f32")]
    numbers: ShapeNumbers,
    /// Length by which a pin may miss, in the face's unit [default: 0.0005 of its diagonal]
    #[arg(long, value_name = "LENGTH", value_parser = number(POSITIVE, ""))]
    tolerance: Option<f64>,
    #[command(flatten)]
    take: TakeArgs,
    #[command(flatten)]
    shape: ShapeArgs,
    #[command(flatten)]
    space: StatedSpace,
}

/// Take to learn from.
#[derive(clap::Args)]
#[command(next_help_heading = "Take")]
struct TakeArgs {
    /// Weights of the shapes, frame by frame: .csv with a column for each shape, or .npz with weights and names
    /// [default: none, and weights are independent]
    #[arg(long, value_name = "TAKE")]
    animation: Option<PathBuf>,
    /// 100 is a full shape in the take, and not 1
    #[arg(long, requires = "animation")]
    percent: bool,
    /// Frames of the take to learn from; the first is 0 [default: all]
    #[arg(long, value_name = "A..B", value_parser = input::range)]
    frames: Option<[Option<usize>; 2]>,
}

/// Shapes and landmarks of the face.
#[derive(clap::Args)]
#[command(next_help_heading = "Shapes")]
struct ShapeArgs {
    /// Bake an identity into the neutral face: its number and weight; repeatable
    #[arg(long, value_name = "I=X", value_parser = identity, value_delimiter = ',', allow_hyphen_values = true)]
    identity: Vec<(usize, f64)>,
    /// Number of shapes to find in example meshes [default: enough for 99.9 % of the motion]
    #[arg(long)]
    rank: Option<usize>,
    /// Vertices at known places of the face, from which `eval` draws handles: .npy, .txt or .csv [default: landmarks of
    /// the .npz, or of ICT-FaceKit in its folder]
    #[arg(long, value_name = "FILE")]
    landmarks: Option<PathBuf>,
}

/// Training data in words, and the number of frames without tracking.
struct Learned {
    text: String,
    lost: usize,
}

/// Types of baked numbers.
const NUMBERS: [(&str, ShapeNumbers); 3] =
    [("f32", ShapeNumbers::F32), ("f16", ShapeNumbers::F16), ("i8", ShapeNumbers::I8)];

impl Run for Train {
    fn run(&self, output: Output) -> anyhow::Result<Report> {
        let (path, animation) = (&self.basis, &self.take.animation);
        let mut inputs = vec![path.clone()];
        inputs.extend(animation.iter().chain(&self.shape.landmarks).cloned());
        let target = OutputFile::new(&self.output, &inputs)?.of_a_model()?;
        let mesh = OutputFile::new(&outline::beside(&self.output), &inputs)?;
        if target.is(&mesh) {
            let out = self.output.display();
            bail!("cannot write {out}: its mesh is to be written under that name");
        }
        let options = Options {
            name: path.file_stem().unwrap_or_default().to_string_lossy().into_owned(),
            tolerance: self.tolerance,
            numbers: self.numbers,
        };
        let (basis, model, learned) = match source::read(path).of(path)? {
            Source::Meshes(mut meshes) => {
                meshes.mesh.space = self.space.of(meshes.mesh.space, path.display())?;
                self.refuse_for_meshes().of(path)?;
                let len = counted(meshes.positions.len(), "mesh", "meshes");
                let (mut basis, model) = of_meshes(&meshes, self.shape.rank, &options).of(path)?;
                self.set_landmarks(&mut basis)?;
                (basis, model, Learned { text: format!("from {len}"), lost: 0 })
            }
            Source::Shapes(mut basis) => {
                if self.shape.rank.is_some() {
                    let path = path.display();
                    bail!(
                        "{path}: it has shapes: --rank is for example meshes, in which shapes are found"
                    );
                }
                basis.mesh.space = self.space.of(basis.mesh.space, path.display())?;
                for &(identity, by) in &self.shape.identity {
                    basis.apply_identity(identity, by).of(path)?;
                }
                self.set_landmarks(&mut basis)?;
                let (model, learned) = self.of_shapes(&basis, &options, output)?;
                (basis, model, learned)
            }
        };
        for warning in &basis.mesh.warnings {
            output.warn(path.display(), printable(&warning.to_string()));
        }
        // Numbers of the face or of the take may be too large for a file.
        let both = || {
            let takes = animation.iter().map(|take| format!(" with {}", take.display()));
            format!("{}{}", path.display(), takes.collect::<String>())
        };
        let bytes = model.bake().with_context(both)?;
        write(&[(&mesh, outline::text(&basis).as_bytes()), (&target, &bytes)])?;
        let report = report(&bytes, &basis, &learned)?;
        let mesh = mesh.named.display().to_string();
        let text = format!("wrote {mesh}, its mesh");
        Ok(report.wrote(&target, &bytes).shown("mesh", "", mesh, text))
    }
}

/// Reports a baked face.
fn report(bytes: &[u8], basis: &Basis, learned: &Learned) -> anyhow::Result<Report> {
    let model = Model::from_bytes(bytes)?;
    let face = BakedFace::open(&model)?;
    let (fit, counts) = (face.prior.fit(), face.prior.counts());
    let report = Report::default()
        .figure("name", "face", face.skin.name(), "")
        .figure("vertices", "vertices", basis.vertex_len(), "")
        .figure("shapes", "shapes", basis.mesh.shapes.len(), "")
        .figure("landmarks", "landmarks", basis.landmarks.len(), "")
        .shown("frames", "learned", fit.frames, &learned.text)
        .figure("lost_frames", "frames without tracking", learned.lost, "");
    let report = match fit.error > 0.0 {
        true => report
            .text(format!("{HANDLES} landmarks, last quarter of the take, learned from the rest:"))
            .figure("error", "error of the prior", fit.error, "units")
            .figure("slider_error", "error of the slider norm", fit.slider_error, "units"),
        false => report.json("error", fit.error).json("slider_error", fit.slider_error),
    };
    Ok(report
        .figure("tolerance", "tolerance of pins", f64::from(fit.beta).sqrt(), "units")
        .figure("mirrored_pairs", "mirrored pairs of shapes", counts.symmetry_len, "")
        .figure("cancelling_pairs", "cancelling pairs of shapes", counts.cancel_len, "")
        .json("space", space_as_json(&model.space())))
}

impl Train {
    /// Learns from the take. Without a take, weights are independent.
    fn of_shapes(
        &self,
        basis: &Basis,
        options: &Options,
        output: Output,
    ) -> anyhow::Result<(FileModel, Learned)> {
        let Some(path) = &self.take.animation else {
            if self.take.frames.is_some() {
                bail!("--frames is of a take: give --animation");
            }
            let text = "from no take: weights are independent".to_owned();
            let model = of_take(basis, &[], options).of(&self.basis)?;
            return Ok((model, Learned { text, lost: 0 }));
        };
        let take = input::take(path, self.take.percent, &basis.names(), output)?;
        let range = input::within(self.take.frames, take.file_len());
        let frames = take.pick(&range, 0, 1).of(path)?;
        let frames: Vec<Vec<f64>> = frames.into_iter().map(<[f64]>::to_vec).collect();
        let lost = range.len() - frames.len();
        let driven =
            (0..basis.mesh.shapes.len()).filter(|&s| frames.iter().any(|f| f[s] != 0.0)).count();
        let (len, shapes) =
            (counted(frames.len(), "frame", "frames"), counted(driven, "shape", "shapes"));
        let text = format!("from {len} of {}, which move {shapes}", path.display());
        if !is_moving(&frames) {
            let text = format!("weights do not change in {len}: only their mean is learned");
            output.warn(path.display(), text);
        }
        let mut model = of_take(basis, &frames, options).of(&self.basis)?;
        measure(&mut model, basis, &frames, options)?;
        Ok((model, Learned { text, lost }))
    }

    /// Sets the given landmarks.
    fn set_landmarks(&self, basis: &mut Basis) -> anyhow::Result<()> {
        let Some(path) = &self.shape.landmarks else { return Ok(()) };
        basis.read_landmarks(path).of(path)
    }

    /// Refuses options that do not apply to example meshes.
    fn refuse_for_meshes(&self) -> anyhow::Result<()> {
        let given = [
            ("--animation", self.take.animation.is_some()),
            ("--frames", self.take.frames.is_some()),
            ("--identity", !self.shape.identity.is_empty()),
        ];
        match given.into_iter().find(|(_, given)| *given) {
            Some((option, _)) => {
                bail!("it has meshes without shapes: {option} is for a face that has some")
            }
            None => Ok(()),
        }
    }
}

/// Parses the number and the weight of an identity.
fn identity(text: &str) -> Result<(usize, f64), String> {
    let pair = text
        .split_once('=')
        .and_then(|(identity, by)| Some((identity.trim().parse().ok()?, by.trim().parse().ok()?)));
    pair.filter(|(_, by): &(usize, f64)| by.is_finite())
        .ok_or_else(|| "expected I=X, the number and the weight of an identity".to_owned())
}
