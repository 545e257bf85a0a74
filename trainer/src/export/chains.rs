//! Transforms of the palette that no single node can hold: proxies, and joints that stretch. Each takes a chain of two
//! nodes.

use nalgebra::{Matrix3, Vector3};
use rayon::prelude::*;
use sinew_runtime::Matrix3x4;

use super::skeleton::{Carrier, Frame, continuous, quaternion, turned};
use super::stretch::Stretch;
use crate::formats::gltf::write::{ChannelKeys, Document, NodeIndex, Placed, Track};

/// A transform of the palette that takes two nodes.
pub(super) struct Chained {
    /// Names of the outer and the inner node.
    pub(super) names: [String; 2],
    /// Index in the palette.
    pub(super) transform: usize,
    /// Point of the rest mesh at which the nodes stand.
    pub(super) centre: [f64; 3],
    /// Joint that carries the nodes.
    pub(super) joint: usize,
}

/// Transforms of a palette as nodes of a document.
///
/// Each transform is a child of a joint whose motion is near, so that it moves with the skeleton between two keys. A node
/// moves, rotates and scales along its own axes, but the transform scales along other axes. The outer node moves, rotates
/// and scales. The inner node, the joint of the skin, rotates the axes back.
pub(super) struct ChainNodes {
    chains: Vec<Chain>,
}

struct Chain {
    outer: NodeIndex,
    inner: NodeIndex,
    transform: usize,
    centre: [f32; 3],
    joint: usize,
    unit: f64,
}

impl ChainNodes {
    /// Adds the nodes under the joints that carry them, each at its centre.
    pub(super) fn new(document: &mut Document, joints: &[Carrier], all: Vec<Chained>) -> Self {
        let add = |Chained { names: [outer, inner], transform, centre, joint }: Chained| {
            let centre = centre.map(|x| x as f32);
            let Carrier { node, ref at_rest, unit } = joints[joint];
            let back = at_rest.inverse();
            let place = back.transform_point(&centre.map(f64::from).into());
            let placed = Placed {
                translation: place.coords.map(|x| (x / unit) as f32).into(),
                rotation: quaternion(&back.rotation),
                scale: [1.0; 3],
            };
            let outer = document.node(outer, Some(node), &placed);
            let inner = document.node(inner, Some(outer), &Placed::AT_PARENT);
            Chain { outer, inner, transform, centre, joint, unit }
        };
        Self { chains: all.into_iter().map(add).collect() }
    }

    /// Puts the inner nodes and their inverse bind matrices, in the model's unit, into the lists of a skin. The lists hold
    /// the joints of the palette, which come first.
    pub(super) fn bind(&self, nodes: &mut Vec<NodeIndex>, inverse_binds: &mut Vec<Matrix3x4>) {
        for Chain { inner, transform, centre, .. } in &self.chains {
            let [x, y, z] = centre.map(|x| -x);
            let bind = [[1.0, 0.0, 0.0, x], [0.0, 1.0, 0.0, y], [0.0, 0.0, 1.0, z]];
            match nodes.get_mut(*transform).zip(inverse_binds.get_mut(*transform)) {
                Some(place) => (*place.0, *place.1) = (*inner, bind),
                None => {
                    nodes.push(*inner);
                    inverse_binds.push(bind);
                }
            }
        }
    }

    /// Makes the tracks of the nodes through palettes. `joints` are the world frames of the joints.
    pub(super) fn tracks(&self, palettes: &[Vec<Matrix3x4>], joints: &[Vec<Frame>]) -> Vec<Track> {
        let tracks = self.chains.par_iter().flat_map_iter(|chain| {
            let maps = palettes.iter().map(|palette| &palette[chain.transform]);
            chain.tracks(maps.zip(joints.iter().map(|joints| &joints[chain.joint])))
        });
        tracks.collect()
    }
}

/// Finds the joint that carries each proxy best: in the poses, its maps take points around the proxy's centre nearest
/// to the images under the proxy's maps.
pub(super) fn carriers(
    palettes: &[Vec<Matrix3x4>],
    poses: &[Vec<crate::examples::Matrix3x4>],
    centres: &[[f64; 3]],
    radius: f64,
) -> Vec<usize> {
    let carrier = |(proxy, centre): (usize, &[f64; 3])| {
        let mut apart = vec![0.0; poses.first().map_or(0, |pose| pose.len())];
        for (palette, pose) in palettes.iter().zip(poses) {
            let map = palette[palette.len() - centres.len() + proxy].map(|row| row.map(f64::from));
            for (apart, joint) in apart.iter_mut().zip(pose) {
                // Squared difference of two maps: at the centre, and over the radius.
                for (map, joint) in map.iter().zip(joint) {
                    let [x, y, z, w] = std::array::from_fn(|column| map[column] - joint[column]);
                    let centre = x * centre[0] + y * centre[1] + z * centre[2] + w;
                    *apart += centre * centre + radius * radius * (x * x + y * y + z * z);
                }
            }
        }
        (0..apart.len()).min_by(|&a, &b| apart[a].total_cmp(&apart[b])).unwrap_or(0)
    };
    centres.par_iter().enumerate().map(carrier).collect()
}

impl Chain {
    fn tracks<'a>(&self, keys: impl Iterator<Item = (&'a Matrix3x4, &'a Frame)>) -> [Track; 4] {
        let centre = Vector3::from(self.centre.map(f64::from));
        let (mut places, mut turns, mut scales, mut axes) = (vec![], vec![], vec![], vec![]);
        let mut before: Option<Stretch> = None;
        for (map, joint) in keys {
            let back = joint.rigid.inverse();
            let linear = Matrix3::from_fn(|row, column| f64::from(map[row][column]));
            let moved = linear * centre + Vector3::from(map.map(|row| f64::from(row[3])));
            let mut linear = back.rotation.to_rotation_matrix() * linear;
            let mut place = back.transform_point(&moved.into()).coords / self.unit;
            if let Some(unstretch) = &joint.unstretch {
                (linear, place) = (unstretch * linear, unstretch * place);
            }
            let stretch = Stretch::of(&linear, before.as_ref());
            before = Some(stretch);
            places.push(place.map(|x| x as f32).into());
            turns.push(quaternion(&turned(&stretch.turn)));
            scales.push(stretch.scale.map(|x| x as f32).into());
            axes.push(quaternion(&turned(&stretch.axes.transpose())));
        }
        let linear = |node, keys| Track { node, keys, holds: false };
        [
            linear(self.outer, ChannelKeys::Translation(places)),
            linear(self.outer, ChannelKeys::Rotation(continuous(turns))),
            linear(self.outer, ChannelKeys::Scale(scales)),
            linear(self.inner, ChannelKeys::Rotation(continuous(axes))),
        ]
    }
}
