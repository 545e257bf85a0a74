//! Proxies as nodes: each proxy is a chain of two nodes, because no single node can hold its map.

use nalgebra::{Isometry3, Matrix3, Vector3};
use rayon::prelude::*;
use sinew_runtime::Matrix3x4;

use super::skeleton::{Carrier, continuous, quaternion, turned};
use super::stretch::Stretch;
use crate::formats::gltf::write::{ChannelKeys, Document, NodeIndex, Placed, Track};

/// The proxies of a palette as nodes of a document.
///
/// Each proxy is a child of the joint whose motion is nearest, so that the proxy moves with the skeleton between two
/// keys. A node moves, rotates and scales along its own axes, but a proxy's map scales along other axes. The outer node
/// moves, rotates and scales. The inner node, the joint of the skin, rotates the axes back.
pub(super) struct ProxyNodes {
    chains: Vec<Chain>,
    /// Inverse bind matrices of the inner nodes, in the model's unit.
    pub(super) inverse_binds: Vec<Matrix3x4>,
}

struct Chain {
    outer: NodeIndex,
    inner: NodeIndex,
    centre: [f32; 3],
    joint: usize,
    unit: f64,
}

impl ProxyNodes {
    /// Adds proxies under the joints that carry them, each at its centre.
    pub(super) fn new(
        document: &mut Document,
        joints: &[Carrier],
        centres: &[[f64; 3]],
        carriers: &[usize],
    ) -> Self {
        let mut proxies = Self { chains: Vec::new(), inverse_binds: Vec::new() };
        for (number, (centre, &joint)) in centres.iter().zip(carriers).enumerate() {
            let centre = centre.map(|x| x as f32);
            let Carrier { node, ref at_rest, unit } = joints[joint];
            let back = at_rest.inverse();
            let place = back.transform_point(&centre.map(f64::from).into());
            let placed = Placed {
                translation: place.coords.map(|x| (x / unit) as f32).into(),
                rotation: quaternion(&back.rotation),
                scale: [1.0; 3],
            };
            let name = format!("proxy_{number}");
            let outer = document.node(name, Some(node), &placed);
            let name = format!("proxy_{number}_axes");
            let inner = document.node(name, Some(outer), &Placed::AT_PARENT);
            proxies.chains.push(Chain { outer, inner, centre, joint, unit });
            let [x, y, z] = centre.map(|x| -x);
            proxies.inverse_binds.push([
                [1.0, 0.0, 0.0, x],
                [0.0, 1.0, 0.0, y],
                [0.0, 0.0, 1.0, z],
            ]);
        }
        proxies
    }

    /// Lists the nodes of the proxies in a skin.
    pub(super) fn joints(&self) -> impl Iterator<Item = NodeIndex> + '_ {
        self.chains.iter().map(|chain| chain.inner)
    }

    /// Makes the tracks of the proxies through palettes, whose last maps are the proxies' maps. `joints` are the world
    /// frames of the joints.
    pub(super) fn tracks(
        &self,
        palettes: &[Vec<Matrix3x4>],
        joints: &[Vec<Isometry3<f64>>],
    ) -> Vec<Track> {
        let len = self.chains.len();
        let tracks = self.chains.par_iter().enumerate().flat_map_iter(|(proxy, chain)| {
            let maps = palettes.iter().map(|palette| &palette[palette.len() - len + proxy]);
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
    fn tracks<'a>(
        &self,
        keys: impl Iterator<Item = (&'a Matrix3x4, &'a Isometry3<f64>)>,
    ) -> [Track; 4] {
        let centre = Vector3::from(self.centre.map(f64::from));
        let (mut places, mut turns, mut scales, mut axes) = (vec![], vec![], vec![], vec![]);
        let mut before: Option<Stretch> = None;
        for (map, joint) in keys {
            let back = joint.inverse();
            let linear = Matrix3::from_fn(|row, column| f64::from(map[row][column]));
            let moved = linear * centre + Vector3::from(map.map(|row| f64::from(row[3])));
            let linear = back.rotation.to_rotation_matrix() * linear;
            let stretch = Stretch::of(&linear, before.as_ref());
            before = Some(stretch);
            let place = back.transform_point(&moved.into()).coords / self.unit;
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
