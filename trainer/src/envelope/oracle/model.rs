//! What the oracle reads, and the stages but those of the correction.

use super::group::Group;
use super::maps::{after, cofactors, linear, seen_from, stack, symmetric};
use crate::kernel::map::step;
use crate::numeric::so3;
use nalgebra::{DMatrix, Matrix3, Matrix3x4, Matrix6, Vector3, Vector4, Vector6};
use sinew_runtime::envelope::Predictor;
use sinew_runtime::{Envelope, Skin};

/// An envelope's arrays and those of a skin that follows it, widened.
pub struct Oracle {
    /// What the palette is made of.
    pub predictor: Predictor,
    /// The joint without a parent.
    pub root: usize,
    /// Parent of each joint, J.
    pub parents: Vec<Option<usize>>,
    /// Largest |θ| of each joint in training, J.
    pub pose_ranges: Vec<f64>,
    /// Key predictors, P; none of the kernel predictor, as of c1 and c2.
    pub keys: Vec<Key>,
    /// c1, 4P x 3P.
    pub c1: DMatrix<f64>,
    /// c2, 4P x 4J.
    pub c2: DMatrix<f64>,
    /// Rest origin of each joint, J; 0 without a correction.
    pub origins: Vec<Vector3<f64>>,
    /// Groups of proxies that share a kernel map.
    pub groups: Vec<Group>,
    /// The skin's vertices, V; none without a skin.
    pub vertices: Vec<Vertex>,
}

/// A key predictor.
pub struct Key {
    /// b.
    pub joint: usize,
    /// A = u W.
    pub twist: Matrix3<f64>,
    /// c and A' = u' W'.
    pub residual: Option<(usize, Matrix3<f64>)>,
    /// H, rows xx, xy, xz, yy, yz, zz.
    pub shear: Matrix6<f64>,
}

/// A vertex of the rest pose.
pub struct Vertex {
    /// `[x̂ 1]`.
    pub position: Vector4<f64>,
    /// Unit normal, or 0.
    pub normal: Vector3<f64>,
    /// Unit tangent and handedness.
    pub tangent: Option<(Vector3<f64>, f64)>,
    /// Palette index and weight, K.
    pub influences: Vec<(usize, f64)>,
}

/// What a key's gradient is the product of: `D = Q_p exp(twist) [exp(residual)] stretch`.
pub struct Factors {
    /// Q_p, I for the root.
    pub parent: Matrix3<f64>,
    /// A θ_b, radians.
    pub twist: Vector3<f64>,
    /// A' θ_c, radians.
    pub residual: Option<Vector3<f64>>,
    /// S.
    pub stretch: Matrix3<f64>,
}

/// A skinned vertex.
pub struct Skinned {
    /// Position, model space.
    pub position: Vector3<f64>,
    /// Unit normal; the rest normal where the map leaves it no direction.
    pub normal: Vector3<f64>,
    /// Unit tangent likewise, and handedness.
    pub tangent: Option<(Vector3<f64>, f64)>,
}

impl Oracle {
    /// Widens the arrays of a loaded envelope, and of a skin that follows it.
    pub fn new(envelope: &Envelope<'_>, skin: Option<&Skin<'_>>) -> Self {
        let j = envelope.joint_len();
        let widened = |value: Option<f32>| value.map_or(f64::NAN, f64::from);
        let origin = |joint| Vector3::from(envelope.origin(joint).unwrap_or_default());
        let keys: Vec<_> = (0..envelope.proxy_len()).filter_map(|l| envelope.key(l)).collect();
        let p = keys.len();
        Self {
            predictor: envelope.predictor(),
            root: envelope.root(),
            parents: (0..j).map(|joint| envelope.parent(joint)).collect(),
            pose_ranges: (0..j).map(|joint| widened(envelope.pose_range(joint))).collect(),
            keys: keys.iter().map(Key::new).collect(),
            c1: DMatrix::from_fn(4 * p, 3 * p, |r, c| widened(envelope.c1(r, c))),
            c2: DMatrix::from_fn(4 * p, 4 * j, |r, c| widened(envelope.c2(r, c))),
            origins: (0..j).map(|joint| origin(joint).map(f64::from)).collect(),
            groups: envelope.groups().map(|group| Group::new(&group)).collect(),
            vertices: skin.map_or(Vec::new(), Vertex::all),
        }
    }

    /// Evaluates a pose of J skinning matrices from end to end: the palette, and the confidence in
    /// it.
    pub fn evaluate(&self, pose: &[Matrix3x4<f64>]) -> (Vec<Matrix3x4<f64>>, f64) {
        if !self.predictor.reconstructs() {
            return self.correct(pose, &self.features(pose), self.joints(pose));
        }
        let relative = self.relative(pose);
        let rotations = self.rotations(&relative);
        let gradients = self.gradients(&relative, &rotations);
        let palette = self.palette(&pose[self.root], &relative, &gradients);
        if self.predictor.corrects() {
            return self.correct(pose, &self.features(pose), palette);
        }
        (palette, self.confidence(&rotations))
    }

    /// Removes the root's motion from J maps: `B_r⁻¹ B_j`, B_r taken as rigid (METHOD §1.1).
    pub fn relative(&self, pose: &[Matrix3x4<f64>]) -> Vec<Matrix3x4<f64>> {
        let unmoved = |(joint, map): (usize, &Matrix3x4<f64>)| match joint == self.root {
            true => Matrix3x4::identity(),
            false => seen_from(&pose[self.root], map),
        };
        pose.iter().enumerate().map(unmoved).collect()
    }

