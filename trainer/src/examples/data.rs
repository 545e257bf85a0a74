//! Examples: posed meshes of one character, and its joints.

use crate::mesh::{EngineMesh, Surface, normals};
use crate::space::millimetres;
use sinew_runtime::format::Space;
use std::ops::Range;

/// A rigid or affine map as three rows of four: `y = m[..][0..3] x + m[..][3]`.
pub type Matrix3x4 = [[f64; 4]; 3];

/// Which use a frame is put to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Split {
    /// Read by the fit and by every choice.
    Train,
    /// Read only to report, after every choice is made.
    HeldOut,
    /// Reported apart: poses beyond the range of motion of the training frames.
    Extreme,
}

impl Split {
    /// Returns its name, as on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Train => "train",
            Self::HeldOut => "held-out",
            Self::Extreme => "extreme",
        }
    }
}

/// The joints of a character: one reference root, every other joint with one parent.
#[derive(Clone, Debug)]
pub struct Skeleton {
    /// J names.
    pub names: Vec<String>,
    /// Parent of each joint; `None` for the reference root alone. Parents may follow children.
    pub parents: Vec<Option<usize>>,
    /// Joints that have no parent where they come from, and here hang under the reference root.
    pub roots: Vec<usize>,
    /// Joints of which the source does not say where they are at rest: [`Examples::place_joints`] finds it.
    pub unplaced: Vec<usize>,
    /// Model-space rest frame of each joint (rigid); its last column is the rest origin.
    pub rest: Vec<Matrix3x4>,
}

impl Skeleton {
    /// Gives the reference root, the first joint without a parent.
    pub fn root(&self) -> usize {
        self.parents.iter().position(Option::is_none).unwrap_or(0)
    }

    /// Gives the parent of each joint where it comes from; several may have none.
    pub fn own_parents(&self) -> Vec<Option<usize>> {
        let own = |(joint, parent): (usize, &Option<usize>)| {
            parent.filter(|_| !self.roots.contains(&joint))
        };
        self.parents.iter().enumerate().map(own).collect()
    }
}

/// N poses of one mesh of V vertices and T triangles on J joints, in the units of the input.
#[derive(Clone, Debug)]
pub struct Examples {
    /// Rest positions, V.
    pub rest: Vec<[f64; 3]>,
    /// Vertex numbers of each triangle, T; quads are split along their first diagonal.
    pub triangles: Vec<[usize; 3]>,
    /// The vertices that an engine draws it with, and what the artist authored of them: normals, tangents,
    /// texture coordinates. Without, they are the V, and nothing is authored.
    pub engine: Option<EngineMesh>,
    /// The joints.
    pub skeleton: Skeleton,
    /// Posed positions, N x V, frame-major.
    pub vertices: Vec<[f64; 3]>,
    /// Whether the posed positions are those of the scene's own skin and shapes, so that each mesh belongs to its pose.
    pub own_skin: bool,
    /// Map from the rest pose to the pose of each joint, N x J, frame-major, model space.
    pub transforms: Vec<Matrix3x4>,
    /// Use of each frame, N.
    pub split: Vec<Split>,
    /// The meshes that were joined, by name: ranges of vertices, one after the other; none where there
    /// was one, or nothing is known of them.
    pub ranges: Vec<(String, Range<usize>)>,
    /// First frame of each clip, ascending from 0: neighbours across one are no more alike than others.
    pub clip_starts: Vec<usize>,
    /// Axes, handedness and unit, as far as they are known.
    pub space: Space,
    /// Joint weights as an artist painted them, V x J, vertex-major: which joints are near a vertex, where poses do not
    /// tell which it follows. A vertex may have none.
    pub joint_weights: Option<Vec<f64>>,
    /// How much each vertex counts in a fit and in what is measured of it, V numbers of mean 1; all
    /// alike without. [`Examples::weigh`] sets it.
    pub importance: Option<Vec<f64>>,
    /// How often each frame counts in a fit, N; once without. [`Examples::repeat`] sets it.
    pub frame_weights: Option<Vec<u8>>,
}

