//! Whole scenes: a character that plays a model, with skeleton, proxies, meshes and an animation for each clip; and the
//! demo character as an artist would deliver it.

use super::chains::ChainNodes;
use super::mesh::{SkinnedMesh, parts};
use super::play::Playback;
use super::skeleton::{JointNodes, key_times, quaternion, turned};
use crate::Error;
use crate::envelope::lbs::weights;
use crate::envelope::levels::LevelReport;
use crate::examples::{Clip, Examples, Split};
use crate::formats::appearance::Appearance;
use crate::formats::gltf::write::{Document, Placed};
use crate::formats::usd;
use crate::space::{Conversion, SpaceRequest};
use sinew_runtime::format::{Axis, Handedness, Space};

/// Note in an exported file.
const NOTE: &str = "The skin follows nodes called proxy_N under the skeleton's joints. A proxy's outer \
    node moves, turns and scales it; its inner node turns the axes of the scale back. The keys \
    were predicted from the skeleton's pose.";

/// Orientation and scale of the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Placement {
    /// As in the model.
    AsModel,
    /// Rotated from z up to y up, about x.
    Upright,
    /// In the given space, where it is stated; the armature rotates and scales the character.
    In(SpaceRequest),
}

/// An exported file.
pub struct Exported {
    /// Bytes of the file.
    pub glb: Vec<u8>,
    /// Reports on the further meshes, in order.
    pub levels: Vec<LevelReport>,
    /// Space of the file.
    space: Space,
    /// Frames a second of the first clip.
    rate: f64,
}

impl Exported {
    /// Writes the file as USD: the nodes as the joints of a skeleton, and a `SkelAnimation` for each clip. The first is
    /// bound. UsdSkel has scales in half precision.
    ///
    /// # Errors
    /// - [`ErrorKind::Unsupported`](crate::ErrorKind::Unsupported): the character stands along an axis other than y and
    ///   z.
    /// - [`ErrorKind::Missing`](crate::ErrorKind::Missing): nothing in the file has a skin.
    pub fn usda(&self) -> Result<String, Error> {
        usd::write(&self.glb, &self.space, self.rate)
    }
}

/// Exports clips of the examples as a GLB with an animation for each clip. The animations are the palettes that the f32
/// runtime predicts. The model's mesh and further meshes use one skin.
#[derive(Clone, Copy)]
pub struct Export<'a> {
    /// The model and its clips.
    pub playback: Playback<'a>,
    /// Materials and names of the mesh. Each known name becomes a mesh, each known material a primitive.
    pub appearance: &'a Appearance,
    /// Orientation and scale of the scene.
    pub placement: Placement,
}

impl Export<'_> {
    /// Writes the file.
    ///
    /// # Errors
    /// - The model is refused or belongs to another character, as in
    ///   [`Character::open`](crate::evaluate::Character::open).
    /// - A clip cannot be played, as in [`check_clips`](super::check_clips).
    /// - A joint is mirrored or hidden in a frame, or the runtime refuses a frame.
    /// - A further mesh does not lie on the model's skin.
    /// - The requested space is impossible; [`ErrorKind::Unsupported`](crate::ErrorKind::Unsupported) if it is
    ///   left-handed.
    /// - [`ErrorKind::Limit`](crate::ErrorKind::Limit): the file would be too large.
    pub fn run(&self) -> Result<Exported, Error> {
        let Self { playback, appearance, placement } = *self;
        let Playback { examples, clips, .. } = playback;
        let (played, further) = playback.play()?;
        let skin = &played.character.skin;
        let normal = |vertex| skin.rest_normal(vertex).unwrap_or_default().map(f64::from);
        let mut normals_at_rest: Vec<_> = (0..skin.vertex_len()).map(normal).collect();
        let own = examples.surface();
        let mut triangles = own.engine_triangles().to_vec();
        if let Some(mirror) = &played.mirror {
            normals_at_rest.iter_mut().for_each(|n| *n = mirror.direction(*n));
            mirror.triangles(&mut triangles);
        }

        let mut document = Document::new(NOTE);
        let (placed, space) = place(played.space, placement)?;
        let armature = document.node("armature".to_owned(), None, &placed);
        let joints = JointNodes::new(&mut document, armature, &played.skeleton);
        let chained = played.stretched().chain(played.proxies()).collect();
        let chains = ChainNodes::new(&mut document, &joints.carriers(), chained);
        let first_proxy = played.first_proxy();
        let mut nodes = joints.nodes[..first_proxy].to_vec();
        let mut inverse_binds = joints.inverse_binds[..first_proxy].to_vec();
        chains.bind(&mut nodes, &mut inverse_binds);
        let palette_skin = document.skin(armature, &nodes, &inverse_binds);
        document.dress(appearance, own.uv().is_some());
        let mesh = SkinnedMesh {
            name: appearance.mesh.as_deref().unwrap_or(skin.name()),
            positions: &played.rest,
            normals: &normals_at_rest,
            uv: own.uv(),
            influences: &played.influences,
            primitives: &[],
        };
        let materials = &appearance.of_triangles;
        let ranges = examples.ranges.iter();
        let ranges = ranges.map(|(name, range)| (name.as_str(), own.engine_range(range)));
        for part in parts(&mesh, ranges, &triangles, materials) {
            document.mesh(&part.of(&mesh), palette_skin);
        }
        further.add(&mut document, palette_skin);
        for ((clip, times), own) in clips.iter().zip(&played.times).zip(played.clips()) {
            let (mut tracks, worlds) = joints.tracks(&played.poses[own.clone()], times);
            tracks.extend(chains.tracks(&played.palettes[own.clone()], &worlds));
            document.animation(&clip.name, times, tracks);
            document.curves(&played.curve_names(), times, &played.curves[own]);
        }
        let rate = clips.first().map_or(UNKNOWN_RATE, rate);
        Ok(Exported { glb: document.finish()?, levels: further.reports, space, rate })
    }
}

