//! With one proxy for each vertex and one key for each triangle, nothing is reduced: the reduction
//! equals the full Poisson reconstruction.

use conformance::tolerance::PSEUDO_SOLVED;
use nalgebra::{Matrix3, Matrix3x4, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use sinew_trainer::envelope::lbs::blend::Weights;
use sinew_trainer::envelope::s3::poisson::Poisson;
use sinew_trainer::envelope::s3::reduce::Reduction;
use sinew_trainer::numeric::affine::homogeneous;

const COLUMNS: usize = 5;
const ROWS: usize = 6;
const JOINTS: usize = 3;

/// Returns a hilly grid: vertices and triangles.
fn grid() -> (Vec<[f64; 3]>, Vec<[usize; 3]>) {
    let at = |x: usize, y: usize| {
        let (x, y) = (x as f64, y as f64);
        [x / 4.0, y / 4.0, 0.2 * (2.0 * x + y * y).sin()]
    };
    let rest = (0..ROWS).flat_map(|y| (0..COLUMNS).map(move |x| at(x, y))).collect();
    let quad = |x: usize, y: usize| {
        let [a, b] = [y * COLUMNS + x, (y + 1) * COLUMNS + x];
        [[a, a + 1, b + 1], [b, a, b + 1]]
    };
    let quads = (0..ROWS - 1).flat_map(|y| (0..COLUMNS - 1).map(move |x| (x, y)));
    (rest, quads.flat_map(|(x, y)| quad(x, y)).collect())
}

/// Returns weights with a separate transform for each item.
fn own(items: usize) -> Weights {
    Weights::from_lists(1, (0..items).map(|item| vec![(item, 1.0)]))
}

#[test]
fn the_reduction_of_nothing_is_the_full_reconstruction() {
    let (rest, triangles) = grid();
    let mut random = ChaCha8Rng::seed_from_u64(6);
    let joints = (0..rest.len()).map(|v| vec![(v % JOINTS, 0.7), ((v + 1) % JOINTS, 0.3)]);
    let joints = Weights::from_lists(2, joints);
    for share in [0.0, 0.05, 0.3, 0.9] {
        let mut fixed: Vec<_> = (0..rest.len()).map(|_| random.random_bool(share)).collect();
        fixed[random.random_range(0..rest.len())] = true;
        let reduction = Reduction {
            rest: &rest,
            triangles: &triangles,
            proxies: &own(rest.len()),
            keys: &own(triangles.len()),
            joints: &joints,
            // The larger of the two counts; transforms that nothing follows stay 0.
            proxy_len: rest.len().max(triangles.len()),
            joint_len: JOINTS,
            fixed: &fixed,
            anchors: None,
        };
        let reduced = reduction.run().unwrap();
        let poisson = Poisson::new(&rest, &triangles, &fixed).unwrap();
        for _ in 0..5 {
            let mut entry = || random.random_range(-2.0..2.0);
            let gradients: Vec<_> =
                triangles.iter().map(|_| Matrix3::from_fn(|_, _| entry())).collect();
            let q: Vec<_> = (0..JOINTS).map(|_| Matrix3x4::from_fn(|_, _| entry())).collect();
            let lbs = |v: usize| -> Vector3<f64> {
                joints.of(v).map(|(j, w)| q[j] * homogeneous(&rest[v]) * w).sum()
            };
            let known: Vec<_> = (0..rest.len()).map(lbs).collect();
            let expected = poisson.reconstruct(&gradients, &known);
            let mut d = gradients;
            d.resize(reduction.proxy_len, Matrix3::zeros());
            let transforms = crate::exact::transforms(&reduced, &d, &q);
            for vertex in (0..rest.len()).filter(|&v| !fixed[v]) {
                let found = transforms[vertex] * homogeneous(&rest[vertex]);
                let error = (found - expected[vertex]).norm();
                assert!(error <= PSEUDO_SOLVED, "vertex {vertex}, F {share}: {error}");
            }
        }
    }
}
