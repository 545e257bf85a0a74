//! Closed forms, an f64 reference of the palette, and output layouts.
#![allow(clippy::unwrap_used, reason = "a test's helpers fail as the test does")]

mod common;

use common::{
    IDENTITY, Rng, SMALL, Shape, apart, attribute, max_difference, palette, random_pose, rest,
    skin, with_envelope, with_predictor,
};
use sinew_runtime::envelope::{Buffer, SkinJob, workspace_len};
use sinew_runtime::format::Predictor;
use sinew_runtime::{Envelope, EvalError, LocalTransform, Matrix3x4, Workspace, model_space_pose};

#[test]
fn rest_pose_gives_rest_mesh() {
    with_envelope(SMALL, |envelope| {
        let maps = palette(&envelope, &vec![IDENTITY; envelope.joint_len()]);
        // Dyadic coefficients make the sums exact.
        assert_eq!(maps, vec![IDENTITY; envelope.palette_len()]);
        let (skinned, rest) = (skin(envelope, &maps), rest(envelope));
        let positions = 3 * envelope.vertex_len();
        assert_eq!(skinned[..positions], rest[..positions]);
        assert!(max_difference(&skinned, &rest) < 2e-7);
    });
}

#[test]
fn global_motion_passes_through() {
    with_envelope(SMALL, |envelope| {
        let mut rng = Rng(3);
        let mut local = (0..envelope.joint_len()).map(|_| rng.local(0.5)).collect::<Vec<_>>();
        let mut pose = vec![IDENTITY; envelope.joint_len()];
        model_space_pose(&envelope, &local, &mut pose).unwrap();
        let still = palette(&envelope, &pose);
        // Turn the root's frame half a turn about z, then shift it.
        let [x, y, z, w] = local[envelope.root()].rotation;
        local[envelope.root()].rotation = [-y, x, w, -z];
        let [tx, ty, tz] = local[envelope.root()].translation;
        local[envelope.root()].translation = [4.0 - tx, 8.0 - ty, tz];
        model_space_pose(&envelope, &local, &mut pose).unwrap();
        let moved = palette(&envelope, &pose);
        let expected = still.iter().map(|[x, y, z]| {
            let mut turned = [x.map(|a| -a), y.map(|a| -a), *z];
            turned[0][3] += 4.0;
            turned[1][3] += 8.0;
            turned
        });
        let expected = expected.collect::<Vec<_>>();
        let difference = max_difference(
            moved.as_flattened().as_flattened(),
            expected.as_flattened().as_flattened(),
        );
        assert!(difference < 5e-6, "{difference}");
        // The comparator sees what it should.
        assert!(max_difference(moved[0].as_flattened(), still[0].as_flattened()) > 1.0);
    });
}

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

/// The exponential by its series, halved twelve times first: nothing in common with the runtime's.
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

/// The logarithm by the trace and the skew part, for angles well below pi.
fn log(m: M) -> [f64; 3] {
    let angle = ((m[0][0] + m[1][1] + m[2][2] - 1.0) / 2.0).clamp(-1.0, 1.0).acos();
    let factor = if angle < 1e-9 { 0.5 } else { angle / (2.0 * angle.sin()) };
    [m[2][1] - m[1][2], m[0][2] - m[2][0], m[1][0] - m[0][1]].map(|x| x * factor)
}