impl Examples {
    /// Counts the vertices, V.
    pub fn vertex_len(&self) -> usize {
        self.rest.len()
    }

    /// Counts the frames, N.
    pub fn frame_len(&self) -> usize {
        self.split.len()
    }

    /// The same, some frames no longer among those of training.
    #[must_use]
    pub fn without(&self, frames: &[usize]) -> Self {
        let mut others = self.clone();
        frames.iter().for_each(|&frame| others.split[frame] = Split::Extreme);
        others
    }

    /// Returns a copy whose training frames are these; other training frames are held out.
    #[must_use]
    pub fn trained_on(&self, frames: &[usize]) -> Self {
        let mut others = self.clone();
        others
            .split
            .iter_mut()
            .filter(|split| **split == Split::Train)
            .for_each(|split| *split = Split::HeldOut);
        frames.iter().for_each(|&frame| others.split[frame] = Split::Train);
        others
    }

    /// Returns the diagonal of the rest pose's bounding box in millimetres; `None` where the unit is not known.
    pub fn diagonal_mm(&self) -> Option<f64> {
        millimetres(&self.space).map(|unit| unit * self.diagonal())
    }

    /// Finds the number of the clip that a frame is of.
    pub fn clip_of(&self, frame: usize) -> usize {
        self.clip_starts.partition_point(|&first| first <= frame)
    }

    /// Counts the joints, J.
    pub fn joint_len(&self) -> usize {
        self.skeleton.names.len()
    }

    /// Gives the rest mesh as an engine draws it.
    pub fn surface(&self) -> Surface<'_> {
        Surface { positions: &self.rest, triangles: &self.triangles, engine: self.engine.as_ref() }
    }

    /// Computes the V unit normals of frame `index`, weighted by triangle area; zero where there is none.
    ///
    /// # Panics
    /// If `index` is not a frame.
    pub fn posed_normals(&self, index: usize) -> Vec<[f64; 3]> {
        normals(self.frame(index), &self.triangles)
    }

    /// Measures the diagonal of the rest pose's bounding box, to which every error is related.
    pub fn diagonal(&self) -> f64 {
        let [low, high] = self.bounds();
        let extent = [0, 1, 2].map(|axis| (high[axis] - low[axis]).max(0.0));
        extent.iter().map(|length| length * length).sum::<f64>().sqrt()
    }

    /// Returns the step of single precision at the largest coordinate, as a share of the diagonal; 0 where positions are
    /// given more finely. Of training frames, which may travel, the median counts.
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

    /// Gives the lowest and the highest corner of the rest pose's bounding box.
    pub fn bounds(&self) -> [[f64; 3]; 2] {
        let mut low = [f64::INFINITY; 3];
        let mut high = [f64::NEG_INFINITY; 3];
        for position in &self.rest {
            for axis in 0..3 {
                low[axis] = low[axis].min(position[axis]);
                high[axis] = high[axis].max(position[axis]);
            }
        }
        [low, high]
    }

    /// Gives the mean of the rest positions.
    pub fn centroid(&self) -> [f64; 3] {
        let mut sum = [0.0; 3];
        for position in &self.rest {
            for axis in 0..3 {
                sum[axis] += position[axis];
            }
        }
        sum.map(|sum| sum / self.vertex_len().max(1) as f64)
    }

    /// Gives the V posed positions of frame `index`.
    ///
    /// # Panics
    /// If `index` is not a frame.
    pub fn frame(&self, index: usize) -> &[[f64; 3]] {
        let vertex_len = self.vertex_len();
        &self.vertices[index * vertex_len..][..vertex_len]
    }

    /// Gives the J maps from the rest pose to the pose of frame `index`.
    ///
    /// # Panics
    /// If `index` is not a frame.
    pub fn pose(&self, index: usize) -> &[Matrix3x4] {
        let joint_len = self.joint_len();
        &self.transforms[index * joint_len..][..joint_len]
    }

    /// Lists the frames put to one use, in order.
    pub fn frames_of(&self, split: Split) -> Vec<usize> {
        (0..self.frame_len()).filter(|&frame| self.split[frame] == split).collect()
    }
}
