//! Examples: posed meshes of one character, and its joints.

use crate::mesh::{EngineMesh, Surface, normals};
use crate::space::{Conversion, millimetres};
use rayon::prelude::*;
use sinew_runtime::format::Space;
use std::ops::Range;

/// A rigid or affine map as three rows of four: `y = m[..][0..3] x + m[..][3]`.
pub type Matrix3x4 = [[f64; 4]; 3];

/// Use of a frame. The numbers are the codes in files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Split {
    /// Training: the fit and every choice read the frame.
    Train = 0,
    /// Test: read only for reports, after every choice is made.
    HeldOut = 1,
    /// Test with poses outside the training range, reported separately.
    Extreme = 2,
}

impl Split {
    /// Returns the name used on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Train => "train",
            Self::HeldOut => "held-out",
            Self::Extreme => "extreme",
        }
    }
}

/// Joints of a character: a tree with one root.
#[derive(Clone, Debug, Default)]
pub struct Skeleton {
    /// Names, J.
    pub names: Vec<String>,
    /// Parent of each joint, J; `None` only for the root. A parent may come after its children.
    pub parents: Vec<Option<usize>>,
    /// Joints without a parent in the source, which became children of the root.
    pub roots: Vec<usize>,
    /// Joints without a rest position in the source. [`Examples::place_joints`] estimates the position.
    pub unplaced: Vec<usize>,
    /// Rest frame of each joint in model space, J, rigid. The last column is the rest origin.
    pub rest: Vec<Matrix3x4>,
    /// Whether the source has no joint: the skin follows curves alone. The skeleton is then one joint that never moves,
    /// and a model has none.
    pub is_still: bool,
}

impl Skeleton {
    /// Makes the skeleton of a source without joints.
    pub fn still() -> Self {
        Self {
            names: vec!["still".to_owned()],
            parents: vec![None],
            rest: vec![translation([0.0; 3])],
            is_still: true,
            ..Self::default()
        }
    }

    /// Returns the root: the first joint without a parent.
    pub fn root(&self) -> usize {
        self.parents.iter().position(Option::is_none).unwrap_or(0)
    }

    /// Returns the parent of each joint in the source, J; several joints may have none.
    pub fn own_parents(&self) -> Vec<Option<usize>> {
        let own = |(joint, parent): (usize, &Option<usize>)| {
            parent.filter(|_| !self.roots.contains(&joint))
        };
        self.parents.iter().enumerate().map(own).collect()
    }
}

/// N poses of a mesh with V vertices and T triangles on J joints, in the input's units.
#[derive(Clone, Debug, Default)]
pub struct Examples {
    /// Rest positions, V.
    pub rest: Vec<[f64; 3]>,
    /// Vertex numbers of each triangle, T. Quads are split along their first diagonal.
    pub triangles: Vec<[usize; 3]>,
    /// Engine vertices, with authored normals, tangents and texture coordinates. `None` if the engine vertices are the
    /// V and nothing is authored.
    pub engine: Option<EngineMesh>,
    /// The joints.
    pub skeleton: Skeleton,
    /// Posed positions, N x V, frame-major.
    pub vertices: Vec<[f64; 3]>,
    /// Whether the posed positions come from the scene's own skin and shapes. Then every mesh matches its pose.
    pub own_skin: bool,
    /// Map from the rest pose to the posed joint, N x J, frame-major, model space.
    pub transforms: Vec<Matrix3x4>,
    /// Names of the curves, C.
    pub curve_names: Vec<String>,
    /// Values of the curves, N x C, frame-major; 0 at rest.
    pub curves: Vec<f64>,
    /// Use of each frame, N.
    pub split: Vec<Split>,
    /// Names and consecutive vertex ranges of the joined meshes; empty for a single mesh, or if unknown.
    pub ranges: Vec<(String, Range<usize>)>,
    /// First frame of each clip, ascending from 0. Frames on either side of a clip's start are not neighbours in time.
    pub clip_starts: Vec<usize>,
    /// Axes, handedness and unit, where known.
    pub space: Space,
    /// Painted joint weights, V x J, vertex-major. They show which joints are near a vertex if the poses do not. A
    /// vertex may have none.
    pub joint_weights: Option<Vec<f64>>,
    /// Weight of each vertex in fits and in measured errors, V, of mean 1; `None` for equal weights. Set by
    /// [`Examples::set_importance`].
    pub importance: Option<Vec<f64>>,
    /// Number of times each frame counts in a fit, N; `None` for once. Set by [`Examples::repeat`].
    pub frame_weights: Option<Vec<u8>>,
}

impl Examples {
    /// Returns the number of vertices, V.
    pub fn vertex_len(&self) -> usize {
        self.rest.len()
    }

