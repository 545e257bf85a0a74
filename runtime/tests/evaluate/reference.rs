//! The palette and the skin (positions, normals, tangents) against f64.

use crate::common::{
    Stretched, apart, max_difference, palette, random_pose, skinned, stretched_pose, with_envelope,
    with_skin,
};
use models::{Rng, SMALL, STRETCHING, Shape};
use sinew_runtime::{Envelope, Matrix3x4};

type M = [[f64; 3]; 3];

fn mul(a: M, b: M) -> M {
    a.map(|row| [0, 1, 2].map(|c| (0..3).map(|k| row[k] * b[k][c]).sum()))
}

fn transposed(a: M) -> M {
    [0, 1, 2].map(|r| [0, 1, 2].map(|c| a[c][r]))
}

fn apply(a: M, v: [f64; 3]) -> [f64; 3] {
    a.map(|row| (0..3).map(|k| row[k] * v[k]).sum())
}

fn cross_matrix([x, y, z]: [f64; 3]) -> M {
    [[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]]
}

/// The exponential by its series, with twelve halvings; independent of the runtime's method.
fn exp(v: [f64; 3]) -> M {
    let small = cross_matrix(v.map(|x| x / 4096.0));
    let mut out = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let mut power = out;
    for n in 1..10 {
        power = mul(power, small).map(|row| row.map(|x| x / f64::from(n)));
        out = [0, 1, 2].map(|r| [0, 1, 2].map(|c| out[r][c] + power[r][c]));
    }
    (0..12).fold(out, |out, _| mul(out, out))
}

/// The logarithm from the trace and the skew part, for angles well below pi.
fn log(m: M) -> [f64; 3] {
    let angle = ((m[0][0] + m[1][1] + m[2][2] - 1.0) / 2.0).clamp(-1.0, 1.0).acos();
    let factor = if angle < 1e-9 { 0.5 } else { angle / (2.0 * angle.sin()) };
    [m[2][1] - m[1][2], m[0][2] - m[2][0], m[1][0] - m[0][1]].map(|x| x * factor)
}

/// The inverse by cofactors.
fn inverse(m: M) -> M {
    let minor = |r: usize, c: usize| {
        let ([a, b], [d, e]) = ([(r + 1) % 3, (r + 2) % 3], [(c + 1) % 3, (c + 2) % 3]);
        m[a][d] * m[b][e] - m[a][e] * m[b][d]
    };
    let volume = (0..3).map(|c| m[0][c] * minor(0, c)).sum::<f64>();
    [0, 1, 2].map(|r| [0, 1, 2].map(|c| minor(c, r) / volume))
}

/// METHOD §1.8 and §1.10 in f64, from the accessors only.
///
/// - `rigid`: the pose without stretch, for the rotations.
fn reference_palette(
    envelope: &Envelope<'_>,
    pose: &[Matrix3x4],
    rigid: &[Matrix3x4],
) -> Vec<[[f64; 4]; 3]> {
    let [pose, rigid] = [pose, rigid]
        .map(|pose| pose.iter().map(|m| m.map(|row| row.map(f64::from))).collect::<Vec<_>>());
    let linear = |m: &[[f64; 4]; 3]| m.map(|[x, y, z, _]| [x, y, z]);
    let root = pose[envelope.root()];
    let root_inverse = match envelope.stretches() {
        true => inverse(linear(&root)),
        false => transposed(linear(&root)),
    };
    // Rotations relative to the root's.
    let root_turn = transposed(linear(&rigid[envelope.root()]));
    let turns = rigid.iter().map(|m| mul(root_turn, linear(m))).collect::<Vec<_>>();
    let strain = |j: usize| {
        let square = mul(transposed(linear(&pose[j])), linear(&pose[j]));
        [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)]
            .map(|(r, c)| (square[r][c] - f64::from(u8::from(r == c))) / 2.0)
    };
    let relative = pose.iter().map(|m| {
        let q = mul(root_inverse, linear(m));
        let t = apply(root_inverse, [0, 1, 2].map(|r| m[r][3] - root[r][3]));
        (q, t)
    });
    let relative = relative.collect::<Vec<_>>();
    let theta = |j: usize| {
        envelope.parent(j).map_or([0.0; 3], |p| log(mul(transposed(turns[p]), turns[j])))
    };
    let wide = |m: [[f32; 3]; 3]| m.map(|row| row.map(f64::from));
    let (p_len, j_len) = (envelope.proxy_len(), envelope.joint_len());
    let mut d = Vec::new();
    for l in 0..p_len {
        let key = envelope.key(l).unwrap();
        let parent = envelope.parent(key.joint);
        let theta_p = parent.map_or([0.0; 3], theta);
        let thetas = [theta(key.joint), theta_p].concat();
        let times = |rows: [[f32; 6]; 6], x: &[f64]| {
            rows.map(|row| row.iter().zip(x).map(|(h, t)| f64::from(*h) * t).sum::<f64>())
        };
        let h = times(key.shear, &thetas);
        let g = key.stretch.map_or([0.0; 6], |rows| times(rows, &strain(key.joint)));
        let h: [_; 6] = std::array::from_fn(|i| h[i] + g[i]);
        let s = [[1.0 + h[0], h[1], h[2]], [h[1], 1.0 + h[3], h[4]], [h[2], h[4], 1.0 + h[5]]];
        let mut out = parent.map_or(exp([0.0; 3]), |p| turns[p]);
        out = mul(out, exp(apply(wide(key.twist), theta(key.joint))));
        if let Some((c, twist)) = key.residual {
            out = mul(out, exp(apply(wide(twist), theta(c))));
        }
        d.push(mul(out, s));
    }
    let entry = |row: usize, r: usize| {
        let c1 =
            (0..3 * p_len).map(|c| f64::from(envelope.c1(row, c).unwrap()) * d[c / 3][r][c % 3]);
        let c2 = (0..4 * j_len).map(|c| {
            let (q, t) = relative[c / 4];
            let q = if c % 4 == 3 { t[r] } else { q[r][c % 4] };
            f64::from(envelope.c2(row, c).unwrap()) * q
        });
        c1.chain(c2).sum::<f64>()
    };
    let transforms = (0..p_len).map(|l| {
        let t = [0, 1, 2].map(|r| [0, 1, 2, 3].map(|c| entry(4 * l + c, r)));
        root.map(|row| {
            let mut out = [0, 1, 2, 3].map(|c| (0..3).map(|k| row[k] * t[k][c]).sum::<f64>());
            out[3] += row[3];
            out
        })
    });
    transforms.collect()
}

