//! `sinew poses`: poses to train on, for the artist's program to evaluate.

use crate::cli::{
    Bars, OfFile, Output, OutputFile, POSITIVE, Report, Run, count, counted, number, printable,
};
use crate::examples::{Loaded, PoseRequest, Source, load_poses, sample_poses, save_poses};
use crate::{Error, ErrorKind};
use std::path::{Path, PathBuf};

/// Largest number of poses.
const FRAMES_MAX: usize = 10_000;

/// Samples poses of a rig, to train on
///
/// Up to a third of the poses moves each joint and each curve alone, up to a third moves joints with their parents and
/// curves in pairs, and the rest moves all. Ranges are those of the rig's clips, in its training frames, and a tenth
/// more on either side, unless that side ends near the rest pose.
///
/// OUT.npz has the arrays of `sinew train` without meshes: bone_names, bone_parents, joint_world_rest, bone_transforms,
/// curve_names and curves; and inverse_binds, the inverses of joint_world_rest. Pose your rig by them, export each
/// mesh, and train on both. In Blender, `blender_export.py --range-of-motion` does all of this.
#[derive(clap::Args)]
#[command(after_help = "Example:\n  sinew poses walk.glb -o poses.npz")]
pub(in crate::cli) struct PosesArgs {
    /// Rig: a scene with mesh and skeleton (.glb, .gltf, .fbx), or a .npz as for `sinew train`
    #[arg(value_name = "RIG")]
    rig: PathBuf,
    /// File to write (.npz)
    #[arg(short, long, value_name = "OUT.npz")]
    output: PathBuf,
    /// Number of poses
    #[arg(long, value_name = "N", value_parser = count(6, FRAMES_MAX), allow_negative_numbers = true)]
    #[arg(default_value_t = PoseRequest::default().frames)]
    frames: usize,
    /// Turn every joint by up to N degrees about each of its axes, and move curves from 0 to 1 [default: the ranges of
    /// the clips]
    #[arg(long, value_name = "N", value_parser = degrees(), allow_negative_numbers = true)]
    degrees: Option<f64>,
    /// Seed of the random choices; equal seeds give equal bytes
    #[arg(long, value_name = "SEED", default_value_t = PoseRequest::default().seed)]
    seed: u64,
}

/// Makes a parser of an angle up to half a turn, where the rotation of a joint is ambiguous.
fn degrees() -> impl Fn(&str) -> Result<f64, String> + Clone + Send + Sync + 'static {
    number((POSITIVE.0, std::ops::Bound::Included(180.0)), " degrees")
}

impl PosesArgs {
    /// Loads the rig. A scene without clips is at rest; then there are no ranges, which sampling reports.
    fn load(&self) -> Result<Loaded, Error> {
        let moving = Source::file(&self.rig);
        let still = Source { still: true, ..moving };
        if self.degrees.is_some() {
            return load_poses(&still);
        }
        load_poses(&moving).or_else(|error| match error.kind() {
            ErrorKind::Missing => load_poses(&still).map_err(|_| error),
            _ => Err(error),
        })
    }
}

impl Run for PosesArgs {
    fn run(&self, output: Output) -> anyhow::Result<Report> {
        let files = Source::file(&self.rig).files();
        let target = OutputFile::new(&self.output, files)?.ending_in(&["npz"])?;
        let loaded = {
            let _reading = Bars::busy(output, "reading the rig");
            self.load()?
        };
        loaded.warnings.iter().for_each(|warning| output.report(self.rig.display(), warning));
        let rig = loaded.examples;
        let (frames, degrees, seed) = (self.frames, self.degrees, self.seed);
        let poses = sample_poses(&rig, &PoseRequest { frames, degrees, seed }).of(&self.rig)?;
        save_poses(&target.named, &rig, &poses)?;
        let (alone, paired) = (poses.alone, poses.paired);
        let together = frames - alone - paired;
        Ok(Report::default()
            .text(format!(
                "{} of {} move, and {}: {alone} poses alone, {paired} in pairs, {together} together",
                counted(poses.joints, "joint", "joints"),
                rig.joint_len(),
                counted(rig.curve_names.len(), "curve", "curves"),
            ))
            .text(format!("wrote {}", printable(&Path::display(&target.named).to_string())))
            .json("frames", frames)
            .json("joints", poses.joints)
            .json("curves", rig.curve_names.len())
            .json("alone", alone)
            .json("paired", paired))
    }
}