/// Time codes a second of USD without a rate: the default of USD.
const UNKNOWN_RATE: f64 = 24.0;
/// Largest difference of a step of a clip from the mean step, relative to it, in a clip with a rate.
const REGULAR: f64 = 1e-2;

/// Returns the frames a second of a clip, in thousandths, if its steps are even.
fn rate(clip: &Clip) -> f64 {
    let steps = || clip.times.windows(2).map(|pair| pair[1] - pair[0]);
    let mean = steps().sum::<f64>() / (clip.times.len().max(2) - 1) as f64;
    let is_regular = steps().all(|step| (step - mean).abs() <= REGULAR * mean);
    let rate = (1000.0 / mean).round() / 1000.0;
    if is_regular && rate.is_normal() { rate } else { UNKNOWN_RATE }
}

/// Returns the armature's transform, which puts the right-handed model into the requested space, and this space.
fn place(model: Space, placement: Placement) -> Result<(Placed, Space), Error> {
    let (space, conversion) = match placement {
        Placement::AsModel => (model, None),
        Placement::Upright => {
            let space =
                |up, forward| Space { up: Some(up), forward: Some(forward), ..Space::default() };
            let upright = space(Axis::Y, Axis::Z);
            let conversion = Conversion::between(&space(Axis::Z, Axis::MinusY), &upright);
            (Space { unit: model.unit, ..upright }, conversion)
        }
        Placement::In(SpaceRequest { handedness: Some(Handedness::Left), .. }) => {
            return Err(Error::unsupported(
                "glTF is right-handed: leave out --to-hand left, engines mirror it as they import it",
            ));
        }
        Placement::In(request) => Conversion::to(model, &request)?,
    };
    let placed = conversion.map_or(Placed::AT_PARENT, |conversion| Placed {
        rotation: quaternion(&turned(&conversion.axes)),
        scale: [conversion.scale as f32; 3],
        ..Placed::AT_PARENT
    });
    Ok((placed, space))
}

/// Note in the demo's file.
const DEMO_NOTE: &str = "A procedural arm: what a rig exports of its skeleton, with the weights of \
    linear blend skinning. The meshes that its flesh really takes are in the point cache beside it.";

/// Sorts frames by use, so that each use is one clip: training, held-out and extreme frames.
pub fn by_use(examples: Examples) -> (Examples, Vec<Clip>) {
    let (mut frames, mut clips) = (Vec::new(), Vec::new());
    for split in [Split::Train, Split::HeldOut, Split::Extreme] {
        let (name, own) = (split.name(), examples.frames_of(split));
        if !own.is_empty() {
            clips.push(Clip::regular(name.to_owned(), frames.len(), own.len()));
            frames.extend(own);
        }
    }
    let mut vertices = Vec::with_capacity(examples.vertices.len());
    frames.iter().for_each(|&frame| vertices.extend_from_slice(examples.frame(frame)));
    let transforms = frames.iter().flat_map(|&frame| examples.pose(frame)).copied().collect();
    let curves = frames.iter().flat_map(|&frame| examples.curves_of(frame)).copied().collect();
    let split = frames.iter().map(|&frame| examples.split[frame]).collect();
    let clip_starts = clips.iter().map(|clip| clip.first).collect();
    (Examples { vertices, transforms, curves, split, clip_starts, ..examples }, clips)
}

/// Writes examples as a rigged character: the skeleton, the rest mesh with four LBS weights a vertex, fitted to the
/// training frames, and an animation for each clip. The rest pose is the bind pose.
///
/// # Errors
/// A clip cannot be played, or the file would be too large.
pub fn demo_glb(examples: &Examples, clips: &[Clip]) -> Result<Vec<u8>, Error> {
    let weights = weights::baseline(examples);
    let influences: Vec<_> = (0..weights.len()).map(|v| weights.of(v).collect()).collect();

    let mut document = Document::new(DEMO_NOTE);
    let armature = document.node("armature".to_owned(), None, &Placed::AT_PARENT);
    let joints = JointNodes::new(&mut document, armature, &examples.skeleton);
    let skin = document.skin(armature, &joints.nodes, &joints.inverse_binds);
    let mesh = SkinnedMesh {
        name: "skin",
        positions: &examples.rest,
        normals: &examples.surface().normals(),
        uv: examples.surface().uv(),
        influences: &influences,
        primitives: &[(None, examples.triangles.clone())],
    };
    document.mesh(&mesh, skin);
    for clip in clips {
        let frames = clip.first..clip.first + clip.times.len();
        let poses: Vec<_> = frames.map(|frame| examples.pose(frame).to_vec()).collect();
        let times = key_times(clip)?;
        document.animation(&clip.name, &times, joints.tracks(&poses, &times).0);
    }
    document.finish()
}