    /// Returns θ_j = log(Q_pᵀ Q_j) of J relative maps, of the nearest rotation, 0 for the root.
    pub fn rotations(&self, relative: &[Matrix3x4<f64>]) -> Vec<Vector3<f64>> {
        let angle = |(joint, parent): (usize, &Option<usize>)| {
            let Some(parent) = parent else { return Vector3::zeros() };
            let turn = linear(&relative[*parent]).transpose() * linear(&relative[joint]);
            so3::polar(&turn).map_or(Vector3::zeros(), |(rotation, _)| so3::log(&rotation))
        };
        self.parents.iter().enumerate().map(angle).collect()
    }

    /// Evaluates the factors of a key's gradient (METHOD §1.4, §1.5).
    pub fn factors(
        &self,
        key: &Key,
        relative: &[Matrix3x4<f64>],
        rotations: &[Vector3<f64>],
    ) -> Factors {
        let parent = self.parents[key.joint];
        let s = key.shear * self.joint_and_parent(key, rotations);
        Factors {
            parent: parent.map_or(Matrix3::identity(), |p| linear(&relative[p])),
            twist: key.twist * rotations[key.joint],
            residual: key.residual.map(|(joint, twist)| twist * rotations[joint]),
            stretch: Matrix3::identity() + symmetric(&s),
        }
    }

    /// Returns `[θ_b; θ_p]` of a key.
    pub fn joint_and_parent(&self, key: &Key, rotations: &[Vector3<f64>]) -> Vector6<f64> {
        let own = rotations[key.joint];
        let above = self.parents[key.joint].map_or(Vector3::zeros(), |p| rotations[p]);
        Vector6::new(own.x, own.y, own.z, above.x, above.y, above.z)
    }

    /// Predicts the P gradients, root motion removed.
    pub fn gradients(
        &self,
        relative: &[Matrix3x4<f64>],
        rotations: &[Vector3<f64>],
    ) -> Vec<Matrix3<f64>> {
        self.keys.iter().map(|key| self.factors(key, relative, rotations).gradient()).collect()
    }

    /// Evaluates `t = c1 d + c2 q` and moves it by the root's map: P maps (METHOD §1.7.3).
    pub fn palette(
        &self,
        root: &Matrix3x4<f64>,
        relative: &[Matrix3x4<f64>],
        gradients: &[Matrix3<f64>],
    ) -> Vec<Matrix3x4<f64>> {
        let t = &self.c1 * stack(gradients) + &self.c2 * stack(relative);
        let maps = (0..self.keys.len()).map(|l| t.fixed_view::<4, 3>(4 * l, 0).transpose());
        maps.map(|map| after(root, &map)).collect()
    }

    /// Returns the confidence in J rotations of a rotational model, the least over the joints: 1
    /// within a joint's trained range, 0 from half of it and 0.1 rad beyond (FORMAT.md).
    pub fn confidence(&self, rotations: &[Vector3<f64>]) -> f64 {
        let of_joint = |(theta, range): (&Vector3<f64>, &f64)| {
            1.0 - step((theta.norm() - range) / (range / 2.0 + 0.1))
        };
        rotations.iter().zip(&self.pose_ranges).map(of_joint).fold(1.0, f64::min)
    }

    /// Skins a vertex by a palette (METHOD §1.8).
    pub fn skin(&self, vertex: &Vertex, palette: &[Matrix3x4<f64>]) -> Skinned {
        let map = vertex.blend(palette);
        let towards =
            |m: &Matrix3<f64>, rest: &Vector3<f64>| (m * rest).try_normalize(0.0).unwrap_or(*rest);
        let turn = linear(&map);
        Skinned {
            position: map * vertex.position,
            normal: towards(&cofactors(&turn), &vertex.normal),
            tangent: vertex.tangent.map(|(rest, hand)| (towards(&turn, &rest), hand)),
        }
    }
}

impl Key {
    fn new(key: &sinew_runtime::envelope::Key) -> Self {
        let matrix = |rows: &[[f32; 3]; 3]| Matrix3::from_fn(|r, c| f64::from(rows[r][c]));
        Self {
            joint: key.joint,
            twist: matrix(&key.twist),
            residual: key.residual.map(|(joint, twist)| (joint, matrix(&twist))),
            shear: Matrix6::from_fn(|r, c| f64::from(key.shear[r][c])),
        }
    }
}

impl Factors {
    /// Multiplies them.
    pub fn gradient(&self) -> Matrix3<f64> {
        let residual = self.residual.map_or(Matrix3::identity(), |angles| so3::exp(&angles));
        self.parent * so3::exp(&self.twist) * residual * self.stretch
    }
}

impl Vertex {
    /// Widens the vertices of a loaded skin.
    fn all(skin: &Skin<'_>) -> Vec<Self> {
        (0..skin.vertex_len()).map(|vertex| Self::new(skin, vertex)).collect()
    }

    fn new(skin: &Skin<'_>, vertex: usize) -> Self {
        let widened =
            |v: Option<[f32; 3]>| Vector3::from(v.unwrap_or([f32::NAN; 3])).map(f64::from);
        let tangent = |[x, y, z, hand]: [f32; 4]| (widened(Some([x, y, z])), f64::from(hand));
        Self {
            position: widened(skin.rest_position(vertex)).push(1.0),
            normal: widened(skin.rest_normal(vertex)),
            tangent: skin.rest_tangent(vertex).map(tangent),
            influences: skin.influences(vertex).map(|(l, w)| (l, f64::from(w))).collect(),
        }
    }

    /// Blends the vertex's maps.
    pub fn blend(&self, palette: &[Matrix3x4<f64>]) -> Matrix3x4<f64> {
        self.influences.iter().map(|&(l, weight)| palette[l] * weight).sum()
    }
}
