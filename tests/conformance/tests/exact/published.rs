//! S3 §2.3 written out: the 12P x 12P system with Kronecker products, with METHOD's corrections,
//! compared with c1 ⊗ I₃ and c2 ⊗ I₃.

use conformance::tolerance::SOLVED;
use faer::Mat;
use nalgebra::{DMatrix, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use sinew_trainer::envelope::lbs::blend::Weights;
use sinew_trainer::envelope::s3::reduce::{Anchors, Reduction};

const VERTICES: usize = 14;
const TRIANGLES: usize = 20;
const PROXIES: usize = 3;
const JOINTS: usize = 2;

/// A mesh with random triangles and random weights.
struct Mesh {
    rest: Vec<[f64; 3]>,
    triangles: Vec<[usize; 3]>,
    proxies: Weights,
    keys: Weights,
    joints: Weights,
    fixed: Vec<bool>,
    anchors: Option<Anchors>,
}

impl Mesh {
    fn new(seed: u64, fixed: usize, anchors: Option<Anchors>) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let rest = (0..VERTICES).map(|_| [(); 3].map(|()| random.random_range(-1.0..1.0)));
        let rest = rest.collect();
        let triangle = |k: usize| {
            let second = random.random_range(1..VERTICES - 1);
            let third = random.random_range(second + 1..VERTICES);
            [0, second, third].map(|step| (k + step) % VERTICES)
        };
        let triangles = (0..TRIANGLES).map(triangle).collect();
        let mut random = |items: usize, transforms: usize| weights(items, transforms, &mut random);
        Self {
            rest,
            triangles,
            proxies: random(VERTICES, PROXIES),
            keys: random(TRIANGLES, PROXIES),
            joints: random(VERTICES, JOINTS),
            fixed: (0..VERTICES).map(|v| v < fixed).collect(),
            anchors,
        }
    }

    fn reduction(&self) -> Reduction<'_> {
        Reduction {
            rest: &self.rest,
            triangles: &self.triangles,
            proxies: &self.proxies,
            keys: &self.keys,
            joints: &self.joints,
            proxy_len: PROXIES,
            joint_len: JOINTS,
            fixed: &self.fixed,
            anchors: self.anchors,
        }
    }

    /// Returns Φ_a (3 x 12P), with Φ_a t = y_a for the stack t of vec(T_l).
    fn phi(&self, vertex: usize) -> DMatrix<f64> {
        embed(self.proxies.of(vertex), &self.rest[vertex], PROXIES)
    }

    /// Returns Ψ_a (3 x 12J).
    fn psi(&self, vertex: usize) -> DMatrix<f64> {
        embed(self.joints.of(vertex), &self.rest[vertex], JOINTS)
    }
}

/// S3's A, B1 and B2.
struct System {
    a: DMatrix<f64>,
    b1: DMatrix<f64>,
    b2: DMatrix<f64>,
}

impl System {
    fn published(mesh: &Mesh) -> Self {
        let mut a = DMatrix::zeros(12 * PROXIES, 12 * PROXIES);
        let mut b1 = DMatrix::zeros(12 * PROXIES, 9 * PROXIES);
        let mut b2 = DMatrix::zeros(12 * PROXIES, 12 * JOINTS);
        for (k, triangle) in mesh.triangles.iter().enumerate() {
            for j in [1, 2] {
                let (first, last) = (triangle[0], triangle[j]);
                let (phi_1, phi_j) = (mesh.phi(first), mesh.phi(last));
                // The factor of t; the known part of the edge goes to B2.
                let free = match (mesh.fixed[first], mesh.fixed[last]) {
                    (true, true) => continue,
                    (false, false) => &phi_j - &phi_1,
                    (true, false) => {
                        b2 += phi_j.transpose() * mesh.psi(first);
                        phi_j
                    }
                    (false, true) => {
                        b2 += phi_1.transpose() * mesh.psi(last);
                        -phi_1
                    }
                };
                let edge = Vector3::from(mesh.rest[last]) - Vector3::from(mesh.rest[first]);
                let edge = DMatrix::from_row_slice(1, 3, edge.as_slice());
                let edge = edge.kronecker(&DMatrix::<f64>::identity(3, 3));
                for (l, beta) in mesh.keys.of(k) {
                    let mut block = b1.columns_mut(9 * l, 9);
                    block += free.transpose() * &edge * beta;
                }
                a += free.transpose() * free;
            }
        }
        Self { a, b1, b2 }
    }

