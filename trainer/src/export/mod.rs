//! A model and a clip as binary glTF, which plays in any engine without our runtime.
//!
//! The skeleton's joints become nodes under one armature, and the proxies under them; what is in the
//! palette are the joints of one skin, and every mesh hangs on it. The f32 runtime predicts the
//! palette of each frame, and that is what the animations play.

mod demo;
mod glb;
mod level;
mod nearest;
mod proxies;
mod skeleton;
mod stretch;

use rayon::prelude::*;
use sinew_runtime::Envelope;

pub use self::demo::{by_use, demo_glb};
pub use self::level::{Level, LevelReport};

use self::glb::{Document, Placed, SkinnedMesh};
use self::level::{Influences, Skinned};
use self::proxies::Proxies;
use self::skeleton::Joints;
use crate::evaluate::{EvaluateError, open, palette, rest, skin_on};
use crate::examples::{Clip, Examples};

/// Vertex numbers of a triangle.
type Triangle = [usize; 3];

/// How far a proxy reaches about its centre where a joint is looked for to carry it, in diagonals.
const REACH: f64 = 0.05;

/// What a file says of itself.
const NOTE: &str = "The skin follows nodes called proxy_N under the skeleton's joints. A proxy's outer \
    node moves, turns and scales it; its inner node turns the axes of the scale back. The keys \
    were predicted from the skeleton's pose.";

/// An export that could not be made.
#[derive(Debug, thiserror::Error)]
pub enum ExportError {
    /// The model is refused, or does not fit the examples.
    #[error(transparent)]
    Model(#[from] EvaluateError),
    /// There is no clip, or one without frames.
    #[error("there is no frame to export: {clip}")]
    NoFrames {
        /// The clip.
        clip: String,
    },
    /// The times of a clip's frames do not ascend from zero on in single precision.
    #[error(
        "clip {clip}: frame {frame} plays at {time} s, expected times from 0 on that ascend by more \
         than single precision rounds"
    )]
    Times {
        /// The clip.
        clip: String,
        /// The frame, counted from the clip's first.
        frame: usize,
        /// Its time in seconds.
        time: f64,
    },
    /// A further mesh does not lie on the model's surface.
    #[error(
        "mesh {name} is {percent:.0} % of the diagonal away from the model's surface, expected at \
         most 10 % at the median: export it in the same rest pose, units and axes as the examples"
    )]
    LevelFar {
        /// Its name.
        name: String,
        /// Median distance in % of the diagonal.
        percent: f64,
    },
    /// The file would be larger than binary glTF allows.
    #[error("the file takes {bytes} bytes, and binary glTF holds 4 GiB: export fewer frames")]
    TooLarge {
        /// Bytes needed.
        bytes: usize,
    },
    /// The file could not be put together.
    #[error("cannot be put together: {0}")]
    Glb(#[from] gltf::Error),
}

/// The axis along which the examples' character stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Up {
    /// y, as in glTF.
    Y,
    /// z: the armature turns the character upright.
    Z,
}

/// An exported file.
pub struct Exported {
    /// Its bytes.
    pub glb: Vec<u8>,
    /// How the further meshes follow, in their order.
    pub levels: Vec<LevelReport>,
}

