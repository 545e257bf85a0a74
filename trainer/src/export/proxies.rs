//! Proxies as nodes: chains of two, which hold what no single node can.

use nalgebra::{Matrix3, Vector3};
use rayon::prelude::*;
use sinew_runtime::Matrix3x4;

use super::glb::{Document, Keys, NodeIndex, Placed, Track};
use super::skeleton::{continuous, quaternion, turned};
use super::stretch::Stretch;

/// The proxies of a palette as nodes of a document.
///
/// A node moves, turns and scales along its own axes. A proxy's map scales along axes of its own
/// choice: its outer node moves, turns and scales, and its inner node, the joint of the skin, turns
/// the axes back.
pub(super) struct Proxies {
    chains: Vec<Chain>,
    /// Inverse bind matrices of the inner nodes.
    pub(super) inverse_binds: Vec<Matrix3x4>,
}

struct Chain {
    outer: NodeIndex,
    inner: NodeIndex,
    centre: [f32; 3],
}

impl Proxies {
    /// Adds proxies under a node, which stands in the model's own space, each in the centre of what
    /// it moves.
    pub(super) fn new(document: &mut Document, under: NodeIndex, centres: &[[f64; 3]]) -> Self {
        let mut proxies = Self { chains: Vec::new(), inverse_binds: Vec::new() };
        for (number, centre) in centres.iter().enumerate() {
            let centre = centre.map(|x| x as f32);
            let placed = Placed { translation: centre, ..Placed::AT_PARENT };
            let outer = document.node(format!("proxy_{number}"), Some(under), &placed);
            let name = format!("proxy_{number}_axes");
            let inner = document.node(name, Some(outer), &Placed::AT_PARENT);
            proxies.chains.push(Chain { outer, inner, centre });
            let [x, y, z] = centre.map(|x| -x);
            proxies.inverse_binds.push([
                [1.0, 0.0, 0.0, x],
                [0.0, 1.0, 0.0, y],
                [0.0, 0.0, 1.0, z],
            ]);
        }
        proxies
    }

    /// Gives the joints that the proxies are in a skin.
    pub(super) fn joints(&self) -> impl Iterator<Item = NodeIndex> + '_ {
        self.chains.iter().map(|chain| chain.inner)
    }

    /// Tracks the proxies through palettes, at whose ends their maps stand.
    pub(super) fn tracks(&self, palettes: &[Vec<Matrix3x4>]) -> Vec<Track> {
        let len = self.chains.len();
        let tracks: Vec<Vec<Track>> = self
            .chains
            .par_iter()
            .enumerate()
            .map(|(proxy, chain)| {
                let maps = palettes.iter().map(|palette| &palette[palette.len() - len + proxy]);
                chain.tracks(maps)
            })
            .collect();
        tracks.into_iter().flatten().collect()
    }
}

impl Chain {
    fn tracks<'a>(&self, maps: impl Iterator<Item = &'a Matrix3x4>) -> Vec<Track> {
        let centre = Vector3::from(self.centre.map(f64::from));
        let (mut places, mut turns, mut scales, mut axes) = (vec![], vec![], vec![], vec![]);
        let mut before: Option<Stretch> = None;
        for map in maps {
            let linear = Matrix3::from_fn(|row, column| f64::from(map[row][column]));
            let moved = Vector3::from(map.map(|row| f64::from(row[3])));
            let stretch = Stretch::of(&linear, before.as_ref());
            before = Some(stretch);
            places.push((linear * centre + moved).map(|x| x as f32).into());
            turns.push(quaternion(&turned(&stretch.turn)));
            scales.push(stretch.scale.map(|x| x as f32).into());
            axes.push(quaternion(&turned(&stretch.axes.transpose())));
        }
        vec![
            Track { node: self.outer, keys: Keys::Translation(places) },
            Track { node: self.outer, keys: Keys::Rotation(continuous(turns)) },
            Track { node: self.outer, keys: Keys::Scale(scales) },
            Track { node: self.inner, keys: Keys::Rotation(continuous(axes)) },
        ]
    }
}