/// METHOD §1.8 from the accessors alone, in f64.
fn reference_palette(envelope: &Envelope<'_>, pose: &[Matrix3x4]) -> Vec<[[f64; 4]; 3]> {
    let pose = pose.iter().map(|m| m.map(|row| row.map(f64::from))).collect::<Vec<_>>();
    let linear = |m: &[[f64; 4]; 3]| m.map(|[x, y, z, _]| [x, y, z]);
    let root = pose[envelope.root()];
    let root_inverse = transposed(linear(&root));
    let relative = pose.iter().map(|m| {
        let q = mul(root_inverse, linear(m));
        let t = apply(root_inverse, [0, 1, 2].map(|r| m[r][3] - root[r][3]));
        (q, t)
    });
    let relative = relative.collect::<Vec<_>>();
    let theta = |j: usize| {
        envelope.parent(j).map_or([0.0; 3], |p| log(mul(transposed(relative[p].0), relative[j].0)))
    };
    let wide = |m: [[f32; 3]; 3]| m.map(|row| row.map(f64::from));
    let (p_len, j_len) = (envelope.proxy_len(), envelope.joint_len());
    let mut d = Vec::new();
    for l in 0..p_len {
        let key = envelope.key(l).unwrap();
        let parent = envelope.parent(key.joint);
        let theta_p = parent.map_or([0.0; 3], theta);
        let thetas = [theta(key.joint), theta_p].concat();
        let h = key
            .shear
            .map(|row| row.iter().zip(&thetas).map(|(h, t)| f64::from(*h) * t).sum::<f64>());
        let s = [[1.0 + h[0], h[1], h[2]], [h[1], 1.0 + h[3], h[4]], [h[2], h[4], 1.0 + h[5]]];
        let mut out = parent.map_or(exp([0.0; 3]), |p| relative[p].0);
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
    let maps = (0..p_len).map(|l| {
        let t = [0, 1, 2].map(|r| [0, 1, 2, 3].map(|c| entry(4 * l + c, r)));
        root.map(|row| {
            let mut out = [0, 1, 2, 3].map(|c| (0..3).map(|k| row[k] * t[k][c]).sum::<f64>());
            out[3] += row[3];
            out
        })
    });
    maps.collect()
}

#[test]
fn palette_agrees_with_f64() {
    let shape = Shape { vertices: 3, joints: 9, proxies: 8, influences: 3, tangents: false };
    for shape in [SMALL, shape] {
        with_envelope(shape, |envelope| {
            let mut rng = Rng(11);
            for _ in (0..200).step_by(apart(50)) {
                let pose = random_pose(&envelope, &mut rng, 0.6);
                let found = palette(&envelope, &pose);
                let expected = reference_palette(&envelope, &pose);
                let expected = expected.as_flattened().as_flattened();
                let narrow = expected.iter().map(|&x| x as f32).collect::<Vec<_>>();
                let largest = narrow.iter().fold(1.0f32, |a, x| a.max(x.abs()));
                let difference = max_difference(found.as_flattened().as_flattened(), &narrow);
                // Some 50 roundings of terms as large as the largest.
                assert!(difference < 5e-6 * largest, "{difference} of {largest}");
            }
        });
    }
}

#[test]
fn skin_agrees_with_f64() {
    for influences in [1, 2, 4, 5] {
        with_envelope(Shape { influences, ..SMALL }, |envelope| {
            let maps = palette(&envelope, &random_pose(&envelope, &mut Rng(5), 0.3));
            let v = envelope.vertex_len();
            let found = skin(envelope, &maps);
            for vertex in 0..v {
                let mut m = [[0.0f64; 4]; 3];
                for (index, weight) in envelope.influences(vertex) {
                    for (m, map) in m.as_flattened_mut().iter_mut().zip(maps[index].as_flattened())
                    {
                        *m += f64::from(weight) * f64::from(*map);
                    }
                }
                let linear = m.map(|[x, y, z, _]| [x, y, z]);
                let wide = |x: [f32; 3]| x.map(f64::from);
                let position = apply(linear, wide(envelope.rest_position(vertex).unwrap()));
                let position = [0, 1, 2].map(|r| position[r] + m[r][3]);
                // Cofactors by the adjugate's definition, minor by minor.
                let minor = |r: usize, c: usize| {
                    let ([a, b], [d, e]) = ([(r + 1) % 3, (r + 2) % 3], [(c + 1) % 3, (c + 2) % 3]);
                    linear[a][d] * linear[b][e] - linear[a][e] * linear[b][d]
                };
                let cofactors = [0, 1, 2].map(|r| [0, 1, 2].map(|c| minor(r, c)));
                let unit = |v: [f64; 3]| {
                    let length = v.iter().map(|x| x * x).sum::<f64>().sqrt();
                    v.map(|x| x / length)
                };
                let normal = unit(apply(cofactors, wide(envelope.rest_normal(vertex).unwrap())));
                let [x, y, z, hand] = envelope.rest_tangent(vertex).unwrap();
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
fn ranges_strides_and_buffers_change_places_only() {
    for influences in [2, 4] {
        with_envelope(Shape { influences, ..SMALL }, ranges_strides_and_buffers);
    }
}

fn ranges_strides_and_buffers(envelope: Envelope<'_>) {
    let maps = palette(&envelope, &random_pose(&envelope, &mut Rng(5), 0.3));
    let v = envelope.vertex_len();
    let whole = skin(envelope, &maps);
    // Interleaved in A: position, a gap, normal; tangents in B. Two jobs, as a job system would.
    let (mut a, mut b) = (vec![-7.0; 1 + 8 * v], vec![-7.0; 4 * v]);
    for vertices in [0..3, 3..v] {
        SkinJob {
            envelope,
            palette: &maps,
            vertices: vertices.clone(),
            positions: attribute(Buffer::A, 1, 8),
            normals: attribute(Buffer::A, 5, 8),
            tangents: attribute(Buffer::B, 0, 4),
            out_a: &mut a[8 * vertices.start..][..1 + 8 * vertices.len()],
            out_b: &mut b[4 * vertices.start..4 * vertices.end],
        }
        .run()
        .unwrap();
    }
    assert_eq!(a[0], -7.0);
    for vertex in 0..v {
        let a = &a[1 + 8 * vertex..][..8];
        assert_eq!(a[..3], whole[3 * vertex..][..3]);
        assert_eq!(a[3], -7.0);
        assert_eq!(a[4..7], whole[3 * (v + vertex)..][..3]);
    }
    assert_eq!(b, whole[6 * v..]);

    let mut positions = vec![[0.0; 3]; v];
    envelope.skin_positions(&maps, &mut positions).unwrap();
    assert_eq!(positions.as_flattened(), &whole[..3 * v]);
}

#[test]
fn no_vertex_and_one_vertex() {
    with_envelope(Shape { vertices: 0, ..SMALL }, |envelope| {
        let maps = palette(&envelope, &vec![IDENTITY; envelope.joint_len()]);
        envelope.skin_positions(&maps, &mut []).unwrap();
        assert_eq!(envelope.bounds(&maps), Ok(None));
    });
    let one = Shape { vertices: 1, joints: 1, proxies: 1, influences: 1, tangents: false };
    with_envelope(one, |envelope| {
        let maps = palette(&envelope, &[IDENTITY]);
        let mut out = [[0.0; 3]];
        envelope.skin_positions(&maps, &mut out).unwrap();
        assert_eq!(Some(out[0]), envelope.rest_position(0));
    });
}

#[test]
fn bounds_hold_every_vertex() {
    let shape = Shape { vertices: 60, joints: 6, proxies: 5, influences: 4, tangents: true };
    with_envelope(shape, |envelope| {
        let mut rng = Rng(23);
        for _ in (0..300).step_by(apart(100)) {
            let maps = palette(&envelope, &random_pose(&envelope, &mut rng, 2.0));
            let mut out = vec![[0.0; 3]; envelope.vertex_len()];
            envelope.skin_positions(&maps, &mut out).unwrap();
            let bounds = envelope.bounds(&maps).unwrap().unwrap();
            assert!(out.iter().all(|&x| bounds.contains(x)));
            // The check can fail.
            let top = bounds.max.map(|x| x + 1e-3);
            assert!(!bounds.contains(top) && !bounds.contains([f32::NAN; 3]));
        }
        // Tight where the map is the identity: the mesh's own box, up to the slack.
        let bounds = envelope.bounds(&vec![IDENTITY; envelope.palette_len()]).unwrap().unwrap();
        let x = (0..envelope.vertex_len()).map(|v| envelope.rest_position(v).unwrap()[0]);
        let max = x.fold(f32::MIN, f32::max);
        assert!(bounds.max[0] >= max && bounds.max[0] < max + 1e-4);
    });
}

#[test]
fn degenerate_maps_give_finite_results() {
    with_envelope(SMALL, |envelope| {
        let v = envelope.vertex_len();
        let zero = vec![[[0.0; 4]; 3]; envelope.palette_len()];
        let out = skin(envelope, &zero);
        assert_eq!(out[..3 * v], vec![0.0; 3 * v]);
        assert_eq!(out[3 * v..], rest(envelope)[3 * v..]);
        for scale in [1e-30, 1e-12, 1e12, 1e25] {
            let scaled = IDENTITY.map(|row| row.map(|x| x * scale));
            let out = skin(envelope, &vec![scaled; envelope.palette_len()]);
            assert!(out.iter().all(|x| x.is_finite()), "{scale}");
        }
        // Flat, mirrored, zero and half-turned poses.
        let flat = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0; 4]];
        let mirrored = [[-1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
        let half = [[-1.0, 0.0, 0.0, 0.0], [0.0, -1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
        for joint in 0..envelope.joint_len() {
            for map in [flat, mirrored, half, [[0.0; 4]; 3]] {
                let mut pose = vec![IDENTITY; envelope.joint_len()];
                pose[joint] = map;
                let out = skin(envelope, &palette(&envelope, &pose));
                assert!(out.iter().all(|x| x.is_finite()));
            }
        }
    });
}

#[test]
fn local_transforms_give_the_rest_pose_back() {
    with_envelope(SMALL, |envelope| {
        let j = envelope.joint_len();
        let mut local =
            vec![
                LocalTransform { rotation: [0.0, 0.0, 0.0, 3.0], translation: [1.0, 0.0, 0.0] };
                j
            ];
        local[envelope.root()].translation = [0.0; 3];
        let mut pose = vec![[[f32::NAN; 4]; 3]; j];
        model_space_pose(&envelope, &local, &mut pose).unwrap();
        assert_eq!(pose, vec![IDENTITY; j]);

        let mut refused = |edit: &dyn Fn(&mut LocalTransform)| {
            let mut local = local.clone();
            edit(&mut local[2]);
            let error = model_space_pose(&envelope, &local, &mut pose).unwrap_err();
            assert_eq!(pose, vec![IDENTITY; j]);
            error
        };
        let zero = EvalError::ZeroRotation { joint: 2 };
        assert_eq!(refused(&|local| local.rotation = [0.0; 4]), zero);
        assert_eq!(refused(&|local| local.rotation = [1e30; 4]), zero);
        let not_finite = EvalError::NonFinite { joint: 2 };
        assert_eq!(refused(&|local| local.rotation[3] = f32::NAN), not_finite);
        assert_eq!(refused(&|local| local.translation[0] = f32::INFINITY), not_finite);
        assert!(model_space_pose(&envelope, &local[1..], &mut pose).is_err());
    });
}

#[test]
fn a_workspace_on_the_stack_serves() {
    const LEN: usize = workspace_len(4, 3, 0);
    with_envelope(SMALL, |envelope| {
        assert_eq!(envelope.workspace_len(), LEN);
        let pose = vec![IDENTITY; envelope.joint_len()];
        let mut out = vec![IDENTITY; envelope.palette_len()];
        envelope.palette(&pose, &mut Workspace::<LEN>::new(), &mut out).unwrap();
    });
}

#[test]
fn base_and_correction_share_a_workspace() {
    // The greater of 12 J + 3 J + 9 P and of 12 J and the scratch.
    assert_eq!(workspace_len(4, 3, 0), 87);
    assert_eq!(workspace_len(4, 3, 39), 87);
    assert_eq!(workspace_len(4, 3, 40), 88);
    for predictor in Predictor::ALL {
        with_predictor(predictor, SMALL, |envelope| {
            let scratch = if predictor.corrects() { 56 } else { 0 };
            assert_eq!(envelope.scratch_len(), scratch);
            assert_eq!(envelope.workspace_len(), workspace_len(4, 3, scratch));
            // What it holds before does not matter.
            let pose = random_pose(&envelope, &mut Rng(9), 0.2);
            let palettes = [0.0, f32::NAN, -3.0].map(|content| {
                let mut workspace = vec![content; envelope.workspace_len()];
                let mut out = vec![[[content; 4]; 3]; envelope.palette_len()];
                envelope.palette(&pose, &mut workspace, &mut out).unwrap();
                out
            });
            assert!(palettes[0] == palettes[1] && palettes[1] == palettes[2]);
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