/// Bakes clips of the examples into a GLB: an animation a clip, of the palettes that the f32
/// runtime predicts, with the model's mesh and further ones on one skin.
///
/// # Errors
/// - [`ExportError::Model`]: the model is refused, was made for another character, or refuses a
///   pose.
/// - [`ExportError::NoFrames`] and [`ExportError::Times`]: a clip cannot be played.
/// - [`ExportError::LevelFar`]: a further mesh lies elsewhere.
/// - [`ExportError::TooLarge`] and [`ExportError::Glb`]: the file cannot be made.
pub fn export(
    model: &[u8],
    examples: &Examples,
    clips: &[Clip],
    levels: &[Level],
    up: Up,
) -> Result<Exported, ExportError> {
    let envelope = open(model, examples)?;
    let times = clips.iter().map(key_times).collect::<Result<Vec<_>, _>>()?;
    if clips.is_empty() {
        return Err(ExportError::NoFrames { clip: "the examples have no clip".to_owned() });
    }
    let frames: Vec<usize> =
        clips.iter().flat_map(|clip| clip.first..clip.first + clip.times.len()).collect();
    examples.check_rigid_in(&frames).map_err(EvaluateError::Examples)?;
    let palettes = frames
        .par_iter()
        .map(|&frame| Ok(palette(&envelope, examples, frame)?.0))
        .collect::<Result<Vec<_>, EvaluateError>>()?;
    let rest = rest(&envelope);
    let influences = level::influences(&envelope);

    let mut document = Document::new(NOTE);
    const HALF: f32 = std::f32::consts::FRAC_1_SQRT_2;
    let stands = match up {
        Up::Y => Placed::AT_PARENT,
        Up::Z => Placed { rotation: [-HALF, 0.0, 0.0, HALF], ..Placed::AT_PARENT },
    };
    let armature = document.node("armature".to_owned(), None, &stands);
    let joints = Joints::new(&mut document, armature, &examples.skeleton);
    let centres = centres(&envelope, &rest, &influences);
    let poses: Vec<_> = frames.iter().map(|&frame| examples.pose(frame)).collect();
    let carriers = proxies::carriers(&palettes, &poses, &centres, REACH * examples.diagonal());
    let proxies = Proxies::new(&mut document, &joints, &centres, &carriers);
    let shown = envelope.palette_len() - envelope.proxy_len();
    let nodes = joints.nodes[..shown].iter().copied().chain(proxies.joints()).collect();
    let inverse_binds = [&joints.inverse_binds[..shown], &proxies.inverse_binds].concat();
    let palette_skin = document.skin(armature, nodes, &inverse_binds);

    let rest_normal = |vertex| envelope.rest_normal(vertex).unwrap_or_default().map(f64::from);
    let mesh = SkinnedMesh {
        name: envelope.name(),
        positions: &rest,
        normals: &(0..rest.len()).map(rest_normal).collect::<Vec<_>>(),
        uv: examples.uv.as_deref(),
        influences: &influences,
        triangles: &examples.triangles,
    };
    document.mesh(&mesh, palette_skin);
    let mut reports = Vec::new();
    if !levels.is_empty() {
        let keys = palettes.par_iter().zip(&frames);
        let posed = keys
            .map(|(palette, &frame)| {
                let [positions, _] = skin_on(&envelope, palette, frame)?;
                Ok(positions)
            })
            .collect::<Result<Vec<_>, EvaluateError>>()?;
        let skinned = Skinned {
            rest: &rest,
            triangles: &examples.solid_triangles(),
            influences: &influences,
            most: envelope.influence_len(),
            diagonal: examples.diagonal(),
            palettes: &palettes,
            posed,
        };
        for level in levels {
            let (influences, report) = skinned.follow(level)?;
            reports.push(report);
            let mesh = SkinnedMesh {
                name: &level.name,
                positions: &level.mesh.positions,
                normals: &level.normals(),
                uv: level.mesh.uv.as_deref(),
                influences: &influences,
                triangles: &level.mesh.triangles,
            };
            document.mesh(&mesh, palette_skin);
        }
    }
    let mut begin = 0;
    for (clip, times) in clips.iter().zip(&times) {
        let own = begin..begin + times.len();
        begin = own.end;
        let (mut tracks, worlds) = joints.tracks(&poses[own.clone()]);
        tracks.extend(proxies.tracks(&palettes[own], &worlds));
        document.animation(&clip.name, times, tracks);
    }
    Ok(Exported { glb: document.finish()?, levels: reports })
}

/// Rounds the times of a clip's frames.
fn key_times(clip: &Clip) -> Result<Vec<f32>, ExportError> {
    let name = || clip.name.clone();
    if clip.times.is_empty() {
        return Err(ExportError::NoFrames { clip: format!("clip {} has none", name()) });
    }
    let times: Vec<f32> = clip.times.iter().map(|&time| time as f32).collect();
    let bad = (0..times.len()).find(|&key| {
        let after = key == 0 || times[key] > times[key - 1];
        !(after && times[key] >= 0.0 && times[key].is_finite())
    });
    match bad {
        Some(frame) => Err(ExportError::Times { clip: name(), frame, time: clip.times[frame] }),
        None => Ok(times),
    }
}

/// Gives the centre of what each proxy moves; of the mesh, where it moves nothing.
fn centres(envelope: &Envelope<'_>, rest: &[[f64; 3]], influences: &Influences) -> Vec<[f64; 3]> {
    let first = envelope.palette_len() - envelope.proxy_len();
    let mut sums = vec![[0.0; 4]; envelope.proxy_len()];
    let mut all = [0.0; 4];
    for (x, influences) in rest.iter().zip(influences) {
        let add = |sum: &mut [f64; 4], weight: f64| {
            for (sum, x) in sum.iter_mut().zip(x.iter().chain([&1.0])) {
                *sum += weight * x;
            }
        };
        for &(map, weight) in influences {
            if let Some(sum) = map.checked_sub(first).and_then(|proxy| sums.get_mut(proxy)) {
                add(sum, weight);
            }
        }
        add(&mut all, 1.0);
    }
    let mean = |[x, y, z, weight]: [f64; 4]| [x / weight, y / weight, z / weight];
    sums.into_iter().map(|sum| mean(if sum[3] > 0.0 { sum } else { all })).collect()
}
