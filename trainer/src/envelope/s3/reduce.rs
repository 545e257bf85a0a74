//! Reduction of the Poisson reconstruction to `t = c1 d + c2 q` (METHOD §1.7.3, S3 §2.3, Eq. 6), and the refinement of
//! c1 and c2 on the training meshes.
//!
//! The three coordinates are independent, so c1 is 4P x 3P and c2 4P x 4J; S3's C1 and C2 are c1 ⊗ I₃ and c2 ⊗ I₃.
//!
//! **Refinement.** The Poisson reconstruction takes the predicted gradients as exact. Systematic errors of the
//! prediction show in the training meshes. The refinement adds a correction Δ to `[c1 c2]`: a ridge regression of the
//! reconstruction's residual on gradients and joints. The form and the cost of the evaluation do not change. Δ acts on
//! `d - I` and `q - rest`. The root's block of c2 multiplies a constant and absorbs the subtracted terms, so the rest
//! pose stays exact.

use crate::envelope::lbs::blend::Weights;
use crate::envelope::lbs::poses::Poses;
use crate::envelope::lbs::targets::in_poses;
use crate::numeric::affine::homogeneous;
use crate::numeric::columns::solve_ridge;
use faer::linalg::solvers::Solve;
use faer::{Mat, Side};
use nalgebra::{Matrix4, Vector3, Vector4};
use serde::Serialize;

/// Inputs of the reduction.
#[derive(Clone, Copy)]
pub struct Reduction<'a> {
    /// Rest positions, V, in units of the diagonal.
    pub rest: &'a [[f64; 3]],
    /// Triangles, T; the two edges of a triangle start at its first vertex.
    pub triangles: &'a [[usize; 3]],
    /// α: weights of the vertices on the P proxies.
    pub proxies: &'a Weights,
    /// β: weights of the triangles on the P keys.
    pub keys: &'a Weights,
    /// w: LBS weights of the vertices on the J joints.
    pub joints: &'a Weights,
    /// P.
    pub proxy_len: usize,
    /// J.
    pub joint_len: usize,
    /// F: the near-rigid vertices, V flags.
    pub fixed: &'a [bool],
    /// Anchors, which hold F in place and make the system regular; `None` as published.
    pub anchors: Option<Anchors>,
}

/// Strengths of the two anchors, without unit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Anchors {
    /// γ: pulls each vertex of F to its LBS position. Relative to the mean squared edge.
    pub near_rigid: f64,
    /// μ: pulls each proxy to the LBS map of its patch. Relative to the proxy's share of the edges.
    pub patch: f64,
}

/// The reduced reconstruction.
#[derive(Clone, Debug)]
pub struct Reduced {
    /// c1, 4P x 3P.
    pub c1: Mat<f64>,
    /// c2, 4P x 4J.
    pub c2: Mat<f64>,
}

/// The normal equations `a t = b1 d + b2 q`.
pub struct NormalEquations {
    /// a, 4P x 4P.
    pub a: Mat<f64>,
    /// b1, 4P x 3P.
    pub b1: Mat<f64>,
    /// b2, 4P x 4J.
    pub b2: Mat<f64>,
}

/// Regression of a palette's residual on the deviations of its inputs from rest.
#[derive(Clone)]
pub struct Regression {
    gram: Mat<f64>,
    right: Mat<f64>,
    /// Number of equations.
    rows: f64,
    /// Columns of the gradients, 3P.
    keys: usize,
    root: usize,
}

