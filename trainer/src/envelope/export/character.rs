//! A character's scene: skeleton, proxies, meshes, and an animation a clip.

use super::error::ExportError;
use super::glb::{Document, Placed, SkinnedMesh};
use super::proxies::{self, ProxyNodes};
use super::skeleton::{JointNodes, quaternion, turned};
use super::times::key_times;
use crate::envelope::evaluate::{Character, EvaluateError};
use crate::envelope::levels::{Influences, Level, LevelReport, SkinSurface};
use crate::envelope::posed::{FrameError, influences, palette, rest, skin_on};
use crate::examples::{Clip, Examples, Matrix3x4};
use crate::space::{Conversion, SpaceRequest};
use rayon::prelude::*;
use sinew_runtime::Envelope;
use sinew_runtime::format::{Axis, Handedness, Space};

/// How far a proxy reaches about its centre where a joint is looked for to carry it, in diagonals.
const REACH: f64 = 0.05;

/// What a file says of itself.
const NOTE: &str = "The skin follows nodes called proxy_N under the skeleton's joints. A proxy's outer \
    node moves, turns and scales it; its inner node turns the axes of the scale back. The keys \
    were predicted from the skeleton's pose.";

/// How the file's scene stands to the model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Stand {
    /// As the model does.
    AsModel,
    /// Turned from z up to y up, about x.
    Upright,
    /// In this space, as far as it is said; the armature turns and scales the character.
    In(SpaceRequest),
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
/// - [`ExportError::Model`] and [`ExportError::Frame`]: the model is refused, was made for another
///   character, or refuses a pose.
/// - [`ExportError::NoFrames`] and [`ExportError::Times`]: a clip cannot be played.
/// - [`ExportError::Level`]: a further mesh lies elsewhere.
/// - [`ExportError::Space`] and [`ExportError::LeftHanded`]: it cannot stand as asked.
/// - [`ExportError::TooLarge`] and [`ExportError::Glb`]: the file cannot be made.
pub fn export(
    model: &[u8],
    skin: Option<&str>,
    examples: &Examples,
    clips: &[Clip],
    levels: &[Level],
    stand: Stand,
) -> Result<Exported, ExportError> {
    let character = Character::open(model, skin, examples)?;
    let Character { envelope, skin, space } = character;
    let hand = SpaceRequest { handedness: Some(Handedness::Right), ..SpaceRequest::default() };
    let (right, mirror) = Conversion::to(space, &hand)?;
    let times = clips.iter().map(key_times).collect::<Result<Vec<_>, _>>()?;
    if clips.is_empty() {
        return Err(ExportError::NoFrames { clip: "the examples have no clip".to_owned() });
    }
    let frames: Vec<usize> =
        clips.iter().flat_map(|clip| clip.first..clip.first + clip.times.len()).collect();
    examples.check_rigid_in(&frames).map_err(EvaluateError::Examples)?;
    let mut palettes = frames
        .par_iter()
        .map(|&frame| Ok(palette(&envelope, examples, frame)?.0))
        .collect::<Result<Vec<_>, FrameError>>()?;
    let own_influences = influences(&skin);
    let own = examples.surface();
    let (mut levels, influences_of_levels, reports) = if levels.is_empty() {
        Default::default()
    } else {
        let keys = palettes.par_iter().zip(&frames);
        let posed = keys
            .map(|(palette, &frame)| {
                let [positions, _] = skin_on(&skin, palette, frame)?;
                Ok(own.of_first_copies(positions.as_chunks().0))
            })
            .collect::<Result<Vec<_>, FrameError>>()?;
        let surface = SkinSurface {
            rest: &own.of_first_copies(&rest(&skin)),
            triangles: &examples.solid_triangles(),
            influences: &own.of_first_copies(&own_influences),
            most: skin.influence_len(),
            diagonal: examples.diagonal(),
            palettes: &palettes,
            posed,
        };
        let followed = levels.iter().map(|level| surface.follow(level));
        let followed = followed.collect::<Result<Vec<_>, _>>()?.into_iter();
        let (influences, reports): (Vec<_>, Vec<_>) = followed.unzip();
        (levels.to_vec(), influences, reports)
    };

    // What follows is in the model's space, mirrored where that is left-handed.
    let normal = |vertex| skin.rest_normal(vertex).unwrap_or_default().map(f64::from);
    let mut normals_at_rest: Vec<_> = (0..skin.vertex_len()).map(normal).collect();
    let (mut rest, mut triangles) = (rest(&skin), own.engine_triangles().to_vec());
    let mut skeleton = examples.skeleton.clone();
    let mut poses: Vec<_> = frames.iter().map(|&frame| examples.pose(frame).to_vec()).collect();
    if let Some(mirror) = mirror {
        rest.iter_mut().for_each(|x| *x = mirror.point(*x));
        normals_at_rest.iter_mut().for_each(|n| *n = mirror.direction(*n));
        mirror.triangles(&mut triangles);
        let turn = |b: &mut Matrix3x4| *b = mirror.transform(b);
        skeleton.rest.iter_mut().for_each(turn);
        poses.iter_mut().flatten().for_each(turn);
        for b in palettes.iter_mut().flatten() {
            // Exact: entries change places and signs.
            let turned = mirror.transform(&b.map(|row| row.map(f64::from)));
            *b = turned.map(|row| row.map(|x| x as f32));
        }
        levels.iter_mut().for_each(|level| level.mesh.convert(&mirror));
    }
    let poses: Vec<&[Matrix3x4]> = poses.iter().map(Vec::as_slice).collect();

    let mut document = Document::new(NOTE);
    let armature = document.node("armature".to_owned(), None, &armature(&right, stand)?);
    let joints = JointNodes::new(&mut document, armature, &skeleton);
    let centres = centres(&envelope, &rest, &own_influences);
    let carriers = proxies::carriers(&palettes, &poses, &centres, REACH * examples.diagonal());
    let proxies = ProxyNodes::new(&mut document, &joints, &centres, &carriers);
    let shown = envelope.palette_len() - envelope.proxy_len();
    let nodes = joints.nodes[..shown].iter().copied().chain(proxies.joints()).collect();
    let inverse_binds = [&joints.inverse_binds[..shown], &proxies.inverse_binds].concat();
    let palette_skin = document.skin(armature, nodes, &inverse_binds);
    let mesh = SkinnedMesh {
        name: skin.name(),
        positions: &rest,
        normals: &normals_at_rest,
        uv: own.uv(),
        influences: &own_influences,
        triangles: &triangles,
    };
    document.mesh(&mesh, palette_skin);
    for (level, influences) in levels.iter().zip(&influences_of_levels) {
        let surface = level.mesh.surface();
        let mesh = SkinnedMesh {
            name: &level.name,
            positions: &surface.copied(&level.mesh.positions),
            normals: &surface.normals(),
            uv: surface.uv(),
            influences: &surface.copied(influences),
            triangles: surface.engine_triangles(),
        };
        document.mesh(&mesh, palette_skin);
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

/// Places the armature of a right-handed model, so that the character stands as asked.
fn armature(model: &Space, stand: Stand) -> Result<Placed, ExportError> {
    let conversion = match stand {
        Stand::AsModel => None,
        Stand::Upright => {
            let space =
                |up, forward| Space { up: Some(up), forward: Some(forward), ..Space::default() };
            Conversion::between(&space(Axis::Z, Axis::MinusY), &space(Axis::Y, Axis::Z))
        }
        Stand::In(SpaceRequest { handedness: Some(Handedness::Left), .. }) => {
            return Err(ExportError::LeftHanded);
        }
        Stand::In(request) => Conversion::to(*model, &request)?.1,
    };
    Ok(conversion.map_or(Placed::AT_PARENT, |conversion| Placed {
        rotation: quaternion(&turned(&conversion.axes())),
        scale: [conversion.scale() as f32; 3],
        ..Placed::AT_PARENT
    }))
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
        for &(index, weight) in influences {
            if let Some(sum) = index.checked_sub(first).and_then(|proxy| sums.get_mut(proxy)) {
                add(sum, weight);
            }
        }
        add(&mut all, 1.0);
    }
    let mean = |[x, y, z, weight]: [f64; 4]| [x / weight, y / weight, z / weight];
    sums.into_iter().map(|sum| mean(if sum[3] > 0.0 { sum } else { all })).collect()
}