    /// Returns the number of frames, N.
    pub fn frame_len(&self) -> usize {
        self.split.len()
    }

    /// Returns a copy in which some frames no longer train.
    #[must_use]
    pub fn without(&self, frames: &[usize]) -> Self {
        let mut others = self.clone();
        frames.iter().for_each(|&frame| others.split[frame] = Split::Extreme);
        others
    }

    /// Returns a copy with these training frames; other training frames become held-out frames.
    #[must_use]
    pub fn trained_on(&self, frames: &[usize]) -> Self {
        let mut others = self.clone();
        self.frames_of(Split::Train).iter().for_each(|&f| others.split[f] = Split::HeldOut);
        frames.iter().for_each(|&frame| others.split[frame] = Split::Train);
        others
    }

    /// Returns the diagonal of the rest mesh's bounding box in millimetres; `None` if the unit is unknown.
    pub fn diagonal_mm(&self) -> Option<f64> {
        millimetres(&self.space).map(|unit| unit * self.diagonal())
    }

    /// Returns the number of the clip that contains a frame, counted from 1.
    pub fn clip_of(&self, frame: usize) -> usize {
        self.clip_starts.partition_point(|&first| first <= frame)
    }

    /// Returns the number of joints, J.
    pub fn joint_len(&self) -> usize {
        self.skeleton.names.len()
    }

    /// Returns the rest mesh with its engine vertices.
    pub fn surface(&self) -> Surface<'_> {
        Surface { positions: &self.rest, triangles: &self.triangles, engine: self.engine.as_ref() }
    }

    /// Computes the V unit normals of frame `index`, weighted by triangle area; zero for vertices without area.
    ///
    /// # Panics
    /// If `index` is not a frame.
    pub fn posed_normals(&self, index: usize) -> Vec<[f64; 3]> {
        normals(self.frame(index), &self.triangles)
    }

    /// Returns the diagonal of the rest mesh's bounding box, the reference length of every error.
    pub fn diagonal(&self) -> f64 {
        diagonal(self.rest.iter().copied())
    }

    /// Returns the step of f32 at the largest coordinate, relative to the diagonal; 0 if the positions have more digits
    /// than f32. Training frames may travel, so their median counts.
    pub fn coarseness(&self) -> f64 {
        let farthest = |points: &[[f64; 3]]| {
            let all = points.as_flattened();
            let is_single = all.iter().all(|x| f64::from(*x as f32) == *x);
            if is_single { all.iter().fold(0.0, |far: f64, x| far.max(x.abs())) } else { 0.0 }
        };
        let frames = self.frames_of(Split::Train);
        let mut posed: Vec<f64> = frames.into_iter().map(|i| farthest(self.frame(i))).collect();
        posed.sort_by(f64::total_cmp);
        let median = posed.get(posed.len() / 2).copied().unwrap_or(0.0);
        f64::from(f32::EPSILON) * farthest(&self.rest).max(median) / self.diagonal()
    }

    /// Returns the lowest and highest corner of the rest mesh's bounding box.
    pub fn bounds(&self) -> [[f64; 3]; 2] {
        bounds(self.rest.iter().copied())
    }

    /// Returns the mean of the rest positions.
    pub fn centroid(&self) -> [f64; 3] {
        let add = |sum: [f64; 3], x: &[f64; 3]| [0, 1, 2].map(|axis| sum[axis] + x[axis]);
        let sum = self.rest.iter().fold([0.0; 3], add);
        sum.map(|sum| sum / self.vertex_len().max(1) as f64)
    }

    /// Returns the posed positions of frame `index`, V.
    ///
    /// # Panics
    /// If `index` is not a frame.
    pub fn frame(&self, index: usize) -> &[[f64; 3]] {
        let vertex_len = self.vertex_len();
        &self.vertices[index * vertex_len..][..vertex_len]
    }

    /// Returns the maps from rest pose to pose of frame `index`, J.
    ///
    /// # Panics
    /// If `index` is not a frame.
    pub fn pose(&self, index: usize) -> &[Matrix3x4] {
        let joint_len = self.joint_len();
        &self.transforms[index * joint_len..][..joint_len]
    }

    /// Returns the curves of frame `index`, C.
    ///
    /// # Panics
    /// If `index` is not a frame.
    pub fn curves_of(&self, index: usize) -> &[f64] {
        let curve_len = self.curve_names.len();
        &self.curves[index * curve_len..][..curve_len]
    }

    /// Lists the frames with one use, in order.
    pub fn frames_of(&self, split: Split) -> Vec<usize> {
        (0..self.frame_len()).filter(|&frame| self.split[frame] == split).collect()
    }

    /// Converts the examples to another space; texture coordinates stay.
    pub fn convert(&mut self, conversion: &Conversion, space: Space) {
        self.rest.iter_mut().for_each(|x| *x = conversion.point(*x));
        self.vertices.par_iter_mut().for_each(|x| *x = conversion.point(*x));
        self.skeleton.rest.iter_mut().for_each(|frame| *frame = conversion.transform(frame));
        self.transforms.par_iter_mut().for_each(|b| *b = conversion.transform(b));
        conversion.triangles(&mut self.triangles);
        if let Some(engine) = &mut self.engine {
            engine.turn(|direction| conversion.direction(direction), conversion.is_mirrored());
        }
        self.space = space;
    }

    /// Converts the examples to a model's space, where both spaces are known. Returns the conversion, which other
    /// meshes of the same file need too; `None` if nothing changes.
    pub fn convert_to(&mut self, space: &Space) -> Option<Conversion> {
        let conversion = Conversion::between(&self.space, space)?;
        self.convert(&conversion, *space);
        Some(conversion)
    }

    /// Removes the engine vertices if a skin has as many vertices as the mesh: the skin was trained without them.
    pub fn unsplit_for(&mut self, skin_vertex_len: usize) {
        if skin_vertex_len == self.vertex_len() && skin_vertex_len != self.surface().engine_len() {
            self.engine = None;
        }
    }
}