impl Reduction<'_> {
    /// Solves for c1 and c2: by Cholesky, or with the least norm if there are no anchors.
    ///
    /// Returns `None` if the system is singular because the anchors are too weak.
    pub fn run(&self) -> Option<Reduced> {
        let equations = self.equations();
        let (b1, b2) = (&equations.b1, &equations.b2);
        if self.anchors.is_none() {
            let inverse = pseudo_inverse(&equations.a)?;
            return Some(Reduced { c1: &inverse * b1, c2: &inverse * b2 });
        }
        let factor = equations.a.llt(Side::Lower).ok()?;
        Some(Reduced { c1: factor.solve(b1), c2: factor.solve(b2) })
    }

    /// Builds the normal equations, anchors included.
    pub fn equations(&self) -> NormalEquations {
        let p = self.proxy_len;
        let mut e = NormalEquations {
            a: Mat::zeros(4 * p, 4 * p),
            b1: Mat::zeros(4 * p, 3 * p),
            b2: Mat::zeros(4 * p, 4 * self.joint_len),
        };
        for (k, &[first, second, third]) in self.triangles.iter().enumerate() {
            for last in [second, third] {
                self.add_edge(&mut e, k, first, last);
            }
        }
        if let Some(anchors) = self.anchors {
            self.add_near_rigid_anchor(&mut e, anchors.near_rigid);
            self.add_patch_anchor(&mut e, anchors.patch);
        }
        e
    }

    /// Adds the equation of one edge: the proxies of its free ends on the left, the key gradient and the fixed ends on
    /// the right.
    fn add_edge(&self, e: &mut NormalEquations, triangle: usize, first: usize, last: usize) {
        // φ_j - φ_1 without fixed ends. This covers edges with no, one and two ends in F (S3: F0, F1, F2).
        let mut free = Vec::with_capacity(2 * self.proxies.most());
        let mut known = Vec::with_capacity(self.joints.most());
        for (vertex, sign) in [(last, 1.0), (first, -1.0)] {
            if self.fixed[vertex] {
                known.extend(self.psi(vertex).map(|(j, psi)| (j, -sign * psi)));
            } else {
                free.extend(self.phi(vertex).map(|(l, phi)| (l, sign * phi)));
            }
        }
        if free.is_empty() {
            return;
        }
        let edge = Vector3::from(self.rest[last]) - Vector3::from(self.rest[first]);
        for (row, phi) in &free {
            for (column, other) in &free {
                add_block(&mut e.a, 4 * row, 4 * column, &(phi * other.transpose()));
            }
            for (key, beta) in self.keys.of(triangle) {
                add_block(&mut e.b1, 4 * row, 3 * key, &(phi * edge.transpose() * beta));
            }
            for (joint, psi) in &known {
                add_block(&mut e.b2, 4 * row, 4 * joint, &(phi * psi.transpose()));
            }
        }
    }

    /// Adds γ Σ_{a∈F} |φ_aᵀt - ψ_aᵀq|².
    fn add_near_rigid_anchor(&self, e: &mut NormalEquations, strength: f64) {
        let gamma = strength * self.mean_squared_edge();
        for vertex in (0..self.rest.len()).filter(|&v| self.fixed[v]) {
            for (row, phi) in self.phi(vertex) {
                for (column, other) in self.phi(vertex) {
                    add_block(&mut e.a, 4 * row, 4 * column, &(phi * other.transpose() * gamma));
                }
                for (joint, psi) in self.psi(vertex) {
                    add_block(&mut e.b2, 4 * row, 4 * joint, &(phi * psi.transpose() * gamma));
                }
            }
        }
    }

    /// Adds μ |T_l - T_l^LBS|² over four points around the centroid of each patch. This also determines the maps of
    /// flat patches, of floating parts, and of proxies that move only fixed vertices.
    fn add_patch_anchor(&self, e: &mut NormalEquations, strength: f64) {
        let p = self.proxy_len;
        let mut mass = vec![0.0; p];
        let mut moment = vec![Vector3::zeros(); p];
        let mut square = vec![0.0; p];
        let mut share = vec![vec![0.0; self.joint_len]; p];
        for vertex in 0..self.rest.len() {
            let x = Vector3::from(self.rest[vertex]);
            for (l, alpha) in self.proxies.of(vertex) {
                mass[l] += alpha;
                moment[l] += x * alpha;
                square[l] += x.norm_squared() * alpha;
                for (joint, w) in self.joints.of(vertex) {
                    share[l][joint] += alpha * w;
                }
            }
        }
        let stiffness = |e: &NormalEquations, l: usize| {
            (0..3).map(|c| e.a[(4 * l + c, 4 * l + c)]).sum::<f64>()
        };
        let mean = (0..p).map(|l| stiffness(e, l)).sum::<f64>() / p.max(1) as f64;
        for l in 0..p {
            // A proxy that no vertex uses follows the first joint.
            let weight = mass[l].max(f64::MIN_POSITIVE);
            let centroid = moment[l] / weight;
            let spread = (square[l] / weight - centroid.norm_squared()).max(0.0);
            let radius = spread.sqrt().max(1e-3);
            let points = tetrahedron_moment(&centroid, radius);
            let own = stiffness(e, l).max(1e-3 * mean) + f64::MIN_POSITIVE;
            let block = points * (strength * own / (points.fixed_view::<3, 3>(0, 0).trace()));
            add_block(&mut e.a, 4 * l, 4 * l, &block);
            if mass[l] == 0.0 {
                share[l][0] = weight;
            }
            for (joint, sum) in share[l].iter().enumerate().filter(|(_, sum)| **sum > 0.0) {
                add_block(&mut e.b2, 4 * l, 4 * joint, &(block * (sum / weight)));
            }
        }
    }

    /// Returns φ of a vertex: `α [x̂ 1]` for each of its proxies.
    fn phi(&self, vertex: usize) -> impl Iterator<Item = (usize, Vector4<f64>)> + '_ {
        let h = homogeneous(&self.rest[vertex]);
        self.proxies.of(vertex).map(move |(l, alpha)| (l, h * alpha))
    }

    /// Returns ψ of a vertex: `w [x̂ 1]` for each of its joints.
    fn psi(&self, vertex: usize) -> impl Iterator<Item = (usize, Vector4<f64>)> + '_ {
        let h = homogeneous(&self.rest[vertex]);
        self.joints.of(vertex).map(move |(j, w)| (j, h * w))
    }

    fn mean_squared_edge(&self) -> f64 {
        let squared = |a: usize, b: usize| {
            (Vector3::from(self.rest[b]) - Vector3::from(self.rest[a])).norm_squared()
        };
        let sum: f64 = self.triangles.iter().map(|&[a, b, c]| squared(a, b) + squared(a, c)).sum();
        sum / (2 * self.triangles.len()).max(1) as f64
    }
}