    /// Adds METHOD's anchors: F at its LBS positions, then every patch at its LBS transform,
    /// through the corners of a tetrahedron about its centroid.
    fn anchor(&mut self, mesh: &Mesh, anchors: Anchors) {
        let edge = |a: usize, b: usize| {
            (Vector3::from(mesh.rest[a]) - Vector3::from(mesh.rest[b])).norm_squared()
        };
        let edges: Vec<_> =
            mesh.triangles.iter().flat_map(|t| [edge(t[0], t[1]), edge(t[0], t[2])]).collect();
        let mean = edges.iter().sum::<f64>() / edges.len() as f64;
        let gamma = anchors.near_rigid * mean;
        for vertex in (0..VERTICES).filter(|&v| mesh.fixed[v]) {
            let phi = mesh.phi(vertex);
            self.a += phi.transpose() * &phi * gamma;
            self.b2 += phi.transpose() * mesh.psi(vertex) * gamma;
        }
        // The trace over the nine entries of a linear part counts each coordinate three times.
        let trace = |a: &DMatrix<f64>, l: usize| {
            (0..9).map(|i| a[(12 * l + i, 12 * l + i)]).sum::<f64>() / 3.0
        };
        let own: Vec<_> = (0..PROXIES).map(|l| trace(&self.a, l)).collect();
        let least = 1e-3 * own.iter().sum::<f64>() / PROXIES as f64;
        for (l, own) in own.into_iter().enumerate() {
            let alphas: Vec<_> = (0..VERTICES)
                .map(|v| mesh.proxies.of(v).find(|(m, _)| *m == l).map_or(0.0, |(_, alpha)| alpha))
                .collect();
            let mass: f64 = alphas.iter().sum();
            let mean = |value: &dyn Fn(usize) -> f64| {
                alphas.iter().enumerate().map(|(v, alpha)| alpha * value(v)).sum::<f64>() / mass
            };
            let centroid = Vector3::from_fn(|axis, _| mean(&|v| mesh.rest[v][axis]));
            let squares = mean(&|v| (Vector3::from(mesh.rest[v]) - centroid).norm_squared());
            let corner = squares.sqrt().max(1e-3) / 3f64.sqrt();
            let corners =
                [[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]];
            let points = corners.map(|c| <[f64; 3]>::from(centroid + Vector3::from(c) * corner));
            let shares: Vec<_> = (0..JOINTS)
                .map(|j| {
                    let of = |v| mesh.joints.of(v).find(|(i, _)| *i == j).map_or(0.0, |(_, w)| w);
                    (j, mean(&of))
                })
                .collect();
            let spread: f64 = points.iter().flatten().map(|x| x * x).sum();
            let strength = anchors.patch * own.max(least) / spread;
            for point in &points {
                let phi = embed([(l, 1.0)].into_iter(), point, PROXIES);
                let psi = embed(shares.iter().copied(), point, JOINTS);
                self.a += phi.transpose() * &phi * strength;
                self.b2 += phi.transpose() * psi * strength;
            }
        }
    }

    /// Returns C1 and C2, with the least norm if A is singular.
    fn solve(&self) -> [DMatrix<f64>; 2] {
        let eigen = self.a.clone().symmetric_eigen();
        let most = eigen.eigenvalues.amax();
        let inverse = eigen.eigenvalues.map(|x| if x > 1e-11 * most { 1.0 / x } else { 0.0 });
        let inverse =
            &eigen.eigenvectors * DMatrix::from_diagonal(&inverse) * eigen.eigenvectors.transpose();
        [&inverse * &self.b1, &inverse * &self.b2]
    }
}