/// Returns the lowest and highest corner of the points' bounding box; infinities for no points.
pub(super) fn bounds(points: impl Iterator<Item = [f64; 3]>) -> [[f64; 3]; 2] {
    points.fold([[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]], |[low, high], x| {
        let axes = [0, 1, 2];
        [axes.map(|axis| low[axis].min(x[axis])), axes.map(|axis| high[axis].max(x[axis]))]
    })
}

/// Returns the diagonal of the points' bounding box; 0 for no points.
pub(crate) fn diagonal(points: impl Iterator<Item = [f64; 3]>) -> f64 {
    let [low, high] = bounds(points);
    let extent = [0, 1, 2].map(|axis| (high[axis] - low[axis]).max(0.0));
    extent.iter().map(|length| length * length).sum::<f64>().sqrt()
}

/// Returns the rigid map that moves by a vector.
pub(super) fn translation([x, y, z]: [f64; 3]) -> Matrix3x4 {
    [[1.0, 0.0, 0.0, x], [0.0, 1.0, 0.0, y], [0.0, 0.0, 1.0, z]]
}

/// Returns at most `most` evenly spaced numbers below `len`, ascending.
pub(crate) fn spread(len: usize, most: usize) -> Vec<usize> {
    let count = len.min(most);
    (0..count).map(|number| number * len / count).collect()
}

#[cfg(test)]
mod tests {
    use super::super::testing::triangle;
    use super::*;
    use crate::mesh::EngineMesh;

    #[test]
    fn converting_there_and_back_restores_the_examples() {
        let mut examples = triangle(2);
        let uv = vec![[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]];
        examples.engine = Some(EngineMesh::of_vertices(&examples.rest, &examples.triangles, &uv));
        examples.vertices[4] = [0.5, -0.25, 0.125];
        examples.transforms[3][0][3] = 0.75;
        examples.space = Space::GLTF;
        let before = examples.clone();
        for space in [Space::UNITY, Space::UNREAL] {
            let there = examples.convert_to(&space).unwrap();
            assert!(examples.space == space && there.is_mirrored());
            assert_eq!(examples.triangles, [[0, 2, 1]]);
            examples.validate().unwrap();
            // Normals and tangents turn with the surface. A mirrored cross product changes the handedness.
            assert_eq!(
                examples.surface().normals(),
                before.surface().normals().iter().map(|n| there.direction(*n)).collect::<Vec<_>>()
            );
            let tangents =
                before.surface().tangents().unwrap().into_iter().map(|[x, y, z, hand]| {
                    let [x, y, z] = there.direction([x, y, z]);
                    [x, y, z, -hand]
                });
            assert_eq!(examples.surface().tangents().unwrap(), tangents.collect::<Vec<_>>());
            examples.convert_to(&Space::GLTF).unwrap();
            assert_eq!(examples.rest, before.rest);
            assert_eq!(examples.vertices, before.vertices);
            assert_eq!(examples.transforms, before.transforms);
            assert_eq!(examples.skeleton.rest, before.skeleton.rest);
            assert_eq!(examples.triangles, before.triangles);
            assert_eq!(examples.engine, before.engine);
        }
        assert_eq!(examples.convert_to(&Space::GLTF), None);
    }
}