impl Reduced {
    /// Appends the joints' transforms to the palette, after the proxies: `[t; q] = [c1; 0] d + [c2; I] q`.
    #[must_use]
    pub fn and_joints(&self) -> Self {
        let (rows, joints) = (self.c2.nrows(), self.c2.ncols());
        let mut c1 = Mat::zeros(rows + joints, self.c1.ncols());
        let mut c2 = Mat::zeros(rows + joints, joints);
        c1.subrows_mut(0, rows).copy_from(&self.c1);
        c2.subrows_mut(0, rows).copy_from(&self.c2);
        c2.subrows_mut(rows, joints).copy_from(Mat::<f64>::identity(joints, joints));
        Self { c1, c2 }
    }

    /// Evaluates `t = c1 d + c2 q` in n poses. Returns maps, 3n x 4P; columns 4l..4l+4 belong to proxy l.
    ///
    /// - `gradients`: 3n x 3P; columns 3l..3l+3 belong to key l.
    pub fn palette(&self, gradients: &Mat<f64>, poses: &Poses) -> Mat<f64> {
        gradients * self.c1.transpose() + poses.stacked() * self.c2.transpose()
    }
}

impl NormalEquations {
    /// Returns the ratio of the largest to the smallest eigenvalue of a; infinite if a is singular.
    pub fn condition(&self) -> f64 {
        match self.a.self_adjoint_eigenvalues(Side::Lower).as_deref() {
            Ok(&[least, .., most]) if least > 0.0 => most / least,
            _ => f64::INFINITY,
        }
    }
}

