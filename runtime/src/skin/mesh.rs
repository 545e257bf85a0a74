//! The rest mesh at once, and which mesh it is.

use super::view::Skin;
use crate::format::crc;
use crate::linear::{Le, floats};

impl<'a> Skin<'a> {
    /// Lists the V rest positions.
    pub fn rest_positions(&self) -> impl ExactSizeIterator<Item = [f32; 3]> + use<'a> {
        self.positions().iter().take(self.vertex_len()).map(floats)
    }

    /// Lists the V rest normals.
    pub fn rest_normals(&self) -> impl ExactSizeIterator<Item = [f32; 3]> + use<'a> {
        self.normals().iter().take(self.vertex_len()).map(floats)
    }

    /// Returns the hash of the rest positions, [`mesh_hash_of`] in the file's order: a reload of a file of another mesh,
    /// or of the same in another order, shows itself.
    pub fn mesh_hash(&self) -> u32 {
        self.positions().iter().take(self.vertex_len()).fold(0, with_vertex)
    }
}

/// Computes the hash of a mesh: a CRC-32, from 0 on of vertex after vertex, each time of the hash so far as a
/// little-endian u32 and of the position's bits likewise.
///
/// - `positions`: at rest, in the file's order; of an engine that has kept what it read of the file.
///
/// ```
/// use sinew_runtime::mesh_hash_of;
///
/// let hash = mesh_hash_of(&[[0.0, 1.0, 2.0], [0.5, 1.0, 2.0]]);
/// assert_ne!(hash, mesh_hash_of(&[[0.5, 1.0, 2.0], [0.0, 1.0, 2.0]]));
/// ```
pub fn mesh_hash_of(positions: &[[f32; 3]]) -> u32 {
    positions.iter().fold(0, |hash, position| with_vertex(hash, &position.map(f32::to_le_bytes)))
}

fn with_vertex(hash: u32, position: &[Le; 3]) -> u32 {
    crc::of(&[&hash.to_le_bytes(), position.as_flattened()])
}