#[test]
fn palette_agrees_with_f64() {
    let shape =
        Shape { vertices: 3, joints: 9, proxies: 8, influences: 3, tangents: false, ..SMALL };
    // The root of the samples stretches.
    for shape in [SMALL, shape, STRETCHING, Shape { stretches: true, ..shape }] {
        with_envelope(shape, |envelope| {
            let mut rng = Rng(11);
            for _ in (0..200).step_by(apart(50)) {
                let Stretched { pose, rigid, .. } = stretched_pose(&envelope, &mut rng, 0.6);
                let found = palette(&envelope, &pose);
                let expected = reference_palette(&envelope, &pose, &rigid);
                let expected = expected.as_flattened().as_flattened();
                let narrow = expected.iter().map(|&x| x as f32).collect::<Vec<_>>();
                let largest = narrow.iter().fold(1.0f32, |a, x| a.max(x.abs()));
                let difference = max_difference(found.as_flattened().as_flattened(), &narrow);
                // About 50 roundings of terms as large as the largest; rotations of joints that
                // stretch and the root's inverse are off by some more.
                let most = if shape.stretches { 5e-5 } else { 5e-6 };
                assert!(difference < most * largest, "{difference} of {largest}");
            }
        });
    }
}

#[test]
fn skin_agrees_with_f64() {
    for influences in [1, 2, 4, 5] {
        with_skin(Shape { influences, coefficients: false, ..SMALL }, |envelope, skin| {
            let palette = palette(&envelope, &random_pose(&envelope, &mut Rng(5), 0.3));
            let v = skin.vertex_len();
            let found = skinned(skin, &palette);
            for vertex in 0..v {
                let mut m = [[0.0f64; 4]; 3];
                for (index, weight) in skin.influences(vertex) {
                    let transform = palette[index].as_flattened();
                    for (m, x) in m.as_flattened_mut().iter_mut().zip(transform) {
                        *m += f64::from(weight) * f64::from(*x);
                    }
                }
                let linear = m.map(|[x, y, z, _]| [x, y, z]);
                let wide = |x: [f32; 3]| x.map(f64::from);
                let position = apply(linear, wide(skin.rest_position(vertex).unwrap()));
                let position = [0, 1, 2].map(|r| position[r] + m[r][3]);
                // Cofactors from the adjugate's definition, one minor at a time.
                let minor = |r: usize, c: usize| {
                    let ([a, b], [d, e]) = ([(r + 1) % 3, (r + 2) % 3], [(c + 1) % 3, (c + 2) % 3]);
                    linear[a][d] * linear[b][e] - linear[a][e] * linear[b][d]
                };
                let cofactors = [0, 1, 2].map(|r| [0, 1, 2].map(|c| minor(r, c)));
                let unit = |v: [f64; 3]| {
                    let length = v.iter().map(|x| x * x).sum::<f64>().sqrt();
                    v.map(|x| x / length)
                };
                let normal = unit(apply(cofactors, wide(skin.rest_normal(vertex).unwrap())));
                let [x, y, z, hand] = skin.rest_tangent(vertex).unwrap();
                let tangent = unit(apply(linear, wide([x, y, z])));
                let close = |found: &[f32], expected: [f64; 3], what: &str| {
                    let expected = expected.map(|x| x as f32);
                    let difference = max_difference(found, &expected);
                    assert!(difference < 3e-6, "{what} {vertex}: {difference}");
                };
                close(&found[3 * vertex..][..3], position, "position");
                close(&found[3 * (v + vertex)..][..3], normal, "normal");
                close(&found[6 * v + 4 * vertex..][..3], tangent, "tangent");
                assert_eq!(found[6 * v + 4 * vertex + 3], hand);
            }
        });
    }
}

#[test]
#[should_panic(expected = "not finite")]
fn the_comparator_refuses_nan() {
    max_difference(&[1.0, f32::NAN], &[1.0, 2.0]);
}

#[test]
#[should_panic(expected = "nothing to compare")]
fn the_comparator_refuses_emptiness() {
    max_difference(&[], &[]);
}

#[test]
#[should_panic(expected = "lengths")]
fn the_comparator_refuses_unequal_lengths() {
    max_difference(&[1.0], &[1.0, 2.0]);
}