impl Regression {
    /// Sums the normal equations over all poses except those in `left_out`.
    ///
    /// - `gradients`: 3n x 3P.
    /// - `residual`: residual maps, 3n x 4P.
    pub fn new(
        gradients: &Mat<f64>,
        poses: &Poses,
        residual: &Mat<f64>,
        left_out: &[usize],
    ) -> Self {
        let all = features(gradients, poses);
        let (mut gram, mut right) = (all.transpose() * &all, all.transpose() * residual);
        let [x, r] = [&all, residual].map(|all| in_poses(all, left_out));
        gram -= x.transpose() * &x;
        right -= x.transpose() * &r;
        let rows = (all.nrows() - x.nrows()) as f64;
        Self { gram, right, rows, keys: gradients.ncols(), root: poses.root() }
    }

    /// Adds Δ to c1 and c2.
    ///
    /// - `strength`: ridge per equation.
    pub fn refine(&self, reduced: &Reduced, strength: f64) -> Reduced {
        let ridge = strength * self.rows;
        let delta = solve_ridge(&mut self.gram.clone(), self.right.clone(), ridge);
        let mut refined = reduced.clone();
        for row in 0..refined.c1.nrows() {
            for column in 0..delta.nrows() {
                let value = delta[(column, row)];
                // At rest d = I and q = [I 0]: subtract the rest value in the root's block.
                let axis = if column < self.keys {
                    refined.c1[(row, column)] += value;
                    column % 3
                } else {
                    let column = column - self.keys;
                    refined.c2[(row, column)] += value;
                    column % 4
                };
                if axis < 3 {
                    refined.c2[(row, 4 * self.root + axis)] -= value;
                }
            }
        }
        refined
    }
}

/// Returns the deviations from rest `[d - I, q - rest]`, 3n x (3P + 4J).
fn features(gradients: &Mat<f64>, poses: &Poses) -> Mat<f64> {
    let (keys, joints) = (gradients.ncols(), poses.stacked());
    Mat::from_fn(gradients.nrows(), keys + joints.ncols(), |row, column| {
        let identity = |axis: usize| f64::from(u8::from(row % 3 == axis));
        match column.checked_sub(keys) {
            None => gradients[(row, column)] - identity(column % 3),
            Some(column) => joints[(row, column)] - identity(column % 4),
        }
    })
}

/// Returns Σ h hᵀ over the corners of a regular tetrahedron around a centre.
fn tetrahedron_moment(centre: &Vector3<f64>, radius: f64) -> Matrix4<f64> {
    let step = radius / 3f64.sqrt();
    [[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]]
        .iter()
        .map(|corner| {
            let h = (centre + Vector3::from(*corner) * step).push(1.0);
            h * h.transpose()
        })
        .sum()
}

fn add_block<R: nalgebra::Dim, C: nalgebra::Dim, S: nalgebra::Storage<f64, R, C>>(
    matrix: &mut Mat<f64>,
    row: usize,
    column: usize,
    block: &nalgebra::Matrix<f64, R, C, S>,
) {
    for c in 0..block.ncols() {
        for r in 0..block.nrows() {
            matrix[(row + r, column + c)] += block[(r, c)];
        }
    }
}

fn pseudo_inverse(a: &Mat<f64>) -> Option<Mat<f64>> {
    const RANK: f64 = 1e-11;
    let eigen = a.self_adjoint_eigen(Side::Lower).ok()?;
    let values = eigen.S().column_vector();
    let largest = values[values.nrows().checked_sub(1)?];
    let inverted = Mat::from_fn(a.nrows(), a.nrows(), |r, c| {
        let value = values[c];
        if value > RANK * largest { eigen.U()[(r, c)] / value } else { 0.0 }
    });
    Some(inverted * eigen.U().transpose())
}