fn weights(items: usize, transforms: usize, random: &mut ChaCha8Rng) -> Weights {
    let list = |_| {
        let mut list: Vec<_> =
            (0..transforms).map(|l| (l, random.random_range(0.05..1.0))).collect();
        let sum: f64 = list.iter().map(|(_, w)| w).sum();
        list.iter_mut().for_each(|(_, w)| *w /= sum);
        list.sort_by(|a, b| b.1.total_cmp(&a.1));
        list
    };
    Weights::from_lists(transforms, (0..items).map(list).collect::<Vec<_>>().into_iter())
}

/// Returns `weights ⊗ [x 1] ⊗ I₃`: 3 rows, 12 columns a transform.
fn embed(
    weights: impl Iterator<Item = (usize, f64)>,
    x: &[f64; 3],
    transforms: usize,
) -> DMatrix<f64> {
    let h = DMatrix::from_row_slice(1, 4, &[x[0], x[1], x[2], 1.0]);
    let h = h.kronecker(&DMatrix::<f64>::identity(3, 3));
    let mut out = DMatrix::zeros(3, 12 * transforms);
    for (l, weight) in weights {
        out.columns_mut(12 * l, 12).copy_from(&(&h * weight));
    }
    out
}

/// Returns c ⊗ I₃.
fn expand(c: &Mat<f64>) -> DMatrix<f64> {
    let c = DMatrix::from_fn(c.nrows(), c.ncols(), |row, column| c[(row, column)]);
    c.kronecker(&DMatrix::<f64>::identity(3, 3))
}

fn largest_difference(mesh: &Mesh, [c1, c2]: &[DMatrix<f64>; 2]) -> f64 {
    let reduced = mesh.reduction().run().expect("the mesh is reducible");
    let difference = |found: &Mat<f64>, expected: &DMatrix<f64>| {
        let found = expand(found);
        assert_eq!(found.shape(), expected.shape());
        (found - expected).amax() / expected.amax().max(1.0)
    };
    difference(&reduced.c1, c1).max(difference(&reduced.c2, c2))
}

#[test]
fn without_anchors() {
    for (seed, fixed) in [(1, 0), (2, 1), (3, 5), (4, VERTICES - 1)] {
        let mesh = Mesh::new(seed, fixed, None);
        let expected = System::published(&mesh).solve();
        assert_eq!(expected[0].shape(), (12 * PROXIES, 9 * PROXIES));
        assert_eq!(expected[1].shape(), (12 * PROXIES, 12 * JOINTS));
        let difference = largest_difference(&mesh, &expected);
        assert!(difference <= SOLVED, "{fixed} near-rigid vertices: {difference}");
    }
}

#[test]
fn with_anchors() {
    let anchors = Anchors { near_rigid: 10.0, patch: 1e-2 };
    for (seed, fixed) in [(1, 0), (2, 1), (3, 5), (4, VERTICES - 1), (5, VERTICES)] {
        let mesh = Mesh::new(seed, fixed, Some(anchors));
        let mut system = System::published(&mesh);
        system.anchor(&mesh, anchors);
        let difference = largest_difference(&mesh, &system.solve());
        assert!(difference <= SOLVED, "{fixed} near-rigid vertices: {difference}");
    }
}

#[test]
fn a_wrong_block_or_a_wrong_set_is_detected() {
    let mesh = Mesh::new(3, 5, None);
    let mut system = System::published(&mesh);
    system.b1.columns_mut(0, 9).neg_mut();
    assert!(largest_difference(&mesh, &system.solve()) > 1e-3);
    let mut other = Mesh::new(3, 5, None);
    other.fixed[5] = true;
    assert!(largest_difference(&other, &System::published(&mesh).solve()) > 1e-3);
}
