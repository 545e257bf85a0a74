//! Closed forms, an f64 reference of the palette, and output layouts.
#![allow(clippy::unwrap_used, reason = "a test's helpers fail as the test does")]

mod common;

use common::{
    IDENTITY, Rng, SMALL, Shape, apart, bits, call_error, confident_palette, job, max_difference,
    output, palette, random_pose, rest, run, skinned, with_envelope, with_predictor, with_skin,
};
use sinew_runtime::envelope::{Predictor, scratch_len};
use sinew_runtime::skin::cells;
use sinew_runtime::{
    Argument, CallError, CallErrorKind, Envelope, LocalTransform, Matrix3x4, Skin, SkinJob,
    Workspace, model_space_pose,
};

#[test]
fn rest_pose_gives_rest_mesh() {
    with_skin(SMALL, |envelope, skin| {
        let palette = palette(&envelope, &vec![IDENTITY; envelope.joint_len()]);
        // Dyadic coefficients make the sums exact.
        assert_eq!(palette, vec![IDENTITY; envelope.palette_len()]);
        let (skinned, rest) = (skinned(skin, &palette), rest(skin));
        let positions = 3 * skin.vertex_len();
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
        with_skin(Shape { influences, ..SMALL }, |envelope, skin| {
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
fn ranges_strides_and_buffers_change_places_only() {
    for influences in [2, 4] {
        with_skin(Shape { influences, ..SMALL }, ranges_strides_and_buffers);
    }
}

fn ranges_strides_and_buffers(envelope: Envelope<'_>, skin: Skin<'_>) {
    let palette = palette(&envelope, &random_pose(&envelope, &mut Rng(5), 0.3));
    let v = skin.vertex_len();
    let whole = skinned(skin, &palette);
    // Interleaved in one buffer: a gap, position, a gap, normal; tangents in another. Two jobs, as a
    // job system would.
    let (mut a, mut b) = (vec![-7.0; 1 + 8 * v], vec![-7.0; 4 * v]);
    for vertices in [0..3, 3..v] {
        let a = cells(&mut a[8 * vertices.start..][..1 + 8 * vertices.len()]);
        SkinJob {
            positions: output(&a[1..], 8),
            normals: output(&a[5..], 8),
            tangents: output(cells(&mut b[4 * vertices.start..4 * vertices.end]), 4),
            vertices,
            ..job(skin, &palette)
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
    skin.skin_positions(&palette, &mut positions).unwrap();
    assert_eq!(positions.as_flattened(), &whole[..3 * v]);
}

#[test]
fn a_whole_vertex_stands_in_one_buffer_and_the_later_attribute_wins() {
    with_skin(SMALL, |envelope, skin| {
        let palette = palette(&envelope, &random_pose(&envelope, &mut Rng(5), 0.3));
        let v = skin.vertex_len();
        let whole = skinned(skin, &palette);
        let of = |at: usize, len: usize| &whole[at..][..len];
        let mut out = vec![-7.0; 12 * v];
        let vertex = cells(&mut out);
        let interleaved = SkinJob {
            positions: output(vertex, 12),
            normals: output(&vertex[4..], 12),
            tangents: output(&vertex[8..], 12),
            ..job(skin, &palette)
        };
        interleaved.run().unwrap();
        for (i, vertex) in out.chunks(12).enumerate() {
            let (normal, tangent) = (of(3 * (v + i), 3), of(6 * v + 4 * i, 4));
            let expected = [of(3 * i, 3), &[-7.0], normal, &[-7.0], tangent].concat();
            assert_eq!(vertex, expected);
        }
        // Positions at 0, normals at 2, tangents at 4: of each the later ones' floats are lost.
        let mut out = vec![-7.0; 8 * v];
        let vertex = cells(&mut out);
        let overlapping = SkinJob {
            positions: output(vertex, 8),
            normals: output(&vertex[2..], 8),
            tangents: output(&vertex[4..], 8),
            ..job(skin, &palette)
        };
        overlapping.run().unwrap();
        for (i, vertex) in out.chunks(8).enumerate() {
            let expected = [of(3 * i, 2), of(3 * (v + i), 2), of(6 * v + 4 * i, 4)].concat();
            assert_eq!(vertex, expected);
        }
    });
}

#[test]
fn each_attribute_alone_has_the_same_bits() {
    with_skin(SMALL, |envelope, skin| {
        let palette = palette(&envelope, &random_pose(&envelope, &mut Rng(5), 0.3));
        let v = skin.vertex_len();
        let whole = bits(&skinned(skin, &palette));
        for (start, len) in [(0, 3), (3 * v, 3), (6 * v, 4)] {
            let mut out = vec![f32::NAN; len * v];
            let mut alone = job(skin, &palette);
            let own = output(cells(&mut out), len);
            match start / v {
                0 => alone.positions = own,
                3 => alone.normals = own,
                _ => alone.tangents = own,
            }
            alone.run().unwrap();
            assert_eq!(bits(&out), whole[start..start + len * v]);
        }
    });
}

#[test]
fn no_vertex_and_one_vertex() {
    with_skin(Shape { vertices: 0, ..SMALL }, |envelope, skin| {
        let palette = palette(&envelope, &vec![IDENTITY; envelope.joint_len()]);
        skin.skin_positions(&palette, &mut []).unwrap();
        assert_eq!(skin.bounds(&palette, 0.0), Ok(None));
        assert_eq!(skin.bounds(&palette, 1.0), Ok(None));
        assert!(skinned(skin, &palette).is_empty());
    });
    let one = Shape { vertices: 1, joints: 1, proxies: 1, influences: 1, tangents: false };
    with_skin(one, |envelope, skin| {
        let palette = palette(&envelope, &[IDENTITY]);
        let mut out = [[0.0; 3]];
        skin.skin_positions(&palette, &mut out).unwrap();
        assert_eq!(Some(out[0]), skin.rest_position(0));
    });
}

#[test]
fn degenerate_transforms_give_finite_results() {
    with_skin(SMALL, |envelope, skin| {
        let v = skin.vertex_len();
        let zero = vec![[[0.0; 4]; 3]; envelope.palette_len()];
        let out = skinned(skin, &zero);
        assert_eq!(out[..3 * v], vec![0.0; 3 * v]);
        assert_eq!(out[3 * v..], rest(skin)[3 * v..]);
        for scale in [1e-30, 1e-12, 1e12, 1e25] {
            let scaled = IDENTITY.map(|row| row.map(|x| x * scale));
            let out = skinned(skin, &vec![scaled; envelope.palette_len()]);
            assert!(out.iter().all(|x| x.is_finite()), "{scale}");
        }
        // Flat, mirrored, zero and half-turned poses.
        let flat = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0; 4]];
        let mirrored = [[-1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
        let half = [[-1.0, 0.0, 0.0, 0.0], [0.0, -1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
        for joint in 0..envelope.joint_len() {
            for transform in [flat, mirrored, half, [[0.0; 4]; 3]] {
                let mut pose = vec![IDENTITY; envelope.joint_len()];
                pose[joint] = transform;
                let out = skinned(skin, &palette(&envelope, &pose));
                assert!(out.iter().all(|x| x.is_finite()));
            }
        }
    });
}

#[test]
fn a_batch_has_the_bits_of_its_poses_one_by_one() {
    for predictor in Predictor::ALL {
        with_predictor(predictor, SMALL, |envelope| {
            let mut rng = Rng(17);
            let turns = [0.0, 0.05, 0.2, 1.0, 8.0];
            let poses = turns.map(|turn| random_pose(&envelope, &mut rng, turn));
            let alone = poses.each_ref().map(|pose| confident_palette(&envelope, pose));
            let expected = alone.each_ref().map(|(palette, _)| palette.as_slice()).concat();
            let mut out = vec![[[f32::NAN; 4]; 3]; expected.len()];
            let mut confidences = [f32::NAN; 5];
            let mut scratch = vec![f32::NAN; envelope.scratch_len()];
            let poses = poses.concat();
            envelope.palettes(&poses, &mut scratch, &mut out, &mut confidences).unwrap();
            let flat = |palettes: &[Matrix3x4]| bits(palettes.as_flattened().as_flattened());
            assert_eq!(flat(&out), flat(&expected));
            assert_eq!(bits(&confidences), bits(&alone.each_ref().map(|(_, found)| *found)));
            // The poses tell each other apart.
            let first = envelope.palette_len();
            assert_ne!(out[..first], out[first..2 * first]);
            assert_eq!(envelope.palettes(&[], &mut scratch, &mut [], &mut []), Ok(()));
        });
    }
}

#[test]
fn a_remap_gives_the_bits_of_the_vertices_that_it_names() {
    for influences in [2, 4] {
        with_skin(Shape { influences, ..SMALL }, |envelope, skin| {
            let palette = palette(&envelope, &random_pose(&envelope, &mut Rng(5), 0.3));
            // Twice, backwards, not at all, and more vertices than the mesh has.
            let remap = [6, 0, 0, 5, 4, 6, 1, 1, 3, 0, 6];
            let remapped =
                SkinJob { vertices: 0..remap.len(), remap: Some(&remap), ..job(skin, &palette) };
            let (found, n) = (run(&remapped), remap.len());
            let (whole, v) = (skinned(skin, &palette), skin.vertex_len());
            for (i, vertex) in remap.into_iter().map(|vertex| vertex as usize).enumerate() {
                for (len, of_found, of_whole) in [(3, 0, 0), (3, 3 * n, 3 * v), (4, 6 * n, 6 * v)] {
                    let found = &found[of_found + len * i..][..len];
                    let expected = &whole[of_whole + len * vertex..][..len];
                    assert_eq!(bits(found), bits(expected), "{vertex}");
                }
                // Alone, by a range of the mesh.
                let alone = run(&SkinJob { vertices: vertex..vertex + 1, ..job(skin, &palette) });
                assert_eq!(bits(&alone[..3]), bits(&found[3 * i..][..3]));
                assert_eq!(bits(&alone[3..6]), bits(&found[3 * (n + i)..][..3]));
            }
            // A range is one of the remap.
            let part = run(&SkinJob { vertices: 3..5, ..remapped.clone() });
            assert_eq!(part[..6], found[9..15]);
            // Positions alone, which have a loop of their own.
            let mut positions = vec![f32::NAN; 3 * n];
            let out = output(cells(&mut positions), 3);
            SkinJob { positions: out, ..remapped }.run().unwrap();
            assert_eq!(bits(&positions), bits(&found[..3 * n]));
        });
    }
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
        let error = |kind| CallError { index: 2, ..call_error(kind, Argument::Local) };
        let zero = error(CallErrorKind::ZeroRotation);
        assert_eq!(refused(&|local| local.rotation = [0.0; 4]), zero);
        assert_eq!(refused(&|local| local.rotation = [1e30; 4]), zero);
        let not_finite = error(CallErrorKind::NonFinite);
        assert_eq!(refused(&|local| local.rotation[3] = f32::NAN), not_finite);
        assert_eq!(refused(&|local| local.translation[0] = f32::INFINITY), not_finite);
        assert!(model_space_pose(&envelope, &local[1..], &mut pose).is_err());
    });
}

#[test]
fn a_workspace_on_the_stack_serves() {
    const LEN: usize = scratch_len(4, 3, 0);
    with_envelope(SMALL, |envelope| {
        assert_eq!(envelope.scratch_len(), LEN);
        let pose = vec![IDENTITY; envelope.joint_len()];
        let mut out = vec![IDENTITY; envelope.palette_len()];
        envelope.palette(&pose, &mut Workspace::<LEN>::new(), &mut out).unwrap();
    });
}

#[test]
fn base_and_correction_share_scratch() {
    // The greater of 12 J + 3 J + 9 P and of 12 J and the scratch.
    assert_eq!(scratch_len(4, 3, 0), 87);
    assert_eq!(scratch_len(4, 3, 39), 87);
    assert_eq!(scratch_len(4, 3, 40), 88);
    for predictor in Predictor::ALL {
        with_predictor(predictor, SMALL, |envelope| {
            let correction = if predictor.corrects() { 56 } else { 0 };
            assert_eq!(envelope.correction_len(), correction);
            assert_eq!(envelope.scratch_len(), scratch_len(4, 3, correction));
            // What it holds before does not matter.
            let pose = random_pose(&envelope, &mut Rng(9), 0.2);
            let palettes = [0.0, f32::NAN, -3.0].map(|content| {
                let mut scratch = vec![content; envelope.scratch_len()];
                let mut out = vec![[[content; 4]; 3]; envelope.palette_len()];
                envelope.palette(&pose, &mut scratch, &mut out).unwrap();
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
